//! Cuts polygons into triangles: into the fan about the first corner where no triangle of it is
//! turned against the polygon, as in all that are convex; otherwise ears are clipped (D. Eberly,
//! "Triangulation by Ear Clipping"), seen along the sum of the area vectors (Newell's normal).
//!
//! Every corner stays one, even in a line with its neighbours: the face beside it has it too. What
//! has no area or crosses itself cannot be cut; it keeps its fan.

use glam::{DVec2, DVec3};

/// What a polygon may cost, in corners looked at: so many, and so many more for each of its own.
const COST: u64 = 1 << 20;
const COST_OF_CORNER: u64 = 1 << 10;

/// What is no more than the rounding of a cross product.
const ROUNDING: f64 = 8.0 * f64::EPSILON;

/// Says that a polygon is too intricate to be cut.
#[derive(Debug, thiserror::Error)]
#[error("a face of {0} vertices that is not convex and too intricate to be cut")]
pub(super) struct Intricate(usize);

/// Makes the fan of a polygon a cut of it, in its place.
pub(super) fn cut(positions: &[DVec3], fan: &mut [[u32; 3]]) -> Result<(), Intricate> {
    let at = |v: u32| positions[v as usize];
    let area = |&[a, b, c]: &[u32; 3]| (at(b) - at(a)).cross(at(c) - at(a));
    let normal: DVec3 = fan.iter().map(area).sum();
    let is_turned = |face: &[u32; 3]| {
        let [a, b, c] = face.map(at);
        let turned = area(face).dot(normal);
        turned < 0.0 && turned < -ROUNDING * (b - a).length() * (c - a).length() * normal.length()
    };
    if !fan.iter().any(is_turned) {
        return Ok(());
    }
    let corners: Vec<u32> =
        fan[0][..2].iter().copied().chain(fan.iter().map(|face| face[2])).collect();
    let points: Vec<DVec2> = corners.iter().map(|&v| seen_along(normal, at(v))).collect();
    if let Some(ears) = Ring::of(&points).ears()? {
        for (face, ear) in fan.iter_mut().zip(ears) {
            *face = ear.map(|corner| corners[corner as usize]);
        }
    }
    Ok(())
}

/// Leaves out the coordinate that a normal is largest in: what turns left about the normal turns
/// left in the plane, and no rounding comes in.
fn seen_along(normal: DVec3, point: DVec3) -> DVec2 {
    let axis = normal.abs().max_position();
    let [u, v] = [1, 2].map(|step| point[(axis + step) % 3]);
    if normal[axis] < 0.0 { DVec2::new(v, u) } else { DVec2::new(u, v) }
}

/// The corners that are left of a polygon, counter-clockwise.
struct Ring<'a> {
    points: &'a [DVec2],
    /// The corner before and behind each; that of one clipped off is itself.
    before: Vec<u32>,
    behind: Vec<u32>,
    /// The corners that may stand in the way of an ear, not convex ones, from left to right.
    blockers: Vec<u32>,
    left: usize,
    cost: u64,
}

impl<'a> Ring<'a> {
    fn of(points: &'a [DVec2]) -> Self {
        let count = points.len() as u32;
        let mut ring = Self {
            points,
            before: (0..count).map(|i| (i + count - 1) % count).collect(),
            behind: (0..count).map(|i| (i + 1) % count).collect(),
            blockers: Vec::new(),
            left: points.len(),
            cost: COST.saturating_add(COST_OF_CORNER * u64::from(count)),
        };
        ring.blockers = (0..count).filter(|&i| ring.turn(i) <= 0.0).collect();
        ring.blockers.sort_by(|&a, &b| points[a as usize].x.total_cmp(&points[b as usize].x));
        ring
    }

    /// Clips off one ear after the other; `None` where none is left before the last.
    fn ears(mut self) -> Result<Option<Vec<[u32; 3]>>, Intricate> {
        let mut ears = Vec::with_capacity(self.points.len() - 2);
        let (mut corner, mut tried, mut all) = (0, 0, self.left);
        // Corners in a line with their neighbours are clipped where there is no ear.
        let mut takes_flat = false;
        while self.left > 3 {
            self.pay(1)?;
            let turn = self.turn(corner);
            let is_ear =
                if takes_flat { turn == 0.0 } else { turn > 0.0 && self.is_free(corner)? };
            if is_ear {
                ears.push(self.ear(corner));
                corner = self.clip(corner);
                (tried, takes_flat) = (0, false);
                if 2 * self.left < all {
                    all = self.left;
                    self.drop_blockers();
                }
                continue;
            }
            corner = self.behind[corner as usize];
            tried += 1;
            if tried > self.left {
                if takes_flat {
                    return Ok(None);
                }
                (tried, takes_flat) = (0, true);
            }
        }
        ears.push(self.ear(corner));
        Ok((self.turn(corner) >= 0.0).then_some(ears))
    }

    /// Returns the triangle of a corner and its neighbours.
    fn ear(&self, corner: u32) -> [u32; 3] {
        [self.before[corner as usize], corner, self.behind[corner as usize]]
    }

