//! The tool as a user meets it: what all verbs have in common, and each verb once.

use std::fs;
use std::process::Stdio;

use harmolux::io::coefficients::{self, ReadOptions};
use harmolux::io::images::Exr;
use serde_json::Value;

use crate::common::desk::{Desk, Said, assert_says, repository};
use crate::common::scenes::{CAMERA, LAMP, ROOM};
use crate::common::solids::{cube, u_shape};

/// A second body.
const CRATE: &str = r#"[objects.crate.box]
min = [2.5, 3, 0.2]
max = [3.5, 4, 1.2]
material = "grey"
"#;

/// What is measured, and how much.
const MEASURED: &str = r#"[sensors.floor.grid]
on = "room.z_min"
border = 0.5
count = [3, 1]
[sensors.spots.points]
at = [[1, 1, 0], [3, 1, 0]]
normal = [0, 0, 1]
[render]
seed = 1
stop = { walks = 16 }
[illum]
seed = 1
stop = { walks = 64 }
"#;

/// A room with a crate, a lamp, a camera of 16 x 12 pixels and five sensors: nothing is fitted, so
/// all runs are short.
fn room() -> String {
    [ROOM, CRATE, LAMP, CAMERA, "resolution = [16, 12]\n", MEASURED].concat()
}

/// The stop that makes renders of the repository's own scene short.
const SHORT: [&str; 4] = ["--size", "16x12", "-D", "render.stop={walks=64}"];

fn head_room() -> String {
    repository("data/scenes/head_room.toml")
}

/// A folder with `room.toml`.
fn desk_with_room() -> Desk {
    Desk::new().with("room.toml", room())
}

/// Rejects the room with `from` replaced by `to`.
fn refused_room(desk: &Desk, verb: &str, [from, to]: [&str; 2], words: &[&str]) {
    let room = room();
    assert!(room.contains(from), "{from}");
    desk.put("changed.toml", room.replacen(from, to, 1));
    desk.refused([verb, "changed.toml"], words);
}

/// Rejects a mesh for each verb that shapes it.
fn refused_mesh(desk: &Desk, mesh: &str, words: &[&str]) {
    desk.refused(["fit", mesh, "-l", "2", "-o", "out.txt"], words);
    desk.refused(["sweep", mesh, "-l", "2", "-o", "out"], words);
}

// Renders.

#[test]
fn head_room_renders_to_png_and_exr_with_a_full_report_again_and_again() {
    let desk = Desk::new();
    for _ in 0..2 {
        let again = ["render", &head_room(), "--force"];
        let output = desk.done(again.into_iter().chain(SHORT));
        assert_says(
            &output.out,
            &[
                "degree 32, 1089 coefficients",
                "4 356 B against 587 796 B of the mesh",
                "error of the fit  RMS 0.519 %, largest",
                "image             16 x 12, mean",
                "walks             64 per pixel in 2 replicates",
                "time  ",
                "relative error  ",
                "head_room.png",
                "head_room.exr",
            ],
        );
        assert_says(&output.err, &["fitted `head`: degree 32", "exposure"]);
        assert!(!output.err.contains("warning"), "{}", output.err);
    }
    assert!(desk.bytes("head_room.png").starts_with(b"\x89PNG\r\n\x1a\n"));
    assert_eq!(desk.content().len(), 2);
}

#[test]
fn json_report_of_a_render_has_the_same_numbers() {
    let desk = Desk::new();
    let report = desk.json(["render", &head_room()].into_iter().chain(SHORT));
    let head = &report["objects"][0];
    assert_eq!(head["name"], "head");
    assert_eq!((&head["degree"], &head["coefficients"]), (&32.into(), &1089.into()));
    assert_eq!((&head["bytes"], &head["mesh_bytes"]), (&4356.into(), &587_796.into()));
    // The README's 0.519 %, to its last digit.
    let rms = head["relative_rms"].as_f64().expect("a number");
    assert!((rms - 0.005_19).abs() <= 0.000_005, "{rms}");
    assert_eq!(report["resolution"], serde_json::json!([16, 12]));
    assert_eq!((&report["walks_per_pixel"], &report["replicates"]), (&64.into(), &2.into()));
    assert_eq!((&report["ending"], &report["non_finite_samples"]), (&"walks".into(), &0.into()));
    assert_eq!(report["written"], serde_json::json!(["head_room.png", "head_room.exr"]));
    for name in
        ["mean_luminance", "mean_luminance_standard_error", "median_relative_error", "seconds"]
    {
        assert!(report[name].as_f64().is_some_and(|x| x > 0.0), "{name}: {report}");
    }
}

