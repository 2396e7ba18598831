//! Light in a room that is built in code: illuminance at two sensors, each with its interval.
//!
//!     cargo run --release --example room

use std::ops::ControlFlow;
use std::sync::Arc;

use glam::{DQuat, DVec3};
use harmolux::Result;
use harmolux::estimators::{Estimator, SensorSettings, Stop, Weighting, illuminance};
use harmolux::math::{Placement, Randomness, Rgb};
use harmolux::scene::{Material, Object, PointLight, Scene, Sensor};
use harmolux::sh::Coefficients;
use harmolux::surface::primitives::AxisBox;
use harmolux::surface::{Instance, Intersector, ShSurface};

fn main() -> Result<()> {
    // Grey walls, with normals that point into the room; metres, z up.
    let walls = AxisBox::new(DVec3::ZERO, DVec3::new(4.0, 5.0, 3.0))?.turned_inward(true);
    let room = Object::new("room", walls, Material::lambert(Rgb::grey(0.6))?);

    // An egg of spherical harmonics, scaled by 0.4 and moved to the middle of the room.
    let mut radius = Coefficients::zeros(2);
    radius.set(0, 0, 1.0, 0.0);
    radius.set(2, 0, 0.2, 0.0);
    let egg = Arc::new(ShSurface::new(&radius, Intersector::default())?);
    let placement = Placement::new(DQuat::IDENTITY, 0.4, DVec3::new(2.0, 2.5, 1.0))?;
    let egg = Object::new("egg", Instance::new(egg, placement), Material::lambert(Rgb::grey(0.8))?);

    // A lamp of 100 cd above the egg, one sensor in the egg's shadow and one in a corner.
    let lamp = PointLight::isotropic("lamp", DVec3::new(2.0, 2.5, 2.8), Rgb::grey(100.0));
    let scene = Scene::new(vec![room, egg], vec![lamp])?;
    let sensors = [
        Sensor::plane(DVec3::new(2.0, 2.5, 0.0), DVec3::Z),
        Sensor::plane(DVec3::new(0.5, 0.5, 0.0), DVec3::Z),
    ];

    // Walks go on until every 95 % interval is within 1 % of its value.
    let settings = SensorSettings {
        estimator: Estimator::Local(Weighting::of(&scene)),
        randomness: Randomness::Sobol,
        seed: 1,
        stop: Stop { relative_error: Some(0.01), ..Stop::default() },
    };
    let survey = illuminance(&scene, &sensors, &settings, &|_| ControlFlow::Continue(()))?;
    for (name, measured) in ["in the shadow", "in the corner"].iter().zip(&survey.results) {
        let lux = measured.total;
        println!("{name}: {:.2} +- {:.2} lx", lux.mean, lux.half_width(0.05));
    }
    println!("{} walks", survey.walks);
    Ok(())
}
