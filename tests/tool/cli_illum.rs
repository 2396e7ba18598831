//! Illuminance as a user meets it: groups with intervals, requirements, known values.

use std::io::Write;

use serde_json::Value;

use crate::common::desk::{Desk, Said};

/// Sobolev's planes with sensors along a line, 64 walks.
const PLANES: &str = r#"format = 1
[materials.half.lambert]
reflectance = 0.5
[objects.floor.plane]
point = [0, 0, 0]
normal = [0, 0, 1]
material = "half"
[objects.ceiling.plane]
point = [0, 0, 1]
normal = [0, 0, -1]
material = "half"
[lights.source.point]
at = [0, 0, 0.5]
intensity = 1
[sensors.radius.line]
from = [0, 0, 0]
to = [1, 0, 0]
normal = [0, 0, 1]
spacing = 0.25
[illum]
seed = 1
stop = { walks = 64 }
"#;

/// A folder with `planes.toml`.
fn desk(more: &str) -> Desk {
    Desk::new().with("planes.toml", format!("{PLANES}{more}"))
}

/// Runs `harmolux illum` with these words more; gives its exit code and all it said.
fn illum(desk: &Desk, words: &[&str]) -> (i32, String) {
    desk.run([&["illum", "planes.toml"], words].concat()).all()
}

/// Returns the report, whether all was met or not.
fn json(desk: &Desk, words: &[&str]) -> Value {
    let said = desk.run([&["illum", "planes.toml"], words, &["--json"]].concat());
    serde_json::from_str(&said.out).expect("valid JSON on stdout, and nothing else")
}

/// Runs `harmolux probe` with this input; gives its exit code and all it said.
fn probe(desk: &Desk, words: &[&str], input: &str) -> (i32, String) {
    let mut child = desk.start([&["probe", "planes.toml"], words].concat());
    child.stdin.take().expect("piped").write_all(input.as_bytes()).expect("it reads");
    Said::of(&child.wait_with_output().expect("it ends")).all()
}

#[test]
fn values_beyond_numbers_are_told_and_null_in_json() {
    let desk = desk("");
    let strong = ["-D", "lights.source.point.intensity=1e300"];
    let (code, said) = illum(&desk, &strong);
    assert!(code == 0 && said.contains("intervals, are beyond what numbers can hold"), "{said}");
    let (code, said) = probe(&desk, &strong, "0 0 0.5  1 0 -1\n");
    assert!(code == 0 && said.contains("intervals, are beyond what numbers can hold"), "{said}");
    let row = &json(&desk, &strong)["rows"][0];
    assert!(row["illuminance_lx"].is_f64() && row["half_width_95_lx"].is_null(), "{row}");
    let (code, said) = illum(&desk, &["-D", "lights.source.point.intensity=1e308"]);
    assert!(code == 3 && said.contains("the flux of light `source` is not finite"), "{said}");
}

#[test]
fn line_of_sensors_stands_beside_the_exact_solution() {
    let desk = desk("[compare]\nradius = \"sobolev\"\n");
    let (code, said) = illum(&desk, &[]);
    assert_eq!(code, 0, "{said}");
    assert!(said.contains("radius: 5 of 5 agree with the exact values"), "{said}");
    let report = json(&desk, &[]);
    let rows = report["rows"].as_array().expect("rows");
    let places: Vec<_> = rows.iter().map(|r| r["x_m"].as_f64()).collect();
    assert_eq!(places, [0.0, 0.25, 0.5, 0.75, 1.0].map(Some));
    // Case A of the reference at r = 0 and 1, to the digits given there.
    let exact = |i: usize| rows[i]["exact_lx"].as_f64().expect("a number");
    assert!(
        (exact(0) - 4.528_129_525_817).abs() <= 1e-12
            && (exact(4) - 0.653_442_317_194).abs() <= 1e-12,
        "{report}"
    );
    assert!(rows.iter().all(|r| r["deviation_in_standard_errors"].is_number()));
}

