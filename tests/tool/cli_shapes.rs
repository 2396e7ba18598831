//! The verbs that make shapes of shapes, and of chance, as a user meets them: `transform`, `mean`,
//! `random`.

use std::fs;

use glam::DVec3;
use harmolux::fit::Shape;
use harmolux::io::coefficients;
use harmolux::io::coefficients::shtools_text;
use harmolux::sh::{Coefficients, Convention, Series, Solid, Spectrum, mirrored, volume};
use serde_json::Value;

use crate::common::desk::{Desk, assert_says};

/// A folder with `lump.txt`.
fn desk() -> Desk {
    Desk::new().with("lump.txt", written(&lump()))
}

fn written(shape: &Shape) -> Vec<u8> {
    shtools_text::write(shape, Convention::default()).expect("low degree")
}

fn shape(desk: &Desk, name: &str) -> Shape {
    coefficients::read(&desk.path(name), &coefficients::ReadOptions::default()).expect("a shape")
}

/// Runs the tool, which must end with this code and say these words.
fn refused(desk: &Desk, code: i32, words: &[&str], says: &[&str]) {
    assert_says(&desk.ends(code, words).err, says);
}

/// A body of degree 6 without any symmetry, its expansion centre off the origin.
fn lump() -> Shape {
    let mut c = Coefficients::zeros(6);
    c.set(0, 0, 1.0, 0.0);
    for l in 1..=6 {
        for m in 0..=l {
            let k = 0.2 / (l * l) as f64;
            c.set(l, m, k * ((3 * l + m) as f64).sin(), k * ((l + 5 * m) as f64).cos());
        }
    }
    Shape { centre: DVec3::new(1.0, 2.0, 3.0), ..Shape::new(c) }
}

fn value(shape: &Shape, w: DVec3) -> f64 {
    Series::new(&shape.coefficients).expect("low degree").value(w)
}

fn number(value: &Value) -> f64 {
    value.as_f64().expect("a number")
}

#[test]
fn turns_of_each_kind_agree() {
    let desk = desk();
    // A third of a turn about (1, 1, 1): x goes to y, y to z, z to x.
    for (i, turn) in [
        &["--axis", "1,1,1", "--angle", "120"][..],
        &["--quaternion", "1,1,1,1"],
        &["--matrix", "0,0,1,1,0,0,0,1,0"],
        &["--euler", "0,90,90"],
    ]
    .into_iter()
    .enumerate()
    {
        let out = format!("turned-{i}.txt");
        let said = desk.json([&["transform", "lump.txt", "-o", &out], turn].concat());
        assert!((number(&said["rotation"][1][0]) - 1.0).abs() <= 1e-14, "{said}");
        let turned = shape(&desk, &out);
        assert!((turned.centre - DVec3::new(3.0, 1.0, 2.0)).length() <= 1e-14);
        let w = DVec3::new(0.6, 0.0, 0.8);
        let there = value(&turned, DVec3::new(w.z, w.x, w.y));
        assert!((there - value(&lump(), w)).abs() <= 1e-14, "{turn:?}");
    }
}

#[test]
fn steps_are_taken_in_the_documented_order() {
    let desk = desk();
    let steps = ["--to-origin", "--scale", "2", "--mirror", "x", "-l", "4"];
    desk.json([&["transform", "lump.txt", "-o", "out.txt"][..], &steps].concat());
    let expected = mirrored(&lump().coefficients.truncated(4), harmolux::sh::Axis::X).scaled(2.0);
    let out = shape(&desk, "out.txt");
    assert_eq!((out.centre, out.truncated_from), (DVec3::ZERO, Some(6)));
    for l in 0..=4 {
        for m in 0..=l {
            let ((a, b), (c, d)) = (out.coefficients.get(l, m), expected.get(l, m));
            // Two units in the last place through the file.
            assert!((a - c).abs() <= 1e-15 && (b - d).abs() <= 1e-15);
        }
    }
}

#[test]
fn rocks_are_brought_into_a_standard_position() {
    let desk = desk();
    let steps = ["-l", "24", "--recentre", "centroid", "--align", "--to-origin"];
    let said = desk.json([&["transform", "lump.txt", "-o", "out.txt"][..], &steps].concat());
    assert_eq!(said["aligned"]["axes"], "three axes");
    let rms = number(&said["recentred"]["rms"]);
    assert!(rms <= 1e-6, "{rms}");
    let solid = Solid::of(&shape(&desk, "out.txt").coefficients).expect("valid");
    let first = volume(&lump().coefficients).expect("valid");
    // |dV| <= 4 pi R^2 rms with R = 2 above all radii; the file keeps 17 digits.
    assert!((solid.volume - first).abs() <= 16.0 * std::f64::consts::PI * rms + 1e-12);
    assert!(solid.centroid.length() <= 1e-6);
    let i = solid.inertia_about_origin;
    assert!(i.x_axis.x < i.y_axis.y && i.y_axis.y < i.z_axis.z);
    assert!(i.x_axis.y.abs() + i.x_axis.z.abs() + i.y_axis.z.abs() <= 1e-6);
}

