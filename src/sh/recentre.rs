//! The same surface about another centre: a new series for the distance from there.
//!
//! The surface point p = f(omega) omega is seen from the centre c in the direction u = (p - c)/|p -
//! c|, and an element d omega of the old directions covers d u = f h / |p - c|^3 d omega of the new
//! ones, with h(omega) = f^2 - f c . omega + c . grad_S f. So the moments of the new radius,
//! int |p - c| Y(u) du, are integrals over the old directions: no ray is cast and no equation
//! solved. The new radius exists where h > 0 everywhere; h is a series of degree 2 lmax, so that a
//! bound on it decides this.

use std::f64::consts::PI;

use glam::DVec3;
use rayon::prelude::*;

use super::shape::{angles, require_positive};
use super::{
    Coefficients, Evaluator, GRIDDED_FROM, Grid, GridMoments, Moments, analysis, range,
    rotation_derivatives, synthesis,
};
use crate::{Error, Result};

/// Holds a shape about its new centre and how well it is described there.
#[derive(Debug, Clone, PartialEq)]
pub struct Recentred {
    /// The series of the distance from the new centre.
    pub coefficients: Coefficients,
    /// The root mean square, over the directions from the new centre, of the distance between
    /// series and surface: what truncation leaves, m.
    pub rms: f64,
    /// The largest such distance at the sampled points, m.
    pub max: f64,
    /// What the last refinement of the quadrature changed, as an RMS radius, m: how exact the
    /// coefficients themselves are.
    pub quadrature: f64,
}

/// Change between two quadratures, relative to the mean radius, at which the coefficients count as
/// settled.
const SETTLED: f64 = 1e-12;

/// Samples of the finest quadrature.
const MOST_SAMPLES: usize = 1 << 23;

/// Samples that are added up together; fixed, so that sums do not depend on the number of threads.
const SAMPLES_PER_TASK: usize = 4096;

/// Grids that are filled side by side at high degrees; fixed as well.
const GRIDS: usize = 4;

/// Expands the surface r = f(omega) about `centre`, given from the old centre in metres, up to
/// degree `lmax`.
///
/// ```
/// use glam::DVec3;
/// use harmolux::sh::{Coefficients, recentre};
///
/// let mut ball = Coefficients::zeros(0);
/// ball.set(0, 0, 1.0, 0.0);
/// let moved = recentre(&ball, DVec3::new(0.0, 0.0, 0.2), 24)?;
/// // Seen from there the top is near and the bottom far: r = -0.2 cos(theta) + ...
/// assert!((moved.coefficients.get(1, 0).0 + 0.2).abs() <= 1e-10 && moved.rms <= 1e-12);
/// # Ok::<(), harmolux::Error>(())
/// ```
///
/// # Errors
/// [`Error::Geometry`] when a radius is not positive, or the surface is not certainly star-shaped
/// about `centre`, with the direction where it fails; [`Error::Parameter`] when `centre` is not
/// finite or a degree is too high to evaluate.
pub fn recentre(f: &Coefficients, centre: DVec3, lmax: usize) -> Result<Recentred> {
    if !centre.is_finite() {
        return Err(Error::Parameter(format!("a centre must be finite, found {centre}")));
    }
    require_star_shaped(f, centre)?;
    let mut rings = 2 * (f.lmax().max(lmax) + 4);
    let mut view = View::from(f, centre, rings)?;
    let mut found = view.projected(lmax)?;
    let mut quadrature = f64::INFINITY;
    while 8 * rings * rings <= MOST_SAMPLES && quadrature > SETTLED * found.mean() {
        rings *= 2;
        view = View::from(f, centre, rings)?;
        let finer = view.projected(lmax)?;
        quadrature = (super::difference(&finer, &found).energy() / (4.0 * PI)).sqrt();
        found = finer;
    }
    let [rms, max] = view.errors(&found)?;
    Ok(Recentred { coefficients: found, rms, max, quadrature })
}

