//! The whole reader: exact messages of every class of error, overrides, the shipped scene, random
//! damage.

mod messages;
mod reference;

use crate::math::Unit;
use crate::mesh::UpAxis;
use crate::surface::{Intersector, StepBisection};
use glam::DVec3;
use proptest::prelude::*;

use super::*;
use crate::math::Rgb;
use crate::scene::Measure;
use messages::*;

const HEAD_ROOM: &str = include_str!("../../../../data/scenes/head_room.toml");
const PAPER_ROOM: &str = include_str!("../../../../data/scenes/paper_figure_3.toml");

const ROOM: &str = r#"format = 1
[materials.walls.lambert]
reflectance = 0.5
[materials.floor.lambert]
reflectance = 0.3
[objects.room.box]
min = [0, 0, 0]
max = [4, 5, 3]
inward = true
material = "walls"
faces = { z_min = "floor" }
[lights.lamp.point]
at = [1, 1, 2.5]
intensity = 100
[cameras.main.perspective]
from = [2, 0.5, 1.5]
to = [2, 3, 1]
fov = 45
resolution = [640, 480]
[sensors.desk.grid]
on = "room.z_min"
[render]
estimator = "path"
stop = { relative_error = 0.01, time = "10m" }
"#;

const SHAPES: &str = r#"format = 1.0
materials.grey.lambert.reflectance = 0
[objects.table.rectangle]
corner = [0, 0, 0]
edge_u = [2, 0, 0]
edge_v = [0, 1, 0]
material = "grey"
[objects.lid.disc]
centre = [0, 0, 1]
normal = [0, 0, 2]
radius = 1
material = "grey"
[objects.ball.sphere]
centre = [0, 0, 2]
radius = 0.5
inward = true
material = "grey"
[objects.ground.plane]
point = [0, 0, -1]
normal = [0, 0, 1]
material = "grey"
[objects.twin.mesh]
file = "head.obj"
smooth = true
up = "y"
unit = "mm"
material = "grey"
[objects."the head".sh]
file = "/abs/head.csv"
degree = 8.0
centre = [0, 0, 0.01]
intersector = "step-bisection"
step = 0.01
rotate = { axis = [0, 0, 5], degrees = 90 }
material = "grey"
[sensors.top.grid]
on = "table"
count = [3, 2]
[sensors.air.grid]
height = 0.75
spacing = 0.25
[lights.lamp.point]
at = [0, 0, 3]
flux = 1000
colour = [2, 1, 1]
[cameras.a.perspective]
from = [5, 0, 1]
to = [0, 0, 1]
fov = 30
resolution = [8, 8]
[cameras.b.perspective]
from = [5, 0, 1]
to = [0, 0, 1]
fov = 30
resolution = [8, 8]
[illum]
stop = { walks = 1e6, time = 90 }
"#;

fn parse(text: &str, overrides: &[(&str, &str)]) -> Result<SceneFile> {
    SceneFile::parse(Path::new("dir/room.toml"), text, overrides)
}

fn shipped(text: &str) -> SceneFile {
    SceneFile::parse(Path::new("data/scenes/room.toml"), text, &[]).expect("parses")
}

fn assert_messages(base: &str, damages: &[Damage]) {
    for (from, to, expected) in damages {
        assert!(base.contains(from), "nothing to replace: {from}");
        let error = parse(&base.replacen(from, to, 1), &[]).expect_err(to);
        assert!(matches!(error, Error::Input(_)));
        assert_eq!(error.to_string(), format!("dir/room.toml:{expected}"));
    }
}

#[test]
fn keys_and_types_that_do_not_exist_are_named() {
    assert_messages(ROOM, BAD_KEYS);
}

#[test]
fn text_that_is_not_toml_is_located() {
    assert_messages(ROOM, BAD_TOML);
}

#[test]
fn values_out_of_range_or_of_another_type_are_refused() {
    assert_messages(ROOM, BAD_VALUES);
}

