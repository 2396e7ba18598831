//! Patches: the surface as a height field on the faces of a cube, in polynomials that are certainly above it by less than a known width.
//!
//! The projective map (u, v, w) = (p1/p0, p2/p0, 1/|p0|) of a cube face keeps rays straight, and a star-shaped surface becomes w = 1/Z(u, v), Z = f/s,
//! s = sqrt(1 + u^2 + v^2). A ray visits the few patches in which it comes near the surface (`node`), and in each the first root of a polynomial is
//! found by steps that pass none (`patch`). From outside the surface is taken at its upper bound, from inside at its lower one: the root is
//! at or before the true one, never after, and within the width of it.

mod board;
mod build;
mod certificate;
mod fit;
mod line;
mod node;
mod patch;
mod walk;

use fearless_simd::{Level, dispatch};
use glam::DVec3;

use self::board::Board;
use self::node::Node;
use self::patch::Patch;
use crate::Result;
use crate::sh::{Bounds, Series};

/// Holds the patches of a body and the tree above them. Lengths inside are in largest radii.
#[derive(Debug, Clone)]
pub(super) struct Patches {
    board: Board,
    /// The nodes of each level, the lowest first, row by row and face by face.
    levels: Vec<Vec<Node>>,
    /// Sixteen patches of a node stand together.
    patches: Vec<Patch>,
    /// The largest radius, metres.
    radius: f64,
    /// The largest width of a patch.
    width: f32,
    level: Level,
}

/// On which side of the surface a ray starts.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Side {
    Outside,
    Inside,
}

impl Side {
    /// Gives 1 outside and -1 inside: the sign of F on this side.
    #[inline(always)]
    pub(super) fn sign(self) -> f64 {
        match self {
            Self::Outside => 1.0,
            Self::Inside => -1.0,
        }
    }
}

/// Where a ray crosses the patches.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Crossing {
    /// The distance along the ray, metres.
    pub(super) distance: f64,
    /// The outward normal of the patch, not of unit length.
    pub(super) normal: DVec3,
    /// A bound on the radial distance to the surface, metres.
    pub(super) error: f64,
}

/// A stretch of a ray, in metres, that never comes nearer to the centre than the ball that fills the body.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Stretch {
    /// Where on the ray the stretch starts.
    pub(super) start: f64,
    pub(super) from: DVec3,
    pub(super) direction: DVec3,
    pub(super) length: f64,
}

impl Patches {
    /// Builds the patches of a body.
    ///
    /// # Errors
    /// [`crate::Error::Parameter`] for a degree too high to evaluate.
    pub(super) fn new(series: &Series, bounds: &Bounds) -> Result<Self> {
        build::build(series, bounds)
    }

    /// Bounds how far a crossing can be from the surface along a radius, metres.
    pub(super) fn error(&self) -> f64 {
        self.radius * (f64::from(self.width) + walk::TOLERANCE)
    }

    /// Gives the bytes that patches and tree take.
    pub(super) fn bytes(&self) -> usize {
        let nodes: usize = self.levels.iter().map(|l| size_of_val(&l[..])).sum();
        nodes + size_of_val(&self.patches[..]) + self.board.bytes()
    }

    /// Tells on which side of the surface a point between the balls is; `None` when it is too near to say.
    pub(super) fn side(&self, point: DVec3) -> Option<Side> {
        dispatch!(self.level, simd => self.side_simd(simd, point / self.radius))
    }

    /// Finds the first crossing of a stretch that starts on the given side.
    pub(super) fn first_crossing(&self, stretch: &Stretch, side: Side) -> Option<Crossing> {
        dispatch!(self.level, simd => self.first_crossing_simd(simd, stretch, side))
    }

    /// Tells whether a stretch crosses the surface.
    pub(super) fn crosses(&self, stretch: &Stretch, side: Side) -> bool {
        dispatch!(self.level, simd => self.crosses_simd(simd, stretch, side))
    }
}
