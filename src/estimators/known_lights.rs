//! Lights of simple shapes: what a receiver gets from them is known in closed form, but for what
//! stands between.
//!
//! With X the contribution of a sample as if nothing stood between, V its visibility and C the mean
//! of X in closed form, a C + (1 - a) X V - a X (1 - V) has the right mean for every a (a control
//! variate). With a the visible share, looked up by a few rays of its own, it is C, exact, where
//! all is visible, and 0 where nothing is.

use std::f64::consts::PI;

use glam::DVec3;

use crate::math::{Frame, Ray, Rgb};
use crate::scene::Scene;
use crate::surface::{Division, Facet, Hit, Outline, SampleArea};

use super::contour;
use super::receiver::Receiver;

/// The most facets of an object that counts as known, and how far, relative to their size, a corner
/// may stand out.
const MOST_FACETS: usize = 64;
const FLAT: f64 = 1e-9;

/// Points of a round light that are looked for.
const LOOKS: u32 = 8;

/// Holds the emitting objects of a scene whose light is known: convex bodies of flat facets, discs
/// and spheres.
pub(super) struct KnownLights(Vec<KnownLight>);

struct KnownLight {
    object: usize,
    shape: Shape,
}

enum Shape {
    /// Facets that shine. Of a convex body a point sees only those that face it, and none of those
    /// hides another.
    Facets(Vec<(Facet, Rgb)>),
    Disc {
        centre: DVec3,
        normal: DVec3,
        radius: f64,
        exitance: Rgb,
    },
    Sphere {
        centre: DVec3,
        radius: f64,
        exitance: Rgb,
    },
}

/// What a receiver gets from known lights in closed form.
#[derive(Default)]
pub(super) struct Outlook {
    /// The sum of a C.
    pub(super) light: Rgb,
    /// Pairs of an object and its a, above 0.
    shares: Vec<(usize, f64)>,
}

impl KnownLights {
    pub(super) fn of(scene: &Scene) -> Self {
        let light = |object: usize| {
            let place = &scene.objects()[object];
            let area = place.area.as_ref()?;
            let exitance = |hit: &Hit| place.material(hit).exitance;
            let shape = match area.outline() {
                Outline::Polygons => shining_facets(&**area, exitance)?,
                Outline::Disc { centre, normal, radius } => {
                    let exitance = place.materials[0].exitance;
                    Shape::Disc { centre, normal, radius, exitance }
                }
                Outline::Sphere { centre, radius } => {
                    Shape::Sphere { centre, radius, exitance: place.materials[0].exitance }
                }
                Outline::Other => return None,
            };
            Some(KnownLight { object, shape })
        };
        Self(scene.emitters().iter().filter_map(|e| light(e.object)).collect())
    }

    /// Looks at the known lights from a receiver that answers light by the cosine; nothing is known
    /// to another.
    pub(super) fn seen_from(&self, scene: &Scene, receiver: &Receiver) -> Outlook {
        let mut outlook = Outlook::default();
        let Some((factor, normal)) = receiver.diffuse().filter(|_| !self.0.is_empty()) else {
            return outlook;
        };
        for light in &self.0 {
            let mut look = Look { scene, from: &receiver.hit, normal, asked: 0, seen: 0 };
            let all = light.shape.seen(scene, light.object, &mut look);
            if look.seen > 0 {
                let share = f64::from(look.seen) / f64::from(look.asked);
                outlook.light += factor * all * share;
                outlook.shares.push((light.object, share));
            }
        }
        outlook
    }
}

/// Counts how many points of a light are seen of those that are asked for.
struct Look<'a> {
    scene: &'a Scene,
    from: &'a Hit,
    normal: DVec3,
    asked: u32,
    seen: u32,
}

impl Look<'_> {
    fn ask(&mut self, point: &Hit) {
        let direction = (point.point - self.from.point).normalize_or_zero();
        if direction.dot(self.normal) > 0.0 {
            self.asked += 1;
            self.seen += u32::from(self.scene.sees(self.from, point, direction));
        }
    }
}

