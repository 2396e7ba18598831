//! Solids as OBJ.

use std::fmt::Write;

/// Writes a prism over the polygon `corners` (counter-clockwise), whose caps are cut into the
/// quadrilaterals `caps` (from 0).
pub fn prism(corners: &[[f64; 2]], heights: [f64; 2], caps: &[[usize; 4]]) -> String {
    let n = corners.len();
    let mut text = String::new();
    for z in heights {
        for [x, y] in corners {
            writeln!(text, "v {x} {y} {z}").expect("a String takes all");
        }
    }
    let mut face = |corners: [usize; 4]| {
        let [a, b, c, d] = corners.map(|i| i + 1);
        writeln!(text, "f {a} {b} {c} {d}").expect("a String takes all");
    };
    for &[a, b, c, d] in caps {
        face([d, c, b, a]);
        face([a + n, b + n, c + n, d + n]);
    }
    for i in 0..n {
        let j = (i + 1) % n;
        face([i, j, j + n, i + n]);
    }
    text
}

/// A cube of side `2 a` about the origin.
pub fn cube(a: f64) -> String {
    prism(&[[-a, -a], [a, -a], [a, a], [-a, a]], [-a, a], &[[0, 1, 2, 3]])
}

/// A prism shaped like the letter U: no point sees all of it.
pub fn u_shape() -> String {
    let corners = [[0., 0.], [3., 0.], [3., 3.], [2., 3.], [2., 1.], [1., 1.], [1., 3.], [0., 3.]];
    prism(&corners, [0.0, 1.0], &[[0, 1, 4, 5], [1, 2, 3, 4], [0, 5, 6, 7]])
}
