//! Cameras: from a position on the film to a ray, and from a point of the room back to the film.
//!
//! Film positions are pixels of the whole picture: (0, 0) is its top left corner, (0.5, 0.5) the
//! middle of its first pixel. Each lens has a file of its own and knows its own axes only: to the
//! right, downwards, forward.

mod fisheye;
mod orthographic;
mod panorama;
mod perspective;
mod pose;
#[cfg(test)]
mod tests;
mod window;

use glam::{DVec2, DVec3};

use crate::math::Ray;
use crate::{Error, Result};

pub use fisheye::FisheyeMapping;
pub use window::Window;

use fisheye::Fisheye;
use orthographic::Orthographic;
use perspective::Perspective;
use pose::Pose;

/// Sees a room from a place: where it stands, how it is turned, its lens, the size of its picture,
/// and which window of that is asked for.
///
/// ```
/// use glam::{DVec2, DVec3};
/// use harmolux::scene::Camera;
///
/// let camera = Camera::perspective(DVec3::ZERO, DVec3::Y, 1.0, [640, 480])?;
/// let ray = camera.ray(DVec2::new(100.0, 50.0)).expect("a pinhole's film has rays everywhere");
/// let seen = camera.project(ray.at(3.0)).expect("it is before the camera");
/// assert!(seen.film.distance(DVec2::new(100.0, 50.0)) < 1e-9);
/// # Ok::<(), harmolux::Error>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Camera {
    pose: Pose,
    lens: Lens,
    resolution: [u32; 2],
    window: Window,
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum Lens {
    Perspective(Perspective),
    Orthographic(Orthographic),
    Fisheye(Fisheye),
    Panorama,
}

/// Says where and how a camera sees a point.
///
/// A surface there of area dA, seen under the angle theta from its normal, covers `density` cos
/// theta dA pixels^2 of the film. The value of a pixel with the filter h is the integral of h L
/// over the film; so luminance L leaving dA adds h(offset) L `density` cos theta dA.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Projection {
    /// Where it is on the film, pixels; it may be outside the picture.
    pub film: DVec2,
    /// The unit vector from the point to the eye: along which its light must leave.
    pub towards: DVec3,
    /// The distance along it to the eye (to the film of an orthographic camera), metres.
    pub distance: f64,
    /// The film area, pixels^2, of a square metre at right angles to `towards` at the point.
    pub density: f64,
}

impl Camera {
    fn new(pose: Pose, lens: Lens, resolution: [u32; 2]) -> Result<Self> {
        if resolution.contains(&0) {
            return Err(Error::Parameter("an image needs at least one pixel each way".into()));
        }
        Ok(Self { pose, lens, resolution, window: Window::whole(resolution) })
    }

    /// Places a pinhole at `from`, looking to `to`, with the vertical opening angle `fov` (radians,
    /// between 0 and pi) and columns x rows of pixels, which are square. Up is z, or y where the
    /// view is along z; see [`Camera::with_up`].
    ///
    /// # Errors
    /// [`Error::Parameter`] when `from` and `to` coincide, the angle is out of range or a side has
    /// no pixel.
    pub fn perspective(from: DVec3, to: DVec3, fov: f64, resolution: [u32; 2]) -> Result<Self> {
        let lens = Lens::Perspective(Perspective::new(fov)?);
        Self::new(Pose::looking(from, to)?, lens, resolution)
    }

    /// Places a film `height` metres high with its middle at `from` and at right angles to the view
    /// to `to`; all rays are parallel to the view.
    ///
    /// # Errors
    /// As [`Camera::perspective`], and when the height is not a positive length.
    pub fn orthographic(from: DVec3, to: DVec3, height: f64, resolution: [u32; 2]) -> Result<Self> {
        let lens = Lens::Orthographic(Orthographic::new(height)?);
        Self::new(Pose::looking(from, to)?, lens, resolution)
    }

