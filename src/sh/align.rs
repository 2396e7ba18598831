//! Alignment of a shape to its principal axes of inertia: longest along x, shortest along z.
//!
//! The axes leave four proper rotations (two of three signs are free). Of these the one is taken
//! that makes the sum of the third moments int (x^3 + y^3 + z^3) dV about the centroid largest: the
//! long tails point to the positive sides. Where that does not tell, the smallest turn is taken.

use glam::{DMat3, DQuat, DVec3};

use super::shape::{Solid, exact_grid};
use super::synthesis;
use super::{Coefficients, rotate};
use crate::Result;
use crate::math::Rotation;

/// Says how many axes the inertia fixes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum InertiaSymmetry {
    /// Three different moments: three axes.
    Asymmetric,
    /// Two equal moments: the axis of the third is brought to x or z by the smallest turn.
    Symmetric,
    /// Three equal moments: no axis, nothing is turned.
    Spherical,
}

/// Holds an aligned shape.
#[derive(Debug, Clone, PartialEq)]
pub struct Alignment {
    /// The turned series.
    pub coefficients: Coefficients,
    /// The rotation that was applied, about the expansion centre.
    pub rotation: Rotation,
    /// The principal moments of inertia about the centroid, unit density, ascending: about x, y, z.
    pub moments: [f64; 3],
    /// How many axes the inertia fixes.
    pub top: InertiaSymmetry,
}

/// Moments that differ by less, relative to the largest, count as equal: rounding moves axes by
/// 1e-14 over this.
const EQUAL: f64 = 1e-9;

/// Turns a shape so that its principal axes of inertia lie along x, y, z, the smallest moment (the
/// longest extent) about x.
///
/// The turn is about the expansion centre; move that to the centroid first where the shape shall
/// also be centred.
///
/// # Errors
/// As [`Solid::of`].
pub fn align(f: &Coefficients) -> Result<Alignment> {
    let solid = Solid::of(f)?;
    let principal = solid.principal_axes();
    let [small, middle, large] = principal.moments;
    let equal = |a: f64, b: f64| b - a <= EQUAL * large;
    let (top, turns) = match (equal(small, middle), equal(middle, large)) {
        (true, true) => (InertiaSymmetry::Spherical, vec![DMat3::IDENTITY]),
        (true, false) => {
            (InertiaSymmetry::Symmetric, onto(principal.axes.z_axis, DVec3::Z).to_vec())
        }
        (false, true) => {
            (InertiaSymmetry::Symmetric, onto(principal.axes.x_axis, DVec3::X).to_vec())
        }
        (false, false) => (InertiaSymmetry::Asymmetric, signs(principal.axes).to_vec()),
    };
    let turns: Vec<Rotation> =
        turns.into_iter().map(Rotation::from_matrix).collect::<Result<_>>()?;
    let rotation = preferred(f, &solid, &turns)?;
    Ok(Alignment { coefficients: rotate(f, &rotation), rotation, moments: principal.moments, top })
}

/// Lists the four proper rotations that bring the columns of `axes` onto plus or minus x, y, z.
fn signs(axes: DMat3) -> [DMat3; 4] {
    [(1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0)].map(|(x, y)| {
        DMat3::from_cols(x * axes.x_axis, y * axes.y_axis, x * y * axes.z_axis).transpose()
    })
}

/// Lists the smallest rotations that bring `axis` and its opposite onto `target`.
fn onto(axis: DVec3, target: DVec3) -> [DMat3; 2] {
    [axis, -axis].map(|from| DMat3::from_quat(DQuat::from_rotation_arc(from, target)))
}

/// Chooses the rotation of the largest third moments; among those that agree to rounding the
/// smallest.
fn preferred(f: &Coefficients, solid: &Solid, turns: &[Rotation]) -> Result<Rotation> {
    let axes: Vec<DVec3> =
        turns.iter().flat_map(|t| [0, 1, 2].map(|i| t.matrix().row(i))).collect();
    let (moments, scale) = third_moments(f, solid, &axes)?;
    let sums: Vec<f64> = moments.chunks_exact(3).map(|m| m.iter().sum()).collect();
    let best = sums.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let candidates = turns.iter().zip(&sums).filter(|(_, sum)| **sum >= best - EQUAL * scale);
    let smallest = candidates.map(|(t, _)| t).min_by(|a, b| a.angle().total_cmp(&b.angle()));
    Ok(smallest.copied().unwrap_or(Rotation::IDENTITY))
}

