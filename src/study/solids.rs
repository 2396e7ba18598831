//! What lies inside what: points and objects behind the surface of a closed object.

use glam::{DVec2, DVec3};

use crate::math::{Aabb, Ray};
use crate::scene::Object;
use crate::surface::Surface;

/// A point's ray towards here meets edges and vertices of ordinary scenes with probability zero.
const ASIDE: DVec3 = DVec3::new(0.369_274_729_379_982, 0.501_387_205_912_7, 0.782_527_463_921_9);

/// Points per side of the square that is mapped onto an object's surface.
const SIDE: u32 = 16;

/// Says whether a surface has an inside.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Body {
    /// It has none.
    Open,
    /// It has one.
    Closed,
    /// It has one, and with any two points all between them.
    Convex,
}

/// A closed object, with what is asked of it again and again.
pub(super) struct Solid<'a> {
    object: &'a Object,
    bounds: Aabb,
    convex: bool,
    /// Whether the outside is its back: the normals of a room point inward.
    is_room: bool,
}

impl<'a> Solid<'a> {
    /// Takes an object as a solid; `None` for one without an inside.
    pub(super) fn new(object: &'a Object, body: Body) -> Option<Self> {
        let is_room = || outside_is_behind(&*object.surface);
        (body != Body::Open).then(|| Self {
            object,
            bounds: object.surface.bounds(),
            convex: body == Body::Convex,
            is_room: is_room(),
        })
    }

    /// Returns the name of the object.
    pub(super) fn name(&self) -> &'a str {
        &self.object.name
    }

    /// Returns the diagonal of the bounds, metres.
    pub(super) fn size(&self) -> f64 {
        self.bounds.extent().length()
    }

    /// Whether a point lies behind the surface: inside a body, or outside a room.
    pub(super) fn is_behind(&self, point: DVec3) -> bool {
        if !self.bounds.contains(point) {
            return self.is_room;
        }
        let direction = ASIDE.normalize();
        let hit = self.object.surface.hit(&Ray::new(point, direction));
        hit.map_or(self.is_room, |hit| hit.normal.dot(direction) > 0.0)
    }

    /// Returns the share of the surface, 0 to 1, that lies behind another solid and, where that is
    /// a room, in none of the other `rooms`; `None` when it cannot be sampled.
    pub(super) fn share_behind(&self, other: &Solid, rooms: &[&Solid]) -> Option<f64> {
        let rooms = || rooms.iter().filter(|room| !std::ptr::eq(**room, other));
        let alone = !other.is_room || rooms().next().is_none();
        if alone && self.bounds.intersection(other.bounds).is_empty() {
            return Some(f64::from(u8::from(other.is_room)));
        }
        if other.is_convex_room() && self.bounds.corners().into_iter().all(|c| !other.is_behind(c))
        {
            return Some(0.0);
        }
        let area = self.object.area.as_ref()?;
        let middle = |i: u32| (f64::from(i) + 0.5) / f64::from(SIDE);
        let points = (0..SIDE * SIDE).map(|k| DVec2::new(middle(k / SIDE), middle(k % SIDE)));
        let points = points.map(|u| area.sample_area(u).hit.point);
        let elsewhere = |p: DVec3| other.is_room && rooms().any(|room| !room.is_behind(p));
        let behind = points.filter(|p| other.is_behind(*p) && !elsewhere(*p)).count();
        Some(behind as f64 / f64::from(SIDE * SIDE))
    }

    /// Whether the outside is its back.
    pub(super) fn is_room(&self) -> bool {
        self.is_room
    }

    fn is_convex_room(&self) -> bool {
        self.convex && self.is_room
    }
}

/// Returns the solid behind whose surface a point is: a body that it is inside of, or the first of
/// the rooms when it is in none. A point of the surface of its `own` solid is before that.
pub(super) fn behind<'s, 'a>(
    point: DVec3,
    own: Option<&str>,
    solids: &'s [Solid<'a>],
) -> Option<&'s Solid<'a>> {
    let is_behind = |solid: &&Solid| own != Some(solid.name()) && solid.is_behind(point);
    let body = solids.iter().filter(|s| !s.is_room).find(is_behind);
    body.or_else(|| {
        let mut rooms = solids.iter().filter(|s| s.is_room);
        rooms.clone().all(|room| is_behind(&room)).then(|| rooms.next()).flatten()
    })
}

