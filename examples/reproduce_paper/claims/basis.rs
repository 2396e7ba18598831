//! Equations 14, 17 and 24 to 27: norms of the basis, and derivatives of the Schmidt polynomials.

use glam::DVec3;
use harmolux::Result;
use harmolux::math::quadrature::Rule;
use harmolux::sh::{Coefficients, Series};

use super::{Claim, Equation, Run, largest};

const COMMAND: &str = "cargo run --release --example reproduce_paper -- -o out --only basis";
/// The highest degree that derivatives are checked at.
const LMAX: usize = 32;
/// The highest degree that norms are checked at: factorials to 16! are exact.
const LOW: usize = 8;
/// Zenith angles that derivatives are checked at.
const ANGLES: u32 = 41;
/// What the recurrence of degree 32 loses.
const ROUNDING: f64 = 1e-11;

pub(super) fn claims(_: &Run) -> Result<Vec<Claim>> {
    let norms = norms()?;
    let [with, without] = [Table::new(true)?, Table::new(false)?];
    Ok(vec![
        equation_14(&norms),
        equation_17(&norms),
        equation_24(with.derivative_24(), without.derivative_24()),
        equation_26(with.derivative_26(), without.derivative_26()),
        equation_27(with.derivative_27(), without.derivative_27()),
    ])
}

/// Holds degree, order and the squared norm of cos(m phi) P_k^m by quadrature.
struct Norm {
    k: usize,
    m: usize,
    squared: f64,
    /// The largest product with another degree of this order, relative to the norm.
    product: f64,
}

fn norms() -> Result<Vec<Norm>> {
    let rule = Rule::gauss_legendre(2 * LOW);
    let pairs = (0..=LOW).flat_map(|k| (0..=k).map(move |m| (k, m)));
    let norm = |(k, m): (usize, usize)| {
        let own = legendre(k, m)?;
        // The azimuth gives pi, or 2 pi at m = 0.
        let azimuth = std::f64::consts::PI * if m == 0 { 2.0 } else { 1.0 };
        let squared = azimuth * rule.integrate(|mu| own(mu).powi(2));
        let mut product = 0.0_f64;
        for other in (m..=LOW).filter(|other| *other != k) {
            let other = legendre(other, m)?;
            let integral = azimuth * rule.integrate(|mu| own(mu) * other(mu));
            let size = azimuth * rule.integrate(|mu| other(mu).powi(2));
            product = product.max(integral.abs() / (squared * size).sqrt());
        }
        Ok(Norm { k, m, squared, product })
    };
    pairs.map(norm).collect()
}

/// Returns P_k^m(mu) from the Schmidt polynomial of the library, by (18).
fn legendre(k: usize, m: usize) -> Result<impl Fn(f64) -> f64> {
    let schmidt = series(k, m)?;
    let factor = (factorial(k + m) / factorial(k - m)).sqrt();
    Ok(move |mu: f64| factor * schmidt.value(DVec3::new((1.0 - mu * mu).sqrt(), 0.0, mu)))
}

fn factorial(n: usize) -> f64 {
    (1..=n).map(|i| i as f64).product()
}

/// Returns the series cos(m phi) Q_k^m.
fn series(k: usize, m: usize) -> Result<Series> {
    let mut one = Coefficients::zeros(k);
    one.set(k, m, 1.0, 0.0);
    Series::new(&one)
}

/// Returns the squared norm of (17), with the n of its denominator.
fn squared_norm(k: usize, m: usize, n: usize) -> f64 {
    let epsilon = if m == 0 { 2.0 } else { 1.0 };
    let numerator = std::f64::consts::TAU * epsilon * factorial(k + m);
    numerator / ((2 * n + 1) as f64 * factorial(k - m))
}

