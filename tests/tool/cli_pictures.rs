//! `compare` as a user meets it: the same scene twice, another scene, pictures of other programs.

use std::sync::LazyLock;

use harmolux::io::images::Exr;
use harmolux::math::Rgb;

use crate::common::desk::{Desk, assert_says, number};
use crate::common::scenes::{BALL, CAMERA, LAMP, ROOM};

/// Pictures of 16 x 12 pixels, 32 replicates: two seeds, and the ball a little larger.
static PICTURES: LazyLock<[Vec<u8>; 3]> = LazyLock::new(|| {
    let room = [ROOM, BALL, LAMP, CAMERA, "resolution = [16, 12]\n"].concat();
    let desk = Desk::new().with("room.toml", room);
    let render = |more: &str| {
        let stop = "-D render.stop={walks=4096}";
        desk.done(format!("render room.toml {stop} -o x.exr --force {more}").as_str());
        desk.bytes("x.exr")
    };
    ["--seed 1", "--seed 2", "--seed 3 -D objects.ball.sphere.radius=0.8"].map(render)
});

/// A folder with these pictures.
fn desk() -> Desk {
    let [one, two, other] = &*PICTURES;
    Desk::of(&["compare"]).with("1.exr", one).with("2.exr", two).with("other.exr", other)
}

/// A picture without errors, as other programs write them.
fn foreign(width: usize, height: usize, value: impl Fn(usize) -> f64) -> Vec<u8> {
    let pixels: Vec<Rgb> = (0..width * height).map(|i| Rgb::grey(value(i))).collect();
    let colours = ["R", "G", "B"].into_iter().try_fold(Exr::new(width, height), |exr, name| {
        exr.with_values(name, &pixels.iter().map(|p| p.0[0]).collect::<Vec<_>>())
    });
    let exr = colours.expect("fits").with_attribute("software", "another");
    exr.to_bytes().expect("encoded")
}

#[test]
fn a_picture_is_equal_to_itself() {
    let said = desk().done("1.exr 1.exr").out;
    let words = ["mean 0, 95 % below 0, largest 0", "0 pixels, 0 %", "no difference beyond"];
    assert_says(&said, &words);
}

#[test]
fn two_seeds_differ_by_noise_alone_and_another_scene_by_more() {
    let desk = desk();
    let noise = desk.json("1.exr 2.exr");
    assert_eq!((&noise["differ"], &noise["replicates"]), (&false.into(), &32.into()));
    assert_eq!(noise["tested_pixels"], 192);
    // The noise is all there is: its expectation, and what 192 pixels scatter about it.
    let [found, expected] = ["relmse", "relmse_of_noise"].map(|key| number(&noise, key));
    assert!((found / expected - 1.0).abs() <= 0.5, "{found} {expected}");
    let said = desk.ends(4, "other.exr 1.exr");
    assert_says(&said.out, &["they differ by more than their errors", "largest z of pixels"]);
    let other = desk.json_at(4, "other.exr 1.exr");
    assert!(number(&other, "relmse") > 10.0 * found);
    assert!(number(&other, "flip_mean") > number(&noise, "flip_mean"));
    let level = &other["levels"][0];
    assert!(number(level, "z").abs() > number(level, "limit") && number(level, "beyond") >= 1.0);
    assert!(desk.run("1.exr 1.exr").err.is_empty());
}

#[test]
fn errors_of_two_replicates_judge_nothing() {
    let room = [ROOM, BALL, LAMP, CAMERA, "resolution = [16, 12]\n"].concat();
    let desk = Desk::new().with("room.toml", room);
    let stop = "-D render.stop={walks=64}";
    desk.done(format!("render room.toml {stop} -o a.exr"));
    desk.done(format!("render room.toml {stop} -D lights.lamp.point.intensity=1e4 -o b.exr"));
    let said = desk.done("compare b.exr a.exr").out;
    assert_says(&said, &["not judged: errors from 2 replicates", "more walks"]);
    let report = desk.json("compare b.exr a.exr");
    assert!(report["differ"].is_null() && number(&report, "flip_mean") > 0.1);
}

