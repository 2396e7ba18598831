//! Grids of sensors: from what a scene file says to points, in the cell centres of what the border
//! leaves.

use glam::DVec3;

use crate::Result;
use crate::io::scene_file::{
    BoxFace, BoxSpec, GridLayout, GridPlace, GridSpec, LineLayout, LineSpec, ObjectSpec, SceneFile,
};
use crate::math::Aabb;
use crate::scene::Sensor;

/// A rectangle to lay a grid on.
pub(super) struct Field {
    pub(super) corner: DVec3,
    pub(super) edges: [DVec3; 2],
    pub(super) normal: DVec3,
}

/// Lays the sensors of a grid out; a grid at a height covers `extent`. Empty when the border leaves
/// nothing.
///
/// # Errors
/// What `check` says of their number.
pub(super) fn sensors(
    grid: &GridSpec,
    file: &SceneFile,
    extent: Aabb,
    check: impl Fn(f64) -> Result<()>,
) -> Result<Vec<Sensor>> {
    let Some(field) = field(&grid.place, file, extent) else { return Ok(Vec::new()) };
    let lengths = field.edges.map(|e| e.length() - 2.0 * grid.border);
    if lengths.iter().any(|l| *l <= 0.0 || !l.is_finite()) {
        return Ok(Vec::new());
    }
    let units = field.edges.map(DVec3::normalize);
    let counts = counts(grid.layout, lengths);
    check(f64::from(counts[0]) * f64::from(counts[1]))?;
    let along = |axis: usize, i: u32| {
        let fraction = (f64::from(i) + 0.5) / f64::from(counts[axis]);
        (grid.border + fraction * lengths[axis]) * units[axis]
    };
    let rows = 0..counts[1];
    Ok(rows
        .flat_map(|j| (0..counts[0]).map(move |i| (i, j)))
        .map(|(i, j)| Sensor {
            measure: grid.measure,
            ..Sensor::plane(field.corner + along(0, i) + along(1, j), field.normal)
        })
        .collect())
}

/// Lays the sensors of a line out, from one end to the other.
///
/// # Errors
/// What `check` says of their number.
pub(super) fn along(line: &LineSpec, check: impl Fn(f64) -> Result<()>) -> Result<Vec<Sensor>> {
    let LineSpec { from, to, normal, measure, layout } = *line;
    let count = match layout {
        // A length that is a multiple of the spacing but for roundings has no point more.
        LineLayout::Spacing(spacing) => (from.distance(to) / spacing - 1e-9).ceil().max(1.0) + 1.0,
        LineLayout::Count(count) => f64::from(count),
    };
    check(count)?;
    let place = |i: u32| from.lerp(to, f64::from(i) / (count - 1.0));
    Ok((0..count as u32).map(|i| Sensor { measure, ..Sensor::plane(place(i), normal) }).collect())
}

fn field(place: &GridPlace, file: &SceneFile, extent: Aabb) -> Option<Field> {
    match place {
        GridPlace::Face { object, face } => match file.objects.get(object)? {
            ObjectSpec::Box(spec) => Some(face_of(spec, *face)),
            _ => None,
        },
        GridPlace::Rectangle { object } => match file.objects.get(object)? {
            ObjectSpec::Rectangle(spec) => Some(Field {
                corner: spec.corner,
                edges: [spec.edge_u, spec.edge_v],
                normal: spec.edge_u.cross(spec.edge_v).normalize(),
            }),
            _ => None,
        },
        GridPlace::Height(z) => extent.is_finite().then(|| Field {
            corner: DVec3::new(extent.min.x, extent.min.y, *z),
            edges: [DVec3::X * extent.extent().x, DVec3::Y * extent.extent().y],
            normal: DVec3::Z,
        }),
    }
}

