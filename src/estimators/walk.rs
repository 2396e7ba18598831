//! Random walks of light: from a point light or an emitting surface, from hit to hit, until
//! absorbed by Russian roulette.
//!
//! Q_n is the flux that arrives at hit y_n (Q_1 = Phi for one walk; averages over walks divide by
//! their number). Whatever stands at y_n uses Q_n f G V; only then Q_(n+1) = Q_n f cos / pdf.

use glam::{DVec2, DVec3};

use rayon::prelude::*;

use crate::math::{Randomness, Ray, Rgb, Stream, hash, sampling};
use crate::scene::{Emitter, PointLight, Scene, Vertex};
use crate::{Error, Result};

/// Holds a point of a walk that can be connected to receivers.
#[derive(Debug, Clone, Copy)]
pub struct Node<'a> {
    /// Where.
    pub vertex: Vertex<'a>,
    /// The flux that leaves an emitting surface here, or arrives at a hit, lm; that of all hits it
    /// stands for in a long walk.
    pub flux: Rgb,
    /// For the start on an emitting surface: the density, 1/m2, with which walks start here. `None`
    /// at a hit.
    pub start_density: Option<f64>,
    /// Whether the light came by mirrors from a point light, or from a node of which this holds: no
    /// ray backwards from here can find where it came from.
    pub caustic: bool,
}

impl Node<'_> {
    /// Whether place, normal and flux are numbers. Another node is the last of its walk, which it
    /// spoils.
    pub(super) fn is_sound(&self) -> bool {
        self.vertex.is_sound() && self.flux.is_finite()
    }
}

/// Holds a finished walk.
#[derive(Default)]
pub(super) struct Walked<'a> {
    /// Its start on an emitting surface, and its hits.
    pub(super) nodes: Vec<Node<'a>>,
    /// How it left an open scene.
    pub(super) escape: Option<(Ray, Rgb)>,
}

impl Walked<'_> {
    /// Returns the flux that left the scene.
    pub(super) fn escaped(&self) -> f64 {
        self.escape.map_or(0.0, |(_, flux)| flux.luminance())
    }
}

/// The share of its first flux below which a walk plays Russian roulette. Earlier, roulette would
/// save less than its variance costs: in `paper_figure_3`, which reflects about half, this takes
/// 0.6 of the time to a given error that roulette at every hit takes; starting one hit earlier or
/// later takes a tenth more than this.
const FAINT: f64 = 0.25;

/// The walks that look for caustics, and the seed of their own.
const WALKS_FOR_CAUSTICS: u64 = 4096;
const CAUSTICS: u64 = 0xca;

/// Starts walks on all lights of a scene, each in proportion to its power.
pub struct Launcher<'a> {
    scene: &'a Scene,
    sources: Vec<Source<'a>>,
    /// Ascending sums of the sources' powers, lm.
    cumulative: Vec<f64>,
}

