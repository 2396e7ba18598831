//! Where sensors lie: on the surface they are meant for, before all others.

use glam::DVec3;

use super::{Scene, Sensor};
use crate::math::Ray;
use crate::surface::Hit;

/// A sensor this close to a surface, relative to the size of its object, lies on it: files hold
/// coordinates in single precision.
const ON_SURFACE: f64 = 1e-6;
/// How far before a surface that passes through it a sensor is put, relative to the distance within
/// which it lies on it: enough for the surface to be seen exactly.
const BEFORE_SURFACE: f64 = 1e-3;
/// The same relative to the error of the place where the surface is.
const BEFORE_ERROR: f64 = 64.0;
/// The cosine to its support from which a sensor counts as upright on it.
const UPRIGHT: f64 = 0.999;
/// The least sine of the angle between a sensor's plane and a surface that passes through it, and
/// cosine to one that it lies on.
const LEAST_SLOPE: f64 = 0.05;
/// How many surfaces are passed in search of the one a sensor lies on.
const MOST_LAYERS: usize = 8;

impl Scene {
    /// Puts a sensor on the surface that it is meant to lie on: the uppermost that is within a
    /// millionth of its object's size above or below it. A sensor that was placed on a surface
    /// ([`Sensor::on`]) is on it. Of other surfaces that pass through the sensor, as the walls
    /// where it lies in a corner, it is put on the front, as far as it stays on its own.
    pub fn settled(&self, sensor: &Sensor) -> Sensor {
        let support = self.support(sensor);
        let up = sensor.normal;
        let on = match &support {
            Some((_, hit)) if sensor.error <= 0.0 => {
                let height = (hit.point - sensor.at).dot(up);
                let at = if height > 0.0 { hit.point } else { sensor.at };
                // Rays leave along the sensor's own normal, which may be tilted against the
                // surface.
                let error = hit.error / hit.normal.dot(up).abs();
                Sensor { at, error: error.max(f64::MIN_POSITIVE), ..*sensor }
            }
            _ => *sensor,
        };
        let at = self.before_others(on.at, up, support.as_ref());
        Sensor { at, ..on }
    }

    /// Finds the object that a sensor lies on, and where.
    fn support(&self, sensor: &Sensor) -> Option<(usize, Hit)> {
        let reach = ON_SURFACE * self.index.largest_size();
        let up = sensor.normal;
        let mut ray = Ray::new(sensor.at + reach * up, -up).up_to(2.0 * reach);
        // Surfaces one below the other: those that the sensor is too far from for their size are
        // passed.
        for _ in 0..MOST_LAYERS {
            let (object, hit) = self.hit(&ray)?;
            let height = (hit.point - sensor.at).dot(up);
            // What shines at the sensor is before it, however near.
            let lights_it = hit.normal.dot(up) < 0.0 && self.objects[object].emits();
            let lies_on_it = hit.normal.dot(up).abs() > LEAST_SLOPE;
            if height.abs() <= self.nearness(object, &hit) && lies_on_it && !lights_it {
                return Some((object, hit));
            }
            let next = hit.departure(-up);
            let rest = (next - sensor.at).dot(up) + reach;
            if rest <= 0.0 {
                return None;
            }
            ray = Ray::new(next, -up).up_to(rest);
        }
        None
    }

    /// Moves a sensor to the front of the surfaces that pass through it beside its support, where
    /// it stays on that: seen from a point in a wall, the light of the wall is undefined.
    fn before_others(&self, mut at: DVec3, up: DVec3, support: Option<&(usize, Hit)>) -> DVec3 {
        let reach = ON_SURFACE * self.index.largest_size();
        let (e1, e2) = up.any_orthonormal_pair();
        // Two lines that lie in none of the planes that scenes are made of.
        let (e1, e2) = (0.8 * e1 + 0.6 * e2, 0.8 * e2 - 0.6 * e1);
        // A sensor that is tilted against its support leaves its own plane.
        let upright = support.is_none_or(|(_, hit)| hit.normal.dot(up).abs() > UPRIGHT);
        for _ in 0..MOST_LAYERS {
            let moved = [e1, -e1, e2, -e2].into_iter().find_map(|aside| {
                let ray = Ray::new(at + reach * aside, -aside).up_to(2.0 * reach);
                let (object, hit) = self.hit(&ray)?;
                let within = hit.normal.reject_from_normalized(up);
                let normal = if upright { within } else { hit.normal };
                let near = self.nearness(object, &hit);
                let off = (at - hit.point).dot(hit.normal);
                let before = (BEFORE_SURFACE * near).max(BEFORE_ERROR * hit.error);
                let passes = within.length() > LEAST_SLOPE && off >= -near && off < 0.5 * before;
                let moved = at + normal * ((before - off) / normal.length_squared());
                (passes && self.keeps(moved, up, upright, support)).then_some(moved)
            });
            let Some(moved) = moved else { break };
            at = moved;
        }
        at
    }

    /// Whether a sensor that is moved still lies on its support, or before it if it is tilted.
    fn keeps(
        &self,
        moved: DVec3,
        up: DVec3,
        upright: bool,
        support: Option<&(usize, Hit)>,
    ) -> bool {
        let Some((object, hit)) = support else { return true };
        if !upright {
            return (moved - hit.point).dot(hit.normal) >= -4.0 * hit.error;
        }
        let reach = self.nearness(*object, hit);
        let ray = Ray::new(moved + reach * up, -up).up_to(2.0 * reach);
        self.hit(&ray).is_some_and(|(found, _)| found == *object)
    }

