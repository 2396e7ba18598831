//! The luminance that rays show: a survey of the surfaces that they meet, through mirrors.

use rayon::prelude::*;

use super::estimator::SensorSettings;
use super::receiver::Receiver;
use super::replicates::{Observer, REPLICATES};
use super::results::Survey;
use super::survey::{ask_for, survey};
use crate::Result;
use crate::math::stats::Estimate;
use crate::math::{Ray, Rgb};
use crate::scene::{Measured, Scene, Vertex};

/// Measures luminance, cd/m2, against the direction of all rays, at the first surface that each
/// meets (eq. 11), and at those that mirrors show there; 0 where there is none. The direct part
/// holds what the first surface emits.
///
/// # Errors
/// As [`illuminance`](super::illuminance).
pub fn luminance(
    scene: &Scene,
    rays: &[Ray],
    settings: &SensorSettings,
    observer: Observer,
) -> Result<Survey> {
    ask_for(rays.len())?;
    let seen: Vec<Vec<(Vertex, Rgb)>> = rays.par_iter().map(|ray| seen(scene, ray)).collect();
    let all: Vec<(Vertex, Rgb)> = seen.iter().flatten().copied().collect();
    let receivers: Vec<_> =
        all.iter().map(|(v, left)| Receiver::reflecting(v).through(*left)).collect();
    let emitted = |i: usize| all[i].1 * scene.emitted(&all[i].0);
    let mut survey = survey(scene, &receivers, emitted, settings, observer)?;
    let (results, replicates) = (survey.results, survey.replicates);
    let mut from = 0;
    let own = seen.iter().map(|seen| {
        let range = from..from + seen.len();
        from = range.end;
        together(&results[range.clone()], &replicates[range])
    });
    (survey.results, survey.replicates) = own.unzip();
    Ok(survey)
}

/// Returns the vertices that a ray shows: the first that it meets and, with what mirrors leave of
/// their light, those behind it.
fn seen<'a>(scene: &'a Scene, ray: &Ray) -> Vec<(Vertex<'a>, Rgb)> {
    let (mut seen, mut left) = (Vec::new(), Rgb::WHITE);
    let mut next = scene.vertex(ray);
    while let Some(vertex) = next {
        // A mirror itself shows nothing; there may be many in a row.
        if vertex.albedo() > 0.0 || !vertex.emitted().is_black() || vertex.mirrored().is_none() {
            seen.push((vertex, left));
        }
        let mirrored = vertex.mirrored().map(|(direction, reflectance)| {
            left *= reflectance;
            vertex.hit.leave(direction)
        });
        // What is left out is below the last digit of what is counted.
        next = mirrored.filter(|_| left.luminance() > f64::EPSILON).and_then(|r| scene.vertex(&r));
    }
    seen
}

/// Adds up what one ray shows; what is direct is so at the first surface.
fn together(
    results: &[Measured],
    replicates: &[[f64; REPLICATES]],
) -> (Measured, [f64; REPLICATES]) {
    if let ([result], [replicates]) = (results, replicates) {
        return (*result, *replicates);
    }
    let mut sum = [0.0; REPLICATES];
    for own in replicates {
        sum.iter_mut().zip(own).for_each(|(sum, own)| *sum += own);
    }
    let direct = results.first().map_or(Estimate::without_error(0.0), |first| first.direct);
    let non_finite = results.iter().map(|r| r.non_finite).sum();
    (Measured { total: Estimate::of_replicates(&sum), direct, non_finite }, sum)
}