#[derive(Clone, Copy)]
enum Source<'a> {
    Point(&'a PointLight),
    Surface(&'a Emitter),
}

impl<'a> Launcher<'a> {
    /// Collects the lights of a scene.
    ///
    /// # Errors
    /// [`Error::Parameter`] when no light of the scene has any power, or one more than numbers can
    /// hold.
    pub fn new(scene: &'a Scene) -> Result<Self> {
        let points = scene.lights().iter().map(|l| (Source::Point(l), l.flux().luminance()));
        if let Some(light) = scene.lights().iter().find(|l| !l.flux().luminance().is_finite()) {
            return Err(Error::Parameter(format!(
                "the flux of light `{}` is not finite; reduce its intensity",
                light.name
            )));
        }
        let surfaces = scene.emitters().iter().map(|e| (Source::Surface(e), e.power));
        let mut total = 0.0;
        let (mut sources, mut cumulative) = (Vec::new(), Vec::new());
        for (source, power) in points.chain(surfaces).filter(|(_, power)| *power > 0.0) {
            total += power;
            sources.push(source);
            cumulative.push(total);
        }
        if sources.is_empty() {
            return Err(Error::Parameter(
                "the scene has no light; add a [lights.NAME.point] or give a material an exitance"
                    .into(),
            ));
        }
        Ok(Self { scene, sources, cumulative })
    }

    /// Returns the power, lm, that all sources are counted with when one is picked.
    pub fn power(&self) -> f64 {
        self.cumulative.last().copied().unwrap_or(0.0)
    }

    /// Returns the density, 1/m2, with which walks start at a point of an emitting object.
    pub fn start_density(&self, vertex: &Vertex) -> f64 {
        let emitter = self.scene.emitters().iter().find(|e| e.object == vertex.object);
        let surface = self.scene.objects()[vertex.object].area.as_ref();
        match (emitter, surface) {
            (Some(e), Some(s)) => e.power / self.power() * s.density(&vertex.hit),
            _ => 0.0,
        }
    }

    /// Returns the share of all light, 0 to 1, that point lights shed on mirrors and these send on,
    /// looked up by some thousand rays. A receiver gets none of it straight, since no ray from
    /// there can find a point in a mirror. (From surfaces that emit it gets that, too.)
    pub(super) fn caustic_share(&self, randomness: Randomness, seed: u64) -> f64 {
        if !self.scene.has_mirrors() || self.scene.lights().is_empty() {
            return 0.0;
        }
        let seed = hash([seed, CAUSTICS]);
        let caustic = |index| -> f64 {
            let [u, v, pick, _] = Stream::new(randomness, seed, index).next_4d();
            let Source::Point(light) = self.sources[sampling::discrete(&self.cumulative, pick).0]
            else {
                return 0.0;
            };
            let (ray, flux) = self.leave_point(light, [u, v]);
            let mirrored = self.scene.vertex(&ray).and_then(|vertex| vertex.mirrored());
            mirrored.map_or(0.0, |(_, reflectance)| (flux * reflectance).luminance())
        };
        let flux: f64 =
            (0..WALKS_FOR_CAUSTICS).into_par_iter().map(caustic).collect::<Vec<_>>().iter().sum();
        flux / (self.power() * WALKS_FOR_CAUSTICS as f64)
    }

    /// Follows one walk, adds its nodes to `nodes` and returns the flux that escaped from the
    /// scene.
    pub fn walk(&self, stream: &mut Stream, nodes: &mut Vec<Node<'a>>) -> Rgb {
        self.run(stream, nodes, &|| false).map_or(Rgb::BLACK, |(_, flux)| flux)
    }

    /// Follows one walk to its end, or until `ends` says that it is not needed.
    pub(super) fn follow(&self, stream: &mut Stream, ends: &dyn Fn() -> bool) -> Walked<'a> {
        let mut nodes = Vec::new();
        let escape = self.run(stream, &mut nodes, ends);
        Walked { nodes, escape }
    }

    /// Follows one walk and returns the ray and the flux with which it left the scene.
    fn run(
        &self,
        stream: &mut Stream,
        nodes: &mut Vec<Node<'a>>,
        ends: &dyn Fn() -> bool,
    ) -> Option<(Ray, Rgb)> {
        let before = nodes.len();
        let (mut ray, mut flux) = self.leave(stream, nodes)?;
        let faint = FAINT * flux.luminance();
        let mut thinning = Thinning::default();
        // Of what the light came from last that is no mirror: whether nothing finds it by a ray.
        let mut hidden = nodes.len() == before;
        let mut mirrored = false;
        loop {
            if thinning.hits % ASKED_EVERY == ASKED_EVERY - 1 && ends() {
                return None;
            }
            let Some(vertex) = self.scene.vertex(&ray) else { return Some((ray, flux)) };
            let caustic = hidden && mirrored;
            let node = Node { vertex, flux, start_density: None, caustic };
            if !node.is_sound() {
                // It would outlive every roulette; who looks at the walk counts it as non-finite.
                nodes.push(node);
                return None;
            }
            nodes.extend(thinning.take(node, stream));
            let [u, v, roulette, choice] = stream.next_4d();
            let (direction, weight, by_mirror) = reflect(&vertex, [u, v], choice)?;
            if by_mirror {
                mirrored = true;
            } else {
                (hidden, mirrored) = (caustic, false);
            }
            let next = flux * weight;
            let survival = (next.luminance() / faint).min(1.0);
            if roulette >= survival {
                return None;
            }
            flux = next / survival;
            ray = vertex.hit.leave(direction);
        }
    }

    /// Starts a walk at one of the sources; the start on a surface is its first node.
    fn leave(&self, stream: &mut Stream, nodes: &mut Vec<Node<'a>>) -> Option<(Ray, Rgb)> {
        let [u, v, pick, along] = stream.next_4d();
        let (index, rest) = sampling::discrete(&self.cumulative, pick);
        match self.sources[index] {
            Source::Point(light) => Some(self.leave_point(light, [u, v])),
            Source::Surface(emitter) => {
                let start = self.start_on(emitter, DVec2::new(rest, along))?;
                nodes.push(start);
                let direction = crate::math::Frame::about(start.vertex.hit.normal)
                    .to_world(sampling::cosine_hemisphere([u, v]));
                Some((start.vertex.hit.leave(direction), start.flux))
            }
        }
    }

    fn leave_point(&self, light: &PointLight, u: [f64; 2]) -> (Ray, Rgb) {
        let share = light.flux().luminance() / self.power();
        let (direction, flux) = light.sample(u);
        (Ray::new(light.at, direction), flux / share)
    }

    fn start_on(&self, emitter: &Emitter, u: DVec2) -> Option<Node<'a>> {
        let object = &self.scene.objects()[emitter.object];
        let point = object.area.as_ref()?.sample_area(u);
        // Emission knows the true surface alone.
        let vertex = self.scene.vertex_at(emitter.object, point.hit, point.hit.normal);
        let vertex = Vertex { normal: point.hit.normal, ..vertex };
        let density = emitter.power / self.power() * point.density;
        let exitance = vertex.material.exitance;
        (density > 0.0 && !exitance.is_black()).then(|| Node {
            vertex,
            flux: exitance / density,
            start_density: Some(density),
            caustic: false,
        })
    }
}