fn equation_14(norms: &[Norm]) -> Claim {
    let product = largest(norms.iter().map(|n| n.product));
    let own = |n: &Norm| (n.squared / squared_norm(n.k, n.m, n.k) - 1.0).abs();
    Claim::from(Equation {
        title: "Equation 14: orthogonality",
        printed_words: "The integral of Y_k^m Y_k'^m' over the sphere = delta_kk' delta_mm'",
        correction: Some("times the squared norm of (17): the functions are not normalised."),
        printed: largest(norms.iter().map(|n| (n.squared - 1.0).abs())),
        corrected: Some(largest(norms.iter().map(own)).max(product)),
        tolerance: ROUNDING,
        check: format!(
            "cos(m phi) P_k^m to degree {LOW} by quadrature: the largest difference of the squared \
             norm from 1, and from (17) relative to it. Products of different degrees are 0 to \
             {product:.0e}."
        ),
        command: COMMAND,
    })
}

fn equation_17(norms: &[Norm]) -> Claim {
    let off = |n: &Norm, index: usize| (squared_norm(n.k, n.m, index) / n.squared - 1.0).abs();
    Claim::from(Equation {
        title: "Equation 17: the norm",
        printed_words: "||Y_k^m||^2 = 2 pi eps_m / (2n + 1) (k + m)! / (k - m)!, eps_0 = 2, else 1",
        correction: Some("2n + 1 is 2k + 1; no n is defined."),
        printed: largest(norms.iter().map(|n| off(n, n.m))),
        corrected: Some(largest(norms.iter().map(|n| off(n, n.k)))),
        tolerance: ROUNDING,
        check: format!(
            "Against quadrature to degree {LOW}. The printed form is read with n = m, the only \
             other index there is."
        ),
        command: COMMAND,
    })
}

const PHASE: &str = "P_k^m, and with it Q_k^m, carries the Condon-Shortley phase (-1)^m, which the \
     paper does not state.";

fn check(what: &str) -> String {
    format!(
        "{what} to degree {LMAX} at {ANGLES} zenith angles, against the gradient of the library's \
         series; relative to the largest derivative. Printed: without the phase."
    )
}

fn equation_24(with: f64, without: f64) -> Claim {
    Claim::from(Equation {
        title: "Equations 24 and 25: the derivative by neighbouring orders",
        printed_words: "sqrt(1 - mu^2) dP_lk^m / dmu = -i/2 [sqrt((k + m)(k - m + 1)) P_lk^(m-1) + \
                        sqrt((k - m)(k + m + 1)) P_lk^(m+1)], P_0k^m = i^(-m) Q_k^m",
        correction: Some(PHASE),
        printed: without,
        corrected: Some(with),
        tolerance: ROUNDING,
        check: check("Both sides in complex numbers for l = 0, orders 1 to k,"),
        command: COMMAND,
    })
}

fn equation_26(with: f64, without: f64) -> Claim {
    Claim::from(Equation {
        title: "Equation 26: the derivative of a Schmidt polynomial",
        printed_words: "dQ_k^m / dtheta = 1/2 [sqrt((k - m)(k + m + 1)) Q_k^(m+1) - sqrt((k + m)(k \
                        - m + 1)) Q_k^(m-1)]",
        correction: Some(PHASE),
        printed: without,
        corrected: Some(with),
        tolerance: ROUNDING,
        check: check("Orders 1 to k"),
        command: COMMAND,
    })
}

fn equation_27(with: f64, without: f64) -> Claim {
    Claim::from(Equation {
        title: "Equation 27: the derivative at order 0",
        printed_words: "dQ_k^0 / dtheta = sqrt(k (k + 1)) Q_k^1",
        correction: Some(PHASE),
        printed: without,
        corrected: Some(with),
        tolerance: ROUNDING,
        check: check("Order 0"),
        command: COMMAND,
    })
}

/// Holds Q_k^m and dQ_k^m / dtheta at the angles, at place k (k + 1) / 2 + m.
struct Table {
    values: Vec<Vec<f64>>,
    slopes: Vec<Vec<f64>>,
}

