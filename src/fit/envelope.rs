//! Meshes whose surface a ray from the centre meets more than once: which of the meetings is the
//! radius.
//!
//! Ears and nostrils make a head meet some rays three times. The radius is then that of an
//! envelope: the outermost meeting, the first, or the mean of all.

use std::f64::consts::PI;

use glam::DVec3;
use rayon::prelude::*;

use crate::fit::star::seen_solid_angle;
use crate::math::Ray;
use crate::math::choice::choice;
use crate::mesh::Mesh;
use crate::sh::Grid;
use crate::surface::{MeshSurface, Surface};
use crate::{Error, Result};

/// Chooses the radius along rays that meet a mesh more than once.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Envelope {
    /// The largest distance: folds are filled.
    #[default]
    Outermost,
    /// The smallest distance: what overhangs is cut away.
    First,
    /// The mean of all distances.
    Mean,
}

choice!(Envelope, "envelope":
    Outermost = "outermost" "The farthest meeting: folds are filled",
    First = "first" "The nearest meeting: overhangs are cut away",
    Mean = "mean" "The mean of all meetings",
);

/// Layers nearer to each other than this share of the mesh's reach count as one: far above the
/// rounding of a meeting (1e-16 over the cosine of its angle), far below any fold that a mesh of
/// single-precision vertices can hold.
const THIN: f64 = 1e-10;

/// Rings of the grid on which the share of folded directions is looked at beforehand: 2 R^2 rays.
const LOOKED_AT: usize = 96;

/// Finds the layers of a mesh about a centre inside it.
#[derive(Debug, Clone)]
pub(super) struct Layers {
    surface: MeshSurface,
    centre: DVec3,
    envelope: Envelope,
    /// No point of the mesh is farther from the centre, metres.
    reach: f64,
}

/// Describes what a point of the mesh is to the envelope.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Seen {
    /// The radius of the envelope in the point's direction, metres.
    pub(super) radius: f64,
    /// How much of the point's solid angle counts: all points on one ray together have 1.
    pub(super) share: f64,
    /// Whether the ray meets the mesh more than once.
    pub(super) folded: bool,
}

impl Layers {
    /// Prepares a closed mesh about a centre.
    ///
    /// # Errors
    /// [`Error::Geometry`] when the mesh does not surround the centre once.
    pub(super) fn new(mesh: &Mesh, centre: DVec3, envelope: Envelope) -> Result<Self> {
        if !surrounds(mesh, centre) {
            return Err(Error::Geometry(format!(
                "the mesh does not surround the centre {centre:.6}: an envelope needs a centre \
                 inside; give one"
            )));
        }
        let surface = MeshSurface::new(mesh.clone())?;
        let bounds = surface.bounds();
        let reach = (bounds.max - centre).abs().max((bounds.min - centre).abs()).length() * 1.01;
        Ok(Self { surface, centre, envelope, reach })
    }

    /// Returns the envelope that is followed.
    pub(super) fn envelope(&self) -> Envelope {
        self.envelope
    }

    /// Lists the distances, ascending, at which a ray from the centre meets the mesh.
    fn meetings(&self, direction: DVec3) -> impl Iterator<Item = f64> {
        let mut from = 0.0;
        std::iter::from_fn(move || {
            let ray = Ray { t_min: from, ..Ray::new(self.centre, direction).up_to(self.reach) };
            let distance = self.surface.hit(&ray)?.distance;
            from = distance + THIN * self.reach;
            Some(distance)
        })
    }

    /// Returns the radius of the envelope in a direction, metres, and whether the ray meets the
    /// mesh more than once; `None` where it slips through.
    pub(super) fn radius(&self, direction: DVec3) -> Option<(f64, bool)> {
        let all = All::of(self.meetings(direction))?;
        Some((all.radius(self.envelope), all.count > 1))
    }

    /// Returns what the point of the mesh at this distance in this direction is to the envelope.
    pub(super) fn see(&self, direction: DVec3, distance: f64) -> Seen {
        let Some(all) = All::of(self.meetings(direction)) else {
            // Its own face is seen edge-on: the point stands for hardly any solid angle.
            return Seen { radius: distance, share: 1.0, folded: false };
        };
        let is = |other: f64| f64::from(u8::from((distance - other).abs() <= THIN * self.reach));
        let share = match self.envelope {
            Envelope::Outermost => is(all.last),
            Envelope::First => is(all.first),
            Envelope::Mean => 1.0 / all.count as f64,
        };
        Seen { radius: all.radius(self.envelope), share, folded: all.count > 1 }
    }
}

/// The meetings of one ray.
struct All {
    first: f64,
    last: f64,
    sum: f64,
    count: usize,
}