/// Thins the hits of a long walk out, so that its memory grows with the logarithm of its length:
/// after [`ALL_KEPT`] hits one of two is kept and stands for both, after as many more one of four,
/// and so on.
#[derive(Default)]
struct Thinning {
    hits: u64,
    /// Which hit of the present stride is kept.
    chosen: u64,
}

/// After how many hits of a walk each time it is asked whether it is still needed.
const ASKED_EVERY: u64 = 256;

/// How many hits of a walk are kept at each stride.
const ALL_KEPT: u64 = 64;

impl Thinning {
    /// Returns a hit as it is to be kept, if at all: of each stride one, drawn at random.
    fn take<'a>(&mut self, node: Node<'a>, stream: &mut Stream) -> Option<Node<'a>> {
        // Strides 1, 2, 4, ... hold ALL_KEPT kept hits each, so they begin at ALL_KEPT (stride -
        // 1).
        let stride = 1_u64 << (self.hits / ALL_KEPT + 1).ilog2();
        let place = (self.hits - ALL_KEPT * (stride - 1)) % stride;
        if place == 0 && stride > 1 {
            self.chosen = (stream.next_4d()[0] * stride as f64) as u64;
        }
        self.hits += 1;
        (place == self.chosen).then(|| Node { flux: node.flux * stride as f64, ..node })
    }
}

