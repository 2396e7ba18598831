use std::path::Path;

use super::*;
use crate::study::load;

/// Reads a scene of the repository with overrides and asks what is known of each of its groups;
/// gives the first refusal.
fn refusal(name: &str, overrides: &[(&str, &str)]) -> Option<String> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("data/scenes/exact").join(name);
    let file = SceneFile::read(&path, overrides).expect("a valid scene");
    let loaded = load(&file).expect("loads");
    let known = |group| known_illuminance(&file, group).err().map(|error| error.to_string());
    loaded.sensors.iter().find_map(known)
}

/// An override of a scene.
type Change = (&'static str, &'static str);
/// A scene, what is changed in it, and what is said; nothing where it still is its problem.
type Case = (&'static str, &'static [Change], &'static str);

const LAMP: Change = ("lights.spare.point", "{ at = [0.1, 0.1, 0.7], flux = 5 }");

const CASES: &[Case] = &[
    ("sobolev_b.toml", &[LAMP], "it has 2 lights"),
    ("sobolev_b.toml", &[("materials.dark.lambert.exitance", "0")], ""),
    (
        "sobolev_b.toml",
        &[("materials.dark.lambert.reflectance", "[0.1, 0.2, 0.3]")],
        "material `dark` has a colour",
    ),
    (
        "sobolev_b.toml",
        &[("lights.source.point.colour", "[1, 0, 0]")],
        "light `source` has a colour",
    ),
    (
        "sobolev_b.toml",
        &[("lights.source.point.at", "[0, 0, 2]")],
        "the light is not between the two",
    ),
    (
        "sobolev_b.toml",
        &[("objects.ceiling.plane.normal", "[0, 0.1, -1]")],
        "the two do not face each other",
    ),
    (
        "sobolev_b.toml",
        &[("sensors.upper.points.measure", "cylindrical")],
        "sensor 1 of `upper` measures a cylinder",
    ),
    ("discs_rim.toml", &[("objects.floor.disc.radius", "3")], "the discs have different radii"),
    (
        "discs_rim.toml",
        &[("objects.floor.disc.centre", "[0.1, 0, 0]")],
        "the discs have no common axis",
    ),
    (
        "discs_rim.toml",
        &[("lights.source.point.at", "[0.1, 0, 0.5]")],
        "the light is not on the axis",
    ),
    ("sphere.toml", &[("materials.white.lambert.reflectance", "[0.9, 0.9, 0.8]")], "has a colour"),
    ("hemisphere.toml", &[LAMP], "there is a light `spare`"),
    (
        "hemisphere.toml",
        &[("objects.disc.disc.radius", "0.9")],
        "the rim of the disc is not on the sphere",
    ),
    (
        "hemisphere.toml",
        &[("objects.disc.disc.centre", "[0, 0, 0.6]"), ("objects.disc.disc.radius", "0.8")],
        "sensor 1 of `across` is not on a surface",
    ),
    (
        "concentric.toml",
        &[("objects.inner.sphere.centre", "[0.1, 0, 0]")],
        "the spheres have different centres",
    ),
    (
        "concentric.toml",
        &[("objects.third.sphere", "{ centre = [1.5, 0, 0], radius = 0.1, material = \"wall\" }")],
        "it has 3 objects",
    ),
    ("cie171_5_8.toml", &[("objects.cube.box.max", "[2, 2, 5]")], "the edges of `cube` differ"),
    (
        "cie171_5_8.toml",
        &[("lights.lamp.point.at", "[0, 0, 2.1]")],
        "the light is not in the middle",
    ),
    (
        "cie171_5_8.toml",
        &[
            ("materials.floor.lambert", "{ reflectance = 0.4 }"),
            ("objects.cube.box.faces", "{ z_min = \"floor\" }"),
        ],
        "the faces of `cube` reflect differently",
    ),
    (
        "furnace.toml",
        &[("materials.floor.lambert.exitance", "801")],
        "exitance / (1 - reflectance) is",
    ),
    ("furnace.toml", &[LAMP], "there is a light `spare`"),
    (
        "furnace.toml",
        &[(
            "objects.shelf.disc",
            "{ centre = [1, 1, 1], normal = [0, 0, 1], radius = 0.2, material = \"walls\" }",
        )],
        "`shelf`, a disc, is open",
    ),
    (
        "cie171_5_3.toml",
        &[("objects.room.box.max", "[4, 4, 3]")],
        "`source` is not inside the room; move it off the wall",
    ),
    (
        "cie171_5_3.toml",
        &[("materials.black.lambert.reflectance", "0.1")],
        "material `black` reflects",
    ),
    (
        "cie171_5_6.toml",
        &[("objects.ball.sphere", "{ centre = [1, 1, 1], radius = 0.2, material = \"black\" }")],
        "`ball` is a sphere",
    ),
    (
        "cie171_5_7.toml",
        &[("objects.second.box", "{ min = [1, 2.8, 0], max = [3, 3, 2], material = \"black\" }")],
        "sees a lamp past two objects",
    ),
    ("cie171_5_2.toml", &[("objects.plane.rectangle.corner", "[-2, -2, -1]")], ""),
    ("cie171_5_2.toml", &[("lights.source.lambert.colour", "[1, 0.5, 0.2]")], ""),
];

#[test]
fn scenes_that_are_another_problem_are_refused_with_what_differs() {
    for (scene, overrides, words) in CASES {
        match refusal(scene, overrides) {
            None => assert!(words.is_empty(), "{scene} {overrides:?} is not refused"),
            Some(said) => {
                assert!(!words.is_empty() && said.contains(words), "{scene} {overrides:?}: {said}");
            }
        }
    }
}