/// Makes sure that every point of the surface is seen from `centre`, and nothing of it from behind.
fn require_star_shaped(f: &Coefficients, centre: DVec3) -> Result<()> {
    let degree = 2 * f.lmax().max(1);
    let grid = Grid::minimal(degree);
    let samples = Samples::of(f, centre, &grid)?;
    let facing = &samples.facing;
    let lowest = facing.iter().enumerate().min_by(|a, b| a.1.total_cmp(b.1));
    let Some((worst, &least)) = lowest else { return Ok(()) };
    let seen = least > 0.0 && range(&analysis(facing, &grid, degree)?)?.0 > 0.0;
    if seen {
        return Ok(());
    }
    let how = if least > 0.0 { "not certainly" } else { "not" };
    Err(Error::Geometry(format!(
        "the shape is {how} star-shaped about ({}, {}, {}): from there its surface is seen edge-on \
         or from behind at {} (from the old centre); choose a centre nearer to the old one, or the \
         centroid, or lower the degree",
        centre.x,
        centre.y,
        centre.z,
        angles(grid.direction(worst))
    )))
}

/// Holds radii and h = f^2 - f c . omega + c . grad_S f at the samples of a grid.
struct Samples {
    radii: Vec<f64>,
    facing: Vec<f64>,
}

impl Samples {
    fn of(f: &Coefficients, centre: DVec3, grid: &Grid) -> Result<Self> {
        let radii = synthesis(f, grid)?;
        require_positive(&radii, grid)?;
        let [x, y, z] = rotation_derivatives(f);
        let [x, y, z] = [synthesis(&x, grid)?, synthesis(&y, grid)?, synthesis(&z, grid)?];
        let facing = radii.iter().enumerate().map(|(i, &r)| {
            let w = grid.direction(i);
            // omega x grad_S f, turned back by a quarter about omega.
            let gradient = DVec3::new(x[i], y[i], z[i]).cross(w);
            r * (r - centre.dot(w)) + centre.dot(gradient)
        });
        Ok(Self { facing: facing.collect(), radii })
    }
}

/// Holds points of the surface as seen from the new centre.
struct View {
    /// For each point its direction, distance, and the solid angle it stands for.
    points: Vec<(DVec3, f64, f64)>,
}

impl View {
    fn from(f: &Coefficients, centre: DVec3, rings: usize) -> Result<Self> {
        let grid = Grid::gauss_legendre(rings, 2 * rings);
        let samples = Samples::of(f, centre, &grid)?;
        let points = samples.radii.iter().zip(&samples.facing).enumerate().map(|(i, (&r, h))| {
            let p = r * grid.direction(i) - centre;
            let distance = p.length();
            (p / distance, distance, grid.solid_angle(i) * r * h / distance.powi(3))
        });
        Ok(Self { points: points.collect() })
    }

    /// Projects the distance onto the basis.
    fn projected(&self, lmax: usize) -> Result<Coefficients> {
        if lmax < GRIDDED_FROM {
            let empty = Moments::new(lmax)?;
            let sums = self.summed(SAMPLES_PER_TASK, &empty, Moments::add, Moments::merge);
            return Ok(sums.coefficients());
        }
        let (empty, per_grid) = (GridMoments::new(lmax), self.points.len().div_ceil(GRIDS));
        self.summed(per_grid, &empty, GridMoments::add, GridMoments::merge).coefficients()
    }

    fn summed<M: Clone + Send + Sync>(
        &self,
        per_task: usize,
        empty: &M,
        add: fn(&mut M, DVec3, f64),
        merge: fn(&mut M, &M),
    ) -> M {
        let sum = |points: &[(DVec3, f64, f64)]| {
            let mut part = empty.clone();
            for &(direction, distance, solid_angle) in points {
                add(&mut part, direction, distance * solid_angle);
            }
            part
        };
        let parts: Vec<M> = self.points.par_chunks(per_task).map(sum).collect();
        let mut total = empty.clone();
        for part in &parts {
            merge(&mut total, part);
        }
        total
    }

