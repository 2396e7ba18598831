//! `harmolux view`: a page that shows shapes in a browser.

use std::path::PathBuf;

use clap::Args;
use harmolux::Result;
use harmolux::fit::Shape;
use harmolux::io::coefficients::NamedShape;
use harmolux::io::input::Input;
use harmolux::io::output::{Kind, Output};
use harmolux::mesh::Mesh;
use harmolux::study::Page;
use serde_json::json;

use crate::common::exit::Code;
use crate::common::flags::SeriesReading;
use crate::common::inputs::{read_shapes, read_surface};
use crate::common::progress::Meter;
use crate::common::{paths, say};

/// Write a page that shows shapes in a browser
///
/// One file that stands for itself: no server, no network, any browser. It turns the shapes, cuts
/// them at the degree of a slider and shows their spectra; with --mesh the mesh beside the first,
/// and the difference as colours.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  harmolux view head.txt -o head.html
  harmolux view head.txt --mesh head.obj -o head.html
  harmolux view fits/*.txt -o all.html")]
pub(crate) struct View {
    /// Coefficient files, or tables with a row for each shape
    #[arg(required = true, value_name = "SHAPE")]
    pub(crate) shapes: Vec<PathBuf>,
    /// The page
    #[arg(short, long, value_name = "FILE.html")]
    pub(crate) output: PathBuf,
    /// The mesh that the first shape stands for, metres, z up
    #[arg(long, value_name = "MESH")]
    pub(crate) mesh: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) reading: SeriesReading,
    /// Replace a file that is there already
    #[arg(long)]
    pub(crate) force: bool,
}

/// Runs the verb.
pub(crate) fn run(verb: &View, as_json: bool) -> Result<Code> {
    let output = Output::open(&verb.output, &Kind::HTML, verb.force)?;
    let meter = Meter::start("reading the shapes");
    let shapes = read_shapes(&verb.shapes, &verb.reading.options())?;
    meter.stage("reading the mesh");
    let mesh = verb.mesh.as_ref().map(|path| read_surface(Input::open(path)?)).transpose()?;
    let names: Vec<String> = shapes.iter().map(NamedShape::name).collect();
    let mut page = Page::new(names.join(", "));
    if let (Some(first), Some((mesh, _))) = (shapes.first(), &mesh) {
        warn_of_a_mesh_elsewhere(&first.shape, mesh);
    }
    meter.stage("making the page");
    for (i, (shape, name)) in shapes.iter().zip(&names).enumerate() {
        let twin = mesh.as_ref().filter(|_| i == 0).map(|(mesh, _)| mesh);
        page.shape(name, &shape.shape, twin)?;
    }
    let html = page.to_html();
    output.write(html.as_bytes())?;
    drop(meter);
    if as_json {
        let mut value = json!({ "shapes": names, "bytes": html.len() });
        paths::put(&mut value, "written", &verb.output);
        say::json(&value);
    } else {
        let size = say::bytes(html.len());
        say::note(&format!("written {}, {size}: open it in a browser", verb.output.display()));
    }
    Ok(Code::Done)
}

/// Warns of a mesh whose box does not hold the centre of the shape it is shown beside.
fn warn_of_a_mesh_elsewhere(shape: &Shape, mesh: &Mesh) {
    let bounds = mesh.bounds();
    if !(bounds.min.cmple(shape.centre) & bounds.max.cmpge(shape.centre)).all() {
        let [min, max] = [bounds.min, bounds.max].map(say::point);
        say::warning(&format!(
            "the mesh, from {min} to {max} m, does not lie about the centre of the first shape, {}: \
             is it in other axes or another unit?",
            say::point(shape.centre)
        ));
    }
}
