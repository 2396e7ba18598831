//! Points that stand in rows and columns on a plane, found from their positions alone.

use glam::DVec3;

use crate::{Error, Result};

/// How far a point may be from its node, in spacings: less than the eye can see in a picture of the
/// grid.
const TOLERANCE: f64 = 0.01;

/// Distinguishes points that are one, and lines from planes, relative to the extent of all.
const TINY: f64 = 1e-9;

/// Describes a rectangular lattice as it is seen from the side to which its points look.
#[derive(Debug, Clone, PartialEq)]
pub struct Lattice {
    /// The node at the lower left, metres.
    pub origin: DVec3,
    /// The direction of rows, to the right, of length 1.
    pub right: DVec3,
    /// The direction of columns, upwards, of length 1; `right` x `up` looks to the observer.
    pub up: DVec3,
    /// The distance of nodes along rows and along columns, metres.
    pub spacing: [f64; 2],
    /// The number of nodes in a row and in a column, each at least 2.
    pub size: [usize; 2],
    /// The node of each point, row by row from the lower left.
    pub nodes: Vec<usize>,
}

impl Lattice {
    /// Finds the lattice of points whose side to look at is that of `facing` (of any length; zero
    /// where nothing is known).
    ///
    /// Upright and tilted lattices have as `up` the axis that rises most, horizontal ones as
    /// `right` the axis that is nearest to +x: a floor seen from above has +x to the right and +y
    /// up. Nodes without a point are allowed up to half of all.
    ///
    /// # Errors
    /// [`Error::Geometry`] says why the points are no lattice of at least 2 x 2.
    pub fn of(points: &[DVec3], facing: DVec3) -> Result<Self> {
        let (normal, extent) = plane(points, facing).map_err(Error::Geometry)?;
        // The nearest neighbour of a point is along an axis, unless neighbours are missing.
        let seeds = [0, points.len() / 2, points.len() - 1];
        let found = seeds.map(|seed| Self::along(way(points, seed, extent)?, points, normal));
        let [first, second, third] = found;
        first.or_else(|fault| second.or(third).map_err(|_| fault)).map_err(Error::Geometry)
    }

    /// Returns where a node is, metres; fractions are between nodes.
    pub fn at(&self, column: f64, row: f64) -> DVec3 {
        self.origin + self.right * (column * self.spacing[0]) + self.up * (row * self.spacing[1])
    }

    /// Sorts points into the lattice that has this way between two neighbours.
    fn along(way: DVec3, points: &[DVec3], normal: DVec3) -> Found<Self> {
        let [right, up] = upright(way.reject_from_normalized(normal).normalize_or_zero(), normal);
        let gap = way.length() * TOLERANCE;
        let first = points[0];
        if let Some(off) = points.iter().find(|p| (**p - first).dot(normal).abs() > gap) {
            return Err(format!("the point {} is not in the plane of the others", place(*off)));
        }
        let coordinates = |axis: DVec3| points.iter().map(move |p| (*p - first).dot(axis));
        let columns = Steps::of(coordinates(right).collect(), gap, "columns")?;
        let rows = Steps::of(coordinates(up).collect(), gap, "rows")?;
        let size = [columns.count, rows.count];
        if 2 * points.len() < size[0].saturating_mul(size[1]) {
            return Err("they do not stand in rows and columns at even distances".to_owned());
        }
        let places = coordinates(right).zip(coordinates(up));
        let nodes = places.map(|(x, y)| rows.index(y) * size[0] + columns.index(x));
        let nodes: Vec<usize> = nodes.collect();
        let mut taken = vec![false; size[0] * size[1]];
        let is_taken = |(_, node): &(_, &usize)| std::mem::replace(&mut taken[**node], true);
        if let Some((point, _)) = points.iter().zip(&nodes).find(is_taken) {
            return Err(format!("two points stand at the same place, {}", place(*point)));
        }
        let origin = first + right * columns.start + up * rows.start;
        Ok(Self { origin, right, up, spacing: [columns.step, rows.step], size, nodes })
    }
}

/// What was found, or why it was not.
type Found<T> = std::result::Result<T, String>;

