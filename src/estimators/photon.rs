//! Direct simulation: photons are counted where they cross a small disc about each sensor.
//!
//! E is the flux that crosses the disc against its normal over its area pi r^2: the mean
//! illuminance of the disc in place of that at its centre. For a radius that is small against the
//! distance of all light this differs by a share of the order of (r / distance)^2; within r of an
//! edge, a corner or another object the disc reaches into places without light and E is too low, by
//! up to half at a wall. The interval knows nothing of this bias. The variance goes with 1 /
//! (number of walks x r^2): halving the radius takes four times the walks. A count is a whole
//! number: where Sobol points happen to give all replicates the same one (direct light straight
//! below a lamp), the interval has no width, though the value may be off by most of a photon in
//! each. `harmolux illum` therefore counts with plain random numbers.
//!
//! A disc stands at its sensor, before the surface on which the sensor lies by the
//! self-intersection policy of hits, and farther before a surface that rises above it at the rim (a
//! room seen from inside a sphere), else photons would end short of it. Direct light is counted
//! like all other. Only the illuminance of planes, and the luminance of surfaces, can be counted: a
//! cylinder has no disc.

use std::f64::consts::{PI, TAU};
use std::ops::Range;

use glam::DVec3;

use super::connect::SplitLight;
use super::integrator::{Block, Integrator, Needs, Sum};
use super::receiver::Receiver;
use super::replicates::Watch;
use super::walk::{Node, Walked};
use crate::math::{Frame, Ray, Rgb};
use crate::scene::Scene;
use crate::{Error, Result};

/// The default disc has this share of the total area of the scene.
const SHARE: f64 = 1e-4;
/// Points of the rim at which surfaces are looked for.
const RIM: u32 = 16;

/// Photon counting as an integrator.
pub(super) struct Counters<'a>(Vec<Counter<'a>>);

impl<'a> Counters<'a> {
    /// Places the discs about some receivers, of the radius that is asked for.
    ///
    /// # Errors
    /// As [`radius`] and [`Counter::new`].
    pub(super) fn new(
        scene: &Scene,
        receivers: &[Receiver<'a>],
        asked: Option<f64>,
    ) -> Result<Self> {
        let radius = radius(scene, asked)?;
        let counters = receivers.iter().map(|receiver| Counter::new(scene, receiver, radius));
        Ok(Self(counters.collect::<Result<_>>()?))
    }
}

impl<'a> Integrator<'a> for Counters<'a> {
    fn serve<'w>(
        &'w self,
        block: &Block<'w>,
        receivers: Range<usize>,
        watch: &'w Watch<'w>,
    ) -> Vec<Sum>
    where
        'a: 'w,
    {
        let serve = |receiver: usize| {
            let mut sum = Sum::default();
            if !watch.ends() {
                block.walks.iter().for_each(|walk| sum.add(self.0[receiver].count(walk)));
            }
            sum
        };
        receivers.map(serve).collect()
    }

    fn needs(&self) -> Needs {
        Needs::Walks
    }

    fn finds_point_lights(&self) -> bool {
        true
    }
}

/// Returns the radius, metres, of the counting discs: the one asked for, or that of a ten
/// thousandth of the total area of the scene.
///
/// # Errors
/// [`Error::Parameter`] when the radius is not above 0 and finite, or none is given and the scene
/// holds no bounded surface.
pub(super) fn radius(scene: &Scene, asked: Option<f64>) -> Result<f64> {
    let radius = asked.unwrap_or_else(|| (SHARE * scene.area() / PI).sqrt());
    if radius > 0.0 && radius.is_finite() {
        return Ok(radius);
    }
    Err(Error::Parameter(match asked {
        Some(radius) => format!(
            "the radius of the discs that count photons must be above 0 metres, found {radius}"
        ),
        None => "all surfaces are infinite, so there is no default radius for the discs that \
                 count photons; set `radius` in [illum]"
            .into(),
    }))
}

