//! Strategy A, strategy B and their combination give the picture of path tracing: all pixels of a
//! picture together, and its mean.
//!
//! Seeds are fixed; the false-alarm rate of each picture is 1e-3 (`Estimate::agrees_with`), as far
//! as errors are known. Those of A and B alone are not everywhere
//! (`benches/experiments/picture_tails.rs`): between the walls of the small box only the means of
//! their pictures are judged.

use std::path::Path;

use crate::common::films::{assert_alike, assert_same_mean};
use crate::common::{go_on, image};
use harmolux::estimators::{Estimator, ImageSettings, Weighting, render};
use harmolux::io::scene_file::SceneFile;
use harmolux::scene::Filter;
use harmolux::study::{camera, load};

/// Holds the three to path tracing: by pixels and means, or by means alone where `alone_by_pixel`
/// does not say so of A and B.
fn check(name: &str, resolution: [u32; 2], alone_by_pixel: bool) {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("data/scenes/{name}.toml"));
    let file = SceneFile::read(&path, &[]).expect("a valid scene");
    let loaded = load(&file).expect("loads");
    assert!(loaded.warnings.is_empty(), "{:?}", loaded.warnings);
    let view = camera(&file).expect("a camera").with_resolution(resolution);
    let film = |estimator, walks| {
        let settings = ImageSettings { filter: Filter::Box, ..image(estimator, walks) };
        let film = render(&loaded.scene, &view, &settings, &go_on).expect("renders").film;
        assert_eq!(film.non_finite(), 0);
        film
    };
    let expected = film(Estimator::Path, 4096);
    let by_strategy = |weighting| film(Estimator::Local(weighting), 1024);
    assert_alike(&by_strategy(Weighting::of(&loaded.scene)), &expected);
    let judge_alone = if alone_by_pixel { assert_alike } else { assert_same_mean };
    for weighting in [Weighting::Walk, Weighting::Gather] {
        judge_alone(&by_strategy(weighting), &expected);
    }
}

#[test]
fn every_strategy_gives_the_room_of_the_paper_of_path_tracing() {
    check("paper_figure_3", [24, 18], true);
}

#[test]
fn every_strategy_gives_the_cornell_box_of_path_tracing() {
    check("cornell_head", [20, 20], false);
}
