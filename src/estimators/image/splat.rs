//! Walks connected to the camera: the light that eye rays cannot find.
//!
//! A point light in a mirror shines on surfaces where no ray from there finds it again, so that
//! such light comes into a picture by the walks alone ([`Node::caustic`]): each of those nodes y
//! adds Q f V h(x) dx/dA to the pixels about its image x, h the filter of a pixel and dx/dA the
//! film area per area of the surface. It is the light tracing of Dutre, Lafortune and Willems
//! (1993). Seen in a mirror those places stay dark: neither eye rays nor walks go there.

use glam::DVec2;

use crate::math::{Ray, Rgb};
use crate::scene::{Camera, Filter, Scene};

use super::super::connect::SplitLight;
use super::super::walk::Node;

/// Adds the caustic nodes of walks, each with a weight, to the samples of all pixels of a camera's
/// window.
pub(super) fn add<'a>(
    scene: &Scene,
    camera: &Camera,
    filter: Filter,
    nodes: impl Iterator<Item = &'a Node<'a>>,
    weight: f64,
    samples: &mut [SplitLight],
) {
    for node in nodes.filter(|node| node.caustic) {
        if let Some((film, light)) = seen(scene, camera, node) {
            for film in camera.repeats(film, filter.radius()) {
                spread(camera, filter, film, light * weight, samples);
            }
        }
    }
}

/// Returns where on the film a node is seen, and its light times the film area it lights, cd/m2
/// pixels^2; `None` when it is hidden.
fn seen(scene: &Scene, camera: &Camera, node: &Node) -> Option<(DVec2, Rgb)> {
    let vertex = &node.vertex;
    let image = camera.project(vertex.hit.point)?;
    // A shading normal may see what the surface itself turns away from.
    if vertex.hit.normal.dot(image.towards) * vertex.hit.normal.dot(vertex.outgoing) <= 0.0 {
        return None;
    }
    let reflected =
        vertex.brdf().eval(vertex.normal, vertex.outgoing, image.towards) * vertex.arriving();
    if reflected.is_black() {
        return None;
    }
    let eye = vertex.hit.point + image.towards * image.distance;
    let ray = Ray::between(vertex.hit.departure(image.towards), eye)?;
    let cos = vertex.hit.normal.dot(image.towards).abs();
    (!scene.blocked(&ray)).then(|| (image.film, node.flux * reflected * (image.density * cos)))
}

/// Divides light among the pixels whose filters reach a place on the film.
fn spread(camera: &Camera, filter: Filter, film: DVec2, light: Rgb, samples: &mut [SplitLight]) {
    let window = camera.window();
    let ([left, top], [width, height]) = (window.min(), window.size());
    let reach = filter.radius();
    // The pixels, counted in the window, whose middles are within reach.
    let range = |x: f64, first: u32, count: u32| {
        let x = x - f64::from(first) - 0.5;
        let from = (x - reach).ceil().clamp(0.0, f64::from(count));
        let to = ((x + reach).floor() + 1.0).clamp(0.0, f64::from(count));
        from as usize..to as usize
    };
    for row in range(film.y, top, height) {
        for column in range(film.x, left, width) {
            let middle =
                DVec2::new(column as f64 + f64::from(left), row as f64 + f64::from(top)) + 0.5;
            let weight = filter.density(film - middle);
            samples[row * width as usize + column].indirect += light * weight;
        }
    }
}
