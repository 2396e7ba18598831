//! Level of detail as a user meets it: `render` says which degree each SH object got, and what that
//! may cost.

use harmolux::io::images::Exr;
use serde_json::Value;

use crate::common::desk::{Desk, Said, repository};

const ROOM: &str = r#"format = 1
[materials.walls.lambert]
reflectance = 0.5
[objects.room.box]
min = [0, 0, 0]
max = [4, 40, 3]
inward = true
material = "walls"
[objects.near.sh]
file = "head.txt"
degree = 12
at = [2, 2.5, 1.5]
scale = 5
material = "walls"
[objects.far.sh]
file = "head.txt"
degree = 12
at = [2, 38, 1.5]
scale = 5
material = "walls"
[lights.lamp.point]
at = [1, 1, 2.5]
intensity = 100
[cameras.main.perspective]
from = [2, 0.25, 1.6]
to = [2, 3, 1.6]
fov = 60
resolution = [32, 24]
[illum]
stop = { walks = 64 }
[sensors.spot.points]
at = [[1, 1, 0]]
normal = [0, 0, 1]
"#;

/// A folder with a room and the head at degree 12.
fn desk() -> Desk {
    let desk = Desk::new().with("room.toml", ROOM);
    desk.done(["fit", &repository("data/head.obj"), "-l", "12", "-o", "head.txt"]);
    desk
}

/// Runs `harmolux render` for a moment, with these words more.
fn render(desk: &Desk, words: &[&str]) -> Said {
    desk.done([&["render", "room.toml", "-D", "render.stop.walks=64"], words].concat())
}

#[test]
fn far_objects_are_drawn_at_a_lower_degree_that_is_certified() {
    let desk = desk();
    let define = "render.detail={ pixels = 0.25, normal = 180 }";
    let output = render(&desk, &["-D", define, "-o", "a.exr", "--json"]);
    let report: Value = serde_json::from_str(&output.out).expect("JSON");
    let details = report["details"].as_array().expect("a list");
    let [far, near] = ["far", "near"]
        .map(|name| details.iter().find(|d| d["name"] == name).expect("both objects are listed"));
    let number = |d: &Value, key: &str| d[key].as_f64().unwrap_or(f64::NAN);
    assert!(number(far, "degree") < number(near, "degree"), "{far} {near}");
    assert!((number(far, "distance") - number(near, "distance") - 35.5).abs() <= 0.01);
    for d in [far, near] {
        assert!(number(d, "pixels") <= 0.25 && number(d, "full_degree") == 12.0, "{d}");
    }
    assert!(number(far, "error") > number(near, "error") && number(far, "normal_degrees") > 0.0);
}

#[test]
fn two_hundred_heads_are_judged_each_by_itself() {
    let desk = desk();
    let start = ROOM.find("[objects.near.sh]").expect("there");
    let end = ROOM.find("[lights").expect("there");
    let heads = (0..200)
        .map(|i| {
            let at = [0.5 + 0.3 * f64::from(i % 10), 2.0 + 1.9 * f64::from(i / 10), 1.5];
            let [head, file] = [format!("[objects.head{i}.sh]"), "file = \"head.txt\"".to_owned()];
            format!("{head}\n{file}\ndegree = 12\nat = {at:?}\nmaterial = \"walls\"\n")
        })
        .collect::<Vec<_>>()
        .concat();
    desk.put("room.toml", format!("{}{heads}{}", &ROOM[..start], &ROOM[end..]));
    let details = |define: &str| {
        let words = ["-D", define, "--size", "240x160", "-o", "a.png", "--force", "--json"];
        let said = render(&desk, &words);
        let report: Value = serde_json::from_str(&said.out).expect("JSON");
        (report["details"].as_array().expect("a list").clone(), said.err)
    };
    let (found, _) = details("render.detail={}");
    let mut degrees: Vec<(f64, u64)> = found
        .iter()
        .map(|d| (d["distance"].as_f64().unwrap_or(0.0), d["degree"].as_u64().unwrap_or(99)))
        .collect();
    degrees.sort_by(|a, b| a.0.total_cmp(&b.0));
    // The farther, the lower, and each as low as its own distance allows.
    assert_eq!(degrees.len(), 200);
    assert!(degrees.is_sorted_by(|a, b| a.1 >= b.1), "{degrees:?}");
    assert!(degrees[0].1 > 8 && degrees[199].1 < 6, "{degrees:?}");
    assert!(found.iter().all(|d| d["pixels"].as_f64().is_some_and(|p| p <= 0.25)));
    // A limit for every normal keeps the heads whole, and that is said.
    let (strict, said) = details("render.detail={ normal = 2 }");
    assert!(strict.iter().all(|d| d["degree"] == 12), "{said}");
    let words = ["200 objects at full degree 12", "for the sake of `normal`: without it degree "];
    assert!(words.iter().all(|word| said.contains(word)), "{said}");
}

#[test]
fn degrees_are_said_and_nothing_is_simplified_unasked() {
    let desk = desk();
    let plain = render(&desk, &["-o", "a.exr"]).err;
    assert!(!plain.contains("detail"), "{plain}");
    let one = render(&desk, &["-D", "objects.far.sh.detail={}", "-o", "b.exr"]).err;
    assert!(one.contains("detail: `far` at") && !one.contains("`near`"), "{one}");
    let none = render(&desk, &["-D", "render.detail={ pixels = 0 }", "-o", "c.exr"]).err;
    assert!(none.contains("detail: 2 objects at full degree 12, from 1."), "{none}");
    // The pixels, that is: the files also name their runs.
    let channels = |name: &str| {
        let exr = Exr::read(&desk.path(name)).expect("readable");
        let names: Vec<String> = exr.channel_names().map(str::to_owned).collect();
        names.into_iter().map(|n| exr.channel(&n).map(<[f32]>::to_vec)).collect::<Vec<_>>()
    };
    assert!(channels("a.exr") == channels("c.exr"));
    // Sensors need exact shapes: nothing is chosen for them.
    let illum = desk.done(["illum", "room.toml", "-D", "render.detail={}"]).err;
    assert!(!illum.contains("detail"), "{illum}");
}
