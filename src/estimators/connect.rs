//! The core of the local estimates: what the nodes of a walk contribute to a receiver.
//!
//! A receiver answers light from a direction by W(omega); sensors and pixels differ in nothing else ([`Receiver`]). A node y of a walk contributes
//! Q f(y) W V cos' / d^2 (eq. 5, 11), which is singular at d = 0. A weighting leaves the share c of that to the connection and the rest 1 - c to a ray that
//! gathers from the receiver (Kollig and Keller, 2004): it finds y' and adds (1 - c) W/pdf [direct light at y' + the same walk's nodes seen from y'],
//! recursively. Both together are unbiased for every c.
//!
//! What c depends on is K = pi pdf cos' / d^2, pi times the density per area with which the gathering ray finds y: the kernel G = cos cos' / d^2 for a sensor
//! or a diffuse surface, more in the highlights of a glossy one. With c K s bounded, s = [`Brdf::peak`](crate::scene::Brdf::peak) at y, the variance is finite.
//!
//! Through mirrors nothing can be connected. A gathering ray that meets one goes on from there, and what it finds then is its alone (c = 0); only light of a
//! point that came by mirrors cannot be found so, and the connection has all of it (c = 1, [`Node::caustic`]).
//!
//! Many estimates are made together, level of the recursion after level, so that rays come by batches: first the shadow rays of all
//! connections of the level, then its gathering rays; what they find are the estimates of the next level, which are added to those they
//! belong to at the end. Every estimate has a stream of its own, so its numbers do not depend on its company.

use std::f64::consts::PI;
use std::ops::Range;

use crate::math::{Ray, Rgb, Stream};
use crate::scene::{BrdfSample, Scene, Vertex};
use crate::surface::Hit;

pub(super) use crate::scene::Light;

use super::direct;
use super::flat_lights::Outlook;
use super::receiver::Receiver;
use super::walk::{Launcher, Node};
use super::weighting::Weighting;

/// Connects walks to receivers in a scene under a weighting.
pub(super) struct Connector<'a> {
    scene: &'a Scene,
    launcher: &'a Launcher<'a>,
    weighting: Weighting,
}

/// Holds the estimates that are made together, and the memory they need; to be used again for the next ones.
#[derive(Default)]
pub(super) struct Batch<'a> {
    /// Those asked for, then level by level those that gathering rays led to.
    estimates: Vec<Estimate<'a>>,
    /// What is connected or gathered along `rays`, ray by ray.
    connections: Vec<Connection>,
    gathered: Vec<Gathered>,
    rays: Vec<Ray>,
    blocked: Vec<bool>,
    hits: Vec<Option<(usize, Hit)>>,
}

/// One walk that is being estimated at one receiver.
struct Estimate<'a> {
    receiver: Receiver<'a>,
    walk: &'a [Node<'a>],
    stream: Stream,
    light: Light,
    /// Where its light goes when it is not asked for itself.
    beyond: Option<Beyond>,
}

/// Says what an estimate found by a gathering ray gives to the one it was gathered for.
struct Beyond {
    /// The number of that estimate.
    of: usize,
    weight: Rgb,
    share: f64,
    /// The light of point lights there.
    point_lights: Rgb,
}

/// Light that an estimate receives when nothing stands on a ray.
struct Connection {
    to: usize,
    light: Rgb,
    source: Source,
    /// How much of the light is known without the connection.
    known: f64,
}

#[derive(Clone, Copy)]
enum Source {
    PointLight,
    Start,
    Reflection,
}

/// A gathering ray's sample and the number that decides whether an estimate is made where it ends.
struct Gathered {
    to: usize,
    sample: BrdfSample,
    roulette: f64,
    /// What mirrors have left of the light, where it has met any.
    mirrored: Option<Rgb>,
}

/// The part left by mirrors below which a gathering ray, or one from the eye, plays Russian roulette at each further one.
const FAINT: f64 = 0.25;

/// Gives what is left of the light along a ray after one more mirror, unless roulette ends it.
pub(super) fn through_mirror(left: Rgb, reflectance: Rgb, roulette: f64) -> Option<Rgb> {
    let left = left * reflectance;
    let survival = (left.luminance() / FAINT).min(1.0);
    (roulette < survival).then(|| left / survival)
}

impl<'a> Connector<'a> {
    /// Prepares for a scene whose walks `launcher` starts.
    pub(super) fn new(scene: &'a Scene, launcher: &'a Launcher<'a>, weighting: Weighting) -> Self {
        Self { scene, launcher, weighting }
    }

    /// Looks at the flat lights from a receiver.
    pub(super) fn outlook(&self, receiver: &Receiver) -> Outlook {
        self.launcher.outlook(receiver)
    }