    /// Returns how far from a hit, metres, a sensor may be that is meant to lie there.
    fn nearness(&self, object: usize, hit: &Hit) -> f64 {
        (ON_SURFACE * self.index.size(object)).max(self.index.coincidence(object, hit))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Rgb;
    use crate::scene::{Material, Object};
    use crate::surface::primitives::{AxisBox, Rectangle};

    fn grey() -> Material {
        Material::lambert(Rgb::grey(0.5)).expect("valid")
    }

    /// A room at UTM coordinates with a desk whose top is a hair above 0.75 m.
    fn desk_room(top: f64) -> (Scene, DVec3) {
        let corner = DVec3::new(408_201.0, 5_600_123.0, 0.0);
        let room = AxisBox::new(corner, corner + DVec3::new(4.0, 4.0, 3.0)).expect("valid");
        let desk =
            AxisBox::new(corner + DVec3::new(1.0, 1.0, 0.7), corner + DVec3::new(3.0, 3.0, top));
        let objects = vec![
            Object::new("room", room.turned_inward(true), grey()),
            Object::new("desk", desk.expect("valid"), grey()),
        ];
        (Scene::new(objects, vec![]).expect("valid"), corner)
    }

    #[test]
    fn sensors_a_hair_under_a_surface_lie_on_it() {
        for off in [1e-13, 1e-8, 1e-6, 2e-6] {
            let (scene, corner) = desk_room(0.75 + off);
            let sensor = |x: f64| Sensor::plane(corner + DVec3::new(x, 2.0, 0.75), DVec3::Z);
            let on = scene.settled(&sensor(2.0));
            assert_eq!(on.at.z, 0.75 + off, "{off}");
            assert!(!scene.blocked(&on.as_hit().leave(DVec3::Z).up_to(2.0)));
            // Beside the desk it stays in the air.
            assert_eq!(scene.settled(&sensor(0.5)), sensor(0.5));
        }
        let (scene, corner) = desk_room(0.7501);
        let deep = Sensor::plane(corner + DVec3::new(2.0, 2.0, 0.75), DVec3::Z);
        assert_eq!(scene.settled(&deep), deep);
    }

    #[test]
    fn sensors_in_walls_are_before_all_of_them() {
        let far = DVec3::new(408_201.0, 5_600_123.0, 0.0);
        for (corner, most) in [(DVec3::ZERO, 1e-8), (far, 1e-6)] {
            let size = DVec3::new(4.0, 4.0, 3.0);
            let room = AxisBox::new(corner, corner + size).expect("valid").turned_inward(true);
            let screen = Rectangle::new(corner + DVec3::new(2.0, 1.0, 0.0), DVec3::Y, DVec3::Z);
            let objects = vec![
                Object::new("room", room, grey()),
                Object::new("screen", screen.expect("valid"), grey()),
            ];
            let scene = Scene::new(objects, vec![]).expect("valid");
            let front = |at: [f64; 3], before: [f64; 3]| {
                let at = corner + DVec3::from(at);
                let off = scene.settled(&Sensor::plane(at, DVec3::Z)).at - at;
                let sides = off.to_array().into_iter().zip(before);
                for (off, side) in sides {
                    let right = if side == 0.0 { off == 0.0 } else { off * side > 0.0 };
                    assert!(right && off.abs() <= most, "{at}: {off} for {side}");
                }
            };
            front([0.0, 0.0, 0.0], [1.0, 1.0, 0.0]);
            front([4.0, 4.0, 0.0], [-1.0, -1.0, 0.0]);
            front([4.0, 2.5, 1.0], [-1.0, 0.0, 0.0]);
            front([2.0, 1.5, 0.5], [1.0, 0.0, 0.0]);
            front([2.0, 1.5, 0.0], [1.0, 0.0, 0.0]);
            front([2.1, 1.5, 0.0], [0.0, 0.0, 0.0]);
        }
    }

    #[test]
    fn sensors_stay_on_what_they_lie_on() {
        // Two rooms that share the wall x = 0; a shelf in one of them, its end in that wall.
        let solid = |name: &str, min: [f64; 3], max: [f64; 3], inward: bool| {
            let surface = AxisBox::new(min.into(), max.into()).expect("valid");
            Object::new(name, surface.turned_inward(inward), grey())
        };
        let objects = vec![
            solid("own", [0.0, 0.0, 0.0], [4.0, 5.0, 3.0], true),
            solid("next", [-4.0, 0.0, 0.0], [0.0, 5.0, 3.0], true),
            solid("shelf", [0.0, 4.0, 1.0], [4.0, 5.0, 1.02], false),
        ];
        let scene = Scene::new(objects, vec![]).expect("valid");
        let settled = |at: [f64; 3], normal: [f64; 3]| {
            scene.settled(&Sensor::plane(at.into(), DVec3::from(normal).normalize())).at
        };
        assert!(settled([0.0, 4.5, 1.02], [0.0, 0.0, 1.0]).x > 0.0);
        for tilt in [[1.0, 0.0, 1.0], [1.0, 0.0, 0.2]] {
            assert!(settled([0.0, 2.0, 1.0], tilt).x >= 0.0, "{tilt:?}");
        }
        // In an edge, between both walls.
        let between = settled([2.0, 0.0, 0.0], [0.0, 1.0, 1.0]);
        assert!(between.y > 0.0 && between.z > 0.0, "{between}");
        let corner = settled([4.0, 0.0, 0.0], [-1.0, 1.0, 1.0]);
        assert!(corner.x < 4.0 && corner.y > 0.0 && corner.z > 0.0, "{corner}");
    }
}
