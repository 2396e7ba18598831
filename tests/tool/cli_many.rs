//! Many shapes as a user meets them: tables with a row a shape, one centre and alignment for all,
//! modes of variation.

use std::fs;

use glam::DVec3;
use harmolux::fit::Shape;
use harmolux::io::coefficients::{NamedShape, ReadOptions, read, read_all, shtools_text};
use harmolux::sh::{Coefficients, Convention, best_rotation, difference, rotate};

use crate::common::desk::{Desk, assert_says, number};
use crate::common::solids::cube;

/// A folder with boxes a.obj, b.obj and c.obj off the origin, of three sizes.
fn boxes() -> Desk {
    let desk = Desk::new();
    for (name, k) in [("a", 1.0), ("b", 2.0), ("c", 3.0)] {
        desk.put(&format!("{name}.obj"), moved(k));
    }
    desk
}

/// A cube of half a side k, longer along x, its middle at (0.1, 0.2, 0.3).
fn moved(k: f64) -> String {
    let line = |line: &str| match line.strip_prefix("v ") {
        Some(point) => {
            let p: Vec<f64> =
                point.split_whitespace().map(|v| v.parse().expect("a number")).collect();
            format!("v {} {} {}\n", (1.0 + 0.1 * k) * p[0] + 0.1, p[1] + 0.2, p[2] + 0.3)
        }
        None => format!("{line}\n"),
    };
    cube(k).lines().map(line).collect()
}

/// A body of degree 3 without symmetry, varied by k.
fn body(k: f64) -> Shape {
    let mut c = Coefficients::zeros(3);
    c.set(0, 0, 1.0, 0.0);
    for l in 1..=3 {
        for m in 0..=l {
            let t = (5 * l + 2 * m) as f64;
            c.set(l, m, 0.05 * (t + 0.4 * k).sin(), 0.05 * (2.0 * t - 0.3 * k * k).cos());
        }
    }
    Shape { centre: DVec3::new(k, 0.0, 0.0), ..Shape::new(c) }
}

fn bodies(count: u32) -> Desk {
    let desk = Desk::new();
    for k in 0..count {
        let text = shtools_text::write(&body(f64::from(k)), Convention::default());
        desk.put(&format!("s{k}.txt"), text.expect("low degree"));
    }
    desk
}

fn shape(desk: &Desk, name: &str) -> Shape {
    read(&desk.path(name), &ReadOptions::default()).expect("a shape")
}

fn distance(a: &Shape, b: &Shape) -> f64 {
    difference(&a.coefficients, &b.coefficients).energy().sqrt()
}

#[test]
fn table_of_a_batch_grows_with_it_and_goes_on() {
    let desk = boxes();
    for layout in ["harmolux", "aics"] {
        let words = format!(
            "fit a.obj b.obj c.obj -l 3 -o {layout} --table {layout}.csv --table-layout {layout}"
        );
        desk.done(&*words);
        let whole = desk.text(&format!("{layout}.csv"));
        let rows: Vec<&str> = whole.lines().collect();
        assert_eq!(rows.len(), 4);
        // Nothing is fitted again, and nothing changes.
        desk.done(&*words);
        assert_eq!(desk.text(&format!("{layout}.csv")), whole);
        // A row that was cut off or never there is made of the file, one without file anew.
        let cut = &rows[3][..30];
        desk.put(&format!("{layout}.csv"), format!("{}\n{}\n{cut}", rows[0], rows[1]));
        fs::remove_file(desk.path(&format!("{layout}/c.txt"))).expect("it was written");
        desk.done(&*words);
        let table = read_all(&desk.path(&format!("{layout}.csv")), &ReadOptions::default());
        let table = table.expect("a table");
        assert_eq!(table.iter().map(NamedShape::name).collect::<Vec<_>>(), ["a", "b", "c"]);
        for row in &table {
            let file = shape(&desk, &format!("{layout}/{}.txt", row.name()));
            assert!(distance(&row.shape, &file) <= 1e-14);
            assert!(layout == "aics" || row.shape.centre == file.centre);
        }
        // The mean of the rows is that of the files.
        desk.done(format!("mean {layout}.csv -o {layout}_rows.txt"));
        let files = ["a", "b", "c"].map(|name| format!("{layout}/{name}.txt")).join(" ");
        desk.done(format!("mean {files} -o {layout}_files.txt"));
        let [rows, files] = ["rows", "files"].map(|of| shape(&desk, &format!("{layout}_{of}.txt")));
        assert!(distance(&rows, &files) <= 1e-14);
        assert!(layout == "aics" || (rows.centre - files.centre).length() <= 1e-15);
    }
    // What an earlier run made and this one was not asked for stays, and is told.
    let said = desk.done("fit a.obj -l 3 -o harmolux --table harmolux.csv").err;
    assert_says(&said, &["fits.csv keeps 2 rows of an earlier", "harmolux.csv keeps 2 rows of an"]);
    // Rows of other settings are of another run.
    let words = "fit a.obj -l 3 -o other --table harmolux.csv --centre centroid";
    assert_says(&desk.ends(3, words).err, &["harmolux.csv: the row of a is of another run"]);
    let words = "fit a.obj -l 3 -o a.txt --table t.csv";
    assert_says(&desk.ends(3, words).err, &["`--table` is for fits into a folder"]);
    desk.ends(2, "fit a.obj -l 3 -o a.txt --table-layout aics");
}

