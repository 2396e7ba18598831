//! Bodies that are hard for an intersector in different ways; all have a certified positive radius.

use glam::DVec3;

use harmolux::Result;
use harmolux::sh::{Coefficients, Grid, analysis, gaussian, power_law, range};

/// A named body.
#[derive(Debug, Clone, PartialEq)]
pub struct CheckShape {
    /// What it is.
    pub name: &'static str,
    /// The series of its radius, about 1.
    pub coefficients: Coefficients,
}

/// Makes the bodies: spheres (one hidden in degree 16), random spectra of degrees 4, 16 and 64, a
/// thin spike, a deep dent, and a disc.
///
/// # Errors
/// None that the fixed degrees could cause.
pub fn check_shapes() -> Result<Vec<CheckShape>> {
    let shape = |name, coefficients| CheckShape { name, coefficients };
    Ok(vec![
        shape("sphere", sphere(0)),
        shape("sphere", sphere(16)),
        shape("random", random(4, 2.0)?),
        shape("random", random(16, 2.5)?),
        shape("random", random(64, 3.0)?),
        shape("spike", bump(64, 0.6, 0.06)?),
        shape("dent", bump(48, -0.9, 0.2)?),
        shape("disc", disc(40)?),
    ])
}

fn sphere(lmax: usize) -> Coefficients {
    let mut f = Coefficients::zeros(lmax);
    f.set(0, 0, 1.0, 0.0);
    f
}

/// Returns a random body whose smallest radius is about 0.4.
fn random(lmax: usize, exponent: f64) -> Result<Coefficients> {
    let mut f = gaussian(&power_law(1.0, exponent, 1, lmax)?, lmax as u64)?;
    let (lowest, _) = range(&f)?;
    f = f.scaled(0.6 / lowest.abs());
    f.set(0, 0, 1.0, 0.0);
    Ok(f)
}

/// Returns the unit sphere with a Gaussian bump of a height and an angular width, radians, about a
/// direction that is no axis of anything.
fn bump(lmax: usize, height: f64, width: f64) -> Result<Coefficients> {
    let middle = DVec3::new(0.3, -0.5, 0.7).normalize();
    sampled(lmax, |w| 1.0 + height * (-0.5 * (w.angle_between(middle) / width).powi(2)).exp())
}

/// Returns an oblate spheroid ten times as wide as thick, about a direction that is no axis of
/// anything.
fn disc(lmax: usize) -> Result<Coefficients> {
    let axis = DVec3::new(0.6, 0.2, -0.4).normalize();
    sampled(lmax, |w| {
        let along = w.dot(axis);
        (1.0 - along * along + 100.0 * along * along).sqrt().recip()
    })
}

/// Projects a radius onto degree `lmax`, on a grid four times finer.
fn sampled(lmax: usize, radius: impl Fn(DVec3) -> f64) -> Result<Coefficients> {
    let grid = Grid::gauss_legendre(4 * lmax, 8 * lmax);
    let radii: Vec<f64> = (0..grid.len()).map(|i| radius(grid.direction(i))).collect();
    analysis(&radii, &grid, lmax)
}

#[cfg(test)]
mod tests {
    use super::*;
    use harmolux::sh::Bounds;

    #[test]
    fn bodies_are_what_they_are_named() {
        for CheckShape { name, coefficients } in check_shapes().expect("fixed degrees") {
            let bounds = Bounds::of(&coefficients).expect("a low degree");
            let (flat, lmax) = (bounds.min / bounds.max, coefficients.lmax());
            let expected = match name {
                "sphere" => 0.999..=1.0,
                "random" => 0.05..=0.5,
                "spike" => 0.55..=0.67,
                "dent" => 0.04..=0.11,
                _ => 0.02..=0.1,
            };
            assert!(expected.contains(&flat), "{name} of degree {lmax}: {bounds:?}");
        }
    }
}
