//! Kinds of rays: chords, camera, shadow, grazing.

use clap::ValueEnum;
use glam::DVec3;
use harmolux::fit::project_conforming;
use harmolux::math::sampling::uniform_sphere;
use harmolux::math::{Frame, Ray};
use harmolux::mesh::Mesh;
use harmolux::surface::{Hit, Intersector, SampleArea, ShSurface};
use rand::{RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;

use super::Outcome;

#[derive(Clone, Copy, Debug, PartialEq, ValueEnum)]
pub(super) enum Kind {
    Chords,
    Camera,
    Shadow,
    Grazing,
}

/// What rays are made for.
pub(super) struct Body {
    surface: ShSurface,
    /// The radius of the bounding sphere about the origin, of mesh and expansion, metres.
    radius: f64,
    centre: DVec3,
    /// The radius of a sphere about `centre` that holds the mesh, metres.
    reach: f64,
}

/// How far the camera stands from the centre, in radii of the sphere it frames.
const CAMERA: f64 = 3.0;
/// How far off the surface a shadow ray starts, radii: its origin is outside as f32 too.
const OFF: f64 = 1e-5;

impl Body {
    pub(super) fn new(mesh: &Mesh, lmax: usize) -> Outcome<Self> {
        let coefficients = project_conforming(mesh, DVec3::ZERO, lmax)?;
        let surface = ShSurface::new(&coefficients, Intersector::Certified)?;
        let centre = mesh.bounds().centre();
        let farthest =
            |from: DVec3| mesh.positions().iter().map(|p| p.distance(from)).fold(0.0, f64::max);
        let radius = farthest(DVec3::ZERO).max(surface.body().bounds().max);
        Ok(Self { surface, radius, centre, reach: farthest(centre) })
    }

    /// Makes rays of one kind.
    pub(super) fn rays(&self, kind: Kind, count: usize, seed: u64) -> Vec<Ray> {
        let mut random = Xoshiro256PlusPlus::seed_from_u64(seed);
        match kind {
            Kind::Camera => self.camera(&mut random, count),
            Kind::Chords => (0..count).map(|_| self.chord(&mut random)).collect(),
            Kind::Shadow => (0..count).map(|_| self.shadow(&mut random)).collect(),
            Kind::Grazing => (0..count).map(|_| self.grazing(&mut random)).collect(),
        }
    }

    fn chord(&self, random: &mut Xoshiro256PlusPlus) -> Ray {
        loop {
            let [from, to] = [0, 1].map(|_| self.radius * uniform_sphere(random.random()));
            if let Some(ray) = Ray::between(from, to) {
                return ray;
            }
        }
    }

    /// Looks at the body from a random side; a square picture, the last line cut short where
    /// `count` is no square.
    fn camera(&self, random: &mut Xoshiro256PlusPlus, count: usize) -> Vec<Ray> {
        let back = uniform_sphere(random.random());
        let frame = Frame::about(back);
        let eye = self.centre + CAMERA * self.reach * back;
        // The tangent of half the angle under which the sphere appears.
        let half = 1.0 / (CAMERA * CAMERA - 1.0).sqrt();
        let columns = (count as f64).sqrt().ceil() as usize;
        let at = |pixel: usize| ((pixel as f64 + 0.5) / columns as f64 * 2.0 - 1.0) * half;
        let ray = |i: usize| {
            let local = DVec3::new(at(i % columns), -at(i / columns), -1.0);
            Ray::new(eye, frame.to_world(local).normalize())
        };
        (0..count).map(ray).collect()
    }

    /// Leaves a random point of the surface towards a random point above its horizon.
    fn shadow(&self, random: &mut Xoshiro256PlusPlus) -> Ray {
        loop {
            let hit = self.point(random);
            let target = 2.0 * self.radius * uniform_sphere(random.random());
            let direction = (target - hit.point).normalize_or_zero();
            if direction.dot(hit.normal) > 0.0 {
                let ray = hit.leave(direction);
                return Ray { origin: ray.origin + OFF * self.radius * hit.normal, ..ray };
            }
        }
    }

    /// Passes a random point along a random tangent, a little above or below, from outside the
    /// bounding sphere.
    fn grazing(&self, random: &mut Xoshiro256PlusPlus) -> Ray {
        let hit = self.point(random);
        let [turn, height, side]: [f64; 3] = random.random();
        let (sin, cos) = (std::f64::consts::TAU * turn).sin_cos();
        let direction = Frame::about(hit.normal).to_world(DVec3::new(cos, sin, 0.0));
        let height = 10.0_f64.powf(-3.0 - 6.0 * height) * hit.point.length();
        let through = hit.point + if side < 0.5 { height } else { -height } * hit.normal;
        Ray::new(through - 2.5 * self.radius * direction, direction)
    }

    /// Picks a point of the surface, uniform in area per direction.
    fn point(&self, random: &mut Xoshiro256PlusPlus) -> Hit {
        self.surface.sample_area(random.random::<[f64; 2]>().into()).hit
    }
}
