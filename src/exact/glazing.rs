//! How much light a clear pane lets through: Fresnel's equations with all reflections between its
//! faces (CIE 171:2006, case 5.5).
//!
//! Each face reflects R_s or R_p, each pass keeps t = tau^(1/cos theta_t), and the geometric series
//! of passes to and fro gives T = (1 - R)^2 t/(1 - R^2 t^2), averaged over the two polarisations.
//! The light is unpolarised and incoherent.

use std::f64::consts::FRAC_PI_2;

use super::ranges::accept;
use crate::Result;

/// Describes a plane-parallel pane in air.
///
/// ```
/// use harmolux::exact::Pane;
///
/// let glass = Pane { refractive_index: 1.52, internal_transmittance: 1.0 };
/// assert!((glass.transmittance(0.0)? - 0.918318).abs() <= 5e-7);
/// # Ok::<(), harmolux::Error>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pane {
    /// The refractive index, above 1.
    pub refractive_index: f64,
    /// What one pass along the normal keeps, face to face and without the faces, between 0 and 1; 1
    /// is glass that absorbs nothing.
    pub internal_transmittance: f64,
}

impl Pane {
    /// Returns the directional transmittance, 0 to 1, at `angle` radians from the normal, 0 to
    /// pi/2, where it is 0.
    ///
    /// # Errors
    /// [`Error::Parameter`](crate::Error::Parameter) for a field or `angle` outside its range.
    pub fn transmittance(&self, angle: f64) -> Result<f64> {
        let (n, tau) = (self.refractive_index, self.internal_transmittance);
        accept(n.is_finite() && n > 1.0, "the refractive index", n, "a finite number above 1")?;
        accept((0.0..=1.0).contains(&tau), "the internal transmittance", tau, "between 0 and 1")?;
        let range = "between 0 and pi/2";
        accept((0.0..=FRAC_PI_2).contains(&angle), "the angle, in radians,", angle, range)?;
        let (outside, inside) = (angle.cos(), (1.0 - (angle.sin() / n).powi(2)).sqrt());
        let pass = tau.powf(inside.recip());
        let polarised = |a: f64, b: f64| {
            let reflected = ((a - b) / (a + b)).powi(2);
            through(reflected, pass)
        };
        Ok(0.5 * (polarised(outside, n * inside) + polarised(n * outside, inside)))
    }
}

/// Returns what passes two faces that reflect this part, with `pass` kept on the way between them.
fn through(reflected: f64, pass: f64) -> f64 {
    if reflected >= 1.0 {
        return 0.0;
    }
    (1.0 - reflected).powi(2) * pass / (1.0 - (reflected * pass).powi(2))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Error;

    const CLEAR: Pane = Pane { refractive_index: 1.52, internal_transmittance: 1.0 };
    const GREEN: Pane = Pane { internal_transmittance: 0.96, ..CLEAR };

    #[test]
    fn senseless_panes_and_angles_are_refused() {
        for wrong in [
            Pane { refractive_index: 1.0, ..CLEAR },
            Pane { refractive_index: f64::NAN, ..CLEAR },
            Pane { internal_transmittance: 1.1, ..CLEAR },
            Pane { internal_transmittance: -0.1, ..CLEAR },
        ] {
            assert!(matches!(wrong.transmittance(0.0), Err(Error::Parameter(_))), "{wrong:?}");
        }
        for angle in [-0.1, 1.6, f64::NAN] {
            assert!(CLEAR.transmittance(angle).is_err(), "{angle}");
        }
    }

    #[test]
    fn grazing_light_and_black_glass_let_nothing_through() {
        let black = Pane { internal_transmittance: 0.0, ..CLEAR };
        assert_eq!(black.transmittance(0.3).unwrap(), 0.0);
        // The cosine of the nearest number to pi/2 is 6e-17.
        assert!(CLEAR.transmittance(FRAC_PI_2).unwrap().abs() <= 1e-15);
        assert_eq!(through(1.0, 1.0), 0.0);
    }

    #[test]
    fn glass_is_the_printed_table() {
        let angles = [0.0_f64, 30.0, 45.0, 60.0, 70.0, 75.0, 80.0, 85.0];
        for (pane, printed) in [
            (
                CLEAR,
                [
                    0.918_318, 0.915_957, 0.902_528, 0.843_471, 0.724_713, 0.614_805, 0.456_043,
                    0.245_646,
                ],
            ),
            (
                GREEN,
                [
                    0.881_460, 0.877_047, 0.861_522, 0.801_519, 0.685_392, 0.578_796, 0.424_743,
                    0.219_815,
                ],
            ),
        ] {
            for (angle, value) in angles.iter().zip(printed) {
                let found = pane.transmittance(angle.to_radians()).unwrap();
                // Printed to six decimals.
                assert!((found - value).abs() <= 5.1e-7, "{angle} degrees: {found}, {value}");
            }
        }
    }

    #[test]
    fn light_followed_to_and_fro_gives_the_same() {
        // Fresnel's laws in angles, and the passes added one by one.
        for degrees in [5.0_f64, 40.0, 77.0] {
            let (i, t) = (degrees.to_radians(), (degrees.to_radians().sin() / 1.52).asin());
            let s = ((i - t).sin() / (i + t).sin()).powi(2);
            let p = ((i - t).tan() / (i + t).tan()).powi(2);
            let pass = 0.96_f64.powf(1.0 / t.cos());
            let followed = |r: f64| -> f64 {
                (0..60).map(|k| (1.0 - r).powi(2) * pass * (r * pass).powi(2 * k)).sum()
            };
            let expected = 0.5 * (followed(s) + followed(p));
            let found = GREEN.transmittance(i).unwrap();
            assert!((found - expected).abs() <= 1e-14, "{degrees} degrees: {found}, {expected}");
        }
    }
}
