//! The fisheye: a circle in the middle of the picture, as large as fits, in which the distance from
//! the middle tells the angle from the view.

use crate::math::choice::choice;
use std::f64::consts::PI;

use glam::{DVec2, DVec3};

use crate::{Error, Result};

/// Says how the angle from the view becomes a distance from the middle of a fisheye picture.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum FisheyeMapping {
    /// The angle itself: equal steps of angle are equal steps on the film.
    #[default]
    Equidistant,
    /// The sine of half the angle: equal solid angles have equal areas.
    Equisolid,
    /// The sine: equal areas are equal parts of the illuminance at the eye (the hemispherical
    /// view); opens by 180 degrees at most.
    Orthographic,
    /// The tangent of half the angle: small shapes keep their form; opens by less than 360 degrees.
    Stereographic,
}

choice!(FisheyeMapping, "mapping":
    Equidistant = "equidistant" "",
    Equisolid = "equisolid" "",
    Orthographic = "orthographic" "",
    Stereographic = "stereographic" "",
);

impl FisheyeMapping {
    /// Whether a picture can open by the whole angle `fov`, radians.
    pub fn opens(self, fov: f64) -> bool {
        fov > 0.0
            && match self {
                Self::Equidistant | Self::Equisolid => fov <= 2.0 * PI,
                Self::Orthographic => fov <= PI,
                Self::Stereographic => fov < 2.0 * PI,
            }
    }

    /// Returns the distance from the middle for an angle, in a unit of the mapping's own.
    fn distance(self, angle: f64) -> f64 {
        match self {
            Self::Equidistant => angle,
            Self::Equisolid => (0.5 * angle).sin(),
            Self::Orthographic => angle.sin(),
            Self::Stereographic => (0.5 * angle).tan(),
        }
    }

    /// Returns the derivative of [`FisheyeMapping::distance`].
    fn slope(self, angle: f64) -> f64 {
        match self {
            Self::Equidistant => 1.0,
            Self::Equisolid => 0.5 * (0.5 * angle).cos(),
            Self::Orthographic => angle.cos(),
            Self::Stereographic => 0.5 / (0.5 * angle).cos().powi(2),
        }
    }

    fn angle(self, distance: f64) -> f64 {
        match self {
            Self::Equidistant => distance,
            Self::Equisolid => 2.0 * distance.min(1.0).asin(),
            Self::Orthographic => distance.min(1.0).asin(),
            Self::Stereographic => 2.0 * distance.atan(),
        }
    }

    /// Returns the largest of distance / sine and of the slope over all angles up to `angle`.
    fn stretch(self, angle: f64) -> f64 {
        if self == Self::Orthographic {
            return 1.0;
        }
        if angle >= PI {
            return f64::INFINITY;
        }
        match self {
            Self::Equidistant => (angle / angle.sin()).max(1.0),
            Self::Equisolid => 0.5 / (0.5 * angle).cos(),
            _ => self.slope(angle),
        }
    }
}

/// Holds the mapping and the angle between the view and the rim, radians.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Fisheye {
    mapping: FisheyeMapping,
    rim: f64,
}

impl Fisheye {
    pub(super) fn new(mapping: FisheyeMapping, fov: f64) -> Result<Self> {
        if mapping.opens(fov) {
            return Ok(Self { mapping, rim: 0.5 * fov });
        }
        Err(Error::Parameter(format!(
            "an {} fisheye cannot open by {} degrees: {}",
            mapping.name(),
            fov.to_degrees(),
            match mapping {
                FisheyeMapping::Orthographic => "it takes above 0 and at most 180",
                FisheyeMapping::Stereographic => "it takes above 0 and less than 360",
                _ => "it takes above 0 and at most 360",
            }
        )))
    }

    /// Returns the pixels per unit of the mapping's distance.
    fn scale(self, size: DVec2) -> f64 {
        0.5 * size.min_element() / self.mapping.distance(self.rim)
    }

    /// Returns the direction of a film position; `None` outside the circle.
    pub(super) fn direction(self, film: DVec2, size: DVec2) -> Option<DVec3> {
        let from_middle = film - 0.5 * size;
        let r = from_middle.length();
        if r > 0.5 * size.min_element() {
            return None;
        }
        let (sine, cosine) = self.mapping.angle(r / self.scale(size)).sin_cos();
        Some((sine * from_middle.normalize_or_zero()).extend(cosine))
    }

    /// Returns where a direction meets the film, and there the pixels^2 per steradian; `None`
    /// outside the circle, and right behind the eye.
    pub(super) fn film(self, direction: DVec3, size: DVec2) -> Option<(DVec2, f64)> {
        let across = direction.truncate();
        let sine = across.length();
        let angle = sine.atan2(direction.z);
        if angle > self.rim || (sine == 0.0 && direction.z < 0.0) {
            return None;
        }
        let (scale, slope) = (self.scale(size), self.mapping.slope(angle));
        // Near the view the distance is proportional to the sine, without which nothing is left of
        // either.
        let radial = if sine > 0.0 { self.mapping.distance(angle) / sine } else { slope };
        Some((0.5 * size + scale * radial * across, scale * scale * radial * slope))
    }

    /// Bounds the movement in the picture, pixels, of what turns by `turn` within the angle `angle`
    /// from the view.
    pub(super) fn movement(self, angle: f64, turn: f64, size: DVec2) -> f64 {
        let reach = angle.min(self.rim) + turn;
        self.scale(size) * self.mapping.stretch(reach) * turn
    }
}
