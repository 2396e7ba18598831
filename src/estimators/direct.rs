//! Light that comes straight from point lights: exact, so it has no variance.

use crate::math::Rgb;
use crate::scene::Scene;

use super::connect::Receiver;

/// Adds up I W / d^2 over the point lights that the receiver sees.
pub(super) fn point_lights(scene: &Scene, receiver: &Receiver) -> Rgb {
    scene
        .lights()
        .iter()
        .map(|light| {
            let to_light = light.at - receiver.hit.point;
            let distance2 = to_light.length_squared();
            let direction = to_light / distance2.sqrt();
            let response = receiver.response(direction);
            if response.is_black() || !scene.sees_point(&receiver.hit, light.at, direction) {
                return Rgb::BLACK;
            }
            light.intensity * response / distance2
        })
        .sum()
}
