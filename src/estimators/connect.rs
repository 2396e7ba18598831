//! The core of the local estimates: what the nodes of a walk contribute to a receiver.
//!
//! A receiver answers light from a direction by W(omega); sensors and pixels differ in nothing else
//! ([`Receiver`]). A node y of a walk contributes Q f(y) W V cos' / d^2 (eq. 5, 11), which is
//! singular at d = 0. A weighting leaves the share c of that to the connection and the rest 1 - c
//! to a ray that gathers from the receiver (Kollig and Keller, 2004): it finds y' and adds (1 - c)
//! W/pdf [direct light at y' + the same walks' nodes seen from y'], recursively. Both together are
//! unbiased for every c.
//!
//! Walks are connected by clouds ([`Cloud`]): all that they bring if nothing hinders it is taken
//! up, and some connections, which stand for all, are asked for what is hidden.
//!
//! What c depends on is K = pi pdf cos' / d^2, pi times the density per area with which the
//! gathering ray finds y: the kernel G = cos cos' / d^2 for a sensor or a diffuse surface, more in
//! the highlights of a glossy one. With c K s bounded, s = [`Brdf::peak`](crate::scene::Brdf::peak)
//! at y, the variance is finite.
//!
//! Through mirrors nothing can be connected. A gathering ray that meets one goes on from there, and
//! what it finds then is its alone (c = 0); only light of a point that came by mirrors cannot be
//! found so, and the connection has all of it (c = 1, [`Node::caustic`]).
//!
//! Many estimates are made together, level of the recursion after level, so that rays come by
//! batches: first the shadow rays of the connections of the level, then its gathering rays; what
//! they find are the estimates of the next level, which are added to those they belong to at the
//! end. Every gathering ray has a stream of its own, so its numbers do not depend on its company.

use std::f64::consts::PI;
use std::ops::Range;

use fearless_simd::Level;

use crate::math::{Ray, Rgb, Stream};
use crate::scene::{Scene, Vertex};
use crate::surface::Hit;

pub(super) use crate::scene::SplitLight;

use super::candidates::{Candidates, Choice};
use super::cloud::Cloud;
use super::direct;
use super::gather::{Gathered, Gatherer};
use super::known_lights::Outlook;
use super::receiver::Receiver;
use super::replicates::Watch;
use super::walk::{Launcher, Node};
use super::weighting::Weighting;

/// Connects walks to receivers in a scene under a weighting.
pub(super) struct Connector<'a> {
    pub(super) scene: &'a Scene,
    pub(super) launcher: &'a Launcher<'a>,
    pub(super) weighting: Weighting,
    level: Level,
    watch: Option<&'a Watch<'a>>,
}

/// Holds the estimates that are made together, and the memory they need; to be used again for the
/// next ones.
#[derive(Default)]
pub(super) struct Batch<'a> {
    /// Those asked for, then level by level those that gathering rays led to.
    pub(super) estimates: Vec<Estimate<'a>>,
    /// The gathering rays of the level at work and of the next one.
    pub(super) gatherers: Vec<Gatherer>,
    pub(super) next_gatherers: Vec<Gatherer>,
    /// What is connected or gathered along `rays`, ray by ray.
    connections: Vec<Connection>,
    pub(super) gathered: Vec<Gathered>,
    pub(super) rays: Vec<Ray>,
    blocked: Vec<bool>,
    pub(super) hits: Vec<Option<(usize, Hit)>>,
    candidates: Candidates,
}

/// Some walks that are being estimated at one receiver.
pub(super) struct Estimate<'a> {
    pub(super) receiver: Receiver<'a>,
    pub(super) cloud: &'a Cloud<'a>,
    pub(super) light: SplitLight,
    /// What the connections bring: at first, if nothing hinders them.
    connected: SplitLight,
    /// The luminance of that.
    unhindered: f64,
    /// Where its light goes when it is not asked for itself.
    pub(super) beyond: Option<Beyond>,
}

/// All light of some walks at a receiver, and what connections brought of it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Estimated {
    pub(super) light: SplitLight,
    pub(super) connected: SplitLight,
    /// What the connections would have brought if nothing had hindered them, as luminance.
    unhindered: f64,
}

impl Estimated {
    /// Returns the luminance of the light, 0 where it is no more than the roundings of what was
    /// added and taken off again.
    pub(super) fn luminance(&self) -> f64 {
        let luminance = self.light.total().luminance();
        if luminance.abs() <= SplitLight::ROUNDING * self.unhindered { 0.0 } else { luminance }
    }
}

/// Says what an estimate found by a gathering ray gives to the one it was gathered for.
pub(super) struct Beyond {
    /// The number of that estimate.
    pub(super) of: usize,
    pub(super) weight: Rgb,
    pub(super) share: f64,
}

/// Light that an estimate has been given, and that is taken off again if something stands on a ray.
struct Connection {
    to: usize,
    light: SplitLight,
}

