//! `[cameras.NAME.TYPE]`: where pictures are taken from.

use glam::DVec3;
use serde::Deserialize;

use super::source::Entry;
use super::values::{Opening, Size, Turn, choice, number, number_if};
use super::vectors::{columns_rows, direction_if, point, point_if};
use crate::Result;
use crate::scene::FisheyeMapping;

/// Describes a camera.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(rename_all = "lowercase")]
#[non_exhaustive]
pub enum CameraSpec {
    /// A pinhole.
    Perspective(PerspectiveSpec),
    /// Parallel rays.
    Orthographic(OrthographicSpec),
    /// A circle in which the distance from the middle tells the angle from the view.
    Fisheye(FisheyeSpec),
    /// All around and from pole to pole.
    Panorama(PanoramaSpec),
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
    /// What is up in the picture, of length 1, not along the view; when left out z, or y where the
    /// view is along z.
    #[serde(default, deserialize_with = "direction_if")]
    pub up: Option<DVec3>,
}

/// Describes a camera of parallel rays; exactly one of `height` and `width` is given.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct OrthographicSpec {
    /// The middle of the film, metres; what is behind the film is not seen.
    #[serde(deserialize_with = "point")]
    pub from: DVec3,
    /// A point in the middle of the picture, metres; not `from`.
    #[serde(deserialize_with = "point")]
    pub to: DVec3,
    /// The height of the film, metres. Exactly one of this and `width` is given.
    #[serde(default, deserialize_with = "number_if::<Size, _>")]
    pub height: Option<f64>,
    /// The width of the film, metres.
    #[serde(default, deserialize_with = "number_if::<Size, _>")]
    pub width: Option<f64>,
    /// Columns and rows of pixels.
    #[serde(deserialize_with = "columns_rows")]
    pub resolution: [u32; 2],
    /// What is up in the picture; z when left out, or y where the view is along z.
    #[serde(default, deserialize_with = "direction_if")]
    pub up: Option<DVec3>,
}

impl OrthographicSpec {
    /// Returns the height of the film, metres; pixels are square.
    pub fn film_height(&self) -> f64 {
        let [columns, rows] = self.resolution.map(f64::from);
        let of_width = self.width.map(|width| width * rows / columns);
        self.height.or(of_width).unwrap_or_default()
    }
}

/// Describes a fisheye camera.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FisheyeSpec {
    /// The eye, metres.
    #[serde(deserialize_with = "point")]
    pub from: DVec3,
    /// The point in the middle of the picture, metres; not the eye.
    #[serde(deserialize_with = "point")]
    pub to: DVec3,
    /// The whole opening, degrees, above 0 and at most 360 (orthographic 180, stereographic less
    /// than 360).
    #[serde(default = "half_of_all", deserialize_with = "number::<Turn, _>")]
    pub fov: f64,
    /// How angles become distances.
    #[serde(default, deserialize_with = "choice")]
    pub mapping: FisheyeMapping,
    /// Columns and rows of pixels; the circle has the smaller of them for its diameter.
    #[serde(deserialize_with = "columns_rows")]
    pub resolution: [u32; 2],
    /// What is up in the picture; z when left out, or y where the view is along z.
    #[serde(default, deserialize_with = "direction_if")]
    pub up: Option<DVec3>,
}

/// Describes a panorama.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PanoramaSpec {
    /// The eye, metres.
    #[serde(deserialize_with = "point")]
    pub from: DVec3,
    /// A point above, in or below the middle of the picture, metres; when left out it is in the
    /// direction of x, or of y if that is up.
    #[serde(default, deserialize_with = "point_if")]
    pub to: Option<DVec3>,
    /// Columns and rows of pixels.
    #[serde(deserialize_with = "columns_rows")]
    pub resolution: [u32; 2],
    /// The direction of the upper pole, of length 1; when left out z.
    #[serde(default, deserialize_with = "direction_if")]
    pub up: Option<DVec3>,
}

impl PanoramaSpec {
    /// Returns the upper pole.
    pub fn pole(&self) -> DVec3 {
        self.up.unwrap_or(DVec3::Z)
    }

    /// Returns a point above, in or below the middle of the picture.
    pub fn towards(&self) -> DVec3 {
        let along = if self.pole().x.abs() > 0.9 { DVec3::Y } else { DVec3::X };
        self.to.unwrap_or(self.from + along)
    }
}

