//! Where `illum` writes: a table, a plot of the lines, an array for NumPy, or a map of a surface.

use std::path::Path;

use harmolux::Result;
use harmolux::io::npy;
use harmolux::io::output::{Kind, Output, Stage};
use harmolux::io::scene_file::SceneFile;
use harmolux::io::tables::{Cell, Table};
use harmolux::plots::Figure;

use crate::common::plot::{PlotFormat, unknown_output};
use crate::common::target::Target;
use crate::illum::map::{self, MapTarget};
use crate::illum::{Group, Illum};

/// The columns of the array, which the table has too; the first six say where a sensor is, the
/// others what it measured.
pub(crate) const COLUMNS: [&str; 10] = [
    "x_m",
    "y_m",
    "z_m",
    "normal_x",
    "normal_y",
    "normal_z",
    "illuminance_lx",
    "half_width_95_lx",
    "standard_error_lx",
    "direct_lx",
];
const PLACES: usize = 6;

/// A file to write.
pub(crate) enum IllumTarget {
    Array(Output),
    Map(MapTarget),
    Other(Target),
}

impl IllumTarget {
    /// Opens a file for a table (.csv), an array (.npy), a map (.ply) or a plot (.svg, .png).
    pub(crate) fn open(path: &Path, table: &Table, file: &SceneFile, verb: &Illum) -> Result<Self> {
        let force = verb.force;
        if map::is_map(path) {
            return MapTarget::open(path, file, verb).map(Self::Map);
        }
        let has = |wanted| path.extension().is_some_and(|e| e.eq_ignore_ascii_case(wanted));
        if has("npy") {
            return Output::open(path, &Kind::NPY, force).map(Self::Array);
        }
        if has("csv") || PlotFormat::of_extension(path).is_some() {
            return Target::open(path, table, force).map(Self::Other);
        }
        Err(unknown_output(path, ".csv, .npy, .ply, .svg or .png"))
    }

    /// Returns where it goes.
    pub(crate) fn path_at(&self, stage: Stage) -> &Path {
        match self {
            Self::Array(output) => output.path_at(stage),
            Self::Map(target) => target.path_at(stage),
            Self::Other(target) => target.path_at(stage),
        }
    }

    /// Writes the table, its numbers, the map or the plot.
    pub(crate) fn write(
        self,
        (table, figure, groups): (&Table, &Figure, &[Group]),
        stage: Stage,
    ) -> Result<()> {
        match self {
            Self::Array(mut output) => {
                output.write_at(stage, &npy::rows(COLUMNS.len(), rows(table).as_flattened()))
            }
            Self::Map(target) => target.write(groups, stage),
            Self::Other(target) => target.write(table, figure, stage),
        }
    }
}

/// Takes the numbers of a table; what a sensor behind an object measured is NaN.
fn rows(table: &Table) -> Vec<[f64; 10]> {
    let place = |name: &str| table.header().iter().position(|column| column == name);
    let places = COLUMNS.map(place);
    let behind = place("behind");
    let row = |cells: &Vec<Cell>| {
        let number = |place: Option<usize>| match place.and_then(|place| cells.get(place)) {
            Some(Cell::Number(number)) => *number,
            _ => f64::NAN,
        };
        let mut numbers = places.map(number);
        let counts = behind.is_none_or(|place| cells.get(place) == Some(&Cell::Empty));
        if !counts {
            numbers[PLACES..].fill(f64::NAN);
        }
        numbers
    };
    table.rows().iter().map(row).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn array_has_the_numbers_of_the_table_and_nan_for_what_does_not_count() {
        let mut header = vec!["group"];
        header.extend(COLUMNS);
        header.extend(["non_finite_samples", "behind"]);
        let mut table = Table::new(header);
        assert!(rows(&table).is_empty());
        for behind in [Cell::Empty, "head".into()] {
            let numbers = (1..=10).map(|k| Cell::Number(f64::from(k)));
            let start = std::iter::once(Cell::from("desk"));
            table.push(start.chain(numbers).chain([Cell::Whole(0), behind]));
        }
        let rows = rows(&table);
        assert_eq!(rows[0], [1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0, 10.0]);
        assert_eq!(rows[1][..6], rows[0][..6]);
        assert!(rows[1][6..].iter().all(|v| v.is_nan()));
    }
}
