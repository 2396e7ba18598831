//! Closed enclosures whose light is known in closed form: the integrating sphere, pairs of uniform
//! surfaces, the mean of any room.
//!
//! On a sphere the form-factor kernel is the constant 1/A, so E(x) = E0(x) + int rho E0 dA / [A
//! (1 - mean rho)] whatever the emission and the reflectance. Two surfaces that see each other and
//! themselves uniformly reduce to two linear equations.

use std::f64::consts::PI;

use super::ranges::{absorbing, accept, not_negative, positive, reflectance};
use crate::{Error, Result};

/// Describes a sphere of two zones with an isotropic point source on its z axis. A port is a zone
/// of reflectance 0.
///
/// ```
/// use harmolux::exact::enclosures::IntegratingSphere;
///
/// let (radius, flux, offset, boundary) = (1.0, 1.0, 0.5, 0.0);
/// let reflectance = [0.9, 0.3];
/// let sphere = IntegratingSphere { radius, flux, offset, boundary, reflectance };
/// assert!((sphere.indirect()? - 0.14605730269706566).abs() <= 1e-15);
/// # Ok::<(), harmolux::Error>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct IntegratingSphere {
    /// The radius R, metres, above 0.
    pub radius: f64,
    /// The flux of the source, lm, at least 0.
    pub flux: f64,
    /// The height of the source over the centre, metres, between -R and R.
    pub offset: f64,
    /// The height of the boundary of the zones over the centre, divided by R, in [-1, 1].
    pub boundary: f64,
    /// The reflectances above and below the boundary, each in [0, 1]; their mean over the area
    /// below 1.
    pub reflectance: [f64; 2],
}

impl IntegratingSphere {
    /// Returns the illuminance, lx, at height `mu` R over the centre, `mu` in [-1, 1].
    ///
    /// # Errors
    /// [`Error::Parameter`] for a field or `mu` outside its range.
    pub fn illuminance(&self, mu: f64) -> Result<f64> {
        Ok(self.direct(mu)? + self.indirect()?)
    }

    /// Returns the direct part, lx: flux/(4 pi) (R - a mu)/(R^2 + a^2 - 2 R a mu)^1.5 with a the
    /// offset.
    ///
    /// # Errors
    /// [`Error::Parameter`] for a field or `mu` outside its range.
    pub fn direct(&self, mu: f64) -> Result<f64> {
        self.check()?;
        accept((-1.0..=1.0).contains(&mu), "the height mu", mu, "between -1 and 1")?;
        let (r, a) = (self.radius, self.offset);
        Ok(self.flux / (4.0 * PI) * (r - a * mu) / self.distance(mu).powi(3))
    }

    /// Returns the indirect part, lx, the same everywhere.
    ///
    /// # Errors
    /// [`Error::Parameter`] for a field outside its range.
    pub fn indirect(&self) -> Result<f64> {
        self.check()?;
        let above = self.flux_below(1.0) - self.flux_below(self.boundary);
        let reflected = self.reflectance[0] * above + self.reflectance[1] * (self.flux - above);
        let area = 4.0 * PI * self.radius * self.radius;
        Ok(reflected / (area * (1.0 - self.mean_reflectance())))
    }

    /// Returns the direct flux, lm, on the part of the sphere below height `mu` R.
    fn flux_below(&self, mu: f64) -> f64 {
        0.5 * self.flux * (1.0 + (self.radius * mu - self.offset) / self.distance(mu))
    }

    /// Returns the distance from the source to the circle at height `mu` R.
    fn distance(&self, mu: f64) -> f64 {
        let (r, a) = (self.radius, self.offset);
        // The sum of squares has no cancellation when source and point are near the same pole.
        ((r - a).powi(2) + 2.0 * r * a * (1.0 - mu)).sqrt()
    }

    fn mean_reflectance(&self) -> f64 {
        let [above, below] = self.reflectance;
        0.5 * (above * (1.0 - self.boundary) + below * (1.0 + self.boundary))
    }

