//! Lamps by shape, size and reflectance of the room, and a surface at the origin; the truth is a
//! long run of its own seed.

use std::ops::ControlFlow;

use glam::DVec3;
use harmolux::Result;
use harmolux::estimators::{Estimator, SensorSettings, Stop, Weighting, illuminance};
use harmolux::fit::{Resolution, Tessellation, tessellate};
use harmolux::math::{Randomness, Rgb};
use harmolux::mesh::Mesh;
use harmolux::scene::{Distribution, Object, PointLight, Scene, Sensor};
use harmolux::sh::Coefficients;
use harmolux::surface::primitives::{AxisBox, Disc, Sphere};
use harmolux::surface::{Intersector, MeshSurface, SampleArea, ShSurface};

use super::{Problem, grey};

/// The walks of a truth, and of the runs that are judged.
const TRUTH: u64 = 1 << 19;
const FIXED: Stop = Stop { relative_error: None, time: None, walks: Some(2048) };

pub(super) fn problems() -> Result<Vec<Problem>> {
    let mut problems = vec![at_the_origin()?];
    for radius in [0.02, 0.05, 0.1, 0.3] {
        for reflectance in [0.0, 0.05, 0.5] {
            let ball = Sphere::new(LAMP, radius)?;
            problems.push(room("ball", radius, reflectance, ball)?);
            let disc = Disc::new(LAMP, DVec3::NEG_Z, radius)?;
            problems.push(room("disc", radius, reflectance, disc)?);
            problems.push(room("SH body", radius, reflectance, body(radius)?)?);
            problems.push(room("mesh", radius, reflectance, mesh(radius)?)?);
        }
    }
    Ok(problems)
}

const LAMP: DVec3 = DVec3::new(2.0, 2.0, 2.2);

/// A lamp in a room, an obstacle under it that shades a part of the floor.
fn room(
    shape: &str,
    radius: f64,
    reflectance: f64,
    lamp: impl SampleArea + 'static,
) -> Result<Problem> {
    let walls = AxisBox::new(DVec3::ZERO, DVec3::new(4.0, 4.0, 3.0))?.turned_inward(true);
    let desk = AxisBox::new(DVec3::new(2.2, 1.0, 0.7), DVec3::new(3.2, 2.5, 0.75))?;
    let light = grey(0.0)?.emitting(Rgb::grey(1e3 / lamp.area()));
    let objects = vec![
        Object::new("room", walls, grey(reflectance)?),
        Object::new("desk", desk, grey(reflectance)?),
        Object::new("lamp", lamp, light),
    ];
    let places = [(1.0, 1.0, 0.0), (2.0, 2.0, 0.0), (2.1, 1.5, 0.0), (2.5, 2.0, 0.75)];
    let sensors = places.map(|(x, y, z)| Sensor::plane(DVec3::new(x, y, z), DVec3::Z));
    let name = format!("{shape} r {radius}, rho {reflectance}");
    long_run(name, Scene::new(objects, vec![])?, sensors.to_vec())
}

/// A bumpy body of degree 3 about the lamp's place.
fn body(radius: f64) -> Result<impl SampleArea> {
    use harmolux::math::Placement;
    use harmolux::surface::Instance;
    let mut c = Coefficients::zeros(3);
    c.set(0, 0, radius, 0.0);
    c.set(2, 1, 0.2 * radius, 0.1 * radius);
    c.set(3, 2, 0.1 * radius, -0.1 * radius);
    let surface = std::sync::Arc::new(ShSurface::new(&c, Intersector::Patches)?);
    Ok(Instance::new(surface, Placement::new(glam::DQuat::IDENTITY, 1.0, LAMP)?))
}

/// A ball of some hundred triangles.
fn mesh(radius: f64) -> Result<MeshSurface> {
    let mut c = Coefficients::zeros(0);
    c.set(0, 0, radius, 0.0);
    let Tessellation { mesh, .. } =
        tessellate(&c, DVec3::ZERO, Resolution::Icosphere { frequency: 4 })?;
    let moved: Vec<DVec3> = mesh.positions().iter().map(|p| *p + LAMP).collect();
    MeshSurface::new(Mesh::new(moved, mesh.triangles().to_vec())?)
}

/// A problem that paths do not solve: they find nothing small from afar.
pub(super) const AT_THE_ORIGIN: &str = "disc at the origin";

/// A disc through the origin that a lamp 10 cm above it lights, seen from 6 m above.
fn at_the_origin() -> Result<Problem> {
    let disc = Disc::new(DVec3::ZERO, DVec3::Z, 2.0)?;
    let distribution = Distribution::Lambert { axis: DVec3::NEG_Z };
    let at = DVec3::new(0.05, 0.04, 0.1);
    let lamp = PointLight { distribution, ..PointLight::isotropic("lamp", at, Rgb::WHITE) };
    let sensors = [0.1, 0.5].map(|x| Sensor::plane(DVec3::new(x, 0.0, 6.0), DVec3::NEG_Z));
    let scene = Scene::new(vec![Object::new("disc", disc, grey(0.5)?)], vec![lamp])?;
    // Of 64 hits a replicate has none or one far out: of 2048 walks the intervals hold 91 %.
    let stop = Stop { walks: Some(8192), ..FIXED };
    Ok(Problem { stop, ..long_run(AT_THE_ORIGIN.to_owned(), scene, sensors.to_vec())? })
}

fn long_run(name: String, scene: Scene, sensors: Vec<Sensor>) -> Result<Problem> {
    let settings = SensorSettings {
        estimator: Estimator::Local(Weighting::of(&scene)),
        randomness: Randomness::Sobol,
        seed: 2026,
        stop: Stop { walks: Some(TRUTH), ..Stop::default() },
    };
    let survey = illuminance(&scene, &sensors, &settings, &|_| ControlFlow::Continue(()))?;
    let exact = survey.results.iter().map(|r| r.total.mean).collect();
    Ok(Problem { name, scene, sensors, exact, stop: FIXED })
}
