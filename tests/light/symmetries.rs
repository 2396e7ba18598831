//! What is invariant: a scene that is moved, scaled, turned, mirrored, told in another order or cut
//! in two has the same light.
//!
//! Every primitive, a mesh and an SH body, all kinds of material and lamp take part. Seeds are
//! fixed; a value may differ by four joint standard errors (one in 16 000 by chance, were the runs
//! independent) and by roundings.

use std::sync::Arc;

use crate::common::{bumpy, furnace, go_on, grey, sensors, sphere_mesh};
use glam::{DMat3, DQuat, DVec3};
use harmolux::estimators::{Estimator, RadiositySettings, Survey, Weighting, illuminance};
use harmolux::math::{Placement, Rgb};
use harmolux::scene::{Distribution, Glossy, Material, Measure, Object, PointLight, Scene, Sensor};
use harmolux::surface::primitives::{AxisBox, Disc, Plane, Rectangle, Sphere};
use harmolux::surface::{Instance, MeshSurface, SampleArea};

/// A similarity: turned, scaled, moved; mirrored first, at x = 0, when `mirrored`.
#[derive(Debug, Clone, Copy)]
struct World {
    turn: DQuat,
    scale: f64,
    shift: DVec3,
    mirrored: bool,
}

const HERE: World =
    World { turn: DQuat::IDENTITY, scale: 1.0, shift: DVec3::ZERO, mirrored: false };

impl World {
    fn moved(x: f64, y: f64, z: f64) -> Self {
        Self { shift: DVec3::new(x, y, z), ..HERE }
    }

    fn scaled(scale: f64) -> Self {
        Self { scale, ..HERE }
    }

    fn along(&self, d: DVec3) -> DVec3 {
        self.turn * if self.mirrored { DVec3::new(-d.x, d.y, d.z) } else { d }
    }

    fn at(&self, p: DVec3) -> DVec3 {
        self.scale * self.along(p) + self.shift
    }

    fn rectangle(&self, corner: DVec3, u: DVec3, v: DVec3, m: Material) -> Object {
        // Mirroring turns the normal round, so the edges change places.
        let (u, v) = if self.mirrored { (v, u) } else { (u, v) };
        let edge = |e| self.scale * self.along(e);
        let surface = Rectangle::new(self.at(corner), edge(u), edge(v)).expect("valid");
        Object::new("rectangle", surface, m)
    }

    fn disc(&self, centre: DVec3, normal: DVec3, radius: f64, m: Material) -> Object {
        let surface = Disc::new(self.at(centre), self.along(normal), self.scale * radius);
        Object::new("disc", surface.expect("valid"), m)
    }

    fn ball(&self, centre: DVec3, radius: f64, m: Material) -> Object {
        let surface = Sphere::new(self.at(centre), self.scale * radius).expect("valid");
        Object::new("ball", surface, m)
    }

    /// Places a shape by itself, or a turned one as an instance.
    fn solid(&self, min: DVec3, max: DVec3, inward: bool, m: Material) -> Object {
        if self.turn == DQuat::IDENTITY {
            let (a, b) = (self.at(min), self.at(max));
            let surface = AxisBox::new(a.min(b), a.max(b)).expect("valid").turned_inward(inward);
            return Object::new("box", surface, m);
        }
        let surface = AxisBox::new(min, max).expect("valid").turned_inward(inward);
        self.placed(surface, DVec3::ZERO, 1.0, m)
    }

    fn placed<S: SampleArea + 'static>(&self, s: S, at: DVec3, size: f64, m: Material) -> Object {
        let placement = Placement::new(self.turn, self.scale * size, self.at(at)).expect("valid");
        Object::new("placed", Instance::new(Arc::new(s), placement), m)
    }

    fn mesh(&self, at: DVec3, radius: f64, m: Material) -> Object {
        let mesh = sphere_mesh(2, |d| self.at(at + radius * d));
        let mesh = if self.mirrored { mesh.flipped() } else { mesh };
        Object::new("mesh", MeshSurface::new(mesh).expect("valid"), m)
    }

    /// Lamps grow with the scene, so that illuminances stay.
    fn lamp(&self, at: DVec3, candela: f64) -> PointLight {
        let intensity = Rgb::grey(candela * self.scale * self.scale);
        PointLight::isotropic("lamp", self.at(at), intensity)
    }

    fn sensor(&self, at: DVec3, normal: DVec3) -> Sensor {
        Sensor::plane(self.at(at), self.along(normal))
    }
}

fn estimators(scene: &Scene) -> [Estimator; 2] {
    [Estimator::Local(Weighting::of(scene)), Estimator::Path]
}

