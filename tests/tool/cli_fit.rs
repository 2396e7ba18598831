//! `harmolux fit` as a user meets it: folds, points, filters, many meshes at once.

use std::f64::consts::TAU;
use std::fmt::Write;
use std::fs;
use std::path::Path;

use harmolux::io::coefficients;
use serde_json::Value;

use crate::common::desk::{Desk, assert_says, number};
use crate::common::solids::{cube, prism};

fn desk() -> Desk {
    Desk::of(&["fit"])
}

/// A cube of side 4 with a rail along its top that overhangs on both sides: star-shaped about no
/// point.
fn railed() -> String {
    let corners = [
        [-2.0, -2.0],
        [2.0, -2.0],
        [2.0, 2.0],
        [0.1, 2.0],
        [0.1, 2.1],
        [0.3, 2.1],
        [0.3, 2.2],
        [-0.3, 2.2],
        [-0.3, 2.1],
        [-0.1, 2.1],
        [-0.1, 2.0],
        [-2.0, 2.0],
    ];
    let caps = [[0, 1, 2, 3], [0, 3, 10, 11], [3, 4, 9, 10], [4, 5, 6, 7], [4, 7, 8, 9]];
    prism(&corners, [-2.0, 2.0], &caps)
}

/// Points of the ellipsoid with half axes 1, 2 and 3, on a spiral from pole to pole.
fn ellipsoid(count: usize) -> String {
    let mut text = String::from("x,y,z,weight\n");
    for i in 0..count {
        let z = 1.0 - (2 * i + 1) as f64 / count as f64;
        let (s, phi) = ((1.0 - z * z).sqrt(), 2.399_963 * i as f64);
        writeln!(text, "{},{},{},1", s * phi.cos(), 2.0 * s * phi.sin(), 3.0 * z).expect("text");
    }
    text
}

// Folds.

#[test]
fn a_folded_mesh_is_refused_with_the_flag_that_fits_it() {
    let desk = desk();
    desk.put("rail.obj", railed());
    let words =
        ["rail.obj: the mesh is not star-shaped", "no centre sees all", "--not-star outermost"];
    desk.refused("rail.obj -l 8 -o a.txt", &words);
    let words = ["% of the directions from [", "more than the 0.01 % that are accepted"];
    desk.refused("rail.obj -l 8 -o a.txt --not-star first --not-star-limit 0.01", &words);
    let words = ["does not surround the centre", "give one"];
    desk.refused("rail.obj -l 8 -o a.txt --not-star first --centre 9,0,0", &words);
}

#[test]
fn envelopes_of_a_folded_mesh_are_fitted_in_their_order() {
    let desk = desk();
    desk.put("rail.obj", railed());
    let fits = ["first", "mean", "outermost"].map(|envelope| {
        desk.json(format!("rail.obj -l 8 -o {envelope}.txt --not-star {envelope} --centre 0,0,0"))
    });
    let volumes = fits.each_ref().map(|fit| number(fit, "mesh_volume"));
    assert!(volumes[0] < volumes[1] && volumes[1] < volumes[2], "{volumes:?}");
    // The mesh itself, 64 + 0.08 + 0.24 m3, is between what is cut and what is filled.
    assert!(volumes[0] < 64.32 && 64.32 < volumes[2], "{volumes:?}");
    for fit in &fits {
        let folds = &fit["not_star"];
        // What the rail overhangs is seen within 2 atan(0.3/2.1) by 2 atan(2/2.1), a few hundredths
        // of the sphere at the most.
        assert!(number(folds, "share") > 0.0 && number(folds, "share") < 0.03, "{folds}");
        assert!(number(folds, "quadrature_defect") <= 1e-4, "{folds}");
        // What borders of folds lose would drown the small difference that Parseval takes.
        assert!(number(fit, "rms") <= 0.03 * number(fit, "mean_radius"), "{fit}");
        assert_eq!(fit["rms_by_parseval"], Value::Null);
    }
    let text = desk.done("rail.obj -l 8 -o a.txt --not-star outermost").out;
    assert!(
        text.contains("% of the directions meet the mesh more than once: the outermost radius"),
        "{text}"
    );
}