    /// Returns twice the area of the ear of a corner, zero where it is rounding; negative where the
    /// polygon turns right.
    fn turn(&self, corner: u32) -> f64 {
        let [a, b, c] = self.ear(corner).map(|i| self.points[i as usize]);
        let area = (b - a).perp_dot(c - a);
        if area.abs() <= ROUNDING * (b - a).length() * (c - a).length() { 0.0 } else { area }
    }

    /// Whether no other corner stands in an ear.
    fn is_free(&mut self, corner: u32) -> Result<bool, Intricate> {
        let ear = self.ear(corner).map(|i| self.points[i as usize]);
        let [a, b, c] = ear;
        let (low, high) = (a.min(b).min(c), a.max(b).max(c));
        let x = |i: u32| self.points[i as usize].x;
        let from = self.blockers.partition_point(|&i| x(i) < low.x);
        let near = self.blockers[from..].iter().take_while(|&&i| x(i) <= high.x);
        let mut looked = 0;
        let is_within = |&&i: &&u32| {
            looked += 1;
            let p = self.points[i as usize];
            let side = |from: DVec2, to: DVec2| (to - from).perp_dot(p - from) >= 0.0;
            (low.y..=high.y).contains(&p.y)
                && side(a, b)
                && side(b, c)
                && side(c, a)
                && !ear.contains(&p)
                && self.behind[i as usize] != i
                && self.turn(i) <= 0.0
        };
        let is_free = near.clone().find(is_within).is_none();
        self.pay(looked)?;
        Ok(is_free)
    }

    /// Takes a corner out, and returns where to go on: not at its neighbour, whose ear is thin.
    fn clip(&mut self, corner: u32) -> u32 {
        let [before, _, behind] = self.ear(corner);
        self.behind[before as usize] = behind;
        self.before[behind as usize] = before;
        self.behind[corner as usize] = corner;
        self.left -= 1;
        self.behind[behind as usize]
    }

    /// Forgets the corners that stand in no way any more.
    fn drop_blockers(&mut self) {
        let mut blockers = std::mem::take(&mut self.blockers);
        blockers.retain(|&i| self.behind[i as usize] != i && self.turn(i) <= 0.0);
        self.blockers = blockers;
    }