#[test]
fn tolerances_decide_where_there_are_no_errors() {
    let desk = desk()
        .with("a.exr", foreign(16, 12, |i| 1.0 + (i % 16) as f64))
        .with("b.exr", foreign(16, 12, |i| 1.1 * (1.0 + (i % 16) as f64)));
    let said = desk.done("a.exr b.exr").out;
    assert_says(&said, &["not judged: no standard errors (channel stderr.Y) in a.exr and b.exr"]);
    assert_says(&desk.done("a.exr 1.exr").out, &["(channel stderr.Y) in a.exr"]);
    let report = desk.json("a.exr b.exr --tolerance relmse=0.01,flip=0.5");
    assert_eq!((&report["differ"], &report["within_tolerance"]), (&().into(), &true.into()));
    // (0.1 / 1.1)^2, but for what dark pixels have added.
    assert!((number(&report, "relmse") - 0.008_264).abs() <= 2e-5, "{report}");
    let said = desk.ends(4, "a.exr b.exr --tolerance relmse=0.008");
    assert_says(&said.err, &["relMSE, 0.008259, is above the tolerance of 0.008000"]);
    assert_says(&desk.ends(4, "a.exr b.exr --tolerance flip=0").err, &["the mean of FLIP"]);
    assert_says(&desk.ends(3, "a.exr b.exr --tolerance psnr=3").err, &["no setting `psnr`"]);
    assert_says(&desk.ends(3, "a.exr b.exr --tolerance flip=-1").err, &["below 0"]);
    assert_eq!(desk.run("a.exr b.exr --tolerance 0.1").code, 2);
}

#[test]
fn maps_are_written_as_pictures() {
    let desk = desk();
    desk.ends(4, "other.exr 1.exr -o d.png -o d.svg");
    assert!(desk.bytes("d.png").starts_with(b"\x89PNG"));
    assert_says(&desk.text("d.svg"), &[">cd/m\u{b2}<", ">0<"]);
    desk.ends(4, "other.exr 1.exr -o f.svg --map flip");
    assert_says(&desk.text("f.svg"), &[">FLIP<", ">1.0<"]);
    desk.ends(4, "other.exr 1.exr -o z.svg --map z");
    assert_says(&desk.text("z.svg"), &[">std. errors<"]);
    assert_says(&desk.ends(3, "1.exr 2.exr -o d.png").err, &["--force"]);
    desk.done("1.exr 2.exr -o d.png --force");
    assert_says(&desk.ends(3, "1.exr 2.exr -o d.exr").err, &[".png or .svg"]);
    assert_eq!(desk.run("1.exr 2.exr --map flip").code, 2);
    let desk = desk.with("a.exr", foreign(16, 12, |i| i as f64));
    assert_says(&desk.ends(3, "a.exr 1.exr -o n.svg --map z").err, &["needs standard errors"]);
    assert!(!desk.path("n.svg").exists());
}

#[test]
fn what_cannot_be_compared_is_refused_with_how_to_go_on() {
    let desk = desk()
        .with("wide.exr", foreign(17, 12, |_| 1.0))
        .with("holed.exr", foreign(16, 12, |i| if i == 20 { f64::NAN } else { 1.0 }))
        .with("text.exr", "not a picture")
        .with(
            "depth.exr",
            Exr::new(1, 1).with_values("Z", &[1.0]).and_then(|e| e.to_bytes()).expect("encoded"),
        );
    let part = Exr::from_bytes("1.exr".as_ref(), &desk.bytes("1.exr")).expect("an EXR");
    let desk = desk.with("part.exr", part.within([64, 48], [3, 4]).to_bytes().expect("encoded"));
    for (words, says) in [
        ("wide.exr 1.exr", "wide.exr and 1.exr: 17 x 12 pixels against 16 x 12: only pictures of"),
        ("1.exr part.exr", "against the part from pixel (3, 4) of 64 x 48: only the same part"),
        ("1.exr holed.exr", "holed.exr: pixel (4, 1) is not finite\n  help: a picture with such"),
        ("text.exr 1.exr", "text.exr: this is not a readable EXR image"),
        ("text.exr 1.exr", "help: give EXR pictures"),
        ("depth.exr 1.exr", "no channels R, G, B and no luminance: Z"),
        ("1.exr none.exr", "none.exr: cannot read"),
        ("1.exr 2.exr --pixels-per-degree 0", "0 pixels per degree: FLIP takes 1 to"),
    ] {
        assert_says(&desk.ends(3, words).err, &[says]);
    }
    assert!(desk.done("part.exr part.exr").out.contains("verdict"));
}

#[test]
fn one_seed_twice_is_noted() {
    let desk = desk();
    let mut exr = Exr::from_bytes("2.exr".as_ref(), &desk.bytes("2.exr")).expect("an EXR");
    exr = exr.with_attribute("seed", "1");
    let desk = desk.with("alike.exr", exr.to_bytes().expect("encoded"));
    assert_says(&desk.done("alike.exr 1.exr").err, &["both have the same seed"]);
}
