//! `mesh`, `spectrum`, `diff` and the plots of `sweep` as a user meets them: processes in a folder
//! of their own.

use std::fs;

use glam::DVec3;
use harmolux::fit::Shape;
use harmolux::io::coefficients::shtools_text;
use harmolux::sh::{Coefficients, Convention};

use crate::common::desk::{Desk, assert_says, number};

/// A folder with a ball of radius 1, one of radius 1.1 about another centre, and a bumpy body.
fn desk() -> Desk {
    Desk::new()
        .with("ball.txt", written(&shape(1.0, 0.0, DVec3::ZERO)))
        .with("moved.txt", written(&shape(1.1, 0.0, DVec3::new(0.25, 0.0, 0.0))))
        .with("bumpy.txt", written(&shape(1.0, 0.05, DVec3::ZERO)))
}

fn written(shape: &Shape) -> Vec<u8> {
    shtools_text::write(shape, Convention::default()).expect("a low degree")
}

fn shape(radius: f64, bumps: f64, centre: DVec3) -> Shape {
    let mut c = Coefficients::zeros(if bumps == 0.0 { 0 } else { 4 });
    c.set(0, 0, radius, 0.0);
    for l in 1..=c.lmax() {
        for m in 0..=l {
            c.set(l, m, bumps * ((3 * l + m) as f64).sin(), bumps * ((l + 5 * m) as f64).cos());
        }
    }
    Shape { centre, ..Shape::new(c) }
}

#[test]
fn diff_encloses_the_distance_of_two_balls() {
    let desk = desk();
    // On the axis through both centres the spheres reach from -1 to 1 and from -0.85 to 1.35: 0.35
    // apart on one side, seen from either.
    let found = desk.json(["diff", "ball.txt", "moved.txt"]);
    assert!(
        number(&found, "hausdorff_lower_m") <= 0.35 && number(&found, "hausdorff_upper_m") >= 0.35
    );
    assert!(number(&found, "hausdorff_upper_m") - number(&found, "hausdorff_lower_m") <= 4e-3);
    for one_sided in ["a_from_b_lower_m", "b_from_a_lower_m"] {
        assert!((number(&found, one_sided) - 0.35).abs() <= 4e-3);
    }
    assert!(found["radial_rms_m"].is_null() && found["within_tolerance"].is_null());
    assert_says(
        found["no_radial_because"].as_str().expect("a reason"),
        &["centres are 2.500e-1 m apart"],
    );
    let text = desk.done(["diff", "ball.txt", "moved.txt"]).out;
    assert_says(
        &text,
        &[
            "Hausdorff distance",
            "radial",
            "none: their centres",
            "normals differ by",
            "ratio 1.331",
        ],
    );
}

#[test]
fn diff_judges_a_tolerance_by_the_upper_bound() {
    let desk = desk();
    let ball = ["diff", "ball.txt", "bumpy.txt", "--tolerance"];
    let near = desk.json([&ball[..], &["0.5"]].concat());
    assert_eq!(near["within_tolerance"], true);
    let radial = number(&near, "radial_max_m");
    let far = desk.ends(4, [&ball[..], &["1cm"]].concat());
    assert_says(&far.err, &["is above the tolerance of 0.01000 m"]);
    // A distance in space is never more than the one along the radius.
    assert!(number(&near, "hausdorff_lower_m") <= radial);
    let wrong = desk.ends(2, [&ball[..], &["0"]].concat());
    assert_says(&wrong.err, &["a positive length in metres or with its unit"]);
}

#[test]
fn diff_writes_its_numbers_and_refuses_what_it_cannot_use() {
    let desk = desk();
    desk.done(["diff", "ball.txt", "bumpy.txt", "-o", "diff.csv"]);
    let table = fs::read_to_string(desk.path("diff.csv")).expect("there");
    assert_says(
        &table,
        &["a,b,quantity,value,unit\n", "ball.txt,bumpy.txt,hausdorff_upper,", "volume_a,"],
    );
    desk.refused(["diff", "ball.txt", "none.txt"], &["none.txt: cannot read"]);
    desk.put("negative.txt", written(&shape(-1.0, 0.0, DVec3::ZERO)));
    desk.refused(
        ["diff", "ball.txt", "negative.txt"],
        &["ball.txt and negative.txt: ", "the radius towards"],
    );
    fs::write(desk.path("notes.csv"), "my notes\n").expect("written");
    desk.refused(
        ["diff", "ball.txt", "ball.txt", "-o", "notes.csv"],
        &["notes.csv: this file is there already"],
    );
}

