//! A sample of each format, held against all that recognise one: each is told by its own alone.

use crate::fit::Shape;
use crate::io::coefficients::{self, SeriesFormat, WriteOptions};
use crate::io::meshes::{self, MeshFormat};
use crate::io::{points, spectra};
use crate::mesh::shapes;
use crate::sh::Coefficients;

/// What a file is taken for.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Kind {
    Mesh(MeshFormat),
    Series(SeriesFormat),
    Points,
    Spectrum,
}

/// Asks everybody.
fn told(bytes: &[u8]) -> Vec<Kind> {
    let length = bytes.len() as u64;
    let mesh = meshes::recognise(bytes, length).map(Kind::Mesh);
    let series = coefficients::recognise_content(bytes, length).map(Kind::Series);
    let points = points::recognise(bytes).then_some(Kind::Points);
    let spectrum = spectra::recognise(bytes).then_some(Kind::Spectrum);
    [mesh, series, points, spectrum].into_iter().flatten().collect()
}

/// A file of each format that is written, as it is written.
fn written() -> Vec<(Kind, Vec<u8>)> {
    let cube = shapes::cube();
    let mesh = |format| (Kind::Mesh(format), meshes::encode(&cube, format).expect("written"));
    let mut c = Coefficients::zeros(3);
    c.set(0, 0, 1.0, 0.0);
    let shape = Shape::new(c);
    let options = WriteOptions::default();
    let series = |format| {
        let bytes = coefficients::encode(&shape, format, &options).expect("fits every format");
        (Kind::Series(format), bytes)
    };
    let written = SeriesFormat::ALL.into_iter().filter(|f| f.is_written()).map(series);
    MeshFormat::writable().into_iter().map(mesh).chain(written).collect()
}

/// Texts, as other programs write them.
fn texts() -> Vec<(Kind, String)> {
    use MeshFormat::{Gltf, Obj, Off, Ply, Stl};
    let cube = "-1 -1 -1\n1 -1 -1\n1 1 -1\n-1 1 -1\n-1 -1 1\n1 -1 1\n1 1 1\n-1 1 1\n";
    let faces = "4 3 2 1 0\n4 4 5 6 7\n4 0 1 5 4\n4 1 2 6 5\n4 2 3 7 6\n4 3 0 4 7\n";
    let text = |kind, text: &str| (kind, text.to_owned());
    vec![
        (Kind::Mesh(Off), format!("OFF\n8 6 12\n{cube}{faces}")),
        (Kind::Mesh(Off), format!("OFF8 6 12\n{cube}{faces}")),
        // Rows that would be degrees and orders.
        (Kind::Mesh(Off), format!("off\n4 1 0\n0 0 0\n1 0 0\n1 1 0\n1 -1 0\n{faces}")),
        text(Kind::Mesh(Obj), "# 0 0 0\nv 0 0 0\nv 1 0 0\nv 1 1 0\nf 1 2 3\n"),
        text(Kind::Mesh(Ply), "ply\nformat ascii 1.0\nend_header\n0 0 1\n1 0 1\n1 1 1\n1 -1 1\n"),
        text(Kind::Mesh(Stl), "solid 0 0 0\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\n"),
        text(Kind::Mesh(Gltf), "{\n \"asset\": {\"version\": \"2.0\"}}"),
        text(Kind::Mesh(Gltf), "glTF\u{2}\0\0\0"),
        text(Kind::Series(SeriesFormat::Text), "0 0 1\n1 0 1\n1 1 1 1\n2 0 1\n"),
        text(Kind::Series(SeriesFormat::Text), "1738.0, 4.9\n0,0,1,0\n1,0,1,0\n1,1,0,0\n"),
        text(Kind::Series(SeriesFormat::Dov), "0 0 1\n1 0 1\n1 1 1\n1 -1 1\n"),
        text(Kind::Series(SeriesFormat::SpharmPdm), "{ 4,{0, 0, 0},\n{1, 2, 3}, {4, 5, 6}}"),
        text(Kind::Series(SeriesFormat::Icgem), "max_degree 1\nend_of_head ==\ngfc 0 0 1 0\n"),
        text(Kind::Points, "1 2 3\n4 5 6\n"),
        text(
            Kind::Points,
            "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\n\
             property float z\nend_header\n0 0 1\n",
        ),
        text(Kind::Points, cube),
        text(Kind::Points, "# a grid\n0 0 1\n1 0 1\n2 0 1\n0 1 1\n1 1 1\n"),
        text(Kind::Points, "x,y,z,weight\n0,0,1,1\n1,0,1,1\n1,1,1,1\n"),
        text(Kind::Spectrum, "degree,power_m2\n0,1.5\n1,0.25\n2,1e-3\n"),
    ]
}

#[test]
fn each_file_is_told_by_its_own_format_alone() {
    for (kind, bytes) in written() {
        assert_eq!(told(&bytes), [kind]);
    }
    for (kind, text) in texts() {
        // However lines end; a mark of UTF-8 stands before texts only.
        for ends in ["\n", "\r\n"] {
            let text = text.replace('\n', ends);
            assert_eq!(told(text.as_bytes()), [kind], "{text}");
            if !text.starts_with("glTF") {
                let marked = format!("\u{feff}{text}");
                assert_eq!(told(marked.as_bytes()), [kind], "{text}");
            }
        }
        if let Kind::Mesh(_) | Kind::Points = kind {
            let text = text.replace('\n', "\r");
            assert_eq!(told(text.as_bytes()), [kind], "{text}");
        }
    }
}

#[test]
fn what_is_none_is_told_by_nobody() {
    for bytes in [&b""[..], b"hello\n", b"\x89PNG\r\n\x1a\n", b"\x1f\x8b\x08\0", &[0; 40]] {
        assert_eq!(told(bytes), [], "{bytes:?}");
    }
    #[cfg(feature = "images")]
    {
        use crate::io::images::Exr;
        let pixels = [crate::math::Rgb::grey(0.5); 6];
        let picture = Exr::new(3, 2).with_colour("", &pixels).and_then(|exr| exr.to_bytes());
        assert_eq!(told(&picture.expect("written")), []);
    }
}
