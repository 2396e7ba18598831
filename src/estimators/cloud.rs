//! Walks made ready to be connected to many receivers: their nodes side by side, the diffuse ones
//! in lanes.

use std::f64::consts::PI;

use fearless_simd::prelude::*;
use fearless_simd::{Level, Simd, dispatch, f64x8};
use glam::DVec3;

use super::walk::Node;
use crate::math::Rgb;
use crate::math::lanes::{LANES, load, splat};
use crate::scene::Brdf;
use crate::surface::Hit;

/// How many walks make a cloud.
pub(super) const WALKS: usize = 32;

/// Holds the nodes of some walks.
pub(super) struct Cloud<'a> {
    /// Diffuse hits first, as they are in `blocks`, those on smooth meshes last; then glossy ones
    /// and starts.
    nodes: Vec<Node<'a>>,
    diffuse: usize,
    blocks: Vec<Block>,
    /// The shading normals of the last blocks, those that hold hits on smooth meshes.
    shading: Vec<[[f64; LANES]; 3]>,
    walks: usize,
    non_finite: usize,
}

/// Diffuse nodes side by side; a lane without one sends nothing.
#[derive(Clone, Copy, Default)]
struct Block {
    place: [[f64; LANES]; 3],
    normal: [[f64; LANES]; 3],
    /// The flux reflected per steradian and cosine, lm/sr: Q reflectance / pi.
    strength: [[f64; LANES]; 3],
    /// Up to which K in 1/m2 the node is connected in full, whatever the weighting says.
    at_least: [f64; LANES],
}

/// A receiver that answers light by the cosine, as the lanes need it.
pub(super) struct Plane {
    pub(super) point: DVec3,
    /// The normal by which light counts.
    pub(super) normal: DVec3,
    /// The normal of the true surface, on the same side.
    pub(super) true_normal: DVec3,
    /// W / cos.
    pub(super) factor: Rgb,
}

impl Plane {
    pub(super) fn new(hit: &Hit, normal: DVec3, factor: Rgb) -> Self {
        let side = 1.0_f64.copysign(hit.normal.dot(normal));
        Self { point: hit.point, normal, true_normal: side * hit.normal, factor }
    }
}