fn half_of_all() -> f64 {
    180.0
}

impl CameraSpec {
    /// Returns the eye, metres; with parallel rays the middle of the film.
    pub const fn from(&self) -> DVec3 {
        match self {
            Self::Perspective(spec) => spec.from,
            Self::Orthographic(spec) => spec.from,
            Self::Fisheye(spec) => spec.from,
            Self::Panorama(spec) => spec.from,
        }
    }

    /// Returns the number of columns and rows.
    pub const fn resolution(&self) -> [u32; 2] {
        match self {
            Self::Perspective(spec) => spec.resolution,
            Self::Orthographic(spec) => spec.resolution,
            Self::Fisheye(spec) => spec.resolution,
            Self::Panorama(spec) => spec.resolution,
        }
    }

    /// Returns the name of its type in a scene file.
    pub const fn type_name(&self) -> &'static str {
        match self {
            Self::Perspective(_) => "perspective",
            Self::Orthographic(_) => "orthographic",
            Self::Fisheye(_) => "fisheye",
            Self::Panorama(_) => "panorama",
        }
    }

    pub(super) fn check(&self, entry: &Entry) -> Result<()> {
        match self {
            Self::Perspective(spec) => check_view(spec.from, spec.to, spec.up, entry),
            Self::Orthographic(spec) => {
                check_film(spec, entry)?;
                check_view(spec.from, spec.to, spec.up, entry)
            }
            Self::Fisheye(spec) => {
                check_opening(spec, entry)?;
                check_view(spec.from, spec.to, spec.up, entry)
            }
            Self::Panorama(spec) => {
                check_view(spec.from, spec.towards(), spec.up, entry)?;
                check_pole(spec, entry)
            }
        }
    }
}

/// The smallest sine between `up` and the view from which a picture's axes are still good to eight
/// digits.
const SMALLEST_SINE: f64 = 1e-8;

fn check_view(from: DVec3, to: DVec3, up: Option<DVec3>, entry: &Entry) -> Result<()> {
    let Some(view) = (to - from).try_normalize() else {
        let message = format!("`to` and `from` in {} are the same point", entry.header());
        return Err(entry.error("to", message, "write in `to` a point to look at"));
    };
    let along = |up: DVec3| up.cross(view).length() < SMALLEST_SINE;
    if up.is_some_and(along) {
        let message = format!("`up` in {} is along the view", entry.header());
        return Err(entry.error("up", message, "write another direction, or leave `up` out"));
    }
    Ok(())
}

fn check_film(spec: &OrthographicSpec, entry: &Entry) -> Result<()> {
    let header = entry.header();
    match (spec.height, spec.width) {
        (Some(_), Some(_)) => {
            let message = format!("{header} has both `height` and `width`");
            Err(entry.error("width", message, "keep one; the other follows from `resolution`"))
        }
        (None, None) => {
            let message = format!("{header} has neither `height` nor `width`");
            Err(entry.error("", message, "add `height = 4`, the height of the picture in metres"))
        }
        _ => Ok(()),
    }
}

fn check_opening(spec: &FisheyeSpec, entry: &Entry) -> Result<()> {
    if spec.mapping.opens(spec.fov.to_radians()) {
        return Ok(());
    }
    let limit = match spec.mapping {
        FisheyeMapping::Orthographic => "at most 180",
        FisheyeMapping::Stereographic => "less than 360",
        _ => "at most 360",
    };
    let message = format!(
        "`fov` in {} must be {limit} degrees with the mapping {}, found {}",
        entry.header(),
        spec.mapping.name(),
        spec.fov
    );
    Err(entry.error("fov", message, "write a smaller one, or `mapping = \"equidistant\"`"))
}

/// Rejects a view that a panorama has nowhere in its middle.
fn check_pole(spec: &PanoramaSpec, entry: &Entry) -> Result<()> {
    let view = (spec.towards() - spec.from).normalize_or_zero();
    if spec.pole().cross(view).length() >= SMALLEST_SINE {
        return Ok(());
    }
    let message =
        format!("`to` in {} is straight above or below `from`: at a pole", entry.header());
    let help = "write a point beside it: a panorama's middle is level; or another `up`";
    Err(entry.error("to", message, help))
}
