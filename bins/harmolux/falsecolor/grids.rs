//! The group of sensors that is shown: one that is a grid.

use std::path::Path;

use harmolux::error::{InputError, shown};
use harmolux::io::sensor_table::MeasuredGroup;
use harmolux::plots::Lattice;
use harmolux::{Error, Result};

use super::Falsecolor;
use crate::common::say;

const NO_GRID: &str = "make the sensors a grid, [sensors.NAME.grid]; lines of sensors are plotted \
                       by `harmolux illum SCENE -o lines.svg`";

/// Takes the group that was named, or the only one that is a grid.
pub(super) fn choose(
    verb: &Falsecolor,
    groups: Vec<MeasuredGroup>,
) -> Result<(MeasuredGroup, Lattice)> {
    let path: &Path = &verb.input;
    let names = |groups: &[MeasuredGroup]| {
        groups.iter().map(|group| group.name.clone()).collect::<Vec<_>>().join(", ")
    };
    let all = names(&groups);
    let several = groups.len() > 1;
    if let Some(name) = &verb.group {
        let found = groups.into_iter().find(|group| group.name == *name);
        let group = found.ok_or_else(|| {
            let message = format!("there is no group `{name}` of sensors, only {all}");
            InputError::new(path, message).help("name one of these with --group")
        })?;
        let lattice = lattice(&group).map_err(|fault| no_grid(path, name, &fault))?;
        return Ok((group, lattice));
    }
    let mut faults = Vec::new();
    let mut grids = Vec::new();
    for group in groups {
        match lattice(&group) {
            Ok(lattice) => grids.push((group, lattice)),
            Err(fault) => faults.push((group.name, fault)),
        }
    }
    if grids.len() > 1 {
        let found: Vec<String> = grids.iter().map(|(group, _)| group.name.clone()).collect();
        let message = format!("several groups are grids: {}", found.join(", "));
        let help = "name the one to show with --group NAME";
        return Err(InputError::new(path, message).help(help).into());
    }
    if let (None, Some((name, fault))) = (grids.first(), faults.first()) {
        if several {
            let message = format!("none of the groups is a grid: {all}; `{name}`: {fault}");
            return Err(InputError::new(path, message).help(NO_GRID).into());
        }
        return Err(no_grid(path, name, fault));
    }
    let skipped: Vec<String> = faults.iter().map(|(name, _)| shown(name)).collect();
    if !skipped.is_empty() {
        say::note(&format!("not shown, no grids: {}", skipped.join(", ")));
    }
    grids.pop().ok_or_else(|| InputError::new(path, "the table has no sensors").into())
}

fn lattice(group: &MeasuredGroup) -> Result<Lattice> {
    Lattice::of(&group.at, group.normals.iter().copied().sum())
}

fn no_grid(path: &Path, name: &str, fault: &Error) -> Error {
    let message = format!("the sensors of `{name}` are no grid: {fault}");
    InputError::new(path, message).help(NO_GRID).into()
}
