//! Light that comes straight from point lights: exact, so it has no variance. At a light itself it is without bounds, and NaN.

use crate::math::{Ray, Rgb};
use crate::scene::Scene;

use super::receiver::Receiver;

/// Gives, for every point light that sheds light on the receiver, I W / d^2 and the ray on which nothing may stand.
pub(super) fn connections(scene: &Scene, receiver: &Receiver) -> impl Iterator<Item = (Ray, Rgb)> {
    scene.lights().iter().filter_map(|light| {
        let to_light = light.at - receiver.hit.point;
        let distance2 = to_light.length_squared();
        let direction = to_light / distance2.sqrt();
        let light_there = light.towards(-direction) * receiver.response(direction);
        if light_there.is_black() {
            return None;
        }
        let ray = Ray::between(receiver.hit.departure(direction), light.at)?;
        Some((ray, light_there / distance2))
    })
}

/// Adds up I W / d^2 over the point lights that the receiver sees.
pub(super) fn point_lights(scene: &Scene, receiver: &Receiver) -> Rgb {
    let seen = connections(scene, receiver).filter(|(ray, _)| !scene.blocked(ray));
    seen.map(|(_, light)| light).sum()
}
