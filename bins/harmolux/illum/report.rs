//! How `illum` reports: tables and verdicts for people, JSON for machines.

use comfy_table::Table as TextTable;
use glam::DVec3;
use harmolux::error::shown;
use harmolux::estimators::{Bracket, GroupSummary, Survey};
use harmolux::io::scene_file::Limit;
use harmolux::io::tables::Table;
use harmolux::math::stats::Estimate;
use harmolux::plots::{Axis, Curve, Figure, Style};
use harmolux::study::{Judged, Verdict};
use harmolux::{Error, Result};
use serde_json::{Value, json};

use crate::common::say;
use crate::common::surveys::{half_width, non_finite_samples};
use crate::illum::Group;

/// Prints the values of a group, what they come to, and whether that is enough.
pub(crate) fn group(group: &Group) {
    if group.sensors.is_empty() {
        return;
    }
    let label = shown(group.name);
    say::data(&values(group, &label).to_string());
    let hidden = group.behind.iter().flatten().count();
    if hidden > 0 {
        say::data(&format!(
            "{label}: {} of {} sensors count, {hidden} are behind an object",
            group.sensors.len() - hidden,
            group.sensors.len()
        ));
    }
    if let Some(GroupSummary { mean, least, largest, uniformity }) = &group.summary {
        for (name, bracket) in [("mean", mean), ("least", least), ("largest", largest)] {
            say::data(&format!("{label}: {name} {} lx", text(bracket)));
        }
        let uniformity = uniformity.as_ref().map_or("-".to_owned(), text);
        say::data(&format!("{label}: U0 {uniformity}"));
        comparison(group, &label);
    }
    for judged in &group.judged {
        say::data(&format!("{label}: {}", sentence(judged)));
    }
    say::data("");
}

/// Tells how many sensors agree with what is known, and how far the farthest is off, as the largest
/// difference over the largest exact value.
fn comparison(group: &Group, label: &str) {
    let compared = || group.comparisons().flatten();
    let count = compared().count();
    if count == 0 {
        return;
    }
    let agree = compared().filter(|c| c.agrees == Some(true)).count();
    let known = compared().filter(|c| c.agrees.is_some()).count();
    let largest = compared().map(|c| c.exact).fold(0.0, f64::max);
    let pairs = group.comparisons().zip(group.results);
    let off = pairs.filter_map(|(c, r)| Some((r.total.mean - c?.exact).abs()));
    let judged = if known == 0 {
        "not judged against the exact values, as no error is known".to_owned()
    } else {
        format!("{agree} of {count} agree with the exact values (joint test, false alarm 1e-3)")
    };
    say::data(&format!(
        "{label}: {judged}; max |dE| / max E = {}",
        say::percent(off.fold(0.0, f64::max) / largest)
    ));
}

fn values(group: &Group, label: &str) -> TextTable {
    let mut header = vec![label, "x m", "y m", "z m", "E lx", "± 95 %", "direct lx"];
    let mut comparisons = group.comparisons().peekable();
    if comparisons.peek().is_some() {
        header.extend(["exact lx", "off by s.e.", "agrees"]);
    }
    let mut table = say::table(&header);
    let sensors = group.sensors.iter().zip(group.results).zip(group.behind);
    let places = say::columns(&group.sensors.iter().map(|s| s.at.to_array()).collect::<Vec<_>>());
    for (i, ((sensor, r), behind)) in sensors.enumerate() {
        let [x, y, z] = [0, 1, 2].map(|axis| say::significant(sensor.at[axis], places[axis]));
        let illuminance = match behind {
            None if r.total.mean.is_nan() => "unknown".to_owned(),
            None => measured(&r.total),
            Some(object) => format!("behind {}", shown(object)),
        };
        let mut row = vec![
            (i + 1).to_string(),
            x,
            y,
            z,
            illuminance,
            half_width(&r.total),
            if r.direct.mean.is_nan() { "-".to_owned() } else { measured(&r.direct) },
        ];
        row.extend(comparisons.next().into_iter().flat_map(|c| {
            let Some(c) = c else { return [(); 3].map(|()| "-".to_owned()) };
            let (off, agrees) = match c.agrees {
                Some(agrees) => (format!("{:+.2}", c.deviation), if agrees { "yes" } else { "NO" }),
                None => ("-".to_owned(), "-"),
            };
            [say::measured(c.exact, r.total.half_width(0.05)), off, agrees.to_owned()]
        }));
        table.add_row(row);
    }
    table
}

/// Writes the value of an estimate.
fn measured(estimate: &Estimate) -> String {
    say::measured(estimate.mean, estimate.half_width(0.05))
}

/// Writes a value with its interval where that is known.
fn text(bracket: &Bracket) -> String {
    let half_width = 0.5 * (bracket.high - bracket.low);
    let number = |x: f64| say::measured(x, half_width);
    if !bracket.has_interval() {
        return number(bracket.value);
    }
    let [value, low, high] = [bracket.value, bracket.low, bracket.high].map(number);
    format!("{value} ({low} to {high})")
}

