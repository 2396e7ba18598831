//! Which degree an SH object was given for a picture, and what that may cost: a line for those that
//! share a degree.

use std::collections::BTreeMap;
use std::f64::consts::PI;

use harmolux::error::shown;
use harmolux::study::DetailedObject;
use serde_json::{Value, json};

use crate::common::say;

/// Says on stderr which objects got which degree.
pub(crate) fn tell(details: &[DetailedObject]) {
    let mut groups: BTreeMap<(usize, usize), Vec<&DetailedObject>> = BTreeMap::new();
    for object in details {
        let degrees = (object.detail.degree, object.detail.full_degree);
        groups.entry(degrees).or_default().push(object);
    }
    for ((degree, full), objects) in groups {
        say::note(&line(degree, full, &objects));
    }
}

fn line(degree: usize, full: usize, objects: &[&DetailedObject]) -> String {
    let who = match objects {
        [one] => format!("`{}`", shown(&one.name)),
        many => format!("{} objects", many.len()),
    };
    let details = || objects.iter().map(|object| object.detail);
    let nearest = say::significant(details().map(|d| d.distance).fold(f64::INFINITY, f64::min), 3);
    let kept = kept_by_normals(objects);
    if degree == full {
        return format!("detail: {who} at full degree {full}, from {nearest} m away{kept}");
    }
    let largest = |of: fn(&harmolux::study::Detail) -> f64| {
        say::significant(details().map(|d| of(&d)).fold(0.0, f64::max), 3)
    };
    let normals = if details().any(|d| d.normal >= PI) {
        "without a bound".to_owned()
    } else {
        format!("by at most {} degrees", largest(|d| d.normal.to_degrees()))
    };
    format!(
        "detail: {who} at degree {degree} of {full}, from {nearest} m away: at most {} mm and {} \
         pixels off, normals turned {normals}{kept}",
        largest(|d| 1e3 * d.error),
        largest(|d| d.pixels),
    )
}

/// Says where the angle asks for a higher degree than the pixels do.
fn kept_by_normals(objects: &[&DetailedObject]) -> String {
    let kept = objects.iter().map(|object| object.detail);
    let kept = || kept.clone().filter(|d| d.degree_by_pixels < d.degree);
    let by_pixels = || kept().map(|d| d.degree_by_pixels);
    match (kept().count(), by_pixels().min(), by_pixels().max()) {
        (0, ..) | (_, None, _) | (_, _, None) => String::new(),
        (count, Some(least), Some(most)) => {
            let which = if count == objects.len() { "" } else { &format!(", {count} of them") };
            let degrees =
                if least == most { format!("{least}") } else { format!("{least} to {most}") };
            format!("{which} for the sake of `normal`: without it degree {degrees} would do")
        }
    }
}

/// Returns the same object by object.
pub(crate) fn json(details: &[DetailedObject]) -> Value {
    let one = |object: &DetailedObject| {
        let d = object.detail;
        json!({
            "name": object.name,
            "degree": d.degree,
            "full_degree": d.full_degree,
            "distance": d.distance,
            "error": d.error,
            "pixels": d.pixels,
            "normal_degrees": d.normal.to_degrees(),
            "degree_by_pixels": d.degree_by_pixels,
        })
    };
    details.iter().map(one).collect()
}
