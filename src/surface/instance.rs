//! A surface placed by rotation, uniform scale and translation.
//!
//! Rays go into local space, where their direction keeps its length and distances shrink by the
//! scale; hits come back. The placed surface is, by definition, the exact image of the local one
//! under the stored [`Placement`], whose matrix is orthogonal to rounding only; the error bounds
//! here account for that.

use std::sync::Arc;

use glam::{DVec2, DVec3};

use super::{AreaPoint, Division, Facet, Hit, Outline, SampleArea, Surface};
use crate::math::{Aabb, Placement, Ray};

/// Places a shared surface in the world; itself a surface, and one to sample where the inner one
/// is.
///
/// A closed room made of one placed box is leak-proof as [`super::primitives::AxisBox`] describes;
/// of other surfaces a point closer to a concave edge than its error bound can depart behind the
/// neighbouring face.
///
/// ```
/// use std::sync::Arc;
/// use glam::{DQuat, DVec3};
/// use harmolux::math::{Placement, Ray};
/// use harmolux::surface::{Instance, SampleArea, Surface, primitives::Sphere};
///
/// let unit = Arc::new(Sphere::new(DVec3::ZERO, 1.0)?);
/// let three_times = Placement::new(DQuat::IDENTITY, 3.0, DVec3::new(5.0, 0.0, 0.0))?;
/// let large = Instance::new(unit, three_times);
/// let hit = large.hit(&Ray::new(DVec3::ZERO, DVec3::X)).expect("straight ahead");
/// assert!((hit.distance - 2.0).abs() <= 1e-15);
/// assert!((large.area() - 36.0 * std::f64::consts::PI).abs() <= 1e-12);
/// let both: Arc<dyn SampleArea> = Arc::new(large);
/// let _as_surface: Arc<dyn Surface> = both;
/// # Ok::<(), harmolux::Error>(())
/// ```
#[derive(Debug)]
pub struct Instance<S: ?Sized = dyn Surface> {
    placement: Placement,
    inner: Arc<S>,
}

impl<S: ?Sized> Clone for Instance<S> {
    fn clone(&self) -> Self {
        Self { placement: self.placement, inner: Arc::clone(&self.inner) }
    }
}

/// How many rays of a batch go through local space at a time: enough to feed a batched surface,
/// little enough for the stack.
const BATCH: usize = 64;

impl<S: ?Sized> Instance<S> {
    /// Places `inner`.
    pub const fn new(inner: Arc<S>, placement: Placement) -> Self {
        Self { placement, inner }
    }

    /// Returns the placement.
    pub const fn placement(&self) -> &Placement {
        &self.placement
    }

    /// Returns the surface that is placed.
    pub const fn inner(&self) -> &Arc<S> {
        &self.inner
    }

    /// Takes a ray into local space; infinite ends stay infinite.
    fn local_ray(&self, ray: &Ray) -> Ray {
        let scale = self.placement.scale();
        Ray {
            origin: self.placement.unapply(ray.origin),
            direction: self.placement.unapply_direction(ray.direction),
            t_min: ray.t_min / scale,
            t_max: ray.t_max / scale,
        }
    }

    /// Brings a hit of the inner surface into the world, its error bound widened by the roundings
    /// of that.
    ///
    /// Error, with x the local point and u = 2^-53: three products, their sums and the scale lose 4
    /// sqrt(3) u s|x|, the translation u|p|. The bound is 16u s|x| + 2u|p|, so that a departed ray,
    /// 2.5 bounds off, survives its way into local space: difference, rotation and quotient lose
    /// less than 9u s|x| there, and a matrix M with entries of M^T M - I up to 6u another 18u s|x|,
    /// in all less than the 40u s|x| that 2.5 bounds hold.
    pub fn world_hit(&self, local: &Hit) -> Hit {
        let scale = self.placement.scale();
        let point = self.placement.apply(local.point);
        let mapping = f64::EPSILON * (8.0 * scale * local.point.length() + point.length());
        Hit {
            distance: local.distance * scale,
            point,
            normal: self.placement.apply_direction(local.normal),
            shading_normal: self.placement.apply_direction(local.shading_normal),
            error: scale * local.error + mapping,
            part: local.part,
        }
    }

