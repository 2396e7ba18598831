//! The patches of a scene: facets of all its surfaces, each with two sides.

use super::super::estimator::MAX_PATCHES;
use crate::math::Rgb;
use crate::scene::{Brdf, Object, Scene};
use crate::surface::{Division, Facet, Hit};
use crate::{Error, Result};

/// Holds the patches of a scene. Side 2 i of patch i is that of its normal, side 2 i + 1 the other.
pub(super) struct Patches {
    /// Where.
    pub(super) facets: Vec<Facet>,
    /// The reflectance of each, the same on both sides.
    pub(super) reflectance: Vec<Rgb>,
    /// The exitance of each, lm/m2, on the side of the normal, with that of others that shine in
    /// its place.
    pub(super) exitance: Vec<Rgb>,
    /// Whether another surface lies in the place of each and counts there, on the side of the
    /// normal and on the other.
    covered: Vec<[bool; 2]>,
}

impl Patches {
    /// Divides the surfaces of a scene into about `count` patches.
    pub(super) fn new(scene: &Scene, count: usize) -> Result<Self> {
        let lights: Vec<_> = scene.lights().iter().map(|light| light.at).collect();
        let mut patches = Self {
            facets: Vec::new(),
            reflectance: Vec::new(),
            exitance: Vec::new(),
            covered: Vec::new(),
        };
        for (number, object) in scene.objects().iter().enumerate() {
            let Some(surface) = &object.area else { return Err(infinite(object)) };
            let share = surface.area() / scene.area();
            let count = ((count as f64 * share).round() as usize).max(1);
            for facet in surface.facets(&Division { count, lights: &lights }) {
                let material = object.material(&facet.middle);
                patches.reflectance.push(reflectance(object, &material.brdf)?);
                let front = scene.vertex_at(number, facet.middle, facet.middle.normal);
                let shines = !material.exitance.is_black();
                let all = scene.emitted(&front) * std::f64::consts::PI;
                patches.exitance.push(if shines { all } else { Rgb::BLACK });
                let covers = |sign: f64| scene.counts_before(number, &facet.middle, sign);
                patches.covered.push([covers(1.0), covers(-1.0)]);
                patches.facets.push(facet);
            }
            if patches.facets.len() > MAX_PATCHES {
                return Err(Error::Parameter(format!(
                    "radiosity can hold {MAX_PATCHES} patches and object `{}` takes it beyond; \
                     give meshes fewer triangles (each is a patch), ask for fewer patches, or \
                     choose the estimator `local`",
                    object.name
                )));
            }
        }
        Ok(patches)
    }

    /// Returns the facet of a side.
    pub(super) fn facet(&self, side: usize) -> &Facet {
        &self.facets[side / 2]
    }

    /// Returns the reflectance of a side.
    pub(super) fn reflectance(&self, side: usize) -> Rgb {
        if self.is_covered(side) { Rgb::BLACK } else { self.reflectance[side / 2] }
    }

    /// Returns the exitance of a side, lm/m2.
    pub(super) fn exitance(&self, side: usize) -> Rgb {
        let shines = side.is_multiple_of(2) && !self.is_covered(side);
        if shines { self.exitance[side / 2] } else { Rgb::BLACK }
    }

    /// Whether another surface lies in the place of a side and counts there.
    pub(super) fn is_covered(&self, side: usize) -> bool {
        self.covered[side / 2][side % 2]
    }

    /// Counts the sides.
    pub(super) fn sides(&self) -> usize {
        2 * self.facets.len()
    }
}

/// Returns 1 on the side of the normal, -1 on the other.
pub(super) fn sign(side: usize) -> f64 {
    if side.is_multiple_of(2) { 1.0 } else { -1.0 }
}

/// Returns a point of `facet` that can see, and be seen on that side by, what looks from `from`
/// with `normal` up: the first of its points from the given one on.
pub(super) fn facing<'a>(
    facet: &'a Facet,
    sign: f64,
    from: &Hit,
    normal: glam::DVec3,
    start: usize,
) -> Option<&'a Hit> {
    let n = facet.points.len();
    (0..n).map(|k| &facet.points[(start + k) % n]).find(|target| {
        let to = target.point - from.point;
        to.dot(normal) > 0.0 && sign * to.dot(target.normal) < 0.0
    })
}

fn infinite(object: &Object) -> Error {
    Error::Parameter(format!(
        "object `{}` is infinite and cannot be divided into patches; for radiosity use a disc or \
         a rectangle that is large enough, or choose the estimator `local`",
        object.name
    ))
}

fn reflectance(object: &Object, brdf: &Brdf) -> Result<Rgb> {
    match brdf {
        Brdf::Lambert { reflectance } => Ok(*reflectance),
        Brdf::Glossy(_) | Brdf::Mirror { .. } | Brdf::Mixture(_) => Err(Error::Parameter(format!(
            "the material of object `{}` is not Lambertian; radiosity knows no other, choose the \
             estimator `local` or `path`",
            object.name
        ))),
    }
}
