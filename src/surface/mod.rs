//! Surfaces that rays meet: the trait, the hit, and who implements them.

mod area_map;
mod bvh;
mod certified;
mod facets;
mod instance;
mod mesh_surface;
mod patches;
pub mod primitives;
mod radial;
mod sh_surface;
mod shell;
mod step_bisection;

pub use bvh::Bvh;
pub use facets::{Division, Facet};
pub use instance::Instance;
pub use mesh_surface::MeshSurface;
pub use radial::{Chord, Gap, RadialBody};
pub use sh_surface::{Intersector, ShSurface};
pub use step_bisection::StepBisection;

use glam::{DVec2, DVec3};

use crate::math::{Aabb, Ray};

/// Answers rays. One method is required beside the bounds; a surface overrides the others where it
/// knows a faster way.
///
/// Surfaces are opaque and two-sided; the normal of a hit points to the outer side whichever side
/// the ray came from.
pub trait Surface: Send + Sync {
    /// Returns the first hit between `ray.t_min` and `ray.t_max`, or `None`.
    fn hit(&self, ray: &Ray) -> Option<Hit>;

    /// Bounds the surface; infinite where the surface is.
    fn bounds(&self) -> Aabb;

    /// Whether anything is hit between `ray.t_min` and `ray.t_max`.
    fn blocked(&self, ray: &Ray) -> bool {
        self.hit(ray).is_some()
    }

    /// Answers a batch: `hits[i]` for `rays[i]`, both of the same length.
    fn hits(&self, rays: &[Ray], hits: &mut [Option<Hit>]) {
        for (ray, hit) in rays.iter().zip(hits) {
            *hit = self.hit(ray);
        }
    }

    /// Marks in `blocked`, which has the length of `rays`, the rays that hit anything; a ray that
    /// is marked already is passed over.
    fn mark_blocked(&self, rays: &[Ray], blocked: &mut [bool]) {
        for (ray, blocked) in rays.iter().zip(blocked) {
            *blocked = *blocked || self.blocked(ray);
        }
    }

    /// Returns it as a flat rectangle, if it is one: of those a ray can be put to many at a time.
    fn as_rectangle(&self) -> Option<&primitives::Rectangle> {
        None
    }

    /// Sharpens a hit of this surface before it is shaded: exact point, exact normals. Shadow rays
    /// never need it.
    fn refine(&self, hit: &Hit) -> Hit {
        *hit
    }
}

/// Describes where a ray met a surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Hit {
    /// The distance along the ray, metres.
    pub distance: f64,
    /// The point, metres.
    pub point: DVec3,
    /// The unit normal of the surface that was traced, on its outer side.
    pub normal: DVec3,
    /// The unit normal used for shading; equal to `normal` except on smooth meshes.
    pub shading_normal: DVec3,
    /// An absolute bound, metres, on the distance between `point` and the surface.
    pub error: f64,
    /// Which part of the surface was hit: the face of a box or mesh, 0 where there is only one.
    pub part: u32,
}

/// How far the end of a ray of length 1 may be off by rounding, in every surface's arithmetic
/// (docs/how/architecture.md).
pub(crate) const END_ROUNDING: f64 = 32.0 * f64::EPSILON;

impl Hit {
    /// Returns the point from which a ray towards `direction` leaves.
    ///
    /// The point is moved along the geometric normal, to the side `direction` looks to, by four
    /// times the error bound: far enough to be certainly on that side, and as near as the hit is
    /// exact. This and [`Hit::segment`] are the one self-intersection policy of the crate. Nowhere
    /// else is there an epsilon.
    pub fn departure(&self, direction: DVec3) -> DVec3 {
        self.lifted(direction, 0.0)
    }

    /// Makes the ray that leaves the hit along the unit vector `direction`.
    pub fn leave(&self, direction: DVec3) -> Ray {
        Ray::new(self.departure(direction), direction)
    }

    /// Makes the ray between two hits, `direction` being the unit vector from this one to `other`;
    /// both ends depart from their surfaces. `None` when nothing is left between them.
    ///
    /// A ray knows where it starts, but its end is rounded with its length: the end stays off its
    /// surface by that, too.
    pub fn segment(&self, other: &Self, direction: DVec3) -> Option<Ray> {
        let rounding = END_ROUNDING * other.point.distance(self.point);
        Ray::between(self.departure(direction), other.lifted(-direction, rounding))
    }

    /// Moves the point off the surface, to the side `direction` looks to, by four error bounds and
    /// `more` metres.
    fn lifted(&self, direction: DVec3, more: f64) -> DVec3 {
        // A hit can be exact: on a plane, at the origin. Its rays leave all the same.
        let error = self.error.max(1e-300);
        // A direction in the tangent plane itself (-0.0 included) counts as outward.
        let side = if self.normal.dot(direction) < 0.0 { -1.0 } else { 1.0 };
        self.point + ((4.0 * error + more) * side) * self.normal
    }
}

/// Samples a surface by area; implemented where that is possible (everything bounded).
pub trait SampleArea: Surface {
    /// Returns the area, m2.
    fn area(&self) -> f64;

    /// Samples a point; its density is [`SampleArea::density`] there.
    fn sample_area(&self, u: DVec2) -> AreaPoint;

    /// Returns the density, 1/m2, with which [`SampleArea::sample_area`] picks the point of a
    /// (refined) hit.
    fn density(&self, hit: &Hit) -> f64;

    /// Describes what is seen of the surface from its outer side, where that is simple.
    fn outline(&self) -> Outline {
        Outline::Other
    }

    /// Divides the surface into facets that are nearly flat.
    fn facets(&self, division: &Division) -> Vec<Facet>;

    /// Maps the unit square onto the surface so that equal parts of it become equal areas: evenly
    /// spread points of the square are evenly spread on the surface, and a plain mean over them is
    /// a mean over the area.
    ///
    /// Where the density of [`SampleArea::sample_area`] is the same everywhere, that is such a map
    /// already.
    fn uniform(&self, u: DVec2) -> Hit {
        self.sample_area(u).hit
    }
}

/// Describes what is seen of a surface from its outer side.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Outline {
    /// Polygons: [`SampleArea::facets`] of any number has their outlines exactly.
    Polygons,
    /// A disc, seen from the side of its unit normal.
    Disc {
        /// The centre, metres.
        centre: DVec3,
        /// The unit normal.
        normal: DVec3,
        /// The radius, metres.
        radius: f64,
    },
    /// A sphere, seen from outside.
    Sphere {
        /// The centre, metres.
        centre: DVec3,
        /// The radius, metres.
        radius: f64,
    },
    /// Anything else.
    Other,
}

/// Describes a point sampled on a surface, as the hit that a ray from outside would have made (its
/// distance is 0), with its density.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AreaPoint {
    /// The point, normals and error bound.
    pub hit: Hit,
    /// The density, 1/m2, with which this point was picked.
    pub density: f64,
}
