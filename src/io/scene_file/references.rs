//! Names that refer to other things of the scene: each must exist.

use std::collections::BTreeMap;

use super::material::MaterialSpec;
use super::object::{BoxSpec, ObjectSpec};
use super::source::Source;
use super::suggest::suggest;
use crate::Result;

/// Checks that `name`, written at `key`, is one of the things; `what` is their singular, of which
/// the first word gets the plural.
pub(super) fn check<T>(
    name: &str,
    things: &BTreeMap<String, T>,
    what: &str,
    key: &[&str],
    source: &Source,
) -> Result<()> {
    if things.contains_key(name) {
        return Ok(());
    }
    let names: Vec<&String> = things.keys().collect();
    let (noun, rest) = what.split_at(what.find(' ').unwrap_or(what.len()));
    let help = suggest(name, &names, &format!("{noun}s{rest}"));
    Err(source.error(key, format!("unknown {what} `{name}`"), Some(help)))
}

/// Checks the materials an object names.
pub(super) fn check_materials(
    name: &str,
    object: &ObjectSpec,
    materials: &BTreeMap<String, MaterialSpec>,
    source: &Source,
) -> Result<()> {
    let key = ["objects", name, object.type_name(), "material"];
    check(object.material(), materials, "material", &key, source)?;
    match object {
        ObjectSpec::Box(spec) => check_faces(name, spec, materials, source),
        _ => Ok(()),
    }
}

/// Checks the materials that mixtures name.
pub(super) fn check_mixtures(
    materials: &BTreeMap<String, MaterialSpec>,
    source: &Source,
) -> Result<()> {
    for (name, material) in materials {
        let MaterialSpec::Mixture(mixture) = material else { continue };
        for part in mixture.of.keys() {
            let key = ["materials", name, "mixture", "of", part];
            check(part, materials, "material", &key, source)?;
            if let Some(MaterialSpec::Mixture(_)) = materials.get(part) {
                let message = if part == name {
                    format!("`{part}` is mixed of itself")
                } else {
                    format!("`{part}` is a mixture itself")
                };
                let help = "name the materials it is mixed of, each with its share of the whole";
                return Err(source.error(&key, message, Some(help.to_owned())));
            }
        }
    }
    Ok(())
}

fn check_faces(
    name: &str,
    spec: &BoxSpec,
    materials: &BTreeMap<String, MaterialSpec>,
    source: &Source,
) -> Result<()> {
    spec.faces.iter().try_for_each(|(face, material)| {
        let key = ["objects", name, "box", "faces", face.name()];
        check(material, materials, "material", &key, source)
    })
}
