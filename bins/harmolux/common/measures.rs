//! What a body measures: for people, as JSON and as columns of a table.

use std::f64::consts::PI;

use harmolux::fit::Measures;
use harmolux::io::tables::Cell;
use serde_json::{Value, json};

use crate::common::say::{percent, point, significant};

/// Returns the lines about a body whose volume and area are told already.
pub(crate) fn lines(body: &Measures) -> Vec<(&'static str, String)> {
    let three = |numbers: [f64; 3]| numbers.map(|x| significant(x, 5)).join(", ");
    let [elongation, flatness] = [body.elongation(), body.flatness()].map(|x| significant(x, 5));
    let roughness = significant(body.roughness, 5);
    let share = percent(body.roughness / (0.75 * body.volume / PI).cbrt());
    vec![
        ("centroid", point(body.centroid)),
        ("inertia", format!("{} m5, principal, of density 1", three(body.principal.moments))),
        ("semi-axes", format!("{} m, of the equivalent ellipsoid", three(body.semi_axes))),
        ("sphericity", significant(body.sphericity(), 5)),
        ("elongation", format!("{elongation}, second semi-axis over first")),
        ("flatness", format!("{flatness}, third over second")),
        (
            "roughness",
            format!("{roughness} m RMS from that ellipsoid, {share} of the volume's radius"),
        ),
    ]
}

/// Puts them into an object; null where there is no body.
pub(crate) fn put(object: &mut Value, body: Option<&Measures>) {
    let axes =
        |m: &Measures| [m.principal.axes.x_axis, m.principal.axes.y_axis, m.principal.axes.z_axis];
    object["centroid"] = json!(body.map(|m| m.centroid.to_array()));
    object["inertia"] = json!(body.map(|m| m.principal.moments));
    object["principal_axes"] = json!(body.map(|m| axes(m).map(|axis| axis.to_array())));
    object["semi_axes"] = json!(body.map(|m| m.semi_axes));
    object["sphericity"] = json!(body.map(Measures::sphericity));
    object["elongation"] = json!(body.map(Measures::elongation));
    object["flatness"] = json!(body.map(Measures::flatness));
    object["roughness"] = json!(body.map(|m| m.roughness));
}

/// The columns of a table beside volume and area.
pub(crate) const COLUMNS: [&str; 13] = [
    "centroid_x",
    "centroid_y",
    "centroid_z",
    "inertia_1",
    "inertia_2",
    "inertia_3",
    "semi_axis_a",
    "semi_axis_b",
    "semi_axis_c",
    "sphericity",
    "elongation",
    "flatness",
    "roughness",
];

/// Returns the cells of these columns; empty where there is no body.
pub(crate) fn cells(body: Option<&Measures>) -> Vec<Cell> {
    let Some(body) = body else { return vec![Cell::Empty; COLUMNS.len()] };
    let form = [body.sphericity(), body.elongation(), body.flatness(), body.roughness];
    let numbers = [body.centroid.to_array(), body.principal.moments, body.semi_axes];
    numbers.into_iter().flatten().chain(form).map(Cell::Number).collect()
}
