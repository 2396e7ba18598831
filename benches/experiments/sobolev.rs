//! Sobolev's problem, case A of the paper (Figure 2): the local estimate against the exact curve,
//! and how its error falls with the number of walks: for scrambled Sobol points in 32 replicates,
//! which give every value its error, for one sequence of as many points, which gives none, and for
//! plain random numbers.
//!
//!     cargo run --release --features experiments --example sobolev

use std::ops::ControlFlow;
use std::sync::Arc;

use glam::DVec3;
use harmolux::Result;
use harmolux::estimators::{
    Estimator, REPLICATES, SensorSettings, Stop, Survey, Weighting, illuminance,
};
use harmolux::exact::{Plane as Side, SobolevProblem};
use harmolux::math::{Randomness, Rgb};
use harmolux::scene::{Material, Object, PointLight, Scene, Sensor};
use harmolux::surface::primitives::Plane;

const RADII: [f64; 8] = [0.0, 0.25, 0.5, 1.0, 1.5, 2.0, 3.0, 5.0];

fn main() -> Result<()> {
    let (scene, exact) = (planes()?, SobolevProblem::default());
    let survey = measure(&scene, Randomness::Sobol, 1 << 16, 1)?;
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
        "\nlargest |dE| / E(0) over r <= 3 (the paper's measure), root mean square over 128 runs"
    );
    println!("  walks   Sobol, 32 replicates   Sobol, one sequence   random");
    for walks in [32, 64, 128, 150, 256, 512, 1024, 2000, 4096, 8192] {
        // The replicates of long runs are short runs, independent of each other.
        let alone = |randomness| -> Result<f64> {
            let long = |seed| measure(&scene, randomness, walks * REPLICATES as u64, seed);
            let surveys = (1..=4).map(long).collect::<Result<Vec<Survey>>>()?;
            let short = |survey: &Survey, k: usize| {
                largest_error(survey.replicates.iter().map(|r| r[k]), &exact)
            };
            let short = &short;
            rms(surveys.iter().flat_map(|s| (0..REPLICATES).map(move |k| short(s, k))))
        };
        let replicated = rms((1..=128).map(|seed| {
            let survey = measure(&scene, Randomness::Sobol, walks, seed)?;
            largest_error(survey.results.iter().map(|r| r.total.mean), &exact)
        }))?;
        let (sequence, random) = (alone(Randomness::Sobol)?, alone(Randomness::Pseudorandom)?);
        let [replicated, sequence, random] = [replicated, sequence, random].map(|e| 100.0 * e);
        println!("{walks:7} {replicated:20.3} % {sequence:19.3} % {random:6.3} %");
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

fn measure(scene: &Scene, randomness: Randomness, walks: u64, seed: u64) -> Result<Survey> {
    let sensors = RADII.map(|r| Sensor::plane(DVec3::X * r, DVec3::Z));
    let settings = SensorSettings {
        estimator: Estimator::Local(Weighting::Walk),
        randomness,
        seed,
        stop: Stop { walks: Some(walks), ..Stop::default() },
    };
    illuminance(scene, &sensors, &settings, &|_| ControlFlow::Continue(()))
}

fn largest_error(values: impl Iterator<Item = f64>, exact: &SobolevProblem) -> Result<f64> {
    let scale = exact.illuminance(Side::Lower, 0.0)?;
    let near = RADII.iter().zip(values).filter(|(r, _)| **r <= 3.0);
    near.map(|(r, e)| Ok((e - exact.illuminance(Side::Lower, *r)?).abs() / scale))
        .try_fold(0.0, |worst: f64, error: Result<f64>| Ok(worst.max(error?)))
}

fn rms(errors: impl Iterator<Item = Result<f64>>) -> Result<f64> {
    let errors = errors.collect::<Result<Vec<f64>>>()?;
    Ok((errors.iter().map(|e| e * e).sum::<f64>() / errors.len() as f64).sqrt())
}