#[test]
fn one_rule_of_the_centre_is_for_all() {
    let desk = boxes();
    let middle = DVec3::new(0.1, 0.2, 0.3);
    for (rule, expected) in [
        ("origin", DVec3::ZERO),
        ("centroid", middle),
        ("best", middle),
        ("0.1,0.1,0.1", DVec3::splat(0.1)),
    ] {
        desk.done(format!("fit a.obj b.obj -l 2 -o out --force --centre {rule}"));
        for name in ["a", "b"] {
            let centre = shape(&desk, &format!("out/{name}.txt")).centre;
            // Along the long side of a box the best centre is one of many.
            let mut off = centre - expected;
            off.x *= if rule == "best" { 0.0 } else { 1.0 };
            assert!(off.length() <= 1e-5, "{rule}: {centre}");
        }
    }
    let said = desk.ends(2, "fit a.obj -l 2 -o a.txt --centre middle").err;
    assert_says(&said, &["write three numbers", "origin, centroid, best"]);
}

#[test]
fn shapes_are_turned_to_the_one_they_are_aligned_to() {
    let desk = bodies(1);
    desk.done("transform s0.txt -o turned.txt --euler 40,70,10");
    for (from, to) in [("s0", "a"), ("turned", "b")] {
        desk.done(format!("mesh {from}.txt -o {to}.obj --resolution 16"));
    }
    let words = "a.obj b.obj -l 3 -o out --align-to s0.txt --centre";
    let centres = [shape(&desk, "s0.txt").centre, shape(&desk, "turned.txt").centre];
    let reference = shape(&desk, "s0.txt");
    for (name, c) in ["a", "b"].into_iter().zip(centres) {
        let (x, y, z) = (c.x, c.y, c.z);
        let line =
            format!("fit {name}.obj -l 3 -o {name}.txt --align-to s0.txt --centre {x},{y},{z}");
        let json = desk.json(&*line);
        assert_eq!(json["rotation"].as_array().map(Vec::len), Some(3));
        let found = shape(&desk, &format!("{name}.txt"));
        // The mesh of 5120 faces is off by a thousandth, in both axes a little differently.
        assert!(distance(&found, &reference) <= 0.01, "{name}");
        let left = best_rotation(&found.coefficients, &reference.coefficients);
        assert!(left.angle() <= 1e-9, "{}", left.angle());
        assert_eq!(rotate(&found.coefficients, &left).lmax(), 3);
    }
    desk.done(format!("fit {words} {},0,0", centres[0].x));
    let table = desk.text("out/fits.csv");
    let header = table.lines().next().expect("a header");
    assert!(header.contains(",alpha_degrees,beta_degrees,gamma_degrees,seconds,"), "{header}");
}

#[test]
fn rows_are_shapes_wherever_there_are_many() {
    let desk = boxes();
    desk.done("fit a.obj b.obj c.obj -l 2 -o out --table t.csv");
    let spectrum = desk.json("spectrum t.csv");
    let shapes: Vec<_> =
        spectrum["rows"].as_array().expect("rows").iter().map(|r| r["shape"].clone()).collect();
    assert_eq!((shapes.len(), &shapes[0], &shapes[8]), (9, &"a".into(), &"c".into()));
    assert_eq!(desk.json("spectrum t.csv --row 2")["rows"].as_array().map(Vec::len), Some(3));
    let meshes = desk.json("mesh t.csv -o meshes --resolution 3");
    assert_eq!(meshes["written"], "meshes");
    for (i, name) in ["a", "b", "c"].iter().enumerate() {
        assert_eq!(meshes["meshes"][i]["written"], format!("meshes/{name}.obj"));
        assert!(desk.path(&format!("meshes/{name}.obj")).exists());
    }
    assert_says(&desk.ends(3, "mesh t.csv -o a.ply").err, &["has 3 rows", "`--row`"]);
    desk.done("mesh t.csv -o a.ply --row 3 --resolution 3");
    desk.done("convert t.csv a.csv --row 1 --to table");
    assert_eq!(distance(&shape(&desk, "a.csv"), &shape(&desk, "out/a.txt")), 0.0);
    // A fault says where it is.
    let wrong = desk.text("t.csv").replacen("\nb,4pi,1,0.0,", "\nb,4pi,1,zero,", 1);
    desk.put("wrong.csv", wrong);
    let said = desk.ends(3, "mean wrong.csv -o m.txt").err;
    assert_says(&said, &["wrong.csv:3: row 2, column `centre_x_m`: `zero` is not a number"]);
    // Two files of one name are told apart before anything is written.
    let (table, last) = (desk.text("t.csv"), "\n");
    let row = table.lines().nth(1).expect("a row");
    desk.put("double.csv", format!("{table}{row}{last}"));
    let said = desk.ends(3, "mesh double.csv -o double").err;
    assert_says(&said, &["would both be written to double/a.obj"]);
    assert!(!desk.path("double").exists());
}

