//! Sobolev's problem: a point source between two planes, or two discs.

use std::f64::consts::PI;

use clap::{Args, ValueEnum};
use harmolux::Result;
use harmolux::exact::{Plane, SobolevDiscs, SobolevProblem};
use harmolux::io::tables::Cell;

use super::sheet::{Column, Sheet, Style};
use crate::common::say;
use crate::common::values::pair;

/// Sobolev's problem: an isotropic point source between two infinite parallel planes, or discs
///
/// Gives illuminance and luminance at distances from the foot of the source. Without options:
/// planes 1 m apart of reflectance 0.5, 1 cd half way.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  harmolux exact sobolev
  harmolux exact sobolev --reflectance 0.8,0.3 --height 0.7 --plane both
  harmolux exact sobolev --orders 6 -r 0,1        light reflected 0, 1, ..., 6 times
  harmolux exact sobolev --radius 2 -r 0,1,2      discs of radius 2 m, black outside")]
pub(crate) struct Sobolev {
    /// The reflectance of both planes, or LOWER,UPPER
    #[arg(long, value_name = "RHO", value_parser = pair, default_value = "0.5")]
    reflectance: [f64; 2],
    /// The height of the source over the lower plane, metres
    #[arg(long, value_name = "METRES", default_value_t = 0.5)]
    height: f64,
    /// The distance of the planes, metres
    #[arg(long, value_name = "METRES", default_value_t = 1.0)]
    gap: f64,
    /// The intensity of the source, cd
    #[arg(long, value_name = "CD", default_value_t = 1.0)]
    intensity: f64,
    /// The flux of the source, lm, in place of its intensity
    #[arg(long, value_name = "LM", conflicts_with = "intensity")]
    flux: Option<f64>,
    /// Distances from the foot of the source, metres
    #[arg(
        short,
        long = "distances",
        value_name = "METRES,...",
        value_delimiter = ',',
        default_value = "0,0.25,0.5,1,1.5,2,3,4,5,10"
    )]
    r: Vec<f64>,
    /// Where the light is asked for
    #[arg(long, value_enum, default_value_t = PlaneName::Lower)]
    plane: PlaneName,
    /// Take coaxial discs of this radius, black outside, in place of the planes
    #[arg(long, value_name = "METRES")]
    radius: Option<f64>,
    /// Add a column for each order of reflection up to this one
    #[arg(
        long, value_name = "N", conflicts_with = "radius",
        value_parser = clap::value_parser!(u16).range(0..=100)
    )]
    orders: Option<u16>,
}

#[derive(Debug, Clone, Copy, ValueEnum)]
enum PlaneName {
    Lower,
    Upper,
    Both,
}

impl PlaneName {
    const fn planes(self) -> &'static [(&'static str, Plane)] {
        match self {
            Self::Lower => &[("lower", Plane::Lower)],
            Self::Upper => &[("upper", Plane::Upper)],
            Self::Both => &[("lower", Plane::Lower), ("upper", Plane::Upper)],
        }
    }
}

/// The light on infinite planes or on discs.
enum SplitLight {
    Planes,
    Discs(SobolevDiscs),
}

impl Sobolev {
    pub(super) fn solve(&self) -> Result<Sheet> {
        let problem = self.problem();
        let light = match self.radius {
            None => SplitLight::Planes,
            Some(radius) => SplitLight::Discs(problem.discs(radius)?),
        };
        let mut sheet = Sheet::new(self.columns());
        for &(name, plane) in self.plane.planes() {
            for &r in &self.r {
                let direct = problem.direct(plane, r)?;
                let indirect = match &light {
                    SplitLight::Planes => problem.indirect(plane, r)?,
                    SplitLight::Discs(discs) => discs.indirect(plane, r)?,
                };
                let illuminance = direct + indirect;
                let luminance = self.reflectance_at(plane, r) * illuminance / PI;
                let orders = self.orders().map(|order| problem.order(plane, order, r));
                let numbers = [r, direct, indirect, illuminance, luminance].map(Ok);
                let numbers: Vec<f64> = numbers.into_iter().chain(orders).collect::<Result<_>>()?;
                let cells = numbers.into_iter().map(Cell::Number);
                sheet.push(std::iter::once(Cell::from(name)).chain(cells));
            }
        }
        if let SplitLight::Discs(discs) = &light {
            let (escaped, flux) = (discs.escaped_flux(), 4.0 * PI * problem.intensity);
            sheet.total("escaped_flux_lm", escaped);
            sheet.total("source_flux_lm", flux);
            sheet.note(format!(
                "of {} lm from the source {} lm miss the discs or leave between them",
                say::significant(flux, 6),
                say::significant(escaped, 6)
            ));
        }
        Ok(sheet)
    }

    fn problem(&self) -> SobolevProblem {
        SobolevProblem {
            reflectance: self.reflectance,
            source_height: self.height,
            gap: self.gap,
            intensity: self.flux.map_or(self.intensity, |flux| flux / (4.0 * PI)),
        }
    }

    /// Returns the reflectance at a distance: nothing reflects outside a disc.
    fn reflectance_at(&self, plane: Plane, r: f64) -> f64 {
        if self.radius.is_some_and(|radius| r > radius) {
            return 0.0;
        }
        match plane {
            Plane::Lower => self.reflectance[0],
            Plane::Upper => self.reflectance[1],
        }
    }

    fn orders(&self) -> impl Iterator<Item = u16> {
        self.orders.into_iter().flat_map(|last| 0..=last)
    }

    fn columns(&self) -> impl Iterator<Item = Column> {
        let light = Style::Significant(7);
        let fixed = [
            Column::new("plane", "plane", Style::Given),
            Column::new("r_m", "r m", Style::Given),
            Column::new("direct_lx", "direct lx", light),
            Column::new("indirect_lx", "indirect lx", light),
            Column::new("illuminance_lx", "E lx", light),
            Column::new("luminance_cd_m2", "L cd/m2", light),
        ];
        let order = move |n| Column::new(format!("order_{n}_lx"), format!("order {n} lx"), light);
        fixed.into_iter().chain(self.orders().map(order))
    }
}
