//! Integrals over the body r <= f(omega): volume, centroid and inertia, exact from its
//! coefficients, and area to a stated error.
//!
//! V = 1/3 int f^3, centroid int f^4 omega / (4V), inertia about the origin 1/5 int f^5 (delta_ij -
//! omega_i omega_j): polynomials of degrees 3 lmax, 4 lmax + 1 and 5 lmax + 2, for which
//! Gauss-Legendre grids are exact. The area, int f sqrt(f^2 + |grad_S f|^2), is not a polynomial;
//! its integrand is smooth, so that the error of finer and finer grids falls geometrically.

use std::f64::consts::PI;

use glam::{DMat3, DVec2, DVec3};
use nalgebra::{Matrix3, SymmetricEigen};
use rayon::prelude::*;

use super::{Coefficients, Grid, rotation_derivatives, synthesis};
use crate::{Error, Result};

/// Holds the integrals over a solid body of unit density (1 kg/m3), for radii in metres.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Solid {
    /// The volume, m3.
    pub volume: f64,
    /// The centre of mass, m, from the expansion centre.
    pub centroid: DVec3,
    /// The inertia tensor about the centroid, m5: int (|x|^2 delta_ij - x_i x_j) dV.
    pub inertia: DMat3,
    /// The same about the expansion centre.
    pub inertia_about_origin: DMat3,
}

/// Holds the principal axes of inertia.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PrincipalAxes {
    /// The moments of inertia, m5, ascending: the body is longest along the first axis.
    pub moments: [f64; 3],
    /// The unit axes as columns, in the order of the moments; right-handed, their signs arbitrary.
    pub axes: DMat3,
}

/// Holds an area and how far it can be off.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Area {
    /// The area, m2.
    pub value: f64,
    /// What the last refinement of the grid changed, m2: an upper estimate of the error, since each
    /// refinement leaves a small fraction of the one before.
    pub error: f64,
}

/// Returns the volume of the body, V = 1/3 int f^3 d omega, by a Gauss-Legendre grid that is exact
/// for degree 3 lmax.
///
/// # Errors
/// As [`synthesis`]: a degree too high to evaluate.
pub fn volume(f: &Coefficients) -> Result<f64> {
    let grid = exact_grid(3 * f.lmax());
    let values = synthesis(f, &grid)?;
    Ok(values.iter().enumerate().map(|(i, r)| grid.solid_angle(i) * r.powi(3)).sum::<f64>() / 3.0)
}

/// Makes the smallest grid that integrates polynomials of this degree exactly.
pub(super) fn exact_grid(degree: usize) -> Grid {
    Grid::gauss_legendre(degree / 2 + 1, degree + 1)
}

/// Rejects radii that are not positive: then the body is not what the integrals describe.
pub(super) fn require_positive(radii: &[f64], grid: &Grid) -> Result<()> {
    let worst = radii.iter().enumerate().min_by(|a, b| a.1.total_cmp(b.1));
    match worst {
        Some((i, r)) if r.is_nan() || *r <= 0.0 => Err(Error::Geometry(format!(
            "the radius must be positive in every direction, but is {r:.3e} at {}; choose another \
             centre, or lower the degree or filter the series if it rings",
            angles(grid.direction(i))
        ))),
        _ => Ok(()),
    }
}

/// Writes a direction as its angles in degrees.
pub(super) fn angles(w: DVec3) -> String {
    let theta = w.x.hypot(w.y).atan2(w.z).to_degrees();
    let phi = w.y.atan2(w.x).to_degrees();
    format!("theta = {theta:.1}, phi = {phi:.1} degrees")
}

impl Solid {
    /// Integrates over the body, exactly but for rounding.
    ///
    /// ```
    /// use harmolux::sh::{Coefficients, Solid};
    ///
    /// let mut ball = Coefficients::zeros(0);
    /// ball.set(0, 0, 2.0, 0.0);
    /// let solid = Solid::of(&ball)?;
    /// assert!((solid.volume - 32.0 * std::f64::consts::PI / 3.0).abs() <= 1e-13);
    /// assert!((solid.inertia.x_axis.x - 0.4 * solid.volume * 4.0).abs() <= 1e-12); // 2/5 m r^2
    /// # Ok::<(), harmolux::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Error::Geometry`] when a radius is not positive; [`Error::Parameter`] for a degree too
    /// high to evaluate.
    pub fn of(f: &Coefficients) -> Result<Self> {
        let grid = exact_grid(5 * f.lmax() + 2);
        let radii = synthesis(f, &grid)?;
        require_positive(&radii, &grid)?;
        let mut volume = 0.0;
        let mut moment = DVec3::ZERO;
        let mut second = DMat3::ZERO;
        for (i, &r) in radii.iter().enumerate() {
            let (w, cube) = (grid.direction(i), grid.solid_angle(i) * r.powi(3));
            volume += cube / 3.0;
            moment += (cube * r / 4.0) * w;
            second += (cube * r * r / 5.0) * outer(w);
        }
        Ok(Self::of_moments(volume, moment, second))
    }

