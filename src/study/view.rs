//! What a camera has before it, looked at before a long run: a picture of nothing is no picture
//! that anyone meant.

use glam::{DVec2, DVec3};

use crate::Result;
use crate::io::scene_file::SceneFile;
use crate::scene::{Camera, Scene};

/// The rays each way that look first, and those that look again when the first meet nothing.
const COARSE: u32 = 48;
const FINE: u32 = 480;

/// The points of an object each way that are looked for in the picture when no ray meets anything:
/// it may be smaller than what lies between the rays.
const POINTS: u32 = 16;

/// Checks that a camera has anything at all before it, in the whole of its picture; where it sees
/// nothing its crop may still be meant.
///
/// # Errors
/// [`crate::Error::Input`] that points at the camera, and says where the objects are.
pub fn check_view(file: &SceneFile, scene: &Scene, camera: &Camera) -> Result<()> {
    if [COARSE, FINE].into_iter().any(|most| sees(scene, camera, most)) || shows(scene, camera) {
        return Ok(());
    }
    let (name, spec) = file.camera()?;
    let message =
        format!("camera `{name}` looks at nothing: no point of an object is in its picture");
    Err(file.source.error(
        &["cameras", name, spec.type_name()],
        message,
        Some(advice(scene, camera)),
    ))
}

/// Looks along rays spread over the picture, `most` each way or one a pixel.
fn sees(scene: &Scene, camera: &Camera, most: u32) -> bool {
    let [width, height] = camera.resolution();
    let [columns, rows] = [width.min(most), height.min(most)];
    let cell =
        DVec2::new(f64::from(width) / f64::from(columns), f64::from(height) / f64::from(rows));
    let mut places =
        (0..rows).flat_map(|y| (0..columns).map(move |x| DVec2::new(x.into(), y.into())));
    places.any(|at| camera.ray((at + 0.5) * cell).is_some_and(|ray| scene.hit(&ray).is_some()))
}

/// Whether a point of an object is in the picture: of its surface, spread evenly over what its area
/// is sampled by.
///
/// Nothing hides it there: what does would be larger than it, and met by a ray.
fn shows(scene: &Scene, camera: &Camera) -> bool {
    let is_shown = |point: DVec3| {
        camera.project(point).is_some_and(|seen| within(seen.film, camera.resolution()))
    };
    let shares = (0..POINTS * POINTS)
        .map(|k| (DVec2::new((k % POINTS).into(), (k / POINTS).into()) + 0.5) / f64::from(POINTS));
    scene
        .objects()
        .iter()
        .filter_map(|object| object.area.as_ref())
        .any(|surface| shares.clone().any(|share| is_shown(surface.sample_area(share).hit.point)))
}

/// Says where to look, or what else may be wrong.
fn advice(scene: &Scene, camera: &Camera) -> String {
    let bounds = scene.bounds();
    if scene.objects().is_empty() || !bounds.is_finite() {
        return "add objects, or write another `to`".to_owned();
    }
    let round = |v: f64| format!("{}", (1e3 * v).round() / 1e3);
    let point = |p: DVec3| format!("[{}]", p.to_array().map(round).join(", "));
    let middle = bounds.centre();
    match camera.project(middle) {
        Some(seen) if within(seen.film, camera.resolution()) => format!(
            "the middle of the objects, {}, is in the picture, but none of them: write another \
             `to`, or move `from`",
            point(middle)
        ),
        _ => format!(
            "the objects lie from {} to {}: write `to = {}`, the middle of them, or move `from`",
            point(bounds.min),
            point(bounds.max),
            point(middle)
        ),
    }
}

fn within(film: DVec2, resolution: [u32; 2]) -> bool {
    let size = DVec2::from_array(resolution.map(f64::from));
    film.cmpge(DVec2::ZERO).all() && film.cmple(size).all()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{FisheyeMapping, Material, Object};
    use crate::surface::primitives::{Rectangle, Sphere};

    fn ball(at: DVec3, radius: f64) -> Result<Object> {
        let material = Material::lambert(crate::math::Rgb::grey(0.5))?;
        Ok(Object::new("ball", Sphere::new(at, radius)?, material))
    }

    fn cameras(resolution: [u32; 2]) -> Result<[Camera; 4]> {
        let (from, to) = (DVec3::new(1.0, 2.0, 3.0), DVec3::new(1.0, 12.0, 3.0));
        Ok([
            Camera::perspective(from, to, 0.8, resolution)?,
            Camera::orthographic(from, to, 8.0, resolution)?,
            Camera::fisheye(from, to, FisheyeMapping::Equidistant, 3.0, resolution)?,
            Camera::panorama(from, to, DVec3::Z, resolution)?,
        ])
    }

    fn has_something(object: Object, camera: &Camera) -> Result<bool> {
        let scene = Scene::new(vec![object], Vec::new())?;
        Ok(sees(&scene, camera, COARSE) || sees(&scene, camera, FINE) || shows(&scene, camera))
    }

    #[test]
    fn what_is_smaller_than_a_pixel_is_something() -> Result<()> {
        // From a star between the middles of pixels to a ball of five pixels between the rays that
        // look.
        for (resolution, radius) in [([64, 48], 1e-4), ([64, 48], 1e-9), ([4000, 3000], 5e-3)] {
            for camera in cameras(resolution)? {
                let at = DVec3::new(1.03, 12.0, 3.07);
                assert!(has_something(ball(at, radius)?, &camera)?, "{resolution:?} {radius}");
            }
        }
        Ok(())
    }

    #[test]
    fn sliver_of_which_a_part_is_in_the_picture_is_something() -> Result<()> {
        let [camera, ..] = cameras([64, 48])?;
        // Between two rows of pixels, and far out of the picture on both sides.
        let corner = DVec3::new(-19.0, 12.0, 3.0);
        let thread = Rectangle::new(corner, 40.0 * DVec3::X, 1e-6 * DVec3::Z)?;
        let object =
            Object::new("thread", thread, Material::lambert(crate::math::Rgb::WHITE * 0.5)?);
        assert!(has_something(object, &camera)?);
        Ok(())
    }

    #[test]
    fn what_is_beside_or_behind_is_nothing() -> Result<()> {
        let [perspective, orthographic, fisheye, panorama] = cameras([64, 48])?;
        let (beside, behind) = (DVec3::new(9.0, 12.0, 3.0), DVec3::new(1.0, -8.0, 3.0));
        for radius in [1e-4, 0.5] {
            for camera in [perspective, orthographic] {
                assert!(!has_something(ball(beside, radius)?, &camera)?, "{radius}");
            }
            for camera in [perspective, orthographic, fisheye] {
                assert!(!has_something(ball(behind, radius)?, &camera)?, "{radius}");
            }
            assert!(has_something(ball(behind, radius)?, &panorama)?, "{radius}");
        }
        Ok(())
    }
}