    fn pay(&mut self, cost: u64) -> Result<(), Intricate> {
        self.cost = self.cost.checked_sub(cost).ok_or(Intricate(self.points.len()))?;
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::{Randomness, Stream};

    fn fan(count: usize) -> Vec<[u32; 3]> {
        (1..count as u32 - 1).map(|i| [0, i, i + 1]).collect()
    }

    /// Cuts a polygon in the plane z = x + 2 y, seen from above; its triangles.
    fn cut_of(points: &[[f64; 2]]) -> Vec<[u32; 3]> {
        let positions: Vec<DVec3> =
            points.iter().map(|&[x, y]| DVec3::new(x, y, x + 2.0 * y)).collect();
        let mut faces = fan(points.len());
        cut(&positions, &mut faces).expect("simple enough");
        faces
    }

    /// Checks that the triangles of a polygon look up, have its edges once and all others twice.
    fn check(points: &[[f64; 2]]) {
        let faces = cut_of(points);
        let point = |i: u32| DVec2::from_array(points[i as usize]);
        let area = |&[a, b, c]: &[u32; 3]| (point(b) - point(a)).perp_dot(point(c) - point(a));
        assert!(faces.iter().all(|face| area(face) >= -1e-12), "{points:?} {faces:?}");
        let mut edges: Vec<[u32; 2]> =
            faces.iter().flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]]).collect();
        for i in 0..points.len() as u32 {
            let side = [i, (i + 1) % points.len() as u32];
            let at = edges.iter().position(|e| *e == side).expect("a side of the polygon");
            edges.swap_remove(at);
        }
        edges.sort_unstable();
        let back = |e: &[u32; 2]| edges.binary_search(&[e[1], e[0]]).is_ok();
        assert!(edges.iter().all(back), "{points:?} {faces:?}");
    }

    /// A star of so many spikes whose first corner is within or a tip.
    fn star(spikes: usize, first: usize) -> Vec<[f64; 2]> {
        let corner = |i: usize| {
            let (s, c) = (std::f64::consts::PI * i as f64 / spikes as f64).sin_cos();
            let r = if i.is_multiple_of(2) { 1.0 } else { 0.4 };
            [r * c, r * s]
        };
        (first..first + 2 * spikes).map(corner).collect()
    }

    #[test]
    fn fan_is_kept_where_it_will_do() {
        let square = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
        assert_eq!(cut_of(&square), fan(4));
        // With corners in a line, from a corner that turns right, and as an arrow from its notch.
        let lined = [[0.0, 0.0], [0.1, 0.0], [0.7, 0.0], [1.0, 0.0], [1.0, 1.0], [0.3, 1.0]];
        assert_eq!(cut_of(&lined), fan(6));
        let arrow = [[0.5, 0.2], [1.0, 0.0], [0.5, 1.0], [0.0, 0.0]];
        assert_eq!(cut_of(&arrow), fan(4));
        // What crosses itself, turns back or has no area.
        for bad in [
            [[0.0, 0.0], [1.0, 1.0], [1.0, 0.0], [0.0, 0.9]],
            [[0.0, 0.0], [1.0, 0.0], [2.0, 0.0], [1.0, 0.0]],
            [[0.0, 0.0]; 4],
            [[0.0, 0.0], [1.0, f64::NAN], [1.0, 0.0], [0.0, 0.9]],
            [[0.0, 0.0], [1e200, 0.0], [1e190, 1e190], [0.0, 1e200]],
        ] {
            assert_eq!(cut_of(&bad), fan(4), "{bad:?}");
        }
    }

    #[test]
    fn polygons_that_are_not_convex_are_cut_whichever_corner_is_first() {
        let shapes = [
            vec![[0.5, 0.2], [1.0, 0.0], [0.5, 1.0], [0.0, 0.0]],
            vec![[0.0, 0.0], [2.0, 0.0], [2.0, 1.0], [1.0, 1.0], [1.0, 2.0], [0.0, 2.0]],
            // A comb, with corners in lines.
            vec![
                [0.0, 0.0],
                [1.0, 0.0],
                [2.0, 0.0],
                [3.0, 0.0],
                [3.0, 2.0],
                [2.0, 2.0],
                [2.0, 1.0],
                [1.0, 1.0],
                [1.0, 2.0],
                [0.0, 2.0],
                [0.0, 1.0],
            ],
            // A frame: a square hole, joined to the outside by an edge walked both ways.
            vec![
                [0.0, 0.0],
                [3.0, 0.0],
                [3.0, 3.0],
                [0.0, 3.0],
                [0.0, 0.0],
                [1.0, 1.0],
                [1.0, 2.0],
                [2.0, 2.0],
                [2.0, 1.0],
                [1.0, 1.0],
            ],
            star(5, 0),
            star(5, 1),
            star(40, 0),
        ];
        for mut shape in shapes {
            for _ in 0..shape.len() {
                shape.rotate_left(1);
                check(&shape);
            }
        }
    }

    #[test]
    fn random_outlines_are_cut() {
        for seed in 0..200 {
            let count = 4 + seed as usize % 60;
            let corner = |i: usize| {
                let [u, v] = Stream::new(Randomness::Pseudorandom, seed, i as u64).next_2d();
                let angle = std::f64::consts::TAU * (i as f64 + 0.9 * v) / count as f64;
                let r = 0.1 + u;
                [r * angle.cos(), r * angle.sin()]
            };
            check(&(0..count).map(corner).collect::<Vec<_>>());
        }
    }

    #[test]
    fn looking_from_below_changes_nothing() {
        for normal in [DVec3::X, DVec3::Y, DVec3::Z, -DVec3::X, -DVec3::Y, -DVec3::Z] {
            let (u, v) = normal.any_orthonormal_pair();
            let positions: Vec<DVec3> = star(5, 0).iter().map(|&[x, y]| x * u + y * v).collect();
            let mut faces = fan(10);
            cut(&positions, &mut faces).expect("simple enough");
            let area = |&[a, b, c]: &[u32; 3]| {
                let [a, b, c] = [a, b, c].map(|i| positions[i as usize]);
                (b - a).cross(c - a).dot(normal)
            };
            assert!(faces.iter().all(|face| area(face) > 0.0), "{normal}: {faces:?}");
        }
    }

    #[test]
    fn polygons_of_very_many_corners_take_no_quadratic_time() {
        let random = |i: u64| Stream::new(Randomness::Pseudorandom, 7, i).next_2d();
        let cut_of = |points: &mut dyn Iterator<Item = [f64; 2]>| {
            let positions: Vec<DVec3> = points.map(|[x, y]| DVec3::new(x, y, 0.0)).collect();
            let mut faces = fan(positions.len());
            cut(&positions, &mut faces).map(|()| faces != fan(positions.len()))
        };
        // An outline is cut; so is not a saw whose valleys are in a line, which all ears have to
        // be held against, nor what crosses itself everywhere.
        let outline = |i: u64| {
            let (s, c) = (std::f64::consts::TAU * i as f64 / 10_000.0).sin_cos();
            let r = 1.0 + 0.1 * random(i)[0];
            [r * c, r * s]
        };
        assert!(cut_of(&mut (0..10_000).map(outline)).expect("cut"));
        let teeth = 30_000;
        let base = [[0.0, -1.0], [f64::from(teeth), -1.0]];
        let saw = (0..teeth).map(|i| [f64::from(teeth - i), f64::from(i % 2)]);
        let error = cut_of(&mut base.into_iter().chain(saw)).expect_err("intricate").to_string();
        assert!(error.starts_with("a face of 30002 vertices that is not convex"), "{error}");
        assert!(!cut_of(&mut (0..20_000).map(random)).unwrap_or(false));
    }
}