/// Counts the photons that a receiver gets.
#[derive(Debug, Clone, Copy)]
pub(super) struct Counter<'a> {
    receiver: Receiver<'a>,
    centre: DVec3,
    normal: DVec3,
    radius: f64,
}

impl<'a> Counter<'a> {
    /// Places a disc about a receiver.
    ///
    /// # Errors
    /// [`Error::Parameter`] when the receiver is no plane.
    pub(super) fn new(scene: &Scene, receiver: &Receiver<'a>, radius: f64) -> Result<Self> {
        let Some(normal) = receiver.plane_normal() else {
            return Err(Error::Parameter(
                "photons are counted on planes only; for a cylinder choose the estimator `local` \
                 or `path`"
                    .into(),
            ));
        };
        let base = receiver.hit.departure(normal);
        let centre = base + lift(scene, base, normal, radius) * normal;
        Ok(Self { receiver: *receiver, centre, normal, radius })
    }

    /// Adds up what one walk brings.
    pub(super) fn count(&self, walked: &Walked) -> SplitLight {
        if !walked.nodes.last().is_none_or(Node::is_sound) {
            return SplitLight::NON_FINITE;
        }
        let mut light = SplitLight::default();
        let mut straight = true;
        for node in &walked.nodes {
            if node.start_density.is_none() {
                let hit = &node.vertex.hit;
                let counted = self.crossing(hit.point, -node.vertex.outgoing, -hit.distance..=0.0);
                light.add(counted.map(|response| node.flux * response), straight);
            }
            straight = node.start_density.is_some();
        }
        if let Some((ray, flux)) = &walked.escape {
            let counted = self.crossing(ray.origin, ray.direction, 0.0..=f64::INFINITY);
            light.add(counted.map(|response| *flux * response), straight);
        }
        light
    }

    /// Returns W / (cos pi r^2) for a segment of the line through `point` that crosses the disc
    /// from before; distances count from the point.
    fn crossing(
        &self,
        point: DVec3,
        direction: DVec3,
        range: std::ops::RangeInclusive<f64>,
    ) -> Option<Rgb> {
        let against = -direction.dot(self.normal);
        if against <= 0.0 {
            return None;
        }
        let distance = (point - self.centre).dot(self.normal) / against;
        let off = point + distance * direction - self.centre;
        let inside = off.length_squared() <= self.radius * self.radius;
        (inside && range.contains(&distance)).then(|| {
            self.receiver.response(-direction) / (against * PI * self.radius * self.radius)
        })
    }
}

impl SplitLight {
    fn add(&mut self, counted: Option<Rgb>, straight: bool) {
        let part = if straight { &mut self.direct } else { &mut self.indirect };
        *part += counted.unwrap_or(Rgb::BLACK);
    }
}

