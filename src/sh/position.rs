//! The points of a star-shaped surface as three series: x, y and z of r(omega) omega + centre are
//! exactly one degree higher than r.
//!
//! With c = A - iB and the recurrences of the basis (Condon-Shortley phase included)
//!
//! ```text
//! cos(theta) Q_l^m = [sqrt((l+1)^2 - m^2) Q_{l+1}^m + sqrt(l^2 - m^2) Q_{l-1}^m] / (2l+1)
//! sin(theta) Q_l^m
//!     = [sqrt((l-m)(l-m-1)) Q_{l-1}^{m+1} - sqrt((l+m+1)(l+m+2)) Q_{l+1}^{m+1}] / (2l+1)
//!     = [sqrt((l-m+1)(l-m+2)) Q_{l+1}^{m-1} - sqrt((l+m)(l+m-1)) Q_{l-1}^{m-1}] / (2l+1)
//! ```
//!
//! each product is a handful of terms a coefficient. Back: since x^2 + y^2 + z^2 = 1 on the unit
//! sphere, the sum of the three series, each times its own coordinate, is r + centre . omega; what
//! the set then differs from r omega + centre is its residual.

use std::f64::consts::{PI, SQRT_2};

use glam::DVec3;

use super::Coefficients;

/// Returns x, y and z of the surface r(omega) omega + `centre` as series of degree lmax + 1;
/// `radius` of degree lmax.
///
/// ```
/// use glam::DVec3;
/// use harmolux::sh::{Coefficients, positions};
///
/// let mut radius = Coefficients::zeros(0);
/// radius.set(0, 0, 2.0, 0.0); // a ball: z = 2 cos(theta)
/// let [_, _, z] = positions(&radius, DVec3::ZERO);
/// assert_eq!((z.lmax(), z.get(1, 0)), (1, (2.0, 0.0)));
/// ```
pub fn positions(radius: &Coefficients, centre: DVec3) -> [Coefficients; 3] {
    let mut set = [Axis::X, Axis::Y, Axis::Z].map(|axis| times(radius, axis));
    for (series, offset) in set.iter_mut().zip(centre.to_array()) {
        let (mean, _) = series.get(0, 0);
        series.set(0, 0, mean + offset, 0.0);
    }
    set
}

/// Holds what [`radius_of`] finds in a set of x, y and z.
#[derive(Debug, Clone, PartialEq)]
pub struct RadialPart {
    /// The radius, one degree lower than the set.
    pub radius: Coefficients,
    /// The centre it is counted from.
    pub centre: DVec3,
    /// The root mean square distance, over the sphere of parameters, between the set and the radial
    /// surface; 0 when it is one.
    pub residual: f64,
}

/// Finds radius and centre of a surface whose x, y and z are given as series of one degree, at
/// least 1; `None` for degree 0, which is a point, or for different degrees.
///
/// A set that is no radial surface has the nearest one of this construction as its answer, and a
/// residual above rounding.
pub fn radius_of(set: &[Coefficients; 3]) -> Option<RadialPart> {
    let lmax = set[0].lmax();
    if lmax == 0 || set.iter().any(|series| series.lmax() != lmax) {
        return None;
    }
    let products = [Axis::X, Axis::Y, Axis::Z].map(|axis| times(&set[axis as usize], axis));
    // r + centre . omega, and past degree lmax nothing but the residual.
    let along = sum(&products).truncated(lmax);
    let centre = centre(set, &along);
    let mut radius = along;
    let (z, _) = radius.get(1, 0);
    let (x, y) = radius.get(1, 1);
    // z = Q_1^0, x = -sqrt(2) cos(phi) Q_1^1, y = -sqrt(2) sin(phi) Q_1^1.
    radius.set(1, 0, z - centre.z, 0.0);
    radius.set(1, 1, x + SQRT_2 * centre.x, y + SQRT_2 * centre.y);
    let radius = radius.truncated(lmax - 1);
    let apart = positions(&radius, centre);
    let energy: f64 = set.iter().zip(&apart).map(|(a, b)| difference(a, b).energy()).sum();
    Some(RadialPart { radius, centre, residual: (energy / (4.0 * PI)).sqrt() })
}

/// Finds the centre: the mean of the set less (r + centre . omega) omega is two thirds of it.
fn centre(set: &[Coefficients; 3], along: &Coefficients) -> DVec3 {
    let radial = positions(along, DVec3::ZERO);
    let mean = |i: usize| 1.5 * (set[i].mean() - radial[i].mean());
    DVec3::new(mean(0), mean(1), mean(2))
}

fn sum(terms: &[Coefficients; 3]) -> Coefficients {
    let mut total = Coefficients::zeros(terms[0].lmax());
    for term in terms {
        add(&mut total, term, 1.0);
    }
    total
}

/// Subtracts; both of one degree.
fn difference(a: &Coefficients, b: &Coefficients) -> Coefficients {
    let mut d = a.clone();
    add(&mut d, b, -1.0);
    d
}

fn add(total: &mut Coefficients, term: &Coefficients, k: f64) {
    for l in 0..=total.lmax() {
        for m in 0..=l {
            let ((a, b), (p, q)) = (total.get(l, m), term.get(l, m));
            total.set(l, m, a + k * p, b + k * q);
        }
    }
}

/// A coordinate of the unit sphere.
#[derive(Debug, Clone, Copy)]
enum Axis {
    X,
    Y,
    Z,
}