#[test]
fn things_that_do_not_fit_each_other_are_refused() {
    assert_messages(ROOM, BAD_RELATIONS);
}

#[test]
fn the_rarer_shapes_are_checked_too() {
    assert_messages(SHAPES, BAD_SHAPES);
}

#[test]
fn bad_overrides_are_errors_of_the_caller_and_name_the_key() {
    for (key, value, expected) in BAD_OVERRIDES {
        let error = parse(ROOM, &[(key, value)]).expect_err(value);
        assert!(matches!(error, Error::Parameter(_)));
        assert_eq!(error.to_string(), *expected);
    }
}

#[test]
fn an_empty_file_lacks_its_format_and_an_empty_scene_is_a_scene() {
    let error = parse("", &[]).expect_err("no format");
    assert_eq!(
        error.to_string(),
        "dir/room.toml:1:1: missing key `format`\n  help: add `format = 1`"
    );
    let scene = parse("format = 1", &[]).expect("an empty scene");
    assert_eq!((scene.objects.len(), scene.render), (0, RenderSpec::default()));
}

#[test]
fn columns_count_characters_and_lines_may_end_either_way() {
    let text = "format = 1\r\n[materials.\"wänd e\".lambert]\r\nreflectance = 2";
    let error = parse(text, &[]).expect_err("too bright").to_string();
    assert!(
        error.starts_with("dir/room.toml:3:15: `reflectance` in [materials.\"wänd e\".lambert]")
    );
    let text =
        "format = 1\nobjects.\"ä\".sphere = { centre = [0, 0, 0], radius = 1, material = \"ö\" }";
    let error = parse(text, &[]).expect_err("no material").to_string();
    assert_eq!(error, "dir/room.toml:2:67: unknown material `ö`\n  help: there are no materials");
}

#[test]
fn whole_numbers_and_floats_are_the_same() {
    let floats = ROOM.replace("640, 480", "6.4e2, 480.0").replace("= 100", "= 1e2");
    let (a, b) = (parse(ROOM, &[]).expect("parses"), parse(&floats, &[]).expect("parses"));
    assert_eq!((a.cameras, a.lights), (b.cameras, b.lights));
}

#[test]
fn shapes_are_read_as_written() {
    let scene = parse(SHAPES, &[]).expect("parses");
    let ObjectSpec::Mesh(twin) = &scene.objects["twin"] else { panic!("a mesh") };
    assert_eq!(twin.file.written, Path::new("head.obj"));
    assert_eq!(twin.file.resolved, Path::new("dir/head.obj"));
    assert_eq!((twin.unit, twin.up, twin.scale), (Unit::Millimetre, UpAxis::Y, 1.0));
    let ObjectSpec::Sh(head) = &scene.objects["the head"] else { panic!("coefficients") };
    assert_eq!(head.file.resolved, Path::new("/abs/head.csv"));
    assert_eq!((head.degree, head.centre), (8, Some(DVec3::new(0.0, 0.0, 0.01))));
    let march = Intersector::StepBisection(StepBisection::default());
    assert_eq!((head.intersector, head.step), (march, Some(0.01)));
    assert_eq!(head.rotate, Rotation { axis: DVec3::Z, degrees: 90.0 });
    let ObjectSpec::Disc(lid) = &scene.objects["lid"] else { panic!("a disc") };
    assert_eq!(lid.normal, DVec3::Z);
}

