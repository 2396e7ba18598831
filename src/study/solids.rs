//! What lies inside what: points and objects behind the surface of a closed object.

use glam::{DVec2, DVec3};

use crate::math::{Aabb, Ray};
use crate::scene::Object;
use crate::surface::Surface;

/// A point's ray towards here meets edges and vertices of ordinary scenes with probability zero.
const ASIDE: DVec3 = DVec3::new(0.369_274_729_379_982, 0.501_387_205_912_7, 0.782_527_463_921_9);

/// Points per side of the square that is mapped onto an object's surface.
const SIDE: u32 = 16;

/// Tells whether a point lies behind a closed surface: inside a body, or outside a room whose normals point inward.
pub(super) fn is_behind(surface: &dyn Surface, point: DVec3) -> bool {
    let met_from_behind = |direction: DVec3| {
        let hit = surface.hit(&Ray::new(point, direction))?;
        Some(hit.normal.dot(direction) > 0.0)
    };
    // From outside a ray may miss, which does not tell a body from a room: then the surface is aimed at.
    let aimed =
        || aims(surface.bounds()).find_map(|aim| met_from_behind((aim - point).normalize()));
    met_from_behind(ASIDE.normalize()).or_else(aimed).unwrap_or(false)
}

/// Gives points within bounds to aim at: near the middle, then near that of each eighth; `ASIDE` keeps them off the edges of ordinary scenes.
fn aims(bounds: Aabb) -> impl Iterator<Item = DVec3> {
    let half = 0.5 * bounds.extent();
    let eighth =
        |i: usize| DVec3::from_array([i & 1, (i >> 1) & 1, i >> 2].map(|b| b as f64 - 0.5));
    let offsets = std::iter::once(DVec3::ZERO).chain((0..8).map(eighth));
    offsets.map(move |offset| bounds.centre() + half * (offset + 0.05 * ASIDE))
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
        assert!(!is_behind(&room, DVec3::splat(0.1)) && is_behind(&room, DVec3::splat(-1.5)));
    }

    #[test]
    fn outside_of_a_room_is_behind_on_every_side() {
        let room = AxisBox::new(DVec3::splat(-1.0), DVec3::ONE).expect("valid").turned_inward(true);
        let body = AxisBox::new(DVec3::splat(-1.0), DVec3::ONE).expect("valid");
        for axis in DVec3::AXES {
            for at in [-30.0 * axis, -1.1 * axis, 1.1 * axis, 30.0 * axis] {
                assert!(is_behind(&room, at) && !is_behind(&body, at), "{at}");
            }
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