    /// Makes it of the integrals of 1, x and x x^T over the body.
    pub(crate) fn of_moments(volume: f64, moment: DVec3, second: DMat3) -> Self {
        let centroid = moment / volume;
        let inertia_about_origin = about_point(second);
        let shift = about_point(volume * outer(centroid));
        Self { volume, centroid, inertia: inertia_about_origin - shift, inertia_about_origin }
    }

    /// Finds the principal axes of inertia about the centroid; the largest component of the first
    /// two is positive.
    pub fn principal_axes(&self) -> PrincipalAxes {
        let columns = self.inertia.to_cols_array();
        let eigen = SymmetricEigen::new(Matrix3::from_column_slice(&columns));
        let mut order = [0, 1, 2];
        order.sort_by(|&i, &j| eigen.eigenvalues[i].total_cmp(&eigen.eigenvalues[j]));
        let [x, y, _] = order.map(|i| {
            let v = eigen.eigenvectors.column(i);
            let axis = DVec3::new(v[0], v[1], v[2]).normalize_or_zero();
            axis * axis[axis.abs().max_position()].signum()
        });
        PrincipalAxes {
            moments: order.map(|i| eigen.eigenvalues[i]),
            axes: DMat3::from_cols(x, y, x.cross(y)),
        }
    }
}

/// Returns x x^T.
pub(crate) fn outer(x: DVec3) -> DMat3 {
    DMat3::from_cols(x.x * x, x.y * x, x.z * x)
}

/// Turns second moments S into the inertia tensor, trace(S) - S.
fn about_point(second: DMat3) -> DMat3 {
    let trace = second.x_axis.x + second.y_axis.y + second.z_axis.z;
    DMat3::from_diagonal(DVec3::splat(trace)) - second
}

/// Samples of the finest grid that the area is taken on: more would not fit memory as a matter of
/// course.
const MOST_SAMPLES: usize = 1 << 24;

/// Relative change between two grids at which the area counts as settled.
const SETTLED: f64 = 1e-12;

/// Integrates the area of the body's surface on finer and finer grids until it settles to 1e-12, or
/// up to 2^24 samples.
///
/// # Errors
/// [`Error::Geometry`] when a radius is not positive; [`Error::Parameter`] for a degree too high to
/// evaluate.
pub fn area(f: &Coefficients) -> Result<Area> {
    Ok(over_surface(f, SETTLED, |_| 0.0)?.0)
}

/// Returns the area, refined until it changes by less than `settled` of itself, and of the same
/// grid the integral over the surface of a function of the place from the expansion centre.
///
/// # Errors
/// As [`area`].
pub(crate) fn over_surface(
    f: &Coefficients,
    settled: f64,
    integrand: impl Fn(DVec3) -> f64 + Sync,
) -> Result<(Area, f64)> {
    let slopes = rotation_derivatives(f);
    let mut rings = f.lmax() + 9;
    let mut last = integrals_on(f, &slopes, rings, &integrand)?[0];
    loop {
        rings *= 2;
        let [value, integral] = integrals_on(f, &slopes, rings, &integrand)?;
        let rounding = 64.0 * f64::EPSILON * value;
        let area = Area { value, error: (value - last).abs().max(rounding) };
        if area.error <= settled * value || 8 * rings * rings > MOST_SAMPLES {
            return Ok((area, integral));
        }
        last = value;
    }
}

