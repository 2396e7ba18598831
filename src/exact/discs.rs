//! The Sobolev problem with finite discs: the same source between two coaxial Lambert discs, black
//! outside.
//!
//! Unlike infinite planes a renderer can hold these exactly. In units of the gap the illuminances
//! solve the one-dimensional equation
//!
//! E1(r) = h1/(h1^2 + r^2)^1.5 + rho2 int_0^R K(r, r') E2(r') dr',  K = 2 r' (1 + r^2 + r'^2)/{[1 +
//! (r-r')^2][1 + (r+r')^2]}^1.5,
//!
//! and its exchange of indices, here by Nystroem's method on Gauss panels with E2 eliminated.

use std::f64::consts::PI;

use nalgebra::{DMatrix, DVector};

use super::ranges::{accept, not_negative};
use super::sobolev::{Plane, SobolevProblem, direct};
use crate::math::quadrature::Rule;
use crate::{Error, Result};

/// Holds the solved problem of two coaxial discs of one radius; any distance can be asked for
/// afterwards.
///
/// ```
/// use harmolux::exact::{Plane, SobolevProblem};
///
/// let discs = SobolevProblem::default().discs(2.0)?;
/// assert!((discs.illuminance(Plane::Lower, 1.0)? - 0.6356962829).abs() <= 1e-10);
/// # Ok::<(), harmolux::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct SobolevDiscs {
    problem: SobolevProblem,
    /// Radii and weights of the nodes, in gaps.
    nodes: Vec<(f64, f64)>,
    /// The illuminances of both discs at the nodes, in intensity/gap^2.
    values: [DVector<f64>; 2],
}

/// The largest radius, in gaps: 600 nodes a disc, a fraction of a second. Beyond it infinite planes
/// are near enough.
const LARGEST: f64 = 50.0;
/// The least height of the source over a disc, in gaps: each halving of it takes one more panel.
const NEAREST: f64 = 1e-6;

impl SobolevProblem {
    /// Solves the problem for coaxial discs of `radius` metres (above 0, at most 50 gaps) in place
    /// of infinite planes.
    ///
    /// Relative error about 1e-11. Both reflectances may be 1: light escapes between the discs. The
    /// source stands at least a millionth of the gap from either disc.
    ///
    /// # Errors
    /// [`Error::Parameter`] for a field or `radius` outside its range.
    pub fn discs(&self, radius: f64) -> Result<SobolevDiscs> {
        self.check()?;
        let in_gaps = radius / self.gap;
        let range = "above 0 and at most 50 gaps; take infinite planes for more";
        accept(in_gaps > 0.0 && in_gaps <= LARGEST, "the radius, in gaps,", in_gaps, range)?;
        let h = self.heights();
        let near = h[0].min(h[1]);
        let range = "at least a millionth of the gap for finite discs";
        accept(near >= NEAREST, "the height over the nearer disc, in gaps,", near, range)?;
        let nodes = nodes(in_gaps, near);
        let values = solve(self.reflectance, h, &nodes)?;
        Ok(SobolevDiscs { problem: *self, nodes, values })
    }
}

impl SobolevDiscs {
    /// Returns the illuminance, lx, in the plane of a disc at distance `r` (metres, at least 0)
    /// from the axis.
    ///
    /// Past the radius this is the illuminance of the black surroundings.
    ///
    /// # Errors
    /// [`Error::Parameter`] for a negative or infinite `r`.
    pub fn illuminance(&self, plane: Plane, r: f64) -> Result<f64> {
        Ok(self.problem.direct(plane, r)? + self.indirect(plane, r)?)
    }

    /// Returns the part of the illuminance, lx, that was reflected at least once.
    ///
    /// # Errors
    /// As [`SobolevDiscs::illuminance`].
    pub fn indirect(&self, plane: Plane, r: f64) -> Result<f64> {
        not_negative("the distance r", r)?;
        let (r, other) = (r / self.problem.gap, plane.other().index());
        let terms = self.nodes.iter().zip(self.values[other].iter());
        let integral: f64 = terms.map(|(&(s, w), e)| w * kernel(r, s) * e).sum();
        Ok(self.problem.unit() * self.problem.reflectance[other] * integral)
    }

