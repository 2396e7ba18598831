//! `spacing` of grids of sensors: a number of metres, or the rule of EN 12464-1.

use std::fmt;

use serde::de::{Error, Visitor};
use serde::{Deserialize, Deserializer};

use super::sensor::GridLayout;
use super::values::{Range, Size};

/// "en12464" or a number of metres.
#[derive(Debug)]
pub(super) struct Spacing(pub(super) GridLayout);

impl<'de> Deserialize<'de> for Spacing {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(SpacingVisitor)
    }
}

struct SpacingVisitor;

impl Visitor<'_> for SpacingVisitor {
    type Value = Spacing;

    fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str("\"en12464\" or a number of metres")
    }

    fn visit_str<E: Error>(self, word: &str) -> Result<Spacing, E> {
        if word == "en12464" {
            return Ok(Spacing(GridLayout::En12464));
        }
        Err(E::custom(format!("must be \"en12464\" or a number of metres, found {word:?}")))
    }

    fn visit_i64<E: Error>(self, metres: i64) -> Result<Spacing, E> {
        self.visit_f64(metres as f64)
    }

    fn visit_f64<E: Error>(self, metres: f64) -> Result<Spacing, E> {
        if metres.is_finite() && Size::holds(metres) {
            return Ok(Spacing(GridLayout::Spacing(metres)));
        }
        Err(E::custom(format!(
            "must be a number of metres above 0 and at most 1e9, found {metres}"
        )))
    }
}