fn measure(scene: &Scene, points: &[Sensor], estimator: Estimator, walks: u64) -> Survey {
    illuminance(scene, points, &sensors(estimator, walks), &go_on).expect("runs")
}

/// Whether two surveys tell the same.
fn assert_same(a: &Survey, b: &Survey, what: &str) {
    for (i, (a, b)) in a.results.iter().zip(&b.results).enumerate() {
        let joint = a.total.standard_error.hypot(b.total.standard_error);
        let off = (a.total.mean - b.total.mean).abs();
        assert!(
            off <= 4.0 * joint + 1e-9 * a.total.mean.abs(),
            "{what}, sensor {i}: {:?} against {:?}",
            a.total,
            b.total
        );
    }
}

/// Places where rounding differs most: the origin, beside it, near, far.
fn places() -> Vec<World> {
    let mut all = vec![HERE, World::moved(1e-17, -3e-16, 2e-15), World::moved(7.0, -11.0, 13.0)];
    all.extend([World::moved(1e3, -2e3, 0.7e3), World::moved(4.1e5, 5.6e6, 30.0)]);
    all.extend([1e-6, 1e-3, 1e3, 1e6].map(World::scaled));
    let turn = DQuat::from_axis_angle(DVec3::new(1.0, -2.0, 0.5).normalize(), 0.8);
    all.extend([World { turn, ..HERE }, World { turn, ..World::moved(3.0, 1.0, -2.0) }]);
    all.push(World { turn, scale: 1e-4, ..World::moved(-20.0, 5.0, 1.0) });
    all.push(World { mirrored: true, ..HERE });
    all
}

