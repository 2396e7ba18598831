//! A star-shaped body given by spherical harmonics, as a surface: r = f(omega) about the origin.

use glam::{DVec2, DVec3};

use super::area_map::AreaMap;
use super::certified::Crossing;
use super::patches::{Answer, Patches};
use super::radial::{Gap, RadialBody};
use super::step_bisection::StepBisection;
use super::{AreaPoint, Division, Facet, Hit, SampleArea, Surface, certified, facets};
use crate::math::{Aabb, Ray, sampling};
use crate::sh::Coefficients;
use crate::{Error, Result};

/// Chooses how rays meet an SH surface.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum Intersector {
    /// Patches of the surface with certified error bounds: never misses, and the fastest.
    #[default]
    Patches,
    /// Certified stepping on the exact series: never misses.
    Certified,
    /// The paper's march with bisection: can miss what is thinner than its step.
    StepBisection(StepBisection),
}

impl Intersector {
    /// Their names in scene files.
    pub const NAMES: &'static [&'static str] = &["patches", "certified", "step-bisection"];

    /// Returns the intersector of a name, with the usual settings.
    pub fn named(name: &str) -> Option<Self> {
        match name {
            "patches" => Some(Self::Patches),
            "certified" => Some(Self::Certified),
            "step-bisection" => Some(Self::StepBisection(StepBisection::default())),
            _ => None,
        }
    }
}

/// What answers rays: the patches, or a way of stepping on the series itself.
#[derive(Debug, Clone)]
enum Tracer {
    Patches(Patches),
    Certified,
    StepBisection(StepBisection),
}

/// Answers rays against r = f(omega), f a series of positive radius.
#[derive(Debug, Clone)]
pub struct ShSurface {
    body: RadialBody,
    tracer: Tracer,
    area_map: AreaMap,
}

impl ShSurface {
    /// Makes the surface from the coefficients of its radius, metres.
    ///
    /// # Errors
    /// [`Error::Geometry`] when the radius is not certainly positive; [`Error::Parameter`] for a
    /// degree too high, an intersector whose step is below
    /// [`StepBisection::SHORTEST_STEP`] or whose tolerance is not positive.
    pub fn new(coefficients: &Coefficients, intersector: Intersector) -> Result<Self> {
        if let Intersector::StepBisection(s) = intersector
            && !(s.step >= StepBisection::SHORTEST_STEP && s.tolerance > 0.0)
        {
            return Err(Error::Parameter(format!(
                "the step of the step-bisection intersector must be {:e} or more, and its \
                 tolerance positive",
                StepBisection::SHORTEST_STEP
            )));
        }
        let body = RadialBody::new(coefficients)?;
        let tracer = match intersector {
            Intersector::Patches => Tracer::Patches(Patches::new(body.series(), body.bounds())?),
            Intersector::Certified => Tracer::Certified,
            Intersector::StepBisection(march) => Tracer::StepBisection(march),
        };
        let area_map = AreaMap::new(&body);
        Ok(Self { body, tracer, area_map })
    }

    /// Returns the body: its series and certified bounds.
    pub fn body(&self) -> &RadialBody {
        &self.body
    }

    /// Returns the bytes that the patches and their tree take in memory; 0 without patches.
    pub fn patch_bytes(&self) -> usize {
        match &self.tracer {
            Tracer::Patches(patches) => patches.bytes(),
            _ => 0,
        }
    }

    /// Returns the point, normal and error bound at a direction from the centre.
    pub fn at(&self, direction: DVec3) -> Hit {
        let jet = self.body.series().jet(direction);
        let normal = (direction - jet.gradient / jet.value).normalize();
        Hit {
            distance: jet.value,
            point: jet.value * direction,
            normal,
            shading_normal: normal,
            error: self.body.tolerance() + self.traced_error(),
            part: 0,
        }
    }

    /// Bounds how far what is traced can be from the series, metres.
    fn traced_error(&self) -> f64 {
        match &self.tracer {
            Tracer::Patches(patches) => patches.error(),
            _ => 0.0,
        }
    }

    fn describe(&self, distance: f64, point: DVec3, gap: &Gap) -> Hit {
        let normal = gap.normal.normalize();
        Hit {
            distance,
            point,
            normal,
            shading_normal: normal,
            error: gap.value.abs() + self.body.tolerance() + self.traced_error(),
            part: 0,
        }
    }

    fn certified_hit(&self, ray: &Ray) -> Option<Hit> {
        let Crossing { distance, point, gap } = certified::first_crossing(&self.body, ray)?;
        Some(self.describe(distance, point, &gap))
    }
}

