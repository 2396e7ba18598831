//! Surveys of light as several verbs settle, end and report them.

use harmolux::estimators::{Ending, RadiositySettings, SensorSettings, Stop, Survey};
use harmolux::io::output::Stage;
use harmolux::io::scene_file::IllumSpec;
use harmolux::math::stats::Estimate;
use harmolux::scene::Scene;
use harmolux::study::sensor_settings;

use super::exit::Code;
use super::flags::SceneArguments;
use super::scenes::stop;
use super::{progress, say};

/// Settles how illuminance is computed; a quick look has a tenth of the walks, or of the pairs of
/// patches.
pub(crate) fn settings(spec: &IllumSpec, scene: &Scene, common: &SceneArguments) -> SensorSettings {
    let patches = spec.patches.unwrap_or(RadiositySettings::default().patches);
    let patches = if common.quick { patches.div_ceil(3) } else { patches };
    let spec = IllumSpec {
        stop: stop(spec.stop, common.quick),
        seed: common.seed.unwrap_or(spec.seed),
        patches: Some(patches),
        ..spec.clone()
    };
    sensor_settings(&spec, scene)
}

/// Says how a run ended: a target error that was not met is told by the exit code.
pub(crate) fn code(ending: Ending, stop: Stop, error: Option<f64>, name: &str) -> Code {
    let met = match (stop.relative_error, error) {
        (Some(target), Some(error)) => error <= target,
        (Some(_), None) => false,
        (None, _) => true,
    };
    if let (false, Some(target)) = (met || ending == Ending::Interrupted, stop.relative_error) {
        let reached = error.map_or("unknown".to_owned(), say::percent);
        say::warning(&format!(
            "target not met: the {name} is {reached}, asked for {}; allow more time or walks, or \
             relax `relative_error`",
            say::percent(target)
        ));
    }
    match ending {
        Ending::Interrupted => Code::Interrupted,
        _ if met => Code::Done,
        _ => Code::NotMet,
    }
}

/// Says how far the results of a survey are.
pub(crate) fn stage(survey: &Survey) -> Stage {
    match survey.ending {
        Ending::Interrupted => Stage::Unfinished,
        _ => Stage::Complete,
    }
}

/// Returns the error that a survey has reached: none, with a warning, when no light came anywhere.
pub(crate) fn reached(survey: &Survey) -> Option<f64> {
    let worst = survey.worst();
    if worst.is_none() && survey.walks > 0 {
        say::warning(
            "no light came to any of them; see whether lamps and sensors are where they should be",
        );
    }
    worst.or((survey.ending == Ending::Error).then_some(0.0))
}

/// Writes the half width of an interval, or that none is known.
pub(crate) fn half_width(estimate: &Estimate) -> String {
    let half_width = estimate.half_width(0.05);
    let rounding = say::ROUNDING * estimate.mean.abs();
    match half_width {
        x if x.is_nan() => "-".to_owned(),
        x if x <= rounding => "0".to_owned(),
        x => say::significant(x, 2),
    }
}

/// Reports how the run went.
pub(crate) fn tell(survey: &Survey) {
    let end = match survey.ending {
        Ending::Interrupted => ", interrupted",
        _ => "",
    };
    let time = progress::duration(survey.elapsed);
    if let Some(exchange) = &survey.radiosity {
        say::note(&format!(
            "{} patches, {} shots in {time}{end}; {} of the light was absorbed, {} left unshot",
            exchange.patches,
            exchange.shots,
            say::percent(exchange.absorbed),
            say::percent(exchange.unshot)
        ));
        say::note(
            "radiosity gives no error: compare with another number of patches to see what they \
             cost",
        );
    } else {
        say::note(&format!("{} walks in {time}{end}", survey.walks));
    }
    if survey.escaped > 0.0 {
        say::warning(&format!("{} of the light left the scene", say::percent(survey.escaped)));
    }
    if survey.caustic > 0.0 {
        say::warning(&format!(
            "{} of the light goes from point lights to mirrors, which send it on; by the \
             estimator `local` what of it falls on a sensor straight is missing, by `path` all of \
             it, since no ray finds a point in a mirror (`photon` counts it); give those lights a \
             size: a sphere or a rectangle with an exitance",
            say::percent(survey.caustic)
        ));
    }
    for warning in [non_finite(survey), unbounded(survey)].into_iter().flatten() {
        say::warning(&warning);
    }
}