    /// Returns the flux, lm, that leaves through the open rim or is absorbed beyond it: the
    /// source's less what the discs absorb.
    pub fn escaped_flux(&self) -> f64 {
        let absorbed = |i: usize| -> f64 {
            let terms = self.nodes.iter().zip(self.values[i].iter());
            let flux: f64 = terms.map(|(&(r, w), e)| 2.0 * PI * r * w * e).sum();
            (1.0 - self.problem.reflectance[i]) * flux
        };
        self.problem.intensity * (4.0 * PI - absorbed(0) - absorbed(1))
    }
}

/// Places 12 Gauss nodes a panel on [0, radius]: panels grow from the source height to one gap, the
/// scale of the kernel.
fn nodes(radius: f64, height: f64) -> Vec<(f64, f64)> {
    let base = Rule::gauss_legendre(12);
    let mut nodes = Vec::new();
    let (mut from, mut width) = (0.0, height);
    while from < radius {
        let to = radius.min(from + width);
        nodes.extend(base.clone().on(from, to).iter());
        (from, width) = (to, to.min(1.0));
    }
    nodes
}

/// Returns the kernel of the one-dimensional equation, ring to point.
fn kernel(r: f64, s: f64) -> f64 {
    let product = (1.0 + (r - s).powi(2)) * (1.0 + (r + s).powi(2));
    2.0 * s * (1.0 + r * r + s * s) / (product * product.sqrt())
}

/// Solves for both discs at the nodes: (1 - rho1 rho2 K^2) E1 = d1 + rho2 K d2, then E2 = d2 + rho1
/// K E1.
fn solve(rho: [f64; 2], h: [f64; 2], nodes: &[(f64, f64)]) -> Result<[DVector<f64>; 2]> {
    let n = nodes.len();
    let k = DMatrix::from_fn(n, n, |i, j| nodes[j].1 * kernel(nodes[i].0, nodes[j].0));
    let source = h.map(|h| DVector::from_iterator(n, nodes.iter().map(|&(r, _)| direct(h, r))));
    let system = DMatrix::identity(n, n) - rho[0] * rho[1] * (&k * &k);
    let right = &source[0] + rho[1] * (&k * &source[1]);
    let lower = system.lu().solve(&right).ok_or_else(|| {
        Error::Numeric("the discs' equation is singular; lower a reflectance or the radius".into())
    })?;
    let upper = &source[1] + rho[0] * (&k * &lower);
    Ok([lower, upper])
}

#[cfg(test)]
mod tests {
    use super::*;

    const A: SobolevProblem =
        SobolevProblem { reflectance: [0.5; 2], source_height: 0.5, gap: 1.0, intensity: 1.0 };

    #[test]
    fn senseless_radii_are_refused() {
        for radius in [0.0, -1.0, f64::NAN, 51.0] {
            assert!(matches!(A.discs(radius), Err(Error::Parameter(_))), "{radius}");
        }
        let touching = SobolevProblem { source_height: 1e-9, ..A };
        assert!(matches!(touching.discs(1.0), Err(Error::Parameter(_))));
        let discs = A.discs(1.0).unwrap();
        assert!(discs.illuminance(Plane::Lower, -0.1).is_err());
        assert!(discs.indirect(Plane::Lower, f64::NAN).is_err());
    }

    #[test]
    fn small_discs_leave_direct_light_and_almost_all_flux() {
        let discs = A.discs(1e-4).unwrap();
        assert!((discs.illuminance(Plane::Lower, 0.0).unwrap() - 4.0).abs() <= 1e-7);
        assert!((discs.escaped_flux() - 4.0 * PI).abs() <= 1e-6);
    }

