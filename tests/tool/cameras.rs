//! Cameras, crops, filters and layers: in closed rooms of known luminance, and as a user of
//! `render` meets them.

use std::f64::consts::PI;
use std::fs;
use std::path::Path;
use std::process::{Command, Output};

use crate::common::{furnace, go_on, grey, image, room, sensors};
use glam::DVec3;
use harmolux::Result;
use harmolux::estimators::{Estimator, ImageSettings, Weighting, illuminance, render};
use harmolux::io::images::{Attribute, Exr};
use harmolux::math::Rgb;
use harmolux::scene::{
    Camera, Distribution, Filter, FisheyeMapping, Material, Measured, Object, PointLight, Scene,
    Sensor, Window,
};
use harmolux::surface::primitives::{AxisBox, Sphere};

const EYE: DVec3 = DVec3::new(0.7, 0.6, 1.7);
const TO: DVec3 = DVec3::new(2.2, 2.9, 1.1);

/// A closed room with a ball and a crate in which the luminance is `l0` everywhere.
fn furnace_room(l0: f64) -> Scene {
    let walls: [Material; 6] = std::array::from_fn(|i| furnace(0.2 + 0.1 * i as f64, l0));
    let ball = Sphere::new(DVec3::new(2.2, 2.9, 1.1), 0.6).expect("valid");
    let crate_ = AxisBox::new(DVec3::new(2.9, 0.5, 0.1), DVec3::new(3.6, 1.4, 0.9)).expect("valid");
    let objects = vec![
        room(DVec3::new(4.0, 5.0, 3.0), &walls),
        Object::new("ball", ball, furnace(0.5, l0)),
        Object::new("crate", crate_, furnace(0.3, l0)),
    ];
    Scene::new(objects, Vec::new()).expect("valid")
}

fn cameras() -> Vec<Camera> {
    let fisheye = |mapping, fov| Camera::fisheye(EYE, TO, mapping, fov, [20, 16]);
    let all = [
        Camera::perspective(EYE, TO, 1.0, [20, 16]),
        Camera::orthographic(EYE, TO, 0.9, [20, 16]),
        fisheye(FisheyeMapping::Equidistant, 2.0 * PI),
        fisheye(FisheyeMapping::Equisolid, PI),
        fisheye(FisheyeMapping::Orthographic, PI),
        fisheye(FisheyeMapping::Stereographic, 4.0),
        Camera::panorama(EYE, TO, DVec3::Z, [24, 12]),
    ];
    all.into_iter().collect::<Result<_>>().expect("valid")
}

fn settings(scene: &Scene, filter: Filter, walks: u64) -> ImageSettings {
    ImageSettings { filter, ..image(Estimator::Local(Weighting::of(scene)), walks) }
}

/// In a furnace every ray that there is brings the same; the mean over those pixels that are wholly
/// seen has an error of a per mille or two. Bounds of five standard errors: a false alarm once in 2
/// million, per camera.
#[test]
fn every_camera_and_filter_sees_a_furnace_evenly() {
    let l0 = 100.0;
    let scene = furnace_room(l0);
    for (i, camera) in cameras().iter().enumerate() {
        let filter = Filter::ALL[i % 3];
        let reach = filter.radius() + 0.5;
        let film =
            render(&scene, camera, &settings(&scene, filter, 64), &go_on).expect("renders").film;
        let (pixels, errors) = (film.image(), film.standard_errors());
        let [width, _] = film.size();
        let (mut sum, mut squares, mut count) = (0.0, 0.0, 0);
        for (k, (pixel, error)) in pixels.iter().zip(errors).enumerate() {
            let middle = glam::DVec2::new((k % width) as f64 + 0.5, (k / width) as f64 + 0.5);
            let corners = [-1.0, 1.0].map(|x| [-1.0, 1.0].map(|y| glam::DVec2::new(x, y) * reach));
            let is_whole = corners.iter().flatten().all(|c| camera.ray(middle + *c).is_some());
            if is_whole {
                (sum, squares, count) =
                    (sum + pixel.luminance(), squares + error * error, count + 1);
            }
        }
        assert!(count > 60, "{}: {count}", camera.kind());
        // Pixels share walks: the error of their mean is at most that of a pixel.
        let (mean, error) = (sum / f64::from(count), (squares / f64::from(count)).sqrt());
        assert!(
            (mean - l0).abs() <= 5.0 * error.min(0.01 * l0),
            "{}: {mean} {error}",
            camera.kind()
        );
    }
}