#[test]
fn exr_holds_colour_luminance_and_its_standard_error() {
    let desk = desk_with_room();
    let report = desk.json(["render", "room.toml", "-o", "a.exr", "--layers", "none"]);
    let image = Exr::read(&desk.path("a.exr")).expect("readable");
    assert_eq!((image.width(), image.height()), (16, 12));
    assert!(image.channel_names().eq(["B", "G", "R", "luminance.Y", "stderr.Y"]));
    let channel = |name| image.channel(name).expect("there");
    let mean = channel("luminance.Y").iter().map(|y| f64::from(*y)).sum::<f64>() / (16.0 * 12.0);
    let said = report["mean_luminance"].as_f64().expect("a number");
    // f32 keeps seven digits.
    assert!((mean - said).abs() <= 1e-6 * said, "{mean} {said}");
    assert!(channel("stderr.Y").iter().all(|e| *e >= 0.0));
    for (name, value) in [("scene", "room.toml"), ("seed", "1"), ("unit", "cd/m2")] {
        assert_eq!(image.attribute(name), Some(&value.into()), "{name}");
    }
}

#[test]
fn same_seed_gives_the_same_bytes_on_any_number_of_threads() {
    let desk = Desk::new();
    let scene = head_room();
    let picture = |seed: &str, threads: &str| {
        let more = ["--seed", seed, "-j", threads, "-D", "objects.head.sh.degree=4", "--force"];
        desk.done(["render", &scene].into_iter().chain(SHORT).chain(more));
        [desk.bytes("head_room.png"), desk.bytes("head_room.exr")]
    };
    let first = picture("7", "1");
    assert!(first == picture("7", "2"), "the number of threads changed the picture");
    let other = picture("8", "2");
    assert!(first[0] != other[0] && first[1] != other[1], "the seed did not change the picture");
}

#[test]
fn named_outputs_and_a_quick_look_replace_the_defaults() {
    let desk = desk_with_room();
    let report = desk.json(["render", "room.toml", "-o", "look.PNG", "--quick"]);
    assert_eq!(report["resolution"], serde_json::json!([8, 6]));
    assert_eq!(report["written"], serde_json::json!(["look.PNG"]));
    assert_eq!(desk.content().len(), 2);
}

#[test]
fn override_changes_the_light() {
    let desk = desk_with_room();
    let mean = |intensity: &str| {
        let define = format!("lights.lamp.point.intensity={intensity}");
        let report = desk.json(["render", "room.toml", "--force", "-D", &define]);
        report["mean_luminance"].as_f64().expect("a number")
    };
    let [one, two] = [mean("100"), mean("200")];
    // The same walks with twice the light: equal to rounding.
    assert!((two - 2.0 * one).abs() <= 1e-12 * two, "{one} {two}");
}

// Illuminance.

#[test]
fn illum_prints_a_table_for_each_group_and_writes_csv() {
    let desk = desk_with_room();
    for _ in 0..2 {
        let output = desk.done(["illum", "room.toml", "-o", "lux.csv", "--force"]);
        assert_says(
            &output.out,
            &["| floor |", "| spots |", "E lx", "± 95 %", "direct lx", "floor: mean", "floor: U0 "],
        );
        assert_says(&output.err, &["64 walks in"]);
    }
    let csv = desk.text("lux.csv");
    let mut lines = csv.lines();
    assert_eq!(
        lines.next(),
        Some(
            "group,x_m,y_m,z_m,normal_x,normal_y,normal_z,illuminance_lx,half_width_95_lx,\
             standard_error_lx,direct_lx,non_finite_samples,exact_lx,\
             deviation_in_standard_errors,behind"
        )
    );
    let groups: Vec<&str> = lines.filter_map(|l| l.split(',').next()).collect();
    assert_eq!(groups, ["floor", "floor", "floor", "spots", "spots"]);
}

