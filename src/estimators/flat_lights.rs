//! Flat lights: what a receiver gets from them is known by Lambert's contour formula, but for what stands between.
//!
//! With X the contribution of a sample as if nothing stood between, V its visibility and C the mean of X by the contour formula, a C + (1 - a) X V - a X (1 - V) has
//! the right mean for every a (a control variate). With a the visible share, looked up by a few rays of its own, it is C, exact, where all is visible, and 0 where
//! nothing is.

use crate::math::Rgb;
use crate::scene::Scene;
use crate::surface::{Division, Facet, Hit};

use super::contour;
use super::receiver::Receiver;

/// The most facets of an object that counts as a flat light, and how far, relative to their size, a facet may be bent or a corner stand out.
const MOST_FACETS: usize = 64;
const FLAT: f64 = 1e-9;

/// Holds the emitting objects of a scene that are convex and made of flat facets.
pub(super) struct FlatLights(Vec<FlatLight>);

/// Such an object: of its facets a point sees only those that face it, and none of those hides another.
struct FlatLight {
    object: usize,
    facets: Vec<(Facet, Rgb)>,
}

/// What a receiver gets from flat lights by the contour formula.
#[derive(Default)]
pub(super) struct Outlook {
    /// The sum of a C.
    pub(super) light: Rgb,
    /// Pairs of an object and its a, above 0.
    shares: Vec<(usize, f64)>,
}

impl FlatLights {
    pub(super) fn of(scene: &Scene) -> Self {
        let light = |object: usize| {
            let place = &scene.objects()[object];
            let facets = place.area.as_ref()?.facets(&Division { count: 1, lights: &[] });
            is_convex(&facets).then(|| {
                let exitance = |hit: &Hit| place.material(hit).exitance;
                let facets = facets.into_iter().map(|f| (exitance(&f.middle), f));
                let shining = facets.filter(|(exitance, _)| !exitance.is_black());
                FlatLight { object, facets: shining.map(|(e, f)| (f, e)).collect() }
            })
        };
        Self(scene.emitters().iter().filter_map(|e| light(e.object)).collect())
    }

    /// Looks at the flat lights from a receiver that answers light by the cosine; nothing is known to another.
    pub(super) fn seen_from(&self, scene: &Scene, receiver: &Receiver) -> Outlook {
        let mut outlook = Outlook::default();
        let Some((factor, normal)) = receiver.diffuse().filter(|_| !self.0.is_empty()) else {
            return outlook;
        };
        for light in &self.0 {
            let (mut all, mut asked, mut seen) = (Rgb::BLACK, 0_u32, 0_u32);
            for (facet, exitance) in &light.facets {
                let part = contour::factor(&facet.corners, receiver.hit.point, normal);
                if part <= 0.0 {
                    continue;
                }
                all += *exitance * part;
                for point in &facet.points {
                    let to_point = point.point - receiver.hit.point;
                    let direction = to_point.normalize_or_zero();
                    if direction.dot(normal) > 0.0 {
                        asked += 1;
                        seen += u32::from(scene.sees(&receiver.hit, point, direction));
                    }
                }
            }
            if seen > 0 {
                let share = f64::from(seen) / f64::from(asked);
                outlook.light += factor * all * share;
                outlook.shares.push((light.object, share));
            }
        }
        outlook
    }
}

impl Outlook {
    /// Gives a for an object.
    pub(super) fn share(&self, object: usize) -> f64 {
        self.shares.iter().find(|(o, _)| *o == object).map_or(0.0, |(_, share)| *share)
    }

    /// Gives the objects of which something is known.
    pub(super) fn objects(&self) -> impl Iterator<Item = (usize, f64)> {
        self.shares.iter().copied()
    }
}

/// Tells whether facets are flat and none stands out before another.
fn is_convex(facets: &[Facet]) -> bool {
    let flat = |f: &Facet| (f.flat_area() - f.area).abs() <= FLAT * f.area;
    let behind = |f: &Facet| {
        let size = f.area.sqrt();
        let corners = facets.iter().flat_map(|other| other.corners);
        corners.into_iter().all(|c| (c - f.middle.point).dot(f.middle.normal) <= FLAT * size)
    };
    facets.len() <= MOST_FACETS && facets.iter().all(|f| flat(f) && behind(f))
}
