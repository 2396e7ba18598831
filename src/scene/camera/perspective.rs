//! The pinhole: straight lines stay straight.

use glam::{DVec2, DVec3};

use crate::{Error, Result};

/// Holds half the height of the film at distance 1 from the eye.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Perspective {
    half: f64,
}

impl Perspective {
    /// Opens by the vertical angle `fov`, radians.
    pub(super) fn new(fov: f64) -> Result<Self> {
        if fov > 0.0 && fov < std::f64::consts::PI {
            return Ok(Self { half: (0.5 * fov).tan() });
        }
        Err(Error::Parameter(format!(
            "the opening angle must be between 0 and 180 degrees, found {}",
            fov.to_degrees()
        )))
    }

    /// Returns the side of a pixel on the film at distance 1: the tangent of the angle a pixel in
    /// the middle of the picture is seen under.
    fn pixel(self, size: DVec2) -> f64 {
        2.0 * self.half / size.y
    }

    /// Returns the cosine of the angle between the view and the corners of the picture.
    fn corner_cosine(self, size: DVec2) -> f64 {
        let corner = self.half * DVec2::new(size.x / size.y, 1.0);
        1.0 / (1.0 + corner.length_squared()).sqrt()
    }

    pub(super) fn direction(self, film: DVec2, size: DVec2) -> DVec3 {
        let at = (2.0 * film - size) / size.y * self.half;
        at.extend(1.0).normalize()
    }

    /// Returns where a direction meets the film, and there the pixels^2 per steradian: those of the
    /// middle over the cube of the cosine.
    pub(super) fn film(self, direction: DVec3, size: DVec2) -> Option<(DVec2, f64)> {
        let cosine = direction.z;
        let pixel = self.pixel(size);
        let film = 0.5 * size + direction.truncate() / (cosine * pixel);
        (cosine > 0.0).then(|| (film, (pixel * pixel * cosine.powi(3)).recip()))
    }

    /// Bounds the movement in the picture, pixels, of what moves by `error` at a distance of at
    /// least `distance`.
    ///
    /// A point at distance r moves on the film (at distance 1) from X / z to (X + a) / (z + b),
    /// |(a, b)| <= E. The difference (a z - X b) / (z (z + b)) is at most E (r / z) / (z - E). In
    /// the picture z >= r cos c, c the angle between the view and the corners, so that this is at
    /// most E / (cos c (d cos c - E)).
    pub(super) fn movement(self, distance: f64, error: f64, size: DVec2) -> f64 {
        let cosine = self.corner_cosine(size);
        let depth = distance * cosine - error;
        if depth > 0.0 { error / (cosine * depth * self.pixel(size)) } else { f64::INFINITY }
    }
}