    /// Estimates, from each of some walks with a stream for each, all light at the receiver except that of the point lights it sees itself and what its
    /// outlook knows of flat lights.
    pub(super) fn estimate(
        &self,
        batch: &mut Batch<'a>,
        receiver: &Receiver<'a>,
        outlook: &Outlook,
        walks: impl Iterator<Item = (&'a [Node<'a>], Stream)>,
    ) -> impl Iterator<Item = Light> {
        batch.estimates.clear();
        batch.estimates.extend(walks.map(|(walk, stream)| Estimate::new(*receiver, walk, stream)));
        let asked = batch.estimates.len();
        let mut level = 0..asked;
        while !level.is_empty() {
            let outlook = (level.start == 0).then_some(outlook);
            self.connect(batch, level.clone(), outlook);
            self.gather(batch, level.clone(), outlook);
            level = level.end..batch.estimates.len();
        }
        batch.add_beyond();
        batch.estimates[..asked].iter().map(|estimate| estimate.light)
    }

    /// Connects the estimates of a level to the nodes of their walks and, beyond gathering rays, to the point lights.
    fn connect(&self, batch: &mut Batch<'a>, level: Range<usize>, outlook: Option<&Outlook>) {
        batch.rays.clear();
        batch.connections.clear();
        for to in level {
            let Estimate { receiver, walk, beyond, stream, light, .. } = &mut batch.estimates[to];
            if !walk.last().is_none_or(Node::is_sound) {
                *light = Light::SPOILT;
                continue;
            }
            let mut add = |source, known, (ray, light)| {
                batch.rays.push(ray);
                batch.connections.push(Connection { to, light, source, known });
            };
            if beyond.is_some() {
                direct::few_connections(self.scene, receiver, stream, |connection| {
                    add(Source::PointLight, 0.0, connection);
                });
            }
            for node in *walk {
                let connection = self.connection(receiver, node, beyond.is_none());
                let (source, known) = match node.start_density {
                    None => (Source::Reflection, 0.0),
                    Some(_) => (Source::Start, share(outlook, node.vertex.object)),
                };
                if let Some(connection) = connection {
                    add(source, known, connection);
                }
            }
        }
        batch.blocked.clear();
        batch.blocked.resize(batch.rays.len(), false);
        self.scene.mark_blocked(&batch.rays, &mut batch.blocked);
        for (connection, blocked) in batch.connections.iter().zip(&batch.blocked) {
            let visible = if *blocked { 0.0 } else { 1.0 };
            if visible != connection.known {
                batch.estimates[connection.to].receive(connection, visible - connection.known);
            }
        }
    }

    /// Gives the light that an unhindered connection to a node carries, its share of Q f W V cos' / d^2, and the ray on which nothing may stand;
    /// `None` where there is no such light.
    fn connection(&self, receiver: &Receiver, node: &Node, first: bool) -> Option<(Ray, Rgb)> {
        let to_node = node.vertex.hit.point - receiver.hit.point;
        // What is at one point, too, is turned away from.
        if node.vertex.normal.dot(to_node) >= 0.0 || receiver.turns_away(to_node) {
            return None;
        }
        let distance2 = to_node.length_squared();
        let direction = to_node / distance2.sqrt();
        let response = receiver.response(direction);
        let cos = -node.vertex.normal.dot(direction);
        if response.is_black() {
            return None;
        }
        let kernel = PI * receiver.density(direction) * cos / distance2;
        let (leaving, share) = if let Some(density) = node.start_density {
            (Rgb::grey(1.0 / PI), self.weighting.start_share(kernel, density))
        } else {
            let Vertex { normal, outgoing, .. } = node.vertex;
            let brdf = node.vertex.brdf();
            let leaving = brdf.eval(normal, outgoing, -direction);
            let share = || self.weighting.share(first, kernel, brdf.peak(normal, -direction));
            (leaving, if node.caustic { 1.0 } else { share() })
        };
        if share == 0.0 || leaving.is_black() {
            return None;
        }
        let ray = receiver.hit.segment(&node.vertex.hit, direction)?;
        Some((ray, node.flux * leaving * response * (share * cos / distance2)))
    }

    /// Gathers, by one ray for each estimate of a level, what the connections leave; where it goes on, there is an estimate of the next level.
    fn gather(&self, batch: &mut Batch<'a>, level: Range<usize>, outlook: Option<&Outlook>) {
        let mirrors = self.scene.has_mirrors();
        if !mirrors && !self.weighting.gathers(level.start == 0) {
            return;
        }
        let reach = self.weighting.reach(self.scene);
        batch.rays.clear();
        batch.gathered.clear();
        for to in level {
            let Estimate { receiver, stream, .. } = &mut batch.estimates[to];
            let [u, v, roulette, _] = stream.next_4d();
            let Some(sample) = receiver.sample([u, v]) else { continue };
            batch.rays.push(receiver.hit.leave(sample.direction).up_to(reach));
            batch.gathered.push(Gathered { to, sample, roulette, mirrored: None });
        }
        while !batch.rays.is_empty() {
            batch.hits.clear();
            batch.hits.resize(batch.rays.len(), None);
            self.scene.hits(&batch.rays, &mut batch.hits);
            batch.rays.clear();
            let (gathered, hits) =
                (std::mem::take(&mut batch.gathered), std::mem::take(&mut batch.hits));
            for (gathered, hit) in gathered.iter().zip(&hits) {
                self.take_up(batch, gathered, hit.as_ref(), outlook);
            }
            batch.hits = hits;
            if batch.rays.is_empty() {
                batch.gathered = gathered;
            }
        }
    }

    /// Takes up what a gathering ray has met: its light, an estimate there, and the ray that a mirror sends on.
    fn take_up(
        &self,
        batch: &mut Batch<'a>,
        gathered: &Gathered,
        hit: Option<&(usize, Hit)>,
        outlook: Option<&Outlook>,
    ) {
        let from = &mut batch.estimates[gathered.to];
        // What is known of flat lights is what they send here straight.
        let outlook = outlook.filter(|_| gathered.mirrored.is_none());
        let flat_lights = outlook.iter().flat_map(|o| o.objects());
        for (light, known) in flat_lights.filter(|(light, _)| Some(*light) != hit.map(|h| h.0)) {
            from.light.direct += self.hidden(&from.receiver, gathered, light) * -known;
        }
        let Some((object, hit)) = hit else { return };
        let vertex = self.scene.refined_vertex(*object, hit, -gathered.sample.direction);
        if !vertex.is_sound() {
            from.light = Light::SPOILT;
            return;
        }
        let unknown = 1.0 - share(outlook, *object);
        let estimate = self.look(from, gathered, &vertex, unknown);
        if let Some((direction, reflectance)) = vertex.mirrored() {
            let left = gathered.mirrored.unwrap_or(Rgb::WHITE);
            let [roulette, next_roulette, ..] = from.stream.next_4d();
            if let Some(left) = through_mirror(left, reflectance, roulette) {
                let sample = BrdfSample { direction, ..gathered.sample };
                let (to, roulette, mirrored) = (gathered.to, next_roulette, Some(left));
                batch.rays.push(vertex.hit.leave(direction));
                batch.gathered.push(Gathered { to, sample, roulette, mirrored });
            }
        }
        batch.estimates.extend(estimate);
    }

    /// Gives the light that a gathering ray would see at an object that emits, if nothing hid it.
    fn hidden(&self, receiver: &Receiver, gathered: &Gathered, object: usize) -> Rgb {
        let BrdfSample { direction, .. } = gathered.sample;
        let surface = &self.scene.objects()[object].surface;
        let hit = surface.hit(&receiver.hit.leave(direction));
        hit.map_or(Rgb::BLACK, |hit| {
            let vertex = self.scene.refined_vertex(object, &hit, -direction);
            self.emission(receiver, gathered, &vertex)
        })
    }

    /// Gives the share of a gathering ray in the light that a surface by itself sends along it.
    fn emission(&self, receiver: &Receiver, gathered: &Gathered, vertex: &Vertex) -> Rgb {
        let emitted = vertex.emitted();
        if emitted.is_black() {
            return emitted;
        }
        if let Some(left) = gathered.mirrored {
            return gathered.sample.weight * left * emitted;
        }
        let kernel = kernel(receiver, gathered, vertex);
        let share = self.weighting.start_share(kernel, self.launcher.start_density(vertex));
        gathered.sample.weight * emitted * (1.0 - share)
    }

    /// Takes up what a gathering ray sees, of its emission the unknown part, and gives the estimate that goes on there unless roulette ends it.
    fn look(
        &self,
        from: &mut Estimate<'a>,
        gathered: &Gathered,
        vertex: &Vertex<'a>,
        unknown: f64,
    ) -> Option<Estimate<'a>> {
        if vertex.normal.dot(vertex.outgoing) <= 0.0 {
            return None;
        }
        let emission = self.emission(&from.receiver, gathered, vertex) * unknown;
        let (light, rest) = if gathered.mirrored.is_some() {
            (&mut from.light.indirect, 1.0)
        } else {
            let kernel = kernel(&from.receiver, gathered, vertex);
            let peak = vertex.brdf().peak(vertex.normal, vertex.outgoing);
            let share = self.weighting.share(from.beyond.is_none(), kernel, peak);
            (&mut from.light.direct, 1.0 - share)
        };
        *light += emission;
        // Roulette on what the vertex can return at most ends the recursion without bias.
        let survival = (rest * vertex.albedo()).min(1.0);
        (survival > 0.0 && gathered.roulette < survival).then(|| {
            let weight = gathered.sample.weight * gathered.mirrored.unwrap_or(Rgb::WHITE);
            let share = rest / survival;
            let beyond = Beyond { of: gathered.to, weight, share, point_lights: Rgb::BLACK };
            let there = Receiver::reflecting(vertex);
            let estimate = Estimate::new(there, from.walk, from.stream.clone());
            Estimate { beyond: Some(beyond), ..estimate }
        })
    }
}