/// Returns a face of a box, on the side its normal points to.
pub(super) fn face_of(spec: &BoxSpec, face: BoxFace) -> Field {
    let axis = face.axis();
    let upper = matches!(face, BoxFace::XMax | BoxFace::YMax | BoxFace::ZMax);
    let extent = spec.max - spec.min;
    let mut corner = spec.min;
    corner[axis] = if upper { spec.max[axis] } else { spec.min[axis] };
    let others: [usize; 2] = [[1, 2], [0, 2], [0, 1]][axis];
    let outward = if upper { DVec3::AXES[axis] } else { -DVec3::AXES[axis] };
    Field {
        corner,
        edges: others.map(|i| extent[i] * DVec3::AXES[i]),
        normal: if spec.inward { -outward } else { outward },
    }
}

/// Counts the cells along both edges.
fn counts(layout: GridLayout, lengths: [f64; 2]) -> [u32; 2] {
    let cells = |x: f64| (x as u32).max(1);
    match layout {
        GridLayout::Count(counts) => counts,
        GridLayout::Spacing(size) => lengths.map(|l| cells((l / size - 1e-9).ceil())),
        GridLayout::En12464 => {
            let size = en12464_spacing(lengths);
            lengths.map(|l| cells((l / size).round()))
        }
    }
}

/// Returns the largest cell by EN 12464-1: p = 0.2 * 5^(log10 d), at most 10 m; d is the longer
/// side, or the shorter one where the ratio is 2 or more.
fn en12464_spacing([a, b]: [f64; 2]) -> f64 {
    let (long, short) = (a.max(b), a.min(b));
    let d = if long / short >= 2.0 { short } else { long };
    (0.2 * 5.0_f64.powf(d.log10())).min(10.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Error;

    #[test]
    fn spacing_follows_the_standard() {
        // EN 12464-1, table A.1: 0.4 m -> 0.15 (rounded up there), 1 m -> 0.2, 5 m -> 0.6, 10 m ->
        // 1, 100 m -> 5.
        for (d, p) in [(1.0, 0.2), (10.0, 1.0), (100.0, 5.0)] {
            assert!((en12464_spacing([d, d]) - p).abs() <= 1e-12);
        }
        assert!((en12464_spacing([5.0, 4.0]) - 0.6).abs() <= 0.02);
        assert!((en12464_spacing([20.0, 1.0]) - 0.2).abs() <= 1e-12);
    }

    #[test]
    fn grid_on_the_floor_of_a_room_looks_up_from_cell_centres() {
        let text = "format = 1\n[materials.m.lambert]\nreflectance = 0.5\n[objects.room.box]\n\
                    min = [0, 0, 0]\nmax = [4, 5, 3]\ninward = true\nmaterial = \"m\"\n\
                    [sensors.g.grid]\non = \"room.z_min\"\nborder = 0.5\ncount = [3, 2]";
        let file = SceneFile::parse("room.toml".as_ref(), text, &[]).expect("valid");
        let Some(crate::io::scene_file::SensorSpec::Grid(grid)) = file.sensors.get("g") else {
            panic!("a grid");
        };
        let few = |count| {
            if count > 1e6 { Err(Error::Parameter(String::new())) } else { Ok(()) }
        };
        let laid = |grid: &GridSpec, extent| sensors(grid, &file, extent, few);
        let points = laid(grid, Aabb::EMPTY).expect("few");
        assert_eq!(points.len(), 6);
        assert_eq!(points[0], Sensor::plane(DVec3::new(1.0, 1.5, 0.0), DVec3::Z));
        assert_eq!(points[5].at, DVec3::new(3.0, 3.5, 0.0));
        let at_height = GridSpec { place: GridPlace::Height(0.75), ..grid.clone() };
        let extent = Aabb::new(DVec3::ZERO, DVec3::new(4.0, 5.0, 3.0));
        assert_eq!(laid(&at_height, extent).expect("few")[0].at, DVec3::new(1.0, 1.5, 0.75));
        assert!(laid(&at_height, Aabb::EMPTY).expect("none").is_empty());
        let dense = GridSpec { layout: GridLayout::Spacing(1e-5), ..at_height };
        assert!(laid(&dense, extent).is_err());
    }
}
