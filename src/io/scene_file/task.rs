//! `[render]` and `[illum]`: what to compute, how, and when to stop.

use std::fmt;
use std::time::Duration;

use serde::de::{Error, Visitor};
use serde::{Deserialize, Deserializer};

use super::values::{
    AtLeast0, HalfTurn, Inline, Part, Size, choice, count_if, number, number_if, refusal, table,
    table_if, time_if, whole,
};
use super::vectors::pixels;
use crate::math::choice::choice as choices;
use crate::scene::{Display, Exposure, Filter, Layer, Tone, Window};

/// Describes how a picture is made.
#[derive(Debug, Clone, PartialEq, Default, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct RenderSpec {
    /// The estimator of luminance.
    #[serde(deserialize_with = "choice")]
    pub estimator: RenderEstimator,
    /// The name of the camera; may be left out when there is one.
    pub camera: Option<String>,
    /// The part of the picture to compute, pixels of the picture at its full size; when left out
    /// all of it.
    #[serde(deserialize_with = "crop_if")]
    pub crop: Option<Window>,
    /// How samples weigh in a pixel.
    #[serde(deserialize_with = "choice")]
    pub filter: Filter,
    /// The layers of an EXR picture beside luminance and its standard error; when left out all.
    #[serde(deserialize_with = "layers_if")]
    pub layers: Option<Vec<Layer>>,
    /// The seed of the random numbers.
    #[serde(deserialize_with = "whole::<0, { u64::MAX }, _, _>")]
    pub seed: u64,
    /// When to stop.
    #[serde(deserialize_with = "table")]
    pub stop: StopSpec,
    /// The time between checkpoints, above 0; a default when left out.
    #[serde(deserialize_with = "time_if")]
    pub checkpoint: Option<Duration>,
    /// The factor from luminance to the values of the PNG, of which 1 is white; or a share of the
    /// pixels, such as "98%", that stays below white. When left out the geometric mean of the
    /// luminances becomes 0.18.
    #[serde(deserialize_with = "exposure")]
    pub exposure: Exposure,
    /// What the PNG shows of values near and above white.
    #[serde(deserialize_with = "choice")]
    pub tone: Tone,
    /// How far SH objects may be simplified; not at all when left out. Objects may have their own.
    #[serde(deserialize_with = "table_if")]
    pub detail: Option<DetailSpec>,
}

impl RenderSpec {
    /// Returns how the picture is shown.
    pub const fn display(&self) -> Display {
        Display { exposure: self.exposure, tone: self.tone }
    }
}

/// Reads the left, top, right and bottom border of a part of a picture, the last two behind it.
fn crop_if<'de, D: Deserializer<'de>>(d: D) -> Result<Option<Window>, D::Error> {
    let [x0, y0, x1, y1] = pixels(d)?;
    let none = |_| {
        let found = format!("[{x0}, {y0}, {x1}, {y1}]");
        refusal("[left, top, right, bottom], the last two above the first two", &found, "")
    };
    Window::new([x0, y0], [x1, y1]).map(Some).map_err(none)
}

/// Reads a factor, or a share in per cent.
fn exposure<'de, D: Deserializer<'de>>(d: D) -> Result<Exposure, D::Error> {
    d.deserialize_any(ExposureVisitor)
}

struct ExposureVisitor;

impl ExposureVisitor {
    const MUST: &'static str = "a number above 0, or a share of the pixels such as \"98%\"";
}

impl Visitor<'_> for ExposureVisitor {
    type Value = Exposure;

    fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(Self::MUST)
    }

    fn visit_i64<E: Error>(self, x: i64) -> Result<Exposure, E> {
        self.visit_f64(x as f64)
    }

    fn visit_f64<E: Error>(self, factor: f64) -> Result<Exposure, E> {
        if factor > 0.0 && factor.is_finite() {
            return Ok(Exposure::Factor(factor));
        }
        Err(refusal(Self::MUST, &factor, ""))
    }

    fn visit_str<E: Error>(self, text: &str) -> Result<Exposure, E> {
        text.parse().map_err(|_| refusal(Self::MUST, &format!("{text:?}"), ""))
    }
}

/// Reads words of layers.
fn layers_if<'de, D: Deserializer<'de>>(d: D) -> Result<Option<Vec<Layer>>, D::Error> {
    let words = Vec::<LayerWord>::deserialize(d)?;
    Ok(Some(words.into_iter().map(|word| word.0).collect()))
}

/// One word among others.
struct LayerWord(Layer);