/// Gives how much an outlook knows of an object's light.
fn share(outlook: Option<&Outlook>, object: usize) -> f64 {
    outlook.map_or(0.0, |outlook| outlook.share(object))
}

/// Gives K between a receiver and what its gathering ray found.
fn kernel(receiver: &Receiver, gathered: &Gathered, vertex: &Vertex) -> f64 {
    let cos = vertex.normal.dot(vertex.outgoing);
    PI * gathered.sample.density * cos / (vertex.hit.point - receiver.hit.point).length_squared()
}

impl<'a> Estimate<'a> {
    fn new(receiver: Receiver<'a>, walk: &'a [Node<'a>], stream: Stream) -> Self {
        Self { receiver, walk, stream, light: Light::default(), beyond: None }
    }

    fn receive(&mut self, connection: &Connection, factor: f64) {
        let light = connection.light * factor;
        match (connection.source, &mut self.beyond) {
            (Source::PointLight, Some(beyond)) => beyond.point_lights += light,
            (Source::PointLight | Source::Start, _) => self.light.direct += light,
            (Source::Reflection, _) => self.light.indirect += light,
        }
    }
}

impl Batch<'_> {
    /// Adds the light of what gathering rays led to, the farthest first: each was found later than the one it belongs to.
    fn add_beyond(&mut self) {
        for i in (0..self.estimates.len()).rev() {
            let Estimate { beyond: Some(beyond), light, .. } = &self.estimates[i] else { break };
            let arriving = beyond.point_lights + light.total();
            let gathered = beyond.weight * arriving * beyond.share;
            let of = beyond.of;
            self.estimates[of].light.indirect += gathered;
        }
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::math::Randomness;
    use crate::scene::{Material, Object, PointLight, Sensor};
    use crate::surface::primitives::{AxisBox, Sphere};

    /// A room with a lamp, a ball that shines and reflects, and one that casts shadows.
    fn room() -> Scene {
        let grey = Material::lambert(Rgb::grey(0.8)).expect("valid");
        let walls = AxisBox::new(DVec3::ZERO, DVec3::new(4.0, 5.0, 3.0)).expect("valid");
        let ball =
            |x: f64, radius: f64| Sphere::new(DVec3::new(x, 2.0, 1.0), radius).expect("valid");
        let objects = vec![
            Object::new("room", walls.turned_inward(true), grey.clone()),
            Object::new("shining", ball(1.0, 0.3), grey.clone().emitting(Rgb::grey(100.0))),
            Object::new("dark", ball(3.0, 0.5), grey),
        ];
        let at = DVec3::new(2.0, 4.0, 2.5);
        let lamp = PointLight::isotropic("lamp", at, Rgb::grey(50.0));
        Scene::new(objects, vec![lamp]).expect("valid")
    }

    #[test]
    fn estimates_made_together_are_those_made_alone() {
        let scene = room();
        let launcher = Launcher::new(&scene).expect("there is light");
        let stream = |purpose, i| Stream::new(Randomness::Sobol, purpose, i);
        let walks: Vec<Vec<Node>> = (0..40)
            .map(|i| {
                let mut nodes = Vec::new();
                launcher.walk(&mut stream(1, i), &mut nodes);
                nodes
            })
            .collect();
        // Near an edge most is gathered, over several levels.
        let sensor = Sensor::plane(DVec3::new(0.02, 2.0, 0.0), DVec3::Z);
        let receiver = Receiver::sensor(&sensor);
        let outlook = launcher.outlook(&receiver);
        for weighting in [Weighting::Walk, Weighting::of(&scene)] {
            let connector = Connector::new(&scene, &launcher, weighting);
            let mut batch = Batch::default();
            let items = || walks.iter().map(Vec::as_slice).zip((0..).map(|i| stream(2, i)));
            let together: Vec<Light> =
                connector.estimate(&mut batch, &receiver, &outlook, items()).collect();
            let went_on = batch.estimates.len() > walks.len();
            assert_eq!(went_on, weighting != Weighting::Walk);
            for (item, &light) in items().zip(&together) {
                let alone =
                    connector.estimate(&mut batch, &receiver, &outlook, std::iter::once(item));
                assert_eq!(alone.collect::<Vec<_>>(), [light]);
            }
            assert!(together.iter().any(|l| !l.direct.is_black()));
            assert!(together.iter().any(|l| !l.indirect.is_black()));
        }
    }
}
