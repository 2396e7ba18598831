//! What a camera sees of the shapes alone: normal, depth, object and albedo of the first surface,
//! mirrors included. No light is needed and nothing is random: equal scenes give equal layers.

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use crate::math::choice::choice;
use crate::math::{Ray, Rgb};

use super::{Brdf, Camera, Filter, Scene, Vertex};

/// Names a layer of a picture.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Layer {
    /// Light that met no other surface on its way from its source to the one that is seen, and what
    /// that emits itself.
    Direct,
    /// All other light.
    Indirect,
    /// The shading normal in the axes of the room, turned to the eye.
    Normal,
    /// The distance from the eye, metres.
    Depth,
    /// Which object it is.
    Id,
    /// The part of light that is reflected.
    Albedo,
}

choice!(Layer, "layer":
    Direct = "direct" "",
    Indirect = "indirect" "",
    Normal = "normal" "",
    Depth = "depth" "",
    Id = "id" "",
    Albedo = "albedo" "",
);

/// Positions under the filter at which a pixel takes normal and albedo: a lattice of the unit
/// square, the same for every pixel.
const SAMPLES: usize = 4;

/// Computes layers of the window of a camera, row by row from the top left, from the first hits of
/// its rays.
#[derive(Clone, Copy)]
pub struct FirstHits<'a> {
    /// What is seen.
    pub scene: &'a Scene,
    /// Who sees it, and which window of it counts.
    pub camera: &'a Camera,
    /// How positions weigh in a pixel.
    pub filter: Filter,
}

impl FirstHits<'_> {
    /// Returns the distance from the eye, metres, along the ray through the middle of each pixel;
    /// infinite where nothing is seen.
    pub fn depth(&self) -> Vec<f32> {
        self.middles(|_, hit| hit.distance as f32, f32::INFINITY)
    }

    /// Returns the number of the object, from 1 in the order of the scene, at the middle of each
    /// pixel; 0 where nothing is seen.
    pub fn id(&self) -> Vec<f32> {
        self.middles(|object, _| (object + 1) as f32, 0.0)
    }

    /// Returns the shading normals in the axes of the room, turned to the eye, averaged under the
    /// filter: shorter than 1 at edges, 0 where nothing is seen.
    pub fn normal(&self) -> [Vec<f32>; 3] {
        self.averaged(|vertex| vertex.normal.to_array())
    }

    /// Returns the part of light that the surface reflects towards the eye, averaged under the
    /// filter; 0 where nothing is seen.
    pub fn albedo(&self) -> [Vec<f32>; 3] {
        self.averaged(|vertex| reflected(vertex).0)
    }

    /// Takes the first hit at the middle of every pixel.
    fn middles(
        &self,
        value: impl Fn(usize, &crate::surface::Hit) -> f32 + Sync,
        nothing: f32,
    ) -> Vec<f32> {
        let at = |corner: DVec2| {
            let hit = self.camera.ray(corner + 0.5).and_then(|ray| self.scene.hit(&ray));
            hit.map_or(nothing, |(object, hit)| value(object, &hit))
        };
        self.corners().into_par_iter().flat_map_iter(|row| row.map(at)).collect()
    }

    /// Averages a value of the first vertices under the filter of every pixel.
    fn averaged(&self, value: impl Fn(&Vertex) -> [f64; 3] + Sync) -> [Vec<f32>; 3] {
        let offsets: [DVec2; SAMPLES] = std::array::from_fn(|k| self.filter.sample(lattice(k + 1)));
        let at = |corner: DVec2| {
            let rays = offsets.iter().filter_map(|offset| self.camera.ray(corner + 0.5 + *offset));
            let vertices = rays.filter_map(|ray: Ray| self.scene.vertex(&ray));
            let sum = vertices.map(|v| DVec3::from_array(value(&v))).sum::<DVec3>();
            (sum / SAMPLES as f64).as_vec3()
        };
        let values: Vec<_> =
            self.corners().into_par_iter().flat_map_iter(|row| row.map(at)).collect();
        std::array::from_fn(|k| values.iter().map(|v| v[k]).collect())
    }

    /// Returns the upper left corners of the pixels, row by row.
    fn corners(&self) -> Vec<impl Iterator<Item = DVec2> + use<>> {
        let window = self.camera.window();
        let ([x0, y0], [x1, y1]) = (window.min(), window.max());
        let row = |y: u32| (x0..x1).map(move |x| DVec2::new(f64::from(x), f64::from(y)));
        (y0..y1).map(row).collect()
    }
}

