//! False colour as a user meets it: pictures, grids on any plane, scales, refusals.

use glam::{DQuat, DVec3};
use harmolux::io::images::Exr;
use harmolux::math::Rgb;
use serde_json::Value;

use crate::common::desk::Desk;

/// A folder to work in.
fn desk() -> Desk {
    Desk::of(&["falsecolor"])
}

/// Runs what must be done; gives what it prints.
fn said(desk: &Desk, words: &str) -> String {
    desk.done(words).all().1
}

/// Runs what must be refused; gives the message.
fn refusal(desk: &Desk, words: &str) -> String {
    desk.ends(3, words).err
}

fn size(desk: &Desk, name: &str) -> (u32, u32) {
    image::load_from_memory(&desk.bytes(name))
        .map(|picture| (picture.width(), picture.height()))
        .expect("a PNG")
}

/// A picture of 40 x 30 pixels that rises from 0 to 117 cd/m2 to the right.
fn picture(change: impl Fn(usize, f64) -> f64) -> Vec<u8> {
    let value = |i: usize| change(i, 3.0 * (i % 40) as f64);
    let pixels: Vec<Rgb> = (0..1200).map(|i| Rgb::grey(value(i))).collect();
    let exr = Exr::new(40, 30).with_colour("", &pixels).expect("fits");
    let exr = exr.with_values("stderr.Y", &vec![0.5; 1200]).expect("fits");
    exr.with_attribute("unit", "cd/m2").to_bytes().expect("encoded")
}

/// A table of grids of 5 x 4 sensors, 0.5 m apart: on the floor, on a wall, tilted; and of a line.
fn table() -> String {
    let mut text = format!("{HEADER}\n");
    let planes = [
        ("floor", DQuat::IDENTITY),
        ("wall", DQuat::from_mat3(&glam::DMat3::from_cols(DVec3::Y, DVec3::Z, DVec3::X))),
        ("tilted", DQuat::from_rotation_z(0.3) * DQuat::from_rotation_x(0.8)),
    ];
    for (name, turn) in planes {
        let normal = turn * DVec3::Z;
        for i in 0..20 {
            let p = turn * DVec3::new(f64::from(i % 5) * 0.5, f64::from(i / 5) * 0.5, 0.0);
            let behind = if name == "floor" && i == 7 { "cupboard" } else { "" };
            text += &row(name, p, normal, 100.0 + 10.0 * f64::from(i), behind);
        }
    }
    for i in 0..5 {
        text += &row("row", DVec3::new(f64::from(i), 0.0, 0.0), DVec3::Z, 1.0, "");
    }
    text
}

const HEADER: &str =
    "group,x_m,y_m,z_m,normal_x,normal_y,normal_z,illuminance_lx,half_width_95_lx,behind";

fn row(name: &str, p: DVec3, n: DVec3, value: f64, behind: &str) -> String {
    format!("{name},{},{},{},{},{},{},{value},0.5,{behind}\n", p.x, p.y, p.z, n.x, n.y, n.z)
}

#[test]
fn picture_becomes_false_colour_with_a_legend() {
    let desk = desk().with("view.exr", picture(|_, v| v));
    let text = said(&desk, "view.exr -o cd.png -o cd.svg --lines --points");
    assert!(text.contains("0 to 120.0 cd/m\u{b2}, linear, viridis"), "{text}");
    assert!(text.contains("117.0 cd/m\u{b2} at (39, 0)"), "{text}");
    let (width, height) = size(&desk, "cd.png");
    assert!(width > 640 && height >= 480);
    let svg = desk.text("cd.svg");
    for words in [">cd/m\u{b2}<", ">120<", ">60<", ">117<", "data:image/png;base64,"] {
        assert!(svg.contains(words), "{words}");
    }
    assert!(refusal(&desk, "view.exr -o new.png -o cd.svg").contains("--force"));
    assert!(!desk.path("new.png").exists());
    said(&desk, "view.exr -o new.png -o cd.svg --force");
}

