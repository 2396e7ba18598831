//! Sensors on surfaces: what they measure against closed forms, and the maps that `illum` writes of
//! them.

use std::f64::consts::PI;
use std::fs;
use std::ops::ControlFlow;
use std::path::Path;
use std::process::Command;

use glam::DVec3;
use harmolux::estimators::{Estimator, SensorSettings, Stop, Survey, Weighting, illuminance};
use harmolux::fit::Shape;
use harmolux::io::coefficients::{SeriesFormat, WriteOptions, encode};
use harmolux::io::meshes;
use harmolux::io::scene_file::SceneFile;
use harmolux::math::Randomness;
use harmolux::sh::Coefficients;
use harmolux::study::{Loaded, load};
use rayon::prelude::*;
use tempfile::TempDir;

const LAMP: DVec3 = DVec3::new(3.0, -1.0, 2.0);

/// A lamp of 100 cd, a black material and one that glows.
const START: &str = "format = 1
[materials.black.lambert]
reflectance = 0
[materials.glow.lambert]
reflectance = 0.5
exitance = 50
[lights.lamp.point]
at = [3, -1, 2]
intensity = 100
[illum]
seed = 1
stop = { walks = 64 }
";

const BALL: &str = "[objects.ball.sphere]
centre = [1, 0, 0]
radius = 0.8
material = \"black\"
";

/// A folder with a unit ball of degree 0, a cube and a prism over an L as files.
fn folder() -> TempDir {
    let folder = tempfile::tempdir().expect("a folder");
    let write =
        |name: &str, text: &str| fs::write(folder.path().join(name), text).expect("written");
    let mut ball = Coefficients::zeros(0);
    ball.set(0, 0, 1.0, 0.0);
    fs::write(folder.path().join("ball.sh"), series(ball)).expect("written");
    write(
        "cube.off",
        "OFF\n8 6 0\n-1 -1 -1\n1 -1 -1\n1 1 -1\n-1 1 -1\n-1 -1 1\n1 -1 1\n1 1 1\n-1 1 1\n\
         4 3 2 1 0\n4 4 5 6 7\n4 0 1 5 4\n4 1 2 6 5\n4 2 3 7 6\n4 3 0 4 7\n",
    );
    let outline = [[0, 0], [3, 0], [3, 1], [1, 1], [1, 3], [0, 3]];
    let level = |z: u32| outline.map(|[x, y]| format!("{x} {y} {z}\n")).concat();
    let sides = (0..6).map(|i| {
        let j = (i + 1) % 6;
        format!("4 {i} {j} {} {}\n", j + 6, i + 6)
    });
    let caps = "4 3 2 1 0\n4 5 4 3 0\n4 6 7 8 9\n4 6 9 10 11\n";
    let faces: String = sides.chain([caps.to_owned()]).collect();
    write("l.off", &format!("OFF\n12 10 0\n{}{}{faces}", level(0), level(1)));
    folder
}

fn series(coefficients: Coefficients) -> Vec<u8> {
    encode(&Shape::new(coefficients), SeriesFormat::Text, &WriteOptions::default())
        .expect("encodes")
}

fn scene(folder: &TempDir, more: &str) -> Loaded {
    let path = folder.path().join("scene.toml");
    let file = SceneFile::parse(&path, &format!("{START}{more}"), &[]).expect("valid");
    load(&file).expect("loads")
}

fn survey(loaded: &Loaded, walks: u64) -> Survey {
    let settings = SensorSettings {
        estimator: Estimator::Local(Weighting::of(&loaded.scene)),
        randomness: Randomness::Sobol,
        seed: 1,
        stop: Stop { walks: Some(walks), ..Stop::default() },
    };
    let sensors: Vec<_> = loaded.sensors.iter().flat_map(|g| g.sensors.iter().copied()).collect();
    illuminance(&loaded.scene, &sensors, &settings, &|_| ControlFlow::Continue(())).expect("lit")
}

/// Returns I cos / d^2 of the lamp where it is in front, else 0.
fn lit(at: DVec3, normal: DVec3) -> f64 {
    let off = LAMP - at;
    100.0 * normal.dot(off).max(0.0) / off.length().powi(3)
}

