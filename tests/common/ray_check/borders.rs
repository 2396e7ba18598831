//! Rays on the borders of cube faces and of the cells of these: each must belong to one of them.
//!
//! A border is a plane p_j = c p_i through the centre. With c = +-1 it parts two faces, with c = 0
//! it halves some: the nine mirror planes of the cube. Cells of patches are cut at c = tan(pi/4 s),
//! those of the shell at c = s, s = 2k/n - 1.

use std::f64::consts::FRAC_PI_4;

use glam::DVec3;

use super::rays::Draw;
use harmolux::math::Ray;

/// Cells along one side of a face: of patches and of the shell, up to degree 64. The borders of the
/// levels above are among theirs.
const SIDES: [usize; 13] = [4, 8, 12, 16, 24, 32, 48, 64, 80, 96, 112, 128, 144];

/// By how many units in the last place a component is moved.
const ULPS: [i32; 7] = [-4, -2, -1, 0, 1, 2, 4];

/// A plane p[j] = c p[i] through the centre.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Border {
    i: usize,
    j: usize,
    c: f64,
}

impl Border {
    fn draw(draw: &mut Draw) -> Self {
        let i = draw.below(3);
        Self { i, j: (i + 1 + draw.below(2)) % 3, c: ratio(draw) }
    }

    /// Returns the point moved along one axis onto the plane.
    fn onto(self, mut point: DVec3) -> DVec3 {
        point[self.j] = self.c * point[self.i];
        point
    }
}

/// Makes a ray in a border, along a line where two of them meet, or from a border to anywhere. Half
/// of the rays are exactly there, of the others every component is off by up to 4 units in the last
/// place.
pub(super) fn on_border(draw: &mut Draw, radius: f64) -> Ray {
    let border = Border::draw(draw);
    let reach = 3.0 * radius * draw.unit();
    let ray = match draw.below(5) {
        0 => {
            let [from, to] = [3.0 * radius, reach].map(|r| border.onto(r * draw.direction()));
            Ray::new(from, unit(to - from))
        }
        1 => Ray::new(border.onto(reach * draw.direction()), unit(border.onto(draw.direction()))),
        2 => {
            let along = unit(line(draw));
            let from = if draw.below(8) == 0 { DVec3::ZERO } else { reach * along };
            Ray::new(from, if draw.coin() { along } else { -along })
        }
        3 => {
            let along = unit(border.onto(line(draw)));
            Ray::new(border.onto(radius * draw.unit() * draw.direction()) - reach * along, along)
        }
        _ => Ray::new(border.onto(reach * draw.direction()), draw.direction()),
    };
    if draw.coin() {
        return ray;
    }
    let mut moved = |v: DVec3| DVec3::from_array(v.to_array().map(|x| off(x, draw)));
    Ray { origin: moved(ray.origin), direction: moved(ray.direction), ..ray }
}

/// Draws the c of a border: that of a face three times in four.
fn ratio(draw: &mut Draw) -> f64 {
    let share = |draw: &mut Draw| {
        let side = SIDES[draw.below(SIDES.len())];
        2.0 * draw.below(side + 1) as f64 / side as f64 - 1.0
    };
    match draw.below(8) {
        0 | 1 => 1.0,
        2 | 3 => -1.0,
        4 | 5 => [0.0, -0.0][draw.below(2)],
        6 => (FRAC_PI_4 * share(draw)).tan(),
        _ => share(draw),
    }
}

/// Draws a line where borders meet: through the middle, an edge or a corner of a face or of a cell.
fn line(draw: &mut Draw) -> DVec3 {
    let mut along = DVec3::from_array(std::array::from_fn(|_| ratio(draw)));
    along[draw.below(3)] = if draw.coin() { 1.0 } else { -1.0 };
    along
}

fn unit(vector: DVec3) -> DVec3 {
    vector.try_normalize().unwrap_or(DVec3::X)
}

/// Returns a number next to `x`.
fn off(x: f64, draw: &mut Draw) -> f64 {
    let ulps = ULPS[draw.below(ULPS.len())];
    let next = if ulps < 0 { f64::next_down } else { f64::next_up };
    (0..ulps.abs()).fold(x, |x, _| next(x))
}

#[cfg(test)]
mod tests {
    use super::*;
    use harmolux::math::{Randomness, Stream};

    #[test]
    fn every_mirror_plane_has_rays_in_it_and_next_to_it() {
        let rays: Vec<Ray> = (0..4000)
            .map(|i| on_border(&mut Draw(Stream::new(Randomness::Pseudorandom, 3, i)), 1.0))
            .collect();
        for (i, j) in [(0, 1), (1, 2), (2, 0)] {
            for c in [1.0, -1.0, 0.0] {
                let gap = |v: DVec3| (v[j] - c * v[i]).abs();
                let gaps = || rays.iter().map(|ray| gap(ray.origin).max(gap(ray.direction)));
                let exact = gaps().filter(|gap| *gap == 0.0).count();
                let near = gaps().filter(|gap| *gap > 0.0 && *gap <= 1e-14).count();
                assert!(exact > 100 && near > 100, "{i} {j} {c}: {exact} {near}");
            }
        }
        assert!(rays.iter().any(|ray| ray.origin == DVec3::ZERO));
        assert!(rays.iter().all(|ray| (ray.direction.length() - 1.0).abs() <= 1e-14));
    }
}
