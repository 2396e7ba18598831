//! What lies inside what: points and objects behind the surface of a closed object.

use glam::{DVec2, DVec3};

use crate::math::Ray;
use crate::scene::Object;
use crate::surface::Surface;

/// A point's ray towards here meets edges and vertices of ordinary scenes with probability zero.
const ASIDE: DVec3 = DVec3::new(0.369_274_729_379_982, 0.501_387_205_912_7, 0.782_527_463_921_9);

/// Points per side of the square that is mapped onto an object's surface.
const SIDE: u32 = 16;

/// Tells whether a point lies behind a closed surface: inside a body, or outside a room whose normals point inward.
pub(super) fn is_behind(surface: &dyn Surface, point: DVec3) -> bool {
    let direction = ASIDE.normalize();
    match surface.hit(&Ray::new(point, direction)) {
        Some(hit) => hit.normal.dot(direction) > 0.0,
        None => outside_is_behind(surface),
    }
}

/// Tells whether the outside of a closed surface is its back: whether a ray from far away first meets it from behind.
fn outside_is_behind(surface: &dyn Surface) -> bool {
    let bounds = surface.bounds();
    let direction = -ASIDE.normalize();
    let ray = Ray::new(bounds.centre() - 2.0 * bounds.extent().length() * direction, direction);
    surface.hit(&ray).is_some_and(|hit| hit.normal.dot(direction) > 0.0)
}

/// Gives the share of an object's surface, 0 to 1, that lies behind another closed surface; `None` when it cannot be sampled.
pub(super) fn share_behind(object: &Object, other: &dyn Surface) -> Option<f64> {
    let area = object.area.as_ref()?;
    let middle = |i: u32| (f64::from(i) + 0.5) / f64::from(SIDE);
    let points = (0..SIDE * SIDE).map(|k| DVec2::new(middle(k / SIDE), middle(k % SIDE)));
    let behind = points.filter(|u| is_behind(other, area.sample_area(*u).hit.point)).count();
    Some(behind as f64 / f64::from(SIDE * SIDE))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Rgb;
    use crate::scene::Material;
    use crate::surface::primitives::{AxisBox, Sphere};

    #[test]
    fn inside_of_a_body_and_outside_of_a_room_are_behind() {
        let body = Sphere::new(DVec3::ZERO, 1.0).expect("valid");
        assert!(is_behind(&body, DVec3::splat(0.1)) && !is_behind(&body, DVec3::splat(1.0)));
        let room = AxisBox::new(DVec3::splat(-1.0), DVec3::ONE).expect("valid").turned_inward(true);
        assert!(
            !is_behind(&room, DVec3::splat(0.1))
                && is_behind(&room, DVec3::splat(-1.5))
                && is_behind(&room, DVec3::splat(1.5))
        );
    }

    #[test]
    fn outside_of_a_room_is_behind_on_every_side() {
        let body = AxisBox::new(DVec3::splat(-1.0), DVec3::ONE).expect("valid");
        let room = body.turned_inward(true);
        for side in DVec3::AXES.into_iter().flat_map(|axis| [axis, -axis]) {
            assert!(is_behind(&room, 1.01 * side) && is_behind(&room, 30.0 * side));
            assert!(!is_behind(&body, 1.01 * side) && !is_behind(&body, 30.0 * side));
        }
    }

    #[test]
    fn cutting_a_wall_shows_as_a_share() {
        let material = Material::lambert(Rgb::grey(0.5)).expect("valid");
        let room = AxisBox::new(DVec3::splat(-1.0), DVec3::ONE).expect("valid").turned_inward(true);
        let at = |x| Object::new("s", Sphere::new(DVec3::X * x, 0.5).expect("valid"), material);
        assert_eq!(share_behind(&at(0.0), &room), Some(0.0));
        // Half of the sphere's area is past the wall; the 16 x 16 points resolve it to some percent.
        assert!(share_behind(&at(1.0), &room).is_some_and(|s| (s - 0.5).abs() <= 0.05));
    }
}
