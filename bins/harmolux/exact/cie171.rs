//! The analytic cases 5.2 to 5.7 of CIE 171:2006 as readings.

use clap::Args;
use glam::DVec3;
use harmolux::Result;
use harmolux::exact::cie171::{self, FaceFlux, Reading};
use harmolux::io::tables::Cell;

use super::sheet::{Column, Sheet, Style};
use crate::common::values::point;

/// CIE 171, case 5.4: the flux of a point source of 10 000 lm is found on the faces of a black room
///
/// The room has 4 x 4 x 3 m. What the faces receive adds up to the flux of the source, wherever it
/// is.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  harmolux exact cie171-5.4
  harmolux exact cie171-5.4 --at 0.5,2,2.9")]
pub(crate) struct FluxConservation {
    /// The source, metres from the corner x_min, y_min, z_min
    #[arg(
        long, value_name = "X,Y,Z", allow_hyphen_values = true, value_parser = point,
        default_value = "2,2,1.5"
    )]
    at: DVec3,
}

/// CIE 171, case 5.5: the directional transmittance of clear glass
///
/// Fresnel's equations for both polarisations with all reflections between the faces, refractive
/// index 1.52.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  harmolux exact cie171-5.5
  harmolux exact cie171-5.5 --internal 0.9 --angles 0,10,20,30")]
pub(crate) struct Glass {
    /// Angles from the normal, degrees
    #[arg(
        long,
        value_name = "DEGREES,...",
        value_delimiter = ',',
        allow_hyphen_values = true,
        value_parser = angle,
        default_value = "0,30,45,60,70,75,80,85"
    )]
    angles: Vec<f64>,
    /// What one pass along the normal keeps between the faces; several are panes of their own
    #[arg(long, value_name = "TAU,...", value_delimiter = ',', default_value = "1,0.96")]
    internal: Vec<f64>,
}

/// Reads a value of the command line.
fn angle(text: &str) -> Result<f64, String> {
    let angle = text.trim().parse().ok().filter(|degrees| (0.0..=90.0).contains(degrees));
    angle.ok_or_else(|| "write degrees from the normal, 0 to 90".to_owned())
}

/// What cases in lux are read in: for machines, for people.
const LUX: [&str; 2] = ["illuminance_lx", "E lx"];

/// Returns case 5.2.
pub(super) fn point_source() -> Sheet {
    let mut sheet = sheet(&cie171::point_source(), LUX);
    sheet.note("the figures of the report agree to 0.03 %");
    sheet
}

/// Returns case 5.3.
pub(super) fn area_source() -> Sheet {
    sheet(&cie171::area_source(), LUX)
}

/// Returns case 5.6.
pub(super) fn reflection() -> Sheet {
    let mut sheet = sheet(&cie171::diffuse_reflection(), ["ratio_percent", "E/(E_hz rho) %"]);
    sheet.note("the figures of the report are the same");
    sheet
}

/// Returns case 5.7.
pub(super) fn obstruction() -> Sheet {
    let mut sheet = sheet(&cie171::obstruction(), ["ratio_percent", "E/(E_v rho) %"]);
    sheet.note("these are the corrected values: Table 19 of the report is wrong");
    sheet
}

impl FluxConservation {
    pub(super) fn solve(&self) -> Result<Sheet> {
        let faces = cie171::flux_conservation(self.at)?;
        let mut sheet = Sheet::new([
            Column::new("face", "face", Style::Given),
            Column::new("area_m2", "area m2", Style::Given),
            Column::new("flux_lm", "flux lm", Style::Decimals(4)),
            Column::new("share", "of the source", Style::Decimals(10)),
        ]);
        let all = FaceFlux {
            face: "all",
            area: faces.iter().map(|f| f.area).sum(),
            flux: faces.iter().map(|f| f.flux).sum(),
        };
        for face in faces.iter().chain([&all]) {
            let numbers = [face.area, face.flux, face.flux / cie171::SOURCE_FLUX];
            sheet.push(std::iter::once(Cell::from(face.face)).chain(numbers.map(Cell::Number)));
        }
        Ok(sheet)
    }
}

impl Glass {
    pub(super) fn solve(&self) -> Result<Sheet> {
        let mut sheet = Sheet::new([
            Column::new("internal_transmittance", "internal", Style::Given),
            Column::new("angle_degrees", "angle °", Style::Given),
            Column::new("transmittance", "T", Style::Decimals(6)),
        ]);
        for &internal in &self.internal {
            let glass = cie171::glass(internal);
            for &angle in &self.angles {
                let transmittance = glass.transmittance(angle.to_radians())?;
                sheet.push([internal, angle, transmittance].map(Cell::Number));
            }
        }
        Ok(sheet)
    }
}

/// Tabulates readings, with the figures of the report where they are known.
fn sheet(readings: &[Reading], [name, heading]: [&str; 2]) -> Sheet {
    let value = Style::Decimals(4);
    let is_published = readings.iter().any(|r| r.published.is_some());
    let published = is_published.then(|| {
        [
            Column::new(
                format!("published_{name}"),
                format!("CIE 171: {heading}"),
                Style::Decimals(2),
            ),
            Column::new("published_deviation_percent", "off %", Style::Decimals(2)),
        ]
    });
    let fixed = [
        Column::new("point", "point", Style::Given),
        Column::new("x_m", "x m", Style::Given),
        Column::new("y_m", "y m", Style::Given),
        Column::new("z_m", "z m", Style::Given),
        Column::new("normal_x", "", Style::Hidden),
        Column::new("normal_y", "", Style::Hidden),
        Column::new("normal_z", "", Style::Hidden),
        Column::new(name, heading, value),
    ];
    let mut sheet = Sheet::new(fixed.into_iter().chain(published.into_iter().flatten()));
    for r in readings {
        let [x, y, z] = r.point.to_array();
        let [nx, ny, nz] = r.normal.to_array();
        let numbers = [x, y, z, nx, ny, nz, r.value].map(Cell::Number);
        let published = r.published.map(|p| [p, 100.0 * (p / r.value - 1.0)].map(Cell::Number));
        let label = std::iter::once(Cell::from(r.label.to_string()));
        sheet.push(label.chain(numbers).chain(published.into_iter().flatten()));
    }
    sheet
}
