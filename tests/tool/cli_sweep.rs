//! `sweep` and `view` as a user meets them: every number is that of the verb that measures it
//! alone, every line is kept as it comes, and names are never markup.

use std::fs;

use serde_json::Value;

use crate::common::desk::repository;
use crate::common::desk::{Desk, assert_says};
use crate::common::scenes::{LAMP, ROOM};
use crate::common::solids::cube;

/// A stone that no mirror maps to itself, as a mesh of 1280 faces.
fn stone(desk: &Desk) {
    desk.done("random --power-law rms=0.15,exponent=3 -l 12 --seed 3 -o seed.txt");
    desk.done("mesh seed.txt -o stone.obj --resolution 8");
}

/// A room in which the stone is an SH object, seen by a camera and a few sensors.
const BODY: &str = r#"[objects.body.sh]
file = "stone.obj"
degree = 9
at = [2, 3, 1.2]
scale = 0.6
material = "grey"
[cameras.main.perspective]
from = [2, 0.3, 1.5]
to = [2, 3, 1.2]
fov = 50
resolution = [24, 18]
[sensors.floor.points]
at = [[1, 1, 0], [3, 4, 0]]
normal = [0, 0, 1]
[render]
exposure = 0.05
[illum]
stop = { walks = 4096 }
"#;

fn rows(report: &Value) -> Vec<&Value> {
    report["rows"].as_array().expect("rows").iter().collect()
}

fn row<'a>(report: &'a Value, shape: &str, degree: Option<u64>) -> &'a Value {
    let found = rows(report).into_iter();
    let found = found.filter(|row| row["shape"] == shape && row["degree"].as_u64() == degree);
    let found: Vec<&Value> = found.collect();
    assert_eq!(found.len(), 1, "{shape} {degree:?}");
    found[0]
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or_else(|| panic!("{value} is no number"))
}

#[test]
fn numbers_of_shape_and_storage_are_those_of_fit_diff_and_convert() {
    let desk = Desk::new();
    stone(&desk);
    let report = desk.json("sweep stone.obj -l 2,5 -o out");
    let five = row(&report, "series", Some(5));
    let fit = desk.json("fit stone.obj -l 5 -o five.txt");
    for (own, other) in [("relative_rms", "rms"), ("relative_max", "max")] {
        let other = number(&fit[other]) / number(&fit["mean_radius"]);
        assert!((number(&five[own]) - other).abs() <= 1e-12 * other, "{own}");
    }
    assert_eq!(desk.bytes("five.txt"), desk.bytes("out/stone-5.txt"));
    let diff = desk.json("diff five.txt stone.obj");
    for (own, other) in [
        ("hausdorff_lower_m", "hausdorff_lower_m"),
        ("hausdorff_upper_m", "hausdorff_upper_m"),
        ("normal_mean_deg", "normal_angle_mean_deg"),
        ("normal_95_deg", "normal_angle_95_deg"),
    ] {
        let (own, other) = (number(&five[own]), number(&diff[other]));
        assert!((own - other).abs() <= 1e-12 * other, "{own} and {other}");
    }
    let volume = number(&diff["volume_a_m3"]) / number(&diff["volume_b_m3"]) - 1.0;
    assert!((number(&five["volume_error"]) - volume).abs() <= 1e-12);
    // What is written by hand has as many bytes.
    desk.done("fit stone.obj -l 5 -o five.hxc");
    desk.done("convert five.txt five.hxb");
    let bytes = |name: &str| desk.bytes(name).len() as u64;
    assert_eq!(five["bytes_compact"], bytes("five.hxc"));
    assert_eq!(five["bytes_f64"], bytes("five.hxb"));
    assert_eq!(five["bytes_text"], bytes("five.txt"));
    assert_eq!((&five["bytes_f32"], &five["numbers"]), (&144.into(), &36.into()));
    let original = row(&report, "original", None);
    for (column, name) in [("bytes_ply", "copy.ply"), ("bytes_stl", "copy.stl")] {
        desk.done(format!("convert stone.obj {name}"));
        assert_eq!(original[column], bytes(name), "{column}");
    }
    // A decimated mesh takes no more bytes than the series, and errs as `diff` says.
    let rival = row(&report, "decimated", Some(5));
    assert!(number(&rival["bytes_f32"]) <= 144.0 && number(&rival["numbers"]) == 7.0);
    assert!(number(&rival["relative_rms"]) > number(&five["relative_rms"]));
    for column in ["hit_ns", "blocked_batch_ratio", "refine_ns_q3", "prepare_ms", "bytes_traced"] {
        assert!(number(&five[column]) > 0.0, "{column}");
    }
}

