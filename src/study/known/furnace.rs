//! The furnace: where all that is seen has one luminance L, every point receives pi L, whatever the
//! shapes are.

use super::facts::{NEAR, differs, lambert, no_lamps};
use super::{Mismatch, Result, Solution};
use crate::io::scene_file::{BoxFace, ObjectSpec, SceneFile};
use crate::math::Rgb;

/// Returns C, with which each material emits C (1 - reflectance).
pub(super) fn furnace(file: &SceneFile) -> Result<Solution<'_>, Mismatch> {
    no_lamps(file)?;
    let mut rooms = 0;
    let mut common: Option<Rgb> = None;
    for (name, object) in &file.objects {
        match object {
            ObjectSpec::Box(spec) => rooms += u32::from(spec.inward),
            ObjectSpec::Sphere(spec) => rooms += u32::from(spec.inward),
            ObjectSpec::Mesh(_) | ObjectSpec::Sh(_) => {}
            // Its back reflects and does not emit.
            open => return differs(format!("`{name}`, a {}, is open", open.type_name())),
        }
        for material in materials(object) {
            let (reflectance, exitance) = lambert(file, material)?;
            let [c, r] = [exitance.0, reflectance.0];
            let own = Rgb(std::array::from_fn(|i| c[i] / (1.0 - r[i])));
            let known = *common.get_or_insert(own);
            let same = |i: usize| (own.0[i] - known.0[i]).abs() <= NEAR * known.0[i];
            if !(0..3).all(same) {
                let found = [own, known].map(Rgb::luminance);
                return differs(format!(
                    "exitance / (1 - reflectance) is {} for material `{material}` and {} for \
                     another",
                    found[0], found[1]
                ));
            }
        }
    }
    if rooms != 1 {
        return differs(format!("{rooms} boxes or spheres have `inward = true`"));
    }
    let illuminance = common.unwrap_or(Rgb::BLACK).luminance();
    Ok(Box::new(move |_| Ok(illuminance)))
}

/// Returns the materials of an object that are to be seen.
fn materials(object: &ObjectSpec) -> Vec<&str> {
    match object {
        ObjectSpec::Box(spec) => BoxFace::ALL.map(|face| spec.face_material(face)).to_vec(),
        other => vec![other.material()],
    }
}
