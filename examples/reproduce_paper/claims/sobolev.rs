//! Equations 6 and 7: the exact solution of Sobolev's problem, against the solution of its integral
//! equation between large discs, which knows no Hankel transform.

use harmolux::Result;
use harmolux::exact::{Plane, SobolevDiscs, SobolevProblem};
use harmolux::math::quadrature::Rule;
use pxfm::{f_j0, f_k1};

use super::{Claim, Equation, Run, largest};

const RADII: [f64; 5] = [0.0, 0.5, 1.0, 2.0, 3.0];
/// The radius of the discs, in gaps, that stand for planes.
const LARGE: f64 = 50.0;
/// What is missing beyond that radius falls as its third power.
const MISSING: f64 = 1e-5;
/// Where the integrals are cut: all of them fall as e^-k at least.
const CUT: f64 = 45.0;

pub(super) fn claims(_: &Run) -> Result<Vec<Claim>> {
    let a = SobolevProblem::default();
    let b = SobolevProblem { reflectance: [0.8, 0.3], source_height: 0.7, ..a };
    let problems = [a, b];
    let discs = problems.map(|p| p.discs(LARGE));
    let discs = discs.into_iter().collect::<Result<Vec<SobolevDiscs>>>()?;
    let (mut convolved, mut printed, mut corrected) = (Vec::new(), Vec::new(), Vec::new());
    for (problem, discs) in problems.iter().zip(&discs) {
        for plane in [Plane::Lower, Plane::Upper] {
            for r in RADII {
                let truth = discs.illuminance(plane, r)?;
                let off = |value: f64| (value / truth - 1.0).abs();
                let exact = problem.illuminance(plane, r)?;
                corrected.push(off(exact));
                printed.push(off(as_printed(problem, plane, r)?));
                convolved.push((convolution(problem, plane, r)? / exact - 1.0).abs());
            }
        }
    }
    Ok(vec![equation_6(largest(convolved)), equation_7(largest(printed), largest(corrected))])
}

fn equation_6(off: f64) -> Claim {
    Claim::from(Equation {
        title: "Equation 6: the illuminance of one plane by that of the other",
        printed_words: "E1(r) = (rho2 / pi) integral of E2(r') / [1 + (r - r')^2]^2 d2r' + h1 / \
                        (h1^2 + r^2)^(3/2)",
        correction: None,
        printed: off,
        corrected: None,
        tolerance: MISSING,
        check: format!(
            "The solution (7), corrected, is put into the right side, which is integrated over \
             rings to r' = {LARGE}; cases A (both reflectances 0.5, h1 = 0.5) and B (0.8 and 0.3, \
             h1 = 0.7), both planes, r = 0 to 3."
        ),
        command: "cargo run --release --example reproduce_paper -- -o out --only sobolev",
    })
}

fn equation_7(printed: f64, corrected: f64) -> Claim {
    Claim::from(Equation {
        title: "Equation 7: the solution of Sobolev's problem",
        printed_words: "E1(r) = h1 / (h1^2 + r^2)^(3/2) + rho2 integral from 0 to infinity of \
                        [e^(-h1 k) rho1 k K1(k) + e^(-h2 k) K1(k) J0(kr) k^2] dk / (1 - rho1 rho2 \
                        k^2 K1(k)^2)",
        correction: Some(
            "K1(k) J0(kr) k^2 multiplies both terms: [e^(-h1 k) rho1 k K1(k) + e^(-h2 k)] K1(k) \
             J0(kr) k^2.",
        ),
        printed,
        corrected: Some(corrected),
        tolerance: MISSING,
        check: format!(
            "Against the integral equation between discs of radius {LARGE}, solved at nodes: the \
             largest relative difference in cases A and B, both planes, r = 0 to 3."
        ),
        command: "harmolux exact sobolev --reflectance 0.8,0.3 --height 0.7 --plane both",
    })
}

/// Returns reflectances and heights as this plane counts them: its own first.
fn own_first(p: &SobolevProblem, plane: Plane) -> ([f64; 2], [f64; 2]) {
    let (rho, h) = (p.reflectance, [p.source_height, p.gap - p.source_height]);
    match plane {
        Plane::Lower => (rho, h),
        Plane::Upper => ([rho[1], rho[0]], [h[1], h[0]]),
    }
}

/// Evaluates (7) letter by letter.
fn as_printed(p: &SobolevProblem, plane: Plane, r: f64) -> Result<f64> {
    let ([rho1, rho2], [h1, h2]) = own_first(p, plane);
    let integrand = |k: f64| {
        let k1 = f_k1(k);
        let bracket = (-h1 * k).exp() * rho1 * k * k1 + (-h2 * k).exp() * k1 * f_j0(k * r) * k * k;
        bracket / (1.0 - rho1 * rho2 * (k * k1).powi(2))
    };
    // Doubling away from the logarithm at 0.
    let ends = std::iter::successors(Some(0.5_f64.powi(24)), |k| Some(k + k.min(0.5)));
    Ok(p.direct(plane, r)? + rho2 * panels(ends.take_while(|k| *k <= CUT), 16, integrand))
}

/// Evaluates the right side of (6) with the exact illuminance of the other plane, ring by ring.
fn convolution(p: &SobolevProblem, plane: Plane, r: f64) -> Result<f64> {
    let ([_, rho2], _) = own_first(p, plane);
    let other = if plane == Plane::Lower { Plane::Upper } else { Plane::Lower };
    // The integral over the azimuth of 1 / (a - b cos)^2 is 2 pi a / (a^2 - b^2)^(3/2).
    let ring = |s: f64| {
        let (a, b) = (1.0 + r * r + s * s, 2.0 * r * s);
        let e = p.illuminance(other, s).unwrap_or(f64::NAN);
        2.0 * s * e * a / (a * a - b * b).powf(1.5)
    };
    let ends = std::iter::successors(Some(0.25_f64), |s| Some(s + (0.5 * s).max(0.25)));
    let ends = ends.take_while(|s| *s < LARGE).chain([LARGE]);
    Ok(p.direct(plane, r)? + rho2 * panels(ends, 12, ring))
}

/// Integrates from 0 over panels with these ends.
fn panels(ends: impl Iterator<Item = f64>, nodes: usize, f: impl Fn(f64) -> f64) -> f64 {
    let base = Rule::gauss_legendre(nodes);
    let panel = |from: &mut f64, to: f64| {
        let part = base.clone().on(*from, to).integrate(&f);
        *from = to;
        Some(part)
    };
    ends.scan(0.0, panel).sum()
}