impl<'de> Deserialize<'de> for LayerWord {
    fn deserialize<D: Deserializer<'de>>(d: D) -> Result<Self, D::Error> {
        choice(d).map(Self)
    }
}

/// Names an estimator of luminance.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum RenderEstimator {
    /// The double local estimate: strategies A and B and hits of emitters combined.
    #[default]
    DoubleLocal,
    /// The double local estimate by strategy A alone: walk hits connected to the visible point.
    DoubleLocalA,
    /// The double local estimate by strategy B alone: walk hits connected to a sampled intermediate
    /// point.
    DoubleLocalB,
    /// Backward path tracing.
    Path,
}

choices!(RenderEstimator, "estimator of luminance":
    DoubleLocal = "double-local" "",
    DoubleLocalA = "double-local-a" "",
    DoubleLocalB = "double-local-b" "",
    Path = "path" "",
);

/// Describes how illuminance at sensors is computed.
#[derive(Debug, Clone, PartialEq, Default, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct IllumSpec {
    /// The estimator of illuminance.
    #[serde(deserialize_with = "choice")]
    pub estimator: IllumEstimator,
    /// The seed of the random numbers.
    #[serde(deserialize_with = "whole::<0, { u64::MAX }, _, _>")]
    pub seed: u64,
    /// When to stop.
    #[serde(deserialize_with = "table")]
    pub stop: StopSpec,
    /// For radiosity: about how many patches the surfaces get in all, 1 to 100 000; a default when
    /// left out.
    #[serde(deserialize_with = "patches_if")]
    pub patches: Option<usize>,
    /// For photons: the radius of the discs that count them, above 0, metres; a default when left
    /// out.
    #[serde(deserialize_with = "number_if::<Size, _>")]
    pub radius: Option<f64>,
}

/// Reads a number of patches, of a key that may be left out.
fn patches_if<'de, D: Deserializer<'de>>(d: D) -> Result<Option<usize>, D::Error> {
    whole::<1, 100_000, _, _>(d).map(Some)
}

/// Names an estimator of illuminance.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum IllumEstimator {
    /// The local estimate.
    #[default]
    Local,
    /// Backward path tracing.
    Path,
    /// Radiosity between patches.
    Radiosity,
    /// Photons counted on discs.
    Photon,
}

choices!(IllumEstimator, "estimator of illuminance":
    Local = "local" "The local estimate: one walk of light serves all sensors",
    Path = "path" "Backward path tracing, the reference",
    Radiosity = "radiosity" "Patches that exchange light: no statistical error, and none is \
                             claimed",
    Photon = "photon" "Photons counted on a disc about each sensor: direct simulation",
);

/// Says by how much the truncation of an SH object to a lower degree may show in a picture.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct DetailSpec {
    /// How far a point of the surface may move in the picture, pixels, 0 or more; at 0 the degree
    /// is the full one.
    #[serde(deserialize_with = "number::<AtLeast0, _>")]
    pub pixels: f64,
    /// How far a normal may turn anywhere, degrees, from 0 to 180; at 180, as when it is left out,
    /// it does not matter.
    #[serde(deserialize_with = "number::<HalfTurn, _>")]
    pub normal: f64,
}

impl Default for DetailSpec {
    /// Takes a quarter of a pixel. What is left out of a detailed shape turns some normals by tens
    /// of degrees, within parts of it that the pixels keep small: a limit that holds everywhere is
    /// for smooth shapes, and only where it is asked for.
    fn default() -> Self {
        Self { pixels: 0.25, normal: 180.0 }
    }
}

impl Inline for DetailSpec {
    const MUST: &'static str = "a table such as { pixels = 0.25 }";
}

impl Inline for RenderSpec {
    const MUST: &'static str = "a table";
}

impl Inline for IllumSpec {
    const MUST: &'static str = "a table";
}

impl Inline for StopSpec {
    const MUST: &'static str = "a table such as { relative_error = 0.01, time = \"10m\" }";
}

/// Says when a computation stops: at the first of what is given.
#[derive(Debug, Clone, Copy, PartialEq, Default, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct StopSpec {
    /// The relative error to reach, between 0 and 1: of illuminance the largest 95 % half-width, of
    /// a picture the standard error that 95 % of the pixels keep.
    #[serde(deserialize_with = "number_if::<Part, _>")]
    pub relative_error: Option<f64>,
    /// The time allowed, above 0.
    #[serde(deserialize_with = "time_if")]
    pub time: Option<Duration>,
    /// The number of walks allowed, at least 1.
    #[serde(deserialize_with = "count_if")]
    pub walks: Option<u64>,
}
