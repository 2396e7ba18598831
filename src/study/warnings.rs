//! What of a scene is probably not meant: things that cut through each other, or are where no light
//! comes. A sentence each.

use std::collections::BTreeMap;

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use super::sensors::SensorGroup;
use super::solids::{self, Solid};
use crate::io::scene_file::SceneFile;
use crate::math::Aabb;
use crate::scene::{Object, Scene, Sensor};
use crate::surface::{Bvh, Hit};

/// Says which objects cut through or lie behind closed ones.
pub(super) fn overlaps(solids: &[Solid]) -> Vec<String> {
    let rooms: Vec<&Solid> = solids.iter().filter(|s| s.is_room()).collect();
    let of = |one: &Solid| -> Vec<String> {
        // The smaller of two is judged against the larger: a room lies around its contents.
        let larger = solids.iter().filter(|other| other.size() > one.size());
        larger.filter_map(|other| overlap(one, other, &rooms)).collect()
    };
    solids.par_iter().flat_map_iter(of).collect()
}

fn overlap(one: &Solid, other: &Solid, rooms: &[&Solid]) -> Option<String> {
    let (name, into) = (one.name(), other.name());
    let share = one.share_behind(other, rooms).filter(|share| *share > 0.0)?;
    if share >= 1.0 && one.is_room() && other.is_room() {
        // Two rooms side by side.
        return None;
    }
    Some(if share >= 1.0 {
        format!("object `{name}` is entirely outside the room, or inside the object, `{into}`")
    } else {
        let percent = 100.0 * share.max(0.01);
        format!(
            "object `{name}` cuts through `{into}`: about {percent:.0} % of its surface is behind \
             it"
        )
    })
}

/// Points per side of the square that is mapped onto a surface in search of what lies in its place.
const SIDE: u32 = 8;

/// Says which surfaces lie in one place: what counts there is decided by a rule, not by what was
/// meant.
pub(super) fn coincidences(scene: &Scene, solids: &[Solid]) -> Vec<String> {
    let objects = scene.objects();
    let neighbours = Neighbours::of(objects.iter().map(|o| o.surface.bounds()).collect());
    let is_room = |i: usize| solids.iter().any(|s| s.is_room() && s.name() == objects[i].name);
    let of = |i: usize| -> Vec<String> {
        let Some(area) = &objects[i].area else { return Vec::new() };
        let middle = |k: u32| (f64::from(k) + 0.5) / f64::from(SIDE);
        let points = (0..SIDE * SIDE).map(|k| DVec2::new(middle(k / SIDE), middle(k % SIDE)));
        let hits: Vec<Hit> = points.map(|u| area.sample_area(u).hit).collect();
        let mut found = Vec::new();
        for j in neighbours.of_box(i) {
            let both_shine = objects[i].emits() && objects[j].emits();
            let pair = (&objects[i].name, &objects[j].name);
            let in_place = hits.iter().filter_map(|h| Some((h, scene.in_place_of(h, j)?)));
            let in_place: Vec<_> = in_place.collect();
            let alike = in_place.iter().find(|(h, (normal, _))| h.normal.dot(*normal) > 0.0);
            // Each pair is told once, by the smaller or the first of equals.
            let tells = (area.area(), i) < (area_of(&objects[j]), j);
            if let Some((_, (_, first))) = alike.filter(|_| tells) {
                let what = if both_shine {
                    format!("there their light adds up, and `{}` reflects", objects[*first].name)
                } else {
                    format!("there `{}` counts", objects[*first].name)
                };
                found.push(format!(
                    "objects `{}` and `{}` lie in one place: {what}",
                    pair.0, pair.1
                ));
            } else if alike.is_none() && !in_place.is_empty() && j > i && is_room(i) && is_room(j) {
                found.push(format!(
                    "rooms `{}` and `{}` share a wall: each side shows its own material",
                    pair.0, pair.1
                ));
            }
        }
        found
    };
    (0..objects.len()).into_par_iter().flat_map_iter(of).collect()
}

fn area_of(object: &Object) -> f64 {
    object.area.as_ref().map_or(f64::INFINITY, |area| area.area())
}

/// Finds the boxes that meet one of them.
struct Neighbours {
    bounds: Vec<Aabb>,
    tree: Bvh,
    /// Those without end, which the tree leaves out.
    endless: Vec<usize>,
}

