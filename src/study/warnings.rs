//! What of a scene is probably not meant: things that cut through each other, or are where no light comes. A sentence each.

use std::collections::BTreeMap;

use rayon::prelude::*;

use super::load::SensorGroup;
use super::solids::Solid;
use crate::io::scene_file::SceneFile;

/// Says which objects cut through or lie behind closed ones.
pub(super) fn overlaps(solids: &[Solid]) -> Vec<String> {
    let of = |one: &Solid| -> Vec<String> {
        // The smaller of two is judged against the larger: a room lies around its contents.
        let larger = solids.iter().filter(|other| other.size() > one.size());
        larger.filter_map(|other| overlap(one, other)).collect()
    };
    solids.par_iter().flat_map_iter(of).collect()
}

fn overlap(one: &Solid, other: &Solid) -> Option<String> {
    let (name, into) = (one.name(), other.name());
    let share = one.share_behind(other).filter(|share| *share > 0.0)?;
    Some(if share >= 1.0 {
        format!("object `{name}` is entirely outside the room, or inside the object, `{into}`")
    } else {
        let percent = 100.0 * share.max(0.01);
        format!(
            "object `{name}` cuts through `{into}`: about {percent:.0} % of its surface is behind it"
        )
    })
}

/// Says which cameras are outside the room or inside an object.
pub(super) fn misplaced_cameras(file: &SceneFile, solids: &[Solid]) -> Vec<String> {
    let eyes = file.cameras.iter().map(|(name, spec)| (name, spec.from()));
    eyes.filter_map(|(name, from)| {
        let solid = solids.iter().find(|s| s.is_behind(from))?;
        let behind = solid.name();
        Some(format!("camera `{name}` is outside the room, or inside the object, `{behind}`"))
    })
    .collect()
}

/// Says which groups have no sensors, and of which some get no light.
pub(super) fn misplaced_sensors(groups: &[SensorGroup]) -> Vec<String> {
    let mut warnings = Vec::new();
    for group in groups {
        if group.sensors.is_empty() {
            warnings.push(format!(
                "sensors `{}`: the border leaves no area, so there are none",
                group.name
            ));
        }
        let mut hidden = BTreeMap::<&str, usize>::new();
        for object in group.behind.iter().flatten() {
            *hidden.entry(object).or_default() += 1;
        }
        warnings.extend(hidden.iter().map(|(object, count)| {
            format!(
                "sensors `{}`: {count} of {} are outside the room, or inside the object, `{object}` and get no light",
                group.name,
                group.sensors.len(),
            )
        }));
    }
    warnings
}