impl Table {
    /// Tabulates with the phase of the library, or with (-1)^m taken out.
    fn new(phase: bool) -> Result<Self> {
        let angles =
            (1..=ANGLES).map(|i| std::f64::consts::PI * f64::from(i) / f64::from(ANGLES + 1));
        let (mut values, mut slopes) = (Vec::new(), Vec::new());
        for (k, m) in (0..=LMAX).flat_map(|k| (0..=k).map(move |m| (k, m))) {
            let sign = if phase || m % 2 == 0 { 1.0 } else { -1.0 };
            let series = series(k, m)?;
            let jets: Vec<_> = angles
                .clone()
                .map(|theta| {
                    let (sin, cos) = theta.sin_cos();
                    let jet = series.jet(DVec3::new(sin, 0.0, cos));
                    (sign * jet.value, sign * jet.gradient.dot(DVec3::new(cos, 0.0, -sin)))
                })
                .collect();
            values.push(jets.iter().map(|jet| jet.0).collect());
            slopes.push(jets.iter().map(|jet| jet.1).collect());
        }
        Ok(Self { values, slopes })
    }

    fn value(&self, k: usize, m: usize, angle: usize) -> f64 {
        if m > k { 0.0 } else { self.values[k * (k + 1) / 2 + m][angle] }
    }

    /// Returns by how much `right` differs from the slopes of some orders, relative to the largest
    /// slope.
    fn off(&self, orders: fn(&usize) -> bool, right: impl Fn(usize, usize, usize) -> f64) -> f64 {
        let size = largest(self.slopes.iter().flatten().map(|s| s.abs()));
        let all = (0..=LMAX).flat_map(|k| (0..=k).map(move |m| (k, m)));
        let all = all.filter(|(_, m)| orders(m));
        let differences = all.flat_map(|(k, m)| {
            let slopes = self.slopes[k * (k + 1) / 2 + m].iter().enumerate();
            slopes.map(move |(angle, slope)| (k, m, angle, *slope))
        });
        largest(differences.map(|(k, m, angle, slope)| (right(k, m, angle) - slope).abs() / size))
    }

    fn derivative_26(&self) -> f64 {
        self.off(
            |m| *m > 0,
            |k, m, angle| {
                let [down, up] = roots(k, m);
                0.5 * (up * self.value(k, m + 1, angle) - down * self.value(k, m - 1, angle))
            },
        )
    }

    fn derivative_27(&self) -> f64 {
        self.off(|m| *m == 0, |k, _, angle| ((k * (k + 1)) as f64).sqrt() * self.value(k, 1, angle))
    }

    /// Evaluates the right side of (24) in complex numbers, and turns it by -i^m into the slope.
    fn derivative_24(&self) -> f64 {
        self.off(
            |m| *m > 0,
            |k, m, angle| {
                let [down, up] = roots(k, m);
                let m = m as i32;
                let below = scaled(i_to(1 - m), down * self.value(k, (m - 1) as usize, angle));
                let above = scaled(i_to(-m - 1), up * self.value(k, (m + 1) as usize, angle));
                let sum = [below[0] + above[0], below[1] + above[1]];
                let right = product(scaled(i_to(-1), 0.5), sum);
                let slope = product(scaled(i_to(m), -1.0), right);
                slope[0] + slope[1]
            },
        )
    }
}

/// Returns sqrt((k + m)(k - m + 1)) and sqrt((k - m)(k + m + 1)).
fn roots(k: usize, m: usize) -> [f64; 2] {
    [((k + m) * (k + 1 - m)) as f64, ((k - m) * (k + m + 1)) as f64].map(f64::sqrt)
}

/// Returns i^n as real and imaginary part.
fn i_to(n: i32) -> [f64; 2] {
    match n.rem_euclid(4) {
        0 => [1.0, 0.0],
        1 => [0.0, 1.0],
        2 => [-1.0, 0.0],
        _ => [0.0, -1.0],
    }
}

fn scaled([re, im]: [f64; 2], k: f64) -> [f64; 2] {
    [k * re, k * im]
}

fn product([a, b]: [f64; 2], [c, d]: [f64; 2]) -> [f64; 2] {
    [a * c - b * d, a * d + b * c]
}
