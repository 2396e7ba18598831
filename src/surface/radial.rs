//! The body r <= f(omega) as the intersectors see it: its gap function along a ray, and the balls
//! that hold and fill it.

use glam::DVec3;

use super::shell::Shell;
use crate::Result;
use crate::math::{Ray, require_measurable};
use crate::sh::{Bounds, Coefficients, Series, least, rounding};

/// Holds a star-shaped body about the origin: the series of its radius, positive everywhere, with
/// certified bounds.
#[derive(Debug, Clone)]
pub struct RadialBody {
    series: Series,
    bounds: Bounds,
    tolerance: f64,
    shell: Shell,
}

/// Holds the gap G = |p| - f(p/|p|) at a point of a ray: positive outside the body, its absolute
/// value the radial distance to the surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Gap {
    /// G, metres.
    pub value: f64,
    /// dG/dt along the ray.
    pub slope: f64,
    /// The gradient of r - f(omega) in space, an outward normal of length >= 1.
    pub normal: DVec3,
}

/// Holds the part of a ray inside the bounding ball, and its geometry about the origin.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Chord {
    /// Where the ray enters the bounding ball, or starts inside it.
    pub start: f64,
    /// Where it leaves the ball or ends.
    pub end: f64,
    /// The distance along the ray of its point nearest to the origin (may be negative).
    pub nearest: f64,
    /// The distance of the line from the origin.
    pub offset: f64,
}

/// Radii relative to the largest that count as one: what the surface is traced to.
const RELATIVE_TOLERANCE: f64 = 1e-12;

impl Chord {
    /// Returns the smallest distance from the origin between two distances along the ray.
    pub fn lowest(&self, from: f64, to: f64) -> f64 {
        let along = self.nearest.clamp(from, to.max(from)) - self.nearest;
        (self.offset * self.offset + along * along).sqrt()
    }
}

impl RadialBody {
    /// Takes the series as the radius of a body.
    ///
    /// # Errors
    /// [`crate::Error::Geometry`] when the radius is not positive everywhere, or so nearly 0 that
    /// this cannot be told; [`crate::Error::Parameter`] for a degree too high.
    pub fn new(coefficients: &Coefficients) -> Result<Self> {
        let bounds = Bounds::of(coefficients)?;
        let is_positive = bounds.min > 0.0 && bounds.min.is_finite() && bounds.max.is_finite();
        if !is_positive {
            least(coefficients)?.require_positive(bounds.max)?;
        }
        require_measurable("the largest radius", bounds.max)?;
        let series = Series::new(coefficients)?;
        Ok(Self {
            shell: Shell::new(&series, &bounds),
            series,
            tolerance: RELATIVE_TOLERANCE * bounds.max + 4.0 * rounding(coefficients),
            bounds,
        })
    }

    /// Returns the series of the radius, metres.
    pub fn series(&self) -> &Series {
        &self.series
    }

    /// Returns the certified bounds of radius, slope and curvature.
    pub fn bounds(&self) -> &Bounds {
        &self.bounds
    }

    /// Returns the largest gap, metres, that counts as being on the surface: 1e-12 of the largest
    /// radius and the rounding of the series.
    pub fn tolerance(&self) -> f64 {
        self.tolerance
    }

    /// Evaluates the gap at distance `t` of a ray; a point at the origin counts as deep inside.
    pub fn gap(&self, ray: &Ray, t: f64) -> Gap {
        let p = ray.at(t);
        let r = p.length();
        if r < 0.5 * self.bounds.min {
            return Gap { value: -0.5 * self.bounds.min, slope: 0.0, normal: ray.direction };
        }
        let w = p / r;
        let jet = self.series.jet(w);
        let normal = w - jet.gradient / r;
        Gap { value: r - jet.value, slope: normal.dot(ray.direction), normal }
    }

    /// Evaluates the gap alone, without its slope; a point at the origin counts as deep inside.
    pub fn gap_value(&self, point: DVec3) -> f64 {
        let r = point.length();
        if r < 0.5 * self.bounds.min {
            -0.5 * self.bounds.min
        } else {
            r - self.series.value(point / r)
        }
    }

    /// Returns the shell of bounds around the surface.
    pub(super) fn shell(&self) -> &Shell {
        &self.shell
    }

    /// Clips a ray to the bounding ball; `None` when it passes by, or an end of it is not a number.
    pub fn chord(&self, ray: &Ray) -> Option<Chord> {
        let nearest = -ray.origin.dot(ray.direction);
        let offset = ray.at(nearest).length();
        let half = (self.bounds.max + offset) * (self.bounds.max - offset);
        if half.is_nan() || half < 0.0 {
            return None;
        }
        let half = half.sqrt();
        let (start, end) = (ray.t_min.max(nearest - half), ray.t_max.min(nearest + half));
        // NaN would be passed over by `max` and `min`.
        (ray.t_min <= ray.t_max && start <= end).then_some(Chord { start, end, nearest, offset })
    }

    /// Returns where the line of a chord is inside the ball that fills the body: between these two
    /// distances nothing can be hit.
    pub fn core(&self, chord: &Chord) -> Option<(f64, f64)> {
        let half = (self.bounds.min + chord.offset) * (self.bounds.min - chord.offset);
        (half > 0.0).then(|| (chord.nearest - half.sqrt(), chord.nearest + half.sqrt()))
    }
}
