//! `[kind.NAME.type]`: checks the three levels before serde reads below them, and tells which types
//! each kind has.

use serde::de::{Deserialize, Deserializer, Error as _, Visitor, value};
use toml::Spanned;
use toml::de::{DeTable, DeValue};

use super::camera::CameraSpec;
use super::light::WrittenLight;
use super::material::MaterialSpec;
use super::object::ObjectSpec;
use super::sensor::WrittenSensor;
use super::source::{Source, header};
use super::suggest::{list, nearest};
use crate::Result;

/// The kinds of things with names, in the plural that heads them.
pub(super) const KINDS: [&str; 5] = ["materials", "objects", "lights", "cameras", "sensors"];

/// Returns the types of a kind.
pub(super) fn types(kind: &str) -> &'static [&'static str] {
    match kind {
        "materials" => variants::<MaterialSpec>(),
        "objects" => variants::<ObjectSpec>(),
        "lights" => variants::<WrittenLight>(),
        "cameras" => variants::<CameraSpec>(),
        "sensors" => variants::<WrittenSensor>(),
        _ => &[],
    }
}

/// Checks that every named thing is a table with exactly one, known, type.
pub(super) fn check(root: &DeTable, source: &Source) -> Result<()> {
    for kind in KINDS {
        let things = root.get(kind).and_then(|value| value.get_ref().as_table());
        for (name, thing) in things.into_iter().flatten() {
            check_thing(kind, name, thing, source)?;
        }
    }
    Ok(())
}

fn check_thing(
    kind: &str,
    name: &Spanned<impl AsRef<str>>,
    thing: &Spanned<DeValue>,
    source: &Source,
) -> Result<()> {
    let types = types(kind);
    let path = [kind, name.get_ref().as_ref()];
    let heading = header(&path);
    let example = || {
        let meant = header(&[kind, path[1], types.first().unwrap_or(&"TYPE")]);
        format!("write {meant}; the types of {kind} are: {}", list(types))
    };
    let DeValue::Table(table) = thing.get_ref() else {
        let message = format!("{heading} must be a table with a type in its header");
        return Err(source.error_at(&thing.span(), message, Some(example())));
    };
    if let Some(stranger) = table.keys().find(|key| !types.contains(&key.get_ref().as_ref())) {
        let message = format!("unknown type `{stranger}` in {heading}");
        let help = match nearest(stranger.get_ref(), types) {
            Some(r#type) => format!("did you mean `{type}`?"),
            None => example(),
        };
        return Err(source.error_at(&stranger.span(), message, Some(help)));
    }
    let found: Vec<_> = table.keys().collect();
    match found.as_slice() {
        [only] => match table.get(only.get_ref().as_ref()) {
            Some(spec) if !spec.get_ref().is_table() => {
                // serde would take an array for a struct, field by field.
                let message = format!("`{only}` in {heading} must be a table");
                Err(source.error_at(&spec.span(), message, Some(example())))
            }
            _ => Ok(()),
        },
        [] => {
            Err(source.error_at(&thing.span(), format!("{heading} has no type"), Some(example())))
        }
        [.., last] => {
            // The one written later is the likelier slip; an override is written last of all.
            let culprit = found.iter().max_by_key(|key| key.span().start).unwrap_or(last);
            let names: Vec<&str> = found.iter().map(|key| key.get_ref().as_ref()).collect();
            let message = format!("{heading} has more than one type: {}", list(&names));
            let help = "a thing has one type; give the other one a name of its own";
            Err(source.error_at(&culprit.span(), message, Some(help.to_owned())))
        }
    }
}

/// Returns the variants of an enum, as its derived `Deserialize` tells them to a deserializer.
fn variants<'de, T: Deserialize<'de>>() -> &'static [&'static str] {
    let mut names: &'static [&'static str] = &[];
    // The listener always refuses: only what it heard is of interest.
    let _ = T::deserialize(Listener(&mut names));
    names
}

struct Listener<'a>(&'a mut &'static [&'static str]);

impl<'de> Deserializer<'de> for Listener<'_> {
    type Error = value::Error;

    fn deserialize_enum<V: Visitor<'de>>(
        self,
        _name: &'static str,
        variants: &'static [&'static str],
        _visitor: V,
    ) -> Result<V::Value, value::Error> {
        *self.0 = variants;
        Err(value::Error::custom("heard"))
    }

    fn deserialize_any<V: Visitor<'de>>(self, _visitor: V) -> Result<V::Value, value::Error> {
        Err(value::Error::custom("not an enum"))
    }

    serde::forward_to_deserialize_any! {
        bool i8 i16 i32 i64 u8 u16 u32 u64 f32 f64 char str string bytes byte_buf option unit
        unit_struct newtype_struct seq tuple tuple_struct map struct identifier ignored_any
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn types_are_heard_from_serde() {
        assert_eq!(types("nothing"), [""; 0]);
        assert_eq!(types("objects"), ["box", "rectangle", "disc", "sphere", "plane", "mesh", "sh"]);
        assert_eq!(types("sensors"), ["points", "grid", "line", "surface"]);
        assert_eq!(types("lights"), ["point", "lambert", "spot"]);
        assert!(KINDS.into_iter().all(|kind| !types(kind).is_empty()));
    }
}