/// Integrates 1 and a function over the surface, on one grid.
fn integrals_on(
    f: &Coefficients,
    slopes: &[Coefficients; 3],
    rings: usize,
    integrand: &(impl Fn(DVec3) -> f64 + Sync),
) -> Result<[f64; 2]> {
    let grid = Grid::gauss_legendre(rings, 2 * rings);
    let radii = synthesis(f, &grid)?;
    require_positive(&radii, &grid)?;
    let mut squares = vec![0.0; grid.len()];
    for slope in slopes {
        // |omega x grad_S f| is |grad_S f|.
        for (square, s) in squares.iter_mut().zip(synthesis(slope, &grid)?) {
            *square += s * s;
        }
    }
    let around = grid.azimuths();
    let azimuth = |j: usize| DVec2::from_angle(2.0 * PI * j as f64 / around as f64);
    let equator: Vec<DVec2> = (0..around).map(azimuth).collect();
    let ring = |k: usize| {
        let (z, s) = grid.rings()[k];
        let samples = radii[k * around..].iter().zip(&squares[k * around..]).zip(&equator);
        let mut sums = [0.0; 2];
        for ((r, square), w) in samples {
            let area = r * (r * r + square).sqrt();
            sums[0] += area;
            sums[1] += area * integrand(r * (s * w).extend(z));
        }
        sums.map(|sum| grid.solid_angle(k * around) * sum)
    };
    // Added up in their order: the same on any number of threads.
    let sums: Vec<[f64; 2]> = (0..rings).into_par_iter().map(ring).collect();
    Ok(sums.iter().fold([0.0; 2], |[a, b], [c, d]| [a + c, b + d]))
}

#[cfg(test)]
mod tests {
    use approx::assert_relative_eq;

    use super::*;
    use crate::sh::analysis;

    /// Expands a radius on a grid fine enough that aliasing is rounding.
    fn expanded(lmax: usize, radius: impl Fn(DVec3) -> f64) -> Coefficients {
        let grid = Grid::gauss_legendre(200, 400);
        let values: Vec<f64> = (0..grid.len()).map(|i| radius(grid.direction(i))).collect();
        analysis(&values, &grid, lmax).expect("fine enough")
    }

    /// A sphere of radius 1 about c, |c| < 1, seen from the origin: |r omega - c| = 1.
    fn offset_sphere(c: DVec3) -> impl Fn(DVec3) -> f64 {
        move |w| w.dot(c) + (w.dot(c).powi(2) + 1.0 - c.length_squared()).sqrt()
    }

    fn ellipsoid(axes: DVec3) -> impl Fn(DVec3) -> f64 {
        move |w| (w / axes).length().recip()
    }

    /// The truncation error of a radius: RMS and largest over the sphere.
    fn truncation(c: &Coefficients, radius: impl Fn(DVec3) -> f64) -> (f64, f64) {
        let grid = Grid::gauss_legendre(60, 120);
        let values = synthesis(c, &grid).expect("small degree");
        let errors = (0..grid.len()).map(|i| (i, (values[i] - radius(grid.direction(i))).abs()));
        let (mut square, mut worst) = (0.0, 0.0_f64);
        for (i, e) in errors {
            square += grid.solid_angle(i) * e * e;
            worst = worst.max(e);
        }
        ((square / (4.0 * PI)).sqrt(), worst)
    }

    fn diagonal(m: DMat3) -> [f64; 3] {
        [m.x_axis.x, m.y_axis.y, m.z_axis.z]
    }

    #[test]
    fn sphere_and_dipole_have_their_volumes() {
        let mut c = Coefficients::zeros(1);
        c.set(0, 0, 2.0, 0.0);
        assert_relative_eq!(volume(&c).expect("degree 1"), 32.0 * PI / 3.0, max_relative = 1e-14);
        c.set(1, 0, 0.5, 0.0); // int (2 + mu/2)^3 = 2 pi (2 * 8 + 3 * 2 * 1/4 * 2/3)
        assert_relative_eq!(
            volume(&c).expect("degree 1"),
            2.0 * PI * 17.0 / 3.0,
            max_relative = 1e-14
        );
    }

    #[test]
    fn radii_that_are_not_positive_are_refused() {
        let mut c = Coefficients::zeros(1);
        assert!(matches!(Solid::of(&c), Err(Error::Geometry(_))));
        c.set(0, 0, 1.0, 0.0);
        c.set(1, 0, 1.5, 0.0);
        let error = Solid::of(&c).expect_err("negative below").to_string();
        assert!(error.contains("positive") && error.contains("theta = 1"), "{error}");
        assert!(matches!(area(&c), Err(Error::Geometry(_))));
    }

    #[test]
    fn sphere_has_its_integrals() {
        let mut c = Coefficients::zeros(4);
        c.set(0, 0, 2.0, 0.0);
        let solid = Solid::of(&c).expect("valid");
        assert_relative_eq!(solid.volume, 32.0 * PI / 3.0, max_relative = 1e-14);
        assert!(solid.centroid.length() <= 1e-15);
        for moment in solid.principal_axes().moments {
            assert_relative_eq!(moment, 0.4 * solid.volume * 4.0, max_relative = 1e-13);
        }
        let area = area(&c).expect("valid");
        assert!((area.value - 16.0 * PI).abs() <= area.error && area.error <= 1e-12);
    }

