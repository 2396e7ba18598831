//! The exchange of light between patches: who has most shoots first, until next to nothing is left.

use std::ops::ControlFlow;

use rayon::prelude::*;

use super::super::contour;
use super::super::direct;
use super::super::receiver::Receiver;
use super::super::replicates::{Control, Ending, Observer};
use super::super::results::Exchange;
use super::patches::{Patches, facing, sign};
use crate::math::{Ray, Rgb};
use crate::scene::Scene;
use crate::surface::Facet;

/// Holds the radiosity of all sides.
pub(super) struct Solution {
    /// B, lm/m2, side by side.
    pub(super) radiosity: Vec<Rgb>,
    pub(super) exchange: Exchange,
    pub(super) ending: Ending,
}

impl Solution {
    /// Stands for one in which every side is lit: gathering from any other takes no longer.
    pub(super) fn everywhere_lit(patches: &Patches) -> Self {
        let exchange =
            Exchange { patches: patches.facets.len(), shots: 0, unshot: 1.0, absorbed: 0.0 };
        let radiosity = vec![Rgb::WHITE; patches.sides()];
        Self { radiosity, exchange, ending: Ending::Converged }
    }
}

/// Patches nearer to each other than this many times the longer of their diagonals exchange light
/// by several points.
const NEAR: f64 = 3.0;
/// Receiving patches per batch of shadow rays.
const TOGETHER: usize = 64;
/// How many form factors are kept for the next time their patch shoots: 1 GiB. What is not kept is
/// computed again.
const KEPT: usize = 1 << 27;
/// How many shots the observer hears of at a time.
const REPORTED: u64 = 16;

/// The part of a shooting side's radiosity that arrives at others, as illuminance.
type Row = Vec<(u32, f32)>;

/// Shoots until no more than the share `tolerance` of all light is unshot.
pub(super) fn solve(
    scene: &Scene,
    patches: &Patches,
    tolerance: f64,
    control: &Control,
    observer: Observer,
) -> Solution {
    let mut light = Exchanged::start(scene, patches);
    let mut rows = Rows { rows: vec![None; patches.sides()], kept: 0 };
    let all = light.emitted.luminance();
    let mut shots = 0;
    let (ending, left) = loop {
        let (next, left) = light.most_unshot(patches);
        if left <= tolerance * all {
            break (Ending::Converged, left);
        }
        if control.is_late() {
            break (Ending::Time, left);
        }
        if shots % REPORTED == 0 {
            // The unshot light falls about exponentially.
            let share = ((left / all).ln() / tolerance.ln()).clamp(0.0, 1.0);
            if control.report_share(share, shots, observer) == ControlFlow::Break(()) {
                break (Ending::Interrupted, left);
            }
        }
        rows.with(next, || row(scene, patches, next), |row| light.shoot(patches, next, row));
        shots += 1;
    };
    let absorbed = light.absorbed(patches).luminance() / light.emitted.luminance();
    let radiosity = (0..patches.sides())
        .map(|s| patches.exitance(s) + patches.reflectance(s) * light.arrived[s]);
    Solution {
        radiosity: radiosity.collect(),
        exchange: Exchange {
            patches: patches.facets.len(),
            shots,
            unshot: if all > 0.0 { left / all } else { 0.0 },
            absorbed,
        },
        ending,
    }
}

/// What has arrived where and what has not been passed on.
struct Exchanged {
    /// The illuminance of each side, lx.
    arrived: Vec<Rgb>,
    /// The radiosity of each side that is still to be shot, lm/m2.
    unshot: Vec<Rgb>,
    /// The flux of all sources, lm.
    emitted: Rgb,
}

impl Exchanged {
    /// Starts with what the sources give.
    fn start(scene: &Scene, patches: &Patches) -> Self {
        let arrived: Vec<Rgb> =
            (0..patches.sides()).into_par_iter().map(|s| lit(scene, patches, s)).collect();
        let unshot = (0..patches.sides())
            .map(|s| patches.exitance(s) + patches.reflectance(s) * arrived[s])
            .collect();
        let lamps: Rgb = scene.lights().iter().map(crate::scene::PointLight::flux).sum();
        let surfaces: Rgb =
            (0..patches.sides()).map(|s| patches.exitance(s) * patches.facet(s).area).sum();
        Self { arrived, unshot, emitted: lamps + surfaces }
    }

    /// Returns the side with the most unshot flux, and the unshot flux of all together, lm.
    fn most_unshot(&self, patches: &Patches) -> (usize, f64) {
        let (mut most, mut side, mut sum) = (0.0, 0, 0.0);
        for (i, unshot) in self.unshot.iter().enumerate() {
            let flux = unshot.luminance() * patches.facet(i).area;
            sum += flux;
            if flux > most {
                (most, side) = (flux, i);
            }
        }
        (side, sum)
    }

