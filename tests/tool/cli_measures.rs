//! What bodies measure, as a user meets it: `info`, the table of `fit`, and `evaluate`.

use std::f64::consts::PI;

use glam::DVec3;
use harmolux::fit::Shape;
use harmolux::io::coefficients::shtools_text;
use harmolux::sh::{Coefficients, Convention};
use serde_json::Value;

use crate::common::desk::{Desk, assert_says};

/// A box of 3 x 2 x 1 about (10, 20, 30).
const CUBOID: &str = "v 8.5 19 29.5\nv 11.5 19 29.5\nv 11.5 21 29.5\nv 8.5 21 29.5\n\
    v 8.5 19 30.5\nv 11.5 19 30.5\nv 11.5 21 30.5\nv 8.5 21 30.5\n\
    f 4 3 2 1\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n";

/// A ball of radius 2 with a long head: r = 2 + cos(theta) / 2.
fn pear() -> Shape {
    let mut c = Coefficients::zeros(1);
    c.set(0, 0, 2.0, 0.0);
    c.set(1, 0, 0.5, 0.0);
    Shape { centre: DVec3::new(1.0, 2.0, 3.0), ..Shape::new(c) }
}

fn desk() -> Desk {
    let text = shtools_text::write(&pear(), Convention::default()).expect("low degree");
    Desk::new().with("box.obj", CUBOID).with("pear.txt", text)
}

fn near(value: &Value, exact: f64) {
    let value = value.as_f64().expect("a number");
    assert!((value - exact).abs() <= 1e-10 * exact.abs(), "{value} is not {exact}");
}

#[test]
fn measures_of_a_mesh_follow_its_unit() {
    let desk = desk();
    for (unit, metres) in [("m", 1.0_f64), ("km", 1e3), ("um", 1e-6), ("mm", 1e-3)] {
        let said = desk.json(["info", "box.obj", "--unit", unit]);
        near(&said["volume"], 6.0 * metres.powi(3));
        near(&said["area"], 22.0 * metres.powi(2));
        for (found, exact) in [(0, 10.0), (1, 20.0), (2, 30.0)] {
            near(&said["centroid"][found], exact * metres);
        }
        // m (b^2 + c^2) / 12.
        for (found, exact) in [(0, 2.5), (1, 5.0), (2, 6.5)] {
            near(&said["inertia"][found], exact * metres.powi(5));
        }
        near(&said["principal_axes"][0][0].as_f64().map(f64::abs).into(), 1.0);
        near(&said["sphericity"], PI.cbrt() * 36.0_f64.powf(2.0 / 3.0) / 22.0);
        near(&said["elongation"], 2.0 / 3.0);
        near(&said["flatness"], 0.5);
        near(&said["bounds"][1][2], 30.5 * metres);
    }
    let said = desk.done("info box.obj --unit cm").out;
    let roughness = "roughness         0.001";
    assert_says(
        &said,
        &["centroid          (0.1000, 0.2000, 0.3000) m", "m5, principal", roughness],
    );
}

#[test]
fn measures_of_an_open_mesh_and_of_no_surface_are_null() {
    let desk = desk();
    desk.put("open.obj", CUBOID.trim_end().rsplit_once('\n').expect("a last face").0);
    let said = desk.json("info open.obj");
    for key in ["centroid", "inertia", "semi_axes", "sphericity", "flatness", "roughness"] {
        assert_eq!(said.get(key), Some(&Value::Null), "{key}");
    }
    desk.put("none.txt", "0, 0, 1, 0\n1, 0, 2, 0\n1, 1, 0, 0\n");
    let said = desk.json_at(3, "info none.txt --normalisation 4pi");
    assert_eq!((&said["area"], &said["sphericity"]), (&Value::Null, &Value::Null));
}

#[test]
fn what_is_said_of_coefficients_is_refused_of_meshes_and_points() {
    let desk = desk();
    desk.put("cloud.xyz", "1 0 0\n0 2 0\n0 0 3\n");
    for (flags, named) in [
        ("--normalisation ortho", "`--normalisation`"),
        ("--normalisation 4pi --csphase -1", "`--normalisation` and `--csphase`"),
        ("--add-radius 1", "`--add-radius`"),
        ("--row 2", "`--row`"),
    ] {
        for (file, kind) in [("box.obj", "a mesh"), ("cloud.xyz", "points")] {
            let said = desk.ends(3, &*format!("info {file} {flags}"));
            assert_says(&said.err, &[file, kind, &format!("leave out {named}")]);
        }
    }
    let said = desk.json("info cloud.xyz --unit cm");
    near(&said["bounds"][1][2], 0.03);
}

