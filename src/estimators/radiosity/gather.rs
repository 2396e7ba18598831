//! The final gather: what a receiver gets from the patches, each seen in its contour.

use super::super::connect::SplitLight;
use super::super::contour::{self, Cylinder};
use super::super::receiver::Receiver;
use super::patches::{Patches, sign};
use super::shooting::Solution;
use crate::math::{Ray, Rgb};
use crate::scene::Scene;
use crate::surface::Facet;

/// Sides per batch of shadow rays.
const TOGETHER: usize = 64;

/// Adds up what the patches send to a receiver: direct by what they emit, indirect by what they
/// reflect.
pub(super) fn gather(
    scene: &Scene,
    patches: &Patches,
    solution: &Solution,
    receiver: &Receiver,
) -> SplitLight {
    let cylinder = receiver.cylinder();
    let (mut light, mut rays) = (SplitLight::default(), Vec::new());
    let sides: Vec<usize> =
        (0..patches.sides()).filter(|s| !solution.radiosity[*s].is_black()).collect();
    for sides in sides.chunks(TOGETHER) {
        rays.clear();
        let mut seen: Vec<(usize, Rgb, usize)> = Vec::new();
        for &side in sides {
            let facet = patches.facet(side);
            let response = response(facet, sign(side), receiver, cylinder.as_ref());
            if response.is_black() {
                continue;
            }
            let before = rays.len();
            rays.extend(shadow_rays(facet, sign(side), receiver));
            seen.push((side, response, rays.len() - before));
        }
        let mut blocked = vec![false; rays.len()];
        scene.mark_blocked(&rays, &mut blocked);
        let mut rest = &blocked[..];
        for (side, response, rays) in seen {
            let (own, others) = rest.split_at(rays);
            rest = others;
            let open = own.iter().filter(|blocked| !**blocked).count();
            let visible = response * (open as f64 / rays.max(1) as f64);
            let emitted = patches.exitance(side);
            light.direct += visible * emitted;
            light.indirect += visible * (solution.radiosity[side] - emitted);
        }
    }
    light
}

/// Returns what a receiver gets from one side of an unhindered facet of radiosity 1.
fn response(facet: &Facet, sign: f64, receiver: &Receiver, cylinder: Option<&Cylinder>) -> Rgb {
    if let Some((normal, weight)) = receiver.cosine() {
        let factor = contour::factor(&facet.corners, receiver.hit.point, normal);
        return weight * (sign * factor).max(0.0);
    }
    let mut corners = facet.corners;
    if sign < 0.0 {
        corners.reverse();
    }
    Rgb::grey(cylinder.map_or(0.0, |c| c.sees(&corners, receiver.hit.point)))
}

/// Returns the rays to those points of a facet that face the receiver and that it receives light
/// from.
fn shadow_rays(facet: &Facet, sign: f64, receiver: &Receiver) -> impl Iterator<Item = Ray> {
    facet.points.iter().filter_map(move |target| {
        let direction = (target.point - receiver.hit.point).try_normalize()?;
        let faces = sign * direction.dot(target.normal) < 0.0;
        if !faces || receiver.response(direction).is_black() {
            return None;
        }
        receiver.hit.segment(target, direction)
    })
}