impl<'a> Cloud<'a> {
    /// Takes walks up. A walk with a node that is not sound is left out and counted.
    pub(super) fn new<'w>(walks: impl Iterator<Item = &'w [Node<'a>]>) -> Self
    where
        'a: 'w,
    {
        let (mut nodes, mut smooth, mut others) = (Vec::new(), Vec::new(), Vec::new());
        let (mut sound, mut non_finite) = (0, 0);
        for walk in walks {
            if !walk.last().is_none_or(Node::is_sound) {
                non_finite += 1;
                continue;
            }
            sound += 1;
            for node in walk {
                let kind = match diffuse(node) {
                    Some(_) if node.vertex.is_flat() => &mut nodes,
                    Some(_) => &mut smooth,
                    None => &mut others,
                };
                kind.push(*node);
            }
        }
        let flat_blocks = nodes.len() / LANES;
        let any_smooth = !smooth.is_empty();
        nodes.append(&mut smooth);
        let diffuse = nodes.len();
        let blocks = nodes.chunks(LANES).map(Block::new).collect();
        let shading = nodes.chunks(LANES).skip(flat_blocks).filter(|_| any_smooth);
        let shading =
            shading.map(|nodes| in_lanes(nodes.iter().map(|n| n.vertex.normal))).collect();
        nodes.append(&mut others);
        Self { nodes, diffuse, blocks, shading, walks: sound, non_finite }
    }

    /// Returns the number of walks without those left out.
    pub(super) fn walks(&self) -> usize {
        self.walks
    }

    /// Returns the number of walks left out.
    pub(super) fn non_finite(&self) -> usize {
        self.non_finite
    }

    /// Returns the number of walks with those left out.
    pub(super) fn taken(&self) -> usize {
        self.walks + self.non_finite
    }

    /// Returns all nodes.
    pub(super) fn nodes(&self) -> &[Node<'a>] {
        &self.nodes
    }

    /// Returns the nodes that are not diffuse hits: glossy ones and starts.
    pub(super) fn others(&self) -> &[Node<'a>] {
        &self.nodes[self.diffuse..]
    }

    /// Returns what a diffuse node brings to a plane, its block being weighed for that.
    pub(super) fn light(&self, node: usize, plane: &Plane, weighed: &Weighed) -> Rgb {
        let (block, lane) = (node / LANES, node % LANES);
        let [r, g, b] = self.blocks[block].strength;
        plane.factor * Rgb([r[lane], g[lane], b[lane]]) * weighed.kernels[lane]
    }

    /// Weighs the diffuse nodes at a plane, K up to `limit`: puts K and the luminance that each
    /// brings unhindered into `weighed`, and returns what all bring.
    pub(super) fn weigh(
        &self,
        level: Level,
        plane: &Plane,
        limit: f64,
        weighed: &mut Vec<Weighed>,
    ) -> Rgb {
        weighed.resize(self.blocks.len(), Weighed::default());
        dispatch!(level, simd => self.weigh_simd(simd, plane, limit, weighed))
    }

    #[inline(always)]
    fn weigh_simd<S: Simd>(
        &self,
        simd: S,
        plane: &Plane,
        limit: f64,
        weighed: &mut [Weighed],
    ) -> Rgb {
        let mut sums = [f64x8::splat(simd, 0.0); 3];
        let [red, blue] = Rgb::RED_AND_BLUE;
        let (red, blue) = (f64x8::splat(simd, red), f64x8::splat(simd, blue));
        let flat_blocks = self.blocks.len() - self.shading.len();
        for (number, (block, weighed)) in self.blocks.iter().zip(weighed).enumerate() {
            let mut kernel = block.kernels(simd, plane, limit);
            if number >= flat_blocks {
                kernel = block.lit(simd, plane, &self.shading[number - flat_blocks], kernel);
            }
            let [r, g, b] = block.light(simd, kernel, plane.factor);
            sums = [sums[0] + r, sums[1] + g, sums[2] + b];
            let luminance = (r - g).mul_add(red, (b - g).mul_add(blue, g));
            weighed.kernels = kernel.into();
            weighed.luminances = luminance.into();
            weighed.total = total(luminance);
        }
        Rgb([total(sums[0]), total(sums[1]), total(sums[2])])
    }
}

/// What the nodes of a block bring to a plane, unhindered.
#[derive(Clone, Copy, Default)]
pub(super) struct Weighed {
    kernels: [f64; LANES],
    /// Luminances.
    pub(super) luminances: [f64; LANES],
    /// Their sum.
    pub(super) total: f64,
}

/// Adds up the lanes.
#[inline(always)]
fn total<S: Simd>(lanes: f64x8<S>) -> f64 {
    <[f64; LANES]>::from(lanes).iter().sum()
}

#[inline(always)]
fn dot<S: Simd>(a: [f64x8<S>; 3], b: [f64x8<S>; 3]) -> f64x8<S> {
    a[0].mul_add(b[0], a[1].mul_add(b[1], a[2] * b[2]))
}

/// Returns the reflectance of a node that reflects light diffusely.
fn diffuse(node: &Node) -> Option<Rgb> {
    match node.vertex.brdf() {
        Brdf::Lambert { reflectance } if node.start_density.is_none() => Some(*reflectance),
        _ => None,
    }
}

/// Puts vectors side by side; 0 in a lane without one.
fn in_lanes(vectors: impl Iterator<Item = DVec3>) -> [[f64; LANES]; 3] {
    let mut lanes = [[0.0; LANES]; 3];
    for (lane, vector) in vectors.enumerate() {
        for axis in 0..3 {
            lanes[axis][lane] = vector[axis];
        }
    }
    lanes
}

impl Block {
    fn new(nodes: &[Node]) -> Self {
        let place = in_lanes(nodes.iter().map(|n| n.vertex.hit.point));
        let mut block = Self {
            place,
            normal: in_lanes(nodes.iter().map(|n| n.vertex.true_normal())),
            ..Self::default()
        };
        for (lane, node) in nodes.iter().enumerate() {
            let vertex = &node.vertex;
            let strength = diffuse(node).map_or(Rgb::BLACK, |r| node.flux * r / PI);
            let strength = strength * vertex.arriving();
            for axis in 0..3 {
                block.strength[axis][lane] = strength.0[axis];
            }
            block.at_least[lane] = if node.caustic { f64::INFINITY } else { 0.0 };
        }
        block
    }

    /// Returns K of each lane.
    #[inline(always)]
    fn kernels<S: Simd>(&self, simd: S, plane: &Plane, limit: f64) -> f64x8<S> {
        let (place, from) = (load(simd, &self.place), splat(simd, plane.point));
        let to_node = [place[0] - from[0], place[1] - from[1], place[2] - from[2]];
        let towards = dot(to_node, splat(simd, plane.normal));
        let above = dot(to_node, splat(simd, plane.true_normal));
        let away = dot(to_node, load(simd, &self.normal));
        let squared = dot(to_node, to_node);
        let zero = f64x8::splat(simd, 0.0);
        let kernel = -(towards * away) / (squared * squared);
        let limit = f64x8::splat(simd, limit).max(f64x8::from_slice(simd, &self.at_least));
        let faces = towards.simd_gt(zero) & above.simd_gt(zero) & away.simd_lt(zero);
        faces.select(kernel.min(limit), zero)
    }

    /// Leaves of K of each lane what is on the side that its shading normal looks to.
    #[inline(always)]
    fn lit<S: Simd>(
        &self,
        simd: S,
        plane: &Plane,
        shading: &[[f64; LANES]; 3],
        kernel: f64x8<S>,
    ) -> f64x8<S> {
        let (place, from) = (load(simd, &self.place), splat(simd, plane.point));
        let to_node = [place[0] - from[0], place[1] - from[1], place[2] - from[2]];
        let zero = f64x8::splat(simd, 0.0);
        dot(to_node, load(simd, shading)).simd_lt(zero).select(kernel, zero)
    }

    /// Returns the light of each lane, colour by colour.
    #[inline(always)]
    fn light<S: Simd>(&self, simd: S, kernel: f64x8<S>, factor: Rgb) -> [f64x8<S>; 3] {
        let strength = load(simd, &self.strength);
        let [r, g, b] = factor.0;
        [
            strength[0] * (kernel * f64x8::splat(simd, r)),
            strength[1] * (kernel * f64x8::splat(simd, g)),
            strength[2] * (kernel * f64x8::splat(simd, b)),
        ]
    }
}