/// A cap over a stem, turned about z in few steps; the borders of its folds jump by half a radius.
fn capped() -> String {
    const AROUND: usize = 8;
    let rings = [[0.5, -1.0], [0.3, -0.4], [0.3, 0.4], [0.8, 0.0], [0.8, 0.6]];
    let mut text = String::from("v 0 0 -1\nv 0 0 1\n");
    let at = |ring: usize, k: usize| 3 + ring * AROUND + k % AROUND;
    for k in 0..rings.len() * AROUND {
        let ([r, z], angle) = (rings[k / AROUND], TAU * (k % AROUND) as f64 / AROUND as f64);
        writeln!(text, "v {} {} {z}", r * angle.cos(), r * angle.sin()).expect("text");
    }
    let last = rings.len() - 1;
    for k in 0..AROUND {
        writeln!(text, "f 1 {} {}", at(0, k + 1), at(0, k)).expect("text");
        writeln!(text, "f 2 {} {}", at(last, k), at(last, k + 1)).expect("text");
        for ring in 0..last {
            let [a, b] = [at(ring, k), at(ring, k + 1)];
            writeln!(text, "f {a} {b} {} {}", at(ring + 1, k + 1), at(ring + 1, k)).expect("text");
        }
    }
    text
}

#[test]
fn an_envelope_that_rings_says_so_and_the_advice_helps() {
    let desk = desk();
    desk.put("cap.obj", capped());
    desk.put("cube.obj", cube(1.0));
    let fit = |more: &str| {
        let said =
            desk.done(format!("cap.obj -o a.txt --force --not-star outermost --json {more}"));
        (serde_json::from_str::<Value>(&said.out).expect("JSON"), said.err)
    };
    let (plain, said) = fit("-l 16");
    let words = ["warning: the series rings", " above that of the envelope", "`--filter lanczos`"];
    assert_says(&said, &words);
    assert_says(&desk.done("--help").out, &["--filter <FILTER>", "lanczos", "-l, --degree"]);
    let excess = |fit: &Value| number(fit, "area") / number(fit, "mesh_area") - 1.0;
    assert!(excess(&plain) > 0.3 && plain["rings"] == true, "{plain}");
    // Who follows the advice has less of it, and is told what else there is.
    let (filtered, said) = fit("-l 16 --filter lanczos");
    assert!(excess(&filtered) <= 0.5 * excess(&plain), "{filtered}");
    assert!(number(&filtered, "normal_mean_degrees") < number(&plain, "normal_mean_degrees"));
    assert_says(&said, &["even with `--filter lanczos`: lower the degree, `-l`"]);
    let (lower, said) = fit("-l 8 --filter lanczos");
    assert!(lower["rings"] == false && !said.contains("rings"), "{lower} {said}");
    // Of several meshes each is told by its name.
    let many = desk.done("cap.obj cube.obj -l 16 -o out --not-star outermost").err;
    assert_says(&many, &["warning: cap.obj: the series rings"]);
    assert!(!many.contains("cube.obj: the series rings"), "{many}");
}

#[test]
fn vertices_without_faces_count_nowhere() {
    let desk = Desk::new();
    desk.put("cube.obj", cube(1.0));
    desk.put("more.obj", cube(1.0) + "v 50 60 70\nv 80 90 100\n");
    let [plain, more] = ["cube", "more"].map(|name| {
        let fit = desk.json(format!("fit {name}.obj -l 4 -o {name}.txt"));
        let info = desk.json(format!("info {name}.obj"));
        assert_eq!(info["bytes"], fit["mesh_bytes"]);
        fit
    });
    // Eight vertices and twelve faces of twelve bytes.
    assert_eq!((&plain["mesh_bytes"], &more["mesh_bytes"]), (&240.into(), &240.into()));
    assert_eq!((&plain["max"], &plain["rms"]), (&more["max"], &more["rms"]));
}

#[test]
fn a_star_shaped_mesh_is_fitted_as_ever_under_not_star() {
    let desk = desk();
    desk.put("cube.obj", cube(1.0));
    desk.done("cube.obj -l 6 -o a.txt");
    let fit = desk.json("cube.obj -l 6 -o b.txt --not-star mean");
    assert_eq!((desk.text("a.txt"), &fit["not_star"]), (desk.text("b.txt"), &Value::Null));
}