/// Returns the normal of the plane of points and the extent of them.
fn plane(points: &[DVec3], facing: DVec3) -> Found<(DVec3, f64)> {
    if points.len() < 4 {
        return Err(format!("{} points are no grid, which has at least 2 x 2", points.len()));
    }
    if !points.iter().all(|p| p.is_finite()) {
        return Err("a point has a coordinate that is not finite".to_owned());
    }
    let first = points[0];
    let far = |distance: &dyn Fn(DVec3) -> f64| {
        points.iter().copied().fold(first, |a, b| if distance(b) > distance(a) { b } else { a })
    };
    let end = far(&|p| p.distance_squared(first));
    let extent = end.distance(first);
    let along = (end - first).normalize_or_zero();
    let aside = |p: DVec3| (p - first).reject_from_normalized(along).length();
    let side = far(&aside);
    if aside(side) <= TINY * extent || extent == 0.0 {
        return Err("the points stand in one line".to_owned());
    }
    let normal = along.cross(side - first).normalize();
    let toward = normal.dot(facing.normalize_or_zero());
    let turned = if toward.abs() > 1e-6 { toward < 0.0 } else { normal.z < 0.0 };
    Ok((if turned { -normal } else { normal }, extent))
}

/// Returns the way from a point to its nearest neighbour.
fn way(points: &[DVec3], seed: usize, extent: f64) -> Found<DVec3> {
    let here = points[seed];
    let others = points.iter().enumerate().filter(|(i, _)| *i != seed);
    let ways = others.map(|(_, p)| *p - here);
    let way = ways.min_by(|a, b| a.length_squared().total_cmp(&b.length_squared()));
    way.filter(|way| way.length() > TINY * extent)
        .ok_or_else(|| format!("two points stand at the same place, {}", place(here)))
}

/// Turns an axis by quarters until the picture stands upright.
fn upright(axis: DVec3, normal: DVec3) -> [DVec3; 2] {
    let quarter = normal.cross(axis);
    let level = normal.z.abs() > 1.0 - TINY;
    // A trace of the other axis decides between two that are alike.
    let rank = |right: DVec3| {
        let up = normal.cross(right);
        if level { right.x + 1e-6 * right.y } else { up.z + 1e-6 * right.x }
    };
    let turns = [axis, quarter, -axis, -quarter];
    let right = turns.into_iter().fold(axis, |a, b| if rank(b) > rank(a) { b } else { a });
    [right, normal.cross(right)].map(cleaned)
}

/// Takes what rounding has left out of a direction, so that a floor's x axis is (1, 0, 0).
fn cleaned(direction: DVec3) -> DVec3 {
    let clean = |x: f64| if x.abs() <= TINY { 0.0 } else { x };
    DVec3::from_array(direction.to_array().map(clean)).normalize_or_zero()
}

/// Coordinates at even distances.
struct Steps {
    start: f64,
    step: f64,
    count: usize,
}

impl Steps {
    fn of(mut coordinates: Vec<f64>, gap: f64, name: &str) -> Found<Self> {
        coordinates.sort_by(f64::total_cmp);
        let apart = coordinates.windows(2).filter(|pair| pair[1] - pair[0] > gap);
        let count = apart.count() + 1;
        let (start, end) = match coordinates[..] {
            [start, .., end] if count > 1 => (start, end),
            _ => return Err("the points stand in one line".to_owned()),
        };
        let steps = Self { start, step: (end - start) / (count - 1) as f64, count };
        let off = |x: &f64| {
            let node = start + steps.index(*x) as f64 * steps.step;
            (x - node).abs() > TOLERANCE * steps.step
        };
        if coordinates.iter().any(off) {
            return Err(format!("their {name} are not at even distances"));
        }
        Ok(steps)
    }

    fn index(&self, coordinate: f64) -> usize {
        (((coordinate - self.start) / self.step).round() as usize).min(self.count - 1)
    }
}

