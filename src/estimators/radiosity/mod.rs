//! Radiosity: the deterministic baseline. Surfaces in patches of constant radiosity B, B = M + rho
//! E, exchange light until next to none is left.
//!
//! Progressive refinement (Cohen, Chen, Wallace and Greenberg 1988): the patch with the most unshot
//! flux shoots it to all others, again and again; as relaxation this is Southwell's. Form factors
//! are exact for points that see a polygon (Lambert's contour formula) times visibility by shadow
//! rays; neighbours take the mean over several points of the patch that receives. Point lights
//! light patches and sensors exactly. In the end each sensor gathers from all patches by the same
//! formula ("final gather"), so that its value does not jump from patch to patch.
//!
//! The error is that of the patches: nothing here estimates it, and no interval is claimed. It
//! falls about in proportion to their size squared (the number of patches) where light is smooth,
//! slower at shadow borders and in edges and corners; compare two numbers of patches to see it.
//!
//! Limits: Lambertian reflection only; bounded surfaces only; every triangle of a mesh is a patch,
//! shaded flat; time grows with the square of the number of patches.

mod gather;
mod patches;
mod shooting;

use std::time::{Duration, Instant};

use rayon::prelude::*;

use super::estimator::RadiositySettings;
use super::receiver::Receiver;
use super::replicates::{Control, Observer, REPLICATES, Stop, Watch};
use super::results::Survey;
use crate::Result;
use crate::math::Rgb;
use crate::math::stats::Estimate;
use crate::scene::{Measured, Scene};
use patches::Patches;
use shooting::Solution;

/// How many times as long as was measured is left for the final gather.
const RESERVE: f64 = 1.25;

/// Measures what receivers get from the patches of a scene, beside the light of `points`. Of `stop`
/// only the time counts.
pub(super) fn survey(
    scene: &Scene,
    receivers: &[Receiver],
    points: &[Rgb],
    settings: &RadiositySettings,
    stop: Stop,
    observer: Observer,
) -> Result<Survey> {
    settings.check()?;
    let control = Control::new(stop);
    let patches = Patches::new(scene, settings.patches)?;
    // The exchange leaves time to gather what the receivers get.
    let rest = |time: Duration| {
        let started = Instant::now();
        if let Some(receiver) = receivers.first() {
            gather::gather(scene, &patches, &Solution::everywhere_lit(&patches), receiver);
        }
        let each = receivers.len().div_ceil(rayon::current_num_threads()) as f64;
        let reserve = started.elapsed().mul_f64(RESERVE * each);
        time.saturating_sub(control.elapsed()).saturating_sub(reserve)
    };
    let exchange = Control::new(Stop { time: stop.time.map(rest), ..stop });
    let solution = shooting::solve(scene, &patches, settings.tolerance, &exchange, observer);
    let watch = Watch::new(&control, observer, solution.exchange.shots);
    let gather = |(point, receiver): (&Rgb, &Receiver)| {
        if watch.ends() {
            return Measured::UNKNOWN;
        }
        let light = gather::gather(scene, &patches, &solution, receiver);
        Measured {
            total: Estimate::without_error((*point + light.total()).luminance()),
            direct: Estimate::without_error((*point + light.direct).luminance()),
            non_finite: 0,
        }
    };
    let results: Vec<Measured> = points.par_iter().zip(receivers).map(gather).collect();
    Ok(Survey {
        results,
        replicates: vec![[f64::NAN; REPLICATES]; receivers.len()],
        ending: if watch.has_ended() { watch.ending() } else { solution.ending },
        walks: solution.exchange.shots,
        escaped: f64::NAN,
        caustic: 0.0,
        elapsed: control.elapsed(),
        radiosity: Some(solution.exchange),
    })
}

#[cfg(test)]
mod tests;