// Errors of a fit, filters, degrees.

#[test]
fn a_fit_states_its_errors_of_radius_normal_volume_and_area() {
    let desk = desk();
    desk.put("cube.obj", cube(1.0));
    let fit = desk.json("cube.obj -l 12 -o a.txt");
    assert!((number(&fit, "mesh_volume") - 8.0).abs() <= 1e-9, "{fit}");
    assert!((number(&fit, "mesh_area") - 24.0).abs() <= 1e-9, "{fit}");
    // Degree 12 rounds edges and corners: mostly area is lost.
    assert!((number(&fit, "volume") / 8.0 - 1.0).abs() <= 0.01, "{fit}");
    assert!((number(&fit, "area") / 24.0 - 1.0).abs() <= 0.08, "{fit}");
    let [mean, most] = ["normal_mean_degrees", "normal_95_degrees"].map(|name| number(&fit, name));
    assert!(mean > 1.0 && most > mean && most < 60.0, "{fit}");
    assert!((number(&fit, "rms") / number(&fit, "rms_by_parseval") - 1.0).abs() <= 0.01, "{fit}");
    let text = desk.done("cube.obj -l 12 -o b.txt").out;
    for word in ["normals ", "volume ", "area ", "(by Parseval "] {
        assert!(text.contains(word), "`{word}` is missing in:\n{text}");
    }
}

#[test]
fn filters_damp_degrees_and_are_off_by_default() {
    let desk = desk();
    desk.put("cube.obj", cube(1.0));
    desk.done("cube.obj -l 8 -o plain.txt");
    desk.done("cube.obj -l 8 -o heat.txt --filter heat=0.01");
    let lanczos = desk.json("cube.obj -l 8 -o lanczos.txt --filter lanczos");
    assert_eq!(lanczos["filter"], "lanczos");
    let read = |name| {
        coefficients::read(&desk.path(name), &coefficients::ReadOptions::default())
            .expect("readable")
            .coefficients
    };
    let [plain, heat, lanczos] = ["plain.txt", "heat.txt", "lanczos.txt"].map(read);
    for l in [0_usize, 4, 8] {
        let ours = plain.degree_deviation(l);
        let x = std::f64::consts::PI * l as f64 / 9.0;
        let sinc = if l == 0 { 1.0 } else { x.sin() / x };
        assert!((lanczos.degree_deviation(l) - sinc * ours).abs() <= 1e-14);
        let cooled = (-0.01 * (l * (l + 1)) as f64).exp() * ours;
        assert!((heat.degree_deviation(l) - cooled).abs() <= 1e-14);
    }
    for wrong in [
        "--filter box",
        "--filter heat=-1",
        "--not-star-limit 3",
        "--not-star first --not-star-limit 200",
    ] {
        assert_eq!(desk.run(format!("cube.obj -l 8 -o a.txt {wrong}")).code, 2, "{wrong}");
    }
}

#[test]
fn degrees_from_0_to_300_are_fitted() {
    let desk = desk();
    desk.put("cube.obj", cube(1.0));
    let mut last = f64::INFINITY;
    for degree in [0, 1, 95, 96, 300] {
        let fit = desk.json(format!("cube.obj -l {degree} -o {degree}.txt"));
        let rms = number(&fit, "rms");
        assert!(
            rms <= last && (rms / number(&fit, "rms_by_parseval") - 1.0).abs() <= 0.01,
            "{fit}"
        );
        last = rms;
    }
}

// Points.

#[test]
fn points_are_fitted_by_least_squares() {
    let desk = desk();
    desk.put("scan.csv", ellipsoid(2000));
    let fit = desk.json("scan.csv -l 16 -o a.txt");
    assert_eq!(
        (&fit["points"], &fit["centre"]),
        (&2000.into(), &serde_json::json!([0.0, 0.0, 0.0]))
    );
    // Degree 16 leaves some 1e-3 of this ellipsoid.
    assert!(number(&fit, "rms") <= 5e-3 * number(&fit, "mean_radius"), "{fit}");
    assert!(number(&fit, "standard_error") < number(&fit, "rms"), "{fit}");
    // r(+z) is the half axis.
    let shape = coefficients::read(&desk.path("a.txt"), &coefficients::ReadOptions::default())
        .expect("readable")
        .coefficients;
    let up: f64 = (0..=16).map(|l| shape.get(l, 0).0).sum();
    assert!((up - 3.0).abs() <= 0.02, "{up}");
    let text = desk.done("scan.csv -l 4 -o b.txt --lambda 1e-6 --unit mm").out;
    assert!(text.contains("RMS residual") && text.contains("points          2000"), "{text}");
}