#[test]
fn numbers_of_light_are_those_of_render_illum_and_compare() {
    let desk = Desk::new();
    stone(&desk);
    desk.put("room.toml", [ROOM, LAMP, BODY].concat());
    let report = desk.json("sweep stone.obj -l 3 --scene room.toml --samples 8 -o out");
    let three = row(&report, "series", Some(3));
    let body = desk.text("room.toml");
    let mesh = body.replace("[objects.body.sh]", "[objects.body.mesh]").replace("degree = 9\n", "");
    desk.put("mesh.toml", mesh);
    desk.put("three.toml", body.replace("degree = 9", "degree = 3"));
    let stop = "-D render.stop.walks=256";
    desk.done(format!("render mesh.toml {stop} -o mesh.png -o mesh.exr"));
    desk.done(format!("render mesh.toml {stop} --seed 1 -o noise.exr"));
    desk.done(format!("render three.toml {stop} --seed 1 -o three.png -o three.exr"));
    let pixels = |name: &str| image::load_from_memory(&desk.bytes(name)).expect("a PNG").to_rgb8();
    assert_eq!(pixels("out/stone-original.png"), pixels("mesh.png"));
    assert_eq!(pixels("out/stone-3.png"), pixels("three.png"));
    let compared = |name: &str| {
        let said = desk.run(format!("compare {name} mesh.exr --json"));
        let value: Value = serde_json::from_str(&said.out).expect("JSON");
        [number(&value["relmse"]), number(&value["flip_mean"])]
    };
    let ([relmse, flip], [noise, flip_noise]) = (compared("three.exr"), compared("noise.exr"));
    // An EXR keeps seven digits.
    let near = |a: &Value, b: f64| assert!((number(a) - b).abs() <= 1e-4 * b.abs(), "{a} {b}");
    near(&three["relmse"], (relmse - noise).max(0.0));
    near(&three["relmse_noise"], noise);
    near(&three["flip"], flip);
    near(&three["flip_noise"], flip_noise);
    let lux = |scene: &str, seed: &str| -> Vec<f64> {
        let report = desk.json(format!("illum {scene} --seed {seed}"));
        rows(&report).iter().map(|row| number(&row["illuminance_lx"])).collect()
    };
    let (own, original) = (lux("three.toml", "1"), lux("mesh.toml", "0"));
    let changes = own.iter().zip(&original).map(|(a, b)| (a / b - 1.0).abs());
    near(&three["lux_max"], changes.fold(0.0, f64::max));
    assert!(number(&three["silhouette_pixels"]) > 0.0 && number(&three["render_ratio"]) > 0.0);
}

#[test]
fn a_scene_without_camera_has_no_pictures() {
    let desk = Desk::new();
    stone(&desk);
    let body = [ROOM, LAMP, BODY].concat();
    let (before, rest) = body.split_once("[cameras").expect("a camera");
    let (_, after) = rest.split_once("[sensors").expect("sensors");
    desk.put("room.toml", format!("{before}[sensors{after}"));
    let report = desk.json("sweep stone.obj -l 3 --scene room.toml -o out");
    let three = row(&report, "series", Some(3));
    assert!(three["relmse"].is_null() && three["flip"].is_null() && three["lux_max"].is_number());
    desk.refused("sweep stone.obj -l 3 --scene room.toml -o out --tolerance relmse=1", &["camera"]);
}

