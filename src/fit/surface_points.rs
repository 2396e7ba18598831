//! Points of a shape's surface in given directions: radius, place and normal.

use glam::DVec3;
use rayon::prelude::*;

use super::Shape;
use crate::sh::Evaluator;
use crate::{Error, Result, memory};

/// A direction from the expansion centre, in degrees: latitude from the plane z = 0 towards +z,
/// longitude from +x towards +y.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LatLong {
    latitude: f64,
    longitude: f64,
}

impl LatLong {
    /// Takes a latitude from -90 to 90 and any finite longitude, degrees.
    ///
    /// # Errors
    /// [`Error::Parameter`] for others.
    pub fn new(latitude: f64, longitude: f64) -> Result<Self> {
        if !(-90.0..=90.0).contains(&latitude) {
            let text = format!("a latitude is from -90 to 90 degrees, not {latitude}");
            return Err(Error::Parameter(text));
        }
        if !longitude.is_finite() {
            let text = format!("a longitude is a finite number of degrees, not {longitude}");
            return Err(Error::Parameter(text));
        }
        Ok(Self { latitude, longitude })
    }

    /// Returns the nodes of a grid from north to south, each ring from longitude 0 eastwards:
    /// `latitudes` (at least 2) at even distances from 90 to -90 degrees, both poles included, and
    /// `longitudes` (at least 1) from 0, 360/n degrees apart.
    ///
    /// # Errors
    /// [`Error::Parameter`] for fewer; [`Error::Memory`] for more than fits.
    pub fn grid(latitudes: usize, longitudes: usize) -> Result<Vec<Self>> {
        if latitudes < 2 || longitudes < 1 {
            return Err(Error::Parameter(format!(
                "a grid has at least 2 latitudes, the poles, and 1 longitude, not {latitudes} x \
                 {longitudes}"
            )));
        }
        let count = latitudes.saturating_mul(longitudes);
        ask::<Self>(count)?;
        let ring = |i: usize| {
            // North and south are mirrored to the last bit.
            let from = |i: usize| 90.0 - 180.0 * i as f64 / (latitudes - 1) as f64;
            let mirrored = latitudes - 1 - i;
            let latitude = if i <= mirrored { from(i) } else { -from(mirrored) };
            let longitude = move |j: usize| 360.0 * j as f64 / longitudes as f64;
            (0..longitudes).map(move |j| Self { latitude, longitude: longitude(j) })
        };
        Ok((0..latitudes).flat_map(ring).collect())
    }

    /// Returns the latitude, degrees.
    pub fn latitude(self) -> f64 {
        self.latitude
    }

    /// Returns the longitude as it was given, degrees.
    pub fn longitude(self) -> f64 {
        self.longitude
    }

    /// Returns the unit vector.
    pub fn direction(self) -> DVec3 {
        if self.latitude.abs() == 90.0 {
            return DVec3::new(0.0, 0.0, self.latitude.signum());
        }
        let (z, s) = self.latitude.to_radians().sin_cos();
        let (y, x) = (self.longitude % 360.0).to_radians().sin_cos();
        DVec3::new(s * x, s * y, z)
    }
}

/// A point of a surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SurfacePoint {
    /// Its direction from the expansion centre.
    pub at: LatLong,
    /// The radius, m.
    pub radius: f64,
    /// The place in the axes of the file, m: centre and radius along the direction.
    pub position: DVec3,
    /// The outward unit normal.
    pub normal: DVec3,
}

/// Evaluates a shape in many directions: radii to 1e-11 of the largest, from degree 96 on at a cost
/// for each that does not depend on the degree.
///
/// ```
/// use harmolux::fit::{LatLong, Shape, surface_points};
/// use harmolux::sh::Coefficients;
///
/// let mut radius = Coefficients::zeros(1);
/// radius.set(0, 0, 2.0, 0.0);
/// radius.set(1, 0, 0.5, 0.0); // 2 + cos(theta) / 2
/// let north = surface_points(&Shape::new(radius), &[LatLong::new(90.0, 0.0)?])?[0];
/// assert!((north.radius - 2.5).abs() <= 1e-15 && (north.normal.z - 1.0).abs() <= 1e-15);
/// # Ok::<(), harmolux::Error>(())
/// ```
///
/// # Errors
/// [`Error::Parameter`] for a degree too high to evaluate; [`Error::Memory`] when the points do not
/// fit.
pub fn surface_points(shape: &Shape, places: &[LatLong]) -> Result<Vec<SurfacePoint>> {
    ask::<SurfacePoint>(places.len())?;
    let series = Evaluator::new(&shape.coefficients)?;
    let point = |at: &LatLong| {
        let direction = at.direction();
        let jet = series.jet(direction);
        SurfacePoint {
            at: *at,
            radius: jet.value,
            position: shape.centre + jet.value * direction,
            normal: (jet.value * direction - jet.gradient).normalize_or_zero(),
        }
    };
    Ok(places.par_iter().map(point).collect())
}