#[test]
fn sensors_measure_planes_cylinders_and_halves() {
    let measure = |written: &str| {
        let text = ROOM.replace("[render]", &format!("{written}\n[render]"));
        let scene = SceneFile::parse("room.toml".as_ref(), &text, &[])?;
        let SensorSpec::Grid(grid) = &scene.sensors["desk"] else { panic!("a grid") };
        Ok::<_, Error>(grid.measure)
    };
    assert_eq!(measure("").expect("parses"), Measure::Plane);
    assert_eq!(measure("measure = \"cylindrical\"").expect("parses"), Measure::Cylinder);
    let half = "measure = \"semicylindrical\"\nfacing = [0, 2, 0]";
    assert_eq!(measure(half).expect("parses"), Measure::SemiCylinder { facing: DVec3::Y });
    for (bad, words) in [
        (
            "measure = \"cylinder\"",
            "the words here are `plane`, `cylindrical` and `semicylindrical`",
        ),
        ("measure = \"semicylindrical\"", "missing key `facing`"),
        ("facing = [1, 0, 0]", "`facing` in [sensors.desk.grid] has no meaning"),
        ("measure = \"semicylindrical\"\nfacing = [1, 0, 1]", "perpendicular to the axis"),
    ] {
        let error = measure(bad).expect_err(bad).to_string();
        assert!(error.contains(words), "{error}");
    }
}

#[test]
fn lights_sensors_and_stops_are_read_as_written() {
    let scene = parse(SHAPES, &[]).expect("parses");
    let lamp = &scene.lights["lamp"];
    assert_eq!(lamp.strength, Strength::Flux(1000.0));
    // Four roundings of numbers near 1.
    assert!((lamp.colour.luminance() - 1.0).abs() <= 1e-15);
    assert!((lamp.colour.0[0] - 2.0 * lamp.colour.0[1]).abs() <= 1e-15);
    let place = GridPlace::Rectangle { object: "table".to_owned() };
    let top =
        GridSpec { place, border: 0.0, layout: GridLayout::Count([3, 2]), measure: Measure::Plane };
    assert_eq!(scene.sensors["top"], SensorSpec::Grid(top));
    let air = GridSpec {
        place: GridPlace::Height(0.75),
        border: 0.0,
        layout: GridLayout::Spacing(0.25),
        measure: Measure::Plane,
    };
    assert_eq!(scene.sensors["air"], SensorSpec::Grid(air));
    let stop = scene.illum.stop;
    assert_eq!((stop.walks, stop.time.map(|t| t.as_secs())), (Some(1_000_000), Some(90)));
}

#[test]
fn surfaces_are_read_as_written() {
    let of = |base: &str, written: &str| {
        let text = format!("{base}\n[sensors.all.surface]\n{written}\n");
        match &parse(&text, &[]).expect(written).sensors["all"] {
            SensorSpec::Surface(spec) => spec.clone(),
            other => panic!("{other:?}"),
        }
    };
    let (place, layout) = (SurfacePlace::Object("room".to_owned()), SurfaceLayout::Even(9));
    let room = of(ROOM, "on = \"room\"\npoints = 9.0");
    assert_eq!(room, SurfaceSpec { place, layout, measure: Measure::Plane });
    let floor = of(ROOM, "on = \"room.z_min\"\npoints = 1\nmeasure = \"cylindrical\"");
    let face = SurfacePlace::Face { object: "room".to_owned(), face: BoxFace::ZMin };
    assert_eq!((floor.place, floor.measure), (face, Measure::Cylinder));
    let vertices = |written: &str| of(SHAPES, written).layout;
    assert_eq!(vertices("on = \"twin\"\nvertices = true"), SurfaceLayout::Vertices);
    for body in ["the head", "ball"] {
        let written = format!("on = \"{body}\"\nvertices = true\npoints = 1000");
        assert_eq!(vertices(&written), SurfaceLayout::Geodesic(1000));
    }
}

#[test]
fn details_are_off_unless_asked_for_and_filled_up() {
    let scene = parse(SHAPES, &[]).expect("parses");
    let ObjectSpec::Sh(head) = &scene.objects["the head"] else { panic!("coefficients") };
    assert_eq!((scene.render.detail, head.detail), (None, None));
    let overrides =
        [("render.detail", "{ pixels = 0.5 }"), ("objects.\"the head\".sh.detail.normal", "20")];
    let scene = parse(SHAPES, &overrides).expect("parses");
    let ObjectSpec::Sh(head) = &scene.objects["the head"] else { panic!("coefficients") };
    assert_eq!(scene.render.detail, Some(DetailSpec { pixels: 0.5, normal: 180.0 }));
    assert_eq!(head.detail, Some(DetailSpec { pixels: 0.25, normal: 20.0 }));
}