    fn check(&self) -> Result<()> {
        positive("the radius", self.radius)?;
        not_negative("the flux", self.flux)?;
        let inside = self.offset.abs() < self.radius;
        accept(inside, "the offset", self.offset, "smaller than the radius")?;
        let boundary = self.boundary;
        accept((-1.0..=1.0).contains(&boundary), "the boundary", boundary, "between -1 and 1")?;
        reflectance("the reflectance above", self.reflectance[0])?;
        reflectance("the reflectance below", self.reflectance[1])?;
        absorbing("the mean reflectance", self.mean_reflectance())
    }
}

/// Holds what two uniform surfaces send out and receive, in the order of the problem's arrays.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Balance {
    /// The exitances M = M0 + rho E, lm/m2.
    pub exitance: [f64; 2],
    /// The illuminances E, lx.
    pub illuminance: [f64; 2],
}

/// Describes a spherical cap closed by its flat disc; each emits and reflects uniformly. Arrays are
/// [cap, disc].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CapAndDisc {
    /// The cap's share of the area of its sphere, between 0 and 1; 1/2 is the hemisphere.
    pub fraction: f64,
    /// The own exitances M0, lm/m2, at least 0.
    pub emission: [f64; 2],
    /// The reflectances, each in [0, 1], not both 1.
    pub reflectance: [f64; 2],
}

impl CapAndDisc {
    /// Solves E_cap = f M_cap + (1 - f) M_disc, E_disc = M_cap.
    ///
    /// # Errors
    /// [`Error::Parameter`] for a field outside its range.
    pub fn solve(&self) -> Result<Balance> {
        let f = self.fraction;
        accept(f > 0.0 && f < 1.0, "the cap's share of the sphere", f, "between 0 and 1")?;
        balance([[f, 1.0 - f], [1.0, 0.0]], self.emission, self.reflectance)
    }
}

/// Describes the space between two concentric spheres. Arrays are [inner, outer].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ConcentricSpheres {
    /// The radii, metres, above 0 and the inner one smaller.
    pub radius: [f64; 2],
    /// The own exitances M0 into the space between, lm/m2, at least 0.
    pub emission: [f64; 2],
    /// The reflectances, each in [0, 1], not both 1.
    pub reflectance: [f64; 2],
}

impl ConcentricSpheres {
    /// Solves E_inner = M_outer, E_outer = q M_inner + (1 - q) M_outer with q the ratio of the
    /// areas.
    ///
    /// # Errors
    /// [`Error::Parameter`] for a field outside its range.
    pub fn solve(&self) -> Result<Balance> {
        let [inner, outer] = self.radius;
        positive("the inner radius", inner)?;
        positive("the outer radius", outer)?;
        accept(inner < outer, "the inner radius", inner, "smaller than the outer one")?;
        let q = (inner / outer).powi(2);
        balance([[0.0, 1.0], [q, 1.0 - q]], self.emission, self.reflectance)
    }
}

/// Describes two infinite parallel planes that emit and reflect uniformly.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ParallelPlanes {
    /// The own exitances M0, lm/m2, at least 0.
    pub emission: [f64; 2],
    /// The reflectances, each in [0, 1], not both 1.
    pub reflectance: [f64; 2],
}

impl ParallelPlanes {
    /// Solves E_1 = M_2, E_2 = M_1.
    ///
    /// # Errors
    /// [`Error::Parameter`] for a field outside its range.
    pub fn solve(&self) -> Result<Balance> {
        balance([[0.0, 1.0], [1.0, 0.0]], self.emission, self.reflectance)
    }
}

/// Returns the mean illuminance, lx, over all surfaces of a closed room of one reflectance:
/// flux/[area (1 - rho)], whatever its shape.
///
/// `flux` lm, at least 0; `area` m2, above 0; `rho` at least 0 and below 1.
///
/// # Errors
/// [`Error::Parameter`] for an argument outside its range.
pub fn mean_illuminance(flux: f64, area: f64, rho: f64) -> Result<f64> {
    not_negative("the flux", flux)?;
    positive("the area", area)?;
    absorbing("the reflectance", rho)?;
    Ok(flux / (area * (1.0 - rho)))
}

