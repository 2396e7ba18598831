//! Pixels of pictures of small lamps: how many 95 % intervals hold the mean of all other seeds.

use std::ops::ControlFlow;

use glam::DVec3;
use harmolux::Result;
use harmolux::estimators::{Estimator, ImageSettings, Stop, Weighting, render};
use harmolux::math::stats::student_t;
use harmolux::math::{Randomness, Rgb};
use harmolux::scene::{Camera, Filter, Object, Scene};
use harmolux::surface::primitives::{AxisBox, Sphere};

use super::{POOLED, grey};

const SEEDS: u64 = 24;
/// Eye rays a pixel, and walks to each.
const EYE_RAYS: u64 = 128;
const WALKS: u64 = 32;

pub(super) fn judge() -> Result<bool> {
    let mut good = true;
    println!("picture of                  pixels held by their 95 % interval, {SEEDS} seeds");
    for radius in [0.05, 0.1, 0.3] {
        for reflectance in [0.05, 0.5] {
            let held = held(radius, reflectance)?;
            let verdict = POOLED.contains(&held);
            good &= verdict;
            let verdict = if verdict { "as claimed" } else { "NOT as claimed" };
            let name = format!("ball r {radius}, rho {reflectance}");
            println!("{name:25}  {:7.2} %   {verdict}", 100.0 * held);
        }
    }
    Ok(good)
}

fn held(radius: f64, reflectance: f64) -> Result<f64> {
    let walls = AxisBox::new(DVec3::ZERO, DVec3::new(4.0, 4.0, 3.0))?.turned_inward(true);
    let desk = AxisBox::new(DVec3::new(2.2, 1.0, 0.7), DVec3::new(3.2, 2.5, 0.75))?;
    let lamp = Sphere::new(DVec3::new(2.0, 2.0, 2.2), radius)?;
    let light = grey(0.0)?.emitting(Rgb::grey(80.0 / (radius * radius)));
    let objects = vec![
        Object::new("room", walls, grey(reflectance)?),
        Object::new("desk", desk, grey(reflectance)?),
        Object::new("lamp", lamp, light),
    ];
    let scene = Scene::new(objects, vec![])?;
    let from = DVec3::new(0.3, 0.4, 1.4);
    let camera = Camera::perspective(from, DVec3::new(2.6, 2.2, 0.3), 1.0, [20, 16])?;
    let films = (0..SEEDS).map(|seed| {
        let settings = ImageSettings {
            estimator: Estimator::Local(Weighting::of(&scene)),
            randomness: Randomness::Sobol,
            seed,
            stop: Stop { walks: Some(EYE_RAYS * WALKS), ..Stop::default() },
            filter: Filter::Box,
        };
        let rendering = render(&scene, &camera, &settings, &|_| ControlFlow::Continue(()))?;
        Ok(rendering.film)
    });
    let films = films.collect::<Result<Vec<_>>>()?;
    let pixels = films[0].size().iter().product();
    let quantile = student_t(0.05, films[0].replicates() - 1);
    let mut held = 0;
    for pixel in 0..pixels {
        let all: f64 = films.iter().map(|f| f.pixel(pixel).luminance()).sum();
        for film in &films {
            let own = film.pixel(pixel).luminance();
            let others = (all - own) / (SEEDS - 1) as f64;
            // The mean of the others has an error, too.
            let error = film.standard_error(pixel) * (1.0 + 1.0 / (SEEDS - 1) as f64).sqrt();
            held += u64::from((own - others).abs() <= quantile * error + 1e-12 * own);
        }
    }
    Ok(held as f64 / (pixels as u64 * SEEDS) as f64)
}