impl All {
    fn of(mut distances: impl Iterator<Item = f64>) -> Option<Self> {
        let first = distances.next()?;
        let start = Self { first, last: first, sum: first, count: 1 };
        Some(distances.fold(start, |all, d| Self {
            last: d,
            sum: all.sum + d,
            count: all.count + 1,
            ..all
        }))
    }

    fn radius(&self, envelope: Envelope) -> f64 {
        match envelope {
            Envelope::Outermost => self.last,
            Envelope::First => self.first,
            Envelope::Mean => self.sum / self.count as f64,
        }
    }
}

/// Whether a closed mesh winds once about a point.
fn surrounds(mesh: &Mesh, point: DVec3) -> bool {
    let faces = 0..mesh.triangles().len();
    let turns = faces.map(|f| seen_solid_angle(mesh.corners(f), point)).sum::<f64>() / (4.0 * PI);
    // Winding numbers of closed meshes are whole; a point on a face sees half a turn.
    (turns - 1.0).abs() < 0.25
}

/// Chooses a centre for a closed mesh that is star-shaped about none: of these candidates inside
/// the mesh the one from which the smallest share of the directions meets the mesh more than once,
/// found by a few thousand rays. `None` when no candidate is inside.
///
/// # Errors
/// [`Error::Geometry`] when rays cannot meet the mesh at all: no face has an area.
pub fn least_folded(mesh: &Mesh, candidates: &[DVec3]) -> Result<Option<DVec3>> {
    let grid = Grid::gauss_legendre(LOOKED_AT, 2 * LOOKED_AT);
    let mut best = None;
    for &centre in candidates.iter().filter(|c| surrounds(mesh, **c)) {
        let layers = Layers::new(mesh, centre, Envelope::Outermost)?;
        let folded: Vec<bool> = (0..grid.len())
            .into_par_iter()
            .map(|i| layers.radius(grid.direction(i)).is_none_or(|(_, folded)| folded))
            .collect();
        let share: f64 =
            folded.iter().enumerate().filter(|f| *f.1).map(|f| grid.solid_angle(f.0)).sum();
        if best.is_none_or(|(least, _)| share < least) {
            best = Some((share, centre));
        }
    }
    Ok(best.map(|(_, centre)| centre))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes;

    #[test]
    fn centre_outside_is_refused() {
        let cube = shapes::cube();
        assert!(Layers::new(&cube, DVec3::splat(2.0), Envelope::Outermost).is_err());
        assert_eq!(least_folded(&cube, &[DVec3::splat(2.0)]).expect("a surface"), None);
        let flipped = cube.flipped();
        assert!(Layers::new(&flipped, DVec3::splat(0.5), Envelope::Outermost).is_err());
    }

    #[test]
    fn rays_through_edges_and_corners_meet_once() {
        for direction in [DVec3::X, DVec3::ONE, DVec3::new(1.0, 1.0, 0.0)] {
            let layers =
                Layers::new(&shapes::cube(), DVec3::splat(0.5), Envelope::Mean).expect("inside");
            let direction = direction.normalize();
            let (radius, folded) = layers.radius(direction).expect("closed");
            assert!((radius - 0.5 / direction.x).abs() <= 1e-14 && !folded);
        }
    }

    #[test]
    fn a_ray_across_the_arms_of_a_u_has_three_layers() {
        // From the foot of the left arm at (0.5, 1.5, 0.5) towards +x: walls at x = 1, 2 and 3.
        let at = DVec3::new(0.5, 1.5, 0.5);
        for (envelope, radius, shares) in [
            (Envelope::Outermost, 2.5, [0.0, 0.0, 1.0]),
            (Envelope::First, 0.5, [1.0, 0.0, 0.0]),
            (Envelope::Mean, 1.5, [1.0 / 3.0; 3]),
        ] {
            let layers = Layers::new(&shapes::u_shape(), at, envelope).expect("inside");
            assert_eq!(layers.radius(DVec3::X), Some((radius, true)));
            for (distance, share) in [0.5, 1.5, 2.5].into_iter().zip(shares) {
                let seen = layers.see(DVec3::X, distance);
                assert_eq!(seen, Seen { radius, share, folded: true }, "{envelope}");
            }
        }
    }

    #[test]
    fn the_lowest_point_sees_most_of_a_u() {
        // The nearer to the inner floor, the wider the inner walls of the arms are seen.
        let [low, high] = [DVec3::new(1.5, 0.1, 0.5), DVec3::new(1.5, 0.9, 0.5)];
        let chosen = least_folded(&shapes::u_shape(), &[high, low, DVec3::splat(9.0)]);
        assert_eq!(chosen.expect("a surface"), Some(low));
    }
}
