//! What a sweep draws: its plots and its page.

use harmolux::Result;
use harmolux::io::coefficients;
use harmolux::io::coefficients::ReadOptions;
use harmolux::io::input::Input;
use harmolux::io::output::{Kind, Output, Stage};
use harmolux::io::tables::Table;
use harmolux::plots::Figure;
use harmolux::study::{Column, Original, Page, SWEEP_FIGURES, SweepRow, sweep_figures};
use rayon::prelude::*;
use serde_json::{Value, json};

use super::report::{self, Answer};
use super::{Sweep, lines};
use crate::common::plot::PlotFormat;
use crate::common::target::write_all;

/// The files that a sweep draws.
pub(super) struct Outputs {
    plots: Vec<[Output; 2]>,
    page: Output,
}

impl Outputs {
    /// Opens the files; a run that goes on draws them anew.
    pub(super) fn open(verb: &Sweep) -> Result<Self> {
        let open = |name: String, kind: &Kind| {
            Output::open_again(&verb.output.join(name), kind, verb.force)
        };
        let plot = |name: &str| {
            Ok([open(format!("{name}.svg"), &Kind::SVG)?, open(format!("{name}.png"), &Kind::PNG)?])
        };
        let plots = SWEEP_FIGURES.into_iter().map(plot).collect::<Result<_>>()?;
        Ok(Self { plots, page: open("index.html".to_owned(), &Kind::HTML)? })
    }

    /// Draws.
    pub(super) fn write(
        self,
        verb: &Sweep,
        original: &Original,
        (table, rows): (&Table, &[SweepRow]),
        answers: &[Answer],
    ) -> Result<()> {
        let highest;
        let (series, mesh) = match original {
            Original::Mesh(mesh, _) => {
                let last = verb.degrees.0.last().copied().unwrap_or_default();
                let path = lines::coefficients(verb, last);
                highest = coefficients::read(&path, &ReadOptions::default())?;
                (&highest, Some(mesh))
            }
            Original::Series(shape) => (shape, None),
        };
        let figures = sweep_figures(rows, &series.coefficients);
        let mut page = Page::new(lines::stem(verb));
        let mut written = Vec::new();
        let (svgs, pngs): (Vec<_>, Vec<_>) =
            self.plots.into_iter().map(|[svg, png]| (svg, png)).unzip();
        // One after the other: kuva numbers what it draws.
        let shown: Vec<_> =
            figures.iter().zip(svgs.into_iter().zip(pngs)).filter(|(f, _)| !f.is_empty()).collect();
        let mut drawings = Vec::new();
        for (figure, (svg, png)) in shown {
            let drawn = figure.to_svg()?;
            page.plot(&figure.title, &drawn);
            written.push(svg.write(drawn.as_bytes()));
            drawings.push((figure, png));
        }
        let draw =
            |(figure, png): (&Figure, Output)| PlotFormat::Png.write(figure, png, Stage::Complete);
        written.par_extend(drawings.into_par_iter().map(draw));
        page.shape(&lines::stem(verb), series, mesh)?;
        if rows.iter().any(|row| !row[Column::Flip].is_nan()) {
            add_pictures(&mut page, verb)?;
        }
        page.table(columns(rows), report::json(table)?["rows"].take());
        page.answers(answers.iter().map(Answer::value).collect());
        written.push(self.page.write(page.to_html().as_bytes()));
        write_all(written)
    }
}

/// Adds the pictures that stand in the folder.
fn add_pictures(page: &mut Page, verb: &Sweep) -> Result<()> {
    let read = |degree| Input::open_file(&lines::picture(verb, degree))?.rest();
    page.original(&read(None)?)?;
    verb.degrees.0.iter().try_for_each(|l| page.picture(*l, &read(Some(*l))?))
}

/// Describes the columns in which anything is known.
fn columns(rows: &[SweepRow]) -> Value {
    let known = |column: &Column| rows.iter().any(|row| !row[*column].is_nan());
    let described = Column::ALL.into_iter().filter(known).map(|column| {
        json!({
            "name": column.name(),
            "title": column.title(),
            "unit": column.unit(),
            "scale": if column.unit() == "%" { 100 } else { 1 },
            "detail": is_detail(column),
        })
    });
    described.collect()
}

/// Whether a number is one for the table alone, not for the panel beside the shape.
fn is_detail(column: Column) -> bool {
    let name = column.name();
    let of_table = [Column::HausdorffLower, Column::RelMseEqualTime, Column::Render];
    of_table.contains(&column)
        || ["_q1", "_q3", "_noise"].iter().any(|end| name.ends_with(end))
        || name.contains("_batch_")
}