#[test]
fn sphere_under_a_lamp_has_the_closed_form() {
    let folder = folder();
    for (layout, count) in
        [("points = 2000", 2000), ("vertices = true\npoints = 2000", 10 * 225 + 2)]
    {
        let loaded =
            scene(&folder, &format!("{BALL}[sensors.s.surface]\non = \"ball\"\n{layout}\n"));
        let group = &loaded.sensors[0];
        assert_eq!(group.sensors.len(), count);
        let survey = survey(&loaded, 64);
        let mut sum = 0.0;
        for (sensor, result) in group.sensors.iter().zip(&survey.results) {
            let out = (sensor.at - DVec3::X).normalize();
            assert!((sensor.at.distance(DVec3::X) - 0.8).abs() <= 1e-14);
            assert!(sensor.normal.distance(out) <= 1e-14);
            let exact = lit(DVec3::X + 0.8 * out, out);
            assert!((result.direct.mean - exact).abs() <= 1e-6 * exact + 1e-12, "{sensor:?}");
            sum += result.direct.mean;
        }
        // What falls on the ball is what goes into its solid angle.
        let sin2 = 0.64 / (LAMP - DVec3::X).length_squared();
        let mean = 100.0 * 2.0 * PI * (1.0 - (1.0 - sin2).sqrt()) / (4.0 * PI * 0.64);
        let error = sum / count as f64 / mean - 1.0;
        // The lattice is good to about 1 / n; the vertices of a geodesic sphere differ by some per
        // cent in the area they stand for.
        let tolerance = if layout.contains("vertices") { 3e-2 } else { 1e-3 };
        assert!(error.abs() <= tolerance, "{layout}: {error}");
    }
}

/// Bodies that are convex, by the lines of their object.
fn convex_bodies() -> Vec<(&'static str, &'static str)> {
    vec![
        ("sh", "file = \"ball.sh\"\ndegree = 0\n"),
        ("sh", "file = \"ball.sh\"\ndegree = 0\nintersector = \"certified\"\n"),
        (
            "sh",
            "file = \"ball.sh\"\ndegree = 0\nat = [0.1, 0.2, -0.4]\nscale = 0.01\n\
             rotate = { axis = [1, 2, 3], degrees = 77 }\n",
        ),
        ("sh", "file = \"ball.sh\"\ndegree = 0\nat = [-300, 200, -50]\nscale = 3\n"),
        ("mesh", "file = \"cube.off\"\n"),
        ("mesh", "file = \"cube.off\"\nsmooth = true\n"),
        (
            "mesh",
            "file = \"cube.off\"\nat = [-300, 200, -50]\nscale = 0.02\n\
             rotate = { axis = [1, 2, 3], degrees = 77 }\n",
        ),
        ("sphere", "centre = [-300, 200, -50]\nradius = 0.5\n"),
        ("box", "min = [-1, -2, -1]\nmax = [1, -1, 2]\n"),
        ("disc", "centre = [0, 0, 0]\nnormal = [1, 1, 1]\nradius = 1\n"),
        ("rectangle", "corner = [0, 0, 0]\nedge_u = [1, 0, 0]\nedge_v = [0, 2, 0]\n"),
    ]
}

#[test]
fn on_convex_bodies_no_sensor_before_the_lamp_is_dark_and_none_behind_is_lit() {
    let folder = folder();
    for (kind, lines) in convex_bodies() {
        for layout in ["points = 3000", "vertices = true\npoints = 900", "vertices = true"] {
            let fits = match kind {
                "mesh" => !layout.contains("vertices") || !layout.contains("points"),
                "sh" | "sphere" => layout.contains("points"),
                _ => !layout.contains("vertices"),
            };
            if !fits {
                continue;
            }
            let text = format!(
                "[objects.body.{kind}]\nmaterial = \"black\"\n{lines}[sensors.s.surface]\n\
                 on = \"body\"\n{layout}\n"
            );
            let loaded = scene(&folder, &text);
            let group = &loaded.sensors[0];
            assert!(group.behind.iter().all(Option::is_none) && loaded.warnings.is_empty());
            let survey = survey(&loaded, 1);
            let bright = survey.results.iter().filter(|r| r.direct.mean > 0.0).count();
            assert!(bright > 0, "{text}");
            for (sensor, result) in group.sensors.iter().zip(&survey.results) {
                let exact = lit(sensor.at, sensor.normal);
                assert!((result.direct.mean - exact).abs() <= 1e-9 * exact, "{text}{sensor:?}");
            }
        }
    }
}

