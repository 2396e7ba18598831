//! Equation 12: the kernel of the double local estimate, letter by letter, against the exact
//! luminance of Sobolev's planes.

use std::f64::consts::PI;

use glam::DVec3;
use harmolux::Result;
use harmolux::estimators::{Launcher, Node, REPLICATES};
use harmolux::exact::Plane;
use harmolux::math::stats::Estimate;
use harmolux::math::{Randomness, Ray, Stream, sampling};
use harmolux::scene::Vertex;

use super::figure_2::Planes;
use super::{Claim, Equation, Run, exponent};

/// Where the luminance is asked for, on the lower plane.
const RADIUS: f64 = 1.0;
/// The reflectance of both planes.
const RHO: f64 = 0.5;
/// Beyond how many standard errors a mean of replicates differs: once in a thousand by chance.
const FAR: f64 = 3.6;

/// Says how the direction from r to r' is drawn.
#[derive(Clone, Copy)]
enum Draw {
    ByCosine,
    Uniformly,
}

pub(super) fn claims(run: &Run) -> Result<Vec<Claim>> {
    let planes = Planes::load()?;
    let walks = run.choose(1 << 10, 1 << 14);
    let (printed_uniform, uniform) = estimates(&planes, Draw::Uniformly, walks)?;
    let (printed_cosine, cosine) = estimates(&planes, Draw::ByCosine, walks)?;
    // What was reflected more than once: L less K L0.
    let exact = RHO * planes.exact.indirect(Plane::Lower, RADIUS)? / PI;
    let off = |e: Estimate| (e.mean / exact - 1.0).abs();
    Ok(vec![Claim::from(Equation {
        title: "Equations 11 and 12: the kernel of the double local estimate",
        printed_words: "I = M sum of Q_n k, k = 1 / pi^2 sigma(r'; l'', l') sigma(r; l', l) F(r', \
                        r'')",
        correction: Some(
            "k also has F(r, r') / (pi p(r')), p the density per area with which r' is chosen; it \
             is 1 where the direction to r' is drawn by the cosine.",
        ),
        printed: off(printed_uniform),
        corrected: Some(off(uniform).max(off(cosine))),
        tolerance: FAR * uniform.relative_error().max(cosine.relative_error()),
        check: format!(
            "L - L0 - K L0 of Sobolev's planes at r = {RADIUS}: {REPLICATES} replicates of {walks} \
             walks with an r' each; relative to the exact value. Q_n is the flux that leaves a \
             hit, the source gives its direct light. The paper does not say how r' is drawn: with \
             directions of one density the printed form is off as stated above, by the cosine by \
             {}. The tolerance is {FAR} standard errors.",
            exponent(off(printed_cosine))
        ),
        command: "cargo run --release --example reproduce_paper -- -o out --only double",
    })])
}

/// Returns what (12) gives as printed, and corrected.
fn estimates(planes: &Planes, draw: Draw, walks: u64) -> Result<(Estimate, Estimate)> {
    let values = (0..REPLICATES as u64).map(|seed| replicate(planes, draw, seed, walks));
    let (printed, corrected): (Vec<f64>, Vec<f64>) =
        values.collect::<Result<Vec<_>>>()?.into_iter().unzip();
    Ok((Estimate::of_replicates(&printed), Estimate::of_replicates(&corrected)))
}

/// Returns the means of one replicate: as printed, and corrected.
fn replicate(planes: &Planes, draw: Draw, seed: u64, walks: u64) -> Result<(f64, f64)> {
    let launcher = Launcher::new(&planes.scene)?;
    let above = Ray::new(DVec3::new(RADIUS, 0.0, 0.5), DVec3::NEG_Z);
    let Some(here) = planes.scene.vertex(&above) else { return Ok((f64::NAN, f64::NAN)) };
    let (mut printed, mut corrected, mut nodes) = (0.0, 0.0, Vec::new());
    for index in 0..walks {
        let u = stream(2 * seed, index).next_2d();
        // F(r, r') / (pi p(r')): p falls with the cosine at r' and the distance as F does.
        let (direction, factor) = match draw {
            Draw::ByCosine => (sampling::cosine_hemisphere(u), 1.0),
            Draw::Uniformly => {
                let direction = sampling::uniform_sphere(u);
                (DVec3 { z: direction.z.abs(), ..direction }, 2.0 * direction.z.abs())
            }
        };
        let Some(middle) = planes.scene.vertex(&here.hit.leave(direction)) else { continue };
        nodes.clear();
        launcher.walk(&mut stream(2 * seed + 1, index), &mut nodes);
        let value = RHO * RHO / PI * illuminance(planes, &middle, &nodes);
        printed += value;
        corrected += factor * value;
    }
    Ok((printed / walks as f64, corrected / walks as f64))
}

/// Returns the illuminance of r' by the source and by one walk: Q_n F / pi.
fn illuminance(planes: &Planes, middle: &Vertex, nodes: &[Node]) -> f64 {
    let (at, normal) = (middle.hit.point, middle.normal);
    let reflected = nodes.iter().map(|node| {
        let there = (node.vertex.hit.point, node.vertex.normal);
        RHO * node.flux.luminance() / PI * form_factor((at, normal), there)
    });
    let direct = planes.scene.lights().iter().map(|light| {
        let way = light.at - at;
        let cosine = way.dot(normal).max(0.0) / way.length();
        light.towards(-way.normalize()).luminance() * cosine / way.length_squared()
    });
    reflected.sum::<f64>() + direct.sum::<f64>()
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
