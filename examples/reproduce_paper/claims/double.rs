//! Equation 12: the kernel of the double local estimate, letter by letter, against the exact
//! luminance of Sobolev's planes.

use std::f64::consts::PI;

use glam::DVec3;
use harmolux::Result;
use harmolux::estimators::{Launcher, REPLICATES};
use harmolux::exact::Plane;
use harmolux::math::stats::Estimate;
use harmolux::math::{Randomness, Ray, Stream, sampling};

use super::figure_2::Planes;
use super::{Claim, Equation, Run};

/// Where the luminance is asked for, on the lower plane.
const RADIUS: f64 = 1.0;
/// The reflectance of both planes.
const RHO: f64 = 0.5;
/// Beyond how many standard errors a mean of replicates differs: once in a thousand by chance.
const FAR: f64 = 3.6;

pub(super) fn claims(run: &Run) -> Result<Vec<Claim>> {
    let planes = Planes::load()?;
    let walks = run.choose(1 << 10, 1 << 14);
    let printed = (0..REPLICATES as u64).map(|seed| replicate(&planes, seed, walks));
    let printed = Estimate::of_replicates(&printed.collect::<Result<Vec<_>>>()?);
    // What was reflected more than once: L less K L0.
    let exact = RHO * planes.exact.indirect(Plane::Lower, RADIUS)? / PI;
    let off = |factor: f64| (factor * printed.mean / exact - 1.0).abs();
    Ok(vec![Claim::from(Equation {
        title: "Equations 11 and 12: the kernel of the double local estimate",
        printed_words: "I = M sum of Q_n k, k = 1 / pi^2 sigma(r'; l'', l') sigma(r; l', l) F(r', \
                        r'')",
        correction: Some(
            "k also has F(r, r') / p(r'), p the density per area with which r' is chosen: pi where \
             the direction to r' is drawn by the cosine.",
        ),
        printed: off(1.0),
        corrected: Some(off(PI)),
        tolerance: FAR * printed.relative_error(),
        check: format!(
            "L - L0 - K L0 of Sobolev's planes at r = {RADIUS}: {REPLICATES} replicates of {walks} \
             walks, with an r' by the cosine for each; relative to the exact value. The tolerance \
             is {FAR} standard errors."
        ),
        command: "cargo run --release --example reproduce_paper -- -o out --only double",
    })])
}

/// Returns the mean of (11) with (12) as printed; the source is node 0.
fn replicate(planes: &Planes, seed: u64, walks: u64) -> Result<f64> {
    let launcher = Launcher::new(&planes.scene)?;
    let factor = (RHO / PI).powi(2);
    let above = Ray::new(DVec3::new(RADIUS, 0.0, 0.5), DVec3::NEG_Z);
    let Some(here) = planes.scene.vertex(&above) else { return Ok(f64::NAN) };
    let (mut sum, mut nodes) = (0.0, Vec::new());
    for index in 0..walks {
        let local = sampling::cosine_hemisphere(stream(2 * seed, index).next_2d());
        let Some(middle) = planes.scene.vertex(&here.hit.leave(local)) else { continue };
        let (at, normal) = (middle.hit.point, middle.normal);
        nodes.clear();
        launcher.walk(&mut stream(2 * seed + 1, index), &mut nodes);
        let reflected = nodes.iter().map(|node| {
            let kernel = form_factor((at, normal), (node.vertex.hit.point, node.vertex.normal));
            node.flux.luminance() * kernel
        });
        let direct = planes.scene.lights().iter().map(|light| {
            let way = light.at - at;
            let cosine = way.dot(normal).max(0.0) / way.length();
            light.towards(-way.normalize()).luminance() * cosine / way.length_squared()
        });
        sum += factor * (reflected.sum::<f64>() + direct.sum::<f64>());
    }
    Ok(sum / walks as f64)
}

fn stream(seed: u64, index: u64) -> Stream {
    Stream::new(Randomness::Pseudorandom, seed, index)
}

/// Returns the paper's F of two points that see each other.
fn form_factor((a, a_normal): (DVec3, DVec3), (b, b_normal): (DVec3, DVec3)) -> f64 {
    let way = b - a;
    let cosines = way.dot(a_normal).max(0.0) * (-way.dot(b_normal)).max(0.0);
    if cosines > 0.0 { cosines / way.length_squared().powi(2) } else { 0.0 }
}
