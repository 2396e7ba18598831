//! Sobolev's problem, case A of the paper (Figure 2): the local estimate against the exact curve, and how its error falls with the number of
//! walks, for scrambled Sobol points and for plain random numbers.
//!
//!     cargo run --release --example sobolev

use std::ops::ControlFlow;
use std::sync::Arc;

use glam::DVec3;
use harmolux::Result;
use harmolux::estimators::{SensorEstimator, SensorSettings, Stop, Survey, Weighting, illuminance};
use harmolux::exact::{Plane as Side, SobolevProblem};
use harmolux::math::{Randomness, Rgb};
use harmolux::scene::{Material, Object, PointLight, Scene, Sensor};
use harmolux::surface::primitives::Plane;

const RADII: [f64; 8] = [0.0, 0.25, 0.5, 1.0, 1.5, 2.0, 3.0, 5.0];

fn main() -> Result<()> {
    let (scene, exact) = (planes()?, SobolevProblem::default());
    let survey = measure(&scene, Randomness::Sobol, 1 << 16)?;
    println!("   r       exact          E   95 % half width  in standard errors");
    for (r, result) in RADII.iter().zip(&survey.results) {
        let (e, reference) = (result.total, exact.illuminance(Side::Lower, *r)?);
        println!(
            "{r:4.2} {reference:11.6} {:10.6} {:17.6} {:19.2}",
            e.mean,
            e.half_width(0.05),
            (e.mean - reference) / e.standard_error
        );
    }
    println!(
        "\nlargest |dE| / E(0) over r <= 3 (the paper's measure)\n  walks      Sobol     random"
    );
    for power in [7, 9, 11, 13, 15] {
        let error = |randomness| -> Result<f64> {
            largest_error(&measure(&scene, randomness, 1 << power)?, &exact)
        };
        let (sobol, random) = (error(Randomness::Sobol)?, error(Randomness::Pseudorandom)?);
        println!("{:7} {:8.3} % {:8.3} %", 1 << power, 100.0 * sobol, 100.0 * random);
    }
    Ok(())
}

/// Two infinite planes of reflectance 1/2 one metre apart, and a point source of 1 cd between them.
fn planes() -> Result<Scene> {
    let plane = |name: &str, z: f64, normal: DVec3| -> Result<Object> {
        let materials = vec![Material::lambert(Rgb::grey(0.5))?];
        let surface = Arc::new(Plane::new(DVec3::Z * z, normal)?);
        Ok(Object { name: name.into(), surface, area: None, materials })
    };
    let objects = vec![plane("lower", 0.0, DVec3::Z)?, plane("upper", 1.0, DVec3::NEG_Z)?];
    let source = PointLight::isotropic("source", DVec3::Z * 0.5, Rgb::WHITE);
    Scene::new(objects, vec![source])
}

fn measure(scene: &Scene, randomness: Randomness, walks: u64) -> Result<Survey> {
    let sensors = RADII.map(|r| Sensor::plane(DVec3::X * r, DVec3::Z));
    let settings = SensorSettings {
        estimator: SensorEstimator::Local(Weighting::Walk),
        randomness,
        seed: 1,
        stop: Stop { walks: Some(walks), ..Stop::default() },
    };
    illuminance(scene, &sensors, &settings, &|_| ControlFlow::Continue(()))
}

fn largest_error(survey: &Survey, exact: &SobolevProblem) -> Result<f64> {
    let scale = exact.illuminance(Side::Lower, 0.0)?;
    let near = RADII.iter().zip(&survey.results).filter(|(r, _)| **r <= 3.0);
    near.map(|(r, result)| {
        Ok((result.total.mean - exact.illuminance(Side::Lower, *r)?).abs() / scale)
    })
    .try_fold(0.0, |worst: f64, error: Result<f64>| Ok(worst.max(error?)))
}