    #[test]
    fn discs_are_the_printed_table() {
        for (radius, values) in [
            (2.0, &[4.514_082_781_9, 1.845_390_249_1, 0.635_696_282_9, 0.136_426_001_1][..]),
            (
                3.0,
                &[
                    4.524_964_198_8,
                    1.856_992_018_1,
                    0.649_712_723_5,
                    0.160_409_720_6,
                    0.050_262_011_6,
                ],
            ),
            (
                5.0,
                &[
                    4.527_821_817_2,
                    1.859_975_153_0,
                    0.653_104_733_4,
                    0.166_052_397_1,
                    0.061_442_126_4,
                ],
            ),
            (
                10.0,
                &[
                    4.528_121_985_8,
                    1.860_282_481_3,
                    0.653_434_536_7,
                    0.166_489_196_3,
                    0.062_140_203_6,
                ],
            ),
            (
                20.0,
                &[
                    4.528_129_353_4,
                    1.860_289_908_0,
                    0.653_442_143_4,
                    0.166_497_572_0,
                    0.062_150_055_6,
                ],
            ),
        ] {
            let discs = A.discs(radius).unwrap();
            for (&r, value) in [0.0, 0.5, 1.0, 2.0, 3.0].iter().zip(values) {
                // Printed to ten decimals.
                let error = (discs.illuminance(Plane::Lower, r).unwrap() - value).abs();
                assert!(error <= 6e-11, "R = {radius}, r = {r}: {error:e}");
            }
        }
    }

    #[test]
    fn large_discs_approach_infinite_planes() {
        let b = SobolevProblem { reflectance: [0.8, 0.3], source_height: 0.9, ..A };
        let discs = b.discs(20.0).unwrap();
        for plane in [Plane::Lower, Plane::Upper] {
            for r in [0.0, 0.3, 1.0, 3.0] {
                let difference =
                    b.illuminance(plane, r).unwrap() - discs.illuminance(plane, r).unwrap();
                // What the planes add beyond R = 20 is below 2e-7 in case A, and a little more
                // here.
                assert!((0.0..=1e-6).contains(&difference), "{plane:?}, r = {r}: {difference:e}");
            }
        }
    }

    #[test]
    fn one_reflection_from_a_disc_is_the_closed_integral() {
        // A single grey disc: E1(0) = 1/h1^2 + rho2 int 2 s/(1+s^2)^2 h2/(h2^2+s^2)^1.5 ds.
        let p = SobolevProblem { reflectance: [0.0, 0.6], source_height: 0.2, ..A };
        let (radius, h2) = (1.5, 0.8);
        let integrand = |s: f64| 2.0 * s / (1.0 + s * s).powi(2) * direct(h2, s);
        let expected = 25.0 + 0.6 * Rule::gauss_legendre(60).on(0.0, radius).integrate(integrand);
        let found = p.discs(radius).unwrap().illuminance(Plane::Lower, 0.0).unwrap();
        assert!((found - expected).abs() <= 1e-11);
    }

    #[test]
    fn what_escapes_arrives_on_the_black_surroundings() {
        let rule = Rule::gauss_legendre(40).on(0.0, 1.0);
        for (reflectance, source_height) in [([1.0, 1.0], 0.5), ([0.9, 0.2], 0.3)] {
            let discs = SobolevProblem { reflectance, source_height, ..A }.discs(2.0).unwrap();
            // r = 2/t turns the endless rings into a finite interval; E falls as t^3 or faster.
            let ring = |t: f64| {
                let both = [Plane::Lower, Plane::Upper];
                let e: f64 = both.map(|p| discs.illuminance(p, 2.0 / t).unwrap()).iter().sum();
                2.0 * PI * e * 4.0 / t.powi(3)
            };
            let arrived = rule.integrate(ring);
            assert!((arrived / discs.escaped_flux() - 1.0).abs() <= 1e-10, "{arrived}");
        }
    }
}