#[test]
fn the_camera_is_the_named_or_the_only_one() {
    assert_eq!(parse(ROOM, &[]).expect("parses").camera().expect("one").0, "main");
    let two = parse(SHAPES, &[]).expect("parses");
    assert_eq!(
        two.camera().expect_err("two").to_string(),
        "dir/room.toml:1:1: the scene has several cameras and [render] names none\n  help: add \
         `camera = \"a\"`; the cameras are `a` and `b`"
    );
    let named = parse(SHAPES, &[("render.camera", "b")]).expect("parses");
    assert_eq!(named.camera().expect("named").0, "b");
    assert!(parse("format = 1", &[]).expect("parses").camera().is_err());
}

#[test]
fn names_with_dots_work_in_places_and_overrides() {
    let text = ROOM.replace("objects.room", "objects.\"my.room\"").replace("room.z", "my.room.z");
    let scene = parse(&text, &[("objects.\"my.room\".box.max", "[9, 9, 9]")]).expect("parses");
    let SensorSpec::Grid(grid) = &scene.sensors["desk"] else { panic!("a grid") };
    let place = GridPlace::Face { object: "my.room".to_owned(), face: BoxFace::ZMin };
    assert_eq!(grid.place, place);
    let ObjectSpec::Box(room) = &scene.objects["my.room"] else { panic!("a box") };
    assert_eq!(room.max, DVec3::splat(9.0));
}

#[test]
fn overrides_replace_add_and_make_things() {
    let overrides = [
        ("lights.lamp.point.intensity", "250"),
        ("lights.lamp.point.intensity", "300"),
        ("lights.lamp.point.colour", "[1, 1, 1]"),
        ("lights.spare.point", "{ at = [1, 1, 1], flux = 5 }"),
        ("lights . spare . 'point' . flux", "6.5"),
        ("render.estimator", "double-local"),
        ("render.stop.time", "90s"),
        ("objects.room.box.faces.z_max", "floor"),
        ("illum.seed", "7"),
    ];
    let scene = parse(ROOM, &overrides).expect("parses");
    let lamp = &scene.lights["lamp"];
    assert_eq!((lamp.strength, lamp.colour), (Strength::Intensity(300.0), Rgb::WHITE));
    let spare = &scene.lights["spare"];
    assert_eq!(spare.strength, Strength::Flux(6.5));
    assert_eq!(scene.render.estimator, RenderEstimator::DoubleLocal);
    assert_eq!(scene.render.stop.time.map(|t| t.as_secs()), Some(90));
    assert_eq!(scene.illum.seed, 7);
    let ObjectSpec::Box(room) = &scene.objects["room"] else { panic!("a box") };
    assert_eq!(room.face_material(BoxFace::ZMax), "floor");
    assert_eq!(room.face_material(BoxFace::XMax), "walls");
}

#[test]
fn an_override_can_mend_the_file() {
    let broken = ROOM.replace("format = 1\n", "").replace("fov = 45", "fov = 200");
    let mends = [("format", "1"), ("cameras.main.perspective.fov", "45")];
    assert!(parse(&broken, &mends[..1]).is_err());
    assert!(parse(&broken, &mends).is_ok());
}

#[test]
fn overrides_split_at_the_first_free_equals_sign() {
    assert_eq!(split_override("a.b = c=d").expect("splits"), ("a.b", "c=d"));
    assert_eq!(split_override("a.\"x=y\".b=1").expect("splits"), ("a.\"x=y\".b", "1"));
    assert_eq!(
        split_override("a.b").expect_err("no =").to_string(),
        "-D a.b: has no `=`\n  help: write KEY=VALUE, as in lights.lamp.point.intensity=250; \
         quote names that hold dots or spaces"
    );
}