/// Returns how high a disc must stand for no surface below its rim, in view of its centre, to rise
/// above it; at most the radius.
fn lift(scene: &Scene, base: DVec3, normal: DVec3, radius: f64) -> f64 {
    let frame = Frame::about(normal);
    let rise = |k: u32| {
        let (sin, cos) = (TAU * f64::from(k) / f64::from(RIM)).sin_cos();
        let above = base + radius * (cos * frame.tangent + sin * frame.bitangent + normal);
        let in_view = Ray::between(base, above).is_some_and(|ray| !scene.blocked(&ray));
        let below = in_view.then(|| scene.hit(&Ray::new(above, -normal).up_to(radius))).flatten();
        below.map_or(0.0, |(_, hit)| radius - hit.distance)
    };
    (0..RIM).map(rise).fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::estimators::walk::Launcher;
    use crate::math::{Randomness, Stream};
    use crate::scene::{Material, Object, PointLight, Sensor};
    use crate::surface::primitives::{AxisBox, Rectangle, Sphere};

    fn black() -> Material {
        Material::lambert(Rgb::BLACK).expect("valid")
    }

    /// The mean over walks of what a sensor counts.
    fn mean(scene: &Scene, sensor: &Sensor, radius: f64) -> f64 {
        let launcher = Launcher::new(scene).expect("there is light");
        let counter = Counter::new(scene, &Receiver::sensor(sensor), radius).expect("a plane");
        let n = 1 << 16;
        let count = |i| {
            let mut stream = Stream::new(Randomness::Sobol, 5, i);
            counter.count(&launcher.follow(&mut stream, &|| false)).direct.luminance()
        };
        (0..n).map(count).sum::<f64>() / n as f64
    }

    fn lamp(at: DVec3) -> PointLight {
        PointLight::isotropic("lamp", at, Rgb::grey(100.0))
    }

    #[test]
    fn photons_are_counted_on_surfaces_and_in_free_space_alike() {
        let floor = Rectangle::new(DVec3::ZERO, 4.0 * DVec3::X, 4.0 * DVec3::Y).expect("valid");
        let object = Object::new("floor", floor, black());
        let scene = Scene::new(vec![object], vec![lamp(DVec3::new(2.0, 2.0, 2.0))]).expect("valid");
        // I (1 - cos) of the disc's rim, 2 pi over pi r^2, is the mean illuminance of a disc at
        // distance d.
        let exact = |d: f64, r: f64| 200.0 * (1.0 - d / d.hypot(r)) / (r * r);
        let at = DVec3::new(2.0, 2.0, 0.0);
        for (sensor, d) in [
            (Sensor::plane(at, DVec3::Z), 2.0),
            (Sensor::plane(at + 0.5 * DVec3::Z, DVec3::Z), 1.5),
            // Towards the open sky: what flies off crosses it too.
            (Sensor::plane(at + 4.0 * DVec3::Z, DVec3::NEG_Z), 2.0),
        ] {
            let found = mean(&scene, &sensor, 0.3);
            assert!((found / exact(d, 0.3) - 1.0).abs() <= 0.02, "{found} {}", exact(d, 0.3));
        }
        assert_eq!(mean(&scene, &Sensor::plane(at, DVec3::NEG_Z), 0.3), 0.0);
    }

    #[test]
    fn half_a_disc_at_a_wall_counts_half() {
        let room = AxisBox::new(DVec3::ZERO, DVec3::splat(4.0)).expect("valid").turned_inward(true);
        let object = Object::new("room", room, black());
        let scene = Scene::new(vec![object], vec![lamp(DVec3::new(0.3, 2.0, 1.0))]).expect("valid");
        let at = |x: f64| mean(&scene, &Sensor::plane(DVec3::new(x, 2.0, 0.0), DVec3::Z), 0.2);
        // The lamp stands halfway between the middle of the half disc, 0.085 m from the wall, and
        // that of the whole one.
        let (wall, clear) = (at(0.0), at(0.515));
        assert!((wall / clear - 0.5).abs() <= 0.025, "{wall} {clear}");
    }

    #[test]
    fn discs_stand_clear_of_hollow_surfaces() {
        let ball = Sphere::new(DVec3::ZERO, 1.0).expect("valid").turned_inward(true);
        let scene = Scene::new(vec![Object::new("ball", ball, black())], vec![lamp(DVec3::ZERO)])
            .expect("valid");
        let found = mean(&scene, &Sensor::plane(DVec3::NEG_Z, DVec3::Z), 0.1);
        // 100 cd at 1 m; the disc is r^2 / 2 nearer.
        assert!((found / 100.0 - 1.0).abs() <= 0.03, "{found}");
    }

    #[test]
    fn a_radius_is_needed_where_all_is_infinite() {
        let empty = Scene::new(Vec::new(), vec![lamp(DVec3::ZERO)]).expect("valid");
        assert!(radius(&empty, None).is_err_and(|e| e.to_string().contains("`radius`")));
        assert!(radius(&empty, Some(f64::NAN)).is_err() && radius(&empty, Some(0.0)).is_err());
        assert_eq!(radius(&empty, Some(0.1)).expect("valid"), 0.1);
    }
}