#[test]
fn spectrum_is_that_of_the_coefficients() {
    let desk = desk();
    let rows = desk.json(["spectrum", "bumpy.txt", "ball.txt"]);
    let rows = rows["rows"].as_array().expect("rows");
    assert_eq!(rows.len(), 6);
    let f = shape(1.0, 0.05, DVec3::ZERO).coefficients;
    for (l, row) in rows.iter().enumerate().take(5) {
        let power = f.degree_deviation(l).powi(2) / (2 * l + 1) as f64;
        assert!((number(row, "power_m2") / power - 1.0).abs() <= 1e-12);
    }
    assert_eq!((&rows[5]["shape"], number(&rows[5], "power_m2")), (&"ball".into(), 1.0));
    let text = desk.done(["spectrum", "bumpy.txt"]).out;
    assert_says(&text, &["| degree |", "| 4 "]);
}

#[test]
fn spectra_are_plotted_to_files_and_to_the_terminal() {
    let desk = desk();
    let files = ["-o", "s.svg", "-o", "s.png", "-o", "s.csv"];
    for _ in 0..2 {
        desk.done([&["spectrum", "bumpy.txt", "--force"], &files[..]].concat());
    }
    assert_says(
        &fs::read_to_string(desk.path("s.svg")).expect("there"),
        &["<svg", "Power per degree"],
    );
    assert!(fs::read(desk.path("s.png")).expect("there").starts_with(b"\x89PNG"));
    let plot = desk.done(["spectrum", "bumpy.txt", "--plot"]).out;
    assert!(plot.contains("Power per degree") && !plot.contains('\x1b'), "{plot}");
    desk.refused(["spectrum", "bumpy.txt", "-o", "s.jpg"], &["name a file .csv, .svg or .png"]);
    desk.refused(["spectrum", "ball.txt", "--plot"], &["there is nothing to plot"]);
}

#[test]
fn meshes_are_made_in_each_way_and_stand_for_the_coefficients() {
    let desk = desk();
    let ways: [(&str, &[&str], u64); 3] = [
        ("a.obj", &["--resolution", "4"], 320),
        ("b.ply", &["--lat-long", "6x9"], 90),
        ("c.stl", &["--tolerance", "5mm"], 0),
    ];
    for (file, way, faces) in ways {
        let made = desk.json([&["mesh", "bumpy.txt", "-o", file], way].concat());
        assert!(faces == 0 || made["faces"] == faces, "{made}");
        let (error, bound) = (number(&made, "chord_error"), number(&made, "chord_error_bound"));
        assert!(error <= bound && (faces > 0 || error <= 5e-3), "{made}");
        let info = desk.json(["info", file]);
        assert_eq!(info["faces"], made["faces"]);
        // What diff encloses is at most what the mesh said of itself; STL rounds to f32.
        let diff = desk.json(["diff", "bumpy.txt", file, "--width", "4mm"]);
        assert!(number(&diff, "hausdorff_lower_m") <= bound + 1e-6, "{diff}");
    }
}

#[test]
fn meshes_that_cannot_be_made_are_refused() {
    let desk = desk();
    desk.refused(
        ["mesh", "ball.txt", "-o", "ball.glb"],
        &["meshes are written as .obj, .ply or .stl"],
    );
    desk.refused(["mesh", "ball.txt", "-o", "b.ply", "--tolerance", "1e-15"], &["takes more than"]);
    desk.refused(["mesh", "ball.txt", "-o", "b.ply", "--resolution", "100000"], &["is too large"]);
    desk.put("negative.txt", written(&shape(-1.0, 0.0, DVec3::ZERO)));
    desk.refused(["mesh", "negative.txt", "-o", "b.ply"], &["negative.txt: the radius towards"]);
    let both =
        desk.ends(2, ["mesh", "ball.txt", "-o", "b.ply", "--resolution", "4", "--lat-long", "4x4"]);
    assert_says(&both.err, &["cannot be used with"]);
}

#[test]
fn the_map_of_a_difference_is_a_coloured_mesh() {
    let desk = desk();
    let done = desk.done(["diff", "ball.txt", "moved.txt", "--map", "map.ply"]);
    assert_says(&done.err, &["map.ply: blue -0.", "red +0.", "b is outside a"]);
    let bytes = fs::read(desk.path("map.ply")).expect("there");
    assert_says(&String::from_utf8_lossy(&bytes[..400]), &["harmolux", "property uchar red"]);
}
