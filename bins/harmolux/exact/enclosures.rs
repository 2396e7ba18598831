//! Closed enclosures of uniform or spherical surfaces.

use clap::Args;
use harmolux::Result;
use harmolux::exact::enclosures::{
    Balance, CapAndDisc, ConcentricSpheres, IntegratingSphere, ParallelPlanes, mean_illuminance,
};
use harmolux::io::tables::Cell;

use super::sheet::{Column, Sheet, Style};
use crate::common::values::{numbers, pair};

/// To how many digits people read light here.
const LIGHT: Style = Style::Significant(10);

/// An integrating sphere of two zones with an isotropic point source on its axis
///
/// Gives the illuminance at heights over the centre, in radii: 1 is the upper pole, 0 the equator.
/// The indirect part is the same everywhere. Without options: radius 1 m, 1 lm half way up,
/// reflectance 0.9 above the equator and 0.3 below. A port is a zone of reflectance 0.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  harmolux exact sphere
  harmolux exact sphere --offset 0 --reflectance 0.95 --flux 1000 --at 0
  harmolux exact sphere --reflectance 0.95,0 --boundary -0.98      a port about the lower pole")]
pub(crate) struct Sphere {
    /// The radius, metres
    #[arg(long, value_name = "METRES", default_value_t = 1.0)]
    radius: f64,
    /// The flux of the source, lm
    #[arg(long, value_name = "LM", default_value_t = 1.0)]
    flux: f64,
    /// The height of the source over the centre, metres
    #[arg(long, value_name = "METRES", default_value_t = 0.5, allow_negative_numbers = true)]
    offset: f64,
    /// The height of the boundary of the zones over the centre, in radii
    #[arg(long, value_name = "MU", default_value_t = 0.0, allow_negative_numbers = true)]
    boundary: f64,
    /// The reflectance of both zones, or ABOVE,BELOW
    #[arg(long, value_name = "RHO", value_parser = pair, default_value = "0.9,0.3")]
    reflectance: [f64; 2],
    /// Heights over the centre, in radii, -1 to 1
    #[arg(
        long,
        value_name = "MU,...",
        value_delimiter = ',',
        allow_hyphen_values = true,
        default_value = "1,0,-1"
    )]
    at: Vec<f64>,
}

impl Sphere {
    pub(super) fn solve(&self) -> Result<Sheet> {
        let sphere = IntegratingSphere {
            radius: self.radius,
            flux: self.flux,
            offset: self.offset,
            boundary: self.boundary,
            reflectance: self.reflectance,
        };
        let mut sheet = Sheet::new([
            Column::new("height_radii", "height / R", Style::Given),
            Column::new("direct_lx", "direct lx", LIGHT),
            Column::new("indirect_lx", "indirect lx", LIGHT),
            Column::new("illuminance_lx", "E lx", LIGHT),
        ]);
        for &mu in &self.at {
            let row = [mu, sphere.direct(mu)?, sphere.indirect()?, sphere.illuminance(mu)?];
            sheet.push(row.map(Cell::Number));
        }
        Ok(sheet)
    }
}

/// A spherical cap closed by its flat disc, each emitting and reflecting uniformly
///
/// Without options: a hemisphere of reflectance 0.8 over a disc of reflectance 0.3 that emits 1
/// lm/m2.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  harmolux exact cap
  harmolux exact cap --fraction 0.9 --emission 100,0 --reflectance 0.9,0")]
pub(crate) struct Cap {
    /// The cap's share of the area of its sphere; 0.5 is the hemisphere
    #[arg(long, value_name = "SHARE", default_value_t = 0.5)]
    fraction: f64,
    /// The exitances of their own, CAP,DISC, lm/m2
    #[arg(long, value_name = "M0,M0", value_parser = numbers::<2>, default_value = "0,1")]
    emission: [f64; 2],
    /// The reflectance of both, or CAP,DISC
    #[arg(long, value_name = "RHO", value_parser = pair, default_value = "0.8,0.3")]
    reflectance: [f64; 2],
}

impl Cap {
    pub(super) fn solve(&self) -> Result<Sheet> {
        let (fraction, emission, reflectance) = (self.fraction, self.emission, self.reflectance);
        let balance = CapAndDisc { fraction, emission, reflectance }.solve()?;
        Ok(sheet(["cap", "disc"], emission, reflectance, balance))
    }
}