#[test]
fn lines_are_plotted_and_written() {
    let desk = desk("[compare]\nradius = \"sobolev\"\n");
    let (code, said) = illum(&desk, &["-o", "a.svg", "-o", "a.csv"]);
    assert_eq!(code, 0, "{said}");
    let read = |name: &str| desk.text(name);
    assert!(read("a.svg").contains("radius, exact"));
    assert_eq!(read("a.csv").lines().count(), 6);
    let (code, said) = illum(&desk, &["-o", "a.jpg"]);
    assert!(code == 3 && said.contains(".csv, .npy, .ply, .svg or .png"), "{said}");
    let line =
        "radius.line]\nfrom = [0, 0, 0]\nto = [1, 0, 0]\nnormal = [0, 0, 1]\nspacing = 0.25\n";
    let points = PLANES.replace(line, "foot.points]\nat = [[0, 0, 0]]\nnormal = [0, 0, 1]\n");
    desk.put("planes.toml", points);
    let (code, said) = illum(&desk, &["--plot"]);
    assert!(code == 3 && said.contains("no line of sensors to plot"), "{said}");
}

#[test]
fn wrong_known_values_are_found_out() {
    let (code, said) = illum(&desk("[compare]\nradius = [9, 9, 9, 9, 9]\n"), &[]);
    assert_eq!(code, 4, "{said}");
    assert!(said.contains("NO") && said.contains("0 of 5 agree"), "{said}");
    let (code, said) = illum(&desk("[compare]\nradius = [9, 3]\n"), &[]);
    assert_eq!(code, 3, "{said}");
    assert!(said.contains("24:10: 2 values for the 5 sensors of `radius`"), "{said}");
    let lamp = "lights.spare.point={ at = [0, 0, 0.7], flux = 5 }";
    let (code, said) = illum(&desk("[compare]\nradius = \"sobolev\"\n"), &["-D", lamp]);
    assert!(code == 3 && said.contains("is not Sobolev's problem"), "{said}");
    let off = "sensors.radius.line.from=[0, 0, 0.1]";
    let (code, said) = illum(&desk("[compare]\nradius = \"sobolev\"\n"), &["-D", off]);
    assert!(code == 3 && said.contains("sensor 1 of `radius` is not on a plane"), "{said}");
    let (code, said) = illum(&desk("[compare]\nradius = \"cube\"\n"), &[]);
    assert_eq!(code, 3, "{said}");
    assert!(said.contains("24:10: the scene is not a cube with a lamp in its middle"), "{said}");
}

#[test]
fn probe_sees_a_body_along_the_borders_of_cube_faces() {
    let desk = Desk::new();
    let head = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("data/head.obj");
    let text = format!(
        r#"format = 1
[materials.glow.lambert]
reflectance = 0
exitance = 628.318530717958647
[materials.sky.lambert]
reflectance = 0
exitance = 314.15926535897932
[objects]
sky.sphere = {{ centre = [0, 0, 0], radius = 20, inward = true, material = "sky" }}
ball.sh = {{ file = {head:?}, degree = 0, scale = 8, material = "glow" }}
[illum]
stop = {{ walks = 32 }}
"#
    );
    desk.put("planes.toml", text);
    let rays = "3 3 3 -1 -1 -1\n-3 3 -3 1 -1 1\n3 3 0 -1 -1 0\n0 3 -3 0 -1 1\n3 3 1 -3 -3 -1\n";
    let (code, said) = probe(&desk, &[], rays);
    let seen: Vec<&str> = said.lines().take(5).filter_map(|l| l.split('\t').next()).collect();
    assert_eq!((code, &seen[..]), (0, &["200.0000"; 5][..]), "{said}");
}