#[test]
fn json_of_illum_has_a_row_for_each_sensor() {
    let desk = desk_with_room();
    let report = desk.json(["illum", "room.toml"]);
    let rows = report["rows"].as_array().expect("rows");
    assert_eq!(rows.len(), 5);
    // Straight below the lamp at 1.5 m to one side: E = I h / d^3, without any walk.
    let spot = rows.iter().find(|r| r["group"] == "spots").expect("a spot");
    let direct = spot["direct_lx"].as_f64().expect("a number");
    assert!((direct - 100.0 / 6.25).abs() <= 1e-9, "{direct}");
    for row in rows {
        let number = |name: &str| row[name].as_f64().unwrap_or(f64::NAN);
        assert!(number("illuminance_lx") > 0.0, "{row}");
        assert!(number("half_width_95_lx") > number("standard_error_lx"), "{row}");
    }
    assert_eq!(desk.content().len(), 1, "nothing is written without -o");
}

// Coefficients.

#[test]
fn fitted_coefficients_are_described_and_stand_in_a_scene() {
    let desk = Desk::new();
    let fit = ["fit", &repository("data/head.obj"), "-l", "8", "-o", "head.txt", "--force"];
    assert_says(&desk.done(fit).out, &["8, 81 coefficients", "324 B in f32", "RMS error"]);
    assert_says(&desk.done(["info", "head.txt"]).out, &["degree       8, 81", "head.obj"]);
    let [fitted, held] = [desk.json(fit), desk.json(["info", "head.txt"])];
    for name in ["degree", "coefficients", "bytes", "centre", "mean_radius"] {
        assert_eq!(fitted[name], held[name], "{name}");
    }
    let head = "[objects.head.sh]\nfile = \"head.txt\"\ndegree = 8\nat = [1.5, 3, 1.5]\n\
                scale = 5\nmaterial = \"grey\"\n";
    desk.put("room.toml", room() + head);
    let with_head = desk.done(["render", "room.toml", "-o", "a.exr"]);
    assert!(!with_head.err.contains("warning"), "{}", with_head.err);
    desk.put("room.toml", room());
    desk.done(["render", "room.toml", "-o", "b.exr"]);
    assert!(desk.bytes("a.exr") != desk.bytes("b.exr"), "the head is not to be seen");
}

#[test]
fn grid_projection_comes_close_to_the_conforming_one() {
    let desk = Desk::new();
    let head = repository("data/head.obj");
    desk.done(["fit", &head, "-l", "4", "-o", "a.txt"]);
    let finer = ["--projection", "grid", "--oversampling", "16"];
    desk.done(["fit", &head, "-l", "4", "-o", "b.txt"].into_iter().chain(finer));
    let read = |name| {
        coefficients::read(&desk.path(name), &ReadOptions::default())
            .expect("readable")
            .coefficients
    };
    let [a, b] = [read("a.txt"), read("b.txt")];
    for (l, m) in (0..=4).flat_map(|l| (0..=l).map(move |m| (l, m))) {
        let (one, other) = (a.get(l, m), b.get(l, m));
        // The grid of about 80 x 160 rays aliases the faces' edges to some 1e-4 of the mean radius.
        let error = (one.0 - other.0).hypot(one.1 - other.1) / a.mean();
        assert!(error <= 1e-3, "degree {l}, order {m}: {error}");
    }
}

#[test]
fn unit_and_centre_of_a_mesh_are_heeded() {
    let desk = Desk::new();
    desk.put("metres.obj", cube(1.0));
    desk.put("millimetres.obj", cube(1000.0));
    let a = desk.json(["fit", "metres.obj", "-l", "4", "-o", "a.txt"]);
    let b = desk.json(["fit", "millimetres.obj", "-l", "4", "-o", "b.txt", "--unit", "mm"]);
    let number = |v: &Value, name: &str| v[name].as_f64().expect("a number");
    for name in ["mean_radius", "rms", "clearance"] {
        let [a, b] = [&a, &b].map(|v| number(v, name));
        assert!((a - b).abs() <= 1e-9 * a, "{name}: {a} {b}");
    }
    assert!((number(&a, "clearance") - 1.0).abs() <= 1e-12, "{a}");
    let centre = ["--centre", "-0.25,0,0.5"];
    let off = desk.json(["fit", "metres.obj", "-l", "4", "-o", "c.txt"].into_iter().chain(centre));
    assert_eq!(off["centre"], serde_json::json!([-0.25, 0.0, 0.5]));
    assert_eq!(desk.json(["info", "c.txt"])["centre"], off["centre"]);
}