#[test]
fn a_sweep_goes_on_from_its_table() {
    let desk = Desk::of(&["sweep", "a.obj", "-o", "out"]).with("a.obj", cube(1.0));
    desk.done("-l 1,2");
    let whole = desk.text("out/sweep.csv");
    let lines: Vec<&str> = whole.lines().collect();
    let starts = ["shape,degree,", "original,,", "series,1,", "series,2,"];
    assert!(lines.iter().zip(starts).all(|(line, start)| line.starts_with(start)), "{whole}");
    desk.put(
        "out/sweep.csv",
        format!("{}\n{}\n{}\n{}", lines[0], lines[1], lines[2], &lines[3][..9]),
    );
    for name in ["error_bytes.svg", "spectrum.png", "a-2.txt", "index.html"] {
        fs::remove_file(desk.path(&format!("out/{name}"))).expect("it was written");
    }
    desk.done("-l 1,2");
    let again = desk.text("out/sweep.csv");
    let now: Vec<&str> = again.lines().collect();
    assert_eq!(now[..3], lines[..3], "what was there was timed again: {again}");
    assert_eq!(now.len(), lines.len());
    assert!(desk.path("out/a-2.txt").exists() && desk.path("out/index.html").exists());
    // More degrees, and the figures anew; a complete sweep is as it was.
    let figure = desk.bytes("out/error_degree.svg");
    desk.done("-l 1,2,3");
    assert!(desk.bytes("out/error_degree.svg") != figure);
    let three = desk.text("out/sweep.csv");
    desk.done("-l 1,2,3");
    assert_eq!(desk.text("out/sweep.csv"), three);
    desk.put("a.obj", cube(2.0));
    desk.refused("-l 1", &["out/sweep.csv: the row of original", "is of another run"]);
}

#[test]
fn what_a_run_left_behind_is_made_whole_and_nothing_else_is_touched() {
    let desk = Desk::new();
    stone(&desk);
    desk.put("room.toml", [ROOM, LAMP, BODY].concat());
    let line = "sweep stone.obj -l 1,2 --scene room.toml --samples 2 -o out";
    desk.done(line);
    let whole = desk.text("out/stone-2.txt");
    let table = desk.text("out/sweep.csv");
    // Killed between the files and the line, or in the middle of the line; a picture that is gone.
    let without = |shape: &str| -> String {
        table.lines().filter(|row| !row.starts_with(shape)).flat_map(|row| [row, "\n"]).collect()
    };
    let torn = table.replacen("series,2,9,", "series,2,nine,", 1);
    for left in [without("series,2,"), torn, table.clone()] {
        desk.put("out/sweep.csv", left);
        fs::remove_file(desk.path("out/stone-2.png")).expect("it was there");
        let said = desk.done(line);
        assert_says(&said.err, &["degree 2"]);
        assert_eq!(desk.text("out/stone-2.txt"), whole);
        assert!(desk.path("out/stone-2.png").exists());
        assert!(desk.text("out/sweep.csv").contains("series,2,9,"));
    }
    // What another program wrote stays, and so does all where there is no table.
    desk.put("out/sweep.csv", without("series,2,"));
    desk.put("out/stone-2.txt", "mine");
    assert_says(&desk.ends(3, line).err, &["stone-2.txt", "not written by this program"]);
    fs::remove_file(desk.path("out/sweep.csv")).expect("it was there");
    desk.put("out/stone-2.txt", whole);
    assert_says(&desk.ends(3, line).err, &["there already", "--force"]);
}

