//! Closed rooms, from which no ray escapes.

use glam::DVec3;

use super::super::AxisBox;
use super::{unit_box, v};
use crate::math::{Frame, Randomness, Ray, Stream, sampling};
use crate::surface::{Hit, Surface};

/// Draws a cosine-distributed direction on the hit's outer side, now and then one that all but
/// grazes.
fn bounce(hit: &Hit, [u, v, pick, graze]: [f64; 4]) -> DVec3 {
    let local = if pick < 0.2 {
        let cos = 10_f64.powf(-15.0 * graze);
        DVec3::new((6.3 * u).cos(), (6.3 * u).sin(), cos).normalize()
    } else if pick < 0.3 {
        // Exactly along a wall: zero components of either sign.
        [DVec3::X, DVec3::Y, DVec3::NEG_X, DVec3::NEG_Y][(4.0 * u) as usize]
    } else {
        sampling::cosine_hemisphere([u, v])
    };
    Frame::about(hit.normal).to_world(local)
}

/// Follows `bounces` reflections in an inward box and counts the rays that find no wall or see the
/// back of one.
fn escapes(room: &AxisBox, bounces: u64, mut aim: impl FnMut(&Hit, [f64; 4]) -> DVec3) -> u64 {
    let centre = room.bounds().centre();
    let start = || room.hit(&Ray::new(centre, v(0.36, 0.48, 0.8))).expect("from the middle");
    let (mut lost, mut hit) = (0, start());
    for i in 0..bounces {
        let direction = aim(&hit, Stream::new(Randomness::Pseudorandom, 5, i).next_4d());
        let ray = hit.leave(direction);
        let next = room.hit(&ray).filter(|next| next.normal.dot(direction) <= 0.0);
        lost += u64::from(next.is_none() || !room.bounds().contains(ray.origin));
        hit = next.unwrap_or_else(start);
    }
    lost
}

fn rooms() -> [AxisBox; 5] {
    [
        (DVec3::ZERO, v(4.0, 5.0, 3.0)),
        (v(-1.0, -0.3, -1.0 / 3.0), v(0.1, 0.7, 0.9)),
        (v(1e6, -1e6, 1e-3), v(1e6 + 3.0, 4.1 - 1e6, 2.7)),
        (v(-1e-3, 0.0, 1e-3), v(1e-3, 1e-3, 2e-3)),
        (v(0.0, 0.0, 1e6), v(1e6, 1.0, 1e6 + 1e-3)),
    ]
    .map(|(min, max)| AxisBox::new(min, max).expect("valid").turned_inward(true))
}

#[test]
fn nothing_escapes_from_a_closed_room_in_a_million_bounces() {
    for room in rooms() {
        assert_eq!(escapes(&room, 200_000, bounce), 0, "{room:?}");
    }
}

#[test]
fn nothing_escapes_through_edges_and_corners() {
    for room in rooms() {
        let (low, extent) = (room.bounds().min, room.bounds().extent());
        // Aims at points from 1e-12 down to 0 (of the room's size, then in ulps) off a random edge
        // or corner, and beyond it.
        let lost = escapes(&room, 200_000, |hit, [u, w, pick, nudge]| {
            let mut at = v(u, w, pick);
            let corner = [u, w, pick].map(|x| (16.0 * x) as u32 % 2);
            for axis in 0..3 {
                if nudge < 0.3 || axis != (32.0 * u) as usize % 3 {
                    let tiny = [0.0, 1e-12, 1e-15, -1e-15, -1e-12, 3e-16][(64.0 * w) as usize % 6];
                    at[axis] = f64::from(corner[axis]) + tiny * nudge;
                }
            }
            let direction = (low + at * extent - hit.point).try_normalize();
            // The side of the wall is a walk's own choice: it never sends light behind it.
            let direction = direction.filter(|d| d.dot(hit.normal) != 0.0).unwrap_or(hit.normal);
            if direction.dot(hit.normal) < 0.0 { -direction } else { direction }
        });
        assert_eq!(lost, 0, "{room:?}");
    }
}

#[test]
fn every_ray_that_starts_in_a_closed_box_hits_it_from_inside() {
    // Origins in the box, on faces, on edges and in corners to the last bit; directions with zero
    // components among them.
    let values = [0.0, f64::from_bits(1), 1e-12, 0.5, 1.0 - f64::EPSILON / 2.0, 1.0];
    let steps = [-1.0, -1e-300, -0.0, 0.0, 1e-9, 1.0];
    let room = unit_box().turned_inward(true);
    for i in 0..216 {
        let from = v(values[i % 6], values[i / 6 % 6], values[i / 36]);
        for j in 0..216 {
            let towards = v(steps[j % 6], steps[j / 6 % 6], steps[j / 36]);
            let Some(direction) = towards.try_normalize() else { continue };
            let hit = room.hit(&Ray::new(from, direction)).expect("closed");
            assert!(hit.distance >= 0.0 && hit.normal.dot(direction) < 0.0, "{from} {direction}");
        }
    }
}

#[test]
fn departed_corner_points_stay_inside() {
    let room = rooms()[0];
    let (low, high) = (room.bounds().min, room.bounds().max);
    for corner in [low, high, v(low.x, high.y, low.z), v(high.x, high.y, low.z)] {
        let inwards = (room.bounds().centre() - corner).normalize();
        let hit = room.hit(&Ray::new(room.bounds().centre(), -inwards)).expect("the corner");
        for direction in
            [DVec3::X, DVec3::Y, DVec3::Z, DVec3::NEG_X, DVec3::NEG_Y, DVec3::NEG_Z, inwards]
        {
            if direction.dot(hit.normal) >= 0.0 {
                assert!(room.bounds().contains(hit.departure(direction)));
            }
        }
    }
}
