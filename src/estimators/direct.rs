//! Light that comes straight from point lights. At a light itself it is without bounds, and NaN.

use crate::math::{Ray, Rgb, Stream};
use crate::scene::Scene;

use super::receiver::Receiver;

/// The most point lights that are all asked for each sample of a pixel or each end of a gathering
/// ray; of more, so many are drawn.
const MOST: usize = 8;

/// Below this step, numbers are too coarse to draw by.
const FAINTEST: f64 = 1e-290;

/// Returns, for every point light that sheds light on the receiver, I W / d^2 and the ray on which
/// nothing may stand.
fn connections(scene: &Scene, receiver: &Receiver) -> impl Iterator<Item = (Ray, Rgb)> {
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

/// Hands `take` what a few point lights shed on the receiver, I W / d^2, with the ray on which
/// nothing may stand; together they have the mean of all. When there are many, they are drawn in
/// proportion to their light, at even distances from a random start.
pub(super) fn few_connections(
    scene: &Scene,
    receiver: &Receiver,
    stream: &mut Stream,
    mut take: impl FnMut((Ray, Rgb)),
) {
    if scene.lights().len() <= MOST {
        connections(scene, receiver).for_each(take);
        return;
    }
    let all: Vec<(Ray, Rgb)> = connections(scene, receiver).collect();
    let step = all.iter().map(|(_, light)| light.luminance()).sum::<f64>() / MOST as f64;
    if step < FAINTEST {
        all.into_iter().for_each(take);
        return;
    }
    let [start, ..] = stream.next_4d();
    let (mut sum, mut next) = (0.0, start * step);
    for (ray, light) in all {
        let own = light.luminance();
        sum += own;
        let mut times = 0_u32;
        while next < sum {
            next += step;
            times += 1;
        }
        if times > 0 {
            take((ray, light * (f64::from(times) * step / own)));
        }
    }
}

/// Adds up I W / d^2 over the point lights that the receiver sees; many are drawn from.
pub(super) fn few_point_lights(scene: &Scene, receiver: &Receiver, stream: &mut Stream) -> Rgb {
    let mut sum = Rgb::BLACK;
    few_connections(scene, receiver, stream, |(ray, light)| {
        if !scene.blocked(&ray) {
            sum += light;
        }
    });
    sum
}

/// Adds up I W / d^2 over all point lights that the receiver sees: exact.
pub(super) fn point_lights(scene: &Scene, receiver: &Receiver) -> Rgb {
    let seen = connections(scene, receiver).filter(|(ray, _)| !scene.blocked(ray));
    seen.map(|(_, light)| light).sum()
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::math::Randomness;
    use crate::scene::{PointLight, Sensor};

    #[test]
    fn few_of_many_lights_have_the_mean_of_all() {
        let lamp = |i: u32| {
            let x = f64::from(i);
            let intensity = if i == 7 { 500.0 } else { 1.0 + x.sin().abs() };
            PointLight::isotropic("", DVec3::new(x, 1.0, 2.0), Rgb::grey(intensity))
        };
        let scene = Scene::new(vec![], (0..40).map(lamp).collect()).expect("valid");
        let receiver = Receiver::sensor(&Sensor::plane(DVec3::new(3.0, 0.0, 0.0), DVec3::Z));
        let all = point_lights(&scene, &receiver).luminance();
        let n = 512;
        let mut asked = 0;
        let sum: f64 = (0..n)
            .map(|i| {
                let mut stream = Stream::new(Randomness::Sobol, 3, i);
                few_connections(&scene, &receiver, &mut stream, |_| asked += 1);
                let mut stream = Stream::new(Randomness::Sobol, 3, i);
                few_point_lights(&scene, &receiver, &mut stream).luminance()
            })
            .sum();
        // In proportion to the light itself every draw gives the same sum.
        assert!((sum / n as f64 / all - 1.0).abs() <= 1e-9, "{sum} {all}");
        assert!(asked <= n as usize * MOST);
    }
}