/// For how many walks one node is connected to a receiver, and how many nodes of a cloud to what a
/// gathering ray has found. In rooms with a head half as many or twice as many take as much time to
/// a given error.
const WALKS_TO_A_RAY: usize = 2;
const CONNECTED_BEYOND: usize = 2;

/// How many nodes that no lane can weigh are weighed one by one at a receiver, and at what a
/// gathering ray has found.
const WEIGHED: usize = 48;
const WEIGHED_BEYOND: usize = 8;

impl<'a> Connector<'a> {
    /// Prepares for a scene whose walks `launcher` starts.
    pub(super) fn new(scene: &'a Scene, launcher: &'a Launcher<'a>, weighting: Weighting) -> Self {
        Self { scene, launcher, weighting, level: Level::new(), watch: None }
    }

    /// Leaves off, with whatever is known, when `watch` says that nothing more is needed.
    pub(super) fn watched(self, watch: &'a Watch<'a>) -> Self {
        Self { watch: Some(watch), ..self }
    }

    /// Whether what is asked for is not needed any more.
    pub(super) fn ends(&self) -> bool {
        self.watch.is_some_and(Watch::ends)
    }

    /// Estimates, from each of some clouds of walks, all light at the receiver except that of the
    /// point lights it sees itself and what its outlook knows of flat lights: the mean over the
    /// walks. Each cloud comes with a stream, at least one, for every gathering ray.
    pub(super) fn estimate<Streams: ExactSizeIterator<Item = Stream>>(
        &self,
        batch: &mut Batch<'a>,
        receiver: &Receiver<'a>,
        outlook: &Outlook,
        clouds: impl Iterator<Item = (&'a Cloud<'a>, Streams)>,
    ) -> impl Iterator<Item = Estimated> {
        batch.estimates.clear();
        batch.gatherers.clear();
        for (to, (cloud, streams)) in clouds.enumerate() {
            batch.estimates.push(Estimate::new(*receiver, cloud, None));
            let rays = streams.len();
            batch.gatherers.extend(streams.map(|stream| Gatherer::new(to, rays, stream)));
        }
        let asked = batch.estimates.len();
        let mut level = 0..asked;
        while !level.is_empty() && !self.ends() {
            let outlook = (level.start == 0).then_some(outlook);
            self.connect(batch, level.clone(), outlook);
            self.gather(batch, &level, outlook);
            std::mem::swap(&mut batch.gatherers, &mut batch.next_gatherers);
            batch.next_gatherers.clear();
            level = level.end..batch.estimates.len();
        }
        batch.add_beyond();
        let asked = batch.estimates[..asked].iter();
        asked.map(|e| Estimated {
            light: e.light,
            connected: e.connected,
            unhindered: e.unhindered,
        })
    }

    /// Connects the estimates of a level to the nodes of their walks and, beyond gathering rays, to
    /// the point lights.
    fn connect(&self, batch: &mut Batch<'a>, level: Range<usize>, outlook: Option<&Outlook>) {
        batch.rays.clear();
        batch.connections.clear();
        let mut gatherers = 0;
        for to in level.clone() {
            while batch.gatherers[gatherers].to < to {
                gatherers += 1;
            }
            self.connect_one(batch, [to, gatherers], outlook);
        }
        batch.blocked.clear();
        batch.blocked.resize(batch.rays.len(), false);
        self.scene.mark_blocked(&batch.rays, &mut batch.blocked);
        let all = batch.connections.iter().zip(&batch.blocked);
        for (Connection { to, light }, _) in all.filter(|(_, blocked)| **blocked) {
            let estimate = &mut batch.estimates[*to];
            estimate.light = estimate.light - *light;
        }
        for estimate in &mut batch.estimates[level] {
            estimate.unhindered = estimate.connected.total().luminance();
            estimate.light = estimate.light.above_rounding(&estimate.connected);
            estimate.connected = estimate.light;
        }
    }