#[test]
fn crop_is_the_same_pixels_to_the_bit() {
    let scene = furnace_room(100.0);
    let window = Window::new([3, 5], [14, 11]).expect("valid");
    for camera in cameras() {
        let settings = settings(&scene, Filter::Gaussian, 24);
        let whole = render(&scene, &camera, &settings, &go_on).expect("renders").film;
        let part = camera.with_window(window).expect("within");
        let part = render(&scene, &part, &settings, &go_on).expect("renders").film;
        assert_eq!(part.size(), [11, 6]);
        let width = whole.size()[0];
        let (all, errors) = (whole.image(), whole.standard_errors());
        let (some, some_errors) = (part.image(), part.standard_errors());
        for (k, (pixel, error)) in some.iter().zip(some_errors).enumerate() {
            let at = (k / 11 + 5) * width + k % 11 + 3;
            assert_eq!((*pixel, error), (all[at], errors[at]), "{} {k}", camera.kind());
        }
    }
}

/// The orthographic fisheye is the hemisphere projected on the plane of a luxmeter: pi times the
/// mean luminance over its circle is the illuminance that surfaces give there. A false alarm (five
/// standard errors) once in 2 million.
#[test]
fn hemispherical_picture_adds_up_to_the_illuminance_at_the_eye() {
    let walls = [0.2, 0.3, 0.4, 0.5, 0.6, 0.7].map(grey);
    let objects = vec![room(DVec3::new(4.0, 5.0, 3.0), &walls)];
    let lamp = PointLight {
        name: "lamp".to_owned(),
        at: DVec3::new(1.0, 1.0, 2.5),
        intensity: Rgb::grey(100.0),
        distribution: Distribution::Isotropic,
    };
    let scene = Scene::new(objects, vec![lamp]).expect("valid");
    let sensor = Sensor::plane(EYE, (TO - EYE).normalize());
    let estimator = Estimator::Local(Weighting::of(&scene));
    let lit = illuminance(&scene, &[sensor], &sensors(estimator, 1 << 14), &go_on).expect("runs");
    let Measured { total, direct, .. } = lit.results[0];
    let mapping = FisheyeMapping::Orthographic;
    let camera = Camera::fisheye(EYE, TO, mapping, PI, [24, 24]).expect("valid");
    // With the box filter no sample counts for the outside of the square, of which the circle is pi
    // / 4.
    let film =
        render(&scene, &camera, &settings(&scene, Filter::Box, 128), &go_on).expect("renders").film;
    let (mean, error) = film.mean();
    let seen = 4.0 * mean;
    let tolerance = 5.0 * total.standard_error.hypot(4.0 * error);
    assert!((seen - (total.mean - direct.mean)).abs() <= tolerance, "{seen} {total:?} {direct:?}");
    assert!(tolerance <= 0.05 * seen, "{tolerance} {seen}");
}

const ROOM: &str = r#"format = 1
[materials.walls.lambert]
reflectance = [0.6, 0.5, 0.4]
[objects.room.box]
min = [0, 0, 0]
max = [4, 5, 3]
inward = true
material = "walls"
[objects.crate.box]
min = [1.5, 3, 0]
max = [2.5, 4, 1.2]
material = "walls"
[lights.lamp.point]
at = [1, 1, 2.5]
intensity = 100
[cameras.main.perspective]
from = [2, 0.25, 1.6]
to = [2, 3, 1.2]
fov = 60
resolution = [16, 12]
[cameras.plan.orthographic]
from = [2, 2.5, 2.9]
to = [2, 2.5, 0]
width = 3.9
resolution = [12, 15]
[cameras.glare.fisheye]
from = [2, 0.25, 1.6]
to = [2, 3, 1.2]
mapping = "equisolid"
resolution = [16, 16]
[cameras.around.panorama]
from = [2, 0.25, 1.6]
resolution = [32, 16]
[render]
seed = 1
camera = "main"
stop = { walks = 16 }
"#;