/// Samples how light goes on from a vertex: the direction, the weight, and whether by a mirror.
fn reflect(vertex: &Vertex, u: [f64; 2], choice: f64) -> Option<(DVec3, Rgb, bool)> {
    let mirrored = vertex.mirrored();
    let adjoint = |direction| vertex.adjoint(direction);
    let by_mirror = mirrored.map_or(0.0, |(_, reflectance)| {
        reflectance.luminance() / (reflectance.luminance() + vertex.albedo())
    });
    match mirrored {
        Some((direction, reflectance)) if choice < by_mirror => {
            let weight = reflectance / by_mirror * adjoint(direction)?;
            Some((direction, weight, true))
        }
        _ => {
            let sample = vertex.brdf().sample(vertex.normal, vertex.outgoing, u)?;
            let weight = sample.weight / (1.0 - by_mirror) * adjoint(sample.direction)?;
            Some((sample.direction, weight, false))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Material, Object};
    use crate::surface::primitives::Sphere;

    /// A lamp in the middle of a white sphere: its walks are long.
    fn sphere(reflectance: f64) -> Scene {
        let wall = Sphere::new(DVec3::ZERO, 1.0).expect("valid").turned_inward(true);
        let white = Material::lambert(Rgb::grey(reflectance)).expect("valid");
        let lamp = PointLight::isotropic("lamp", DVec3::ZERO, Rgb::WHITE);
        Scene::new(vec![Object::new("wall", wall, white)], vec![lamp]).expect("valid")
    }

    #[test]
    fn long_walks_are_thinned_out_and_keep_their_light() {
        let scene = sphere(0.995);
        let launcher = Launcher::new(&scene).expect("there is light");
        let (count, mut sum, mut longest) = (400, 0.0, 0);
        for i in 0..count {
            let mut nodes = Vec::new();
            launcher.walk(&mut Stream::new(Randomness::Sobol, 7, i), &mut nodes);
            sum += nodes.iter().map(|n| n.flux.luminance()).sum::<f64>() / launcher.power();
            longest = longest.max(nodes.len());
        }
        // What arrives is 1 / (1 - reflectance) times what is sent; lengths are as good as
        // exponential, so the mean of 400 has a standard error of 5 %, less for Sobol's points.
        // Four of them.
        let mean = sum / f64::from(count as u32);
        assert!((mean * 0.005 - 1.0).abs() <= 0.2, "{mean}");
        assert!(longest < 64 * 6, "{longest}");
    }

    #[test]
    fn each_stride_keeps_one_hit_that_stands_for_all() {
        let scene = sphere(0.5);
        let launcher = Launcher::new(&scene).expect("there is light");
        let mut nodes = Vec::new();
        let mut stream = Stream::new(Randomness::Pseudorandom, 1, 0);
        launcher.walk(&mut stream, &mut nodes);
        let node = Node { flux: Rgb::WHITE, ..nodes[0] };
        let mut thinning = Thinning::default();
        // Strides 1, 2, 4 and 8, each of 64 kept hits.
        let kept = (0..64 * 15).filter_map(|_| thinning.take(node, &mut stream));
        let fluxes: Vec<f64> = kept.map(|n| n.flux.luminance()).collect();
        assert_eq!(fluxes.len(), 4 * 64);
        for (stride, fluxes) in [1.0, 2.0, 4.0, 8.0].into_iter().zip(fluxes.chunks(64)) {
            assert!(fluxes.iter().all(|flux| (flux - stride).abs() <= 1e-12), "{stride}");
        }
    }

    #[test]
    fn share_of_mirrors_is_that_of_the_first_hits() {
        let ball = Sphere::new(DVec3::new(0.0, 0.0, 2.0), 1.0).expect("valid");
        let mirror = Material::mirror(Rgb::grey(0.8)).expect("valid");
        let lamp = PointLight::isotropic("lamp", DVec3::ZERO, Rgb::WHITE);
        let scene = Scene::new(vec![Object::new("ball", ball, mirror)], vec![lamp]).expect("valid");
        let launcher = Launcher::new(&scene).expect("there is light");
        // The ball fills a cone with the sine 1/2: its share of all directions, of which 0.8 go on.
        let exact = 0.8 * 0.5 * (1.0 - 0.75_f64.sqrt());
        let found = launcher.caustic_share(Randomness::Sobol, 1);
        assert!((found / exact - 1.0).abs() <= 0.01, "{found} {exact}");
    }
}