    /// Brings a hit of `ray` into the world; the rounding of the scale must not carry it out of the
    /// ray's range.
    fn world_hit_of(&self, ray: &Ray, local: &Hit) -> Hit {
        let hit = self.world_hit(local);
        Hit { distance: hit.distance.max(ray.t_min).min(ray.t_max), ..hit }
    }

    /// Takes a world hit back into local space; the way back loses less than 32u of the distance
    /// from the local origin.
    fn local_hit(&self, hit: &Hit) -> Hit {
        let scale = self.placement.scale();
        let point = self.placement.unapply(hit.point);
        Hit {
            distance: hit.distance / scale,
            point,
            normal: self.placement.unapply_direction(hit.normal),
            shading_normal: self.placement.unapply_direction(hit.shading_normal),
            error: hit.error / scale + 16.0 * f64::EPSILON * point.length(),
            part: hit.part,
        }
    }
}

impl<S: Surface + ?Sized> Surface for Instance<S> {
    fn hit(&self, ray: &Ray) -> Option<Hit> {
        let local = self.inner.hit(&self.local_ray(ray))?;
        Some(self.world_hit_of(ray, &local))
    }

    fn bounds(&self) -> Aabb {
        placed(&self.inner.bounds(), &self.placement)
    }

    fn blocked(&self, ray: &Ray) -> bool {
        self.inner.blocked(&self.local_ray(ray))
    }

    fn hits(&self, rays: &[Ray], hits: &mut [Option<Hit>]) {
        let mut local = [Ray::new(DVec3::ZERO, DVec3::Z); BATCH];
        for (rays, hits) in rays.chunks(BATCH).zip(hits.chunks_mut(BATCH)) {
            for (local, ray) in local.iter_mut().zip(rays) {
                *local = self.local_ray(ray);
            }
            self.inner.hits(&local[..rays.len()], hits);
            for (hit, ray) in hits.iter_mut().zip(rays) {
                *hit = hit.map(|local| self.world_hit_of(ray, &local));
            }
        }
    }

    fn mark_blocked(&self, rays: &[Ray], blocked: &mut [bool]) {
        let mut local = [Ray::new(DVec3::ZERO, DVec3::Z); BATCH];
        for (rays, blocked) in rays.chunks(BATCH).zip(blocked.chunks_mut(BATCH)) {
            // What is marked already is passed over, so its local ray may be anything.
            for ((local, ray), _) in
                local.iter_mut().zip(rays).zip(&*blocked).filter(|(_, marked)| !**marked)
            {
                *local = self.local_ray(ray);
            }
            self.inner.mark_blocked(&local[..rays.len()], blocked);
        }
    }

    fn refine(&self, hit: &Hit) -> Hit {
        let local = self.local_hit(hit);
        let refined = self.inner.refine(&local);
        // A surface with nothing to refine must not pay the rounding of the way there and back.
        if refined == local { *hit } else { self.world_hit(&refined) }
    }
}

impl<S: SampleArea + ?Sized> SampleArea for Instance<S> {
    fn area(&self) -> f64 {
        self.inner.area() * self.placement.scale().powi(2)
    }

    fn sample_area(&self, u: DVec2) -> AreaPoint {
        let local = self.inner.sample_area(u);
        let density = local.density / self.placement.scale().powi(2);
        AreaPoint { hit: self.world_hit(&local.hit), density }
    }

    fn density(&self, hit: &Hit) -> f64 {
        self.inner.density(&self.local_hit(hit)) / self.placement.scale().powi(2)
    }

    fn outline(&self) -> Outline {
        let (at, scale) = (|p| self.placement.apply(p), self.placement.scale());
        match self.inner.outline() {
            Outline::Disc { centre, normal, radius } => Outline::Disc {
                centre: at(centre),
                normal: self.placement.apply_direction(normal),
                radius: scale * radius,
            },
            Outline::Sphere { centre, radius } => {
                Outline::Sphere { centre: at(centre), radius: scale * radius }
            }
            other => other,
        }
    }

    fn facets(&self, division: &Division) -> Vec<Facet> {
        let lights: Vec<DVec3> =
            division.lights.iter().map(|&at| self.placement.unapply(at)).collect();
        let local = self.inner.facets(&Division { lights: &lights, ..*division });
        let place = |facet: Facet| facet.placed(&self.placement, |hit| self.world_hit(hit));
        local.into_iter().map(place).collect()
    }