/// The space between two concentric spheres, each emitting and reflecting uniformly
///
/// Without options: radii 1 m and 2 m, the inner sphere of reflectance 0.4 emits 1 lm/m2, the outer
/// one has reflectance 0.7.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  harmolux exact concentric
  harmolux exact concentric --radius 0.1,3 --emission 5000,0 --reflectance 0.8")]
pub(crate) struct Concentric {
    /// The radii, INNER,OUTER, metres
    #[arg(long, value_name = "METRES,METRES", value_parser = numbers::<2>, default_value = "1,2")]
    radius: [f64; 2],
    /// The exitances of their own, INNER,OUTER, lm/m2
    #[arg(long, value_name = "M0,M0", value_parser = numbers::<2>, default_value = "1,0")]
    emission: [f64; 2],
    /// The reflectance of both, or INNER,OUTER
    #[arg(long, value_name = "RHO", value_parser = pair, default_value = "0.4,0.7")]
    reflectance: [f64; 2],
}

impl Concentric {
    pub(super) fn solve(&self) -> Result<Sheet> {
        let (radius, emission, reflectance) = (self.radius, self.emission, self.reflectance);
        let balance = ConcentricSpheres { radius, emission, reflectance }.solve()?;
        Ok(sheet(["inner", "outer"], emission, reflectance, balance))
    }
}

/// Two infinite parallel planes, each emitting and reflecting uniformly
///
/// Without options: both of reflectance 0.5, the lower one emits 1 lm/m2.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  harmolux exact planes
  harmolux exact planes --emission 0,100 --reflectance 0.2,0.7")]
pub(crate) struct Planes {
    /// The exitances of their own, LOWER,UPPER, lm/m2
    #[arg(long, value_name = "M0,M0", value_parser = numbers::<2>, default_value = "1,0")]
    emission: [f64; 2],
    /// The reflectance of both, or LOWER,UPPER
    #[arg(long, value_name = "RHO", value_parser = pair, default_value = "0.5")]
    reflectance: [f64; 2],
}

impl Planes {
    pub(super) fn solve(&self) -> Result<Sheet> {
        let (emission, reflectance) = (self.emission, self.reflectance);
        let balance = ParallelPlanes { emission, reflectance }.solve()?;
        Ok(sheet(["lower", "upper"], emission, reflectance, balance))
    }
}

/// Tabulates two surfaces that light each other.
fn sheet(names: [&str; 2], emission: [f64; 2], reflectance: [f64; 2], balance: Balance) -> Sheet {
    let mut sheet = Sheet::new([
        Column::new("surface", "surface", Style::Given),
        Column::new("emission_lm_m2", "M0 lm/m2", Style::Given),
        Column::new("reflectance", "reflectance", Style::Given),
        Column::new("illuminance_lx", "E lx", LIGHT),
        Column::new("exitance_lm_m2", "M lm/m2", LIGHT),
    ]);
    for i in 0..2 {
        let numbers = [emission[i], reflectance[i], balance.illuminance[i], balance.exitance[i]];
        sheet.push(std::iter::once(Cell::from(names[i])).chain(numbers.map(Cell::Number)));
    }
    sheet
}

/// The mean illuminance over all surfaces of a closed room of one reflectance, whatever its shape
///
/// flux/[area (1 - rho)]. Without options: 10 000 lm in a cube of 4 m and reflectance 0.5.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  harmolux exact room --flux 5000 --area 80 --reflectance 0.3,0.5,0.7")]
pub(crate) struct Room {
    /// The flux of all sources, lm
    #[arg(long, value_name = "LM", default_value_t = 10_000.0)]
    flux: f64,
    /// The area of all surfaces, m2
    #[arg(long, value_name = "M2", default_value_t = 96.0)]
    area: f64,
    /// Reflectances, each a room of its own
    #[arg(long, value_name = "RHO,...", value_delimiter = ',', default_value = "0.5")]
    reflectance: Vec<f64>,
}

impl Room {
    pub(super) fn solve(&self) -> Result<Sheet> {
        let mut sheet = Sheet::new([
            Column::new("reflectance", "reflectance", Style::Given),
            Column::new("flux_lm", "flux lm", Style::Given),
            Column::new("area_m2", "area m2", Style::Given),
            Column::new("mean_illuminance_lx", "mean E lx", LIGHT),
        ]);
        for &rho in &self.reflectance {
            let mean = mean_illuminance(self.flux, self.area, rho)?;
            sheet.push([rho, self.flux, self.area, mean].map(Cell::Number));
        }
        Ok(sheet)
    }
}
