//! Coefficients become a mesh: closed, oriented outward, star-shaped about the centre, every vertex
//! on the surface.
//!
//! A triangle of directions that turns counter-clockwise still does after each corner is moved
//! along its direction, so a triangulated sphere gives a mesh that is seen from the centre once in
//! every direction, whatever the radius. Three spheres are at hand: the geodesic one, the one by
//! latitude and longitude, and the one refined to a tolerance.

mod adaptive;
mod chord_error;
mod icosphere;
mod lat_long;
mod parametric;

use glam::DVec3;
use rayon::prelude::*;

use crate::error::Advice;
use crate::math::require_measurable;
use crate::mesh::Mesh;
use crate::sh::{Coefficients, Evaluator, require_positive};
use crate::{Error, Result, memory};

pub use chord_error::ChordError;
pub use parametric::parametric_mesh;

/// The most faces a tessellation may have.
pub const MAX_FACES: usize = 1 << 25;

/// Chooses how fine a tessellation is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Resolution {
    /// The geodesic sphere of this frequency n: 20 n^2 faces of nearly one size.
    Icosphere {
        /// At least 1.
        frequency: usize,
    },
    /// Latitude and longitude: 2 azimuths (bands - 1) faces, the poles single vertices.
    LatLong {
        /// From pole to pole, at least 2.
        bands: usize,
        /// Around, at least 3.
        azimuths: usize,
    },
    /// As many faces as it takes for the surface to be within this distance, metres, of the faces
    /// at all samples: fine where the surface bends, coarse where it does not.
    Adaptive {
        /// Positive and finite.
        tolerance: f64,
    },
}

/// Holds a mesh made of coefficients and how far it is from them.
#[derive(Debug, Clone, PartialEq)]
pub struct Tessellation {
    /// The mesh, metres; its vertices are on the surface.
    pub mesh: Mesh,
    /// How far it is from the surface.
    pub chord_error: ChordError,
}

/// A triangulated unit sphere.
struct SphereMesh {
    directions: Vec<DVec3>,
    triangles: Vec<[u32; 3]>,
}

impl Resolution {
    /// Returns the number of faces; `None` for the adaptive mesh, whose number only refining tells.
    pub fn faces(self) -> Option<usize> {
        match self {
            Self::Icosphere { frequency } => {
                Some(frequency.saturating_mul(frequency).saturating_mul(20))
            }
            Self::LatLong { bands, azimuths } => {
                Some(bands.saturating_sub(1).saturating_mul(azimuths).saturating_mul(2))
            }
            Self::Adaptive { .. } => None,
        }
    }

    fn check(self, mean_radius: f64) -> Result<()> {
        let wrong = match self {
            Self::Icosphere { frequency: 0 } => "the frequency of an icosphere is at least 1",
            Self::LatLong { bands, azimuths } if bands < 2 || azimuths < 3 => {
                "a sphere by latitude and longitude takes at least 2 bands and 3 azimuths"
            }
            Self::Adaptive { tolerance } if !(tolerance > 0.0 && tolerance.is_finite()) => {
                "the chord error to reach is a positive number of metres"
            }
            // A sphere takes 4.8 faces for each of its radius over the error; a shape of that size
            // hardly less than a tenth of it.
            Self::Adaptive { tolerance } if mean_radius / tolerance > 2.0 * MAX_FACES as f64 => {
                return Err(adaptive::too_many_faces(tolerance));
            }
            _ => match self.faces() {
                Some(faces) if faces > MAX_FACES => {
                    return Err(Error::Parameter(format!(
                        "a mesh of {faces} faces is too large; at most {MAX_FACES} are made"
                    )));
                }
                _ => return Ok(()),
            },
        };
        Err(Error::Parameter(wrong.into()))
    }
}

/// Makes a mesh of the surface r = f(omega) about `centre`: closed, oriented outward and
/// star-shaped about the centre.
///
/// # Errors
/// [`Error::Parameter`] for a resolution out of range, more than [`MAX_FACES`] or a degree too
/// high; [`Error::Geometry`] where the radius is not positive.
///
/// ```
/// use glam::DVec3;
/// use harmolux::sh::Coefficients;
/// use harmolux::fit::{Resolution, tessellate};
///
/// let mut ball = Coefficients::zeros(0);
/// ball.set(0, 0, 2.0, 0.0);
/// let made = tessellate(&ball, DVec3::ZERO, Resolution::Adaptive { tolerance: 1e-2 })?;
/// assert!(made.chord_error.measured <= 1e-2);
/// # Ok::<(), harmolux::Error>(())
/// ```
pub fn tessellate(
    coefficients: &Coefficients,
    centre: DVec3,
    resolution: Resolution,
) -> Result<Tessellation> {
    let series = Evaluator::new(coefficients)?;
    let mesh = surface_mesh(&series, resolution)?;
    let corners: Vec<[DVec3; 3]> =
        (0..mesh.triangles().len()).map(|face| mesh.corners(face)).collect();
    let chord_error = chord_error::chord_error(&series, &corners)?;
    Ok(Tessellation { mesh: mesh.translated(centre), chord_error })
}

/// Makes the mesh alone, about the origin: see [`tessellate`].
pub(crate) fn surface_mesh(series: &Evaluator, resolution: Resolution) -> Result<Mesh> {
    let mean = series.coefficients().mean();
    resolution.check(mean)?;
    require_measurable("the mean radius", mean.abs()).map_err(|e| e.advise(Advice::AddRadius))?;
    ask_for(resolution.faces().unwrap_or(0))?;
    let sphere = match resolution {
        Resolution::Icosphere { frequency } => icosphere::icosphere(frequency),
        Resolution::LatLong { bands, azimuths } => lat_long::lat_long(bands, azimuths),
        Resolution::Adaptive { tolerance } => adaptive::adaptive(series, tolerance)?,
    };
    let mesh = Mesh::new(lift(series, &sphere.directions)?, sphere.triangles)?;
    // Between the vertices, too.
    require_positive(series.coefficients())?;
    Ok(mesh)
}

/// Asks for what the making of so many faces takes: 200 bytes each.
fn ask_for(faces: usize) -> Result<()> {
    let what = format_args!("a mesh of {faces} faces");
    memory::ask_each(faces, 200.0, what, "choose a coarser mesh")
}

/// Moves directions out to the surface.
fn lift(series: &Evaluator, directions: &[DVec3]) -> Result<Vec<DVec3>> {
    let radii: Vec<f64> = directions.par_iter().map(|w| series.value(*w)).collect();
    if let Some(i) = radii.iter().position(|r| !(*r > 0.0 && r.is_finite())) {
        let error = Error::Geometry(format!(
            "the radius towards {:.3} is {:.3e} (mean radius {:.3e}), but a surface needs a \
             positive one everywhere; choose another centre, or lower the degree or filter the \
             series if it rings",
            directions[i],
            radii[i],
            series.coefficients().mean()
        ));
        // A mean of heights tells nothing of their radius.
        let are_heights = series.coefficients().mean() <= -radii[i];
        return Err(if are_heights { error.advise(Advice::AddRadius) } else { error });
    }
    Ok(directions.iter().zip(radii).map(|(w, r)| r * *w).collect())
}

#[cfg(test)]
mod tests;
