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
    /// The scene is a problem whose exact solution is known.
    Exact(ExactProblem),
}

/// Names a problem whose exact solution is known, by the words of `[compare]`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ExactProblem {
    /// A point source between two infinite planes.
    Sobolev,
    /// The same between two coaxial discs of one radius.
    Discs,
    /// The inside of a sphere, with point sources anywhere, with a wall that emits, or both.
    Sphere,
    /// A sphere that a disc divides in two caps, one of which may be a hemisphere.
    Cap,
    /// The space between two concentric spheres.
    Concentric,
    /// A closed cube with a point source in its middle.
    Cube,
    /// A closed room in which everything, of any shape, sends out the same luminance.
    Furnace,
    /// Black surfaces: light comes straight from point sources, rectangles and faces of boxes.
    Direct,
}

impl ExactProblem {
    /// All problems, in the order in which messages list them.
    pub const ALL: [Self; 8] = [
        Self::Sobolev,
        Self::Discs,
        Self::Sphere,
        Self::Cap,
        Self::Concentric,
        Self::Cube,
        Self::Furnace,
        Self::Direct,
    ];

    /// Returns the word that names the problem in a scene file.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Sobolev => "sobolev",
            Self::Discs => "discs",
            Self::Sphere => "sphere",
            Self::Cap => "cap",
            Self::Concentric => "concentric",
            Self::Cube => "cube",
            Self::Furnace => "furnace",
            Self::Direct => "direct",
        }
    }
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
        write!(f, "{} or a list of illuminances, lx, one for each sensor", words())
    }

    fn visit_str<E: serde::de::Error>(self, word: &str) -> Result<CompareSpec, E> {
        let named = ExactProblem::ALL.into_iter().find(|problem| problem.name() == word);
        named.map(CompareSpec::Exact).ok_or_else(|| {
            E::custom(format!("must be {} or a list of illuminances, found {word:?}", words()))
        })
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut seq: A) -> Result<CompareSpec, A::Error> {
        let mut values = Vec::new();
        while let Some(number) = seq.next_element::<Number<AtLeast0>>()? {
            values.push(number.0);
        }
        Ok(CompareSpec::Values(values))
    }
}

/// Lists the words for problems.
fn words() -> String {
    ExactProblem::ALL.map(|problem| format!("{:?}", problem.name())).join(", ")
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