#[test]
fn probe_marks_points_outside_the_room_and_refuses_those_in_a_lamp() {
    let desk = desk("");
    let room = "{ min = [-1, -1, 0], max = [1, 1, 1], inward = true, material = \"half\" }";
    let text = desk.text("planes.toml");
    let (before, after) = text.split_once("[objects.floor.plane]").expect("planes");
    let (_, after) = after.split_once("[lights").expect("lights");
    let text = format!("{before}[objects]\nroom.box = {room}\n[lights{after}");
    desk.put("planes.toml", text);
    let input = "0 0 0  0 0 1\n0 0 -0.5  0 0 1\n5 0 0  0 0 1\n";
    let (code, said) = probe(&desk, &["-I"], input);
    let lines: Vec<&str> = said.lines().collect();
    assert_eq!((code, &lines[1..3]), (0, &["NaN\tbehind room"; 2][..]), "{said}");
    assert!(lines[0].starts_with(|c: char| c.is_ascii_digit()), "{said}");
    let words = "warning: 2 of 3 points are outside the room, or inside the object, `room` (the \
                 first is point 2); they measure nothing";
    assert!(said.contains(words), "{said}");
    let (code, said) = probe(&desk, &["-I", "--json"], input);
    let rows: Value = serde_json::from_str(
        said.split("\n64 walks").next().unwrap_or("").split("\nwarning").next().unwrap_or(""),
    )
    .expect("JSON");
    let rows = &rows["rows"];
    assert!(code == 0 && rows[1]["behind"] == "room" && rows[0]["behind"].is_null(), "{said}");
    assert!(rows[1]["value_lx"].is_null() && rows[0]["value_lx"].is_number(), "{said}");
    let (code, said) = probe(&desk, &[], input);
    assert!(
        code == 0 && said.contains("they see it from behind") && !said.contains("NaN"),
        "{said}"
    );
    let (code, said) = probe(&desk, &["-I"], "0 0 0  0 0 1\n0 0 0.5  0 0 1\n");
    assert!(code == 3 && said.contains("stdin: point 2 is where light `source` is"), "{said}");
}

#[test]
fn walls_that_absorb_nothing_are_refused_with_the_reason() {
    for (value, words) in [
        ("materials.half.lambert.reflectance=1", "below 1"),
        ("materials.half.lambert.reflectance=1.5", "below 1"),
    ] {
        let (code, said) = illum(&desk(""), &["-D", value]);
        assert!(code == 3 && said.contains(words) && said.contains("reflectance"), "{said}");
    }
}

#[test]
fn no_time_is_refused_and_too_little_ends_with_4_and_what_was_reached() {
    for time in ["0", "\"0s\"", "-1"] {
        let stop = format!("illum.stop={{ time = {time} }}");
        let (code, said) = illum(&desk(""), &["-D", &stop]);
        assert!(code == 3 && said.contains("must be a time above 0"), "{said}");
    }
    let desk = desk("");
    let stop = "illum.stop={ relative_error = 1e-6, time = 0.2 }";
    let (code, said) = illum(&desk, &["-D", stop, "-o", "lux.csv"]);
    assert_eq!(code, 4, "{said}");
    let told = said.split("target not met: the largest 95 % half width is ").nth(1).expect("said");
    let reached: f64 = told.split(' ').next().and_then(|x| x.parse().ok()).expect("a number");
    assert!(reached > 1e-4 && reached < 100.0, "{said}");
    assert!(told.contains("asked for 0.000100 %") && told.contains("allow more time"), "{said}");
    let written = desk.text("lux.csv");
    assert_eq!(written.lines().count(), 6);
}

#[test]
fn values_have_the_digits_that_their_intervals_justify() {
    let desk = desk("[compare]\nradius = \"sobolev\"\n");
    // Direct light is exact, and four times nothing is known of the rest with 64 walks and 2^18.
    let foot = |words: &[&str]| -> Vec<String> {
        let (_, said) = illum(&desk, words);
        let row = said.lines().find(|line| line.starts_with("| 1 ")).expect("a row").to_owned();
        row.split('|').map(|cell| cell.trim().to_owned()).collect()
    };
    let decimals = |text: &str| text.split_once('.').map_or(0, |(_, after)| after.len());
    for words in [&[][..], &["-D", "illum.stop.walks=65536"]] {
        let row = foot(words);
        let [value, half_width, direct, exact] = [&row[5], &row[6], &row[7], &row[8]];
        assert_eq!(decimals(value), decimals(half_width), "{row:?}");
        assert_eq!(decimals(exact), decimals(value), "{row:?}");
        assert_eq!(direct, "4.000000", "{row:?}");
    }
}