#[test]
fn everything_in_a_furnace_receives_pi_l() {
    let folder = folder();
    // Exitance over absorption: 50 / (1 - 0.5) = 100 lx everywhere; the lamp is outside the room's
    // scene.
    let furnace = START.replace("[lights.lamp.point]\nat = [3, -1, 2]\nintensity = 100\n", "");
    for (kind, lines, layout) in [
        ("sphere", "centre = [0, 0, 0]\nradius = 1\n", "points = 40"),
        ("sh", "file = \"ball.sh\"\ndegree = 0\n", "points = 40"),
        ("sh", "file = \"ball.sh\"\ndegree = 0\n", "vertices = true\npoints = 40"),
        ("mesh", "file = \"l.off\"\nat = [-1.5, -1.5, 0]\n", "points = 40"),
        ("mesh", "file = \"l.off\"\nat = [-1.5, -1.5, 0]\n", "vertices = true"),
    ] {
        let text = format!(
            "{furnace}[objects.room.box]\nmin = [-2, -2, -2]\nmax = [2, 2, 2]\ninward = true\n\
             material = \"glow\"\n[objects.body.{kind}]\nmaterial = \"glow\"\n\
             {lines}[sensors.s.surface]\non = \"body\"\n{layout}\n[sensors.wall.surface]\n\
             on = \"room.x_max\"\npoints = 10\n[sensors.walls.surface]\non = \"room\"\n\
             points = 20\n"
        );
        let file = SceneFile::parse(&folder.path().join("f.toml"), &text, &[]).expect("valid");
        let loaded = load(&file).expect("loads");
        assert!(loaded.warnings.is_empty(), "{:?}", loaded.warnings);
        let survey = survey(&loaded, 1 << 12);
        let count = survey.results.len();
        for (i, result) in survey.results.iter().enumerate() {
            let total = result.total;
            assert!(total.agrees_with(100.0, 1e-9, 5 * count), "{kind} {layout} {i}: {total:?}");
            assert!(total.standard_error <= 5.0, "{kind} {layout} {i}: {total:?}");
        }
    }
}

#[test]
fn head_as_mesh_and_as_series_receives_the_same() {
    let head = Path::new(env!("CARGO_MANIFEST_DIR")).join("data/head.obj");
    let folder = folder();
    let mut flux = Vec::new();
    for kind in ["mesh]", "sh]\ndegree = 24"] {
        let text = format!(
            "[objects.head.{kind}\nfile = {head:?}\nmaterial = \"black\"\nscale = 7\n\
             [sensors.s.surface]\non = \"head\"\npoints = 4000\n"
        );
        let loaded = scene(&folder, &text);
        let survey = survey(&loaded, 1);
        let mean = survey.results.iter().map(|r| r.direct.mean).sum::<f64>() / 4000.0;
        let area = loaded.scene.objects()[0].area.as_ref().expect("bounded").area();
        flux.push([mean, mean * area]);
    }
    let [mesh, series] = [flux[0], flux[1]];
    // The series of degree 24 has less area behind the ears; what it catches of the lamp differs by
    // its outline alone.
    assert!((mesh[0] / series[0] - 1.0).abs() <= 0.05, "{flux:?}");
    assert!((mesh[1] / series[1] - 1.0).abs() <= 0.01, "{flux:?}");
}

#[test]
fn mean_over_a_series_is_the_mean_over_its_area() {
    let folder = folder();
    let mut pear = Coefficients::zeros(2);
    pear.set(0, 0, 1.0, 0.0);
    pear.set(1, 0, 0.4, 0.0);
    pear.set(2, 0, 0.2, 0.0);
    pear.set(2, 2, 0.1, -0.05);
    fs::write(folder.path().join("pear.sh"), series(pear)).expect("written");
    let text = "[objects.pear.sh]\nfile = \"pear.sh\"\ndegree = 2\nmaterial = \"black\"\n\
                scale = 2\nrotate = { axis = [1, 0, 0], degrees = 50 }\n[sensors.s.surface]\n\
                on = \"pear\"\npoints = 5000\n";
    let loaded = scene(&folder, text);
    let area = loaded.scene.objects()[0].area.clone().expect("bounded");
    let sensors = &loaded.sensors[0].sensors;
    // By the theorem of Gauss: the mean of n is 0 and that of p.n is 3 V / A; both to the lattice.
    let mean_normal = sensors.iter().map(|s| s.normal).sum::<DVec3>() / 5000.0;
    assert!(mean_normal.length() <= 2e-3, "{mean_normal}");
    // The same by weights: uniform directions, each by the inverse of its density.
    let mut weighted = [0.0; 2];
    for i in 0..200 * 200 {
        let u = glam::DVec2::new(f64::from(i % 200) + 0.5, f64::from(i / 200) + 0.5) / 200.0;
        let point = area.sample_area(u);
        weighted[0] += 1.0 / point.density;
        weighted[1] += point.hit.point.dot(DVec3::Z).powi(2) / point.density;
    }
    let (total, second) = (weighted[0] / 40_000.0, weighted[1] / weighted[0]);
    assert!((total / area.area() - 1.0).abs() <= 1e-4);
    let plain = sensors.iter().map(|s| s.at.z * s.at.z).sum::<f64>() / 5000.0;
    assert!((plain / second - 1.0).abs() <= 1e-3, "{plain} {second}");
}

