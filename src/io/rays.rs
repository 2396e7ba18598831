//! Points with directions as text, for `probe`: x y z dx dy dz, one pair a line.

use std::path::Path;

use glam::DVec3;

use crate::Result;
use crate::error::InputError;
use crate::math::unit;

/// Reads pairs of a point, metres, and a direction, which is made a unit vector. Numbers are apart
/// by spaces, tabs, commas or semicolons; `#` starts a comment, and lines without numbers are
/// passed over. `path` is for messages.
///
/// # Errors
/// [`crate::Error::Input`] with the line that does not hold six finite numbers or whose direction
/// has no length.
pub fn parse(path: &Path, text: &str) -> Result<Vec<(DVec3, DVec3)>> {
    let mut rays = Vec::new();
    for (i, line) in text.lines().enumerate() {
        let line = line.split('#').next().unwrap_or_default();
        let apart = |c: char| c.is_whitespace() || c == ',' || c == ';';
        let words: Vec<&str> = line.split(apart).filter(|word| !word.is_empty()).collect();
        if words.is_empty() {
            continue;
        }
        let fault = |message: String| {
            let help = "write x y z dx dy dz: a point in metres and a direction";
            InputError::new(path, message).at(i + 1, None).help(help)
        };
        let numbers: Vec<f64> = words
            .iter()
            .map(|word| word.parse().ok().filter(|x: &f64| x.is_finite()))
            .map(|number| {
                number.ok_or_else(|| {
                    fault(format!("`{line}` has something that is no finite number"))
                })
            })
            .collect::<std::result::Result<_, _>>()?;
        let [x, y, z, u, v, w] = numbers[..] else {
            return Err(fault(format!("six numbers expected, found {}", numbers.len())).into());
        };
        let direction = unit(DVec3::new(u, v, w))
            .ok_or_else(|| fault("the direction has length 0".to_owned()))?;
        rays.push((DVec3::new(x, y, z), direction));
    }
    Ok(rays)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_become_points_and_unit_directions() {
        let read = |text: &str| parse(Path::new("stdin"), text);
        let text = "# a comment\n1 2 3  0 0 2\n\n4,5;6\t-1 0 0 # more\n";
        let expected =
            [(DVec3::new(1.0, 2.0, 3.0), DVec3::Z), (DVec3::new(4.0, 5.0, 6.0), DVec3::NEG_X)];
        assert_eq!(read(text).expect("good"), expected);
        for (bad, words) in [
            ("1 2 3 0 0 1\n1 2 3", "stdin:2: six numbers expected, found 3"),
            ("1 2 3 0 0 x", "stdin:1: `1 2 3 0 0 x` has something that is no finite number"),
            ("1 2 nan 0 0 1", "finite"),
            ("1 2 3 0 0 0", "the direction has length 0"),
        ] {
            let error = read(bad).expect_err("bad").to_string();
            assert!(error.contains(words), "{error}");
        }
    }
}