#[test]
fn later_rooms_can_point_at_any_key() {
    let scene = parse(ROOM, &[("objects.room.box.max", "[5, 5, 5]")]).expect("parses");
    let source = &scene.source;
    let at = |key: &[&str]| source.error(key, "is odd", None).to_string();
    assert_eq!(at(&["objects", "room", "box", "material"]), "dir/room.toml:10:12: is odd");
    assert_eq!(at(&["objects", "room", "box", "min", "2"]), "dir/room.toml:7:14: is odd");
    assert_eq!(at(&["objects", "room", "box", "colour"]), "dir/room.toml:6:1: is odd");
    assert_eq!(at(&["objects", "room", "box", "max"]), "-D objects.room.box.max: is odd");
    assert_eq!(at(&[]), "dir/room.toml:1:1: is odd");
    assert_eq!(source.span(&["nowhere"]), None);
    assert_eq!(source.line_column(usize::MAX).0, ROOM.lines().count() + 1);
}

#[test]
fn files_are_read_and_what_cannot_be_read_is_told() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("room.toml");
    assert!(matches!(SceneFile::read(&path, &[]), Err(Error::Io { action: "read", .. })));
    std::fs::write(&path, SHAPES).expect("writes");
    let scene = SceneFile::read(&path, &[]).expect("reads");
    let ObjectSpec::Mesh(twin) = &scene.objects["twin"] else { panic!("a mesh") };
    assert_eq!(twin.file.resolved, folder.path().join("head.obj"));
    std::fs::write(&path, b"format = 1\n# \xc3\xa4 \xff\n").expect("writes");
    let error = SceneFile::read(&path, &[]).expect_err("not UTF-8").to_string();
    assert!(
        error.ends_with(":2:5: not UTF-8 text\n  help: a scene is a text file; save it as UTF-8")
    );
}

#[test]
fn the_head_room_parses_and_its_panel_looks_at_the_head() {
    let scene = shipped(HEAD_ROOM);
    let ObjectSpec::Box(room) = &scene.objects["room"] else { panic!("a box") };
    let ObjectSpec::Box(plinth) = &scene.objects["plinth"] else { panic!("a box") };
    let ObjectSpec::Sh(head) = &scene.objects["head"] else { panic!("a head") };
    let ObjectSpec::Rectangle(panel) = &scene.objects["panel"] else { panic!("a rectangle") };
    let camera = scene.camera().expect("one camera").1;
    assert_eq!((head.degree, camera.resolution()), (32, [510, 340]));
    for point in [scene.lights["lamp"].at, camera.from(), head.at, panel.corner] {
        assert!(point.cmpgt(room.min).all() && point.cmplt(room.max).all());
    }
    // The origin of the head is above the plinth, by less than its largest radius.
    assert!(head.at.cmpgt(plinth.min).all() && head.at.z > plinth.max.z);
    assert!(head.at.truncate().cmplt(plinth.max.truncate()).all());
    assert!(head.at.z < plinth.max.z + 0.1414 * head.scale);
    assert!(panel.edge_u.cross(panel.edge_v).dot(head.at - panel.corner) > 0.0);
}

