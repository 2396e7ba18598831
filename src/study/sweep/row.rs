//! The lines of a sweep: what is measured, under which names and in which units.

use std::ops::{Index, IndexMut};

use crate::io::tables::{Cell, Table};
use crate::math::choice::choice;

/// Names whose line it is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Rendition {
    /// What is swept: the mesh, or the whole series.
    Original,
    /// The series of a degree.
    Series,
    /// The mesh decimated to the bytes of the series of a degree, both in f32.
    Decimated,
}

choice!(Rendition, "rendition":
    Original = "original" "",
    Series = "series" "",
    Decimated = "decimated" "",
);

/// Lists the columns: the variant, its name in the table, what a reader calls it, its unit ("%" is
/// a share), and whether it counts things.
macro_rules! columns {
    ($($(#[$doc:meta])* $variant:ident $name:literal $title:literal $unit:literal $whole:literal),+
     $(,)?) => {
        /// Names a column of a sweep.
        #[derive(Debug, Clone, Copy, PartialEq, Eq)]
        pub enum Column {
            $($(#[$doc])* $variant),+
        }

        impl Column {
            /// Lists all, in the order of the table.
            pub const ALL: [Self; [$(Self::$variant),+].len()] = [$(Self::$variant),+];

            /// Returns the name in tables.
            pub const fn name(self) -> &'static str {
                match self { $(Self::$variant => $name),+ }
            }

            /// Returns what a reader calls it.
            pub const fn title(self) -> &'static str {
                match self { $(Self::$variant => $title),+ }
            }

            /// Returns the unit a reader sees; "%" stands for a share of 1.
            pub const fn unit(self) -> &'static str {
                match self { $(Self::$variant => $unit),+ }
            }

            const fn is_whole(self) -> bool {
                match self { $(Self::$variant => $whole),+ }
            }
        }
    };
}

columns! {
    /// The number of coefficients, or of vertices.
    Numbers "numbers" "coefficients or vertices" "" true,
    /// The RMS radial error, relative to the mean radius.
    RelativeRms "relative_rms" "RMS error" "%" false,
    /// The largest radial error, relative to the mean radius.
    RelativeMax "relative_max" "largest error" "%" false,
    /// The Hausdorff distance from the original is not less, metres.
    HausdorffLower "hausdorff_lower_m" "Hausdorff distance, from" "m" false,
    /// The Hausdorff distance from the original is not more, metres.
    HausdorffUpper "hausdorff_upper_m" "Hausdorff distance, to" "m" false,
    /// The mean angle between normals at nearest points, degrees.
    NormalMean "normal_mean_deg" "mean angle of normals" "deg" false,
    /// The angle between normals that 95 % of the points stay below, degrees.
    Normal95 "normal_95_deg" "angle of 95 % of the normals" "deg" false,
    /// How much more volume than the original, relative to it.
    VolumeError "volume_error" "error of volume" "%" false,
    /// How much more area than the original, relative to it.
    AreaError "area_error" "error of area" "%" false,
    /// The largest relative difference of a principal moment of inertia.
    InertiaError "inertia_error" "error of inertia" "%" false,
    /// Bytes in f64: the exact form (.hxb); vertices and indices of a mesh.
    BytesF64 "bytes_f64" "in f64" "bytes" true,
    /// Bytes in f32: the coefficients; vertices and indices of a mesh.
    BytesF32 "bytes_f32" "in f32" "bytes" true,
    /// Bytes as text: coefficients as pyshtools reads them; a mesh as OBJ.
    BytesText "bytes_text" "as text" "bytes" true,
    /// Bytes compressed to a fifth of the error: .hxc; a mesh quantised and deflated.
    BytesCompact "bytes_compact" "compact" "bytes" true,
    /// Bytes of a mesh as binary STL.
    BytesStl "bytes_stl" "as STL" "bytes" true,
    /// Bytes of a mesh as binary PLY, doubles.
    BytesPly "bytes_ply" "as PLY" "bytes" true,
    /// Bytes as traced: patches and their tree; triangles and their tree.
    BytesTraced "bytes_traced" "as traced" "bytes" true,
    /// The time of the projection on one thread, milliseconds.
    Fit "fit_ms" "fit" "ms" false,
    /// The time to make it ready for rays on one thread, milliseconds.
    Prepare "prepare_ms" "preparation" "ms" false,
    /// The time of a first hit, ray by ray, nanoseconds: the median.
    Hit "hit_ns" "first hit" "ns" false,
    /// Its first quartile.
    HitLow "hit_ns_q1" "first hit, first quartile" "ns" false,
    /// Its third quartile.
    HitHigh "hit_ns_q3" "first hit, third quartile" "ns" false,
    /// The same over that of the original in turns: the median.
    HitRatio "hit_ratio" "first hit against the original" "x" false,
    /// The time of a first hit in batches, nanoseconds a ray.
    HitBatch "hit_batch_ns" "first hit, batches" "ns" false,
    /// Its first quartile.
    HitBatchLow "hit_batch_ns_q1" "first hit, batches, first quartile" "ns" false,
    /// Its third quartile.
    HitBatchHigh "hit_batch_ns_q3" "first hit, batches, third quartile" "ns" false,
    /// The same over that of the original.
    HitBatchRatio "hit_batch_ratio" "first hit, batches, against the original" "x" false,
    /// The time to tell whether anything is between two points, nanoseconds.
    Blocked "blocked_ns" "occlusion" "ns" false,
    /// Its first quartile.
    BlockedLow "blocked_ns_q1" "occlusion, first quartile" "ns" false,
    /// Its third quartile.
    BlockedHigh "blocked_ns_q3" "occlusion, third quartile" "ns" false,
    /// The same over that of the original.
    BlockedRatio "blocked_ratio" "occlusion against the original" "x" false,
    /// The same in batches, nanoseconds a ray.
    BlockedBatch "blocked_batch_ns" "occlusion, batches" "ns" false,
    /// Its first quartile.
    BlockedBatchLow "blocked_batch_ns_q1" "occlusion, batches, first quartile" "ns" false,
    /// Its third quartile.
    BlockedBatchHigh "blocked_batch_ns_q3" "occlusion, batches, third quartile" "ns" false,
    /// The same over that of the original.
    BlockedBatchRatio "blocked_batch_ratio" "occlusion, batches, against the original" "x" false,
    /// The time to move a hit onto the surface itself, nanoseconds.
    Refine "refine_ns" "refine a hit" "ns" false,
    /// Its first quartile.
    RefineLow "refine_ns_q1" "refine a hit, first quartile" "ns" false,
    /// Its third quartile.
    RefineHigh "refine_ns_q3" "refine a hit, third quartile" "ns" false,
    /// The relMSE of the picture against the original's at equal samples, the noise taken off.
    RelMse "relmse" "relMSE of the picture" "" false,
    /// What noise alone adds to it: the original with another seed.
    RelMseNoise "relmse_noise" "relMSE by noise" "" false,
    /// The relMSE at equal time, noise and all.
    RelMseEqualTime "relmse_equal_time" "relMSE at equal time" "" false,
    /// The mean FLIP of the picture against the original's.
    Flip "flip" "FLIP of the picture" "" false,
    /// The same of the original with another seed.
    FlipNoise "flip_noise" "FLIP by noise" "" false,
    /// The pixels whose middle sees the object here and not there, or the other way round.
    Silhouette "silhouette_pixels" "silhouette" "pixels" true,
    /// The time of the picture, seconds.
    Render "render_s" "picture" "s" false,
    /// The same over that of the original.
    RenderRatio "render_ratio" "picture against the original" "x" false,
    /// The largest relative difference of an illuminance at the sensors of the scene.
    LuxMax "lux_max" "largest change of illuminance" "%" false,
    /// What noise alone brings: the original with another seed.
    LuxNoise "lux_noise" "largest change of illuminance by noise" "%" false,
}

/// Holds one line of a sweep; what was not measured is NaN.
#[derive(Debug, Clone, PartialEq)]
pub struct SweepRow {
    /// Whose line it is.
    pub rendition: Rendition,
    /// The degree of the series, or of that in whose bytes a mesh is; of the original none.
    pub degree: Option<usize>,
    values: [f64; Column::ALL.len()],
}

impl Index<Column> for SweepRow {
    type Output = f64;

    fn index(&self, column: Column) -> &f64 {
        &self.values[column as usize]
    }
}

impl IndexMut<Column> for SweepRow {
    fn index_mut(&mut self, column: Column) -> &mut f64 {
        &mut self.values[column as usize]
    }
}

impl SweepRow {
    /// Starts a line on which nothing is measured.
    pub const fn new(rendition: Rendition, degree: Option<usize>) -> Self {
        Self { rendition, degree, values: [f64::NAN; Column::ALL.len()] }
    }

    /// Starts a table of such lines; `more` are columns behind them.
    pub fn table(more: &[&str]) -> Table {
        let columns = Column::ALL.map(Column::name);
        Table::new(["shape", "degree"].iter().chain(&columns).chain(more).copied())
    }

    /// Returns the first cells, which tell one line from the others.
    pub fn head(&self) -> [Cell; 2] {
        [self.rendition.name().into(), self.degree.into()]
    }

    /// Returns the cells of a line of [`SweepRow::table`].
    pub fn cells(&self) -> Vec<Cell> {
        let cell = |column: Column| match self[column] {
            value if value.is_nan() => Cell::Empty,
            value if column.is_whole() => Cell::from(value as usize),
            value => Cell::Number(value),
        };
        self.head().into_iter().chain(Column::ALL.map(cell)).collect()
    }

    /// Reads what [`SweepRow::cells`] wrote; `None` for anything else.
    pub fn of_cells(cells: &[Cell]) -> Option<Self> {
        let [Cell::Text(shape), degree, values @ ..] = cells else { return None };
        let rendition = shape.parse().ok()?;
        let mut row = Self::new(rendition, degree.number().map(|degree| degree as usize));
        for (column, cell) in Column::ALL.into_iter().zip(values) {
            row[column] = match cell {
                Cell::Empty => f64::NAN,
                other => other.number().filter(|number| number.is_finite())?,
            };
        }
        Some(row)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_survives_its_cells() {
        let mut row = SweepRow::new(Rendition::Series, Some(4));
        (row[Column::Numbers], row[Column::RelativeRms]) = (25.0, 0.1);
        let cells = row.cells();
        assert_eq!(cells.len(), SweepRow::table(&[]).header().len());
        let read = SweepRow::of_cells(&cells).expect("a line");
        assert_eq!((read.rendition, read.degree), (Rendition::Series, Some(4)));
        assert_eq!((read[Column::Numbers], read[Column::RelativeRms]), (25.0, 0.1));
        assert!(read[Column::Hit].is_nan());
        assert_eq!(SweepRow::of_cells(&["other".into(), Cell::Empty]), None);
        for damaged in ["x".into(), Cell::Number(f64::NAN)] {
            let mut cells = cells.clone();
            cells[2] = damaged;
            assert_eq!(SweepRow::of_cells(&cells), None);
        }
    }

    #[test]
    fn columns_have_names_of_their_own() {
        let mut names = Column::ALL.map(Column::name).to_vec();
        names.sort_unstable();
        names.dedup();
        assert_eq!(names.len(), Column::ALL.len());
    }
}
