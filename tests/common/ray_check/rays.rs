//! The rays of a check: by far the most ordinary, one in a hundred made to graze.
//!
//! Every ray depends on the seed and its number only. What kind it is follows from the number
//! modulo 100.

use std::f64::consts::TAU;

use glam::DVec3;

use super::borders::on_border;
use harmolux::math::sampling::uniform_sphere;
use harmolux::math::{Frame, Randomness, Ray, Stream};
use harmolux::surface::{Hit, ShSurface, Surface};

/// How a ray was made.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum RayKind {
    /// Between two random points of a sphere of 1.5 largest radii, and on.
    Chord,
    /// From up to ten radii off towards a point of the ball of the largest radius.
    Outside,
    /// From inside the body.
    Inside,
    /// From its centre.
    Centre,
    /// Left a hit of the surface, as it was reported or refined.
    Left,
    /// Parallel to an axis: two components of its direction are zero.
    Axis,
    /// On a line through the centre.
    Radial,
    /// From a million radii off.
    Far,
    /// With `t_min` and `t_max` anywhere, or next to the hit.
    Cut,
    /// On a border of cube faces or of cells, or a few roundings off.
    Border,
    /// Tangent to the surface, off by 1e-3 to 1e-9 of the largest radius.
    Grazing,
}

impl RayKind {
    fn of(index: u64) -> Self {
        match index % 100 {
            0..49 => Self::Chord,
            49..55 => Self::Border,
            55..63 => Self::Outside,
            63..71 => Self::Inside,
            71..74 => Self::Centre,
            74..84 => Self::Left,
            84..88 => Self::Axis,
            88..91 => Self::Radial,
            91..94 => Self::Far,
            94..99 => Self::Cut,
            _ => Self::Grazing,
        }
    }

    /// Names the kind in a report.
    pub(super) const fn name(self) -> &'static str {
        match self {
            Self::Chord => "chord",
            Self::Outside => "outside",
            Self::Inside => "inside",
            Self::Centre => "central",
            Self::Left => "leaving",
            Self::Axis => "axis-parallel",
            Self::Radial => "radial",
            Self::Far => "far",
            Self::Cut => "cut",
            Self::Border => "border",
            Self::Grazing => "grazing",
        }
    }
}

/// A ray, and what is known of it.
#[derive(Debug, Clone, Copy)]
pub(super) struct TestRay {
    pub(super) ray: Ray,
    pub(super) kind: RayKind,
    /// Whether it started by `Hit::leave`, and is therefore certainly on its side of the surface.
    pub(super) left: bool,
}

/// Makes rays about a body.
pub(super) struct Rays<'a> {
    pub(super) examined: &'a dyn Surface,
    pub(super) oracle: &'a ShSurface,
    pub(super) seed: u64,
}