#[test]
fn points_of_every_kind_are_the_same() {
    let desk = desk();
    let points: Vec<[f64; 3]> = ellipsoid(300)
        .lines()
        .skip(1)
        .map(|line| {
            let mut numbers = line.split(',').map(|n| n.parse().expect("a number"));
            [(); 3].map(|()| numbers.next().expect("three"))
        })
        .collect();
    let rows = |row: &dyn Fn(&[f64; 3]) -> String| points.iter().map(row).collect::<String>();
    let header = "ply\nformat ascii 1.0\nelement vertex 300\nproperty float red\n\
                  property double x\nproperty double y\nproperty double z\nend_header\n";
    desk.put("a.xyz", rows(&|[x, y, z]| format!("{x} {y} {z}\n")));
    desk.put("normals.txt", rows(&|[x, y, z]| format!("{x}\t{y}\t{z}\t0\t0\t1\n")));
    desk.put("lidar.asc", rows(&|[x, y, z]| format!("{x} {y} {z} {}\n", 100.0 * z.abs())));
    let scan = rows(&|[x, y, z]| format!("{x} {y} {z} -1200 255 0 9\n"));
    desk.put("scan.pts", format!("300\r\n{}", scan.replace('\n', "\r\n")));
    let named = rows(&|[x, y, z]| format!("7;{z};{y};{x}\n"));
    desk.put("named.csv", format!("id;Z;Y;X\n{named}"));
    let axes = rows(&|[x, y, z]| format!("0,{x},{y},{z}\n"));
    desk.put("napari.csv", format!("index,axis-0,axis-1,axis-2\n{axes}"));
    let compared = rows(&|[x, y, z]| format!("{x},{y},{z},0.5,0.5,0.5\n"));
    desk.put("compare.csv", format!("//X,Y,Z,Rf,Gf,Bf\n{compared}"));
    desk.put("cloud.ply", header.to_owned() + &rows(&|[x, y, z]| format!("9 {x} {y} {z}\n")));
    desk.put("rows.npy", harmolux::io::npy::rows(3, points.as_flattened()));
    let expected = desk.json("a.xyz -l 4 -o a.txt");
    for name in [
        "normals.txt",
        "lidar.asc",
        "scan.pts",
        "named.csv",
        "napari.csv",
        "compare.csv",
        "cloud.ply",
        "rows.npy",
    ] {
        let fit = desk.json(format!("{name} -l 4 -o {name}.txt"));
        for key in ["points", "mean_radius", "rms", "standard_error"] {
            assert_eq!(fit[key], expected[key], "{name}, {key}");
        }
    }
    // A fourth column is a weight only when that is said.
    let weighted = desk.json("lidar.asc -l 4 -o w.txt --weights");
    assert_ne!(weighted["mean_radius"], expected["mean_radius"]);
    desk.refused("a.xyz -l 4 -o b.txt --weights", &["there are no weights here"]);
    desk.put("cube.obj", cube(1.0));
    desk.refused("cube.obj -l 4 -o b.txt --weights", &["a mesh has no weights", "`--weights`"]);
}

#[test]
fn gap_between_points_is_told_by_the_standard_error() {
    let desk = desk();
    let all = ellipsoid(600);
    let is_upper = |line: &&str| !line.split(',').nth(2).is_some_and(|z| z.starts_with('-'));
    let upper = all.lines().filter(is_upper);
    desk.put("half.csv", upper.collect::<Vec<_>>().join("\n") + "\n");
    let fit = desk.json("half.csv -l 6 -o a.txt --centre 0,0,0");
    let [rms, error, largest] =
        ["rms", "standard_error", "largest_standard_error"].map(|key| number(&fit, key));
    assert!(error > 10.0 * rms && largest > error, "{fit}");
    let said = desk.done("half.csv -l 6 -o b.txt --centre 0,0,0").err;
    assert_says(&said, &["warning: the points leave the series uncertain", "lambda 1e-6", "`-l`"]);
    desk.put("all.csv", &all);
    let said = desk.done("all.csv -l 12 -o c.txt").err;
    assert!(!said.contains("warning"), "{said}");
}

