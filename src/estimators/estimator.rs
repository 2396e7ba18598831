//! The choice of an estimator, and what sets it.

use super::replicates::Stop;
use super::weighting::Weighting;
use crate::math::Randomness;
use crate::{Error, Result};

/// Chooses how light is estimated.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Estimator {
    /// Local estimates: one walk from the lights serves all sensors (light tracing to points), and
    /// what pixels see (the double local estimate). At sensors that a pilot of 32 walks finds
    /// bright for the size of the scene a bounded kernel has a greater bound, so that no hit brings
    /// more than sixteen times the illuminance there.
    Local(Weighting),
    /// Backward path tracing, the reference.
    Path,
    /// Radiosity, for sensors: no statistical error, that of the patches is not known. Of the stop
    /// only the time counts.
    Radiosity(RadiositySettings),
    /// Photons counted on a disc about each sensor. The intervals are those of the mean over the
    /// disc, not of its centre.
    Photon {
        /// The radius of the discs, metres, above 0; when left out they have a ten thousandth of
        /// the total area of the scene.
        radius: Option<f64>,
    },
}

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

impl RadiositySettings {
    pub(super) fn check(&self) -> Result<()> {
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

/// Sets a survey.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SensorSettings {
    /// How illuminance is estimated.
    pub estimator: Estimator,
    /// Where random numbers come from.
    pub randomness: Randomness,
    /// The seed: the same seed gives the same bytes on any number of threads.
    pub seed: u64,
    /// When to stop; the error is the largest relative 95 % half width over the sensors.
    pub stop: Stop,
}
