//! The core of the local estimates: what the nodes of a walk contribute to a receiver.
//!
//! A receiver answers light from a direction by W(omega): the cosine for illuminance, f cos for the luminance of a surface seen by an eye; sensors
//! and pixels differ in nothing else. A node y of a walk contributes Q f(y) G V W/cos (eq. 5, 11), where G = cos cos' / d^2 is singular at
//! d = 0. A weighting leaves the share c(G) of that to the connection and the rest 1 - c to a ray that gathers from the receiver (Kollig and Keller, 2004):
//! it finds y' and adds (1 - c) W/pdf [direct light at y' + the same walk's nodes seen from y'], recursively. Both together are unbiased for
//! every c; a bounded c G makes the variance finite.

use std::f64::consts::PI;

use glam::DVec3;

use crate::math::{Frame, Ray, Rgb, Stream, sampling};
use crate::scene::{Brdf, BrdfSample, Scene, Sensor, Vertex};
use crate::surface::Hit;

use super::direct;
use super::walk::{Launcher, Node};

/// Divides light between connections to walks (share c) and gathering rays (share 1 - c), as a function of G in 1/m2.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Weighting {
    /// The paper's plain estimate: all by connection, c = 1; its variance is unbounded near edges.
    Walk,
    /// The bounded kernel, c = min(1, b/G).
    Bounded {
        /// The largest G that is connected in full, 1/m2.
        bound: f64,
    },
}

impl Weighting {
    /// Takes the default of the crate for a scene: the bounded kernel with b = 10 / total area.
    pub fn of(scene: &Scene) -> Self {
        if scene.area() > 0.0 { Self::Bounded { bound: 10.0 / scene.area() } } else { Self::Walk }
    }

    /// Gives the share of the connection to a hit of a walk.
    fn share(&self, g: f64) -> f64 {
        match *self {
            Self::Walk => 1.0,
            Self::Bounded { bound } => (bound / g).min(1.0),
        }
    }

    /// Gives the share of the connection to a walk's start, which has a known density: the balance heuristic between that density and the cosine
    /// density of the gathering ray, c = pi p / (pi p + G).
    fn start_share(&self, g: f64, density: f64) -> f64 {
        match self {
            Self::Walk => 1.0,
            Self::Bounded { .. } => PI * density / (PI * density + g),
        }
    }

    /// Tells how far a gathering ray can find a hit to which the connection leaves anything.
    fn reach(&self) -> f64 {
        match self {
            Self::Walk => 0.0,
            Self::Bounded { bound } => bound.sqrt().recip(),
        }
    }
}

/// Receives light at a point of the scene.
#[derive(Debug, Clone, Copy)]
pub struct Receiver<'a> {
    /// Where, with the error bound its rays leave by.
    pub hit: Hit,
    normal: DVec3,
    reflection: Option<(&'a Brdf, DVec3)>,
}

/// Separates what came straight from a source from what was reflected before.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Light {
    /// Straight from lights and emitting surfaces.
    pub direct: Rgb,
    /// After at least one reflection.
    pub indirect: Rgb,
}

impl Light {
    /// Gives both together.
    pub fn total(&self) -> Rgb {
        self.direct + self.indirect
    }
}

impl<'a> Receiver<'a> {
    /// Measures illuminance: W = cos.
    pub fn sensor(sensor: &Sensor) -> Self {
        Self { hit: sensor.as_hit(), normal: sensor.normal, reflection: None }
    }

    /// Measures the luminance that a vertex reflects towards `vertex.outgoing`: W = f cos.
    pub fn reflecting(vertex: &Vertex<'a>) -> Self {
        Self {
            hit: vertex.hit,
            normal: vertex.normal,
            reflection: Some((&vertex.material.brdf, vertex.outgoing)),
        }
    }

    /// Gives W for light that comes from the unit vector `direction`; black from below the surface.
    pub fn response(&self, direction: DVec3) -> Rgb {
        let cos = self.normal.dot(direction);
        if cos <= 0.0 || self.geometric_cos(direction) <= 0.0 {
            return Rgb::BLACK;
        }
        match self.reflection {
            None => Rgb::grey(cos),
            Some((brdf, outgoing)) => brdf.eval(self.normal, direction, outgoing) * cos,
        }
    }

    /// Samples a direction to look along.
    pub(super) fn sample(&self, u: [f64; 2]) -> Option<BrdfSample> {
        match self.reflection {
            None => {
                let local = sampling::cosine_hemisphere(u);
                (local.z > 0.0).then(|| BrdfSample {
                    direction: Frame::about(self.normal).to_world(local),
                    weight: Rgb::grey(PI),
                    density: sampling::cosine_pdf(local.z),
                })
            }
            Some((brdf, outgoing)) => brdf.sample(self.normal, outgoing, u),
        }
        .filter(|sample| self.geometric_cos(sample.direction) > 0.0)
    }