/// Solves M = M0 + rho F M for two surfaces by Cramer's rule; `form_factors[i][j]` is the share of
/// i's view that j fills.
fn balance(f: [[f64; 2]; 2], emission: [f64; 2], rho: [f64; 2]) -> Result<Balance> {
    for i in 0..2 {
        not_negative("the emission", emission[i])?;
        reflectance("the reflectance", rho[i])?;
    }
    let (a, d) = (1.0 - rho[0] * f[0][0], 1.0 - rho[1] * f[1][1]);
    let (b, c) = (rho[0] * f[0][1], rho[1] * f[1][0]);
    let determinant = a * d - b * c;
    if rho == [1.0; 2] || determinant <= 0.0 {
        return Err(Error::Parameter(
            "two surfaces of reflectance 1 never absorb the light between them; lower one of them"
                .into(),
        ));
    }
    let exitance = [
        (d * emission[0] + b * emission[1]) / determinant,
        (c * emission[0] + a * emission[1]) / determinant,
    ];
    Ok(Balance { exitance, illuminance: f.map(|row| row[0] * exitance[0] + row[1] * exitance[1]) })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::quadrature::Rule;

    const SPHERE: IntegratingSphere = IntegratingSphere {
        radius: 1.0,
        flux: 1.0,
        offset: 0.5,
        boundary: 0.0,
        reflectance: [0.9, 0.3],
    };

    #[test]
    fn senseless_spheres_are_refused() {
        for wrong in [
            IntegratingSphere { radius: 0.0, ..SPHERE },
            IntegratingSphere { flux: f64::NAN, ..SPHERE },
            IntegratingSphere { offset: 1.0, ..SPHERE },
            IntegratingSphere { boundary: 1.5, ..SPHERE },
            IntegratingSphere { reflectance: [1.0, 1.0], ..SPHERE },
            IntegratingSphere { reflectance: [1.0, 0.0], boundary: -1.0, ..SPHERE },
        ] {
            assert!(matches!(wrong.indirect(), Err(Error::Parameter(_))), "{wrong:?}");
        }
        assert!(SPHERE.illuminance(1.1).is_err() && SPHERE.direct(f64::NAN).is_err());
    }

    #[test]
    fn sphere_has_the_printed_values() {
        // Printed to 16 digits; a dozen operations in f64.
        assert!((SPHERE.indirect().unwrap() - 0.146_057_302_697_065_66).abs() <= 1e-15);
        for (mu, value) in [
            (1.0, 0.464_367_188_880_856_4),
            (-1.0, 0.181_425_067_828_597_96),
            (0.0, 0.202_998_306_170_439_82),
        ] {
            assert!((SPHERE.illuminance(mu).unwrap() - value).abs() <= 1e-15, "mu = {mu}");
        }
    }

    #[test]
    fn uniform_sphere_with_central_source_is_the_textbook() {
        let s = IntegratingSphere { offset: 0.0, reflectance: [0.8; 2], radius: 2.0, ..SPHERE };
        let expected = mean_illuminance(1.0, 16.0 * PI, 0.8).unwrap();
        assert!((s.illuminance(0.3).unwrap() - expected).abs() <= 1e-15);
    }

    #[test]
    fn sphere_absorbs_the_whole_flux() {
        let s =
            IntegratingSphere { radius: 1.7, flux: 30.0, offset: -0.9, boundary: 0.4, ..SPHERE };
        let absorbed = |from: f64, to: f64, rho: f64| {
            let band = Rule::gauss_legendre(80).on(from, to);
            let area = 2.0 * PI * 1.7 * 1.7;
            band.integrate(|mu| (1.0 - rho) * area * s.illuminance(mu).unwrap())
        };
        let sum = absorbed(-1.0, 0.4, 0.3) + absorbed(0.4, 1.0, 0.9);
        assert!((sum - 30.0).abs() <= 1e-12);
    }

    #[test]
    fn hemisphere_has_the_printed_values() {
        let b = CapAndDisc { fraction: 0.5, emission: [0.0, 1.0], reflectance: [0.8, 0.3] };
        let b = b.solve().unwrap();
        let expected = [(b.exitance, [5.0 / 6.0, 1.25]), (b.illuminance, [25.0 / 24.0, 5.0 / 6.0])];
        for (found, printed) in expected {
            assert!(
                (found[0] - printed[0]).abs() <= 1e-15 && (found[1] - printed[1]).abs() <= 1e-15
            );
        }
    }

    #[test]
    fn concentric_spheres_have_the_printed_values() {
        let s =
            ConcentricSpheres { radius: [1.0, 2.0], emission: [1.0, 0.0], reflectance: [0.4, 0.7] };
        let b = s.solve().unwrap();
        // Printed to ten decimals.
        assert!((b.exitance[0] - 1.172_839_506_2).abs() <= 5.1e-11);
        assert!((b.exitance[1] - 0.432_098_765_4).abs() <= 5.1e-11);
        assert!((b.illuminance[1] - 0.617_283_950_6).abs() <= 5.1e-11);
        assert!((b.illuminance[0] - b.exitance[1]).abs() <= 1e-16);
    }

    #[test]
    fn parallel_planes_follow_the_closed_form() {
        let (m, rho) = ([2.0, 5.0], [0.3, 0.6]);
        let b = ParallelPlanes { emission: m, reflectance: rho }.solve().unwrap();
        let closed = (m[0] + rho[0] * m[1]) / (1.0 - rho[0] * rho[1]);
        assert!((b.exitance[0] - closed).abs() <= 1e-14);
        assert!((b.illuminance[1] - closed).abs() <= 1e-14);
    }

    #[test]
    fn enclosures_absorb_what_they_emit() {
        let (m, rho) = ([3.0, 7.0], [0.4, 0.9]);
        for (b, areas) in [
            (
                CapAndDisc { fraction: 0.8, emission: m, reflectance: rho }.solve().unwrap(),
                [1.0, 0.2],
            ),
            (
                ConcentricSpheres { radius: [2.0, 3.0], emission: m, reflectance: rho }
                    .solve()
                    .unwrap(),
                [4.0, 9.0],
            ),
        ] {
            let emitted: f64 = (0..2).map(|i| areas[i] * m[i]).sum();
            let absorbed: f64 = (0..2).map(|i| areas[i] * (1.0 - rho[i]) * b.illuminance[i]).sum();
            assert!((absorbed / emitted - 1.0).abs() <= 1e-14);
        }
    }

    #[test]
    fn furnace_is_uniform() {
        // Emission pi L0 (1 - rho) gives E = pi L0 everywhere.
        let rho = [0.25, 0.85];
        let b = CapAndDisc { fraction: 0.3, emission: rho.map(|r| 1.0 - r), reflectance: rho };
        for e in b.solve().unwrap().illuminance {
            assert!((e - 1.0).abs() <= 1e-15);
        }
    }

    #[test]
    fn senseless_pairs_are_refused() {
        let p = ParallelPlanes { emission: [1.0, 0.0], reflectance: [0.5; 2] };
        assert!(ParallelPlanes { reflectance: [1.0; 2], ..p }.solve().is_err());
        assert!(ParallelPlanes { emission: [-1.0, 0.0], ..p }.solve().is_err());
        let pair = CapAndDisc { fraction: 1.0, emission: p.emission, reflectance: p.reflectance };
        assert!(pair.solve().is_err());
        assert!(CapAndDisc { fraction: 0.3, reflectance: [1.0; 2], ..pair }.solve().is_err());
        let (emission, reflectance) = (p.emission, p.reflectance);
        let turned = ConcentricSpheres { radius: [2.0, 1.0], emission, reflectance };
        assert!(turned.solve().is_err());
        assert!(mean_illuminance(1.0, 6.0, 1.0).is_err());
        assert!(mean_illuminance(1.0, 0.0, 0.5).is_err());
    }
}