    /// Places a fisheye at `from`, looking to `to`, which opens by the whole angle `fov`, radians:
    /// pi for half of all directions. The picture is the largest circle that fits; outside it there
    /// are no rays.
    ///
    /// # Errors
    /// As [`Camera::perspective`], and when the mapping cannot open so wide.
    pub fn fisheye(
        from: DVec3,
        to: DVec3,
        mapping: FisheyeMapping,
        fov: f64,
        resolution: [u32; 2],
    ) -> Result<Self> {
        let lens = Lens::Fisheye(Fisheye::new(mapping, fov)?);
        Self::new(Pose::looking(from, to)?, lens, resolution)
    }

    /// Places a panorama at `from`: 360 degrees by 180, `up` being the upper pole and `to` above,
    /// in or below the middle. Pixels are square in the middle when there are twice as many columns
    /// as rows.
    ///
    /// # Errors
    /// [`Error::Parameter`] when `from` and `to` coincide or `to` is at a pole, or a side has no
    /// pixel.
    pub fn panorama(from: DVec3, to: DVec3, up: DVec3, resolution: [u32; 2]) -> Result<Self> {
        let pose = Pose::looking(from, to)?.upright(up)?;
        Self::new(pose, Lens::Panorama, resolution)
    }

    /// Turns the camera so that `up` points upwards in the picture; of a panorama `up` is the upper
    /// pole.
    ///
    /// # Errors
    /// [`Error::Parameter`] when `up` is along the view or not finite.
    pub fn with_up(mut self, up: DVec3) -> Result<Self> {
        self.pose = match self.lens {
            Lens::Panorama => self.pose.upright(up)?,
            _ => self.pose.with_up(up)?,
        };
        Ok(self)
    }

    /// Returns the number of columns and rows of the whole picture.
    pub const fn resolution(&self) -> [u32; 2] {
        self.resolution
    }

    /// Returns the same view with another number of pixels, the whole of it.
    #[must_use]
    pub const fn with_resolution(mut self, resolution: [u32; 2]) -> Self {
        self.resolution = resolution;
        self.window = Window::whole(resolution);
        self
    }

    /// Returns the part of the picture that is asked for.
    pub const fn window(&self) -> Window {
        self.window
    }

    /// Asks for a part of the picture.
    ///
    /// # Errors
    /// [`Error::Parameter`] when it reaches beyond the picture.
    pub fn with_window(mut self, window: Window) -> Result<Self> {
        if !window.is_within(self.resolution) {
            let ([x0, y0], [x1, y1]) = (window.min(), window.max());
            let [width, height] = self.resolution;
            return Err(Error::Parameter(format!(
                "the crop {x0},{y0},{x1},{y1} reaches beyond the picture of {width} x {height} \
                 pixels"
            )));
        }
        self.window = window;
        Ok(self)
    }

    /// Returns the eye; of an orthographic camera the middle of its film.
    pub const fn position(&self) -> DVec3 {
        self.pose.eye
    }

    /// Returns the unit vector in the middle of the picture.
    pub const fn forward(&self) -> DVec3 {
        self.pose.forward
    }