    fn uniform(&self, u: DVec2) -> Hit {
        self.world_hit(&self.inner.uniform(u))
    }
}

/// Bounds the image of a box axis by axis (Arvo, "Transforming Axis-Aligned Bounding Boxes",
/// Graphics Gems, 1990): the box of the eight corners, widened by its rounding. Infinite sides stay
/// infinite where the rotation looks along them.
fn placed(local: &Aabb, placement: &Placement) -> Aabb {
    if local.is_empty() {
        return Aabb::EMPTY;
    }
    let (mut min, mut max) = (placement.translation(), placement.translation());
    let (mut low_size, mut high_size) = (min.abs(), max.abs());
    for j in 0..3 {
        let column = placement.scale() * placement.rotation().col(j);
        for i in (0..3).filter(|&i| column[i] != 0.0) {
            let (a, b) = (column[i] * local.min[j], column[i] * local.max[j]);
            min[i] += a.min(b);
            max[i] += a.max(b);
            low_size[i] += a.min(b).abs();
            high_size[i] += a.max(b).abs();
        }
    }
    // Five roundings of the sum of sizes at most.
    let widen = 4.0 * f64::EPSILON;
    Aabb { min: min - widen * low_size, max: max + widen * high_size }
}

#[cfg(test)]
mod tests {
    use glam::{DMat3, DQuat};

    use super::*;
    use crate::math::{Frame, Randomness, Stream, sampling};
    use crate::surface::primitives::exact::{Exact, from_sphere};
    use crate::surface::primitives::{AxisBox, Disc, Plane, Sphere};

    fn random(index: u64) -> [f64; 4] {
        Stream::new(Randomness::Pseudorandom, 11, index).next_4d()
    }

    fn direction(index: u64) -> DVec3 {
        let [u, v, ..] = random(index);
        sampling::uniform_sphere([u, v]).normalize()
    }

    /// Draws a placement with scale and translation log-uniform over the given decades.
    fn placement(index: u64, scales: [f64; 2], reach: [f64; 2]) -> Placement {
        let [a, b, c, d] = random(3 * index);
        let [e, f, ..] = random(3 * index + 1);
        let between = |[low, high]: [f64; 2], x: f64| 10_f64.powf(low + (high - low) * x);
        let rotation = DQuat::from_xyzw(a - 0.5, b - 0.5, c - 0.5, d - 0.5);
        Placement::new(rotation, between(scales, e), between(reach, f) * direction(3 * index + 2))
            .expect("valid")
    }

    /// Takes a world point back through the exact inverse of the stored placement, to 32 digits.
    fn exact_local(point: DVec3, placement: &Placement) -> Exact {
        let m: DMat3 = placement.rotation();
        let y = Exact::from(point).minus(placement.translation().into());
        let first = y.turned(m.transpose());
        let residual = y.minus(first.turned(m));
        let world = first.plus(residual.turned(m.transpose()));
        // The quotient by the scale, Newton-corrected once.
        let (s, q) = (placement.scale(), world.times(1.0 / placement.scale()));
        q.plus(world.minus(q.times(s)).times(1.0 / s))
    }

    #[test]
    fn misses_and_nan_rays_stay_misses() {
        let ball: Arc<dyn Surface> = Arc::new(Sphere::new(DVec3::ZERO, 1.0).expect("valid"));
        let placed = Instance::new(ball, placement(0, [0.0, 1.0], [0.0, 1.0]));
        assert_eq!(placed.hit(&Ray::new(DVec3::NAN, DVec3::X)), None);
        assert_eq!(placed.hit(&Ray::new(DVec3::splat(50.0), DVec3::ONE.normalize())), None);
        assert_eq!(placed.hit(&Ray::new(DVec3::ZERO, DVec3::X).up_to(f64::NAN)), None);
    }

    #[test]
    fn identity_changes_nothing_but_the_bound() {
        let ball = Arc::new(Sphere::new(DVec3::ONE, 0.5).expect("valid"));
        let placed = Instance::new(Arc::clone(&ball), Placement::IDENTITY);
        let ray = Ray::new(DVec3::ZERO, DVec3::ONE.normalize());
        let (a, b) = (ball.hit(&ray).expect("ahead"), placed.hit(&ray).expect("ahead"));
        assert!(b.error >= a.error);
        assert_eq!(Hit { error: a.error, ..b }, a);
    }

