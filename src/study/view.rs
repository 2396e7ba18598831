//! What a camera has before it, looked at before a long run: a picture of nothing is no picture that anyone meant.

use glam::{DVec2, DVec3};

use crate::Result;
use crate::io::scene_file::SceneFile;
use crate::scene::{Camera, Scene};

/// The rays each way that look first, and those that look again when the first meet nothing.
const COARSE: u32 = 48;
const FINE: u32 = 480;

/// Checks that a camera sees anything at all, in the whole of its picture; where it sees nothing its crop may still be meant.
///
/// # Errors
/// [`crate::Error::Input`] that points at the camera, and says where the objects are.
pub fn check_view(file: &SceneFile, scene: &Scene, camera: &Camera) -> Result<()> {
    if [COARSE, FINE].into_iter().any(|most| sees(scene, camera, most)) {
        return Ok(());
    }
    let (name, spec) = file.camera()?;
    let message =
        format!("camera `{name}` looks at nothing: no ray of its picture meets an object");
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
            "it looks towards them, at {}: they may be smaller than a pixel, or the eye may be past them; move `from`",
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