#[test]
fn head_is_covered_evenly() {
    let head = Path::new(env!("CARGO_MANIFEST_DIR")).join("data/head.obj");
    let folder = folder();
    let text = format!(
        "[objects.head.sh]\ndegree = 32\nfile = {head:?}\nmaterial = \"black\"\nscale = 7\n\
         [sensors.s.surface]\non = \"head\"\npoints = 4000\n"
    );
    let loaded = scene(&folder, &text);
    let area = loaded.scene.objects()[0].area.clone().expect("bounded");
    let (n, h) = (150, 1e-5);
    let stretch = |i: u32| {
        let i = f64::from(i);
        let u = glam::DVec2::new((i + 0.5) / f64::from(n), 0.01 + 0.98 * (0.618_034 * i).fract());
        let at = |x: f64, y: f64| area.uniform(u + h * glam::DVec2::new(x, y)).point;
        let along = (at(1.0, 0.0) - at(-1.0, 0.0)) / (2.0 * h);
        let around = (at(0.0, 1.0) - at(0.0, -1.0)) / (2.0 * h);
        (along.cross(around).length() / area.area() - 1.0).powi(2)
    };
    let squares: f64 = (0..n).into_par_iter().map(stretch).sum();
    let rms = (squares / f64::from(n)).sqrt();
    // What twice oversampled series leave of the creases at the ears and the neck.
    assert!(rms <= 1e-2, "{rms}");
    // In a mean over the area it cancels: moments of the position and of the light of a lamp
    // without its shadows, against weights.
    let moments: [fn(DVec3, DVec3) -> f64; 3] = [|p, _| p.z * p.z, |p, _| p.x * p.x, lit];
    for moment in moments {
        let (mut sum, mut weights) = (0.0, 0.0);
        for i in 0..200 * 200 {
            let u = glam::DVec2::new(f64::from(i % 200) + 0.5, f64::from(i / 200) + 0.5) / 200.0;
            let point = area.sample_area(u);
            sum += moment(point.hit.point, point.hit.normal) / point.density;
            weights += 1.0 / point.density;
        }
        let sensors = &loaded.sensors[0].sensors;
        let plain = sensors.iter().map(|s| moment(s.at, s.normal)).sum::<f64>() / 4000.0;
        let error = plain / (sum / weights) - 1.0;
        assert!(error.abs() <= 3e-3, "{error}");
    }
}

#[test]
fn own_object_never_hides_a_sensor_and_others_do() {
    let folder = folder();
    let l = "[objects.l.mesh]\nfile = \"l.off\"\nmaterial = \"black\"\nscale = 1e-4\n";
    for layout in ["points = 20000", "vertices = true"] {
        let loaded = scene(&folder, &format!("{l}[sensors.s.surface]\non = \"l\"\n{layout}\n"));
        assert!(loaded.sensors[0].behind.iter().all(Option::is_none), "{layout}");
    }
    let room = "[objects.room.box]\nmin = [-5, -5, -5]\nmax = [5, 5, 5]\ninward = true\n\
                material = \"black\"\n[objects.ball.sphere]\ncentre = [5, 0, 0]\nradius = 1\n\
                material = \"black\"\n[sensors.s.surface]\non = \"ball\"\npoints = 1000\n";
    let loaded = scene(&folder, room);
    let group = &loaded.sensors[0];
    let hidden = group.behind.iter().filter(|b| b.as_deref() == Some("room")).count();
    assert!(hidden.abs_diff(500) <= 10, "{hidden}");
    assert!(loaded.warnings.iter().any(|w| w.contains("sensors `s`")));
}

