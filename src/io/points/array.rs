//! Points as an array of NumPy: a row for each, its first three columns x, y and z.

use std::path::Path;

use super::{MOST_COLUMNS, PointOptions, no_weights, point};
use crate::Result;
use crate::error::InputError;
use crate::io::npy::{self, Array};
use crate::mesh::Points;

/// Whether a file that begins so is an array of real rows.
pub(super) fn is_rows(head: &[u8]) -> bool {
    npy::is_table(head)
}

/// Reads the rows of an array, numbers of either width and order of axes and bytes.
pub(super) fn parse(path: &Path, bytes: &[u8], options: PointOptions) -> Result<Points> {
    let array = Array::parse(path, bytes)?;
    let rows = match *array.shape.as_slice() {
        [rows, 3..=MOST_COLUMNS] if !array.complex => rows,
        _ => {
            let message = format!("an array of shape {:?} holds no points", array.shape);
            let help = "points are rows of at least three real numbers: x, y, z; transpose an \
                        array whose columns they are";
            return Err(InputError::new(path, message).help(help).into());
        }
    };
    if options.weights && array.shape[1] < 4 {
        return Err(no_weights(path, "the rows have three columns").into());
    }
    let mut points = Points::default();
    for row in 0..rows {
        let number = |column: usize| array.at(&[row, column]).0;
        let weight = if options.weights { number(3) } else { 1.0 };
        let (position, weight) = point([0, 1, 2].map(number), weight).map_err(|(i, message)| {
            InputError::new(path, format!("row {row}, column {i} (from 0): {message}"))
        })?;
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
        super::super::parse(Path::new("p.npy"), bytes, PointOptions { weights })
    }

    #[test]
    fn rows_of_any_width_and_order_are_read() {
        let five = npy::rows(5, &[1.0, 2.0, 3.0, 0.5, 9.0, 4.0, 5.0, 6.0, 0.0, 9.0]);
        let expected = [DVec3::new(1.0, 2.0, 3.0), DVec3::new(4.0, 5.0, 6.0)];
        assert!(is_rows(&five));
        let plain = read(&five, false).expect("points");
        assert_eq!(
            (plain.positions.as_slice(), plain.weights.as_slice()),
            (&expected[..], &[1.0; 2][..])
        );
        assert_eq!(read(&five, true).expect("points").weights, [0.5, 0.0]);
        let mut columns = npy::write(&[2, 3], 1, &[]);
        let at = columns.windows(5).position(|w| w == b"False").expect("said");
        columns.splice(at..at + 5, *b"True ");
        columns.extend([1.0_f64, 4.0, 2.0, 5.0, 3.0, 6.0].iter().flat_map(|x| x.to_le_bytes()));
        assert_eq!(read(&columns, false).expect("points").positions, expected);
    }

    #[test]
    fn arrays_of_other_things_are_refused() {
        for (shape, parts, numbers, expected) in [
            (vec![3], 1, vec![1.0; 3], "an array of shape [3] holds no points"),
            (vec![2, 2], 1, vec![1.0; 4], "an array of shape [2, 2]"),
            (vec![3, 40], 1, vec![1.0; 120], "transpose"),
            (vec![1, 3], 2, vec![1.0; 6], "an array of shape [1, 3]"),
            (vec![1, 3], 1, vec![1.0, f64::NAN, 0.0], "row 0, column 1 (from 0): `NaN`"),
            (vec![0, 3], 1, vec![], "no point stands in this file"),
        ] {
            let bytes = npy::write(&shape, parts, &numbers);
            let message = read(&bytes, false).expect_err("refused").to_string();
            assert!(message.contains(expected), "{message}");
        }
        let bytes = npy::rows(3, &[1.0, 2.0, 3.0]);
        assert!(read(&bytes, true).expect_err("refused").to_string().contains("no weights here"));
    }
}