#[test]
fn modes_of_shapes_are_written_and_said() {
    let desk = bodies(8);
    let files = (0..8).map(|k| format!("s{k}.txt")).collect::<Vec<_>>().join(" ");
    let all = desk.json(format!("modes {files} --modes 100"));
    let modes = all["modes"].as_array().expect("modes");
    // The bodies span four dimensions: sine and cosine of each of two angles.
    assert_eq!((modes.len(), &all["shapes"]), (4, &8.into()));
    let last = number(&modes[3], "cumulative");
    assert!((last - 1.0).abs() <= 1e-12, "{last}");
    let words = format!("modes {files} -o out --modes 2 --at 1.5 --json");
    let said: serde_json::Value = serde_json::from_str(&desk.done(&*words).out).expect("JSON");
    let written = said["written"].as_array().expect("files");
    let names: Vec<&str> = written.iter().filter_map(|name| name.as_str()).collect();
    let ends = ["mode1_-1.5", "mode1_+1.5", "mode2_-1.5", "mode2_+1.5"];
    for name in ["mean.txt", "mode1.txt", "mode2.txt", "scores.csv", "explained.csv"] {
        assert!(names.contains(&&*format!("out/{name}")) && desk.path("out").join(name).exists());
    }
    assert!(ends.iter().all(|name| desk.path(&format!("out/{name}.obj")).exists()));
    assert_eq!(names.len(), 5 + 4 + 4);
    // Scores times displacements in deviations bring the shapes back, but for the other modes.
    let mean = shape(&desk, "out/mean.txt");
    assert_eq!(mean.centre, DVec3::new(3.5, 0.0, 0.0));
    let mut rows = csv::Reader::from_path(desk.path("out/scores.csv")).expect("a table");
    assert_eq!(rows.headers().expect("a header"), vec!["name", "mode1_m", "mode2_m"]);
    let (mut near, mut far) = (0.0, 0.0);
    for (k, row) in rows.records().enumerate() {
        let row = row.expect("a row");
        assert_eq!(&row[0], format!("s{k}.txt"));
        let mut sum = mean.coefficients.clone();
        for mode in 1..=2 {
            let score: f64 = row[mode].parse().expect("a number");
            let deviation = number(&said["modes"][mode - 1], "deviation");
            let part = shape(&desk, &format!("out/mode{mode}.txt")).coefficients;
            sum = difference(&sum, &part.scaled(-score / deviation));
        }
        let body = body(k as f64).coefficients;
        near += difference(&sum, &body).energy();
        far += difference(&mean.coefficients, &body).energy();
    }
    let left = 1.0 - number(&said["modes"][1], "cumulative");
    assert!((near / far - left).abs() <= 1e-12, "{} {left}", near / far);
    // What stands there stays, whichever file it is.
    assert_says(&desk.ends(3, &*words).err, &["out/mean.txt", "--force"]);
}

#[test]
fn what_has_no_modes_is_told() {
    let desk = bodies(2);
    for (code, words, says) in [
        (3, "s0.txt", "modes need at least two shapes, found 1"),
        (3, "s0.txt s0.txt", "the shapes do not differ"),
        (2, "s0.txt s1.txt --at 2", "--output"),
        (2, "s0.txt s1.txt --at=-2 -o out", "write a positive number"),
        (2, "s0.txt s1.txt --modes 0", "--modes"),
    ] {
        assert_says(&desk.ends(code, format!("modes {words}")).err, &[says]);
    }
    // Two shapes have one mode, and no scores of a second to plot.
    desk.done("convert s1.txt low.txt -l 2");
    let said = desk.done("modes s0.txt low.txt -o out");
    assert_says(&said.err, &["degrees 2 to 3: the lower are padded with zeros"]);
    assert!(desk.path("out/explained.svg").exists() && !desk.path("out/scores.svg").exists());
}
