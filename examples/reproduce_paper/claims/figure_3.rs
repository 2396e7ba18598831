//! Figure 3: the room with the head, by the double local estimate, held to path tracing.

use harmolux::Result;
use harmolux::estimators::{Estimator, ImageSettings, Rendering, Stop, Weighting, render};
use harmolux::io::images;
use harmolux::io::scene_file::SceneFile;
use harmolux::math::Randomness;
use harmolux::scene::{Camera, Display, Film, Filter, Scene};
use harmolux::study::{camera, load};

use super::{Claim, Run, Verdict, data, digits, go_on, percent};
use crate::figures::Picture;

/// The room of the paper.
pub(super) const SCENE: &str = "scenes/paper_figure_3.toml";
/// Beyond how many standard errors two means differ: once in a thousand by chance.
const FAR: f64 = 3.6;

pub(super) fn claims(run: &Run) -> Result<Vec<Claim>> {
    let file = SceneFile::read(&data(SCENE), &[])?;
    let size = run.choose([240, 180], [480, 360]);
    let (scene, camera) = (load(&file)?.scene, camera(&file)?.with_resolution(size));
    let error = run.choose(0.08, 0.03);
    let stop = Stop { relative_error: Some(error), ..Stop::default() };
    let local = Estimator::Local(Weighting::of(&scene));
    let rendering = shot(&scene, &camera, local, stop)?;
    let small = camera.with_resolution([80, 60]);
    let walks = run.choose(1 << 10, 1 << 13);
    let stop = |walks| Stop { walks: Some(walks), ..Stop::default() };
    let own = shot(&scene, &small, local, stop(walks))?.film;
    let path = shot(&scene, &small, Estimator::Path, stop(walks))?.film;
    let z = difference(&own, &path);
    let film = &rendering.film;
    let [width, height] = film.size();
    let median = film.median_relative_error().unwrap_or(f64::NAN);
    Ok(vec![Claim {
        title: "Figure 3: a room with a head of harmonics",
        paper_words: "Figure 3 shows the simplest room with one isotropic light source and a human \
                      head, given by spherical harmonics.",
        place: "Implementation, Figure 3",
        paper_number: "a picture".to_owned(),
        ours: format!("{width} x {height} pixels, {} walks a pixel", rendering.walks_per_pixel),
        error: format!(
            "median standard error {} of a pixel; mean luminance {} standard errors from path \
             tracing",
            percent(median, 2),
            digits(z, 2)
        ),
        command: format!("harmolux render data/{SCENE} -o figure_3.png"),
        verdict: Verdict::of(z <= FAR),
        notes: vec![format!(
            "Room, head and lamp are ours: the paper gives no measures. 95 % of the pixels have a \
             standard error within {} of their value. Confirmed where the mean of the picture \
             ({} x {} pixels) and that of path tracing are within {FAR} standard errors.",
            percent(error, 1),
            own.size()[0],
            own.size()[1]
        )],
        table: None,
        picture: Some(Picture {
            name: "figure_3.png",
            caption: "Figure 3 again: a head of degree 32 in a lit room".to_owned(),
            bytes: images::png(width, height, &film.image(), Display::default(), None)?.bytes,
        }),
    }])
}

fn shot(scene: &Scene, camera: &Camera, estimator: Estimator, stop: Stop) -> Result<Rendering> {
    let (randomness, filter) = (Randomness::Sobol, Filter::Box);
    let settings = ImageSettings { estimator, randomness, seed: 1, stop, filter };
    render(scene, camera, &settings, &go_on)
}

fn difference(a: &Film, b: &Film) -> f64 {
    let ((a, a_error), (b, b_error)) = (a.mean(), b.mean());
    (a - b).abs() / a_error.hypot(b_error)
}
