//! What a scene file says, as the problems need to know it.

use glam::DVec3;

use super::{Mismatch, Result};
use crate::io::scene_file::{DistributionSpec, LightSpec, MaterialSpec, ObjectSpec, SceneFile};
use crate::math::Rgb;
use crate::study::load;

/// How far places may differ, relative to the size of the problem, and unit vectors from each
/// other.
pub(super) const NEAR: f64 = 1e-9;

/// A grey Lambert material.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Grey {
    pub(super) reflectance: f64,
    /// The exitance by itself, lm/m2.
    pub(super) exitance: f64,
}

/// Says what in the scene is not as it should be.
pub(super) fn differs<T>(what: impl Into<String>) -> Result<T, Mismatch> {
    Err(Mismatch::Scene(what.into()))
}

/// Returns a Lambert material.
pub(super) fn lambert(file: &SceneFile, name: &str) -> Result<(Rgb, Rgb), Mismatch> {
    match file.materials.get(name) {
        Some(MaterialSpec::Lambert(spec)) => Ok((spec.reflectance, spec.exitance)),
        _ => differs(format!("material `{name}` is not Lambertian")),
    }
}

/// Returns a Lambert material that is grey.
pub(super) fn grey(file: &SceneFile, name: &str) -> Result<Grey, Mismatch> {
    let (reflectance, exitance) = lambert(file, name)?;
    let is_grey = |colour: Rgb| colour.0[0] == colour.0[1] && colour.0[1] == colour.0[2];
    if !is_grey(reflectance) || !is_grey(exitance) {
        return differs(format!("material `{name}` has a colour"));
    }
    Ok(Grey { reflectance: reflectance.0[0], exitance: exitance.0[0] })
}

/// Returns the reflectance of a grey Lambert material that does not emit.
pub(super) fn dark(file: &SceneFile, name: &str) -> Result<f64, Mismatch> {
    let Grey { reflectance, exitance } = grey(file, name)?;
    if exitance > 0.0 {
        return differs(format!("material `{name}` emits"));
    }
    Ok(reflectance)
}

/// Returns the only object.
pub(super) fn only_object(file: &SceneFile) -> Result<(&str, &ObjectSpec), Mismatch> {
    match file.objects.first_key_value() {
        Some((name, object)) if file.objects.len() == 1 => Ok((name, object)),
        _ => differs(format!("it has {} objects", file.objects.len())),
    }
}

/// Returns both objects of a scene that has two, in the order of their names.
pub(super) fn two_objects(file: &SceneFile) -> Result<[&ObjectSpec; 2], Mismatch> {
    let objects: Vec<&ObjectSpec> = file.objects.values().collect();
    match objects[..] {
        [one, other] => Ok([one, other]),
        _ => differs(format!("it has {} objects", objects.len())),
    }
}

/// Returns the only light, isotropic and white.
pub(super) fn only_lamp(file: &SceneFile) -> Result<&LightSpec, Mismatch> {
    match lamps(file)?[..] {
        [lamp] => Ok(lamp),
        _ => differs(format!("it has {} lights", file.lights.len())),
    }
}

/// Returns all lights, if they are isotropic and white.
pub(super) fn lamps(file: &SceneFile) -> Result<Vec<&LightSpec>, Mismatch> {
    for (name, light) in &file.lights {
        if light.distribution != DistributionSpec::Isotropic {
            return differs(format!("light `{name}` does not shine equally to all sides"));
        }
        if light.colour != Rgb::WHITE {
            return differs(format!("light `{name}` has a colour"));
        }
    }
    Ok(file.lights.values().collect())
}

/// Rejects lights that are no surface.
pub(super) fn no_lamps(file: &SceneFile) -> Result<(), Mismatch> {
    match file.lights.first_key_value() {
        Some((name, _)) => differs(format!("there is a light `{name}`")),
        None => Ok(()),
    }
}

/// Returns the intensity of an isotropic light, cd.
pub(super) fn intensity(lamp: &LightSpec) -> f64 {
    load::light("", lamp).intensity.luminance()
}

/// Whether two unit vectors are the same.
pub(super) fn same(a: DVec3, b: DVec3) -> bool {
    a.distance(b) <= NEAR
}
