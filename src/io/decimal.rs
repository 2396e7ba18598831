//! Numbers as texts have them, those of Fortran too.

/// Reads a number; an exponent may begin with `D`, as Fortran writes it. It need not be finite.
pub(in crate::io) fn real(text: &str) -> Option<f64> {
    let fortran = || {
        let (mantissa, exponent) = text.split_once(['D', 'd'])?;
        exponent.parse::<i32>().ok().and_then(|_| format!("{mantissa}e{exponent}").parse().ok())
    };
    text.parse().ok().or_else(fortran)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exponents_of_fortran_are_read() {
        for (text, value) in [
            ("1.0D-03", 1e-3),
            ("-2.5d2", -250.0),
            ("1D+00", 1.0),
            (".5D1", 5.0),
            ("1e3", 1e3),
            ("7", 7.0),
        ] {
            assert_eq!(real(text), Some(value), "{text}");
        }
        for text in ["", "D", "1D", "D3", "1D2D3", "1Dx", "1.0D1.5", "1e2D3", "(1,2)", "0d", "1D "]
        {
            assert_eq!(real(text), None, "{text}");
        }
        assert!(real("1D999").is_some_and(f64::is_infinite));
    }
}