#[test]
fn poor_fit_is_warned_of_and_counts_in_the_table() {
    let desk = desk();
    desk.put(
        "bar.obj",
        prism(&[[-4.0, -1.0], [4.0, -1.0], [4.0, 1.0], [-4.0, 1.0]], [-1.0, 1.0], &[[0, 1, 2, 3]]),
    );
    let said = desk.done("bar.obj -l 0 -o a.txt").err;
    assert_says(&said, &["warning: the series is off by", "of the mean radius (RMS)", "`-l`"]);
    desk.put("cube.obj", cube(1.0));
    desk.done("bar.obj cube.obj -l 4 -o out");
    let table = desk.text("out/fits.csv");
    let rows: Vec<&str> = table.lines().collect();
    assert!(rows[0].contains(",warning,error,"), "{table}");
    assert!(rows[1].contains("the series is off by") && !rows[2].contains("off by"), "{table}");
}

#[test]
fn parametric_surface_of_spharm_pdm_is_fitted() {
    let desk = desk();
    // An ellipsoid of half axes 1, 2, 3: of a ball the numbers are -2.894405 (x, y) and 2.046653.
    desk.put(
        "skull.coef",
        "{ 4,{0, 0, 0},\n{0, 0, 6.139960},\n{-2.894405, 0, 0},\n{0, -5.788810, 0}}",
    );
    let exact = 8.0 * std::f64::consts::PI;
    let fit = desk.json("skull.coef -l 4 -o a.txt");
    assert!((number(&fit, "mesh_volume") / exact - 1.0).abs() <= 1e-3, "{fit}");
    let desk = Desk::new().with("skull.coef", desk.text("skull.coef"));
    let info = desk.json("info skull.coef --unit mm");
    assert!((number(&info, "volume") / (1e-9 * exact) - 1.0).abs() <= 1e-3, "{info}");
    desk.done("convert skull.coef skull.ply");
    assert!((number(&desk.json("info skull.ply"), "volume") / exact - 1.0).abs() <= 1e-3);
    desk.refused("convert skull.coef b.txt", &["no radial shape", "`harmolux fit`"]);
    desk.put("rock.txt", "0 0 1\n1 0 0.1\n1 1 0 0\n");
    desk.refused("fit rock.txt -l 0 -o c.txt", &["these are coefficients already"]);
}

#[test]
fn points_that_cannot_be_fitted_are_refused() {
    let desk = desk();
    desk.put("few.xyz", "1 0 0\n0 1 0\n0 0 1\n");
    let words =
        ["few.xyz: 3 samples cannot determine the 16 coefficients", "to 0 or less", "lambda"];
    desk.refused("few.xyz -l 3 -o a.txt --centre 0,0,0", &words);
    desk.refused("few.xyz -l 0 -o a.txt --projection grid", &["have no faces", "least squares"]);
    desk.refused("few.xyz -l 200 -o a.txt --lambda 1", &["GB; the highest degree is 100"]);
    desk.put("bad.xyz", "1 0 0\n0 one 0\n");
    desk.refused("bad.xyz -l 0 -o a.txt", &["bad.xyz:2:3: `one` is not a finite number", "help: "]);
    desk.put("empty.csv", "");
    desk.refused("empty.csv -l 0 -o a.txt", &["no point stands in this file"]);
    desk.refused("none.csv -l 0 -o a.txt", &["none.csv: cannot read"]);
}

#[test]
fn least_squares_over_the_vertices_of_a_mesh_come_close() {
    let desk = desk();
    let head = Path::new(env!("CARGO_MANIFEST_DIR")).join("data/head.obj").display().to_string();
    let exact = desk.json(format!("{head} -l 8 -o a.txt"));
    let fit = desk.json(format!("{head} -l 8 -o b.txt --projection least-squares"));
    assert_eq!(fit["rms_by_parseval"], Value::Null);
    let [a, b] = [&exact, &fit].map(|fit| number(fit, "rms"));
    // The exact projection has the least error; least squares over 16 331 vertices comes within a
    // part in a thousand.
    assert!(a <= b && b <= 1.001 * a, "{a} {b}");
}