#[test]
fn bad_transforms_are_refused_and_write_nothing() {
    let desk = desk();
    fs::write(desk.path("foreign.txt"), "a poem").expect("written");
    let to = |out: &'static str| ["transform", "lump.txt", "-o", out];
    let with = |rest: &[&'static str]| [&to("out.txt")[..], rest].concat();
    refused(&desk, 3, &with(&["--recentre", "9,9,9"]), &["lump.txt", "star-shaped", "theta = "]);
    refused(&desk, 3, &with(&["--scale", "0"]), &["scale"]);
    refused(&desk, 3, &with(&["--axis", "0,0,0", "--angle", "1"]), &["axis"]);
    refused(&desk, 2, &with(&["--matrix", "1,0,0,0,1,0,0,0,-1"]), &["determinant"]);
    refused(&desk, 2, &with(&["--matrix", "1,0,0,0,1,0,0,0,2"]), &["no rotation"]);
    refused(&desk, 2, &with(&["--quaternion", "0,0,0,0"]), &["not zero"]);
    refused(&desk, 2, &with(&["--euler", "1,2"]), &["3 numbers"]);
    refused(&desk, 2, &with(&["--recentre", "middle"]), &["centroid"]);
    refused(&desk, 2, &with(&["--align", "--euler", "1,2,3"]), &["cannot be used with"]);
    refused(&desk, 2, &with(&["--axis", "0,0,1"]), &["--angle"]);
    refused(&desk, 3, &to("foreign.txt"), &["--force"]);
    refused(&desk, 3, &["transform", "none.txt", "-o", "out.txt"], &["none.txt"]);
    assert!(!desk.path("out.txt").exists());
    assert_eq!(fs::read(desk.path("foreign.txt")).expect("there"), b"a poem");
}

#[test]
fn shape_without_a_positive_radius_is_not_aligned() {
    let desk = desk();
    let mut c = Coefficients::zeros(1);
    c.set(0, 0, 1.0, 0.0);
    c.set(1, 0, 2.0, 0.0);
    desk.put("bad.txt", written(&Shape::new(c)));
    let align = ["transform", "bad.txt", "-o", "out.txt", "--align"];
    refused(&desk, 3, &align, &["bad.txt", "positive in every direction"]);
    // Turning it is well defined.
    desk.json(["transform", "bad.txt", "-o", "out.txt", "--mirror", "z"]);
    assert_eq!(shape(&desk, "out.txt").coefficients.get(1, 0).0, -2.0);
}

#[test]
fn mean_of_a_shape_and_its_mirror_image_is_symmetric() {
    let desk = desk();
    desk.json(["transform", "lump.txt", "-o", "twin.txt", "--mirror", "y"]);
    let said = desk.json(["mean", "lump.txt", "twin.txt", "-o", "mean.txt"]);
    let mean = shape(&desk, "mean.txt");
    assert!(mean.coefficients.sines().iter().all(|b| *b == 0.0));
    assert_eq!(mean.centre, DVec3::new(1.0, 0.0, 3.0));
    let [first, second] = [0, 1].map(|i| number(&said["distances"][i]["rms"]));
    assert!((first - second).abs() <= 1e-15 && first > 0.01);
    // Of two the sample deviation is sqrt 2 times the distance from the mean.
    assert!((number(&said["scatter"]) - 2.0_f64.sqrt() * first).abs() <= 1e-14);
    let table = desk.done(["mean", "lump.txt", "twin.txt", "-o", "mean.txt", "--force"]);
    assert!(table.out.contains("| twin.txt |"));
}

#[test]
fn weights_count_and_must_fit() {
    let desk = desk();
    let mut c = Coefficients::zeros(0);
    c.set(0, 0, 3.0, 0.0);
    desk.put("ball.txt", written(&Shape::new(c)));
    let base = ["mean", "lump.txt", "ball.txt", "-o", "mean.txt", "--weights"];
    let said = desk.json([&base[..], &["3,1"]].concat());
    assert!((number(&said["mean_radius"]) - 1.5).abs() <= 1e-15);
    assert_eq!((&said["degree"], &said["scatter"]), (&Value::from(6), &Value::Null));
    fs::remove_file(desk.path("mean.txt")).expect("written before");
    refused(&desk, 3, &[&base[..], &["1"]].concat(), &["2 shapes need 2 weights"]);
    refused(&desk, 3, &[&base[..], &["1,0"]].concat(), &["positive", "number 2"]);
    refused(&desk, 2, &["mean", "-o", "mean.txt"], &["SHAPES"]);
    assert!(!desk.path("mean.txt").exists());
}

#[test]
fn random_shapes_depend_on_their_seed_alone() {
    let desk = desk();
    let law = ["random", "--gaussian-sphere", "sigma=0.15,nu=4", "-l", "12"];
    desk.json([&law[..], &["--count", "3", "--seed", "5", "-o", "rocks"]].concat());
    desk.json([&law[..], &["--seed", "6", "-j", "1", "-o", "six.txt"]].concat());
    assert_eq!(shape(&desk, "rocks/6.txt"), shape(&desk, "six.txt"));
    assert_ne!(shape(&desk, "rocks/7.txt"), shape(&desk, "six.txt"));
    assert_eq!(fs::read_dir(desk.path("rocks")).expect("made").count(), 3);
}

#[test]
fn spectra_of_shapes_and_tables_give_strangers() {
    let desk = desk();
    let said = desk.json(["random", "--spectrum", "lump.txt", "--seed", "3", "-o", "other.txt"]);
    let (lump, other) = (lump(), shape(&desk, "other.txt"));
    assert!((other.coefficients.mean() - 1.0).abs() <= 1e-15);
    assert_eq!(other.coefficients.lmax(), 6);
    assert_ne!(lump.coefficients, other.coefficients);
    let deviation = Spectrum::of(&other.coefficients).deviation();
    assert!((number(&said["shapes"][0]["deviation"]) - deviation).abs() <= 1e-14);

    // The table that `spectrum` writes is read back: the same body.
    desk.json(["spectrum", "lump.txt", "-o", "lump.csv"]);
    desk.json(["random", "--spectrum", "lump.csv", "--seed", "3", "-o", "same.txt"]);
    let same = shape(&desk, "same.txt").coefficients;
    assert!((same.get(3, 2).0 - other.coefficients.get(3, 2).0).abs() <= 1e-14);

    fs::write(desk.path("s.csv"), "degree,power\n2,0.001\n3,0.002\n").expect("written");
    desk.json(["random", "--spectrum", "s.csv", "--radius", "2", "-l", "5", "-o", "out.txt"]);
    let out = shape(&desk, "out.txt").coefficients;
    assert_eq!((out.lmax(), out.get(1, 1), out.get(4, 2)), (5, (0.0, 0.0), (0.0, 0.0)));
    assert!((out.mean() - 2.0).abs() <= 1e-15);
}

#[test]
fn bad_laws_are_refused_and_leave_no_folder() {
    let desk = desk();
    let refused = |code, law: &[&str], words: &[&str]| {
        refused(&desk, code, &[&["random", "-l", "8", "-o", "out.txt"][..], law].concat(), words);
    };
    refused(3, &["--gaussian-sphere", "sigma=0.2"], &["`nu` is missing"]);
    refused(3, &["--gaussian-sphere", "sigma=0.2,nu=3,mu=1"], &["no setting `mu`", "first"]);
    refused(3, &["--gaussian-sphere", "sigma=-1,nu=3"], &["within 0 to 10"]);
    refused(3, &["--gaussian-sphere", "sigma=3,nu=2"], &["seed 1", "not positive"]);
    refused(3, &["--power-law", "rms=0.1,exponent=3,first=20"], &["first <= last"]);
    refused(3, &["--power-law", "rms=0.1,exponent=3", "--radius", "0"], &["mean radius"]);
    refused(2, &["--power-law", "rms:0.1"], &["NAME=NUMBER"]);
    refused(2, &["--power-law", "rms=1,exponent=1", "--spectrum", "x"], &["cannot be used with"]);
    refused(2, &[], &["--gaussian-sphere"]);
    fs::write(desk.path("s.csv"), "degree,power\n2,0.001\n4,0.002\n").expect("written");
    refused(3, &["--spectrum", "s.csv"], &["s.csv:3", "degree 3 must come"]);
    refused(3, &["--spectrum", "none.csv"], &["none.csv"]);
    assert!(!desk.path("out.txt").exists());
    let many = ["random", "--gaussian-sphere", "sigma=-1,nu=3", "--count", "3", "-o", "rocks"];
    desk.refused(many, &["within 0 to 10"]);
    assert!(!desk.path("rocks").exists());
}