fn illum(folder: &TempDir, text: &str, words: &[&str]) -> (i32, String) {
    fs::write(folder.path().join("scene.toml"), format!("{START}{text}")).expect("written");
    let mut command = Command::new(env!("CARGO_BIN_EXE_harmolux"));
    command.current_dir(folder.path()).args(["illum", "scene.toml"]).args(words);
    let output = command.output().expect("it starts");
    let text = [output.stdout.as_slice(), &output.stderr].map(String::from_utf8_lossy).concat();
    (output.status.code().unwrap_or(-1), text)
}

#[test]
fn map_of_a_mesh_is_that_mesh_with_its_illuminance() {
    let folder = folder();
    let cube = "[objects.cube.mesh]\nfile = \"cube.off\"\nmaterial = \"black\"\nat = [0, 0, 5]\n\
                scale = 0.5\n[sensors.all.surface]\non = \"cube\"\nvertices = true\n";
    let (code, said) = illum(&folder, cube, &["-o", "map.ply", "-o", "map.csv"]);
    assert_eq!(code, 0, "{said}");
    assert!(
        said.contains("map.ply: viridis from 0 to") && said.contains("written map.ply"),
        "{said}"
    );
    let bytes = fs::read(folder.path().join("map.ply")).expect("written");
    let head = String::from_utf8_lossy(&bytes[..600]).into_owned();
    for line in [
        "element vertex 8",
        "property float nz",
        "property float illuminance",
        "property float half_width",
        "property uchar red",
        "element face 12",
    ] {
        assert!(head.contains(&format!("{line}\n")), "{head}");
    }
    let [map, cube] =
        ["map.ply", "cube.off"].map(|n| meshes::read(&folder.path().join(n)).expect("read"));
    assert_eq!(map.triangles(), cube.triangles());
    for (there, here) in map.positions().iter().zip(cube.positions()) {
        assert!(there.distance(0.5 * *here + DVec3::new(0.0, 0.0, 5.0)) <= 1e-15);
    }
    // The rows of the table are the same sensors.
    let (code, said) = illum(&folder, &cube_of_points(), &["-o", "map.ply", "--force"]);
    assert_eq!(code, 0, "{said}");
    let cloud = fs::read(folder.path().join("map.ply")).expect("written");
    let end = cloud.windows(11).position(|w| w == b"end_header\n").expect("a header") + 11;
    assert_eq!(cloud.len() - end, 50 * (24 + 12 + 8 + 3));
    assert!(!String::from_utf8_lossy(&cloud[..end]).contains("face"));
    let rows = fs::read_to_string(folder.path().join("map.csv")).expect("written");
    assert_eq!(rows.lines().count(), 9);
}

fn cube_of_points() -> String {
    "[objects.cube.mesh]\nfile = \"cube.off\"\nmaterial = \"black\"\n[sensors.all.surface]\n\
     on = \"cube\"\npoints = 50\n"
        .to_owned()
}

#[test]
fn map_takes_one_group_and_says_which() {
    let folder = folder();
    let spot = "[sensors.spot.points]\nat = [[0, 0, 4]]\nnormal = [0, 0, 1]\n";
    let (code, said) = illum(&folder, &format!("{BALL}{spot}"), &["-o", "a.ply"]);
    assert!(code == 3 && said.contains("no sensors of kind surface"), "{said}");
    let two = format!(
        "{BALL}{spot}[sensors.a.surface]\non = \"ball\"\npoints = 5\n[sensors.b.surface]\n\
         on = \"ball\"\npoints = 7\n"
    );
    let (code, said) = illum(&folder, &two, &["-o", "map.ply"]);
    assert!(
        code == 3 && said.contains("holds one group") && said.contains("-o a.ply -o b.ply"),
        "{said}"
    );
    let (code, said) = illum(&folder, &two, &["-o", "a.ply", "-o", "b.ply"]);
    assert_eq!(code, 0, "{said}");
    let head = fs::read(folder.path().join("b.ply")).expect("written");
    assert!(String::from_utf8_lossy(&head[..300]).contains("element vertex 7\n"));
}
