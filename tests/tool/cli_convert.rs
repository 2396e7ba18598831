//! `harmolux convert`, and `info` of what it writes, as a user meets them.

use std::fs;

use serde_json::Value;

use crate::common::desk::{Desk, Said};

/// A lopsided ball: degree 2, 4pi, csphase 1, about a centre of its own.
const SHAPE: &str = "# harmolux 0.1.0 coefficients\n# normalisation: 4pi\n# csphase: 1\n# unit: m\n\
                     # centre: 0.5 0.0 -0.25\n# source: \"rock.obj\"\n\
                     # source-hash: fnv1a64:85944171f73967e8\n# lmax: 2\n0, 0, 1.0, 0.0\n\
                     1, 0, 0.1, 0.0\n1, 1, 0.05, -0.02\n2, 0, 0.03, 0.0\n2, 1, 0.01, 0.02\n\
                     2, 2, -0.04, 0.03\n";

/// A folder with a shape.
fn desk() -> Desk {
    Desk::new().with("rock.txt", SHAPE)
}

#[test]
fn every_format_goes_out_and_comes_back() {
    let desk = desk();
    let expected = desk.json("info rock.txt");
    for (name, flags, reading, keeps_centre) in [
        ("a.txt", "--to-normalisation schmidt --to-csphase -1", "", true),
        ("a.dov", "", "", true),
        ("a.bshc", "--to-normalisation unnorm", "--normalisation unnorm", false),
        ("a.npy", "--to-csphase -1", "--normalisation 4pi --csphase -1", false),
        ("alm.npy", "--to alm", "", false),
        ("a.coef", "", "", true),
        ("a.csv", "", "", false),
        ("a.tab", "", "", false),
    ] {
        let report = desk.json(format!("convert rock.txt {name} {flags}"));
        assert_eq!((&report["degree"], &report["coefficients"]), (&2.into(), &9.into()), "{name}");
        assert_eq!(
            report["bytes"],
            fs::metadata(desk.path(name)).expect("written").len(),
            "{name}"
        );
        let lost = report["lost"].as_array().expect("a list");
        assert_eq!(lost.contains(&"centre".into()), !keeps_centre, "{name}: {report}");
        // Without its extension: the content alone tells the format.
        fs::copy(desk.path(name), desk.path("nameless")).expect("copied");
        let info = desk.json(format!("info nameless {reading}"));
        assert_eq!(info["format"], report["to"], "{name}");
        assert_eq!(info["normalisation"], report["normalisation"], "{name}");
        for key in ["mean_radius", "volume"] {
            let [a, b] = [&info, &expected].map(|v| v[key].as_f64().expect("a number"));
            assert!((a / b - 1.0).abs() <= 1e-14, "{name}, {key}: {a} {b}");
        }
        desk.done(format!("convert nameless back.txt {reading} --force"));
        let centre = if keeps_centre {
            serde_json::json!([0.5, 0.0, -0.25])
        } else {
            serde_json::json!([0.0, 0.0, 0.0])
        };
        let back = desk.json("info back.txt");
        let near = |a: &Value, b: &Value| {
            (a.as_f64().unwrap_or(9.0) - b.as_f64().unwrap_or(0.0)).abs() <= 1e-15
        };
        assert!((0..3).all(|i| near(&back["centre"][i], &centre[i])), "{name}: {back}");
    }
}

#[test]
fn what_is_lost_and_what_is_not_said_is_told_on_stderr() {
    let desk = desk();
    let Said { out, err, .. } = desk.done("convert rock.txt a.npy -l 1");
    assert!(
        out.contains("a coefficient text of degree 2")
            && out.contains("an array of coefficients of degree 1"),
        "{out}"
    );
    for word in [
        "cut from degree 2 to 1",
        "a.npy has no room for the centre (0.5000, 0, -0.2500) m",
        "the source rock.obj",
        "the degree of the fit, 2",
        "a.npy does not say its convention: tell who reads it 4pi, csphase 1",
    ] {
        assert!(err.contains(word), "{err}");
    }
    let Said { err, .. } = desk.done("convert rock.txt b.txt -l 9");
    assert_eq!(err, "the series ends at degree 2: nothing to cut at 9\n");
}