    #[test]
    fn placed_sphere_is_the_sphere_of_placed_parameters() {
        for i in 0..2000 {
            let placement = placement(i, [-3.0, 3.0], [-3.0, 3.0]);
            let local = Sphere::new(DVec3::new(0.3, -0.2, 0.5), 0.7).expect("valid");
            let placed = Instance::new(Arc::new(local), placement);
            let (centre, radius) = (placement.apply(local.centre()), placement.scale() * 0.7);
            let direct = Sphere::new(centre, radius).expect("valid");
            let target = centre + 0.9 * radius * direction(7 * i);
            let ray = Ray::new(target - 3.0 * radius * direction(5 * i), direction(5 * i));
            let (a, b) = (placed.hit(&ray).expect("aimed"), direct.hit(&ray).expect("aimed"));
            // Impact parameters up to 0.9 R: sensitivity 1/cos < 2.5 to a dozen roundings of the
            // coordinates.
            let tolerance = 64.0 * f64::EPSILON * (centre.length() + radius + ray.origin.length());
            assert!((a.distance - b.distance).abs() <= tolerance);
            assert!((a.point - b.point).length() <= tolerance);
            assert!((a.normal - b.normal).length() * radius <= tolerance);
            assert!(a.error <= 32.0 * f64::EPSILON * (centre.length() + radius));
            assert!((placed.area() / direct.area() - 1.0).abs() <= 8.0 * f64::EPSILON);
            assert!((placed.density(&a) * direct.area() - 1.0).abs() <= 8.0 * f64::EPSILON);
        }
    }

    #[test]
    fn bound_holds_and_departures_are_clean_at_all_scales() {
        let local = Sphere::new(DVec3::new(0.3, -0.2, 0.5), 0.7).expect("valid");
        for i in 0..4000 {
            let placement = placement(i, [-3.0, 6.0], [-3.0, 6.0]);
            let placed = Instance::new(Arc::new(local), placement);
            let (centre, radius) = (placement.apply(local.centre()), placement.scale() * 0.7);
            let away = 10_f64.powf(9.0 * random(i)[3]) * radius;
            let aim = direction(5 * i);
            let ray = Ray::new(centre + 0.5 * radius * direction(7 * i) - away * aim, aim);
            let Some(hit) = placed.hit(&ray) else { continue };
            let inner = exact_local(hit.point, &placement);
            let off = from_sphere(inner, local.centre(), local.radius()).abs() * placement.scale();
            assert!(off <= hit.error, "{off:e} > {:e}", hit.error);
            let frame = Frame::about(hit.normal);
            for cos in [1.0, 1e-3, 1e-6, 1e-9, 1e-12] {
                let [u, ..] = random(9 * i);
                let (sin, angle) = ((1.0_f64 - cos * cos).sqrt(), 6.3 * u);
                let flat = DVec3::new(sin * angle.cos(), sin * angle.sin(), 0.0);
                let up = frame.to_world(flat + cos * DVec3::Z).normalize();
                let down = frame.to_world(flat - cos * DVec3::Z).normalize();
                assert_eq!(placed.hit(&hit.leave(up)), None, "{cos:e}");
                assert!(placed.hit(&hit.leave(down)).is_some_and(|h| h.distance > 0.0), "{cos:e}");
            }
        }
    }

    #[test]
    fn ends_of_a_ray_are_scaled_and_kept() {
        let ball = Arc::new(Sphere::new(DVec3::ZERO, 1.0).expect("valid"));
        for scale in [1e-90, 1e-3, 1.0 / 3.0, 7.0, 1e90] {
            let placement = Placement::new(DQuat::IDENTITY, scale, DVec3::ZERO).expect("valid");
            let placed = Instance::new(Arc::clone(&ball), placement);
            let ray = Ray::new(DVec3::new(0.0, 0.0, 3.0 * scale), DVec3::NEG_Z);
            let near = placed.hit(&ray).expect("ahead").distance;
            assert!((near / scale - 2.0).abs() <= 1e-15);
            let cut = placed.hit(&ray.up_to(2.0 * scale));
            assert!(cut.is_none_or(|h| h.distance <= 2.0 * scale));
            assert_eq!(placed.hit(&ray.up_to(1.99 * scale)), None);
            assert!(placed.blocked(&ray) && !placed.blocked(&ray.up_to(1.99 * scale)));
            let far = placed.hit(&Ray { t_min: 2.5 * scale, ..ray }).expect("behind");
            assert!((far.distance / scale - 4.0).abs() <= 1e-14);
        }
    }