#[test]
fn fits_have_the_measures_of_their_series() {
    let desk = desk();
    desk.put("cloud.xyz", "1 0 0\n-1 0 0\n0 1 0\n0 -1 0\n0 0 1\n0 0 -1\n");
    let said = desk.json("fit box.obj cloud.xyz -l 0 -o fits --unit cm");
    for (row, radius, centre) in [(0, None, 0.1), (1, Some(0.01), 0.0)] {
        let row = &said["rows"][row];
        let number = |name: &str| row[name].as_f64().expect("a number");
        let radius = radius.unwrap_or(number("mean_radius"));
        near(&row["area"], 4.0 * PI * radius * radius);
        near(&row["volume"], 4.0 / 3.0 * PI * radius.powi(3));
        near(&row["inertia_3"], 8.0 / 15.0 * PI * radius.powi(5));
        near(&row["semi_axis_b"], radius);
        near(&row["sphericity"], 1.0);
        assert!((number("centroid_x") - centre).abs() <= 1e-12);
        assert!(number("roughness") <= 1e-12 * radius);
    }
}

#[test]
fn directions_of_every_kind_give_the_same_points() {
    let desk = desk();
    desk.put("places.csv", "name,lon,lat\nnorth,0,90\nside,90,0\nlow,-120,-30\n");
    let said = desk.json("evaluate pear.txt --at 90,0;0,90 --at -30,-120");
    let rows = said["rows"].as_array().expect("rows");
    assert_eq!(
        rows,
        desk.json("evaluate pear.txt --points places.csv")["rows"].as_array().expect("rows")
    );
    assert_eq!(rows.len(), 3);
    for (row, radius) in rows.iter().zip([2.5, 2.0, 1.75]) {
        near(&row["radius_m"], radius);
    }
    near(&rows[0]["z_m"], 5.5);
    near(&rows[1]["y_m"], 4.0);
    // The slope of 2 + cos(theta) / 2 at the equator is -1/2 per radian southwards.
    near(&rows[1]["normal_y"], 2.0 / 4.25_f64.sqrt());
    near(&rows[1]["normal_z"], -0.5 / 4.25_f64.sqrt());
    let said = desk.done("evaluate pear.txt --at 0,90").out;
    assert_says(&said, &["latitude", "2.000000", "4.000000", "0.970143"]);
}

#[test]
fn grid_is_table_array_and_map() {
    let desk = desk();
    let command = "evaluate pear.txt --grid 5x8 -o g.csv -o g.npy -o g.png -o g.svg";
    let said = desk.done(command);
    assert_says(&said.out, &["40", "1.500000 m at latitude -90", "2.500000 m at latitude 90"]);
    let bytes = desk.bytes("g.npy");
    assert_says(&String::from_utf8_lossy(&bytes[..128]), &["'<f8'", "'shape': (5, 8)"]);
    let (radii, rest) = bytes[128..].as_chunks();
    let radii: Vec<f64> = radii.iter().map(|bytes| f64::from_le_bytes(*bytes)).collect();
    assert!((radii.len(), rest.len()) == (40, 0));
    for (i, radius) in radii.iter().enumerate() {
        let latitude = (90.0 - 45.0 * (i / 8) as f64).to_radians();
        assert!((radius - 2.0 - 0.5 * latitude.sin()).abs() <= 1e-14);
    }
    let table = desk.text("g.csv");
    assert_eq!(table.lines().count(), 41);
    assert!(table.lines().nth(10).is_some_and(|row| row.starts_with("45.0,45.0,2.35")), "{table}");
    // What it wrote is read again as directions.
    let again = desk.json("evaluate pear.txt --points g.csv");
    assert_eq!(again["rows"].as_array().map(Vec::len), Some(40));
    let map = image::open(desk.path("g.png")).expect("a PNG").into_rgb8();
    assert!(map.width() > 640 && map.height() > 400);
    assert_says(&desk.ends(3, command).err, &["g.csv"]);
}

#[test]
fn what_cannot_be_evaluated_is_told() {
    let desk = desk();
    desk.put("bad.csv", "latitude,longitude\n0,0\n-90.5,0\n");
    desk.put("two.csv", "name,shcoeffs_L0M0C\na,1\nb,2\n");
    for (code, words, says) in [
        (2, "evaluate pear.txt", "--at"),
        (2, "evaluate pear.txt --at 91,0", "from -90 to 90 degrees, not 91"),
        (2, "evaluate pear.txt --at nan,0", "write latitude and longitude"),
        (2, "evaluate pear.txt --at 1", "write latitude and longitude"),
        (2, "evaluate pear.txt --grid 1x8", "write latitudes x longitudes"),
        (2, "evaluate pear.txt --grid 0x0", "write latitudes x longitudes"),
        (2, "evaluate pear.txt --grid 3x4 --at 0,0", "cannot be used with"),
        (3, "evaluate pear.txt --at 0,0 -o a.npy", "give `--grid NLATxNLON`"),
        (3, "evaluate pear.txt --at 0,0 -o a.obj", ".csv, .npy, .png or .svg"),
        (3, "evaluate pear.txt --points bad.csv", "bad.csv:3: a latitude is from -90 to 90"),
        (3, "evaluate two.csv --at 0,0", "`--row`"),
        (3, "evaluate box.obj --at 0,0", "box.obj"),
    ] {
        assert_says(&desk.ends(code, words).err, &[says]);
    }
    near(&desk.json("evaluate two.csv --row 2 --at 0,0")["rows"][0]["radius_m"], 2.0);
}
