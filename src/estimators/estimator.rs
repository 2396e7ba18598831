//! The choice of an estimator.

use super::radiosity::RadiositySettings;
use super::weighting::Weighting;

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