impl Surface for ShSurface {
    fn hit(&self, ray: &Ray) -> Option<Hit> {
        match &self.tracer {
            Tracer::Patches(patches) => match patches.hit(ray) {
                Answer::Known(hit) => hit,
                Answer::AskSeries => self.certified_hit(ray),
            },
            Tracer::Certified => self.certified_hit(ray),
            Tracer::StepBisection(march) => {
                let (t, gap) = march.first_crossing(&self.body, ray)?;
                Some(self.describe(t, ray.at(t), &gap))
            }
        }
    }

    fn bounds(&self) -> Aabb {
        match &self.tracer {
            Tracer::Patches(patches) => patches.bounds(),
            _ => Aabb::of_ball(DVec3::ZERO, self.body.bounds().max),
        }
    }

    fn blocked(&self, ray: &Ray) -> bool {
        match &self.tracer {
            Tracer::Patches(patches) => match patches.blocked(ray) {
                Answer::Known(blocked) => blocked,
                Answer::AskSeries => certified::crosses(&self.body, ray),
            },
            Tracer::Certified => certified::crosses(&self.body, ray),
            Tracer::StepBisection(march) => march.first_crossing(&self.body, ray).is_some(),
        }
    }

    fn hits(&self, rays: &[Ray], hits: &mut [Option<Hit>]) {
        let Tracer::Patches(patches) = &self.tracer else {
            return rays.iter().zip(hits).for_each(|(ray, hit)| *hit = self.hit(ray));
        };
        for place in patches.hits(rays, hits) {
            hits[place] = self.certified_hit(&rays[place]);
        }
    }

    fn mark_blocked(&self, rays: &[Ray], blocked: &mut [bool]) {
        let Tracer::Patches(patches) = &self.tracer else {
            return rays.iter().zip(blocked).for_each(|(r, b)| *b = *b || self.blocked(r));
        };
        for place in patches.mark_blocked(rays, blocked) {
            blocked[place] = certified::crosses(&self.body, &rays[place]);
        }
    }

    /// Moves the point along its radius onto the exact series and takes the exact normal there.
    fn refine(&self, hit: &Hit) -> Hit {
        let Some(direction) = hit.point.try_normalize() else { return *hit };
        Hit { distance: hit.distance, part: hit.part, ..self.at(direction) }
    }
}

/// Returns dA / d omega = f sqrt(f^2 + |grad_S f|^2).
fn area_factor(body: &RadialBody, direction: DVec3) -> f64 {
    let jet = body.series().jet(direction);
    jet.value * jet.value.hypot(jet.gradient.length())
}

impl SampleArea for ShSurface {
    /// Returns the area as integrated on a Gauss-Legendre grid oversampled twice; the integrand is
    /// smooth but not band-limited.
    fn area(&self) -> f64 {
        self.area_map.area()
    }

    /// Samples the direction uniformly; the density follows the stretch of the surface.
    fn sample_area(&self, u: DVec2) -> AreaPoint {
        let direction = sampling::uniform_sphere(u.to_array());
        let hit = Hit { distance: 0.0, ..self.at(direction) };
        AreaPoint { hit, density: self.density(&hit) }
    }

    fn density(&self, hit: &Hit) -> f64 {
        let Some(direction) = hit.point.try_normalize() else { return 0.0 };
        1.0 / (4.0 * std::f64::consts::PI * area_factor(&self.body, direction))
    }

    /// Divides by direction, into at least 96 facets.
    fn facets(&self, division: &Division) -> Vec<Facet> {
        let at = |direction| {
            let hit = Hit { distance: 0.0, ..self.at(direction) };
            (hit, area_factor(&self.body, direction))
        };
        facets::around(division.count, 4, at).collect()
    }