fn sentence(judged: &Judged) -> String {
    let verdict = match judged.verdict {
        _ if judged.found.value.is_nan() => "UNDECIDED, no sensor counts or was reached in time",
        Verdict::Met if !judged.found.has_interval() => {
            "met by the value, whose error is not known"
        }
        Verdict::NotMet if !judged.found.has_interval() => {
            "NOT MET by the value, whose error is not known"
        }
        Verdict::Met => "met",
        Verdict::NotMet => "NOT MET",
        Verdict::Undecided if judged.is_within_interval() => {
            "UNDECIDED, the limit is within the interval"
        }
        Verdict::Undecided => "UNDECIDED, light is missing from the values",
    };
    let (relation, limit) = relation(judged.limit);
    format!("required {} {relation} {limit}: {verdict}", judged.quantity)
}

const fn relation(limit: Limit) -> (&'static str, f64) {
    match limit {
        Limit::AtLeast(limit) => (">=", limit),
        Limit::AtMost(limit) => ("<=", limit),
    }
}

/// Plots the illuminance along lines of sensors with its intervals, and what is known of it.
pub(crate) fn figure<'a>(lines: impl Iterator<Item = &'a Group<'a>>) -> Figure {
    let mut curves = Vec::new();
    for line in lines {
        let start = line.sensors.first().map_or(DVec3::ZERO, |s| s.at);
        let distances = || line.sensors.iter().map(|s| s.at.distance(start));
        let known = distances().zip(line.comparisons()).filter_map(|(x, c)| Some([x, c?.exact]));
        let known: Vec<[f64; 2]> = known.collect();
        if !known.is_empty() {
            curves.push(Curve::new(format!("{}, exact", line.name), known).drawn(Style::Line));
        }
        let counting = || line.results.iter().zip(line.behind).filter(|(_, b)| b.is_none());
        let points = distances().zip(line.results).zip(line.behind).filter(|(_, b)| b.is_none());
        let points = points.map(|((x, r), _)| [x, r.total.mean]);
        let mut measured = Curve::new(line.name, points.collect());
        if counting().all(|(r, _)| !r.total.standard_error.is_nan()) {
            let errors = counting().map(|(r, _)| [r.total.half_width(0.05); 2]);
            measured = measured.with_errors(errors.collect());
        }
        curves.push(measured.drawn(Style::Points));
    }
    let axes = [Axis::linear("along the line, m"), Axis::linear("illuminance, lx")];
    Figure::new("Illuminance, 95 % intervals", axes, curves)
}

/// Writes everything as JSON: the rows of the table, the groups with their requirements, and how
/// the run went.
pub(crate) fn json(table: &Table, groups: &[Group], survey: &Survey) -> Result<String> {
    let failed = |e| Error::Numeric(format!("the JSON writer failed: {e}"));
    let mut report = serde_json::to_value(table).map_err(failed)?;
    report["groups"] = groups.iter().map(of_group).collect();
    report["walks"] = match &survey.radiosity {
        None => survey.walks.into(),
        Some(_) => Value::Null,
    };
    report["radiosity"] = survey.radiosity.as_ref().map_or(Value::Null, |exchange| {
        json!({
            "patches": exchange.patches,
            "shots": exchange.shots,
            "unshot_share": exchange.unshot,
            "absorbed_share": exchange.absorbed,
        })
    });
    report["seconds"] = survey.elapsed.as_secs_f64().into();
    report["non_finite_samples"] = non_finite_samples(survey).into();
    report["escaped_share"] = survey.escaped.into();
    report["caustic_share"] = survey.caustic.into();
    report["ending"] = survey.ending.name().into();
    serde_json::to_string_pretty(&report).map_err(failed)
}

fn of_group(group: &Group) -> Value {
    let bracket = |b: &Bracket| json!({ "value": b.value, "low_95": b.low, "high_95": b.high });
    let hidden = group.behind.iter().flatten().count();
    let mut value =
        json!({ "group": group.name, "sensors": group.sensors.len(), "behind": hidden });
    if let Some(summary) = &group.summary {
        value["mean_lx"] = bracket(&summary.mean);
        value["least_lx"] = bracket(&summary.least);
        value["largest_lx"] = bracket(&summary.largest);
        value["uniformity"] = summary.uniformity.as_ref().map(bracket).into();
    }
    value["requirements"] = group.judged.iter().map(of_requirement).collect();
    value
}

fn of_requirement(judged: &Judged) -> Value {
    let (relation, limit) = relation(judged.limit);
    let verdict = match judged.verdict {
        Verdict::Met => "met",
        Verdict::NotMet => "not met",
        Verdict::Undecided => "undecided",
    };
    json!({
        "quantity": judged.quantity.to_string(),
        "relation": relation,
        "limit": limit,
        "verdict": verdict,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::common::surveys::tests::survey;

    #[test]
    fn samples_that_are_not_finite_are_written() {
        let report = json(&Table::new(["group"]), &[], &survey(3)).expect("writes");
        let report: Value = serde_json::from_str(&report).expect("JSON");
        assert_eq!(report["non_finite_samples"], 3);
    }
}
