//! The lines of a sweep: which are there, and how the others are made, each kept as it comes.

use std::path::{Path, PathBuf};

use harmolux::Result;
use harmolux::io::images::png;
use harmolux::io::output::{Kind, Output};
use harmolux::io::scene_file::SceneFile;
use harmolux::io::tables::{Cell, Table};
use harmolux::scene::{Display, Exposure};
use harmolux::study::{Light, Original, Picture, Rendition, Sweep as Swept, SweepRow};

use super::{Sweep, light};
use crate::common::about::about;
use crate::common::growing::GrowingTable;
use crate::common::progress::Meter;
use crate::common::shape_file::ShapeFile;
use crate::common::{interrupt, say, shape_file};

/// A sweep under way.
pub(super) struct Run<'a> {
    verb: &'a Sweep,
    table: GrowingTable,
    key: String,
    scene: Option<SceneFile>,
    lines: Vec<Line>,
}

/// One line of the table: without what is measured, and with it.
struct Line {
    row: SweepRow,
    cells: Option<Vec<Cell>>,
}

/// The scene with the original, and how all pictures are shown.
struct Lit {
    light: Light,
    display: Display,
}

/// Returns the file of coefficients of a degree.
pub(super) fn coefficients(verb: &Sweep, degree: usize) -> PathBuf {
    verb.output.join(format!("{}-{degree}.txt", stem(verb)))
}

/// Returns the file of the picture of a degree, or of the original.
pub(super) fn picture(verb: &Sweep, degree: Option<usize>) -> PathBuf {
    let of = degree.map_or_else(|| "original".to_owned(), |degree| degree.to_string());
    verb.output.join(format!("{}-{of}.png", stem(verb)))
}

/// Returns what the shape is called.
pub(super) fn stem(verb: &Sweep) -> String {
    verb.shape.file_stem().unwrap_or_default().to_string_lossy().into_owned()
}

impl<'a> Run<'a> {
    /// Looks which lines an earlier run has done, and whether the files of the others can be
    /// written.
    pub(super) fn new(
        verb: &'a Sweep,
        mut table: GrowingTable,
        key: String,
        original: &Original,
        scene: Option<SceneFile>,
    ) -> Result<Self> {
        let takes_pictures = scene.as_ref().is_some_and(|scene| !scene.cameras.is_empty());
        let degrees = || verb.degrees.0.iter().map(|degree| Some(*degree));
        let first = std::iter::once((Rendition::Original, None));
        let series = degrees().map(|degree| (Rendition::Series, degree));
        let rivals = original.rivalled(&verb.degrees.0).into_iter();
        let rivals = rivals.map(|degree| (Rendition::Decimated, Some(degree)));
        let mut lines = Vec::new();
        for (rendition, degree) in first.chain(series).chain(rivals) {
            let row = SweepRow::new(rendition, degree);
            let is_series = rendition == Rendition::Series;
            let mut paths = Vec::new();
            if let Some(degree) = degree.filter(|_| is_series) {
                paths.push(coefficients(verb, degree));
            }
            if takes_pictures && rendition != Rendition::Decimated {
                paths.push(picture(verb, degree));
            }
            let done = table.done(&row.head(), || Ok(key.clone()))?;
            let cells = done.filter(|cells| SweepRow::of_cells(cells).is_some());
            let cells = cells.filter(|_| paths.iter().all(|path| path.is_file()));
            if cells.is_none() {
                table.leave_out(&row.head());
                paths.iter().try_for_each(|path| check(path, &table, verb.force))?;
            }
            lines.push(Line { row, cells });
        }
        table.begin()?;
        Ok(Self { verb, table, key, scene, lines })
    }

    /// Whether all lines are there.
    pub(super) fn is_complete(&self) -> bool {
        self.lines.iter().all(|line| line.cells.is_some())
    }

    /// Makes the lines that are missing: the original, the degrees, then the rivals, which are
    /// decimated from the highest degree down.
    pub(super) fn measure(&mut self, swept: &Swept, meter: &Meter) -> Result<()> {
        let lit = self.light(swept, meter)?;
        let mut rivals = None;
        let all = self.lines.len();
        let is_rival = |line: &Line| line.row.rendition == Rendition::Decimated;
        let first = self.lines.iter().position(is_rival).unwrap_or(all);
        for (done, i) in (0..first).chain((first..all).rev()).enumerate() {
            if self.lines[i].cells.is_some() {
                continue;
            }
            let row = self.lines[i].row.clone();
            let name = report_name(&row);
            meter.count(done, all, &name);
            let own = |e| about(&self.verb.shape, e);
            let cells = match (row.rendition, row.degree) {
                (Rendition::Decimated, Some(degree)) => {
                    let rivals = match &mut rivals {
                        Some(rivals) => rivals,
                        none => none.insert(swept.rivals().map_err(own)?),
                    };
                    let row = rivals.measure(degree).map_err(own)?;
                    row.map(|row| self.keep(&row, || Ok(()))).transpose()?
                }
                (Rendition::Series, Some(degree)) => {
                    Some(self.series(swept, degree, lit.as_ref()).map_err(own)?)
                }
                _ => Some(self.original(swept, lit.as_ref()).map_err(own)?),
            };
            self.lines[i].cells = cells;
            say::note(&format!("{} of {all}: {name}", done + 1));
        }
        Ok(())
    }