/// One lit surface through the point (0, 0, 0), seen from afar.
type Lit = (&'static str, fn(&World, Material) -> Object);

const LIT: [Lit; 8] = [
    ("rectangle", |w, m| {
        let corner = DVec3::new(-0.1, -0.1, 0.0);
        w.rectangle(corner, 2.0 * DVec3::X, 2.0 * DVec3::Y, m)
    }),
    ("corner of a rectangle", |w, m| w.rectangle(DVec3::ZERO, 2.0 * DVec3::X, 2.0 * DVec3::Y, m)),
    ("disc", |w, m| w.disc(DVec3::ZERO, DVec3::Z, 2.0, m)),
    ("ball", |w, m| w.ball(-DVec3::Z, 1.0, m)),
    ("box", |w, m| w.solid(DVec3::new(-1.0, -1.0, -2.0), DVec3::new(1.0, 1.0, 0.0), false, m)),
    ("mesh", |w, m| w.mesh(-DVec3::Z, 1.0, m)),
    ("SH body", |w, m| w.placed(bumpy(), DVec3::new(0.0, 0.0, -1.0), 0.9, m)),
    ("plane", |w, m| {
        let surface = Plane::new(w.at(DVec3::ZERO), w.along(DVec3::Z)).expect("valid");
        Object { area: None, surface: Arc::new(surface), ..w.ball(DVec3::ZERO, 1.0, m) }
    }),
];

/// A lamp 10 cm above a surface through the origin, sensors from 0.3 m to 1000 km above it: a
/// quarter of the light was lost.
#[test]
fn light_of_a_surface_is_the_same_wherever_it_stands_and_from_however_far() {
    for (name, lit) in LIT {
        let seen = |world: &World, estimator: Option<Estimator>| {
            let lamp = world.lamp(DVec3::new(0.05, 0.04, 0.1), 1.0);
            let objects = vec![lit(world, grey(0.5))];
            let scene = Scene::new(objects, vec![lamp]).expect("valid");
            let up = |z: f64| world.sensor(DVec3::new(0.1, 0.0, z), DVec3::NEG_Z);
            let points = [0.3, 6.0, 1e3, 1e6].map(up);
            let estimator = estimator.unwrap_or(estimators(&scene)[0]);
            measure(&scene, &points, estimator, 1 << 13)
        };
        // A mirrored body is another body.
        let mirrors = name != "SH body";
        let reference = seen(&World::moved(7.0, -11.0, 13.0), None);
        for world in places().into_iter().filter(|w| mirrors || !w.mirrored) {
            assert_same(&seen(&world, None), &reference, &format!("{name}, {world:?}"));
        }
        // Paths find nothing small from afar.
        let mut path = seen(&HERE, Some(Estimator::Path));
        path.results.truncate(2);
        assert_same(&path, &reference, name);
        // From so far away light falls off by the square alone: to a thousandth at a kilometre.
        if name != "plane" {
            let [near, far] = [2, 3].map(|i| reference.results[i].total.mean);
            assert!((1e6 * far / near - 1.0).abs() <= 5e-3, "{name}: {near:e} {far:e}");
        }
    }
}

/// A room with every primitive, a mesh, an SH body, all kinds of material and lamp.
fn furnished(w: &World) -> (Vec<Object>, Vec<PointLight>, Vec<Sensor>) {
    let v = DVec3::new;
    let metal = Glossy::metal(Rgb::grey(0.7), 0.4).expect("valid");
    let coated = Glossy::coated(Rgb::grey(0.5), 1.5, 0.3).expect("valid");
    let shine = |lux: f64| grey(0.2).emitting(Rgb::grey(lux));
    let objects = vec![
        w.solid(DVec3::ZERO, v(4.0, 5.0, 3.0), true, grey(0.5)),
        w.solid(v(0.5, 3.0, 0.0), v(1.5, 4.0, 0.75), false, Material::glossy(coated)),
        w.ball(v(3.0, 4.0, 0.5), 0.5, Material::glossy(metal)),
        w.mesh(v(1.0, 1.0, 0.4), 0.4, grey(0.8)),
        w.disc(v(2.0, 2.5, 0.01), DVec3::Z, 0.5, grey(0.1)),
        w.rectangle(v(1.7, 2.2, 3.0), 0.6 * DVec3::Y, 0.6 * DVec3::X, shine(3000.0)),
        w.disc(v(3.0, 1.0, 2.9), DVec3::NEG_Z, 0.2, shine(5000.0)),
        w.ball(v(0.8, 2.5, 2.2), 0.1, shine(5000.0)),
        w.mesh(v(3.3, 3.0, 1.8), 0.1, shine(4000.0)),
    ];
    let axis = w.along(v(0.0, 0.6, -0.8));
    let spot = Distribution::Spot { axis, inner: 0.9, outer: 0.7 };
    let lamps = vec![
        w.lamp(v(2.0, 0.5, 2.5), 20.0),
        PointLight { distribution: spot, ..w.lamp(v(3.5, 0.5, 2.5), 50.0) },
    ];
    let sensors = vec![
        w.sensor(v(2.0, 1.5, 0.0), DVec3::Z),
        w.sensor(v(1.0, 3.5, 0.75), DVec3::Z),
        w.sensor(v(0.0, 2.0, 1.2), DVec3::X),
        Sensor { measure: Measure::Cylinder, ..w.sensor(v(3.0, 2.0, 1.2), DVec3::Z) },
    ];
    (objects, lamps, sensors)
}

#[test]
fn light_in_a_room_is_the_same_wherever_it_stands() {
    let seen = |world: &World| {
        let (objects, lamps, points) = furnished(world);
        let scene = Scene::new(objects, lamps).expect("valid");
        estimators(&scene).map(|e| measure(&scene, &points, e, 1 << 12))
    };
    let here = seen(&HERE);
    assert_same(&here[0], &here[1], "local and path");
    for world in places() {
        for (moved, here) in seen(&world).iter().zip(&here) {
            assert_same(moved, here, &format!("{world:?}"));
        }
    }
}

#[test]
fn order_of_objects_and_number_of_threads_make_no_difference() {
    let (objects, lamps, points) = furnished(&HERE);
    let run = |turn: usize, threads: usize| {
        let mut objects = objects.clone();
        objects.rotate_left(turn);
        let scene = Scene::new(objects, lamps.clone()).expect("valid");
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        let estimator = estimators(&scene)[0];
        pool.install(|| measure(&scene, &points, estimator, 1 << 12))
    };
    let first = run(0, 1);
    assert_eq!(first.results, run(0, 7).results, "threads");
    for turn in 1..objects.len() {
        assert_same(&run(turn, 2), &first, &format!("turned by {turn}"));
    }
}

#[test]
fn furnaces_are_even_wherever_they_stand() {
    for world in places() {
        let w = &world;
        let body = w.placed(bumpy(), DVec3::new(2.0, 2.5, 1.2), 0.7, furnace(0.4, 100.0));
        let ball = w.ball(DVec3::new(0.7, 0.7, 0.0), 0.5, furnace(0.3, 100.0));
        let walls = w.solid(DVec3::ZERO, DVec3::new(4.0, 5.0, 3.0), true, furnace(0.6, 100.0));
        let scene = Scene::new(vec![walls, body, ball], vec![]).expect("valid");
        let points = [
            w.sensor(DVec3::new(2.0, 1.0, 0.0), DVec3::Z),
            w.sensor(DVec3::new(0.01, 0.01, 3.0), DVec3::NEG_Z),
            w.sensor(DVec3::new(4.0, 2.0, 1.0), DVec3::NEG_X),
        ];
        for estimator in estimators(&scene) {
            for result in measure(&scene, &points, estimator, 1 << 11).results {
                let exact = 100.0 * std::f64::consts::PI;
                assert!(result.total.agrees_with(exact, 0.0, 1000), "{world:?}: {result:?}");
            }
        }
    }
}

/// A Lambertian lamp and a plane sensor change places: E / I stays, behind any obstacles.
#[test]
fn lamp_and_sensor_may_be_swapped() {
    let (objects, _, _) = furnished(&HERE);
    let dark = objects.into_iter().filter(|o| !o.emits()).collect::<Vec<_>>();
    let ends = [
        (DVec3::new(2.0, 1.5, 0.3), DVec3::new(0.0, 0.6, 0.8)),
        (DVec3::new(3.5, 4.5, 2.0), DVec3::new(-0.8, 0.0, -0.6)),
    ];
    let run = |[(lamp, axis), (at, normal)]: [(DVec3, DVec3); 2], estimator: usize| {
        let distribution = Distribution::Lambert { axis };
        let lamp = PointLight { distribution, ..HERE.lamp(lamp, 100.0) };
        let scene = Scene::new(dark.clone(), vec![lamp]).expect("valid");
        measure(&scene, &[Sensor::plane(at, normal)], estimators(&scene)[estimator], 1 << 14)
    };
    for estimator in [0, 1] {
        let there = run(ends, estimator);
        assert_same(&there, &run([ends[1], ends[0]], estimator), "swapped");
        assert!(there.results[0].total.relative_error() <= 0.03);
    }
}

/// A floor and the lamps above it, whole and in two halves; the round ones as meshes that are
/// nearly so.
#[test]
fn objects_may_be_cut_in_two() {
    let v = DVec3::new;
    let lux = |x: f64| grey(0.3).emitting(Rgb::grey(x));
    let run = |halves: bool, estimator: usize| {
        let strip = |x: f64, width: f64, z: f64, m: Material| {
            HERE.rectangle(v(x, -1.0, z), width * DVec3::X, 2.0 * DVec3::Y, m)
        };
        let lamp = |x: f64, width: f64| {
            HERE.rectangle(v(x, 0.0, 2.0), 0.5 * DVec3::Y, width * DVec3::X, lux(900.0))
        };
        let objects = if halves {
            let floor = [strip(-1.0, 1.0, 0.0, grey(0.7)), strip(0.0, 1.0, 0.0, grey(0.7))];
            floor.into_iter().chain([lamp(-0.3, 0.4), lamp(0.1, 0.2)]).collect()
        } else {
            vec![strip(-1.0, 2.0, 0.0, grey(0.7)), lamp(-0.3, 0.6)]
        };
        let scene = Scene::new(objects, vec![HERE.lamp(v(0.4, 0.4, 1.0), 3.0)]).expect("valid");
        let points =
            [v(0.0, 0.0, 1.2), v(0.0, 0.3, 0.01)].map(|at| Sensor::plane(at, DVec3::NEG_Z));
        measure(&scene, &points, estimators(&scene)[estimator], 1 << 14)
    };
    for estimator in [0, 1] {
        assert_same(&run(false, estimator), &run(true, estimator), "cut in two");
    }
}

/// A lamp in the plane of its ceiling, two lamps in one place, a carpet on a floor, two rooms with
/// one wall between them.
#[test]
fn surfaces_in_one_place_count_as_they_are_meant() {
    let v = DVec3::new;
    let turned = DQuat::from_axis_angle(v(0.3, 1.0, -0.5).normalize(), 1.1);
    for world in [HERE, World::moved(1e4, -3.0, 77.0), World { turn: turned, ..HERE }] {
        let w = &world;
        let room = || w.solid(DVec3::ZERO, v(4.0, 5.0, 3.0), true, grey(0.5));
        let next = || w.solid(v(4.0, 0.0, 0.0), v(8.0, 5.0, 3.0), true, grey(0.1));
        let lamp = |z: f64, lux: f64| {
            let m = grey(0.2).emitting(Rgb::grey(lux));
            w.rectangle(v(1.7, 2.2, z), 0.6 * DVec3::Y, 0.6 * DVec3::X, m)
        };
        let carpet =
            |z: f64| w.rectangle(v(1.0, 1.0, z), 2.0 * DVec3::X, 2.0 * DVec3::Y, grey(0.05));
        let points = [
            w.sensor(v(2.0, 2.5, 0.8), DVec3::Z),
            w.sensor(v(3.9, 2.0, 0.8), DVec3::NEG_Z),
            w.sensor(v(4.0, 3.0, 1.0), DVec3::NEG_X),
        ];
        let run = |objects: Vec<Object>, estimator: usize| {
            let scene = Scene::new(objects, vec![]).expect("valid");
            measure(&scene, &points, estimators(&scene)[estimator], 1 << 13)
        };
        for estimator in [0, 1] {
            // 10 um apart is beside each other, and makes no difference to the light.
            let apart = vec![room(), next(), carpet(1e-5), lamp(3.0 - 1e-5, 5000.0)];
            let apart = run(apart, estimator);
            let here = || vec![room(), next(), carpet(0.0), lamp(3.0, 5000.0)];
            for turn in 0..4 {
                let mut objects = here();
                objects.rotate_left(turn);
                assert_same(&run(objects, estimator), &apart, &format!("{world:?}, {turn}"));
            }
            if estimator == 0 && world.turn == DQuat::IDENTITY {
                let radiosity = |objects: Vec<Object>| {
                    let scene = Scene::new(objects, vec![]).expect("valid");
                    let by = Estimator::Radiosity(RadiositySettings::default());
                    let survey = measure(&scene, &points, by, 1);
                    let absorbed = survey.radiosity.expect("told").absorbed;
                    assert!(absorbed <= 1.02, "{absorbed}");
                    survey.results.iter().map(|r| r.total.mean).collect::<Vec<f64>>()
                };
                let apart = vec![room(), next(), carpet(1e-5), lamp(3.0 - 1e-5, 5000.0)];
                let pairs = radiosity(here()).into_iter().zip(radiosity(apart));
                for (here, apart) in pairs {
                    assert!((here / apart - 1.0).abs() <= 0.03, "{world:?}: {here} {apart}");
                }
            }
            let twice = vec![lamp(3.0, 2000.0), room(), next(), carpet(0.0), lamp(3.0, 3000.0)];
            assert_same(&run(twice, estimator), &apart, &format!("{world:?}, two lamps"));
        }
    }
}

/// Smooth meshes have two normals: what walks bring must fit what is seen backwards.
#[test]
fn smooth_meshes_that_shine_or_reflect_are_alike_by_walks_and_by_paths() {
    let mesh = || {
        let mesh = sphere_mesh(1, |d| DVec3::new(2.0, 2.5, 1.2) + 0.6 * d);
        welded(&mesh)
    };
    for material in [grey(0.0).emitting(Rgb::grey(100.0)), grey(0.9)] {
        let body = Object::new("body", MeshSurface::smooth(mesh()).expect("valid"), material);
        let room = HERE.solid(DVec3::ZERO, DVec3::new(4.0, 5.0, 3.0), true, grey(0.1));
        let lamp = HERE.lamp(DVec3::new(1.0, 1.0, 2.5), 100.0);
        let scene = Scene::new(vec![room, body], vec![lamp]).expect("valid");
        let points = [(1.0, 1.0), (2.0, 1.6), (3.5, 3.0)]
            .map(|(x, y)| Sensor::plane(DVec3::new(x, y, 0.0), DVec3::Z));
        let points: Vec<Sensor> = points
            .into_iter()
            .chain([Sensor::plane(DVec3::new(1.0, 1.0, 2.0), DVec3::new(0.6, 0.8, 0.0))])
            .collect();
        let [local, path] = estimators(&scene).map(|e| measure(&scene, &points, e, 1 << 15));
        assert_same(&local, &path, "smooth");
        assert!(local.results[3].total.relative_error() <= 0.01, "{:?}", local.results[3]);
    }
}

/// Joins vertices in one place, so that normals can be interpolated.
fn welded(mesh: &harmolux::mesh::Mesh) -> harmolux::mesh::Mesh {
    let mut positions: Vec<DVec3> = Vec::new();
    let mut number = |p: DVec3| {
        let known = positions.iter().position(|q| q.distance(p) <= 1e-9);
        known.unwrap_or_else(|| {
            positions.push(p);
            positions.len() - 1
        }) as u32
    };
    let faces = (0..mesh.triangles().len()).map(|f| mesh.corners(f).map(&mut number)).collect();
    harmolux::mesh::Mesh::new(positions, faces).expect("valid")
}

/// The turns are turns: what the rest relies on.
#[test]
fn turned_worlds_keep_lengths() {
    for world in places() {
        let columns = [DVec3::X, DVec3::Y, DVec3::Z].map(|axis| world.along(axis));
        let matrix = DMat3::from_cols(columns[0], columns[1], columns[2]);
        assert!((matrix.determinant().abs() - 1.0).abs() <= 1e-12);
    }
}