    /// Returns the RMS over directions and the largest of |series - distance|.
    fn errors(&self, found: &Coefficients) -> Result<[f64; 2]> {
        let series = Evaluator::new(found)?;
        let values: Vec<f64> = self.points.par_iter().map(|p| series.value(p.0)).collect();
        let (mut sum, mut worst) = (0.0, 0.0_f64);
        for (value, (_, distance, solid_angle)) in values.iter().zip(&self.points) {
            let error = (value - distance).abs();
            sum += solid_angle * error * error;
            worst = worst.max(error);
        }
        Ok([(sum / (4.0 * PI)).sqrt(), worst])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::sampling::uniform_sphere;
    use crate::sh::{Series, Solid, volume};

    fn ball() -> Coefficients {
        let mut c = Coefficients::zeros(0);
        c.set(0, 0, 1.0, 0.0);
        c
    }

    fn lump() -> Coefficients {
        let mut c = Coefficients::zeros(6);
        c.set(0, 0, 1.0, 0.0);
        for l in 1..=6 {
            for m in 0..=l {
                let k = 0.2 / (l * l) as f64;
                c.set(l, m, k * ((3 * l + m) as f64).sin(), k * ((l + 5 * m) as f64).cos());
            }
        }
        c
    }

    #[test]
    fn degenerate_centres_are_refused() {
        let nan = recentre(&ball(), DVec3::new(f64::NAN, 0.0, 0.0), 4);
        assert!(matches!(nan, Err(Error::Parameter(_))));
        for centre in [DVec3::new(0.0, 0.0, 1.0), DVec3::new(3.0, 0.0, 0.0)] {
            let error = recentre(&ball(), centre, 4).expect_err("on the surface or outside");
            assert!(error.to_string().contains("star-shaped about"), "{error}");
        }
    }

    #[test]
    fn a_shape_that_hides_part_of_itself_is_refused_with_the_direction() {
        // 1 + 0.8 P_2(cos theta): a dumb-bell along z; from high in the upper lobe the lower one is
        // hidden by the waist.
        let mut dumbbell = ball().truncated(2);
        dumbbell.set(2, 0, 0.8, 0.0);
        assert!(recentre(&dumbbell, DVec3::new(0.0, 0.0, 0.05), 8).is_ok());
        let error = recentre(&dumbbell, DVec3::new(0.0, 0.0, 1.4), 8).expect_err("hidden");
        assert!(error.to_string().contains("at theta = "), "{error}");
    }

    #[test]
    fn offset_sphere_has_its_closed_form() {
        let c = DVec3::new(0.1, -0.25, 0.2);
        let moved = recentre(&ball(), c, 48).expect("inside");
        let series = Series::new(&moved.coefficients).expect("degree 48");
        for i in 0..50 {
            let w = uniform_sphere([(f64::from(i) + 0.5) / 50.0, (f64::from(i) * 0.618).fract()]);
            let exact = -w.dot(c) + (w.dot(c).powi(2) + 1.0 - c.length_squared()).sqrt();
            assert!((series.value(w) - exact).abs() <= moved.max + 1e-13);
        }
        assert!(moved.max <= 1e-12 && moved.quadrature <= 1e-12, "{moved:?}");
    }

    #[test]
    fn the_same_centre_gives_the_same_series() {
        let same = recentre(&lump(), DVec3::ZERO, 6).expect("inside");
        let d = super::super::difference(&same.coefficients, &lump());
        assert!(d.energy() <= 1e-26 && same.rms <= 1e-13, "{}", d.energy());
    }

    #[test]
    fn volume_stays_and_centroid_moves_within_the_stated_error() {
        let (shape, c) = (lump(), DVec3::new(0.1, 0.05, -0.1));
        let before = Solid::of(&shape).expect("valid");
        let mut last = f64::INFINITY;
        for lmax in [8, 16, 32] {
            let moved = recentre(&shape, c, lmax).expect("inside");
            assert!(moved.rms < last && moved.rms <= moved.max);
            last = moved.rms;
            let after = Solid::of(&moved.coefficients).expect("valid");
            // |dV| <= 4 pi R^2 rms, |d(V centroid)| <= 4 pi R^3 rms with R = 2 above all radii.
            let allowed = 16.0 * PI * moved.rms + 1e-12;
            assert!((volume(&moved.coefficients).expect("valid") - before.volume).abs() <= allowed);
            assert!((after.centroid - (before.centroid - c)).length() <= 4.0 * allowed);
        }
        assert!(last <= 1e-6, "{last:e}");
    }
}