    /// Makes the scene ready where a line that is missing needs it.
    fn light(&mut self, swept: &Swept, meter: &Meter) -> Result<Option<Lit>> {
        let needs_light =
            |line: &Line| line.cells.is_none() && line.row.rendition != Rendition::Decimated;
        let Some(scene) = self.scene.take().filter(|_| self.lines.iter().any(needs_light)) else {
            return Ok(None);
        };
        meter.stage("rendering the original");
        let Display { exposure, tone } = scene.render.display();
        let light = light(self.verb, scene, swept.original())?;
        let pixels = light.picture().map_or(&[][..], |picture| &picture.pixels);
        let exposure = Exposure::Factor(exposure.factor(pixels)?);
        Ok(Some(Lit { light, display: Display { exposure, tone } }))
    }

    fn series(&self, swept: &Swept, degree: usize, lit: Option<&Lit>) -> Result<Vec<Cell>> {
        let (shape, mut row) = swept.measure_degree(degree)?;
        let picture = match lit {
            Some(Lit { light, display }) => {
                light.measure(&shape, &mut row)?.map(|picture| (picture, *display))
            }
            None => None,
        };
        let file = open_shape(&coefficients(self.verb, degree), &self.table, self.verb.force)?;
        self.keep(&row, || {
            file.write(&shape)?;
            let Some((picture, display)) = &picture else { return Ok(()) };
            self.write_picture(Some(degree), picture, *display)
        })
    }

    fn original(&self, swept: &Swept, lit: Option<&Lit>) -> Result<Vec<Cell>> {
        let mut row = swept.measure_original()?;
        let Some(Lit { light, display }) = lit else { return self.keep(&row, || Ok(())) };
        light.measure_original(&mut row);
        let write = |picture| self.write_picture(None, picture, *display);
        self.keep(&row, || light.picture().map_or(Ok(()), write))
    }

    fn write_picture(
        &self,
        degree: Option<usize>,
        shown: &Picture,
        display: Display,
    ) -> Result<()> {
        let [width, height] = shown.size;
        let image = png(width, height, &shown.pixels, display, None)?;
        let output = open_picture(&picture(self.verb, degree), &self.table, self.verb.force)?;
        output.write(&image.bytes)
    }

    /// Writes what a line brought: its row, and the files.
    fn keep(&self, row: &SweepRow, write: impl FnOnce() -> Result<()>) -> Result<Vec<Cell>> {
        let mut cells = row.cells();
        cells.push(self.key.as_str().into());
        self.table.append_with(&cells, write)??;
        Ok(cells)
    }

    /// Writes all lines in their order.
    pub(super) fn finish(self) -> Result<(Table, Vec<SweepRow>)> {
        let _whole = interrupt::writing();
        let cells = self.lines.into_iter().filter_map(|line| line.cells);
        let table = self.table.finish(cells.collect())?;
        let rows = table.rows().iter().filter_map(|cells| SweepRow::of_cells(cells)).collect();
        Ok((table, rows))
    }
}

/// Checks that a file of a line can be written. Where a run goes on, what this program wrote may
/// stand there: the run was ended between the files and their line.
fn check(path: &Path, table: &GrowingTable, force: bool) -> Result<()> {
    if path.extension().is_some_and(|e| e == "png") {
        return open_picture(path, table, force).map(drop);
    }
    open_shape(path, table, force).map(drop)
}

fn open_picture(path: &Path, table: &GrowingTable, force: bool) -> Result<Output> {
    let open = if table.goes_on() { Output::open_again } else { Output::open };
    open(path, &Kind::PNG, force)
}

fn open_shape(path: &Path, table: &GrowingTable, force: bool) -> Result<ShapeFile> {
    let open = if table.goes_on() { shape_file::open_again } else { shape_file::open };
    open(path, force)
}

/// Returns what a line is called.
pub(super) fn report_name(row: &SweepRow) -> String {
    match (row.rendition, row.degree) {
        (Rendition::Series, Some(degree)) => format!("degree {degree}"),
        (Rendition::Decimated, Some(degree)) => format!("mesh as degree {degree}"),
        _ => "original".to_owned(),
    }
}
