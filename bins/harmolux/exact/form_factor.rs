//! Form factors of pairs of surfaces, configuration factors at a point.

use std::f64::consts::PI;

use clap::{Args, Subcommand};
use glam::DVec3;
use harmolux::exact::form_factors::{
    CoaxialDiscs, OpposedRectangles, PerpendicularRectangles, RectangleFromPoint, polygon,
};
use harmolux::io::tables::Cell;
use harmolux::{Error, Result};

use super::sheet::{Column, Sheet, Style};
use crate::common::values::point;

/// To how many decimals people read a factor.
const FACTOR: Style = Style::Decimals(10);

/// Form factors between rectangles or discs, and configuration factors at a point
///
/// A form factor F is the share of the flux from a uniform Lambert surface that arrives at another;
/// a configuration factor C is its limit at a point, so that luminance L gives E = pi L C there.
#[derive(Debug, Args)]
#[command(
    subcommand_value_name = "SURFACES",
    subcommand_help_heading = "Surfaces",
    disable_help_subcommand = true,
    after_help = "Examples:
  harmolux exact form-factor opposed --width 4 --depth 4 --distance 3         floor to ceiling
  harmolux exact form-factor perpendicular --common 4 --from 4 --to 3         floor to wall, and \
                                                                              back
  harmolux exact form-factor discs --from 0.5 --to 1 --distance 0.7
  harmolux exact form-factor polygon --vertex 1,0,2 --vertex 0,1,2 --vertex -1,0,2"
)]
pub(crate) struct FormFactor {
    #[command(subcommand)]
    surfaces: Surfaces,
}

#[derive(Debug, Subcommand)]
enum Surfaces {
    Opposed(Opposed),
    Perpendicular(Perpendicular),
    Discs(Discs),
    Point(Point),
    Polygon(Polygon),
}

/// Two equal rectangles that face each other squarely (Howell C-11)
#[derive(Debug, Args)]
struct Opposed {
    /// One side of both, metres
    #[arg(long, value_name = "METRES", default_value_t = 1.0)]
    width: f64,
    /// The other side of both, metres
    #[arg(long, value_name = "METRES", default_value_t = 1.0)]
    depth: f64,
    /// The distance of their planes, metres
    #[arg(long, value_name = "METRES", default_value_t = 1.0)]
    distance: f64,
}

/// Two rectangles at a right angle with a whole edge in common (Howell C-14)
#[derive(Debug, Args)]
struct Perpendicular {
    /// The common edge, metres
    #[arg(long, value_name = "METRES", default_value_t = 1.0)]
    common: f64,
    /// How far the first rectangle reaches from the edge, metres
    #[arg(long, value_name = "METRES", default_value_t = 1.0)]
    from: f64,
    /// How far the second rectangle reaches from the edge, metres
    #[arg(long, value_name = "METRES", default_value_t = 1.0)]
    to: f64,
}

/// Two discs on one axis, face to face (Howell C-41)
#[derive(Debug, Args)]
struct Discs {
    /// The radius of the first disc, metres
    #[arg(long, value_name = "METRES", default_value_t = 1.0)]
    from: f64,
    /// The radius of the second disc, metres
    #[arg(long, value_name = "METRES", default_value_t = 1.0)]
    to: f64,
    /// The distance of their planes, metres
    #[arg(long, value_name = "METRES", default_value_t = 1.0)]
    distance: f64,
}

/// A rectangle seen from a point opposite one of its corners (Howell B-3, B-4)
///
/// The receiver is parallel to the rectangle, or at a right angle to it with its normal along the
/// height.
#[derive(Debug, Args)]
struct Point {
    /// One side, metres
    #[arg(long, value_name = "METRES", default_value_t = 1.0)]
    width: f64,
    /// The other side, metres
    #[arg(long, value_name = "METRES", default_value_t = 1.0)]
    height: f64,
    /// The distance from the point to the corner, metres
    #[arg(long, value_name = "METRES", default_value_t = 1.0)]
    distance: f64,
}

