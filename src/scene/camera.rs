//! Cameras: from a position on the film to a ray.

use glam::{DVec2, DVec3};

use crate::math::Ray;
use crate::{Error, Result};

/// Projects through a point; straight lines stay straight.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Perspective {
    from: DVec3,
    forward: DVec3,
    /// To the right and downwards on the image plane at distance 1, half the image high.
    right: DVec3,
    down: DVec3,
    resolution: [u32; 2],
}

impl Perspective {
    /// Places a camera at `from`, looking to `to`, with the vertical opening angle `fov` (radians, between 0 and pi) and width x height pixels.
    /// Up is z, or y where the view is along z; see [`Perspective::with_up`].
    ///
    /// # Errors
    /// [`Error::Parameter`] when `from` and `to` coincide, the angle is out of range or a side has no pixel.
    pub fn new(from: DVec3, to: DVec3, fov: f64, resolution: [u32; 2]) -> Result<Self> {
        let Some(forward) = (to - from).try_normalize() else {
            return Err(Error::Parameter(
                "a camera must look from one point to another, found the same twice".into(),
            ));
        };
        if !(fov > 0.0 && fov < std::f64::consts::PI) {
            return Err(Error::Parameter(format!(
                "the opening angle must be between 0 and 180 degrees, found {}",
                fov.to_degrees()
            )));
        }
        if resolution.contains(&0) {
            return Err(Error::Parameter("an image needs at least one pixel each way".into()));
        }
        let up = if forward.z.abs() > 1.0 - 1e-12 { DVec3::Y } else { DVec3::Z };
        let right = DVec3::X * (0.5 * fov).tan();
        Self { from, forward, right, down: DVec3::ZERO, resolution }.with_up(up)
    }

    /// Turns the camera about its view so that `up` points upwards in the image.
    ///
    /// # Errors
    /// [`Error::Parameter`] when `up` is along the view or not finite.
    pub fn with_up(mut self, up: DVec3) -> Result<Self> {
        let half = self.right.length();
        let Some(right) = self.forward.cross(up).try_normalize() else {
            return Err(Error::Parameter(format!("{up} cannot be up: it is along the view")));
        };
        self.right = half * right;
        self.down = half * self.forward.cross(right);
        Ok(self)
    }

    /// Gives width and height in pixels.
    pub const fn resolution(&self) -> [u32; 2] {
        self.resolution
    }

    /// Gives the same view with another number of pixels.
    pub const fn with_resolution(mut self, resolution: [u32; 2]) -> Self {
        self.resolution = resolution;
        self
    }

    /// Gives the eye point.
    pub const fn position(&self) -> DVec3 {
        self.from
    }

    /// Gives the side of a pixel on the image plane at distance 1: the tangent of the angle a pixel in the middle of the image is seen under.
    pub fn pixel(&self) -> f64 {
        2.0 * self.down.length() / f64::from(self.resolution[1])
    }

    /// Gives the cosine of the angle between the view and the corners of the image.
    pub fn corner_cosine(&self) -> f64 {
        let [width, height] = self.resolution.map(f64::from);
        let corner = self.right * (width / height) + self.down;
        1.0 / (1.0 + corner.length_squared()).sqrt()
    }

    /// Makes the ray through a film position in pixels: (0, 0) is the top left corner of the image, (0.5, 0.5) the middle of its first pixel.
    pub fn ray(&self, film: DVec2) -> Ray {
        let [width, height] = self.resolution.map(f64::from);
        let x = (2.0 * film.x - width) / height;
        let y = (2.0 * film.y - height) / height;
        let direction = self.forward + x * self.right + y * self.down;
        Ray::new(self.from, direction.normalize())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn impossible_cameras_are_refused() {
        let at = |to, fov: f64, resolution| Perspective::new(DVec3::ZERO, to, fov, resolution);
        assert!(at(DVec3::ZERO, 1.0, [4, 4]).is_err());
        assert!(at(DVec3::X, 0.0, [4, 4]).is_err());
        assert!(at(DVec3::X, 4.0, [4, 4]).is_err());
        assert!(at(DVec3::X, 1.0, [4, 0]).is_err());
    }

    #[test]
    fn film_positions_map_to_the_field_of_view() {
        let fov = 90.0_f64.to_radians();
        let camera = Perspective::new(DVec3::ZERO, DVec3::Y, fov, [200, 100]).expect("valid");
        assert!((camera.ray(DVec2::new(100.0, 50.0)).direction - DVec3::Y).length() <= 1e-15);
        let top = camera.ray(DVec2::new(100.0, 0.0)).direction;
        assert!((top - DVec3::new(0.0, 1.0, 1.0).normalize()).length() <= 1e-15);
        let right = camera.ray(DVec2::new(200.0, 50.0)).direction;
        assert!((right - DVec3::new(2.0, 1.0, 0.0).normalize()).length() <= 1e-15);
        // 100 pixels are the height 2 at distance 1.
        assert!((camera.pixel() - 0.02).abs() <= 1e-16);
        let corner = camera.ray(DVec2::ZERO).direction.dot(DVec3::Y);
        assert!((camera.corner_cosine() - corner).abs() <= 1e-15);
    }

    #[test]
    fn looking_down_takes_y_as_up() {
        let camera = Perspective::new(DVec3::Z, DVec3::ZERO, 1.0, [10, 10]).expect("valid");
        assert!(camera.ray(DVec2::new(5.0, 0.0)).direction.y > 0.0);
        assert!(camera.ray(DVec2::new(10.0, 5.0)).direction.x > 0.0);
    }
}
