//! What a shape costs in bytes, form by form: the mesh, its coefficients as text, all bits of them,
//! f32, and the compact form with an added RMS error of a fifth, a tenth and a fiftieth of the
//! truncation error. `docs/how/compact.md` shows the table of the head.
//!
//!     cargo run --release --features experiments --example storage -- data/head.obj

use std::path::Path;

use harmolux::Result;
use harmolux::fit::Shape;
use harmolux::fit::{FitSettings, fit, mesh_bytes, series_bytes};
use harmolux::io::coefficients::compact::{self, Tolerance};
use harmolux::io::coefficients::{binary, shtools_text};
use harmolux::io::meshes;
use harmolux::sh::{Coefficients, Convention};

const DEGREES: [usize; 6] = [4, 8, 16, 32, 64, 128];
const SHARES: [f64; 3] = [5.0, 10.0, 50.0];

fn main() -> Result<()> {
    let path = std::env::args_os().nth(1).unwrap_or_else(|| "data/head.obj".into());
    let mesh = meshes::read(Path::new(&path))?;
    let settings = FitSettings::of_degree(128);
    let fit = fit(&mesh, &settings)?;
    println!(
        "the mesh, f32 and u32: {} B; all coefficients about {}",
        mesh_bytes(fit.mesh_size),
        fit.centre
    );
    println!(
        "                    bytes                       added RMS 1/5 of \
         truncation     1/10     1/50"
    );
    println!(
        "  l truncation       text  binary     f32   compact  mesh/compact     added  compact  \
         compact"
    );
    for lmax in DEGREES {
        let shape = Shape { centre: fit.centre, ..Shape::new(fit.coefficients.truncated(lmax)) };
        let truncation = truncation(&fit.coefficients, lmax, fit.error.rms);
        let [fifth, tenth, fiftieth] =
            SHARES.map(|share| compact::encode(&shape, Tolerance::Metres(truncation / share)));
        let (fifth, percent) = (fifth?, 100.0 / fit.coefficients.mean());
        println!(
            "{lmax:3} {:8.3} % {:10} {:7} {:7} {:9} {:13.0} {:7.4} % {:8} {:8}",
            percent * truncation,
            shtools_text::write(&shape, Convention::default())?.len(),
            binary::encode(&shape)?.len(),
            series_bytes(lmax),
            fifth.bytes.len(),
            mesh_bytes(fit.mesh_size) as f64 / fifth.bytes.len() as f64,
            percent * fifth.rms,
            tenth?.bytes.len(),
            fiftieth?.bytes.len()
        );
    }
    Ok(())
}

/// Returns the RMS error of a series cut at `lmax`, by Parseval from the finest fit and what that
/// one leaves.
fn truncation(finest: &Coefficients, lmax: usize, left: f64) -> f64 {
    let tail =
        (lmax + 1..=finest.lmax()).map(|l| finest.degree_deviation(l).powi(2) / (2 * l + 1) as f64);
    (left * left + tail.sum::<f64>()).sqrt()
}