#[test]
fn photons_straight_below_a_lamp_have_an_error() {
    let words =
        ["--estimator", "photon", "-D", "illum.radius=0.1", "-D", "illum.stop.walks=524288"];
    let report = json(&desk(""), &words);
    let half_width = report["rows"][0]["half_width_95_lx"].as_f64().expect("a number");
    // Some 5000 photons of 4.5 lx: 1.4 % is one standard error.
    assert!(half_width > 0.02 && half_width < 0.5, "{report}");
}

#[test]
fn probe_answers_line_by_line() {
    let desk = desk("");
    // The floor at the foot of the source, seen aslant: L = rho E / pi.
    let input = "# seen\n-1 0 1e-3  1 0 -1e-3\n0 0 0.25  0 1 0\n";
    let (code, said) = probe(&desk, &["-D", "illum.stop.walks=4096"], input);
    assert_eq!(code, 0, "{said}");
    let values: Vec<f64> =
        said.lines().filter_map(|line| line.split_once('\t')?.0.parse().ok()).collect();
    assert!((values[0] / (0.5 * 4.528_13 / std::f64::consts::PI) - 1.0).abs() <= 0.01, "{said}");
    assert_eq!(values[1..], [0.0], "{said}");
    let (code, said) = probe(&desk, &["-I", "--json"], "0 0 0  0 0 1\n");
    let rows: Value =
        serde_json::from_str(said.split("\n64 walks").next().unwrap_or("")).expect("JSON");
    assert!(code == 0 && rows["rows"][0]["direct_lx"] == 4.0, "{said}");
    let (code, said) = probe(&desk, &[], "# nothing\n");
    assert!(code == 0 && said.starts_with("no ray was read"), "{said}");
    let (code, said) = probe(&desk, &["-I"], "0 0 0  0 0 1\n0 0 zero\n");
    assert!(code == 3 && said.contains("stdin:2: "), "{said}");
}

#[test]
fn requirements_are_met_not_met_or_undecided() {
    let cases = [
        ("mean_min = 1", 0, "mean >= 1: met"),
        ("largest_max = 4", 4, "largest <= 4: NOT MET"),
        ("uniformity_min = 0.9", 4, "U0 >= 0.9: NOT MET"),
        ("least_min = 0.65", 4, "least >= 0.65: UNDECIDED"),
    ];
    for (require, expected, words) in cases {
        let (code, said) = illum(&desk(&format!("[require]\nradius = {{ {require} }}\n")), &[]);
        assert_eq!(code, expected, "{said}");
        assert!(said.contains(&format!("radius: required {words}")), "{said}");
    }
    let desk = desk("[require]\nradius = { mean_min = 1, mean_max = 1.5 }\n");
    let group = &json(&desk, &[])["groups"][0];
    let verdicts: Vec<_> = group["requirements"]
        .as_array()
        .expect("a list")
        .iter()
        .map(|r| r["verdict"].as_str().expect("a word").to_owned())
        .collect();
    assert_eq!(verdicts, ["met", "not met"], "{group}");
    let [low, high] = ["low_95", "high_95"].map(|end| group["mean_lx"][end].as_f64());
    assert!(low < high && low > Some(2.0), "{group}");
}

/// Sobolev's planes as discs of radius 5.
fn discs(more: &str) -> Desk {
    let plane = |name: &str, z: u8, to: i8| {
        (
            format!("[objects.{name}.plane]\npoint = [0, 0, {z}]\nnormal = [0, 0, {to}]\n"),
            format!(
                "[objects.{name}.disc]\ncentre = [0, 0, {z}]\nnormal = [0, 0, {to}]\nradius = 5\n"
            ),
        )
    };
    let pairs = [plane("floor", 0, 1), plane("ceiling", 1, -1)];
    let text = pairs.iter().fold(PLANES.to_owned(), |text, (from, to)| {
        assert!(text.contains(from), "{from}");
        text.replace(from, to)
    });
    let desk = desk("");
    desk.put("planes.toml", format!("{text}{more}"));
    desk
}

