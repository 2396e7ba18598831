//! Talk on stderr: warnings, errors, notes; and tables for people on stdout.

use std::io::Write;

use comfy_table::presets::ASCII_MARKDOWN;
use comfy_table::{CellAlignment, Table};
use glam::DVec3;
use harmolux::Error;
use harmolux::error::{abridged, presented, shown, shown_lines};
use harmolux::math::{EulerAngles, Rotation};
use harmolux::sh::Convention;
use serde_json::Value;

use crate::common::exit::Code;
use crate::common::{advice, progress};

/// Prints an error.
pub(crate) fn error(error: &Error) {
    note(&format!("error: {}", advice::told(error)));
}

/// Prints a warning.
pub(crate) fn warning(text: &str) {
    note(&format!("warning: {}", abridged(text)));
}

/// Prints a note about what is being done.
pub(crate) fn note(text: &str) {
    // Talk that nobody can hear is not worth failing for.
    progress::aside(|| drop(writeln!(std::io::stderr(), "{}", presented(text))));
}

/// Prints a line of data on stdout, or several.
pub(crate) fn data(text: &str) {
    raw(&shown_lines(text));
}

/// Prints a line of JSON.
pub(crate) fn json(value: &Value) {
    raw(&value.to_string());
}

/// Prints what is not changed, JSON or a drawing in colours, on stdout. That a reader has gone away
/// is no failure; any other is told, and ends the run.
pub(crate) fn raw(text: &str) {
    let mut out = std::io::stdout().lock();
    let done = out
        .write_all(text.as_bytes())
        .and_then(|()| out.write_all(b"\n"))
        .and_then(|()| out.flush());
    match done {
        Err(e) if e.kind() != std::io::ErrorKind::BrokenPipe => {
            note(&format!("error: stdout: cannot write: {e}"));
            std::process::exit(Code::Failed as i32);
        }
        _ => {}
    }
}

/// Starts a table, in Markdown: the first column to the left, the others, numbers, to the right.
pub(crate) fn table(header: &[&str]) -> Table {
    let mut table = Table::new();
    table.load_style(ASCII_MARKDOWN).set_header(header);
    for column in table.column_iter_mut().skip(1) {
        column.set_cell_alignment(CellAlignment::Right);
    }
    table
}

/// Prints pairs of name and value, one a line, the values under each other.
pub(crate) fn pairs(pairs: &[(&str, String)]) {
    let width = pairs.iter().map(|(name, _)| name.chars().count()).max().unwrap_or(0);
    for (name, value) in pairs {
        data(&format!("{name:<width$}  {}", presented(value)));
    }
}

/// Names a convention.
pub(crate) fn convention(convention: Convention) -> String {
    format!("{}, csphase {}", convention.normalisation, convention.phase.csphase())
}

/// Writes a share as a percentage with three significant digits.
pub(crate) fn percent(share: f64) -> String {
    format!("{} %", significant(100.0 * share, 3))
}

/// Writes a number with so many significant digits, without exponent where that is readable.
pub(crate) fn significant(x: f64, digits: usize) -> String {
    if x == 0.0 || !x.is_finite() {
        return format!("{x}");
    }
    let magnitude = x.abs().log10().floor() as i32;
    if !(-4..9).contains(&magnitude) {
        return format!("{x:.*e}", digits.saturating_sub(1));
    }
    let decimals = (digits as i32 - 1 - magnitude).max(0) as usize;
    format!("{x:.decimals$}")
}

/// Returns for each column how many significant digits, four at least, tell different numbers
/// apart.
pub(crate) fn columns<const N: usize>(rows: &[[f64; N]]) -> [usize; N] {
    std::array::from_fn(|column| {
        let mut numbers: Vec<f64> = rows.iter().map(|row| row[column]).collect();
        numbers.sort_by(f64::total_cmp);
        // What differs by rounding alone is the same place.
        let size = numbers.iter().map(|x| x.abs()).fold(0.0, f64::max);
        numbers.dedup_by(|next, kept| *next - *kept <= 1e-12 * size);
        let tells = |digits: usize| {
            let mut pairs = numbers.windows(2);
            pairs.all(|pair| significant(pair[0], digits) != significant(pair[1], digits))
        };
        (4..13).find(|digits| tells(*digits)).unwrap_or(13)
    })
}

/// Writes a value with the digits that its 95 % half width justifies: to the second digit of that,
/// but two at least and seven at most; four where no error is known, and seven where the value is
/// exact.
pub(crate) fn measured(x: f64, half_width: f64) -> String {
    let magnitude = |x: f64| x.abs().log10().floor() as i32;
    let digits = if half_width.is_nan() {
        4
    } else if half_width <= ROUNDING * x.abs() || !half_width.is_finite() {
        if half_width.is_finite() { 7 } else { 2 }
    } else {
        magnitude(x).saturating_sub(magnitude(half_width)).saturating_add(2).clamp(2, 7)
    };
    significant(x, digits as usize)
}

/// What is left of the error of an exact value, relative to it.
pub(crate) const ROUNDING: f64 = 1e-13;

/// Writes a number of bytes with its thousands apart.
pub(crate) fn bytes(n: usize) -> String {
    let digits = n.to_string();
    let mut grouped = String::new();
    for (i, digit) in digits.chars().enumerate() {
        if i > 0 && (digits.len() - i).is_multiple_of(3) {
            grouped.push(' ');
        }
        grouped.push(digit);
    }
    format!("{grouped} B")
}

/// Writes a unit of a file as it is printed: cd/m\u{b2}.
pub(crate) fn unit(unit: &str) -> String {
    shown(unit).replace("m2", "m\u{b2}")
}

/// Writes a point, metres.
pub(crate) fn point(p: DVec3) -> String {
    let [x, y, z] = p.to_array().map(|v| significant(v, 4));
    format!("({x}, {y}, {z}) m")
}

/// Says by how much, and by which angles, something is turned.
pub(crate) fn turn(rotation: &Rotation) -> String {
    let EulerAngles { alpha, beta, gamma } = rotation.euler();
    let [alpha, beta, gamma] = [alpha, beta, gamma].map(|a| format!("{:.3}", a.to_degrees()));
    let angle = rotation.angle().to_degrees();
    format!("by {angle:.3} degrees; Euler angles {alpha}, {beta}, {gamma} (z-y-z)")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_keep_their_significant_digits() {
        assert_eq!(significant(0.012_345, 3), "0.0123");
        assert_eq!(significant(1234.5, 3), "1234");
        assert_eq!(significant(1.5e-7, 3), "1.50e-7");
        assert_eq!(significant(0.0, 3), "0");
        assert_eq!(bytes(587_796), "587 796 B");
        assert_eq!(bytes(12), "12 B");
    }
    #[test]
    fn values_have_the_digits_that_their_errors_justify() {
        for (value, half_width, text) in [
            (310.981_23, 1.234, "311.0"),
            (310.981_23, 0.012_34, "310.981"),
            (310.981_23, 60.0, "311"),
            (0.062_15, 0.000_31, "0.06215"),
            (4.528_129_525, 0.0, "4.528130"),
            (4.528_129_525, 1e-9, "4.528130"),
            (4.528_129_525, f64::NAN, "4.528"),
            (4.528_129_525, f64::INFINITY, "4.5"),
            (0.5, 12.0, "0.50"),
            (0.0, 0.0, "0"),
            (0.0, 1.0, "0"),
        ] {
            assert_eq!(measured(value, half_width), text);
        }
    }
}