    /// Maps by the inverses of the area above a height and of the area along its ring (`area_map`);
    /// about a hundred times the cost of [`SampleArea::sample_area`].
    fn uniform(&self, u: DVec2) -> Hit {
        Hit { distance: 0.0, ..self.at(self.area_map.direction(&self.body, u)) }
    }
}

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng};
    use rand_xoshiro::Xoshiro256PlusPlus;

    use super::*;
    use crate::error::Advice;

    fn sphere(radius: f64) -> Coefficients {
        let mut c = Coefficients::zeros(0);
        c.set(0, 0, radius, 0.0);
        c
    }

    fn bumpy(lmax: usize, amplitude: f64) -> Coefficients {
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(lmax as u64);
        let mut c = Coefficients::zeros(lmax);
        c.set(0, 0, 1.0, 0.0);
        for l in 1..=lmax {
            for m in 0..=l {
                let k = amplitude / (l * l) as f64;
                c.set(l, m, k * (rng.random::<f64>() - 0.5), k * (rng.random::<f64>() - 0.5));
            }
        }
        c
    }

    fn random_ray(rng: &mut Xoshiro256PlusPlus, radius: f64) -> Ray {
        let from = radius * sampling::uniform_sphere(rng.random());
        let to = radius * sampling::uniform_sphere(rng.random());
        Ray::between(from, to).expect("distinct").up_to(f64::INFINITY)
    }

    #[test]
    fn negative_radius_and_bad_march_are_refused() {
        let negative = ShSurface::new(&sphere(-1.0), Intersector::Certified).expect_err("refused");
        let Error::Advised { error, advice: Advice::AddRadius } = negative else {
            panic!("{negative}")
        };
        assert!(matches!(*error, Error::Geometry(_)), "{error}");
        for step in [0.0, 1e-12, f64::NAN] {
            let march = Intersector::StepBisection(StepBisection { step, tolerance: 1e-9 });
            assert!(matches!(ShSurface::new(&sphere(1.0), march), Err(Error::Parameter(_))));
        }
    }

    #[test]
    fn ray_of_which_no_distance_counts_hits_nothing() {
        let march = Intersector::StepBisection(StepBisection::default());
        for intersector in [Intersector::Patches, Intersector::Certified, march] {
            let s = ShSurface::new(&sphere(1.0), intersector).expect("valid");
            // Both ends are one number when they are measured from the centre.
            let ray = Ray { t_min: 1e-309, t_max: 0.0, ..Ray::new(-DVec3::X, -DVec3::X) };
            assert!(s.hit(&ray).is_none() && !s.blocked(&ray), "{intersector:?}");
        }
    }

    #[test]
    fn sphere_of_degree_zero_is_hit_where_it_stands() {
        let s = ShSurface::new(&sphere(2.0), Intersector::Certified).expect("valid");
        assert!((s.area() - 16.0 * std::f64::consts::PI).abs() <= 1e-10);
        let hit = s.hit(&Ray::new(DVec3::new(-5.0, 1.0, 0.0), DVec3::X)).expect("meets");
        assert!((hit.distance - (5.0 - 3.0_f64.sqrt())).abs() <= 1e-11);
        let inside = s.hit(&Ray::new(DVec3::ZERO, DVec3::Y)).expect("leaves");
        assert!(
            (inside.distance - 2.0).abs() <= 1e-11 && (inside.normal - DVec3::Y).length() <= 1e-12
        );
        assert!(s.hit(&Ray::new(DVec3::new(-5.0, 2.1, 0.0), DVec3::X)).is_none());
        assert!(s.hit(&Ray::new(DVec3::new(5.0, 0.0, 0.0), DVec3::X)).is_none());
        let nan = Ray::new(DVec3::splat(f64::NAN), DVec3::X);
        let ray = Ray::new(DVec3::new(-5.0, 1.0, 0.0), DVec3::X);
        for nan in [nan, Ray { t_min: f64::NAN, ..ray }, ray.up_to(f64::NAN)] {
            assert!(s.hit(&nan).is_none() && !s.blocked(&nan));
        }
    }

    #[test]
    fn both_intersectors_agree_on_random_rays() {
        let c = bumpy(12, 0.8);
        let certified = ShSurface::new(&c, Intersector::Certified).expect("valid");
        let march = ShSurface::new(
            &c,
            Intersector::StepBisection(StepBisection { step: 0.002, tolerance: 1e-12 }),
        )
        .expect("valid");
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(3);
        for _ in 0..5000 {
            let ray = random_ray(&mut rng, 1.5 * certified.body().bounds().max);
            let (a, b) = (certified.hit(&ray), march.hit(&ray));
            assert_eq!(certified.blocked(&ray), a.is_some());
            match (a, b) {
                (Some(a), Some(b)) => {
                    // The march brackets to 1e-12 radii; where it passed a thin lobe it can only be
                    // later.
                    assert!(a.distance <= b.distance + 1e-9, "{} {}", a.distance, b.distance);
                    assert!(certified.body().gap_value(a.point).abs() <= a.error);
                    if b.distance - a.distance > 1e-6 {
                        assert!(missed_lobe_is_thin(&certified, &ray, a.distance, 0.002));
                    }
                }
                (Some(a), None) => {
                    assert!(missed_lobe_is_thin(&certified, &ray, a.distance, 0.002));
                }
                (None, Some(_)) => panic!("certified stepping missed a root"),
                (None, None) => {}
            }
        }
    }

    /// Whether the ray leaves the body again within two march steps of entering it: what the march
    /// is allowed to miss.
    fn missed_lobe_is_thin(s: &ShSurface, ray: &Ray, t: f64, step: f64) -> bool {
        let width = 2.0 * step * s.body().bounds().max;
        s.body().gap_value(ray.at(t + width)) > 0.0
    }

    #[test]
    fn departing_rays_do_not_meet_their_own_surface() {
        let s = ShSurface::new(&bumpy(8, 0.5), Intersector::Certified).expect("valid");
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(4);
        for _ in 0..2000 {
            let Some(hit) = s.hit(&random_ray(&mut rng, 2.0)) else { continue };
            let away = hit.leave(hit.normal);
            // Straight up from a body of this slope nothing is near: any hit would be the surface
            // itself.
            assert!(s.hit(&away.up_to(1e-3)).is_none());
            let down = s.hit(&hit.leave(-hit.normal)).expect("the other side");
            assert!(down.distance > 1e-3);
        }
    }

    #[test]
    fn refined_points_lie_on_the_series() {
        let s = ShSurface::new(
            &bumpy(10, 0.6),
            Intersector::StepBisection(StepBisection { step: 0.01, tolerance: 1e-4 }),
        )
        .expect("valid");
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(5);
        for _ in 0..500 {
            let Some(hit) = s.hit(&random_ray(&mut rng, 2.0)) else { continue };
            let fine = s.refine(&hit);
            assert!((fine.point - hit.point).length() <= hit.error);
            assert!(s.body().gap_value(fine.point).abs() <= fine.error && fine.error <= 1e-11);
        }
    }

    #[test]
    fn sampled_area_has_its_density() {
        let s = ShSurface::new(&bumpy(6, 0.9), Intersector::Certified).expect("valid");
        let n = 64;
        let mid = |i: i32| (f64::from(i) + 0.5) / f64::from(n);
        let mean: f64 = (0..n * n)
            .map(|k| 1.0 / s.sample_area(DVec2::new(mid(k / n), mid(k % n))).density)
            .sum::<f64>()
            / f64::from(n * n);
        // E[1/density] is the area; the midpoint rule on 64 x 64 is good to 1e-3 of it here.
        assert!((mean / s.area() - 1.0).abs() <= 1e-3);
    }

    #[test]
    fn rays_from_afar_hit_where_they_hit_from_nearby() {
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(9);
        let s = ShSurface::new(&bumpy(12, 0.8), Intersector::Certified).expect("valid");
        let mut hits = 0;
        for i in 0..20_000 {
            let along = sampling::uniform_sphere(rng.random());
            let aside = rng.random::<f64>() * sampling::uniform_sphere(rng.random());
            let far = Ray::new(aside - 10_f64.powi(6 + i % 6) * along, along);
            let nearest = far.at(-far.origin.dot(along));
            let (Some(near), far) = (s.hit(&Ray::new(nearest - 3.0 * along, along)), s.hit(&far))
            else {
                continue;
            };
            // Where it grazes, a rounding may decide.
            if near.normal.dot(along).abs() > 1e-2 {
                let far = far.expect("hits as well");
                assert!(far.point.distance(near.point) <= 1e-9, "{far:?} {near:?}");
                hits += 1;
            }
        }
        assert!(hits > 10_000, "{hits}");
    }

    #[test]
    fn far_origins_and_degenerate_rays_are_answered() {
        let s = ShSurface::new(&bumpy(8, 0.5), Intersector::Certified).expect("valid");
        let far = s.hit(&Ray::new(DVec3::new(1e6, 0.0, 0.0), DVec3::NEG_X)).expect("radial");
        assert!((far.point.length() - s.body().series().value(DVec3::X)).abs() <= 1e-9);
        assert!(s.hit(&Ray::new(DVec3::new(0.0, 0.0, 1e6), DVec3::X)).is_none());
        assert!(s.hit(&Ray::new(DVec3::X * 5.0, DVec3::NEG_X).up_to(1.0)).is_none());
        let bumpy = bumpy(8, 0.5);
        let march = Intersector::StepBisection(StepBisection::default());
        for intersector in [Intersector::Patches, Intersector::Certified, march] {
            let s = ShSurface::new(&bumpy, intersector).expect("valid");
            let out = s.hit(&Ray::new(DVec3::ZERO, DVec3::Y)).expect("from the centre");
            assert!((out.distance - s.body().series().value(DVec3::Y)).abs() <= 1e-5);
        }
        let patches = ShSurface::new(&bumpy, Intersector::Patches).expect("valid");
        assert!(patches.hit(&Ray::new(DVec3::new(0.0, 0.0, 1e30), DVec3::NEG_Z)).is_some());
    }
}