impl Shape {
    /// Returns the illuminance by all of the light as if nothing stood between, and looks at some
    /// of its points.
    fn seen(&self, scene: &Scene, object: usize, look: &mut Look) -> Rgb {
        let (at, normal) = (look.from.point, look.normal);
        let surface = &scene.objects()[object].surface;
        let mut look_at = |round: Option<(DVec3, DVec3, f64)>| {
            for aim in round.into_iter().flat_map(|(c, axis, r)| spiral(c, axis, r)) {
                let direction = aim.normalize_or_zero();
                if let Some(hit) = surface.hit(&Ray::new(look.from.departure(direction), direction))
                {
                    look.ask(&surface.refine(&hit));
                }
            }
        };
        match self {
            Self::Facets(facets) => {
                let mut all = Rgb::BLACK;
                for (facet, exitance) in facets {
                    let part = contour::factor(&facet.corners, at, normal);
                    if part > 0.0 {
                        all += *exitance * part;
                        facet.points.iter().for_each(|point| look.ask(point));
                    }
                }
                all
            }
            Self::Disc { centre, normal: axis, radius, exitance } => {
                let centre = *centre - at;
                let part = if centre.dot(*axis) < 0.0 {
                    contour::round(centre, *axis, *radius, normal)
                } else {
                    0.0
                };
                look_at((part > 0.0).then_some((centre, *axis, *radius)));
                *exitance * part
            }
            Self::Sphere { centre, radius, exitance } => {
                let outline = contour::outline(*centre - at, *radius);
                let part = outline.map_or(0.0, |(c, axis, r)| contour::round(c, axis, r, normal));
                look_at(outline.filter(|_| part > 0.0));
                *exitance * part
            }
        }
    }
}

/// Spreads points evenly over a disc: a spiral by the golden angle.
fn spiral(centre: DVec3, axis: DVec3, radius: f64) -> impl Iterator<Item = DVec3> {
    let frame = Frame::about(axis);
    let turn = PI * (3.0 - 5.0_f64.sqrt());
    (0..LOOKS).map(move |k| {
        let (sin, cos) = (turn * f64::from(k)).sin_cos();
        let out = radius * ((f64::from(k) + 0.5) / f64::from(LOOKS)).sqrt();
        centre + out * (cos * frame.tangent + sin * frame.bitangent)
    })
}

impl Outlook {
    /// Returns a for an object.
    pub(super) fn share(&self, object: usize) -> f64 {
        self.shares.iter().find(|(o, _)| *o == object).map_or(0.0, |(_, share)| *share)
    }

    /// Returns the objects of which something is known.
    pub(super) fn objects(&self) -> impl Iterator<Item = (usize, f64)> {
        self.shares.iter().copied()
    }
}

/// Returns the facets of a convex body that shine; `None` for another, or one of too many facets.
fn shining_facets(area: &dyn SampleArea, exitance: impl Fn(&Hit) -> Rgb) -> Option<Shape> {
    let facets = area.facets(&Division { count: 1, lights: &[] });
    is_convex(&facets).then(|| {
        let facets = facets.into_iter().map(|f| (exitance(&f.middle), f));
        let shining = facets.filter(|(exitance, _)| !exitance.is_black());
        Shape::Facets(shining.map(|(e, f)| (f, e)).collect())
    })
}

/// Whether no facet stands out before another.
fn is_convex(facets: &[Facet]) -> bool {
    let behind = |f: &Facet| {
        let size = f.area.sqrt();
        let corners = facets.iter().flat_map(|other| other.corners);
        corners.into_iter().all(|c| (c - f.middle.point).dot(f.middle.normal) <= FLAT * size)
    };
    facets.len() <= MOST_FACETS && facets.iter().all(behind)
}