impl Neighbours {
    fn of(bounds: Vec<Aabb>) -> Self {
        let endless = (0..bounds.len()).filter(|i| !bounds[*i].is_finite()).collect();
        Self { tree: Bvh::build(&bounds), endless, bounds }
    }

    /// Lists the others that meet one, in ascending order.
    fn of_box(&self, i: usize) -> Vec<usize> {
        let own = self.bounds[i];
        let mut near = self.endless.clone();
        if own.is_finite() {
            let rounding = rounding(&own);
            let wide = Aabb { min: own.min - rounding, max: own.max + rounding };
            self.tree.overlapping(wide, |j| near.push(j));
        } else {
            near.extend((0..self.bounds.len()).filter(|j| self.bounds[*j].is_finite()));
        }
        near.retain(|j| *j != i && meets(&own, &self.bounds[*j]));
        near.sort_unstable();
        near
    }
}

/// Returns how far rounding may move the coordinates of a box.
fn rounding(a: &Aabb) -> DVec3 {
    1e-12 * a.min.abs().max(a.max.abs())
}

/// Whether two boxes meet, as far as rounding can tell.
fn meets(a: &Aabb, b: &Aabb) -> bool {
    let rounding = rounding(a);
    a.min.cmple(b.max + rounding).all() && b.min.cmple(a.max + rounding).all()
}

/// How far under a surface, relative to the size of its object, nobody puts a sensor on purpose.
const JUST_UNDER: f64 = 1e-3;

/// Names what a sensor lies just under: too far to lie on it, and so near that it gets hardly any
/// light.
pub(super) fn just_under(sensor: &Sensor, scene: &Scene) -> Option<(String, f64)> {
    let ray = scene.settled(sensor).as_hit().leave(sensor.normal);
    let (object, hit) = scene.hit(&ray)?;
    let bounds = scene.objects()[object].surface.bounds();
    let near = JUST_UNDER * bounds.extent().length();
    let cos = hit.normal.dot(ray.direction);
    let lights_it = cos < 0.0 && scene.objects()[object].emits();
    let covers = cos.abs() > 0.5 && hit.distance <= near && !lights_it;
    (bounds.is_finite() && covers).then(|| (scene.objects()[object].name.clone(), hit.distance))
}

/// Says which cameras are outside the room or inside an object.
pub(super) fn misplaced_cameras(file: &SceneFile, solids: &[Solid]) -> Vec<String> {
    let eyes = file.cameras.iter().map(|(name, spec)| (name, spec.from()));
    eyes.filter_map(|(name, from)| {
        let behind = solids::behind(from, None, solids)?.name();
        Some(format!("camera `{name}` is outside the room, or inside the object, `{behind}`"))
    })
    .collect()
}

/// Says which groups have no sensors, and of which some get no light.
pub(super) fn misplaced_sensors(groups: &[SensorGroup], scene: &Scene) -> Vec<String> {
    let mut warnings = Vec::new();
    for group in groups {
        if group.sensors.is_empty() {
            warnings.push(format!(
                "sensors `{}`: the border leaves no area, so there are none",
                group.name
            ));
        }
        // Sensors that were placed on a surface are where they are meant to be.
        let counting = group.sensors.iter().zip(&group.behind);
        let counting = counting.filter(|(sensor, behind)| behind.is_none() && sensor.error == 0.0);
        let counting: Vec<&Sensor> = counting.map(|(sensor, _)| sensor).collect();
        let covered = counting.par_iter().filter_map(|sensor| just_under(sensor, scene));
        let mut under = BTreeMap::<String, (usize, f64)>::new();
        for (object, depth) in covered.collect::<Vec<_>>() {
            let (count, deepest) = under.entry(object).or_default();
            (*count, *deepest) = (*count + 1, depth.max(*deepest));
        }
        warnings.extend(under.iter().map(|(object, (count, deepest))| {
            format!(
                "sensors `{}`: {count} of {} are just under `{object}`, by {deepest:.1e} m at \
                 most; raise them to measure on it",
                group.name,
                group.sensors.len(),
            )
        }));
        let mut hidden = BTreeMap::<&str, usize>::new();
        for object in group.behind.iter().flatten() {
            *hidden.entry(object).or_default() += 1;
        }
        warnings.extend(hidden.iter().map(|(object, count)| {
            format!(
                "sensors `{}`: {count} of {} are outside the room, or inside the object, \
                 `{object}` and get no light",
                group.name,
                group.sensors.len(),
            )
        }));
    }
    warnings
}
