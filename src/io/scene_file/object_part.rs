//! "object.part": what sensors lie on.

use std::collections::BTreeMap;

use super::object::{BoxFace, ObjectSpec};
use super::source::Entry;
use super::suggest::suggest;
use crate::Result;

/// Divides "object.part" where it is not itself the name of an object, which may hold dots.
pub(super) fn object_and_part<'a>(
    on: &'a str,
    objects: &BTreeMap<String, ObjectSpec>,
) -> (&'a str, Option<&'a str>) {
    match on.rsplit_once('.') {
        Some((name, part)) if !objects.contains_key(on) => (name, Some(part)),
        _ => (on, None),
    }
}

pub(super) fn box_face(name: &str, face: Option<&str>, entry: &Entry) -> Result<BoxFace> {
    let names = BoxFace::ALL.map(BoxFace::name);
    let Some(face) = face else {
        let help = format!("write `on = \"{name}.z_min\"`");
        return Err(entry.error("on", format!("`{name}` is a box: a face is missing"), &help));
    };
    let found = BoxFace::ALL.into_iter().find(|f| f.name() == face);
    let help = || suggest(face, &names, "faces of a box");
    found.ok_or_else(|| entry.error("on", format!("`{name}` has no face `{face}`"), &help()))
}