/// Asks for the memory of many points.
fn ask<T>(count: usize) -> Result<()> {
    let each = size_of::<T>() as f64;
    memory::ask_each(count, each, format_args!("{count} points"), "evaluate fewer at once")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sh::{Coefficients, Grid, Series, positions};

    fn lump(lmax: usize) -> Shape {
        let mut c = Coefficients::zeros(lmax);
        c.set(0, 0, 1.0, 0.0);
        for (l, m) in (1..=lmax).flat_map(|l| (0..=l).map(move |m| (l, m))) {
            let k = 0.2 / (l * l) as f64 / (l as f64).sqrt();
            c.set(l, m, k * ((3 * l + m) as f64).sin(), k * ((l + 5 * m) as f64).cos());
        }
        Shape { centre: DVec3::new(1.0, -2.0, 3.0), ..Shape::new(c) }
    }

    #[test]
    fn what_is_no_direction_is_refused() {
        for (latitude, longitude) in [
            (90.000_001, 0.0),
            (-91.0, 0.0),
            (f64::NAN, 0.0),
            (0.0, f64::INFINITY),
            (0.0, f64::NAN),
        ] {
            let message = LatLong::new(latitude, longitude).expect_err("refused").to_string();
            assert!(message.contains("degrees, not "), "{message}");
        }
        for (latitudes, longitudes) in [(0, 4), (1, 4), (3, 0)] {
            assert!(LatLong::grid(latitudes, longitudes).is_err());
        }
        assert!(matches!(LatLong::grid(usize::MAX, usize::MAX), Err(Error::Memory(_))));
    }

    #[test]
    fn grid_has_the_nodes_of_the_transform() {
        let (nodes, grid) = (LatLong::grid(7, 12).expect("small"), Grid::equispaced(6, 12));
        assert_eq!(nodes.len(), grid.len());
        for (i, node) in nodes.iter().enumerate() {
            assert!(node.direction().distance(grid.direction(i)) <= 1e-15, "{node:?}");
        }
        assert_eq!((nodes[0].direction(), nodes[83].direction()), (DVec3::Z, DVec3::NEG_Z));
        assert_eq!((nodes[13].latitude(), nodes[13].longitude()), (60.0, 30.0));
    }

    /// Radius and place are those of the series, one by one and by way of a grid; the normal is
    /// across both ways along the surface, whose place is a series too.
    #[test]
    fn points_and_normals_are_those_of_the_series() {
        for lmax in [6, 120] {
            let shape = lump(lmax);
            let series = Series::new(&shape.coefficients).expect("low degree");
            let [x, y, z] = positions(&shape.coefficients, shape.centre)
                .map(|c| Series::new(&c).expect("low degree"));
            let places = [(0.0, 0.0), (45.0, 405.0), (-30.0, -170.0), (90.0, 7.0), (-90.0, 0.0)];
            let places = places.map(|(a, b)| LatLong::new(a, b).expect("a direction"));
            for point in surface_points(&shape, &places).expect("low degree") {
                let w = point.at.direction();
                assert!((point.radius - series.value(w)).abs() <= 1e-11);
                let place = DVec3::new(x.value(w), y.value(w), z.value(w));
                assert!(point.position.distance(place) <= 1e-11);
                let along = w.any_orthonormal_vector();
                for t in [along, w.cross(along)] {
                    let step = |f: &Series| f.jet(w).gradient.dot(t);
                    let step = DVec3::new(step(&x), step(&y), step(&z));
                    assert!(point.normal.dot(step).abs() <= 1e-9, "{point:?}");
                }
                assert!(point.normal.dot(w) > 0.0 && (point.normal.length() - 1.0).abs() <= 1e-14);
            }
        }
    }
}