/// A polygon seen from a point (Lambert's formula); what is below the receiver's horizon is cut off
///
/// Without options: a square of 1 m, 1 m over the point, which is under one corner.
#[derive(Debug, Args)]
struct Polygon {
    /// A vertex, in order along the border, metres; give three or more [default: a square]
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true, value_parser = point)]
    vertex: Vec<DVec3>,
    /// The point, metres
    #[arg(
        long, value_name = "X,Y,Z", allow_hyphen_values = true, value_parser = point,
        default_value = "0,0,0"
    )]
    at: DVec3,
    /// The normal of the receiver there, of any length
    #[arg(
        long, value_name = "X,Y,Z", allow_hyphen_values = true, value_parser = point,
        default_value = "0,0,1"
    )]
    normal: DVec3,
}

impl FormFactor {
    pub(super) fn solve(&self) -> Result<Sheet> {
        match &self.surfaces {
            Surfaces::Opposed(surfaces) => surfaces.solve(),
            Surfaces::Perpendicular(surfaces) => surfaces.solve(),
            Surfaces::Discs(surfaces) => surfaces.solve(),
            Surfaces::Point(surfaces) => surfaces.solve(),
            Surfaces::Polygon(surfaces) => surfaces.solve(),
        }
    }
}

impl Opposed {
    fn solve(&self) -> Result<Sheet> {
        let (width, depth, distance) = (self.width, self.depth, self.distance);
        let factor = OpposedRectangles { width, depth, distance }.form_factor()?;
        Ok(between([("either", "other", factor)]))
    }
}

impl Perpendicular {
    fn solve(&self) -> Result<Sheet> {
        let there = PerpendicularRectangles { common: self.common, from: self.from, to: self.to };
        let back = PerpendicularRectangles { from: self.to, to: self.from, ..there };
        let factors = [there.form_factor()?, back.form_factor()?];
        Ok(between([("first", "second", factors[0]), ("second", "first", factors[1])]))
    }
}

impl Discs {
    fn solve(&self) -> Result<Sheet> {
        let there = CoaxialDiscs { from: self.from, to: self.to, distance: self.distance };
        let back = CoaxialDiscs { from: self.to, to: self.from, ..there };
        let factors = [there.form_factor()?, back.form_factor()?];
        Ok(between([("first", "second", factors[0]), ("second", "first", factors[1])]))
    }
}

impl Point {
    fn solve(&self) -> Result<Sheet> {
        let (width, height, distance) = (self.width, self.height, self.distance);
        let rectangle = RectangleFromPoint { width, height, distance };
        let factors = [rectangle.parallel()?, rectangle.perpendicular()?];
        Ok(at_point([("parallel", factors[0]), ("perpendicular", factors[1])]))
    }
}

impl Polygon {
    fn solve(&self) -> Result<Sheet> {
        const SQUARE: [DVec3; 4] = [
            DVec3::new(0.0, 0.0, 1.0),
            DVec3::new(1.0, 0.0, 1.0),
            DVec3::new(1.0, 1.0, 1.0),
            DVec3::new(0.0, 1.0, 1.0),
        ];
        let vertices = if self.vertex.is_empty() { &SQUARE } else { self.vertex.as_slice() };
        if vertices.len() < 3 {
            let text = format!("a polygon needs three vertices or more, not {}", vertices.len());
            return Err(Error::Parameter(text));
        }
        let normal = self.normal.try_normalize().ok_or_else(|| {
            Error::Parameter("the normal has no direction; give one such as 0,0,1".into())
        })?;
        Ok(at_point([("as given", polygon(vertices, self.at, normal))]))
    }
}

/// Tabulates form factors from one surface to another.
fn between<const N: usize>(factors: [(&str, &str, f64); N]) -> Sheet {
    let mut sheet = Sheet::new([
        Column::new("from", "from", Style::Given),
        Column::new("to", "to", Style::Given),
        Column::new("form_factor", "F", FACTOR),
    ]);
    for (from, to, factor) in factors {
        sheet.push([from.into(), to.into(), factor.into()]);
    }
    sheet
}

/// Tabulates configuration factors of receivers.
fn at_point<const N: usize>(factors: [(&str, f64); N]) -> Sheet {
    let mut sheet = Sheet::new([
        Column::new("receiver", "receiver", Style::Given),
        Column::new("configuration_factor", "C", FACTOR),
        Column::new("illuminance_per_luminance_sr", "E/L sr", FACTOR),
    ]);
    for (receiver, factor) in factors {
        sheet.push([receiver.into(), Cell::Number(factor), Cell::Number(PI * factor)]);
    }
    sheet
}
