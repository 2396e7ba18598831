//! `harmolux convert` from mesh to mesh.

use harmolux::io::coefficients::SeriesFormat;
use harmolux::io::input::Input;
use harmolux::io::meshes::{self, MeshFormat};
use harmolux::io::output::Output;
use harmolux::{Error, Result};
use serde_json::json;

use crate::common::exit::Code;
use crate::common::inputs::{read_surface, series_format};
use crate::common::{idle, paths, say};
use crate::convert::Convert;

/// Runs the verb when the output is a mesh; `None` when it is not.
pub(crate) fn run(verb: &Convert, as_json: bool) -> Option<Result<Code>> {
    if verb.to.is_some() || MeshFormat::of_extension(&verb.output).is_none() {
        return None;
    }
    Some(convert(verb, as_json))
}

fn convert(verb: &Convert, as_json: bool) -> Result<Code> {
    check_options(verb)?;
    let format = MeshFormat::for_writing(&verb.output)?;
    let output = Output::open(&verb.output, &format.kind(), verb.force)?;
    let mut input = Input::open(&verb.input)?;
    let holds = series_format(&mut input, &verb.reading.options())?;
    if holds.is_some_and(|format| format != SeriesFormat::SpharmPdm) {
        return Err(Error::Parameter(format!(
            "{}: these are coefficients: `harmolux mesh` makes a mesh of them",
            verb.input.display()
        )));
    }
    let mesh = read_surface(input)?.0;
    let mesh = mesh.scaled(verb.reading.metres())?;
    let bytes = meshes::encode(&mesh, format)?;
    output.write(&bytes)?;
    let [vertices, faces] = [mesh.positions().len(), mesh.triangles().len()];
    if as_json {
        let mut value = json!({
            "to": format.name(),
            "vertices": vertices,
            "faces": faces,
            "bytes": bytes.len(),
        });
        paths::put(&mut value, "read", &verb.input);
        paths::put(&mut value, "written", &verb.output);
        say::json(&value);
    } else {
        say::pairs(&[
            ("read", verb.input.display().to_string()),
            ("written", format!("{}, {}", verb.output.display(), format.name())),
            ("faces", format!("{faces}, {vertices} vertices")),
            ("size", say::bytes(bytes.len())),
        ]);
    }
    Ok(Code::Done)
}

/// Rejects what has no meaning for a mesh.
fn check_options(verb: &Convert) -> Result<()> {
    let reading = &verb.reading;
    let of_series = [
        (reading.from.is_some(), "--from"),
        (verb.to_normalisation.is_some(), "--to-normalisation"),
        (verb.to_csphase.is_some(), "--to-csphase"),
        (verb.degree.is_some(), "--degree"),
        (verb.tolerance.is_some(), "--tolerance"),
    ];
    let name = verb.output.display();
    let why = format!("{name}: this is the name of a mesh, not of coefficients");
    idle::refuse(&why, &[&reading.of_series()[..], &of_series[..]].concat())
}