#[test]
fn radiosity_claims_no_error() {
    let desk = discs("patches = 500\n[require]\nradius = { mean_min = 1, mean_max = 1.5 }\n");
    let words = ["--estimator", "radiosity", "-D", "illum.stop.relative_error=0.01"];
    let (code, said) = illum(&desk, &words);
    // 4 for what is required; a target error is no matter where none is known.
    assert_eq!(code, 4, "{said}");
    assert!(said.contains("| 4.525 |  -     |") || said.contains("- |"), "{said}");
    assert!(said.contains("mean >= 1: met by the value, whose error is not known"), "{said}");
    assert!(said.contains("mean <= 1.5: NOT MET by the value"), "{said}");
    assert!(said.contains("radiosity gives no error") && said.contains("506 patches"), "{said}");
    assert!(!said.contains("target not met") && !said.contains("NaN"), "{said}");
    let report = json(&desk, &words);
    // The exact value for discs of radius 5 at the foot of the source.
    let row = &report["rows"][0];
    let found = row["illuminance_lx"].as_f64().expect("a number");
    assert!((found - 4.527_821_817_2).abs() <= 5e-3, "{row}");
    let unknown = ["half_width_95_lx", "standard_error_lx", "deviation_in_standard_errors"];
    assert!(unknown.iter().all(|key| row[key].is_null()), "{row}");
    let mean = &report["groups"][0]["mean_lx"];
    assert!(mean["value"].is_number() && mean["low_95"].is_null(), "{mean}");
    assert!(report["ending"] == "converged" && report["walks"].is_null(), "{report}");
    assert_eq!(report["radiosity"]["patches"], 506);
}

#[test]
fn known_values_stand_beside_radiosity_unjudged() {
    let desk = discs("[compare]\nradius = [4.5278, 3.3672, 1.86, 1.05, 0.6531]\n");
    let (code, said) = illum(&desk, &["--estimator", "radiosity", "--quick"]);
    assert_eq!(code, 0, "{said}");
    assert!(said.contains("not judged against the exact values, as no error is known"), "{said}");
}

#[test]
fn every_estimator_has_a_name_in_the_scene_and_on_the_command_line() {
    for name in ["local", "path", "photon", "radiosity"] {
        let (code, said) = illum(&discs(""), &["--estimator", name]);
        assert_eq!(code, 0, "{name}: {said}");
        let in_scene = format!("illum.estimator={name}");
        assert_eq!(illum(&discs(""), &["-D", &in_scene]).0, 0, "{name}");
    }
    let (code, said) = illum(&discs(""), &["--estimator", "radiosty"]);
    assert!(code == 2 && said.contains("radiosity"), "{said}");
}

#[test]
fn what_a_baseline_cannot_do_is_said() {
    let desk = desk("");
    let (code, said) = illum(&desk, &["--estimator", "radiosity"]);
    assert!(
        code == 3 && said.contains("is infinite") && said.contains("disc or a rectangle"),
        "{said}"
    );
    let (code, said) = illum(&desk, &["--estimator", "photon"]);
    assert!(code == 3 && said.contains("set `radius` in [illum]"), "{said}");
    let (code, said) = illum(&desk, &["--estimator", "photon", "-D", "illum.radius=0.1"]);
    assert_eq!(code, 0, "{said}");
    for (value, words) in [
        ("illum.patches=0", "must be a whole number from 1 to 100000, found 0"),
        ("illum.patches=1e6", "must be a whole number from 1 to 100000"),
        ("illum.radius=0", "must be above 0 and at most 1e9 metres, found 0"),
        ("illum.estimator=radiance", "radiance"),
    ] {
        let (code, said) = illum(&desk, &["-D", value]);
        assert!(code == 3 && said.contains(words), "{value}: {said}");
    }
}