    /// Gives the density per steradian with which [`Receiver::sample`] looks along `direction`.
    pub(super) fn density(&self, direction: DVec3) -> f64 {
        match self.reflection {
            None => sampling::cosine_pdf(self.normal.dot(direction)),
            Some((brdf, _)) => brdf.density(self.normal, direction),
        }
    }

    /// Gives the cosine to the true surface on the side the receiver faces; differs from the shading cosine on smooth meshes only.
    fn geometric_cos(&self, direction: DVec3) -> f64 {
        self.hit.normal.dot(direction) * 1.0_f64.copysign(self.hit.normal.dot(self.normal))
    }
}

/// Connects walks to receivers in a scene under a weighting.
pub(super) struct Connector<'a> {
    scene: &'a Scene,
    launcher: &'a Launcher<'a>,
    weighting: Weighting,
}

impl<'a> Connector<'a> {
    /// Prepares for a scene whose walks `launcher` starts.
    pub(super) fn new(scene: &'a Scene, launcher: &'a Launcher<'a>, weighting: Weighting) -> Self {
        Self { scene, launcher, weighting }
    }

    /// Estimates, from one walk, all light at the receiver except that of the point lights it sees itself.
    pub(super) fn estimate(
        &self,
        receiver: &Receiver,
        walk: &[Node],
        stream: &mut Stream,
    ) -> Light {
        let mut light = Light::default();
        for node in walk {
            let contribution = self.connect(receiver, node);
            match node.start_density {
                Some(_) => light.direct += contribution,
                None => light.indirect += contribution,
            }
        }
        self.gather(receiver, walk, stream, &mut light);
        light
    }

    /// Connects one node: its share of Q f G V W / cos.
    fn connect(&self, receiver: &Receiver, node: &Node) -> Rgb {
        let to_node = node.vertex.hit.point - receiver.hit.point;
        let distance2 = to_node.length_squared();
        if distance2 == 0.0 {
            return Rgb::BLACK;
        }
        let direction = to_node / distance2.sqrt();
        let response = receiver.response(direction);
        let cos = -node.vertex.normal.dot(direction);
        if cos <= 0.0 || response.is_black() {
            return Rgb::BLACK;
        }
        let g = cos * receiver.normal.dot(direction) / distance2;
        let (leaving, share) = if let Some(density) = node.start_density {
            (Rgb::grey(1.0 / PI), self.weighting.start_share(g, density))
        } else {
            let vertex = &node.vertex;
            let leaving = vertex.brdf().eval(vertex.normal, vertex.outgoing, -direction);
            (leaving, self.weighting.share(g))
        };
        if leaving.is_black() || !self.scene.sees(&receiver.hit, &node.vertex.hit, direction) {
            return Rgb::BLACK;
        }
        node.flux * leaving * response * (share * cos / distance2)
    }

    /// Gathers by one ray what the connections leave.
    fn gather(&self, receiver: &Receiver, walk: &[Node], stream: &mut Stream, light: &mut Light) {
        if self.weighting == Weighting::Walk {
            return;
        }
        let [u, v, roulette, _] = stream.next_4d();
        let Some(BrdfSample { direction, weight, .. }) = receiver.sample([u, v]) else { return };
        // Emission is gathered from any distance, reflection only from where the bounded kernel cuts.
        let reach =
            if self.scene.emitters().is_empty() { self.weighting.reach() } else { f64::INFINITY };
        let ray: Ray = receiver.hit.leave(direction).up_to(reach);
        let Some(vertex) = self.scene.vertex(&ray) else { return };
        let cos = vertex.normal.dot(vertex.outgoing);
        if cos <= 0.0 {
            return;
        }
        let to_vertex = vertex.hit.point - receiver.hit.point;
        let g = cos * receiver.normal.dot(direction) / to_vertex.length_squared();
        let emitted = vertex.emitted();
        if !emitted.is_black() {
            let share = self.weighting.start_share(g, self.launcher.start_density(&vertex));
            light.direct += weight * emitted * (1.0 - share);
        }
        let rest = 1.0 - self.weighting.share(g);
        // Roulette on what the vertex can return at most ends the recursion without bias.
        let survival = (rest * vertex.brdf().albedo().luminance()).min(1.0);
        if survival > 0.0 && roulette < survival {
            let beyond = Receiver::reflecting(&vertex);
            let arriving = direct::point_lights(self.scene, &beyond)
                + self.estimate(&beyond, walk, stream).total();
            light.indirect += weight * arriving * (rest / survival);
        }
    }
}
