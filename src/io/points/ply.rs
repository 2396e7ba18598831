//! Points of a PLY file without faces, text or binary of either byte order: x, y, z of its
//! vertices, their weight where they have one, whatever else they hold.

use std::path::Path;

use super::{PointOptions, no_weights, point};
use crate::Result;
use crate::io::ply::{Header, Rows, is_ply};
use crate::io::source::Source;
use crate::mesh::Points;

/// Whether a file that begins so is PLY with vertices and without faces or strips.
pub(super) fn is_cloud(head: &[u8]) -> bool {
    let header = || Header::read(&mut Source::of_bytes(Path::new(""), head)).ok();
    is_ply(head).then(header).flatten().is_some_and(|header| {
        let rows = |name: &str| header.element(name).is_some_and(|element| element.count > 0);
        rows("vertex") && !rows("face") && !rows("tristrips")
    })
}

/// Reads the vertices; what comes after them is not looked at.
pub(super) fn parse(source: &mut Source, options: PointOptions) -> Result<Points> {
    let header = Header::read(source)?;
    let vertex = header.element("vertex").ok_or_else(|| {
        let help = "points are vertices with x, y and z, as in `property float x`";
        source.fault("the header has no element vertex", help)
    })?;
    let coordinates = vertex.coordinates(source)?;
    let weight = vertex.scalar(&["weight", "w"]);
    if options.weights && weight.is_none() {
        return Err(no_weights(source.path(), "vertices have no property weight").into());
    }
    header.check_length(source)?;
    for element in header.elements.iter().take_while(|element| element.name != "vertex") {
        Rows::new(source, header.encoding, element).pass_over()?;
    }
    let mut rows = Rows::new(source, header.encoding, vertex);
    let (mut points, mut values) = (Points::default(), Vec::new());
    while rows.next_scalars(&mut values)? {
        let weight = weight.map_or(1.0, |place| values[place]);
        let made = point(coordinates.map(|place| values[place]), weight);
        let help = "write ordinary numbers; export again if a program wrote this";
        let (position, weight) = made.map_err(|(_, message)| rows.fault(message, help))?;
        points.positions.push(position);
        points.weights.push(weight);
    }
    Ok(points)
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;

    fn read(bytes: &[u8], weights: bool) -> Result<Points> {
        super::super::parse(Path::new("p.ply"), bytes, PointOptions { weights })
    }

    fn refusal(bytes: &[u8]) -> String {
        read(bytes, false).expect_err("refused").to_string()
    }

    const HEADER: &str = "ply\nformat ascii 1.0\ncomment a scan\nelement camera 1\n\
        property list uchar float at\nelement vertex 2\nproperty float z\nproperty uchar red\n\
        property double x\nproperty list uint8 int16 seen\nproperty float y\n\
        property float weight\nelement face 0\nproperty list uchar int vertex_indices\nend_header\n";
    const ROWS: &str = "2 0.5 0.5\n3 255 1 2 7 8 2 0.5\n\n6 0 4 0 5 0\n";

    #[test]
    fn vertices_of_text_and_of_either_order_of_bytes_are_the_points() {
        let text = format!("{HEADER}{ROWS}");
        let expected = Points {
            positions: vec![DVec3::new(1.0, 2.0, 3.0), DVec3::new(4.0, 5.0, 6.0)],
            weights: vec![0.5, 0.0],
        };
        assert!(is_cloud(text.as_bytes()));
        assert_eq!(read(text.as_bytes(), true).expect("points"), expected);
        assert_eq!(read(format!("\u{feff}{text}").as_bytes(), true).expect("points"), expected);
        assert_eq!(read(text.replace('\n', "\r").as_bytes(), true).expect("points"), expected);
        assert_eq!(read(text.replace('\n', "\r\n").as_bytes(), true).expect("points"), expected);
        for big in [false, true] {
            let mut bytes = Vec::new();
            let mut put = |mut part: Vec<u8>| {
                if big {
                    part.reverse();
                }
                bytes.extend(part);
            };
            let real = |x: f32| x.to_le_bytes().to_vec();
            [vec![2], real(0.5), real(0.5)].into_iter().for_each(&mut put);
            for [x, y, z, w] in [[1.0_f32, 2.0, 3.0, 0.5], [4.0, 5.0, 6.0, 0.0]] {
                let x = f64::from(x).to_le_bytes().to_vec();
                let row = [real(z), vec![255], x, vec![1], vec![1, 2], real(y), real(w)];
                row.into_iter().for_each(&mut put);
            }
            let format = if big { "binary_big_endian" } else { "binary_little_endian" };
            let whole = [HEADER.replace("ascii", format).as_bytes(), &bytes].concat();
            assert_eq!(read(&whole, false).expect("points"), expected);
            assert!((0..whole.len()).all(|end| read(&whole[..end], false).is_err()));
        }
    }

    #[test]
    fn numbers_of_every_type_are_read() {
        for (name, bytes, value) in [
            ("char", vec![0xfe], -2.0),
            ("uchar", vec![0xfe], 254.0),
            ("int16", vec![0xfe, 0xff], -2.0),
            ("ushort", vec![1, 2], 513.0),
            ("int", vec![0xfe, 0xff, 0xff, 0xff], -2.0),
            ("uint32", vec![0, 0, 0, 0x80], 2_147_483_648.0),
            ("float", vec![0, 0, 0x80, 0xbf], -1.0),
            ("double", vec![0, 0, 0, 0, 0, 0, 0xf0, 0x3f], 1.0),
        ] {
            let header = format!(
                "ply\nformat binary_little_endian 1.0\nelement vertex 1\nproperty {name} x\n\
                 property uchar y\nproperty uchar z\nend_header\n"
            );
            let all = [header.as_bytes(), &bytes, &[0, 0]].concat();
            assert_eq!(read(&all, false).expect("a point").positions[0].x, value, "{name}");
        }
    }

    #[test]
    fn what_is_no_cloud_is_refused() {
        let text = format!("{HEADER}{ROWS}");
        assert!(!is_cloud(text.replace("face 0", "face 1").as_bytes()));
        assert!(!is_cloud(b"plywood") && !is_cloud(b"ply\nelement vertex 1\n"));
        for (old, new, expected) in [
            ("double x", "double u", "vertices have no property x"),
            ("vertex 2", "vertices 2", "no element vertex"),
            ("float z", "quad z", "p.ply:7: `quad z` is no property"),
            ("end_header", "", "is no statement of a PLY header"),
            ("6 0 4 0 5 0", "6 0 4", "p.ply:19: a vertex with too few values"),
            ("6 0 4 0 5 0", "6 0 inf 0 5 0", "p.ply:19: `inf` is not a finite number"),
            ("5 0\n", "5 -1\n", "the weight -1 is negative"),
            ("vertex 2", "vertex 99999999999", "p.ply:6: the header announces 99999999999 rows"),
            ("vertex 2", "vertex 0", "no point stands"),
        ] {
            let message = refusal(text.replacen(old, new, 1).as_bytes());
            assert!(message.contains(expected), "{message}");
        }
        let bare = text.replace("weight", "w8");
        assert!(
            read(bare.as_bytes(), true).expect_err("refused").to_string().contains("no weights")
        );
        let endless =
            "ply\nformat binary_big_endian 1.0\nelement a 18446744073709551615\nend_header\n";
        assert!(refusal(endless.as_bytes()).contains("no element vertex"));
    }
}
