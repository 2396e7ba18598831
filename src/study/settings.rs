//! What a scene file asks of the estimators.

use crate::estimators::{
    Estimator, ImageSettings, RadiositySettings, SensorSettings, Stop, Weighting,
};
use crate::io::scene_file::{IllumEstimator, IllumSpec, RenderEstimator, RenderSpec, StopSpec};
use crate::math::Randomness;
use crate::scene::Scene;

impl From<StopSpec> for Stop {
    fn from(StopSpec { relative_error, time, walks }: StopSpec) -> Self {
        Self { relative_error, time, walks }
    }
}

/// Returns how a picture of a scene is estimated.
pub fn image_settings(spec: &RenderSpec, scene: &Scene) -> ImageSettings {
    ImageSettings {
        estimator: match spec.estimator {
            RenderEstimator::DoubleLocal => Estimator::Local(Weighting::of(scene)),
            RenderEstimator::DoubleLocalA => Estimator::Local(Weighting::Walk),
            RenderEstimator::DoubleLocalB => Estimator::Local(Weighting::Gather),
            RenderEstimator::Path => Estimator::Path,
        },
        randomness: Randomness::Sobol,
        seed: spec.seed,
        stop: spec.stop.into(),
        filter: spec.filter,
    }
}

/// Returns how the illuminance at the sensors of a scene is estimated.
pub fn sensor_settings(spec: &IllumSpec, scene: &Scene) -> SensorSettings {
    let mut stop = Stop::from(spec.stop);
    let estimator = match spec.estimator {
        IllumEstimator::Local => Estimator::Local(Weighting::of(scene)),
        IllumEstimator::Path => Estimator::Path,
        IllumEstimator::Photon => Estimator::Photon { radius: spec.radius },
        IllumEstimator::Radiosity => {
            // Where no error is known none can be asked for.
            stop = Stop { relative_error: None, walks: None, ..stop };
            let default = RadiositySettings::default();
            let patches = spec.patches.unwrap_or(default.patches);
            Estimator::Radiosity(RadiositySettings { patches, ..default })
        }
    };
    // Counts are whole numbers: evenly spread walks can give all replicates the same one, and an
    // interval without width.
    let randomness = match estimator {
        Estimator::Photon { .. } => Randomness::Pseudorandom,
        _ => Randomness::Sobol,
    };
    SensorSettings { estimator, randomness, seed: spec.seed, stop }
}