#[test]
fn in_the_room_of_the_paper_nothing_touches() {
    let scene = shipped(PAPER_ROOM);
    let ObjectSpec::Box(room) = &scene.objects["room"] else { panic!("a box") };
    let ObjectSpec::Sh(head) = &scene.objects["head"] else { panic!("a head") };
    let lamp = &scene.lights["lamp"];
    let camera = scene.camera().expect("one camera").1;
    assert_eq!(head.file.resolved, Path::new("data/scenes/../head.obj"));
    assert_eq!((head.degree, camera.resolution()), (32, [480, 360]));
    // The farthest vertex of head.obj is 0.14131 m from its origin.
    let radius = 0.1414 * head.scale;
    assert!((head.at - radius).cmpgt(room.min).all() && (head.at + radius).cmplt(room.max).all());
    for point in [lamp.at, camera.from()] {
        assert!(point.distance(head.at) > radius);
        assert!(point.cmpgt(room.min).all() && point.cmplt(room.max).all());
    }
    // The middle of the shadow falls on the floor, beyond the head as the camera sees it.
    let shadow = lamp.at + (head.at - lamp.at) * (lamp.at.z / (lamp.at.z - head.at.z));
    assert!(shadow.y > head.at.y && shadow.cmple(room.max).all() && shadow.x >= room.min.x);
}

/// Replaces some characters of a text: each damage picks a place, a length to drop and a snippet to
/// insert.
fn mutated(text: &str, damages: &[(prop::sample::Index, usize, &str)]) -> String {
    let mut chars: Vec<char> = text.chars().collect();
    for (place, length, snippet) in damages {
        let start = place.index(chars.len() + 1);
        let end = (start + length).min(chars.len());
        chars.splice(start..end, snippet.chars());
    }
    chars.into_iter().collect()
}

fn snippet() -> impl Strategy<Value = &'static str> {
    prop::sample::select(vec![
        "",
        "",
        "\n",
        "\"",
        "'",
        "[",
        "]",
        "{",
        "}",
        "=",
        ".",
        ",",
        "#",
        "0",
        "-1",
        "1e999",
        "nan",
        "inf",
        "é",
        "\u{0}",
        "\u{feff}",
        "\r",
        "x",
        "true",
        "[[a]]",
        "[lights.lamp.point]\n",
        "\"\"\"",
        "= 3\n",
        "1979-05-27",
        "99999999999999999999",
        "format",
        "a.b.c = 1\n",
        "sh",
        "box",
    ])
}

proptest! {
    #![proptest_config(ProptestConfig {
        cases: 4000,
        failure_persistence: None,
        rng_seed: proptest::test_runner::RngSeed::Fixed(1),
        ..ProptestConfig::default()
    })]

    #[test]
    fn damaged_text_never_panics_and_errors_have_a_place(
        damages in prop::collection::vec(
            (any::<prop::sample::Index>(), 0_usize..12, snippet()),
            1..5,
        ),
        which in 0_usize..3,
    ) {
        let text = mutated([ROOM, SHAPES, HEAD_ROOM][which], &damages);
        match parse(&text, &[]) {
            Ok(_) => {}
            Err(Error::Input(error)) => {
                let lines = text.matches('\n').count() + 1;
                prop_assert!(error.line.is_some_and(|line| (1..=lines).contains(&line)), "{error}");
                prop_assert!(error.column.is_some_and(|column| column >= 1));
                prop_assert!(!error.message.is_empty());
            }
            Err(other) => prop_assert!(false, "{other}"),
        }
    }

    #[test]
    fn damaged_overrides_never_panic_and_name_themselves(
        damages in prop::collection::vec(
            (any::<prop::sample::Index>(), 0_usize..8, snippet()),
            0..3,
        ),
        which in 0_usize..4,
        value in prop_oneof!["\\PC{0,12}", "[-\\[\\]{}\"'0-9a-z.,= ]{0,12}"],
    ) {
        let keys = [
            "lights.lamp.point.intensity",
            "objects.room.box.faces.z_min",
            "render.stop",
            "sensors.desk",
        ];
        let key = mutated(keys[which], &damages);
        if let Err(error) = parse(ROOM, &[(&key, &value)]) {
            prop_assert!(matches!(error, Error::Parameter(_) | Error::Input(_)));
            let said = error.to_string();
            prop_assert!(said.starts_with("-D ") || said.starts_with("dir/room.toml:"));
        }
    }
}