#[test]
fn file_that_is_there_is_replaced_only_by_force() {
    let desk = desk();
    for name in ["a.npy", "a.bshc", "a.coef", "a.txt", "a.dov", "a.csv", "a.tab"] {
        desk.done(format!("convert rock.txt {name}"));
        desk.refused(
            format!("convert rock.txt {name}"),
            &["this file is there already", "--force"],
        );
        desk.done(format!("convert rock.txt {name} --force"));
    }
}

#[test]
fn wrong_input_is_refused_and_nothing_is_written() {
    let desk = desk();
    let numbers = |values: &[f64]| values.iter().flat_map(|v| v.to_le_bytes()).collect::<Vec<u8>>();
    desk.put("huge.bshc", numbers(&[0.0, 1e9, 1.0]));
    desk.put("large.bshc", numbers(&[0.0, 1e6, 1.0]));
    let header = format!(
        "{:<117}\n",
        "{'descr': '<f8', 'fortran_order': False, 'shape': (2, 99999, 99999), }"
    );
    desk.put("huge.npy", [b"\x93NUMPY\x01\x00\x76\x00", header.as_bytes()].concat());
    desk.put("bare.txt", b"0 0 1 0\n1 0 0.1 0\n1 1 0.1 0.1\n");
    desk.put("gap.txt", b"0 0 1 0\n2 0 1 0\n");
    desk.put("twice.txt", b"0 0 1 0\n1 0 1 0\n1 0 1 0\n");
    desk.put("order.txt", b"0 0 1 0\n1 0 1 0\n1 2 1 0\n");
    desk.put("nan.txt", b"0 0 NaN 0\n");
    desk.put("cut.coef", b"{ 4,{0, 0, 0},\n{0, 0, 1},\n{1, 0");
    desk.put("points.coef", b"{ 4,{0, 0, 0},\n{0, 0, 2},\n{-1, 0, 0},\n{0, -1, 0}}");
    desk.put("two.csv", b"shcoeffs_L0M0C\n1\n2\n");
    desk.put("cube.obj", b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    desk.put("empty.txt", b"");
    let said = "--normalisation 4pi";
    for (file, flags, words) in [
        ("huge.bshc", said, &["announces degrees 0.0 to 1000000000.0"][..]),
        ("large.bshc", said, &["degree 1000000 takes 8000024000032 bytes, the file has 24"]),
        ("huge.npy", said, &["does not fit the 0 bytes"]),
        ("bare.txt", "", &["does not say how it is normalised", "--normalisation 4pi|ortho"]),
        (
            "rock.txt",
            "--normalisation ortho",
            &["the file says 4pi, csphase 1; asked for was ortho"],
        ),
        ("rock.txt", "--unit mm", &["the file says that its unit is the metre"]),
        ("rock.txt", "--row 1", &["has one shape and no rows"]),
        ("gap.txt", said, &["gap.txt:2: degree 2, order 0 stands here, where degree 1"]),
        ("twice.txt", said, &["twice.txt:3: degree 1, order 0 stands here a second time"]),
        ("order.txt", said, &["order.txt:3: degree 1, order 2: the order cannot exceed"]),
        ("nan.txt", said, &["nan.txt:1: `NaN` is not a finite number"]),
        ("empty.txt", said, &["there are no coefficients here"]),
        ("cut.coef", "", &["cut.coef:3: a triple", "cut off"]),
        ("points.coef", "", &["no radial shape: its points lie", "harmolux fit"]),
        ("points.coef", "--normalisation 4pi", &["a SPHARM-PDM file is always ortho, csphase -1"]),
        ("two.csv", "", &["the table has 2 rows", "`--row`"]),
        ("two.csv", "--row 3", &["there is no row 3"]),
        ("cube.obj", "", &["unrecognised coefficient file", "harmolux fit"]),
        ("rock.txt", "--from npy", &["this is no .npy file"]),
        ("none.txt", "", &["none.txt: cannot read"]),
        (".", "", &["this is a folder"]),
    ] {
        desk.refused(format!("convert {file} out.txt {flags}"), words);
    }
    desk.refused(
        "convert rock.txt a.coef --to-normalisation 4pi",
        &["a SPHARM-PDM file is always ortho, csphase -1"],
    );
    desk.refused(
        "convert rock.txt a.tab --to-normalisation ortho",
        &["a SHADR table cannot say ortho"],
    );
    desk.refused("convert rock.txt a.foo", &["say it with `--to`: text, dov"]);
    desk.refused("convert rock.txt a.txt --to bshc", &["a bshc file needs the extension .bshc"]);
    desk.refused("info two.csv", &["the table has 2 rows"]);
}

/// A scene, `random` and `diff` cannot be told how a file is meant, or not all of it: their advice
/// names the verb that can.
#[test]
fn verbs_without_the_flags_advise_to_convert_and_that_helps() {
    let desk = desk();
    desk.put("bare.txt", b"0 0 1 0\n1 0 0.1 0\n1 1 0.1 0.1\n");
    desk.put("two.csv", b"shcoeffs_L0M0C\n1\n2\n");
    let scene = |file: &str| {
        desk.put(
            "room.toml",
            format!("{ROOM}file = \"{file}\"\ndegree = 1\nmaterial = \"grey\"\n"),
        );
    };
    let advice = "to `harmolux convert bare.txt NEW.txt`, and name NEW.txt instead";
    let random = |file: &str| format!("random --spectrum {file} --radius 1 -o out.txt");
    desk.refused(random("bare.txt"), &["`--normalisation 4pi|ortho", advice]);
    scene("bare.txt");
    desk.refused("illum room.toml", &["`--normalisation 4pi|ortho", "bare.txt NEW.txt`"]);
    let rows = "`--row`, counted from 1, to `harmolux convert two.csv NEW.txt`";
    desk.refused("diff two.csv rock.txt", &[rows]);
    // What the verb at hand can be told stays its own advice.
    let own = desk.ends(3, "diff bare.txt rock.txt").err;
    assert!(own.contains("`--normalisation 4pi|ortho") && !own.contains("NEW.txt"), "{own}");
    desk.done("convert bare.txt NEW.txt --normalisation 4pi");
    desk.done(random("NEW.txt"));
    scene("NEW.txt");
    desk.done("illum room.toml");
}

/// A lamp over a shape whose file is still to be named.
const ROOM: &str = r"format = 1
[materials.grey.lambert]
reflectance = 0.5
[lights.lamp.point]
at = [0, 0, 3]
intensity = 100
[sensors.spot.points]
at = [[2, 0, 0]]
normal = [0, 0, 1]
[illum]
stop = { walks = 64 }
[objects.rock.sh]
";

#[test]
fn wrong_command_line_is_exit_code_2() {
    let desk = desk();
    for line in [
        "convert rock.txt",
        "convert rock.txt a.txt --to shtools",
        "convert rock.txt a.txt --csphase 1",
        "info rock.txt --row 0",
    ] {
        assert_eq!(desk.run(line).code, 2, "{line}");
    }
}

#[test]
fn unit_of_a_file_is_heeded() {
    let desk = desk();
    desk.put("bare.txt", b"0 0 2 0\n");
    let line = "info bare.txt --normalisation 4pi";
    assert_eq!(desk.json(line)["mean_radius"], 2.0);
    for (unit, radius) in [("mm", 0.002), ("km", 2000.0), ("um", 2e-6)] {
        let found = desk.json(format!("{line} --unit {unit}"))["mean_radius"].as_f64();
        assert!(found.is_some_and(|r| (r / radius - 1.0).abs() <= 1e-15), "{unit}");
    }
    let info = desk.json("info rock.txt");
    let [low, high] = [0, 1].map(|i| info["bounds"][i][2].as_f64().expect("a number"));
    // About z = -0.25, some 0.8 to 1.3 each way.
    assert!((-1.6..-0.9).contains(&low) && (0.7..1.4).contains(&high), "{info}");
}

#[test]
fn mesh_becomes_a_mesh() {
    let desk = desk();
    desk.put(
        "a.txt",
        b"OFF\n4 4 0\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 2 1\n3 0 1 3\n3 1 2 3\n3 0 3 2\n",
    );
    let volume = desk.json("info a.txt")["volume"].as_f64().expect("a mesh, by its content");
    for (name, digits) in [("a.obj", 1e-15), ("a.ply", 1e-15), ("a.stl", 1e-6)] {
        let report = desk.json(format!("convert a.txt {name} --unit cm"));
        assert_eq!((&report["faces"], &report["vertices"]), (&4.into(), &4.into()), "{name}");
        let found = desk.json(format!("info {name}"))["volume"].as_f64().expect("a number");
        assert!((1e6 * found / volume - 1.0).abs() <= digits, "{name}: {found}");
    }
    desk.refused("convert rock.txt b.ply", &["these are coefficients", "harmolux mesh"]);
    desk.refused("convert a.txt b.ply -l 4", &["not of coefficients: leave out `--degree`"]);
    desk.refused("convert a.txt b.off", &["meshes are written as .obj, .ply or .stl"]);
    desk.refused("convert a.txt b.txt", &["unrecognised coefficient file", "harmolux fit"]);
}

#[test]
fn formats_that_are_read_only_are_not_written() {
    let desk = desk();
    for name in ["a.gfc", "a.fits"] {
        desk.refused(format!("convert rock.txt {name}"), &["is read here and not written: write"]);
    }
    desk.put(
        "topo.gfc",
        "max_degree 1\nend_of_head\ngfc 0 0 2.0D+00 0\ngfc 1 0 0 0\ngfc 1 1 0 0\n",
    );
    let report = desk.json("convert topo.gfc topo.txt");
    assert_eq!((&report["from"], &report["degree"]), (&"icgem".into(), &1.into()));
    assert_eq!(desk.json("info topo.txt")["mean_radius"], 2.0);
}

#[test]
fn radius_that_is_not_positive_everywhere_has_no_volume() {
    let desk = desk();
    desk.put("heights.txt", "0 0 0\n1 0 0.3\n1 1 0.1 0\n");
    desk.put("rings.txt", "0 0 1\n1 0 0\n1 1 0 0\n2 0 0.9\n2 1 0 0\n2 2 0 0\n");
    let stated = "--normalisation 4pi";
    for (name, advised) in [("heights.txt", true), ("rings.txt", false)] {
        let said = desk.ends(3, format!("info {name} {stated}")).out;
        assert!(said.contains("volume       none") && said.contains("no closed surface"), "{said}");
        assert_eq!(said.contains("`--add-radius`"), advised, "{said}");
        assert_eq!(desk.json_at(3, format!("info {name} {stated}"))["volume"], Value::Null);
        desk.refused(format!("mesh {name} -o a.ply {stated}"), &[name, "radius"]);
        for verb in ["convert", "transform"] {
            let to = if verb == "convert" { "a.dov" } else { "-o a.dov" };
            let said = desk.done(format!("{verb} {name} {to} {stated} --force")).err;
            assert!(said.contains("warning: a.dov: no closed surface"), "{said}");
        }
    }
    let info = desk.json(format!("info heights.txt {stated} --add-radius 2km"));
    assert_eq!(info["mean_radius"], 2000.0);
    desk.done(format!("mesh heights.txt -o a.ply {stated} --add-radius 1 --force"));
}