fn place(p: DVec3) -> String {
    format!("({}, {}, {})", p.x, p.y, p.z)
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DQuat;

    /// Three columns and two rows, 0.5 and 0.8 apart.
    fn six() -> Vec<DVec3> {
        (0..6).map(|i| DVec3::new(f64::from(i % 3) * 0.5, f64::from(i / 3) * 0.8, 0.0)).collect()
    }

    fn fault(points: &[DVec3]) -> String {
        Lattice::of(points, DVec3::Z).expect_err("refused").to_string()
    }

    #[test]
    fn what_is_no_grid_is_refused_with_the_reason() {
        assert!(fault(&[]).contains("0 points are no grid"));
        assert!(fault(&[DVec3::ZERO; 5]).contains("in one line"));
        let line: Vec<DVec3> = (0..5).map(|i| DVec3::splat(f64::from(i))).collect();
        assert!(fault(&line).contains("in one line"));
        let mut twice = six();
        twice.push(twice[4]);
        assert!(fault(&twice).contains("same place"), "{}", fault(&twice));
        let mut bent = six();
        bent[5].z = 0.3;
        assert!(fault(&bent).contains("not in the plane"), "{}", fault(&bent));
        let mut uneven = six();
        uneven[2].x = 1.3;
        uneven[5].x = 1.3;
        assert!(fault(&uneven).contains("columns are not at even distances"), "{}", fault(&uneven));
        let scattered: Vec<DVec3> =
            (0..12).map(|i| DVec3::new(f64::from(i).sin(), f64::from(3 * i).cos(), 0.0)).collect();
        assert!(fault(&scattered).contains("even distances"), "{}", fault(&scattered));
        let mut endless = six();
        endless[0].x = f64::NAN;
        assert!(fault(&endless).contains("not finite"));
    }

    #[test]
    fn floor_has_x_to_the_right_and_y_up_in_any_order() {
        for shift in 0..6 {
            let mut points = six();
            points.rotate_left(shift);
            let lattice = Lattice::of(&points, DVec3::Z).expect("a grid");
            assert_eq!((lattice.size, lattice.right, lattice.up), ([3, 2], DVec3::X, DVec3::Y));
            assert!((lattice.spacing[0] - 0.5).abs() <= 1e-15);
            for (point, node) in points.iter().zip(&lattice.nodes) {
                let there = lattice.at((node % 3) as f64, (node / 3) as f64);
                assert!(there.distance(*point) <= 1e-15);
            }
        }
    }

    #[test]
    fn planes_are_seen_from_the_side_they_look_to() {
        let cases = [
            // A ceiling, seen from below.
            (DVec3::NEG_Z, DVec3::X, DVec3::NEG_Y),
            // Walls, upright.
            (DVec3::X, DVec3::Y, DVec3::Z),
            (DVec3::NEG_X, DVec3::NEG_Y, DVec3::Z),
            (DVec3::NEG_Y, DVec3::X, DVec3::Z),
        ];
        for (normal, right, up) in cases {
            let points: Vec<DVec3> = six().iter().map(|p| up * p.x - right * p.y).collect();
            let lattice = Lattice::of(&points, normal).expect("a grid");
            assert_eq!((lattice.right, lattice.up, lattice.size), (right, up, [2, 3]), "{normal}");
        }
    }

    #[test]
    fn tilted_grid_far_away_with_gaps_is_found() {
        let turn = DQuat::from_rotation_z(0.4) * DQuat::from_rotation_x(0.9);
        let at = DVec3::new(1e3, -2e3, 5.0);
        let full: Vec<DVec3> = (0..35)
            .map(|i| DVec3::new(f64::from(i % 7) * 0.3, f64::from(i / 7) * 0.2, 0.0))
            .collect();
        let points: Vec<DVec3> = full
            .iter()
            .enumerate()
            .filter(|(i, _)| i % 5 != 3)
            .map(|(_, p)| turn * *p + at)
            .collect();
        let lattice = Lattice::of(&points, turn * DVec3::Z).expect("a grid");
        assert_eq!(lattice.size, [7, 5]);
        assert!(lattice.right.distance(turn * DVec3::X) <= 1e-9 && lattice.up.z > 0.7);
        // Measures that look sideways leave the side open: upwards then.
        assert!(Lattice::of(&six(), DVec3::X).is_ok_and(|l| l.up == DVec3::Y));
    }

    #[test]
    fn grid_turned_on_the_floor_takes_the_axis_nearest_to_x() {
        for degrees in [10.0_f64, 44.0, 45.0, 46.0, 135.0, 200.0] {
            let turn = DQuat::from_rotation_z(degrees.to_radians());
            let points: Vec<DVec3> = six().iter().map(|p| turn * *p).collect();
            let lattice = Lattice::of(&points, DVec3::Z).expect("a grid");
            assert!(lattice.right.x >= 0.5_f64.sqrt() - 1e-9, "{degrees}: {}", lattice.right);
        }
    }
}
