//! `[compare]`: what the sensors of a group are known to receive.

use std::collections::BTreeMap;
use std::fmt;

use serde::de::{SeqAccess, Visitor};
use serde::{Deserialize, Deserializer};

use super::references;
use super::sensor::SensorSpec;
use super::source::Source;
use super::values::{AtLeast0, Number};
use crate::Result;

/// Says where the known illuminances of a group of sensors come from.
#[derive(Debug, Clone, PartialEq)]
pub enum CompareSpec {
    /// They are written down, lx, one for each sensor in order.
    Values(Vec<f64>),
    /// The scene is Sobolev's problem, which has an exact solution.
    Sobolev,
}

impl<'de> Deserialize<'de> for CompareSpec {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(CompareVisitor)
    }
}

struct CompareVisitor;

impl<'de> Visitor<'de> for CompareVisitor {
    type Value = CompareSpec;

    fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str("\"sobolev\" or a list of illuminances, lx, one for each sensor")
    }

    fn visit_str<E: serde::de::Error>(self, word: &str) -> Result<CompareSpec, E> {
        if word == "sobolev" {
            return Ok(CompareSpec::Sobolev);
        }
        Err(E::custom(format!("must be \"sobolev\" or a list of illuminances, found {word:?}")))
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut seq: A) -> Result<CompareSpec, A::Error> {
        let mut values = Vec::new();
        while let Some(number) = seq.next_element::<Number<AtLeast0>>()? {
            values.push(number.0);
        }
        Ok(CompareSpec::Values(values))
    }
}

/// Checks that every group exists.
pub(super) fn check(
    compare: &BTreeMap<String, CompareSpec>,
    sensors: &BTreeMap<String, SensorSpec>,
    source: &Source,
) -> Result<()> {
    compare.keys().try_for_each(|group| {
        references::check(group, sensors, "group of sensors", &["compare", group], source)
    })
}
