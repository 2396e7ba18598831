//! Scattered points become the coefficients of their distance from a centre, by least squares.

use std::time::{Duration, Instant};

use glam::DVec3;

use crate::fit::mesh_fit::{Centre, FitSettings, Projection};
use crate::math::Aabb;
use crate::mesh::Points;
use crate::sh::{Coefficients, Series, StandardError, fit_with_error};
use crate::{Error, Result};

/// Holds a series fitted to points and how well it meets them.
#[derive(Debug, Clone, PartialEq)]
pub struct PointFit {
    /// The series of the radius, in the unit of the points.
    pub coefficients: Coefficients,
    /// The expansion centre.
    pub centre: DVec3,
    /// The weighted root mean square of the radial differences at the points, metres.
    pub rms: f64,
    /// The largest radial difference at a point of any weight, metres.
    pub max: f64,
    /// The error that the scatter of the points leaves in the series before a filter, metres, if
    /// they scatter independently; `None` when there are no more points than coefficients.
    pub error: Option<StandardError>,
    /// How many points there are.
    pub count: usize,
    /// The time the fit took.
    pub projection_time: Duration,
}

/// Fits points about the given centre; without one about the origin if that lies within the bounds
/// of the points, else about their weighted mean.
///
/// # Errors
/// [`Error::Parameter`] when the settings ask for a projection or a centre that needs faces;
/// [`Error::Geometry`] for a point at the centre; and as [`fit_with_error`].
pub fn fit_points(points: &Points, settings: &FitSettings) -> Result<PointFit> {
    let Projection::LeastSquares { lambda } = settings.projection else {
        return Err(Error::Parameter(
            "points have no faces to project: fit them by least squares".to_owned(),
        ));
    };
    let centre = choose_centre(points, settings.centre)?;
    let radii: Vec<f64> = points.positions.iter().map(|p| p.distance(centre)).collect();
    let direction = |(i, p): (usize, &DVec3)| {
        (*p - centre).try_normalize().ok_or_else(|| {
            Error::Geometry(format!(
                "point {i} (from 0) stands at the centre {centre:.6}, so it has no direction: \
                 give another centre, or leave it out"
            ))
        })
    };
    let directions: Vec<DVec3> =
        points.positions.iter().enumerate().map(direction).collect::<Result<_>>()?;
    let started = Instant::now();
    let (plain, error) =
        fit_with_error(&directions, &radii, &points.weights, settings.lmax, lambda)?;
    let projection_time = started.elapsed();
    let coefficients = settings.filter.map_or_else(|| plain.clone(), |f| f.apply(&plain));
    let series = Series::new(&coefficients)?;
    let (mut squares, mut all, mut max) = (0.0, 0.0, 0.0_f64);
    for ((direction, radius), weight) in directions.iter().zip(&radii).zip(&points.weights) {
        let difference = radius - series.value(*direction);
        squares += weight * difference * difference;
        all += weight;
        max = max.max(if *weight > 0.0 { difference.abs() } else { 0.0 });
    }
    let rms = (squares / all).sqrt();
    let count = radii.len();
    Ok(PointFit { coefficients, centre, rms, max, error, count, projection_time })
}

fn choose_centre(points: &Points, rule: Option<Centre>) -> Result<DVec3> {
    match rule {
        Some(Centre::At(centre)) => return Ok(centre),
        Some(Centre::Best) => {
            return Err(Error::Parameter(
                "points have no faces that a centre could be best for: take their centroid"
                    .to_owned(),
            ));
        }
        Some(Centre::Centroid) | None => {}
    }
    let bounds = Aabb::of_points(points.positions.iter().copied());
    let inside = bounds.min.cmplt(DVec3::ZERO).all() && bounds.max.cmpgt(DVec3::ZERO).all();
    if inside && rule.is_none() {
        return Ok(DVec3::ZERO);
    }
    let all: f64 = points.weights.iter().sum();
    let moment: DVec3 = points.positions.iter().zip(&points.weights).map(|(p, w)| *p * *w).sum();
    Ok(moment / all)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Points of the sphere of radius 2 about `centre`.
    fn ball(centre: DVec3) -> Points {
        let turn = |i: usize| 2.4 * i as f64;
        let point = |i: usize| {
            let z = 1.0 - (2 * i + 1) as f64 / 100.0;
            let s = (1.0 - z * z).sqrt();
            centre + 2.0 * DVec3::new(s * turn(i).cos(), s * turn(i).sin(), z)
        };
        Points { positions: (0..100).map(point).collect(), weights: vec![1.0; 100] }
    }

    const SETTINGS: FitSettings = FitSettings {
        projection: Projection::LeastSquares { lambda: 0.0 },
        ..FitSettings::of_degree(3)
    };

    #[test]
    fn no_projection_but_least_squares_will_do() {
        let refused = fit_points(&ball(DVec3::ZERO), &FitSettings::of_degree(3));
        assert!(refused.expect_err("refused").to_string().contains("least squares"));
    }

    #[test]
    fn a_point_at_the_centre_is_named() {
        let mut points = ball(DVec3::ZERO);
        points.positions[7] = DVec3::ZERO;
        let refused = fit_points(&points, &SETTINGS).expect_err("refused");
        assert!(refused.to_string().starts_with("point 7 (from 0)"), "{refused}");
    }

    #[test]
    fn centre_is_found_by_the_rule() {
        let middle = DVec3::splat(0.1);
        let fit = |rule| fit_points(&ball(middle), &FitSettings { centre: Some(rule), ..SETTINGS });
        let centroid = fit(Centre::Centroid).expect("determined").centre;
        assert!((centroid - middle).length() <= 0.02 && centroid != DVec3::ZERO);
        assert_eq!(fit(Centre::At(middle)).expect("determined").centre, middle);
        assert!(fit(Centre::Best).expect_err("refused").to_string().contains("centroid"));
    }

    #[test]
    fn a_ball_is_found_about_the_origin_and_about_its_middle() {
        for centre in [DVec3::ZERO, DVec3::splat(10.0)] {
            let fit = fit_points(&ball(centre), &SETTINGS).expect("determined");
            // The spiral's own mean is a little off the middle.
            assert!((fit.centre - centre).length() <= 0.02, "{}", fit.centre);
            assert!((fit.coefficients.mean() - 2.0).abs() <= 1e-3 && fit.rms <= 1e-5, "{fit:?}");
        }
    }
}
