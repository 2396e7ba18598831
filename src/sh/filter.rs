//! Filters against ringing: each degree of a series is damped by a factor; a cut at lmax overshoots
//! at edges, a damped end does less.

use std::f64::consts::PI;
use std::fmt;
use std::str::FromStr;

use super::Coefficients;
use crate::{Error, Result};

/// Damps the degrees of a series; degree 0, the mean, is kept.
///
/// ```
/// use harmolux::sh::{Coefficients, Filter};
///
/// let mut edge = Coefficients::zeros(2);
/// edge.set(0, 0, 1.0, 0.0);
/// edge.set(2, 0, 0.3, 0.0);
/// let heat: Filter = "heat=0.01".parse()?;
/// let smooth = heat.apply(&edge);
/// assert_eq!(smooth.mean(), 1.0);
/// assert!((smooth.get(2, 0).0 - 0.3 * (-0.06_f64).exp()).abs() < 1e-15);
/// # Ok::<(), harmolux::Error>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Filter {
    /// Multiplies degree l by sinc(l/(lmax+1)), sinc x = sin(pi x)/(pi x) (Lanczos' sigma factors).
    Lanczos,
    /// Multiplies degree l by exp(-l(l+1) t): heat flowing for the time t over the unit sphere.
    Heat {
        /// The time t, at least 0; details of angle below about sqrt(2 t) radians fade.
        time: f64,
    },
}

impl Filter {
    /// Makes the heat filter.
    ///
    /// # Errors
    /// [`Error::Parameter`] unless `time` is finite and at least 0.
    pub fn heat(time: f64) -> Result<Self> {
        if time.is_finite() && time >= 0.0 {
            return Ok(Self::Heat { time });
        }
        Err(Error::Parameter(format!(
            "the time of a heat filter is a finite number from 0 on, found {time}; 0.001 softens \
             edges over about 3 degrees of arc"
        )))
    }

    /// Returns the factor, 0 to 1, of degree `l` in a series cut at `lmax`.
    pub fn factor(self, l: usize, lmax: usize) -> f64 {
        match self {
            Self::Lanczos if l == 0 => 1.0,
            Self::Lanczos => {
                let x = PI * l as f64 / (lmax + 1) as f64;
                x.sin() / x
            }
            Self::Heat { time } => (-((l * (l + 1)) as f64) * time).exp(),
        }
    }

    /// Damps a series.
    pub fn apply(self, series: &Coefficients) -> Coefficients {
        let lmax = series.lmax();
        let mut damped = Coefficients::zeros(lmax);
        for l in 0..=lmax {
            let factor = self.factor(l, lmax);
            for m in 0..=l {
                let (a, b) = series.get(l, m);
                damped.set(l, m, factor * a, factor * b);
            }
        }
        damped
    }
}

impl fmt::Display for Filter {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Lanczos => f.write_str("lanczos"),
            Self::Heat { time } => write!(f, "heat={time}"),
        }
    }
}

impl FromStr for Filter {
    type Err = Error;

    /// Reads `lanczos` or `heat=T`.
    fn from_str(text: &str) -> Result<Self> {
        match text.split_once('=').map(|(name, time)| (name, time.trim().parse())) {
            None if text == "lanczos" => Ok(Self::Lanczos),
            Some(("heat", Ok(time))) => Self::heat(time),
            _ => Err(Error::Parameter(format!(
                "`{text}` is no filter: write lanczos, or heat=T with a time such as heat=0.001"
            ))),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ones(lmax: usize) -> Coefficients {
        let mut c = Coefficients::zeros(lmax);
        for l in 0..=lmax {
            (0..=l).for_each(|m| c.set(l, m, 1.0, if m > 0 { 1.0 } else { 0.0 }));
        }
        c
    }

    #[test]
    fn degree_zero_and_time_zero_change_nothing() {
        assert_eq!(Filter::Lanczos.apply(&ones(0)), ones(0));
        assert_eq!(Filter::Heat { time: 0.0 }.apply(&ones(5)), ones(5));
    }

    #[test]
    fn factors_are_the_formulas() {
        // sinc(1/2) = 2/pi at l = 2 of lmax = 3; exp(-3 * 4 * 0.05) = exp(-0.6).
        assert!((Filter::Lanczos.factor(2, 3) - 2.0 / PI).abs() <= 1e-16);
        let heat = Filter::Heat { time: 0.05 };
        let (a, b) = heat.apply(&ones(4)).get(3, 2);
        assert!((a - 0.548_811_636_094_026_4).abs() <= 1e-15 && a == b);
    }

    #[test]
    fn filters_are_read_as_they_are_written() {
        for filter in [Filter::Lanczos, Filter::Heat { time: 0.001 }] {
            assert_eq!(filter.to_string().parse::<Filter>().expect("known"), filter);
        }
        for wrong in ["", "Lanczos", "heat", "heat=", "heat=-1", "heat=nan", "box=2"] {
            assert!(wrong.parse::<Filter>().is_err(), "{wrong}");
        }
    }
}