/// Returns the reflected part of white light, in its colours: of a diffuse surface its reflectance;
/// of others what they mirror, and of the rest the mean over a few directions, with the exact
/// luminance.
fn reflected(vertex: &Vertex) -> Rgb {
    let brdf = vertex.brdf();
    if let Brdf::Lambert { reflectance } = brdf {
        return *reflectance;
    }
    // A pixel has as many vertices; each is looked at along a few ways.
    let ways = (1..=SAMPLES).map(lattice);
    let ways = ways.filter_map(|u| brdf.sample(vertex.normal, vertex.outgoing, u));
    let mean = ways.map(|way| way.weight).sum::<Rgb>();
    let luminance = mean.luminance();
    let rest = if luminance > 0.0 { mean * (vertex.albedo() / luminance) } else { Rgb::BLACK };
    brdf.mirror() + rest
}

/// Returns the k-th point of the plastic lattice of the unit square: any few of them are spread
/// evenly.
fn lattice(k: usize) -> [f64; 2] {
    [0.754_877_666_246_693, 0.569_840_290_998_053].map(|step| (step * k as f64).fract())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{FisheyeMapping, Glossy, Material, Object, Window};
    use crate::surface::primitives::{AxisBox, Rectangle};

    /// A green wall 4 m before the eye at x = 0 .. 3 and z = 0 .. 3, a metal box before its lower
    /// left corner, and nothing elsewhere.
    fn scene() -> Scene {
        let green = Material::lambert(Rgb([0.2, 0.6, 0.1])).expect("valid");
        let metal = Glossy::metal(Rgb([0.9, 0.6, 0.3]), 0.4).expect("valid");
        let wall = Rectangle::new(DVec3::Y * 4.0, DVec3::X * 3.0, DVec3::Z * 3.0).expect("valid");
        let crate_ = AxisBox::new(DVec3::new(0.0, 2.0, 0.0), DVec3::new(1.0, 3.0, 1.0));
        let objects = vec![
            Object::new("wall", wall, green),
            Object::new("crate", crate_.expect("valid"), Material::glossy(metal)),
        ];
        Scene::new(objects, Vec::new()).expect("valid")
    }

    /// A film of 4 x 4 m with its lower left corner at x = 0, z = 0: pixels of half a metre.
    fn camera() -> Camera {
        let from = DVec3::new(2.0, 0.0, 2.0);
        Camera::orthographic(from, from + DVec3::Y, 4.0, [8, 8]).expect("valid")
    }

    #[test]
    fn layers_tell_the_first_surface() {
        let (scene, camera) = (scene(), camera());
        let hits = FirstHits { scene: &scene, camera: &camera, filter: Filter::Box };
        let (depth, id) = (hits.depth(), hits.id());
        let ([x, y, z], [r, g, b]) = (hits.normal(), hits.albedo());
        // Top left is nothing, right of the middle the wall, bottom left the crate.
        let at = |column: usize, row: usize| 8 * row + column;
        for (pixel, distance, number) in
            [(at(0, 0), f32::INFINITY, 0.0), (at(4, 4), 4.0, 1.0), (at(0, 7), 2.0, 2.0)]
        {
            assert_eq!((depth[pixel], id[pixel]), (distance, number), "{pixel}");
            let expected = if number == 0.0 { [0.0; 3] } else { [0.0, -1.0, 0.0] };
            assert_eq!([x[pixel], y[pixel], z[pixel]], expected);
        }
        assert_eq!([r[at(4, 4)], g[at(4, 4)], b[at(4, 4)]], [0.2, 0.6, 0.1]);
        assert_eq!([r[0], g[0], b[0]], [0.0; 3]);
        // A metal has its own colour; between the facets some of the red and more of the blue is
        // lost or scattered.
        let metal = [r, g, b].map(|c| f64::from(c[at(0, 7)]));
        assert!(metal[0] > metal[1] && metal[1] > metal[2], "{metal:?}");
        let luminance = Rgb(metal).luminance();
        assert!((luminance - 0.64).abs() <= 0.05, "{luminance}");
    }

    #[test]
    fn windows_of_layers_are_parts_of_the_whole() {
        let scene = scene();
        let eye = DVec3::new(1.0, 0.5, 1.2);
        let mapping = FisheyeMapping::Equidistant;
        let whole = Camera::fisheye(eye, eye + DVec3::Y, mapping, 3.0, [24, 20]).expect("valid");
        let window = Window::new([5, 3], [17, 19]).expect("valid");
        let part = whole.with_window(window).expect("within");
        let hits = |camera| FirstHits { scene: &scene, camera, filter: Filter::Gaussian };
        let (all, some) = (hits(&whole), hits(&part));
        let cut = |values: &[f32]| -> Vec<f32> {
            values.chunks(24).take(19).skip(3).flat_map(|row| &row[5..17]).copied().collect()
        };
        assert_eq!(cut(&all.depth()), some.depth());
        assert_eq!(cut(&all.id()), some.id());
        for (all, some) in all.normal().iter().zip(some.normal()) {
            assert_eq!(cut(all), some);
        }
        for (all, some) in all.albedo().iter().zip(some.albedo()) {
            assert_eq!(cut(all), some);
        }
    }
}