    /// Returns an estimate what all connections bring if nothing hinders them, and lists those that
    /// may be hindered. The numbers are those of its first gathering ray.
    fn connect_one(
        &self,
        batch: &mut Batch<'a>,
        [to, gatherer]: [usize; 2],
        outlook: Option<&Outlook>,
    ) {
        let Batch { estimates, gatherers, candidates, rays, connections, .. } = batch;
        let Gatherer { numbers: [.., start], stream, .. } = &mut gatherers[gatherer];
        let Estimate { receiver, cloud, light, connected, beyond, .. } = &mut estimates[to];
        let first = beyond.is_none();
        if !first {
            direct::few_connections(self.scene, receiver, stream, |(ray, shed)| {
                let shed = SplitLight { direct: shed, indirect: Rgb::BLACK };
                *connected = *connected + shed;
                rays.push(ray);
                connections.push(Connection { to, light: shed });
            });
        }
        if cloud.walks() > 0 {
            let mean = 1.0 / cloud.walks() as f64;
            let (most, count) = if first {
                (WEIGHED, cloud.walks().div_ceil(WALKS_TO_A_RAY))
            } else {
                (WEIGHED_BEYOND, CONNECTED_BEYOND)
            };
            let choice = Choice { limit: self.weighting.limit(first), most, random: *start };
            let all = candidates.weigh(
                self.level,
                receiver,
                cloud,
                choice,
                |node| self.unhindered(receiver, node, first).unwrap_or(Rgb::BLACK),
                |node| share(outlook, node.vertex.object),
            );
            *connected = *connected + all * mean;
            candidates.draw(cloud, count, |node, brought| {
                let brought = brought * mean;
                let to_node = node.vertex.hit.point - receiver.hit.point;
                match receiver.hit.segment(&node.vertex.hit, to_node.normalize()) {
                    Some(ray) => {
                        rays.push(ray);
                        connections.push(Connection { to, light: brought });
                    }
                    // Nothing is left between the two.
                    None => *light = *light - brought,
                }
            });
        }
        *light = *light + *connected;
    }

    /// Returns the light that an unhindered connection to a node carries, its share of Q f W cos' /
    /// d^2; `None` where there is no such light.
    fn unhindered(&self, receiver: &Receiver, node: &Node, first: bool) -> Option<Rgb> {
        let to_node = node.vertex.hit.point - receiver.hit.point;
        let normal = node.vertex.true_normal();
        // What is at one point, too, is turned away from.
        if normal.dot(to_node) >= 0.0 || receiver.turns_away(to_node) {
            return None;
        }
        let distance2 = to_node.length_squared();
        let direction = to_node / distance2.sqrt();
        let response = receiver.response(direction);
        let cos = -normal.dot(direction);
        if response.is_black() {
            return None;
        }
        let kernel = PI * receiver.density(direction) * cos / distance2;
        let (leaving, share) = if let Some(density) = node.start_density {
            (Rgb::grey(1.0 / PI), self.weighting.start_share(kernel, density))
        } else {
            let Vertex { normal, outgoing, .. } = node.vertex;
            let brdf = node.vertex.brdf();
            let leaving = brdf.eval(normal, outgoing, -direction) * node.vertex.arriving();
            let share = || self.weighting.share(first, kernel, brdf.peak(normal, -direction));
            (leaving, if node.caustic { 1.0 } else { share() })
        };
        if share == 0.0 || leaving.is_black() {
            return None;
        }
        Some(node.flux * leaving * response * (share * cos / distance2))
    }
}

/// Returns how much an outlook knows of an object's light.
pub(super) fn share(outlook: Option<&Outlook>, object: usize) -> f64 {
    outlook.map_or(0.0, |outlook| outlook.share(object))
}

impl<'a> Estimate<'a> {
    pub(super) fn new(
        receiver: Receiver<'a>,
        cloud: &'a Cloud<'a>,
        beyond: Option<Beyond>,
    ) -> Self {
        let (light, connected) = (SplitLight::default(), SplitLight::default());
        Self { receiver, cloud, light, connected, unhindered: 0.0, beyond }
    }
}

impl Batch<'_> {
    /// Adds the light of what gathering rays led to, the farthest first: each was found later than
    /// the one it belongs to.
    fn add_beyond(&mut self) {
        for i in (0..self.estimates.len()).rev() {
            let Estimate { beyond: Some(beyond), light, .. } = &self.estimates[i] else { break };
            let gathered = beyond.weight * light.total() * beyond.share;
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
        let clouds: Vec<Cloud> =
            walks.chunks(8).map(|w| Cloud::new(w.iter().map(Vec::as_slice))).collect();
        // Near an edge most is gathered, over several levels.
        let sensor = Sensor::plane(DVec3::new(0.02, 2.0, 0.0), DVec3::Z);
        let receiver = Receiver::sensor(&sensor);
        // Of the ball all would be known.
        let outlook = Outlook::default();
        for weighting in [Weighting::Walk, Weighting::of(&scene)] {
            let connector = Connector::new(&scene, &launcher, weighting);
            let mut batch = Batch::default();
            let streams =
                |cloud: usize| (0..4_u32).map(move |k| stream(2, 4 * cloud as u64 + u64::from(k)));
            let items = || clouds.iter().zip((0..).map(streams));
            let together: Vec<Estimated> =
                connector.estimate(&mut batch, &receiver, &outlook, items()).collect();
            let went_on = batch.estimates.len() > clouds.len();
            assert_eq!(went_on, weighting != Weighting::Walk);
            for (item, &estimated) in items().zip(&together) {
                let alone =
                    connector.estimate(&mut batch, &receiver, &outlook, std::iter::once(item));
                assert_eq!(alone.collect::<Vec<_>>(), [estimated]);
            }
            assert!(together.iter().any(|e| !e.light.direct.is_black()));
            assert!(together.iter().any(|e| !e.light.indirect.is_black()));
        }
    }
}