#[test]
fn one_degree_is_a_sweep_too() {
    let desk = Desk::new();
    stone(&desk);
    // Degree 0 has no place on a logarithmic axis, a whole series no error.
    desk.done("sweep stone.obj -l 0 -o zero");
    desk.done("sweep seed.txt -l 12 -o whole");
    for folder in ["zero", "whole"] {
        assert!(desk.path(&format!("{folder}/index.html")).exists(), "{folder}");
    }
    assert!(!desk.path("whole/error_bytes.svg").exists());
}

#[test]
fn limits_below_the_noise_are_told() {
    let desk = Desk::new();
    stone(&desk);
    desk.put("room.toml", [ROOM, LAMP, BODY].concat());
    let line =
        "sweep stone.obj -l 1 --scene room.toml --samples 2 -o out --tolerance flip=1e-6,rms=1e-6";
    let said = desk.ends(4, line).err;
    assert_says(&said, &["flip <= 1e-6: noise alone makes", "raise `--samples`", "higher ones"]);
}

#[test]
fn a_mesh_elsewhere_is_told() {
    let desk = Desk::new();
    stone(&desk);
    let moved = |line: &str| match line.strip_prefix("v ") {
        Some(place) => {
            let (x, rest) = place.split_once(' ').expect("three numbers");
            format!("v {} {rest}\n", x.parse::<f64>().expect("a number") + 50.0)
        }
        None => format!("{line}\n"),
    };
    desk.put("far.obj", desk.text("stone.obj").lines().map(moved).collect::<String>());
    let said = desk.done("view seed.txt --mesh far.obj -o far.html").err;
    assert_says(&said, &["does not lie about the centre", "another unit"]);
    let said = desk.done("view seed.txt --mesh stone.obj -o near.html").err;
    assert!(!said.contains("warning"), "{said}");
}

#[test]
fn a_table_is_printed_and_limits_are_answered() {
    let desk = Desk::new();
    stone(&desk);
    let said = desk.done("sweep stone.obj -l 2..6 -o out --tolerance rms=20%,hausdorff=1km");
    assert_says(&said.out, &["| degree 2", "| mesh as degree 6", "rms <= 20%: degree 2, 36 B"]);
    let report = desk.json_at(4, "sweep stone.obj -l 2..6 -o out --tolerance rms=20%,normal=0deg");
    assert_eq!(report["answers"][0]["degree"], 2);
    assert_eq!(report["answers"][1]["degree"], Value::Null);
    let said = desk.ends(4, "sweep stone.obj -l 2..6 -o out --tolerance max=0");
    assert_says(&said.err, &["max <= 0: no degree keeps this"]);
    let says = ["--tolerance flip <= 0.1", "a scene with a camera", "`--scene`"];
    desk.refused("sweep stone.obj -l 2..6 -o out --tolerance flip=0.1", &says);
    let said = desk.ends(2, "sweep stone.obj -l 2 -o out --tolerance size=1");
    assert_says(&said.err, &["no limit of this name: use one of rms, max"]);
}

#[test]
fn a_series_is_cut_at_each_degree() {
    let desk = Desk::new();
    stone(&desk);
    desk.done("fit stone.obj -l 8 -o eight.txt");
    let report = desk.json("sweep eight.txt -l 2,8 -o out");
    assert_eq!(rows(&report).len(), 3, "no mesh, no rivals");
    desk.done("convert eight.txt -l 2 two.txt");
    let diff = desk.json("diff two.txt eight.txt");
    let two = row(&report, "series", Some(2));
    let rms = number(&diff["radial_rms_m"]) / number(&diff["mean_radius_a_m"]);
    assert!((number(&two["relative_rms"]) - rms).abs() <= 1e-9 * rms);
    assert!(number(&row(&report, "series", Some(8))["relative_rms"]) <= 1e-12);
    desk.refused("sweep eight.txt -l 2,9 -o other", &["no degree above 8", "`-l`"]);
    desk.refused("sweep eight.txt -l 2 -o other --unit mm", &["--unit"]);
    desk.refused("sweep stone.obj -l 2 -o other --normalisation 4pi", &["--normalisation"]);
}