/// Whether the outside of a closed surface is its back: whether a ray from far away first meets it
/// from behind.
fn outside_is_behind(surface: &dyn Surface) -> bool {
    let bounds = surface.bounds();
    let direction = -ASIDE.normalize();
    let ray = Ray::new(bounds.centre() - 2.0 * bounds.extent().length() * direction, direction);
    surface.hit(&ray).is_some_and(|hit| hit.normal.dot(direction) > 0.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Rgb;
    use crate::scene::Material;
    use crate::surface::primitives::{AxisBox, Sphere};

    fn sphere(x: f64, radius: f64, inward: bool) -> Object {
        let surface = Sphere::new(DVec3::X * x, radius).expect("valid").turned_inward(inward);
        Object::new("sphere", surface, Material::lambert(Rgb::grey(0.5)).expect("valid"))
    }

    fn cube(inward: bool) -> Object {
        let surface = AxisBox::new(DVec3::splat(-1.0), DVec3::ONE).expect("valid");
        let grey = Material::lambert(Rgb::grey(0.5)).expect("valid");
        Object::new("cube", surface.turned_inward(inward), grey)
    }

    fn convex(object: &Object) -> Solid<'_> {
        Solid::new(object, Body::Convex).expect("closed")
    }

    #[test]
    fn inside_of_a_body_and_outside_of_a_room_are_behind() {
        let (body, room) = (sphere(0.0, 1.0, false), cube(true));
        let (body, room) = (convex(&body), convex(&room));
        // Points in the box of the ball and not in the ball, and points outside both.
        assert!(body.is_behind(DVec3::splat(0.1)) && !body.is_behind(DVec3::splat(0.9)));
        assert!(!body.is_behind(DVec3::splat(1.1)) && !room.is_behind(DVec3::splat(0.1)));
        assert!(room.is_behind(DVec3::splat(-1.5)) && room.is_behind(DVec3::splat(1.5)));
    }

    #[test]
    fn outside_of_a_room_is_behind_on_every_side() {
        let (body, room) = (cube(false), cube(true));
        let (body, room) = (convex(&body), convex(&room));
        for side in DVec3::AXES.into_iter().flat_map(|axis| [axis, -axis]) {
            assert!(room.is_behind(1.01 * side) && room.is_behind(30.0 * side));
            assert!(!body.is_behind(1.01 * side) && !body.is_behind(30.0 * side));
        }
    }

    #[test]
    fn open_surfaces_are_no_solids() {
        assert!(Solid::new(&cube(false), Body::Open).is_none());
    }

    #[test]
    fn cutting_a_wall_shows_as_a_share() {
        let (body, room, round) = (cube(false), cube(true), sphere(0.0, 1.0, true));
        // Half of the sphere's area is past the wall; the 16 x 16 points resolve it to some
        // percent.
        let half = convex(&sphere(1.0, 0.5, false)).share_behind(&convex(&room), &[]);
        assert!(half.is_some_and(|s| (s - 0.5).abs() <= 0.05));
        for (x, behind_walls) in [(0.0, 0.0), (0.5, 0.0), (5.0, 1.0)] {
            let ball = sphere(x, 0.5, false);
            let share = |other: &Solid| convex(&ball).share_behind(other, &[]);
            assert_eq!(share(&convex(&room)), Some(behind_walls), "at {x}");
            assert_eq!(share(&convex(&round)), Some(behind_walls), "at {x}");
            assert_eq!(share(&convex(&body)), Some(1.0 - behind_walls), "at {x}");
            // What is not known to be convex is sampled, with the same answer.
            let sampled = Solid::new(&room, Body::Closed).expect("closed");
            assert_eq!(share(&sampled), Some(behind_walls), "at {x}");
        }
    }

    #[test]
    fn a_point_in_any_room_is_before_all_rooms() {
        let (left, right) = (sphere(-1.0, 1.0, true), sphere(1.0, 1.0, true));
        let ball = sphere(1.0, 0.2, false);
        let solids = [convex(&left), convex(&right), convex(&ball)];
        let number = |point: DVec3| {
            behind(point, None, &solids).map(|s| solids.iter().position(|o| std::ptr::eq(o, s)))
        };
        assert_eq!(number(DVec3::new(-1.0, 0.0, 0.0)), None);
        assert_eq!(number(DVec3::new(1.5, 0.0, 0.0)), None);
        assert_eq!(number(DVec3::new(1.1, 0.0, 0.0)), Some(Some(2)));
        assert_eq!(number(DVec3::new(0.0, 3.0, 0.0)), Some(Some(0)));
        let rooms: Vec<&Solid> = solids.iter().filter(|s| s.is_room()).collect();
        assert_eq!(solids[2].share_behind(&solids[0], &rooms), Some(0.0));
        assert_eq!(solids[2].share_behind(&solids[0], &rooms[..1]), Some(1.0));
    }
}
