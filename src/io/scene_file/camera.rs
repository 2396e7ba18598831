//! `[cameras.NAME.TYPE]`: where pictures are taken from.

use glam::DVec3;
use serde::Deserialize;

use super::source::Entry;
use super::values::{Opening, number};
use super::vectors::{columns_rows, direction_if, point};
use crate::Result;

/// Describes a camera.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(rename_all = "lowercase")]
#[non_exhaustive]
pub enum CameraSpec {
    /// A pinhole.
    Perspective(PerspectiveSpec),
}

impl CameraSpec {
    pub(super) const fn type_name(&self) -> &'static str {
        match self {
            Self::Perspective(_) => "perspective",
        }
    }

    pub(super) fn check(&self, entry: &Entry) -> Result<()> {
        match self {
            Self::Perspective(spec) => spec.check(entry),
        }
    }
}

/// Describes a pinhole camera.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PerspectiveSpec {
    /// The eye, metres.
    #[serde(deserialize_with = "point")]
    pub from: DVec3,
    /// The point in the middle of the picture, metres; not the eye.
    #[serde(deserialize_with = "point")]
    pub to: DVec3,
    /// The vertical opening, degrees, between 0 and 180.
    #[serde(deserialize_with = "number::<Opening, _>")]
    pub fov: f64,
    /// Columns and rows of pixels.
    #[serde(deserialize_with = "columns_rows")]
    pub resolution: [u32; 2],
    /// What is up in the picture, of length 1, not along the view; when left out z, or y where the view is along z.
    #[serde(default, deserialize_with = "direction_if")]
    pub up: Option<DVec3>,
}

impl PerspectiveSpec {
    /// The smallest sine between `up` and the view from which a picture's axes are still good to eight digits.
    const SMALLEST_SINE: f64 = 1e-8;

    fn check(&self, entry: &Entry) -> Result<()> {
        let Some(view) = (self.to - self.from).try_normalize() else {
            let message = format!("`to` and `from` in {} are the same point", entry.header());
            return Err(entry.error("to", message, "write in `to` a point to look at"));
        };
        let along = |up: DVec3| up.cross(view).length() < Self::SMALLEST_SINE;
        if self.up.is_some_and(along) {
            let message = format!("`up` in {} is along the view", entry.header());
            return Err(entry.error("up", message, "write another direction, or leave `up` out"));
        }
        Ok(())
    }
}