fn run(folder: &Path, arguments: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_harmolux"));
    command.current_dir(folder).args(arguments).output().expect("it runs")
}

fn folder() -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("a folder");
    fs::write(folder.path().join("room.toml"), ROOM).expect("written");
    folder
}

fn done(folder: &Path, arguments: &[&str]) {
    let output = run(folder, arguments);
    assert!(output.status.success(), "{arguments:?}: {}", String::from_utf8_lossy(&output.stderr));
}

#[test]
fn pictures_of_every_camera_have_layers_metadata_and_false_colours() {
    let folder = folder();
    let at = folder.path();
    for (name, kind) in [
        ("main", "perspective"),
        ("plan", "orthographic"),
        ("glare", "fisheye"),
        ("around", "panorama"),
    ] {
        let to = ["-o", "a.exr", "-o", "a.png", "--force"];
        done(at, &[&["render", "room.toml", "--camera", name], &to[..]].concat());
        let exr = Exr::read(&at.join("a.exr")).expect("an EXR");
        assert_eq!(exr.attribute("camera"), Some(&name.into()));
        assert_eq!(exr.attribute("cameraType"), Some(&kind.into()));
        assert_eq!(exr.attribute("objects"), Some(&r#"{"crate":1,"room":2}"#.into()));
        assert!(matches!(exr.attribute("worldToCamera"), Some(Attribute::Matrix(_))));
        let channel = |name: &str| exr.channel(name).expect("a channel");
        let [id, depth, luminance] = ["id.Y", "depth.Z", "luminance.Y"].map(channel);
        assert!(id.contains(&1.0) && id.contains(&2.0), "{name}");
        for ((id, depth), luminance) in id.iter().zip(depth).zip(luminance) {
            // Outside the circle of a fisheye there is nothing; on its rim the few samples of a
            // pixel may all miss.
            assert_eq!(*id == 0.0, depth.is_infinite());
            assert!(*id == 0.0 || *depth < 7.1, "{depth}");
            assert!(*luminance > 0.0 || name == "glare", "{name}: {id} {depth}");
        }
        assert_eq!(id.contains(&0.0), name == "glare");
        let [x, y, z] = ["normal.X", "normal.Y", "normal.Z"].map(channel);
        let lengths = x.iter().zip(y).zip(z).map(|((x, y), z)| (x * x + y * y + z * z).sqrt());
        assert!(lengths.fold(0.0_f32, f32::max) <= 1.0 + 1e-6);
        done(at, &["falsecolor", "a.exr", "-o", "b.png", "--force"]);
        done(at, &["falsecolor", "a.exr", "-o", "c.png", "--force", "--channel", "id.Y"]);
    }
    assert!(fs::metadata(at.join("b.png")).is_ok_and(|file| file.len() > 1000));
}

#[test]
fn crops_and_chosen_layers_reach_the_files() {
    let folder = folder();
    let at = folder.path();
    done(at, &["render", "room.toml", "-o", "whole.exr"]);
    let crop = ["render", "room.toml", "--crop", "4,2,14,9", "--layers", "depth", "-o", "part.exr"];
    done(at, &crop);
    let read = |name: &str| Exr::read(&at.join(name)).expect("an EXR");
    let (whole, part) = (read("whole.exr"), read("part.exr"));
    assert_eq!((part.width(), part.height()), (10, 7));
    assert!(part.channel_names().eq(["B", "G", "R", "depth.Z", "luminance.Y", "stderr.Y"]));
    for name in part.channel_names() {
        let [all, some] = [&whole, &part].map(|exr| exr.channel(name).expect("a channel"));
        let cut = all.chunks(16).skip(2).take(7).flat_map(|row| &row[4..14]);
        assert!(cut.eq(some), "{name}");
    }
    // A quick look halves the crop with the picture.
    done(at, &["render", "room.toml", "--quick", "--crop", "4,2,14,9", "-o", "quick.exr"]);
    assert_eq!((read("quick.exr").width(), read("quick.exr").height()), (5, 4));
    let bytes = fs::read(at.join("part.exr")).expect("read");
    done(at, &[&crop[..], &["--force"]].concat());
    assert_eq!(fs::read(at.join("part.exr")).expect("read"), bytes, "equal runs, other bytes");
}

#[test]
fn pictures_of_nothing_and_impossible_crops_are_refused() {
    let folder = folder();
    let at = folder.path();
    let open = ROOM.replace(
        "[objects.room.box]\nmin = [0, 0, 0]\nmax = [4, 5, 3]\ninward = true\n\
                             material = \"walls\"\n",
        "",
    );
    fs::write(at.join("open.toml"), open).expect("written");
    let away = "cameras.main.perspective.to=[2, -3, 1]";
    for (arguments, code, words) in [
        (
            &["open.toml", "-D", away][..],
            3,
            &["camera `main` looks at nothing", "write `to = [2, 3.5, 0.6]`"][..],
        ),
        (&["room.toml", "--crop", "0,0,17,3"], 3, &["--crop", "16 x 12 pixels"]),
        (&["room.toml", "-D", "render.crop=[0,0,17,3]"], 3, &["-D render.crop", "16 x 12"]),
        (&["room.toml", "--crop", "5,0,5,3"], 2, &["empty crop"]),
        (&["room.toml", "--exposure", "0"], 2, &["write a factor above 0"]),
        (&["room.toml", "-D", "render.exposure=p98"], 3, &["-D render.exposure", "\"98%\""]),
        (&["room.toml", "-D", "render.exposure=0"], 3, &["above 0", "found 0"]),
        (&["room.toml", "--tone", "film"], 2, &["filmic"]),
        (&["room.toml", "--camera", "mian"], 3, &["--camera mian", "around, glare, main, plan"]),
        (&["room.toml", "--layers", "norml"], 2, &["normal"]),
        (&["room.toml", "-D", "render.filter=gauss"], 3, &["cannot be `gauss`", "`gaussian`"]),
        (
            &["room.toml", "-D", "render.layers=[\"norml\"]"],
            3,
            &["cannot be `norml`", "did you mean `normal`"],
        ),
        (&["room.toml", "-D", "cameras.glare.fisheye.fov=361"], 3, &["at most 360 degrees"]),
        (
            &["room.toml", "-D", "cameras.plan.orthographic.height=3"],
            3,
            &["both `height` and `width`"],
        ),
        (
            &[
                "room.toml",
                "-D",
                "cameras.around.panorama.up=[1, 0, 0]",
                "-D",
                "cameras.around.panorama.to=[9, 0.25, 1.6]",
            ],
            3,
            &["along the view"],
        ),
        (&["room.toml", "--size", "60000x60000"], 3, &["beyond what a film holds"]),
    ] {
        let output = run(at, &[&["render"], arguments].concat());
        let said = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(code), "{arguments:?}: {said}");
        assert!(words.iter().all(|word| said.contains(word)), "{arguments:?}: {said}");
    }
    // A body far below a pixel, which no ray that looks meets, is something all the same.
    let crumb = ["-D", "objects.crate.box.min=[2.1, 4, 1]"];
    let crumb = [&crumb[..], &["-D", "objects.crate.box.max=[2.1001, 4.0001, 1.0001]"]].concat();
    done(at, &[&["render", "open.toml", "-o", "crumb.png"], &crumb[..]].concat());
    // An empty part of a picture that shows something is no mistake.
    done(at, &["render", "open.toml", "--crop", "0,0,3,3", "-o", "sky.png"]);
}