    #[test]
    fn batches_are_the_single_answers() {
        let placed = Instance::new(
            Arc::new(Sphere::new(DVec3::ZERO, 1.0).expect("valid")),
            placement(3, [0.0, 1.0], [0.0, 0.5]),
        );
        let rays: Vec<Ray> =
            (0..150).map(|i| Ray::new(5.0 * direction(i), -direction(i + 1))).collect();
        let mut hits = vec![None; rays.len()];
        placed.hits(&rays, &mut hits);
        assert!(rays.iter().zip(&hits).all(|(ray, hit)| placed.hit(ray) == *hit));
        assert!(hits.iter().any(Option::is_some) && hits.iter().any(Option::is_none));
        // Every third ray is marked from the start and stays so.
        let mut blocked: Vec<bool> = (0..rays.len()).map(|i| i % 3 == 0).collect();
        placed.mark_blocked(&rays, &mut blocked);
        for (i, (ray, marked)) in rays.iter().zip(blocked).enumerate() {
            assert_eq!(marked, i % 3 == 0 || placed.blocked(ray));
        }
    }

    #[test]
    fn nested_instances_are_one_of_the_composed_placement() {
        for i in 0..500 {
            let (a, b) = (
                placement(2 * i, [-1.0, 1.0], [-1.0, 1.0]),
                placement(2 * i + 1, [-1.0, 1.0], [-1.0, 1.0]),
            );
            let ball = Arc::new(Sphere::new(DVec3::X, 1.0).expect("valid"));
            let nested = Instance::new(Arc::new(Instance::new(Arc::clone(&ball), a)), b);
            let flat = Instance::new(ball, a.then(&b));
            let centre = a.then(&b).apply(DVec3::X);
            let radius = a.scale() * b.scale();
            let aim = direction(i);
            let ray = Ray::new(centre + 0.5 * radius * direction(i + 7) - 3.0 * radius * aim, aim);
            let (n, f) = (nested.hit(&ray).expect("aimed"), flat.hit(&ray).expect("aimed"));
            let tolerance = 64.0
                * f64::EPSILON
                * (ray.origin.length() + centre.length() + 20.0 * radius + 100.0);
            assert!((n.distance - f.distance).abs() <= tolerance);
            assert!((n.point - f.point).length() <= tolerance);
            assert_eq!(nested.refine(&n), n, "nothing to refine, nothing lost");
            assert!((nested.area() / flat.area() - 1.0).abs() <= 1e-14);
            assert_eq!(nested.hit(&n.leave(n.normal)), None);
        }
    }

    /// Refines its point to a place that only an exact series would know.
    struct Refining(Sphere);

    impl Surface for Refining {
        fn hit(&self, ray: &Ray) -> Option<Hit> {
            self.0.hit(ray)
        }
        fn bounds(&self) -> Aabb {
            self.0.bounds()
        }
        fn refine(&self, hit: &Hit) -> Hit {
            Hit {
                point: hit.point.normalize(),
                normal: hit.point.normalize(),
                error: 1e-15,
                ..*hit
            }
        }
    }

    #[test]
    fn refinement_happens_in_local_space() {
        let inner = Arc::new(Refining(Sphere::new(DVec3::ZERO, 0.999).expect("valid")));
        let placement = placement(8, [0.5, 1.0], [0.0, 1.0]);
        let placed: Instance = Instance::new(inner, placement);
        let ray = Ray::new(placement.translation() + 50.0 * DVec3::X, DVec3::NEG_X);
        let hit = placed.refine(&placed.hit(&ray).expect("aimed"));
        let radius = (hit.point - placement.translation()).length();
        assert!(
            (radius - placement.scale()).abs() <= 1e-13
                && (hit.normal - DVec3::X).length() <= 1e-14
        );
        assert!(hit.error <= 1e-13);
    }

