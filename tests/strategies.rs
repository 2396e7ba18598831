//! Strategy A, strategy B and their combination give the picture of path tracing: every pixel of a picture together, and its mean.
//!
//! Seeds are fixed; the false-alarm rate of each picture is 1e-3 (`Estimate::agrees_with`). Numbers of walks are such that errors are known (`examples/picture_tails.rs`).

mod common;

use std::path::Path;

use common::films::assert_alike;
use common::{go_on, image};
use harmolux::estimators::{Estimator, ImageSettings, Weighting, render};
use harmolux::io::scene_file::SceneFile;
use harmolux::scene::Filter;
use harmolux::study::{camera, load};

/// Holds the strategies, `walks` a pixel, to so many `paths`.
fn check(name: &str, resolution: [u32; 2], walks: u64, paths: u64) {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("data/scenes/{name}.toml"));
    let file = SceneFile::read(&path, &[]).expect("a valid scene");
    let loaded = load(&file).expect("loads");
    assert!(loaded.warnings.is_empty(), "{:?}", loaded.warnings);
    let view = camera(&file).expect("a camera").with_resolution(resolution);
    let film = |estimator, walks| {
        let settings = ImageSettings { filter: Filter::Box, ..image(estimator, walks) };
        let film = render(&loaded.scene, &view, &settings, &go_on).expect("renders").film;
        assert_eq!(film.spoilt(), 0);
        film
    };
    let expected = film(Estimator::Path, paths);
    for weighting in [Weighting::of(&loaded.scene), Weighting::Walk, Weighting::Gather] {
        assert_alike(&film(Estimator::DoubleLocal(weighting), walks), &expected);
    }
}

#[test]
fn every_strategy_gives_the_head_room_of_path_tracing() {
    check("head_room", [32, 24], 1024, 4096);
}

#[test]
fn every_strategy_gives_the_cornell_box_of_path_tracing() {
    check("cornell_head", [24, 24], 1024, 4096);
}