impl Rays<'_> {
    /// Makes ray number `index`.
    pub(super) fn make(&self, index: u64) -> TestRay {
        let kind = RayKind::of(index);
        let mut draw = Draw(Stream::new(Randomness::Pseudorandom, self.seed, index));
        if kind == RayKind::Left
            && let Some(ray) = self.leaving(&mut draw)
        {
            return TestRay { ray, kind, left: true };
        }
        let ray = match kind {
            RayKind::Outside => self.outside(&mut draw),
            RayKind::Inside => Ray::new(self.inner_point(&mut draw), draw.direction()),
            RayKind::Centre => Ray::new(DVec3::ZERO, draw.direction()),
            RayKind::Axis => self.axis_parallel(&mut draw),
            RayKind::Radial => self.radial(&mut draw),
            RayKind::Far => self.far(&mut draw),
            RayKind::Cut => self.cut(&mut draw),
            RayKind::Border => on_border(&mut draw, self.radius()),
            RayKind::Grazing => self.grazing(&mut draw),
            RayKind::Chord | RayKind::Left => self.chord(&mut draw),
        };
        TestRay { ray, kind, left: false }
    }

    fn radius(&self) -> f64 {
        self.oracle.body().bounds().max
    }

    fn chord(&self, draw: &mut Draw) -> Ray {
        let radius = 1.5 * self.radius();
        towards(radius * draw.direction(), radius * draw.direction())
    }

    /// Returns a point of the ball of the largest radius.
    fn ball_point(&self, draw: &mut Draw) -> DVec3 {
        self.radius() * draw.unit().cbrt() * draw.direction()
    }

    /// Returns a point of the body.
    fn inner_point(&self, draw: &mut Draw) -> DVec3 {
        let direction = draw.direction();
        draw.unit() * self.oracle.body().series().value(direction) * direction
    }

    fn outside(&self, draw: &mut Draw) -> Ray {
        let distance = self.radius() * draw.log_uniform(1.0, 10.0);
        towards(distance * draw.direction(), self.ball_point(draw))
    }

    /// Leaves a hit, to either side, every other time within a degree or far less of the tangent
    /// plane.
    fn leaving(&self, draw: &mut Draw) -> Option<Ray> {
        let hit = self.examined.hit(&self.chord(draw))?;
        let hit = if draw.coin() { self.examined.refine(&hit) } else { hit };
        let direction = if draw.coin() {
            draw.direction()
        } else {
            let (lift, sign) = (draw.log_uniform(1e-9, 1e-2), if draw.coin() { 1.0 } else { -1.0 });
            (draw.tangent(hit.normal) + sign * lift * hit.normal).normalize()
        };
        Some(hit.leave(direction))
    }

    fn axis_parallel(&self, draw: &mut Draw) -> Ray {
        let mut direction = DVec3::ZERO;
        direction[(3.0 * draw.unit()) as usize % 3] = if draw.coin() { 1.0 } else { -1.0 };
        let point = self.ball_point(draw);
        // On a plane or an axis of the body every other time.
        let point = if draw.coin() { point } else { (point / self.radius()).round() * point };
        Ray::new(point - 3.0 * self.radius() * direction, direction)
    }

    fn radial(&self, draw: &mut Draw) -> Ray {
        let out = draw.direction();
        let from = 3.0 * draw.unit() * self.radius() * out;
        Ray::new(from, if draw.coin() { out } else { -out })
    }

    fn far(&self, draw: &mut Draw) -> Ray {
        towards(1e6 * self.radius() * draw.direction(), self.ball_point(draw))
    }

    fn cut(&self, draw: &mut Draw) -> Ray {
        let ray = self.chord(draw);
        let near = if draw.coin() { self.oracle.hit(&ray) } else { None };
        let Some(Hit { distance, .. }) = near else {
            let [t_min, t_max] =
                [draw.unit(), draw.unit()].map(|u| (4.0 * u - 1.0) * self.radius());
            return Ray { t_min, t_max, ..ray };
        };
        let off = draw.log_uniform(1e-14, 1e-2);
        let place = distance * (1.0 + if draw.coin() { off } else { -off });
        if draw.coin() { ray.up_to(place) } else { Ray { t_min: place, ..ray } }
    }

    fn grazing(&self, draw: &mut Draw) -> Ray {
        let place = self.oracle.at(draw.direction());
        let along = draw.tangent(place.normal);
        let off = self.radius() * draw.log_uniform(1e-9, 1e-3);
        let off = if draw.coin() { off } else { -off };
        Ray::new(place.point + off * place.normal - 3.0 * self.radius() * along, along)
    }
}

/// Makes the half line from one point through another.
fn towards(from: DVec3, to: DVec3) -> Ray {
    let direction = (to - from).try_normalize().unwrap_or(DVec3::X);
    Ray::new(from, direction)
}

/// Random numbers and directions.
pub(super) struct Draw(pub(super) Stream);

impl Draw {
    pub(super) fn unit(&mut self) -> f64 {
        self.0.next_4d()[0]
    }

    /// Draws a whole number below `count`.
    pub(super) fn below(&mut self, count: usize) -> usize {
        (self.unit() * count as f64) as usize
    }

    pub(super) fn coin(&mut self) -> bool {
        self.unit() < 0.5
    }

    pub(super) fn direction(&mut self) -> DVec3 {
        uniform_sphere(self.0.next_2d())
    }

    fn log_uniform(&mut self, low: f64, high: f64) -> f64 {
        low * (high / low).powf(self.unit())
    }

    /// Returns a unit vector across a normal.
    fn tangent(&mut self, normal: DVec3) -> DVec3 {
        let (sin, cos) = (TAU * self.unit()).sin_cos();
        Frame::about(normal).to_world(DVec3::new(cos, sin, 0.0))
    }
}