    #[test]
    fn bounds_hold_the_samples_and_are_tight_for_a_box() {
        let solid =
            AxisBox::new(DVec3::new(-1.0, 0.0, 2.0), DVec3::new(0.5, 3.0, 2.5)).expect("valid");
        let disc = Disc::new(DVec3::ONE, DVec3::new(1.0, 2.0, 3.0), 2.0).expect("valid");
        for i in 0..100 {
            let placement = placement(i, [-2.0, 2.0], [-2.0, 2.0]);
            let inner: [Arc<dyn SampleArea>; 2] = [Arc::new(solid), Arc::new(disc)];
            for inner in inner {
                let (local, placed) = (inner.bounds(), Instance::new(inner, placement));
                let bounds = placed.bounds();
                let corners = (0..8).map(|c| {
                    let pick =
                        DVec3::new(f64::from(c & 1), f64::from(c >> 1 & 1), f64::from(c >> 2));
                    placement.apply(local.min + pick * local.extent())
                });
                let eight = Aabb::of_points(corners);
                let slack = 32.0
                    * f64::EPSILON
                    * (bounds.min.length()
                        + bounds.max.length()
                        + placement.translation().length()
                        + 10.0 * placement.scale());
                assert!(
                    (bounds.min - eight.min).length() <= slack
                        && (bounds.max - eight.max).length() <= slack
                );
                for j in 0..100 {
                    let [u, v, ..] = random(j);
                    let hit = placed.sample_area(DVec2::new(u, v)).hit;
                    let near = Aabb { min: bounds.min - hit.error, max: bounds.max + hit.error };
                    assert!(near.contains(hit.point));
                }
            }
        }
    }

    #[test]
    fn infinite_and_empty_bounds_have_no_nan() {
        let floor = Arc::new(Plane::new(DVec3::new(0.0, 0.0, 2.0), DVec3::Z).expect("valid"));
        let turned = Placement::new(DQuat::from_rotation_z(0.3), 2.0, DVec3::ONE).expect("valid");
        let bounds = Instance::new(Arc::clone(&floor), turned).bounds();
        assert!((bounds.min.z - 5.0).abs() <= 1e-14 && (bounds.max.z - 5.0).abs() <= 1e-14);
        assert_eq!((bounds.min.x, bounds.max.y), (f64::NEG_INFINITY, f64::INFINITY));
        assert_eq!(Instance::new(floor, placement(1, [0.0, 1.0], [0.0, 1.0])).bounds(), Aabb::ALL);
        assert!(placed(&Aabb::EMPTY, &turned).is_empty());
        assert_eq!(placed(&Aabb::ALL, &turned), Aabb::ALL);
    }

    #[test]
    fn nothing_escapes_from_a_placed_room() {
        let local =
            AxisBox::new(DVec3::new(-2.0, -2.5, 0.0), DVec3::new(2.0, 2.5, 3.0)).expect("valid");
        let room = Arc::new(local.turned_inward(true));
        for i in 0..20 {
            // Moved up to three times its size: the reach that the box's edges are kept clear for.
            let [.., x] = random(i);
            let placed = Instance::new(
                Arc::clone(&room),
                placement(i, [0.0, 0.0], [-1.0, 0.9 + x.min(0.1)]),
            );
            let middle = placed.placement().apply(DVec3::Z);
            let mut hit = placed.hit(&Ray::new(middle, direction(i))).expect("closed");
            for j in 0..20_000 {
                let [u, v, pick, nudge] = random(1000 + j);
                let direction = if pick < 0.5 {
                    // Towards a point within 1e-12 of a vertical edge or a corner.
                    let side = |x: f64| if x < 0.5 { -1.0 } else { 1.0 };
                    let z = if nudge < 0.5 { 3.0 * v } else { 1e-12 * v };
                    let near = 1.0 - 1e-12 * nudge * (pick - 0.25);
                    let edge = DVec3::new(2.0 * near * side(u), 2.5 * near * side(v), z);
                    (placed.placement().apply(edge) - hit.point).normalize()
                } else {
                    Frame::about(hit.normal).to_world(sampling::cosine_hemisphere([u, v]))
                };
                let direction =
                    if direction.dot(hit.normal) < 0.0 { -direction } else { direction };
                let next = placed.hit(&hit.leave(direction)).expect("nothing escapes");
                assert!(next.normal.dot(direction) <= 1e-15, "a wall seen from behind");
                hit = next;
            }
        }
    }
}