// Many meshes.

#[test]
fn many_meshes_are_fitted_into_a_folder_and_bad_ones_reported() {
    let desk = desk();
    for (name, side) in [("a.obj", 1.0), ("b.obj", 2.0), ("c.obj", 3.0)] {
        desk.put(name, cube(side));
    }
    desk.put("rail.obj", railed());
    desk.put("open.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    desk.put("scan.xyz", ellipsoid(100));
    let words = "a.obj rail.obj b.obj open.obj gone.obj c.obj scan.xyz -l 4";
    let tables = [1, 2].map(|threads| {
        let output = desk.run(format!("{words} -o out{threads} -j {threads}"));
        assert_eq!(output.code, 3, "{}", output.err);
        let said = output.err;
        for word in [
            "error: rail.obj: the mesh is not star-shaped",
            "error: open.obj: the mesh does not enclose a volume",
            "error: gone.obj: cannot read",
            "error: 3 of 7 could not be fitted: rail.obj, open.obj, gone.obj",
        ] {
            assert!(said.contains(word), "`{word}` is missing in:\n{said}");
        }
        assert!(output.out.contains("not fitted |"), "{}", output.out);
        let table = desk.text(&format!("out{threads}/fits.csv"));
        assert_eq!(fs::read_dir(desk.path(&format!("out{threads}"))).expect("there").count(), 5);
        table
    });
    for name in ["a.txt", "b.txt", "c.txt", "scan.txt"] {
        assert_eq!(desk.text(&format!("out1/{name}")), desk.text(&format!("out2/{name}")));
    }
    let mut rows = csv::Reader::from_reader(tables[0].as_bytes());
    let mut place = |name| rows.headers().expect("a header").iter().position(|h| h == name);
    let [name, mean, error, volume] =
        ["name", "mean_radius", "error", "mesh_volume"].map(|n| place(n).expect("a column"));
    let rows: Vec<csv::StringRecord> = rows.records().map(|r| r.expect("a row")).collect();
    assert_eq!(rows.len(), 7);
    for row in &rows {
        assert_eq!(row[mean].is_empty(), !row[error].is_empty(), "{row:?}");
    }
    assert_eq!(
        (&rows[2][name], rows[2][volume].parse::<f64>().expect("a number").round()),
        ("b.obj", 64.0)
    );
}

#[test]
fn many_meshes_answer_in_json_and_again() {
    let desk = desk();
    desk.put("a.obj", cube(1.0));
    desk.put("b.obj", cube(2.0));
    for _ in 0..2 {
        let report = desk.json("a.obj b.obj -l 2 -o out --force");
        assert_eq!(report["rows"][1]["name"], "b.obj");
        let [a, b] = [0, 1].map(|i| number(&report["rows"][i], "mean_radius"));
        assert!((b / a - 2.0).abs() <= 1e-12 && report["rows"][0]["error"] == Value::Null);
    }
    // One mesh into a folder is many, too: a pattern of the shell may match one.
    desk.done("a.obj -l 2 -o single");
    assert!(desk.path("single/a.txt").exists() && desk.path("single/fits.csv").exists());
}

#[test]
fn many_meshes_replace_nothing_of_others_and_collide_not() {
    let desk = desk();
    desk.put("a.obj", cube(1.0));
    desk.put("a.xyz", "1 0 0\n");
    desk.put("b.obj", cube(2.0));
    desk.refused("a.obj a.xyz -l 0 -o out", &["a.obj and a.xyz would both be written to"]);
    fs::create_dir(desk.path("out")).expect("made");
    desk.put("out/b.txt", "mine");
    desk.refused("a.obj b.obj -l 2 -o out", &["out/b.txt: this file is there already", "--force"]);
    assert_eq!(desk.text("out/b.txt"), "mine");
    desk.refused("a.obj b.obj -l 2 -o out/b.txt", &["cannot create"]);
    desk.done("a.obj b.obj -l 2 -o out --force");
}