    /// To the truncation error delta = f - f_l: |dV| = |int f^2 delta + ...| <= 4 pi R^2
    /// rms(delta), with R above both radii, by Cauchy and Schwarz; |d int f^4 omega / 4| <= 4 pi
    /// R^3 rms, |d int f^5 ... / 5| <= 4 pi R^4 rms in the same way.
    #[test]
    fn offset_sphere_is_met_to_the_truncation_error() {
        let centre = DVec3::new(0.2, -0.3, 0.1);
        let mut last = f64::INFINITY;
        for lmax in [4, 8, 16, 32] {
            let c = expanded(lmax, offset_sphere(centre));
            let (rms, worst) = truncation(&c, offset_sphere(centre));
            assert!(rms <= last / 10.0 || rms <= 1e-14, "degree {lmax}: {rms:e}");
            last = rms;
            let (solid, volume) = (Solid::of(&c).expect("valid"), 4.0 * PI / 3.0);
            let reach = 1.0 + centre.length() + worst;
            let allowed = 4.0 * PI * rms * reach.powi(2) + 1e-13;
            assert!((solid.volume - volume).abs() <= allowed, "degree {lmax}");
            let first = (solid.volume * solid.centroid - volume * centre).length();
            assert!(first <= allowed * reach, "degree {lmax}: {first:e}");
            let own = DMat3::from_diagonal(DVec3::splat(0.4 * volume));
            let exact = own + about_point(volume * outer(centre));
            let difference = (solid.inertia_about_origin - exact).to_cols_array();
            assert!(difference.iter().all(|d| d.abs() <= allowed * reach.powi(2)), "{lmax}");
            if lmax == 32 {
                let difference = (solid.inertia - own).to_cols_array();
                assert!(difference.iter().all(|d| d.abs() <= 1e-12));
                let area = area(&c).expect("valid");
                assert!((area.value - 4.0 * PI).abs() <= 1e-11, "{area:?}");
            }
        }
    }

    #[test]
    fn ellipsoid_is_met_to_the_truncation_error() {
        let axes = DVec3::new(1.2, 1.0, 0.8);
        let volume = 4.0 * PI / 3.0 * axes.element_product();
        let square = axes * axes;
        let exact = DVec3::new(square.y + square.z, square.x + square.z, square.x + square.y)
            * (volume / 5.0);
        for lmax in [4, 8, 16, 32] {
            let c = expanded(lmax, ellipsoid(axes));
            let (rms, worst) = truncation(&c, ellipsoid(axes));
            let solid = Solid::of(&c).expect("valid");
            let reach = 1.2 + worst;
            let allowed = 4.0 * PI * rms * reach.powi(2) + 1e-13;
            assert!((solid.volume - volume).abs() <= allowed, "degree {lmax}");
            assert!(solid.centroid.length() <= 1e-14);
            let found = diagonal(solid.inertia);
            for (f, e) in found.iter().zip(exact.to_array()) {
                assert!((f - e).abs() <= allowed * reach.powi(2), "degree {lmax}: {f} {e}");
            }
        }
    }

    #[test]
    fn area_of_an_ellipsoid_is_that_of_elliptic_integrals() {
        let c = expanded(64, ellipsoid(DVec3::new(1.2, 1.0, 0.8)));
        let area = area(&c).expect("valid");
        // By incomplete elliptic integrals in 30 digits (mpmath).
        let exact = 12.501_094_893_352_27;
        assert!((area.value - exact).abs() <= 1e-10 * exact, "{area:?}");
        assert!(area.error <= 1e-11);
    }

    #[test]
    fn principal_axes_of_a_turned_ellipsoid_are_its_axes() {
        let turn = DMat3::from_axis_angle(DVec3::new(1.0, 2.0, 3.0).normalize(), 0.7);
        let axes = DVec3::new(0.8, 1.2, 1.0);
        let c = expanded(32, |w| ellipsoid(axes)(turn.transpose() * w));
        let principal = Solid::of(&c).expect("valid").principal_axes();
        assert!((principal.axes.determinant() - 1.0).abs() <= 1e-14);
        for (found, i) in
            [(principal.axes.x_axis, 1), (principal.axes.y_axis, 2), (principal.axes.z_axis, 0)]
        {
            assert!((found.dot(turn.col(i)).abs() - 1.0).abs() <= 1e-12);
        }
        assert!(principal.moments.is_sorted());
    }
}
