//! Reconstruction filters: how samples about the middle of a pixel weigh in it. All are positive
//! and integrate to 1 over the film, so they can be sampled in proportion to themselves; every
//! sample then counts alike, and noise stays independent between pixels.

use std::f64::consts::TAU;

use glam::DVec2;

use crate::math::choice::choice;

/// Names a reconstruction filter.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Filter {
    /// The pixel's own square, evenly: sharp, with steps at edges.
    Box,
    /// A tent two pixels wide each way.
    #[default]
    Tent,
    /// A round Gaussian of standard deviation 1/2 pixel, cut off at 3/2 pixels: soft.
    Gaussian,
}

/// The standard deviation and the reach of the Gaussian, pixels.
const DEVIATION: f64 = 0.5;
const REACH: f64 = 1.5;

choice!(Filter, "filter":
    Box = "box" "",
    Tent = "tent" "",
    Gaussian = "gaussian" "",
);

impl Filter {
    /// Returns how far it reaches from the middle of a pixel, pixels, each way.
    pub const fn radius(self) -> f64 {
        match self {
            Self::Box => 0.5,
            Self::Tent => 1.0,
            Self::Gaussian => REACH,
        }
    }

    /// Picks an offset from the middle of a pixel, pixels, in proportion to the filter, from two
    /// uniform numbers.
    pub fn sample(self, [u, v]: [f64; 2]) -> DVec2 {
        match self {
            Self::Box => DVec2::new(u - 0.5, v - 0.5),
            Self::Tent => DVec2::new(tent(u), tent(v)),
            Self::Gaussian => {
                let radius = DEVIATION * (-2.0 * (-u * kept()).ln_1p()).sqrt();
                radius * DVec2::from_angle(TAU * v)
            }
        }
    }

    /// Returns the filter, 1/pixel^2, at an offset from the middle of a pixel: the density of
    /// [`Filter::sample`].
    pub fn density(self, offset: DVec2) -> f64 {
        match self {
            // Half open, so that each point of the film belongs to one pixel.
            Self::Box => {
                let inside = |x: f64| (-0.5..0.5).contains(&x);
                if inside(offset.x) && inside(offset.y) { 1.0 } else { 0.0 }
            }
            Self::Tent => {
                let side = |x: f64| (1.0 - x.abs()).max(0.0);
                side(offset.x) * side(offset.y)
            }
            Self::Gaussian if offset.length() > REACH => 0.0,
            Self::Gaussian => {
                let exponent = -0.5 * offset.length_squared() / DEVIATION.powi(2);
                exponent.exp() / (TAU * DEVIATION.powi(2) * kept())
            }
        }
    }
}

/// Returns the part of the whole Gaussian that is within its reach.
fn kept() -> f64 {
    -(-0.5 * (REACH / DEVIATION).powi(2)).exp_m1()
}

/// Maps a uniform number to a position under a tent of width 2 about 0.
fn tent(u: f64) -> f64 {
    if u < 0.5 { (2.0 * u).sqrt() - 1.0 } else { 1.0 - (2.0 - 2.0 * u).sqrt() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ends_of_the_unit_square_stay_within_the_radius() {
        let ends = [0.0, 0.5, 1.0 - f64::EPSILON, 1.0];
        for filter in Filter::ALL {
            for u in ends.into_iter().flat_map(|u| ends.map(|v| [u, v])) {
                let reach = filter.sample(u).abs().max_element();
                assert!(reach <= filter.radius() * (1.0 + 1e-12), "{filter:?} {u:?}: {reach}");
            }
        }
        assert_eq!(Filter::Tent.sample([0.0, 0.5]), DVec2::new(-1.0, 0.0));
    }

    #[test]
    fn filters_are_positive_integrate_to_one_and_splats_to_the_same_everywhere() {
        // The middle rule on 600 x 600 cells; the cut of the Gaussian, 1 % of its top, is a circle
        // through the cells.
        let n = 600;
        for (filter, tolerance) in
            [(Filter::Box, 1e-12), (Filter::Tent, 1e-5), (Filter::Gaussian, 1e-4)]
        {
            let side = 2.0 * filter.radius() / f64::from(n);
            let at = |i: i32| (f64::from(i) + 0.5) * side - filter.radius();
            let cells = (0..n).flat_map(|i| (0..n).map(move |j| DVec2::new(at(i), at(j))));
            let values: Vec<f64> = cells.map(|offset| filter.density(offset)).collect();
            assert!(values.iter().all(|v| *v >= 0.0));
            let total = values.iter().sum::<f64>() * side * side;
            assert!((total - 1.0).abs() <= tolerance, "{filter:?}: {total}");
        }
        // Box and tent divide every point of the film wholly among the pixels; the Gaussian ripples
        // by six per cent at most.
        for (filter, tolerance) in
            [(Filter::Box, 1e-12), (Filter::Tent, 1e-12), (Filter::Gaussian, 0.06)]
        {
            for point in [DVec2::new(0.1, 0.7), DVec2::new(0.5, 0.5), DVec2::new(0.0, 0.25)] {
                let pixels =
                    (-3..4).flat_map(|i| (-3..4).map(move |j| DVec2::new(i.into(), j.into())));
                let total: f64 = pixels.map(|middle| filter.density(point - middle)).sum();
                assert!((total - 1.0).abs() <= tolerance, "{filter:?} {point}: {total}");
            }
        }
    }

    #[test]
    fn samples_follow_the_density() {
        // Moments of the filter from samples on a 400 x 400 grid of the unit square, against
        // moments by the middle rule over the density.
        let n = 400;
        let steps = || (0..n).map(|i| (f64::from(i) + 0.5) / f64::from(n));
        for filter in Filter::ALL {
            let moments = |weighted: &mut dyn Iterator<Item = (DVec2, f64)>| {
                weighted.fold([0.0; 4], |m, (o, w)| {
                    let terms = [o.x * o.x, o.y * o.y, o.x * o.y, o.length_squared().powi(2)];
                    std::array::from_fn(|k| m[k] + w * terms[k])
                })
            };
            let share = 1.0 / f64::from(n * n);
            let mut sampled =
                steps().flat_map(|u| steps().map(move |v| (filter.sample([u, v]), share)));
            let (r, side) = (filter.radius(), 2.0 * filter.radius() / f64::from(n));
            let mut integrated = steps().flat_map(|x| {
                steps().map(move |y| {
                    let offset = 2.0 * r * DVec2::new(x - 0.5, y - 0.5);
                    (offset, filter.density(offset) * side * side)
                })
            });
            let (a, b) = (moments(&mut sampled), moments(&mut integrated));
            for (a, b) in a.into_iter().zip(b) {
                assert!((a - b).abs() <= 1e-3, "{filter:?}: {a} and {b}");
            }
        }
    }
}