#[test]
fn scale_is_what_is_asked_for() {
    let desk = desk().with("view.exr", picture(|_, v| v));
    let report = desk.json("view.exr -o a.svg -s 80 -n 4 -l nit");
    assert_eq!((report["high"].as_f64(), report["unit"].as_str()), (Some(80.0), Some("nit")));
    assert_eq!(report["levels"], serde_json::json!([0.0, 20.0, 40.0, 60.0, 80.0]));
    // 81 to 117 in steps of 3 are above it, in each row.
    assert_eq!((report["above"].as_u64(), report["below"].as_u64()), (Some(13 * 30), Some(0)));
    let report = desk.json("view.exr -o b.svg --log 2 --palette turbo --bands");
    assert_eq!((report["low"].as_f64(), report["high"].as_f64()), (Some(2.0), Some(200.0)));
    assert_eq!(report["logarithmic"], true);
    let report = desk.json("view.exr -o c.svg --min 10 --channel stderr.Y");
    assert_eq!(report["largest"]["value"], 0.5);
    assert!(refusal(&desk, "view.exr -o d.svg -s 1 --min 2").contains("from 2 to 1 shows nothing"));
    assert!(refusal(&desk, "view.exr -o d.svg -s nan").contains("shows nothing"));
    for decades in ["0", "-1", "400"] {
        let message = refusal(&desk, &format!("view.exr -o d.svg --log {decades}"));
        assert!(message.contains("above 0 and at most 30 decades, not"), "{message}");
    }
    for words in
        ["view.exr -o a.svg --log 2 --min 1", "view.exr", "view.exr -o a.svg --palette jet"]
    {
        assert_eq!(desk.run(words).code, 2, "{words}");
    }
}

#[test]
fn depths_without_end_are_no_non_finite_values() {
    let depths = (0..1200).map(|i| if i < 60 { f64::INFINITY } else { 2.0 }).collect::<Vec<_>>();
    let exr = Exr::new(40, 30).with_values("depth.Z", &depths).expect("fits");
    let desk = desk().with("view.exr", exr.to_bytes().expect("encoded"));
    let text = said(&desk, "view.exr -o a.svg --channel depth.Z");
    assert!(text.contains("nothing there  60, 5.00 %") && !text.contains("not finite"), "{text}");
    assert!(desk.text("a.svg").contains(">nothing<"));
    let report = desk.json("view.exr -o b.svg --channel depth.Z");
    assert_eq!((&report["nothing"], &report["non_finite"]), (&60.into(), &0.into()));
}

#[test]
fn non_finite_and_dark_pictures_are_shown_and_said() {
    let non_finite = desk().with("view.exr", picture(|i, v| if i < 3 { f64::NAN } else { v }));
    let text = said(&non_finite, "view.exr -o a.svg -o a.png --lines");
    assert!(text.contains("3 values are not finite; shown magenta"), "{text}");
    assert!(non_finite.text("a.svg").contains("not finite"));
    let dark = desk().with("view.exr", picture(|_, _| 0.0));
    for words in ["", "--log 3", "--lines -e"] {
        assert_eq!(dark.json(format!("view.exr -o a.png --force {words}"))["high"], 1.0);
    }
    let void = desk().with("view.exr", picture(|_, _| f64::INFINITY));
    assert_eq!(void.json("view.exr -o a.png -e --lines")["largest"], Value::Null);
}

#[test]
fn grids_on_any_plane_become_isolux_pictures() {
    let desk = desk().with("lux.csv", table());
    let text = said(&desk, "lux.csv -o a.svg -o a.png --group floor --points");
    assert!(text.contains("floor, 5 x 4, 1 behind an object"), "{text}");
    assert!(text.contains("290.0 lx at (2, 1.5, 0)"), "{text}");
    let svg = desk.text("a.svg");
    for words in [">x, m<", ">y, m<", ">100<", ">290<", ">lx<", ">behind<", "seen from above"] {
        assert!(svg.contains(words), "{words}");
    }
    assert!(!svg.contains(">170<"), "the hidden sensor has no value");
    said(&desk, "lux.csv -o wall.svg --group wall");
    let wall = desk.text("wall.svg");
    assert!(wall.contains(">y, m<") && wall.contains(">z, m<") && wall.contains("seen from +x"));
    said(&desk, "lux.csv -o tilted.svg --group tilted");
    assert!(desk.text("tilted.svg").contains("along (0.955, 0.296, 0), m"));
    let report = desk.json("lux.csv -o b.svg --group wall --channel half_width_95_lx");
    assert_eq!(
        (report["least"]["value"].as_f64(), report["unit"].as_str()),
        (Some(0.5), Some("lx"))
    );
}