/// Multiplies a series by a coordinate of the unit vector: one degree more.
fn times(f: &Coefficients, axis: Axis) -> Coefficients {
    let mut product = Coefficients::zeros(f.lmax() + 1);
    for l in 0..=f.lmax() {
        for m in 0..=l {
            let c = f.get(l, m);
            match axis {
                Axis::Z => times_z(&mut product, (l, m), c),
                Axis::X | Axis::Y => times_xy(&mut product, (l, m), c, matches!(axis, Axis::Y)),
            }
        }
    }
    product
}

fn times_z(product: &mut Coefficients, (l, m): (usize, usize), (a, b): (f64, f64)) {
    let n = (2 * l + 1) as f64;
    let up = (((l + 1) * (l + 1) - m * m) as f64).sqrt() / n;
    accumulate(product, l + 1, m, (up * a, up * b));
    if l > m {
        let down = ((l * l - m * m) as f64).sqrt() / n;
        accumulate(product, l - 1, m, (down * a, down * b));
    }
}

/// Adds one term times x = sin(theta) cos(phi), or times y = sin(theta) sin(phi): orders m + 1 and
/// m - 1.
fn times_xy(product: &mut Coefficients, (l, m): (usize, usize), (a, b): (f64, f64), y: bool) {
    let n = (2 * l + 1) as f64;
    let root = |p: usize, q: usize| ((p * q) as f64).sqrt() / n;
    // At m = 0 the order -1 is the conjugate of the order 1: both halves come there.
    let half = if m == 0 { 1.0 } else { 0.5 };
    let raised = if y { (-half * b, half * a) } else { (half * a, half * b) };
    let scaled = |k: f64, (a, b): (f64, f64)| (k * a, k * b);
    accumulate(product, l + 1, m + 1, scaled(-root(l + m + 1, l + m + 2), raised));
    if l > m + 1 {
        accumulate(product, l - 1, m + 1, scaled(root(l - m, l - m - 1), raised));
    }
    if m > 0 {
        let lowered = if y { (half * b, -half * a) } else { (half * a, half * b) };
        accumulate(product, l + 1, m - 1, scaled(root(l - m + 1, l - m + 2), lowered));
        accumulate(product, l - 1, m - 1, scaled(-root(l + m, l + m - 1), lowered));
    }
}

fn accumulate(product: &mut Coefficients, l: usize, m: usize, (a, b): (f64, f64)) {
    let (p, q) = product.get(l, m);
    product.set(l, m, p + a, q + b);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::{Randomness, Stream, sampling};
    use crate::sh::Series;

    fn bumpy(lmax: usize) -> Coefficients {
        let mut c = Coefficients::zeros(lmax);
        for l in 0..=lmax {
            for m in 0..=l {
                let k = 1.0 / ((l + 1) * (l + 1)) as f64;
                c.set(l, m, k * ((3 * l + m) as f64).cos(), k * ((l + 5 * m) as f64).sin());
            }
        }
        c
    }

    fn largest(c: &Coefficients) -> f64 {
        c.cosines().iter().chain(c.sines()).fold(0.0, |max, v| max.max(v.abs()))
    }

    #[test]
    fn degree_zero_is_a_ball_and_a_point_is_refused() {
        let ball = positions(&Coefficients::zeros(0), DVec3::ONE);
        let part = radius_of(&ball).expect("a surface");
        assert_eq!((part.centre, part.radius.mean()), (DVec3::ONE, 0.0));
        assert!(radius_of(&[(); 3].map(|()| Coefficients::zeros(0))).is_none());
        let unequal = [1, 2, 2].map(Coefficients::zeros);
        assert!(radius_of(&unequal).is_none());
    }

    #[test]
    fn points_lie_where_the_radius_says() {
        let radius = bumpy(9);
        let centre = DVec3::new(0.3, -0.2, 0.1);
        let f = Series::new(&radius).expect("evaluable");
        let set = positions(&radius, centre).map(|c| Series::new(&c).expect("evaluable"));
        for i in 0..200 {
            let u = Stream::new(Randomness::Sobol, 1, i).next_2d();
            let omega = sampling::uniform_sphere(u);
            let expected = centre + f.value(omega) * omega;
            let found = DVec3::from_array([0, 1, 2].map(|i| set[i].value(omega)));
            // A hundred terms of size 1, each with a handful of roundings.
            assert!((found - expected).length() <= 1e-14, "{found} {expected}");
        }
    }

    #[test]
    fn radius_and_centre_come_back() {
        for lmax in [0, 1, 2, 9, 64] {
            let radius = bumpy(lmax);
            let centre = DVec3::new(0.3, -0.2, 0.1);
            let part = radius_of(&positions(&radius, centre)).expect("a surface");
            assert_eq!(part.radius.lmax(), lmax);
            assert!(part.centre.distance(centre) <= 1e-15, "{}", part.centre);
            // A few roundings of numbers of size 1, 65^2 of them in the residual.
            assert!(part.residual <= 1e-15, "{}", part.residual);
            assert!(largest(&difference(&part.radius, &radius)) <= 2e-15);
        }
    }

    #[test]
    fn ellipsoid_by_its_axes_is_no_radial_surface() {
        // (a x, b y, c z) has its points elsewhere than in the direction of its parameters.
        let [x, y, z] = positions(&bumpy(0), DVec3::ZERO);
        let part = radius_of(&[x.scaled(2.0), y, z]).expect("a surface");
        // By hand: the sum of coordinate times series is 1 + x^2, cut to its mean 4/3; (2x, y, z) -
        // 4/3 omega has the mean square 2/9.
        assert!((part.residual - (2.0_f64 / 9.0).sqrt()).abs() <= 1e-15, "{}", part.residual);
        assert!((part.radius.mean() - 4.0 / 3.0).abs() <= 1e-15);
    }
}
