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

use super::receiver::Receiver;
use super::replicates::{Control, Observer, REPLICATES, Stop, Watch};
use super::survey::Survey;
use crate::math::Rgb;
use crate::math::stats::Estimate;
use crate::scene::{Measured, Scene};
use crate::{Error, Result};
use patches::Patches;
use shooting::Solution;

/// How many times as long as was measured is left for the final gather.
const RESERVE: f64 = 1.25;

/// The largest number of patches: their pairs are visited one by one.
pub const MAX_PATCHES: usize = 100_000;

/// Sets how finely radiosity divides a scene and when it ends.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RadiositySettings {
    /// About how many patches all surfaces get together, each in proportion to its area, 1 to
    /// [`MAX_PATCHES`]; those of curved bodies and meshes may be more.
    pub patches: usize,
    /// The share of all light that may be left unshot, above 0 and below 1.
    pub tolerance: f64,
}

impl Default for RadiositySettings {
    /// Takes 2000 patches and a millionth of the light.
    fn default() -> Self {
        Self { patches: 2000, tolerance: 1e-6 }
    }
}

/// Describes how radiosity went.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Exchange {
    /// The number of patches; each has two sides.
    pub patches: usize,
    /// How often a patch has shot its light.
    pub shots: u64,
    /// The share of the light that is left unshot.
    pub unshot: f64,
    /// The share of the light that all patches absorbed: in a closed scene 1, but for what is
    /// unshot and the error of the patches.
    pub absorbed: f64,
}

impl RadiositySettings {
    fn check(&self) -> Result<()> {
        if !(1..=MAX_PATCHES).contains(&self.patches) {
            return Err(Error::Parameter(format!(
                "the number of patches must be from 1 to {MAX_PATCHES}, found {}",
                self.patches
            )));
        }
        if !(self.tolerance > 0.0 && self.tolerance < 1.0) {
            return Err(Error::Parameter(format!(
                "the tolerance of radiosity is a share of the light, above 0 and below 1, found {}",
                self.tolerance
            )));
        }
        Ok(())
    }
}

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