#[test]
fn only_grid_is_taken_and_others_are_named() {
    let desk = desk().with("lux.csv", table());
    let message = refusal(&desk, "lux.csv -o c.png");
    assert!(message.contains("several groups are grids: floor, wall, tilted"), "{message}");
    let message = refusal(&desk, "lux.csv -o c.png --group flor");
    assert!(message.contains("no group `flor` of sensors, only floor, wall, tilted, row"));
    let message = refusal(&desk, "lux.csv -o c.png --group row");
    assert!(message.contains("`row` are no grid: the points stand in one line"), "{message}");
    assert!(message.contains("help: make the sensors a grid"), "{message}");
    let kept = desk.text("lux.csv");
    let keep = |words: &[&str]| {
        let lines = kept.lines().filter(|l| words.iter().any(|w| l.starts_with(w)));
        desk.put("few.csv", lines.collect::<Vec<_>>().join("\n"));
    };
    keep(&["group", "floor", "row"]);
    assert!(said(&desk, "few.csv -o a.png").contains("not shown, no grids: row"));
    keep(&["group", "row"]);
    assert!(refusal(&desk, "few.csv -o b.png").contains("`row` are no grid"));
}

#[test]
fn what_cannot_be_shown_is_refused_with_the_way_on() {
    let desk = desk().with("lux.csv", table()).with("view.exr", picture(|_, v| v));
    desk.put("x.csv", "a,b\n1,2\n");
    desk.put("x.txt", "hello");
    desk.put("x.exr", [0x76, 0x2f, 0x31, 0x01, 0, 0]);
    for (words, expected) in [
        ("x.csv -o a.png", "x.csv:1: the table has no column `group`, only a, b"),
        ("x.txt -o a.png", "neither an EXR picture nor a CSV table"),
        ("x.exr -o a.png", "not a readable EXR image"),
        ("none.exr -o a.png", "none.exr: cannot read"),
        (". -o a.png", "this is a folder"),
        ("view.exr -o a.jpg", "name a file .png or .svg"),
        ("view.exr -o a.png --channel Z", "no channel `Z`, only B, G, R, luminance.Y, stderr.Y"),
        ("view.exr -o a.png --group floor", "a picture has no group `floor`"),
        ("lux.csv -o a.png --group floor --channel lux", "no column `lux`"),
        ("view.exr -o no/a.png", "no/a.png"),
    ] {
        let message = refusal(&desk, words);
        assert!(message.contains(expected), "{words}: {message}");
    }
    assert!(!desk.path("a.png").exists());
}

#[test]
fn scene_leads_to_pictures_and_to_numpy() {
    let desk = Desk::new();
    let scene = r#"format = 1
[materials.grey.lambert]
reflectance = 0.5
[objects.room.box]
min = [0, 0, 0]
max = [3, 4, 3]
inward = true
material = "grey"
[lights.lamp.point]
at = [1, 1, 2.5]
intensity = 100
[sensors.floor.grid]
on = "room.z_min"
count = [4, 5]
[illum]
stop = { walks = 64 }
"#;
    desk.put("room.toml", scene);
    desk.done("illum room.toml -o lux.csv -o lux.npy");
    assert!(said(&desk, "falsecolor lux.csv -o floor.png").contains("floor, 4 x 5"));
    let bytes = desk.bytes("lux.npy");
    let header = String::from_utf8_lossy(&bytes[..128]).into_owned();
    assert!(header.contains("'descr': '<f8'") && header.contains("'shape': (20, 10)"), "{header}");
    assert_eq!(bytes.len(), 128 + 20 * 10 * 8);
    let number = |i: usize| {
        let at = 128 + 8 * i;
        f64::from_le_bytes(bytes[at..at + 8].try_into().expect("eight bytes"))
    };
    let csv = desk.text("lux.csv");
    let first: Vec<f64> = csv
        .lines()
        .nth(1)
        .expect("a row")
        .split(',')
        .skip(1)
        .take(10)
        .map(|t| t.parse().expect("a number"))
        .collect();
    assert_eq!((0..10).map(number).collect::<Vec<_>>(), first);
    desk.refused("illum room.toml -o lux.npy", &["--force"]);
}