    /// Names the lens, as scene files do.
    pub const fn kind(&self) -> &'static str {
        match self.lens {
            Lens::Perspective(_) => "perspective",
            Lens::Orthographic(_) => "orthographic",
            Lens::Fisheye(_) => "fisheye",
            Lens::Panorama => "panorama",
        }
    }

    /// Returns the matrix, row by row, that turns a point (x, y, z, 1), written as a row before it,
    /// into the camera's coordinates: x to the right, y upwards, z backwards in the picture,
    /// metres. This is how OpenEXR writes its `worldToCamera`.
    pub fn world_to_camera(&self) -> [[f64; 4]; 4] {
        let Pose { eye, right, down, forward, .. } = self.pose;
        let (up, back) = (-down, -forward);
        let row = |k: usize| [right[k], up[k], back[k], 0.0];
        [row(0), row(1), row(2), [-eye.dot(right), -eye.dot(up), -eye.dot(back), 1.0]]
    }

    /// Makes the ray through a film position; `None` where nothing is seen (outside the circle of a
    /// fisheye).
    pub fn ray(&self, film: DVec2) -> Option<Ray> {
        let (size, pose) = (self.size(), &self.pose);
        let direction = match self.lens {
            Lens::Orthographic(lens) => {
                let origin = pose.eye + pose.turn(lens.origin(film, size));
                return Some(Ray::new(origin, pose.forward));
            }
            Lens::Perspective(lens) => lens.direction(film, size),
            Lens::Fisheye(lens) => lens.direction(film, size)?,
            Lens::Panorama => panorama::direction(film, size),
        };
        Some(Ray::new(pose.eye, pose.turn(direction).normalize()))
    }

    /// Finds a point of the room on the film, whatever stands before it; `None` when it is behind
    /// the camera or outside the circle of a fisheye.
    pub fn project(&self, point: DVec3) -> Option<Projection> {
        let (size, local) = (self.size(), self.pose.local(point));
        if let Lens::Orthographic(lens) = self.lens {
            return Some(Projection {
                film: lens.film(local, size)?,
                towards: -self.pose.forward,
                distance: local.z,
                density: lens.scale(size).powi(2),
            });
        }
        let direction = local.try_normalize()?;
        let (film, per_steradian) = match self.lens {
            Lens::Perspective(lens) => lens.film(direction, size)?,
            Lens::Fisheye(lens) => lens.film(direction, size)?,
            Lens::Panorama | Lens::Orthographic(_) => panorama::film(direction, size)?,
        };
        let distance = local.length();
        let towards = (self.pose.eye - point) / distance;
        Some(Projection { film, towards, distance, density: per_steradian / distance.powi(2) })
    }

    /// Returns all film positions at most `margin` pixels outside the picture that show the same as
    /// `film`: itself, and where a panorama goes on beyond its borders. A splat with a filter of
    /// that radius belongs at each.
    pub fn repeats(&self, film: DVec2, margin: f64) -> impl Iterator<Item = DVec2> {
        let is_panorama = self.lens == Lens::Panorama;
        let own = (!is_panorama).then_some(film);
        let around = is_panorama.then(|| panorama::repeats(film, margin, self.size()));
        own.into_iter().chain(around.into_iter().flatten())
    }

    /// Returns the distance of a point from the eye; for an orthographic camera from the plane of
    /// its film.
    pub fn distance(&self, point: DVec3) -> f64 {
        match self.lens {
            Lens::Orthographic(_) => self.pose.local(point).z.abs(),
            _ => point.distance(self.pose.eye),
        }
    }

    /// Bounds the distance in the picture, pixels, by which a visible point of a ball is seen to
    /// move when it moves by `error`, metres; infinite when nothing bounds it: near the eye, where
    /// a panorama has its poles, and where an extreme fisheye looks behind itself.
    pub fn movement(&self, centre: DVec3, radius: f64, error: f64) -> f64 {
        if error <= 0.0 {
            return 0.0;
        }
        let size = self.size();
        let middle = self.distance(centre);
        let distance = middle - radius;
        if distance.is_nan() || distance <= error {
            return f64::INFINITY;
        }
        let (turn, half) = ((error / distance).asin(), (radius / middle).asin());
        let local = self.pose.local(centre);
        match self.lens {
            Lens::Perspective(lens) => lens.movement(distance, error, size),
            Lens::Orthographic(lens) => lens.scale(size) * error,
            Lens::Fisheye(lens) => {
                lens.movement(local.truncate().length().atan2(local.z) + half, turn, size)
            }
            Lens::Panorama => {
                let angle = local.x.hypot(local.z).atan2(-local.y);
                panorama::movement([angle - half, angle + half], turn, size)
            }
        }
    }

    fn size(&self) -> DVec2 {
        DVec2::from_array(self.resolution.map(f64::from))
    }
}
