//! `[require]`: what the sensors of a group must show.

use std::collections::BTreeMap;
use std::fmt;

use serde::Deserialize;

use super::references;
use super::sensor::SensorSpec;
use super::source::Source;
use super::values::{AtLeast0, Inline, Share, number_if};
use crate::Result;

/// Describes the requirements on one group of sensors; at least one.
#[derive(Debug, Clone, Copy, PartialEq, Default, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct RequireSpec {
    /// The mean must be at least this, lx.
    #[serde(deserialize_with = "number_if::<AtLeast0, _>")]
    pub mean_min: Option<f64>,
    /// The mean must be at most this, lx.
    #[serde(deserialize_with = "number_if::<AtLeast0, _>")]
    pub mean_max: Option<f64>,
    /// The least must be at least this, lx.
    #[serde(deserialize_with = "number_if::<AtLeast0, _>")]
    pub least_min: Option<f64>,
    /// The largest must be at most this, lx.
    #[serde(deserialize_with = "number_if::<AtLeast0, _>")]
    pub largest_max: Option<f64>,
    /// U0 = least / mean must be at least this, from 0 to 1.
    #[serde(deserialize_with = "number_if::<Share, _>")]
    pub uniformity_min: Option<f64>,
}

/// Names a quantity of a group of sensors that can be required.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Quantity {
    /// The mean, lx.
    Mean,
    /// The least, lx.
    Least,
    /// The largest, lx.
    Largest,
    /// U0 = least / mean.
    Uniformity,
}

/// Bounds a quantity.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Limit {
    /// It must be at least this.
    AtLeast(f64),
    /// It must be at most this.
    AtMost(f64),
}

impl Inline for RequireSpec {
    const MUST: &'static str = "a table such as { mean_min = 500, uniformity_min = 0.6 }";
}

impl RequireSpec {
    /// Lists what is required.
    pub fn limits(&self) -> impl Iterator<Item = (Quantity, Limit)> {
        let all = [
            (Quantity::Mean, self.mean_min.map(Limit::AtLeast)),
            (Quantity::Mean, self.mean_max.map(Limit::AtMost)),
            (Quantity::Least, self.least_min.map(Limit::AtLeast)),
            (Quantity::Largest, self.largest_max.map(Limit::AtMost)),
            (Quantity::Uniformity, self.uniformity_min.map(Limit::AtLeast)),
        ];
        all.into_iter().filter_map(|(quantity, limit)| Some((quantity, limit?)))
    }
}

impl fmt::Display for Quantity {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(match self {
            Self::Mean => "mean",
            Self::Least => "least",
            Self::Largest => "largest",
            Self::Uniformity => "U0",
        })
    }
}

/// Checks that every group exists and that something is required of it.
pub(super) fn check(
    require: &BTreeMap<String, RequireSpec>,
    sensors: &BTreeMap<String, SensorSpec>,
    source: &Source,
) -> Result<()> {
    for (group, spec) in require {
        let key = ["require", group];
        references::check(group, sensors, "group of sensors", &key, source)?;
        if spec.limits().next().is_none() {
            let message = format!("`{group}` in [require] requires nothing");
            let help = format!("write it like `{group} = {{ mean_min = 500 }}`");
            return Err(source.error(&key, message, Some(help)));
        }
    }
    Ok(())
}