/// Says whether radiosity was ended before its light was passed on.
pub(crate) fn cut_short(survey: &Survey) -> bool {
    let Some(exchange) = &survey.radiosity else { return false };
    let cut_short = survey.ending != Ending::Converged;
    if cut_short {
        say::warning(&format!(
            "radiosity ended with {} of the light left to pass on: all values are too low; give \
             it more time (`illum.stop.time`), or fewer `patches`",
            say::percent(exchange.unshot)
        ));
    }
    cut_short
}

/// Says how many sensors that count were not reached before the run ended, if any.
pub(crate) fn unreached(survey: &Survey, counts: &[bool]) -> bool {
    let unknown = survey.results.iter().zip(counts);
    let unknown = unknown.filter(|(r, counts)| **counts && r.total.mean.is_nan()).count();
    if unknown > 0 {
        let of = counts.iter().filter(|counts| **counts).count();
        say::warning(&format!(
            "the run ended before {unknown} of {of} sensors were served: nothing is known of \
             them; give it more time (`illum.stop.time`), or ask for fewer sensors"
        ));
    }
    unknown > 0
}

/// Says how many values, or their errors, are beyond what numbers can hold, if any.
fn unbounded(survey: &Survey) -> Option<String> {
    let known = |e: &Estimate| e.standard_error.is_finite() || survey.radiosity.is_some();
    let holds = |e: &Estimate| e.mean.is_finite() && known(e);
    // NaN is what a sensor has that does not count.
    let count =
        survey.results.iter().filter(|r| !r.total.mean.is_nan() && !holds(&r.total)).count();
    (count > 0).then(|| {
        format!(
            "{count} of {} values, or their intervals, are beyond what numbers can hold; what is \
             infinite is null in JSON; see the strength of the lamps",
            survey.results.len()
        )
    })
}

/// Says how many samples were not finite, if any.
fn non_finite(survey: &Survey) -> Option<String> {
    let non_finite = non_finite_samples(survey);
    (non_finite > 0).then(|| {
        let (samples, they) =
            if non_finite == 1 { ("sample was", "it is") } else { ("samples were", "they are") };
        format!("{non_finite} {samples} not finite; {they} counted here and nowhere else")
    })
}

pub(crate) fn non_finite_samples(survey: &Survey) -> u64 {
    survey.results.iter().map(|r| r.non_finite).sum()
}

#[cfg(test)]
pub(crate) mod tests {
    use harmolux::scene::Measured;

    use super::*;

    /// A survey of one sensor.
    pub(crate) fn survey(non_finite: u64) -> Survey {
        let one = Estimate { mean: 2.0, standard_error: 0.1, replicates: 32 };
        Survey {
            results: vec![Measured { total: one, direct: one, non_finite }],
            replicates: Vec::new(),
            ending: Ending::Walks,
            walks: 1 << 20,
            escaped: 0.0,
            caustic: 0.0,
            elapsed: std::time::Duration::ZERO,
            radiosity: None,
        }
    }

    #[test]
    fn values_and_intervals_beyond_numbers_are_told() {
        assert_eq!(unbounded(&survey(0)), None);
        for (mean, standard_error) in [(3e299, f64::INFINITY), (f64::INFINITY, f64::NAN)] {
            let mut survey = survey(0);
            survey.results[0].total = Estimate { mean, standard_error, replicates: 32 };
            let told = unbounded(&survey).expect("infinite");
            assert!(told.starts_with("1 of 1 values, or their intervals, are beyond"), "{told}");
        }
    }

    #[test]
    fn samples_that_are_not_finite_are_told() {
        assert_eq!(non_finite(&survey(0)), None);
        let told = non_finite(&survey(1)).expect("one");
        assert_eq!(told, "1 sample was not finite; it is counted here and nowhere else");
        assert!(
            non_finite(&survey(3)).expect("three").starts_with("3 samples were not finite; they")
        );
    }
}