    fn shoot(&mut self, patches: &Patches, from: usize, row: &Row) {
        let shot = std::mem::take(&mut self.unshot[from]);
        for &(to, factor) in row {
            let to = to as usize;
            let illuminance = shot * f64::from(factor);
            self.arrived[to] += illuminance;
            self.unshot[to] += illuminance * patches.reflectance(to);
        }
    }

    /// Returns the flux that the patches absorbed, lm.
    fn absorbed(&self, patches: &Patches) -> Rgb {
        let of = |(side, arrived): (usize, &Rgb)| {
            (Rgb::WHITE - patches.reflectance(side)) * *arrived * patches.facet(side).area
        };
        self.arrived.iter().enumerate().map(of).sum()
    }
}

/// Returns the mean illuminance of a side by the point lights, lx.
fn lit(scene: &Scene, patches: &Patches, side: usize) -> Rgb {
    let points = &patches.facet(side).points;
    let at = |hit| direct::point_lights(scene, &Receiver::side(hit, sign(side)));
    points.iter().map(at).sum::<Rgb>() / points.len() as f64
}

/// Keeps form factors as far as there is memory for them.
struct Rows {
    rows: Vec<Option<Row>>,
    kept: usize,
}

impl Rows {
    fn with(&mut self, side: usize, make: impl Fn() -> Row, mut take: impl FnMut(&Row)) {
        if let Some(row) = &self.rows[side] {
            return take(row);
        }
        let row = make();
        take(&row);
        if self.kept + row.len() <= KEPT {
            self.kept += row.len();
            self.rows[side] = Some(row);
        }
    }
}

/// Computes the illuminance of all sides by one side of radiosity 1.
fn row(scene: &Scene, patches: &Patches, from: usize) -> Row {
    let blocks = patches.facets.par_chunks(TOGETHER).enumerate();
    let mut row: Row = blocks
        .flat_map_iter(|(i, _)| {
            let end = ((i + 1) * TOGETHER).min(patches.facets.len());
            arriving(scene, patches, from, i * TOGETHER..end)
        })
        .collect();
    // A coarse patch may seem to give more than it has; so that the exchange ends, it must not.
    let given: f64 =
        row.iter().map(|(to, f)| f64::from(*f) * patches.facet(*to as usize).area).sum();
    let had = patches.facet(from).area;
    if given > had {
        for (_, factor) in &mut row {
            *factor *= (had / given) as f32;
        }
    }
    row
}

/// Computes a part of a row: that of the receiving patches `to`.
fn arriving(scene: &Scene, patches: &Patches, from: usize, to: std::ops::Range<usize>) -> Row {
    let (shooter, facing_sign) = (patches.facet(from), sign(from));
    let (mut terms, mut rays): (Row, Vec<Ray>) = (Vec::new(), Vec::new());
    for receiver in to.filter(|r| *r != from / 2) {
        let facet = &patches.facets[receiver];
        let near = are_near(facet, shooter);
        let points = if near { &facet.points[..] } else { std::slice::from_ref(&facet.middle) };
        for (k, hit) in points.iter().enumerate() {
            for side in
                [2 * receiver, 2 * receiver + 1].into_iter().filter(|s| !patches.is_covered(*s))
            {
                let normal = sign(side) * hit.normal;
                let factor = facing_sign * contour::factor(&shooter.corners, hit.point, normal);
                if factor <= 0.0 {
                    continue;
                }
                let target = if near {
                    facing(shooter, facing_sign, hit, normal, k + 2)
                } else {
                    Some(&shooter.middle)
                };
                let ray = target.and_then(|target| {
                    let direction = (target.point - hit.point).try_normalize()?;
                    hit.segment(target, direction)
                });
                if let Some(ray) = ray {
                    rays.push(ray);
                    terms.push((side as u32, (factor / points.len() as f64) as f32));
                }
            }
        }
    }
    let mut blocked = vec![false; rays.len()];
    scene.mark_blocked(&rays, &mut blocked);
    let mut row: Row = Vec::new();
    for ((side, factor), _) in terms.into_iter().zip(blocked).filter(|(_, blocked)| !blocked) {
        match row.iter_mut().rev().take(2).find(|(last, _)| *last == side) {
            Some((_, sum)) => *sum += factor,
            None => row.push((side, factor)),
        }
    }
    row
}

fn are_near(a: &Facet, b: &Facet) -> bool {
    let distance2 = a.middle.point.distance_squared(b.middle.point);
    distance2 < NEAR * NEAR * diagonal2(a).max(diagonal2(b))
}

/// Returns the square of the longer diagonal, m2.
fn diagonal2(facet: &Facet) -> f64 {
    let [a, b, c, d] = facet.corners;
    a.distance_squared(c).max(b.distance_squared(d))
}