#[test]
fn info_describes_meshes_with_their_faults() {
    let desk = Desk::new();
    desk.put("u.obj", u_shape());
    let u = desk.json(["info", "u.obj"]);
    assert_eq!((&u["closed"], &u["euler"], &u["vertices"]), (&true.into(), &2.into(), &16.into()));
    let [volume, clearance] = [&u["volume"], &u["star"]["best_clearance"]].map(Value::as_f64);
    // A base of 3 x 1 and two arms of 1 x 2, one high.
    assert!(volume.is_some_and(|v| (v - 7.0).abs() <= 1e-12), "{u}");
    assert!(clearance.is_some_and(|c| c < 0.0), "{u}");
    desk.put("open.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    assert_says(&desk.done(["info", "open.obj"]).out, &["closed            no", "3 edges"]);
}

// Wrong command lines.

#[test]
fn wrong_command_lines_end_with_2_and_show_the_usage() {
    let desk = desk_with_room();
    let wrong: [&[&str]; 10] = [
        &["paint"],
        &["render"],
        &["render", "room.toml", "--size", "320"],
        &["render", "room.toml", "--size", "0x3"],
        &["render", "room.toml", "--seed", "-1"],
        &["render", "room.toml", "-j", "0"],
        &["fit", "a.obj", "-o", "a.txt"],
        &["fit", "a.obj", "-l", "9999", "-o", "a.txt"],
        &["fit", "a.obj", "-l", "2", "-o", "a.txt", "--unit", "furlong"],
        &["sweep", "a.obj", "-l", "5..2", "-o", "out"],
    ];
    let before = desk.content();
    for arguments in wrong {
        let output = desk.run(arguments);
        assert_eq!(output.code, 2, "{arguments:?}: {}", output.err);
        assert_says(&output.err, &["--help"]);
        assert_eq!(output.out, "", "{arguments:?}");
    }
    assert!(desk.content() == before);
}

// Bad meshes.

#[test]
fn missing_mesh_is_named() {
    let desk = Desk::new();
    refused_mesh(&desk, "none.obj", &["none.obj: cannot read"]);
    desk.refused(["info", "none.obj"], &["none.obj: cannot read"]);
}

#[test]
fn empty_mesh_is_explained() {
    let desk = Desk::new();
    desk.put("empty.obj", "");
    refused_mesh(&desk, "empty.obj", &["empty.obj: no vertices and no faces", "help: "]);
}

#[test]
fn vertex_that_is_not_a_number_is_located() {
    let desk = Desk::new();
    desk.put("bad.obj", "# a tetrahedron\nv 0 0 0\nv 1 nan 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\n");
    refused_mesh(&desk, "bad.obj", &["bad.obj:3: vertex 2 is at", "not finite"]);
}

#[test]
fn open_mesh_is_refused_with_the_number_of_its_boundary_edges() {
    let desk = Desk::new();
    let cube = cube(1.0);
    let (open, _) = cube.trim_end().rsplit_once('\n').expect("several lines");
    desk.put("open.obj", open);
    refused_mesh(
        &desk,
        "open.obj",
        &["open.obj: ", "4 edges have one face only", "fill the holes"],
    );
}

#[test]
fn mesh_that_no_point_sees_is_refused_with_the_share_the_worst_face_and_the_best_centre() {
    let desk = Desk::new();
    desk.put("u.obj", u_shape());
    let words = [
        "u.obj: the mesh is not star-shaped about",
        "% of the area",
        "the worst is face ",
        "no centre sees all of it; the best, [",
    ];
    refused_mesh(&desk, "u.obj", &words);
}

#[test]
fn centre_that_does_not_see_all_is_answered_with_one_that_does() {
    let desk = Desk::new();
    desk.put("cube.obj", cube(1.0));
    desk.refused(
        ["fit", "cube.obj", "-l", "2", "-o", "a.txt", "--centre", "3,0,0"],
        &["not star-shaped about [3.0", "it is star-shaped about [", "expand about that centre"],
    );
}

// Bad scenes.

#[test]
fn misspelt_key_is_answered() {
    let desk = Desk::new();
    desk.put("room.toml", "format = 1\n[materials.walls.lambert]\nreflectence = 0.5\n");
    let answer = "error: room.toml:3:1: unknown key `reflectence` in [materials.walls.lambert]\n  \
                  help: did you mean `reflectance`?\n";
    assert_eq!(desk.ends(3, "illum room.toml").err, answer);
}

#[test]
fn unknown_material_is_located_and_the_nearest_is_named() {
    let change = ["material = \"grey\"", "material = \"gray\""];
    let words = ["changed.toml:8:12: unknown material `gray`", "did you mean `grey`?"];
    for verb in ["render", "illum"] {
        refused_room(&Desk::new(), verb, change, &words);
    }
}

#[test]
fn missing_scene_and_what_is_no_scene_are_named() {
    let desk = Desk::new();
    desk.refused(["render", "none.toml"], &["none.toml: cannot read"]);
    desk.put("cube.toml", cube(1.0));
    desk.refused(["render", "cube.toml"], &["cube.toml:1:", "not valid TOML", "help: "]);
}

#[test]
fn missing_mesh_of_a_scene_is_located() {
    let head = "[objects.head.sh]\nfile = \"none.obj\"\ndegree = 4\nmaterial = \"grey\"\n[render]";
    refused_room(
        &Desk::new(),
        "render",
        ["[render]", head],
        &["changed.toml:29:8: none.obj: cannot"],
    );
}

#[test]
fn unfit_mesh_of_a_scene_is_located() {
    let desk = Desk::new();
    desk.put("u.obj", u_shape());
    let head = "[objects.u.sh]\nfile = \"u.obj\"\ndegree = 4\nmaterial = \"grey\"\n[render]";
    let words = ["changed.toml:29:8: u.obj: the mesh is not star-shaped"];
    refused_room(&desk, "render", ["[render]", head], &words);
}

#[test]
fn light_inside_an_object_is_located() {
    let words = ["changed.toml:14:6: light `lamp`", "behind the surface of `crate`", "help: "];
    refused_room(&Desk::new(), "illum", ["[1, 1, 2.5]", "[3, 3.5, 0.7]"], &words);
}

#[test]
fn light_outside_the_room_is_located_on_every_side() {
    let desk = Desk::new();
    let sides = ["[9, 2, 1]", "[-9, 2, 1]", "[2, 19, 1]", "[2, -9, 1]", "[2, 2, 9]", "[2, 2, -9]"];
    for side in sides {
        let words = ["changed.toml:14:6: light `lamp` is behind the surface of `room`", "`room`"];
        refused_room(&desk, "render", ["[1, 1, 2.5]", side], &words);
    }
}

#[test]
fn scene_without_light_camera_or_sensors_says_so() {
    let desk = Desk::new();
    let without = |headers: &[&str]| {
        let keep = |part: &&str| !headers.iter().any(|h| part.starts_with(h));
        room().split("\n[").filter(keep).collect::<Vec<_>>().join("\n[")
    };
    desk.put("dark.toml", without(&["lights"]));
    desk.refused(["render", "dark.toml"], &["dark.toml", "no light", "lights.NAME.point"]);
    desk.refused(["illum", "dark.toml"], &["dark.toml", "no light", "lights.NAME.point"]);
    desk.put("blind.toml", without(&["cameras"]));
    desk.refused(["render", "blind.toml"], &["blind.toml", "no camera", "[cameras."]);
    desk.put("deaf.toml", without(&["sensors"]));
    desk.refused(["illum", "deaf.toml"], &["deaf.toml", "no sensors", "[sensors."]);
}

#[test]
fn malformed_and_unknown_overrides_are_named() {
    let desk = desk_with_room();
    for (define, words) in [
        ("render.stop", ["-D render.stop: has no `=`", "KEY=VALUE"]),
        ("lights.lamp.point.at=[1, 2", ["-D lights.lamp.point.at=[1, 2: ", "not valid TOML"]),
        ("lights.lamp.point.intensty=9", ["-D lights.lamp.point.intensty: ", "`intensity`?"]),
        ("lights.lmap.point.intensity=9", ["-D lights.lmap.point.intensity: ", "`lamp`?"]),
        ("lights.lamp.point.intensity=-9", ["-D lights.lamp.point.intensity: ", "above 0"]),
        ("lights.lamp.point.at=[3, 3.5, 0.7]", ["-D lights.lamp.point.at: ", "`crate`"]),
    ] {
        for verb in ["render", "illum"] {
            desk.refused([verb, "room.toml", "-D", define], &words);
        }
    }
}

// Outputs that cannot be.

#[test]
fn output_in_a_missing_folder_is_refused() {
    let desk = desk_with_room();
    desk.put("cube.obj", cube(1.0));
    let words = ["there is no folder none"];
    desk.refused(["render", "room.toml", "-o", "none/a.png"], &words);
    desk.refused(["illum", "room.toml", "-o", "none/a.csv"], &words);
    desk.refused(["fit", "cube.obj", "-l", "2", "-o", "none/a.txt"], &words);
}

#[test]
fn wrong_extension_is_refused_with_a_better_name() {
    let desk = desk_with_room();
    desk.put("cube.obj", cube(1.0));
    desk.refused(["render", "room.toml", "-o", "a.jpg"], &["a.jpg: ", ".png or .exr"]);
    desk.refused(
        ["illum", "room.toml", "-o", "a.txt"],
        &["a.txt: ", "name a file .csv, .npy, .ply, .svg or .png"],
    );
    desk.refused(["fit", "cube.obj", "-l", "2", "-o", "a.obj"], &["a.obj: ", "name it a.txt"]);
}

#[test]
fn file_that_is_there_is_replaced_only_by_force() {
    let desk = desk_with_room();
    desk.put("cube.obj", cube(1.0));
    for (name, mut arguments) in [
        ("room.png", vec!["render", "room.toml"]),
        ("a.exr", vec!["render", "room.toml", "-o", "a.exr"]),
        ("a.csv", vec!["illum", "room.toml", "-o", "a.csv"]),
        ("a.txt", vec!["fit", "cube.obj", "-l", "2", "-o", "a.txt"]),
        ("sweep.csv", vec!["sweep", "cube.obj", "-l", "2", "-o", "."]),
    ] {
        // Rows are added to a table of its own, so that another's is told apart.
        let is_table = arguments[0] == "sweep";
        let why = if is_table { "not written by this program" } else { "is there already" };
        desk.put(name, "another's");
        desk.refused(&arguments, &[name, why, "--force"]);
        desk.done([&arguments[..], &["--force"]].concat());
        assert!(desk.bytes(name) != b"another's", "{name} is as it was");
        // Its own result may have cost a night, or have got rows since: it stays as well.
        fs::remove_file(desk.path(name)).expect("removed");
        arguments.push("--force");
        desk.done(&arguments);
        arguments.pop();
        if is_table {
            // It goes on, and draws its figure again.
            desk.done(&arguments);
        } else {
            desk.refused(&arguments, &["this file is there already"]);
        }
    }
}

// Warnings.

/// Runs a render of the room with one override and gives what it says on stderr.
fn warnings(desk: &Desk, define: &str) -> String {
    desk.done(["render", "room.toml", "--force", "-D", define]).err
}

#[test]
fn objects_that_cut_a_wall_or_lie_outside_are_warned_of() {
    let desk = Desk::new();
    let scene = repository("data/scenes/paper_figure_3.toml");
    let said = |at: &str| {
        let at = format!("objects.head.sh.at={at}");
        let more = ["-D", &at, "-D", "objects.head.sh.degree=2", "--force"];
        desk.done(["render", &scene].into_iter().chain(SHORT).chain(more)).err
    };
    for at in ["[0.3, 3, 1.25]", "[3.7, 3, 1.25]"] {
        assert_says(&said(at), &["warning: object `head` cuts through `room`: about "]);
    }
    for at in ["[-9, 3, 1.25]", "[19, 3, 1.25]"] {
        assert_says(&said(at), &["warning: object `head` is entirely outside the room"]);
    }
    assert!(!said("[2.1, 3, 1.25]").contains("warning"));
}

#[test]
fn camera_outside_the_room_or_inside_an_object_is_warned_of() {
    let desk = desk_with_room();
    for (from, solid) in
        [("[-2, 2, 1]", "`room`"), ("[9, 2, 1]", "`room`"), ("[3, 3.5, 0.7]", "`crate`")]
    {
        let said = warnings(&desk, &format!("cameras.main.perspective.from={from}"));
        assert_says(&said, &["warning: camera `main` is outside the room", solid]);
    }
}

#[test]
fn hidden_sensors_are_warned_of_marked_and_do_not_count() {
    let desk = desk_with_room();
    let define = "sensors.spots.points.at=[[1, 1, 0], [3, 3.5, 0.7], [9, 1, 0]]";
    let output = desk.done(["illum", "room.toml", "-D", define]);
    assert_says(&output.err, &["warning: sensors `spots`: 1 of 3 are", "`crate`", "`room`"]);
    let said = output.out;
    assert_says(
        &said,
        &["behind crate", "behind room", "spots: 1 of 3 sensors count, 2 are behind"],
    );
    // With one sensor left its uniformity is 1.
    assert_says(&said, &["spots: U0 1.000000 (1.000000 to 1.000000)"]);
    let report = desk.json(["illum", "room.toml", "-D", define]);
    let behind: Vec<_> =
        report["rows"].as_array().expect("rows").iter().map(|r| &r["behind"]).collect();
    assert_eq!(behind[3..], [&Value::Null, &Value::from("crate"), &Value::from("room")]);
    assert_eq!(report["groups"][1]["behind"], 2);
    // Where all are hidden the run ends by itself, and says so.
    let dark =
        desk.text("room.toml").replace("at = [[1, 1, 0], [3, 1, 0]]", "at = [[3, 3.5, 0.7]]");
    let dark = dark
        .replace("[sensors.floor.grid]\non = \"room.z_min\"\nborder = 0.5\ncount = [3, 1]\n", "");
    desk.put("dark.toml", &dark);
    let stop = "illum.stop={ relative_error = 0.01 }";
    let output = desk.done(["illum", "dark.toml", "-D", stop]);
    assert_says(&output.err, &["no light came to any of them"]);
}

#[test]
fn light_that_leaves_an_open_scene_is_warned_of() {
    let desk = desk_with_room();
    let open =
        "{ corner = [0, 0, 0], edge_u = [4, 0, 0], edge_v = [0, 5, 0], material = \"grey\" }";
    desk.put("room.toml", room().replace("on = \"room.z_min\"\nborder = 0.5", "height = 0.5"));
    let text = desk.text("room.toml");
    let (before, after) = text.split_once("[objects.room.box]").expect("a room");
    let (_, after) = after.split_once("\n[").expect("its end");
    desk.put("room.toml", format!("{before}[objects]\nfloor.rectangle = {open}\n[{after}"));
    let said = desk.done(["render", "room.toml", "--force"]).err;
    assert_says(&said, &["warning: ", "% of the light left the scene"]);
}

// Endings.

#[test]
fn target_that_is_not_met_ends_with_4_and_still_writes() {
    let desk = desk_with_room();
    let stop = |verb: &str| format!("{verb}.stop={{relative_error=1e-6, walks=16}}");
    for (verb, file) in [("render", "a.png"), ("illum", "a.csv")] {
        let output = desk.run([verb, "room.toml", "-o", file, "-D", &stop(verb)]);
        assert_eq!(output.code, 4, "{}", output.err);
        assert_says(&output.err, &["warning: target not met: "]);
        assert!(!desk.bytes(file).is_empty());
    }
}

#[test]
fn target_that_is_met_ends_with_0() {
    let desk = desk_with_room();
    let stop = "illum.stop={relative_error=0.5, walks=1000000}";
    let output = desk.done(["illum", "room.toml", "-D", stop]);
    assert!(!output.err.contains("not met"), "{}", output.err);
}

#[cfg(unix)]
mod interrupts {
    use super::*;
    use crate::common::desk::interrupt;
    use crate::common::running::Running;
    use std::thread::sleep;
    use std::time::Duration;

    /// Starts the tool, interrupts it when it has come to its long run, and waits for its end.
    fn interrupted(desk: &Desk, arguments: &[&str]) -> Said {
        let mut run = Running::start(&mut desk.command(arguments));
        // Far longer than the 0.02 s that reading the room takes, far shorter than the run.
        sleep(Duration::from_secs(1));
        run.send(interrupt());
        run.end()
    }

    #[test]
    fn interrupted_render_saves_the_picture_so_far() {
        let desk = desk_with_room();
        let walks = "render.stop={walks=10000000}";
        let said = interrupted(&desk, &["render", "room.toml", "-j", "1", "-D", walks]);
        assert_eq!(said.code, 130, "{}", said.err);
        assert_says(&said.err, &["warning: interrupted: the files hold the picture so far"]);
        assert!(!desk.path("room.exr").exists(), "what is unfinished takes no place");
        let image = Exr::read(&desk.path("room.unfinished.exr")).expect("readable");
        assert!(image.channel("luminance.Y").is_some_and(|y| y.iter().any(|v| *v > 0.0)));
        let png = desk.bytes("room.unfinished.png");
        assert!(png.ends_with(b"IEND\xaeB`\x82"), "the PNG is cut short");
    }

    #[test]
    fn interrupted_illum_saves_the_values_so_far() {
        let desk = desk_with_room();
        let walks = "illum.stop={walks=1000000000000}";
        let arguments = ["illum", "room.toml", "-j", "1", "-o", "a.csv", "-D", walks];
        let said = interrupted(&desk, &arguments);
        assert_eq!(said.code, 130, "{}", said.err);
        assert_says(&said.err, &["written a.unfinished.csv"]);
        let table = desk.text("a.unfinished.csv");
        assert_eq!(table.lines().count(), 6, "a header and five sensors");
        assert!(!desk.path("a.csv").exists(), "what is unfinished takes no place");
    }
}

#[cfg(unix)]
#[test]
fn reader_that_leaves_early_is_no_failure() {
    let desk = desk_with_room();
    let mut command = desk.command(["info", "cube.obj"]);
    desk.put("cube.obj", cube(1.0));
    let mut child =
        command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().expect("the tool starts");
    drop(child.stdout.take());
    let output = Said::of(&child.wait_with_output().expect("a child"));
    assert!(!output.err.contains("panicked"), "{}", output.err);
}

// First contact.

#[test]
fn the_tool_alone_says_what_to_try() {
    let desk = Desk::new();
    let page = desk.done("").out;
    let tried: Vec<&str> = page.lines().filter(|line| line.starts_with("  harmolux ")).collect();
    assert_eq!(tried.len(), 3, "{page}");
    assert_says(&page, &["harmolux --help"]);
    assert_says(&desk.ends(2, "--json").err, &["requires a subcommand"]);
    let help = desk.done("--help").out;
    assert_says(&help, &["Shapes:\n", "Light:\n", "Files:\n", "Options:\n", "Exit codes:"]);
}

#[test]
fn starter_scenes_are_right_without_a_warning() {
    let desk = Desk::new();
    let tries =
        [("room", "illum"), ("office", "illum"), ("sobolev", "illum"), ("gallery", "render")];
    for (name, verb) in tries {
        let scene = format!("{name}.toml");
        assert_says(&desk.done(format!("new {scene} {name}").as_str()).err, &["written", &scene]);
        let size = if verb == "render" { "--size 32x16 -o a.png -o a.exr --force" } else { "" };
        let walks = if verb == "render" { 64 } else { 16384 };
        let brief = format!("{verb} {scene} -D {verb}.stop={{walks={walks}}} {size}");
        let said = desk.done(brief.as_str());
        assert!(!said.err.contains("warning"), "{name}: {}", said.err);
    }
    desk.ends(3, "new room.toml");
    desk.done("new room.toml --force");
    assert_eq!(desk.json("new other.toml")["written"], "other.toml");
}

#[test]
fn shells_and_readers_of_manuals_are_served() {
    let desk = Desk::new();
    for shell in ["bash", "zsh", "fish", "powershell", "elvish"] {
        assert_says(
            &desk.done(["completions", shell]).out,
            &["harmolux", "falsecolor", "exposure"],
        );
    }
    let written = desk.json("man -o man")["written"].as_array().expect("a list").len();
    assert!(written > 20 && desk.path("man/harmolux-render.1").exists());
    assert_says(&desk.text("man/harmolux.1"), &[".TH harmolux", "falsecolor"]);
    desk.ends(3, "man -o man");
    desk.done("man -o man --force");
}

#[test]
fn help_of_every_verb_shows_its_options() {
    let desk = Desk::new();
    for (verb, option) in [
        ("render", "--size"),
        ("illum", "--output"),
        ("fit", "--projection"),
        ("info", "--normalisation"),
        ("sweep", "--degrees"),
    ] {
        assert_says(&desk.done([verb, "--help"]).out, &[option, "--json"]);
    }
    let version = concat!("harmolux ", env!("CARGO_PKG_VERSION"), "\n");
    assert_eq!(desk.done(["--version"]).out, version);
}