#[test]
fn bad_input_says_what_and_where() {
    let desk = Desk::new();
    stone(&desk);
    desk.put("room.toml", [ROOM, LAMP, BODY].concat());
    desk.put("other.obj", cube(1.0));
    let says = [
        "room.toml",
        "no [objects.NAME.sh] whose file is other.obj: its `sh` objects are of stone.obj",
    ];
    desk.refused("sweep other.obj -l 2 -o out --scene room.toml", &says);
    // A scene that reads the file otherwise would show another size.
    let inches = [ROOM, LAMP, BODY].concat().replace("degree = 9", "degree = 9\nunit = \"in\"");
    desk.put("inches.toml", inches);
    let says = ["[objects.body.sh] reads its file with unit = \"in\"", "`--unit in`"];
    desk.refused("sweep stone.obj -l 2 -o out --scene inches.toml", &says);
    for words in [
        "sweep stone.obj -l 5..2 -o out",
        "sweep stone.obj -l= -o out",
        "sweep stone.obj -l 2 -o out -D illum.seed=2",
        "sweep stone.obj -l 2 -o out --size 8x8",
        "sweep stone.obj -l 2 -o out --scene room.toml --samples 1",
    ] {
        desk.ends(2, words);
    }
    assert!(!desk.path("out").exists());
}

#[test]
fn names_on_a_page_are_no_markup() {
    let desk = Desk::new();
    let name = "<img src=x onerror=alert(1)>";
    desk.put(&format!("{name}.obj"), cube(1.0));
    let file = format!("{name}.obj");
    desk.done(["sweep", &file, "-l", "2", "-o", "out"]);
    desk.done(["view", &format!("out/{name}-2.txt"), "--mesh", &file, "-o", "one.html"]);
    for page in ["out/index.html", "one.html"] {
        let html = desk.text(page);
        assert!(!html.contains("<img src=x"), "{page}");
        assert!(html.contains("\\u003cimg src=x onerror=alert(1)>"), "{page}");
    }
}

#[test]
fn view_shows_several_shapes_of_one_name() {
    let desk = Desk::new();
    stone(&desk);
    for folder in ["a", "b"] {
        fs::create_dir(desk.path(folder)).expect("made");
        desk.done(format!("fit stone.obj -l 2 -o {folder}/x.txt"));
    }
    let report = desk.json("view a/x.txt b/x.txt -o both.html");
    assert_eq!(report["shapes"].as_array().expect("names").len(), 2);
    assert!(desk.text("both.html").starts_with("<!doctype html>"));
    desk.refused("view a/x.txt b/x.txt -o both.html", &["both.html", "--force"]);
    desk.done("view a/x.txt -o both.html --force");
    desk.refused("view stone.obj -o mesh.html", &["stone.obj"]);
    desk.refused("view a/x.txt -o page.txt", &["page.txt"]);
}

#[test]
fn the_head_costs_what_the_readme_says() {
    let desk = Desk::new();
    let report = desk.json(["sweep", &repository("data/head.obj"), "-l", "32", "-o", "out"]);
    let [series, rival, mesh] = [("series", Some(32)), ("decimated", Some(32)), ("original", None)]
        .map(|(shape, degree)| row(&report, shape, degree));
    assert_eq!((&series["bytes_f32"], &mesh["bytes_f32"]), (&4356.into(), &391_872.into()));
    assert!((number(&series["relative_rms"]) - 0.005_19).abs() <= 0.000_005);
    // At equal bytes the decimated mesh errs 1.7 times as much; compressed, at three times as many.
    assert!(number(&rival["bytes_f32"]) <= 4356.0);
    assert!(number(&rival["relative_rms"]) >= 1.5 * number(&series["relative_rms"]));
    assert!(number(&rival["bytes_compact"]) >= 2.0 * number(&series["bytes_compact"]));
}