/// Integrates ((x - c) . e)^3 over the body for each unit vector e, exactly; also gives the
/// integral of |f|^6 / 6 to compare with.
///
/// With t = omega . e and d = c . e the integral along a radius is f^6 t^3 / 6 - 3 d f^5 t^2 / 5 +
/// 3 d^2 f^4 t / 4 - d^3 f^3 / 3.
fn third_moments(f: &Coefficients, solid: &Solid, axes: &[DVec3]) -> Result<(Vec<f64>, f64)> {
    let grid = exact_grid(6 * f.lmax() + 3);
    let radii = synthesis(f, &grid)?;
    let mut sums = vec![0.0; axes.len()];
    let mut scale = 0.0;
    for (i, &r) in radii.iter().enumerate() {
        let (w, cube) = (grid.direction(i), grid.solid_angle(i) * r.powi(3));
        scale += cube * r.powi(3) / 6.0;
        for (sum, axis) in sums.iter_mut().zip(axes) {
            let (x, d) = (r * w.dot(*axis), solid.centroid.dot(*axis));
            *sum += cube * (x * x * x / 6.0 - 0.6 * d * x * x + 0.75 * d * d * x - d * d * d / 3.0);
        }
    }
    Ok((sums, scale))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::EulerAngles;
    use crate::sh::{Grid, analysis};

    fn expanded(radius: impl Fn(DVec3) -> f64) -> Coefficients {
        let grid = Grid::gauss_legendre(64, 128);
        let values: Vec<f64> = (0..grid.len()).map(|i| radius(grid.direction(i))).collect();
        analysis(&values, &grid, 16).expect("fine enough")
    }

    fn ellipsoid(axes: DVec3) -> Coefficients {
        expanded(|w| (w / axes).length().recip())
    }

    /// A body without any symmetry.
    fn lump() -> Coefficients {
        let mut c = Coefficients::zeros(6);
        c.set(0, 0, 1.0, 0.0);
        for l in 1..=6 {
            for m in 0..=l {
                let k = 0.25 / (l * l) as f64;
                c.set(l, m, k * ((3 * l + m) as f64).sin(), k * ((l + 5 * m) as f64).cos());
            }
        }
        c
    }

    fn turns() -> Vec<Rotation> {
        [(0.0, 0.0, 0.0), (0.3, 1.1, -2.0), (-3.0, 2.9, 0.1), (2.0, 1.5, 1.0), (0.0, 3.1, 0.0)]
            .map(|(alpha, beta, gamma)| {
                Rotation::from_euler(EulerAngles { alpha, beta, gamma }).expect("finite")
            })
            .to_vec()
    }

    fn largest_difference(a: &Coefficients, b: &Coefficients) -> f64 {
        let pairs = a.cosines().iter().zip(b.cosines()).chain(a.sines().iter().zip(b.sines()));
        pairs.fold(0.0, |worst, (x, y)| worst.max((x - y).abs()))
    }

    #[test]
    fn sphere_is_left_as_it_is() {
        let mut ball = Coefficients::zeros(3);
        ball.set(0, 0, 2.0, 0.0);
        let aligned = align(&ball).expect("valid");
        assert_eq!(
            (aligned.top, aligned.rotation),
            (InertiaSymmetry::Spherical, Rotation::IDENTITY)
        );
        assert_eq!(aligned.coefficients, ball);
    }

    #[test]
    fn any_turn_of_a_lump_aligns_to_the_same_shape() {
        let first = align(&lump()).expect("valid");
        assert_eq!(first.top, InertiaSymmetry::Asymmetric);
        for turn in turns() {
            let again = align(&rotate(&lump(), &turn)).expect("valid");
            // Axes are good to 1e-15 over the relative differences of the moments, some percent
            // here.
            let error = largest_difference(&again.coefficients, &first.coefficients);
            assert!(error <= 1e-12, "{error:e}");
        }
        let solid = Solid::of(&first.coefficients).expect("valid");
        let [x, y, z] = [0, 1, 2].map(|i| solid.inertia.col(i)[i]);
        assert!(x < y && y < z);
        assert!(solid.inertia.x_axis.y.abs() + solid.inertia.x_axis.z.abs() <= 1e-13);
        let (thirds, _) = third_moments(&first.coefficients, &solid, &DVec3::AXES).expect("valid");
        // Of the four signs the sum is largest: no two moments are together negative.
        assert!(thirds[0] + thirds[1] >= 0.0 && thirds[1] + thirds[2] >= 0.0);
        assert!(thirds[0] + thirds[2] >= 0.0);
    }

    #[test]
    fn aligned_shapes_stay_where_they_are() {
        let aligned = align(&lump()).expect("valid").coefficients;
        assert!(align(&aligned).expect("valid").rotation.angle() <= 1e-12);
        // An ellipsoid has no third moments: the smallest turn is none.
        let aligned = align(&ellipsoid(DVec3::new(1.2, 1.0, 0.9))).expect("valid");
        assert!(aligned.rotation.angle() <= 1e-12);
    }

    #[test]
    fn bodies_of_revolution_come_to_x_or_z() {
        for (axes, column) in [(DVec3::new(1.2, 1.0, 1.0), 0), (DVec3::new(1.0, 1.0, 0.9), 2)] {
            let body = ellipsoid(axes);
            for turn in turns() {
                let aligned = align(&rotate(&body, &turn)).expect("valid");
                assert_eq!(aligned.top, InertiaSymmetry::Symmetric);
                let error = largest_difference(&aligned.coefficients, &body);
                assert!(error <= 1e-12, "axis {column}: {error:e}");
            }
        }
    }
}
