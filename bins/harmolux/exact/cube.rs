//! The cube with a point source in its middle, CIE 171's case 5.8.

use clap::Args;
use harmolux::Result;
use harmolux::exact::{Cube, cie171};

use super::sheet::{Column, Sheet, Style};
use crate::common::values::numbers;

/// The points of the references on a face of 4 m, metres from its middle: from there towards an
/// edge and into a corner.
const POINTS: [[f64; 2]; 7] =
    [[0.0, 0.0], [0.5, 0.5], [1.0, 0.0], [1.0, 1.0], [1.5, 1.5], [1.9, 1.9], [1.99, 1.99]];
/// The edge of the cube that `POINTS` are for, metres.
const EDGE: f64 = 4.0;

/// A cube of one reflectance with an isotropic point source in its middle
///
/// Gives the illuminance at points of a face, counted from its middle along its edges. Without
/// options: 4 m, 10 000 lm, reflectance 0.5. The mean indirect illuminance over all faces, rho
/// flux/[A (1 - rho)], stands beside it.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  harmolux exact cube
  harmolux exact cube --edge 3 --flux 5000 --reflectance 0.7 --at 0,0 --at 1,0.5")]
pub(crate) struct CubeRoom {
    /// The length of an edge, metres
    #[arg(long, value_name = "METRES", default_value_t = EDGE)]
    edge: f64,
    /// The flux of the source, lm
    #[arg(long, value_name = "LM", default_value_t = cie171::SOURCE_FLUX)]
    flux: f64,
    /// Reflectances, each a cube of its own
    #[arg(long, value_name = "RHO,...", value_delimiter = ',', default_value = "0.5")]
    reflectance: Vec<f64>,
    /// A point, metres from the middle of the face; may be repeated [default: seven from the middle
    /// into a corner]
    #[arg(long, value_name = "X,Y", allow_hyphen_values = true, value_parser = numbers::<2>)]
    at: Vec<[f64; 2]>,
}

/// CIE 171, case 5.8: interreflection in a cube of 4 m with 10 000 lm in its middle
///
/// The report asks for the mean indirect illuminance, rho flux/[A (1 - rho)], which is exact as a
/// mean over all faces and at no single point: it stands in a column of its own.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  harmolux exact cie171-5.8
  harmolux exact cie171-5.8 --reflectance 0.1,0.3,0.5,0.7,0.9 --at 0,0")]
pub(crate) struct Interreflection {
    /// Reflectances, each a cube of its own
    #[arg(long, value_name = "RHO,...", value_delimiter = ',', default_value = "0.5,0.8")]
    reflectance: Vec<f64>,
    /// A point, metres from the middle of the face; may be repeated [default: seven from the middle
    /// into a corner]
    #[arg(long, value_name = "X,Y", allow_hyphen_values = true, value_parser = numbers::<2>)]
    at: Vec<[f64; 2]>,
}

impl CubeRoom {
    pub(super) fn solve(&self) -> Result<Sheet> {
        let (edge, flux) = (self.edge, self.flux);
        let cubes = self.reflectance.iter().map(|&reflectance| Cube { edge, flux, reflectance });
        let scaled = POINTS.map(|point| point.map(|c| c * (edge / EDGE)));
        let points = if self.at.is_empty() { &scaled } else { self.at.as_slice() };
        sheet(cubes, points, ["mean_indirect_lx", "mean indirect lx"])
    }
}

impl Interreflection {
    pub(super) fn solve(&self) -> Result<Sheet> {
        let cubes = self.reflectance.iter().map(|&rho| cie171::interreflection(rho));
        let points = if self.at.is_empty() { &POINTS } else { self.at.as_slice() };
        sheet(cubes, points, ["published_indirect_lx", "CIE 171: indirect lx"])
    }
}

/// Tabulates cubes at points; the mean goes by this name and heading.
fn sheet(
    cubes: impl Iterator<Item = Cube>,
    points: &[[f64; 2]],
    [name, heading]: [&str; 2],
) -> Result<Sheet> {
    let lux = Style::Decimals(3);
    let mut sheet = Sheet::new([
        Column::new("reflectance", "reflectance", Style::Given),
        Column::new("x_m", "x m", Style::Given),
        Column::new("y_m", "y m", Style::Given),
        Column::new("direct_lx", "direct lx", lux),
        Column::new("indirect_lx", "indirect lx", lux),
        Column::new("illuminance_lx", "E lx", lux),
        Column::new(name, heading, lux),
    ]);
    for cube in cubes {
        let (light, mean) = (cube.solve()?, cube.mean_indirect()?);
        for &[x, y] in points {
            let (direct, indirect) = (cube.direct(x, y)?, light.indirect(x, y)?);
            let row = [cube.reflectance, x, y, direct, indirect, direct + indirect, mean];
            sheet.push(row.map(Into::into));
        }
    }
    sheet.note(
        "the last column is the mean over all faces, exact as such and the same for every point",
    );
    Ok(sheet)
}
