//! Values of the command line.

use glam::DVec3;
use harmolux::Error;
use harmolux::io::coefficients::Tolerance;

/// Reads a value of the command line: a part of the mean radius, or a length with its unit.
pub(crate) fn tolerance(text: &str) -> Result<Tolerance, String> {
    match text.trim().parse::<f64>() {
        Ok(part) if part.is_finite() && part > 0.0 => Ok(Tolerance::OfMeanRadius(part)),
        Ok(_) => Err("write a positive part of the mean radius, such as 1e-3".to_owned()),
        Err(_) => length(text).map(Tolerance::Metres),
    }
}

/// A list of truncation degrees, ascending.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Degrees(pub(crate) Vec<usize>);

/// Reads a value of the command line.
pub(crate) fn size(text: &str) -> Result<[u32; 2], String> {
    let parts = text.split_once(['x', 'X']).map(|(w, h)| (w.parse(), h.parse()));
    match parts {
        Some((Ok(w), Ok(h))) if (1..=65_536).contains(&w) && (1..=65_536).contains(&h) => {
            Ok([w, h])
        }
        _ => Err("write width x height in pixels, each from 1 to 65536, such as 320x240".into()),
    }
}

/// Reads a value of the command line: the numbers of latitudes and longitudes of a grid.
pub(crate) fn grid(text: &str) -> Result<[usize; 2], String> {
    let parts = text.split_once(['x', 'X']).map(|(a, b)| (a.parse(), b.parse()));
    match parts {
        Some((Ok(latitudes @ 2..=65_536), Ok(longitudes @ 1..=65_536))) => {
            Ok([latitudes, longitudes])
        }
        _ => Err("write latitudes x longitudes, at least the 2 poles and 1 longitude and each at \
                  most 65536, such as 181x360"
            .to_owned()),
    }
}

/// Reads a value of the command line.
pub(crate) fn point(text: &str) -> Result<DVec3, String> {
    numbers(text)
        .map(DVec3::from_array)
        .map_err(|_| "write three numbers, such as 0.1,0,-0.2".to_owned())
}

/// Reads a value of the command line.
pub(crate) fn numbers<const N: usize>(text: &str) -> Result<[f64; N], String> {
    let wrong = || format!("write {N} numbers with commas between them");
    let numbers: Vec<f64> = text
        .split(',')
        .map(|part| part.trim().parse().ok().filter(|v: &f64| v.is_finite()))
        .collect::<Option<_>>()
        .ok_or_else(wrong)?;
    numbers.try_into().map_err(|_| wrong())
}

/// Reads a value of the command line: two numbers, or one for both.
pub(crate) fn pair(text: &str) -> Result<[f64; 2], String> {
    numbers::<1>(text)
        .map(|[both]| [both; 2])
        .or_else(|_| numbers(text))
        .map_err(|_| "write one number for both, or two with a comma between them".to_owned())
}

/// Numbers by name, as written: sigma=0.2,nu=3.3.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Settings(Vec<(String, f64)>);

/// Reads a value of the command line.
pub(crate) fn settings(text: &str) -> Result<Settings, String> {
    let setting = |part: &str| {
        let (name, value) = part.split_once('=')?;
        let value = value.trim().parse().ok().filter(|v: &f64| v.is_finite())?;
        Some((name.trim().to_owned(), value))
    };
    let all = text.split(',').map(setting).collect::<Option<_>>();
    all.map(Settings).ok_or_else(|| "write pairs NAME=NUMBER, divided by commas".into())
}

impl Settings {
    /// Returns the values of the known names in their order; one without default must be there.
    pub(crate) fn values<const N: usize>(
        &self,
        known: [(&str, Option<f64>); N],
    ) -> Result<[f64; N], Error> {
        let names = || known.map(|(name, _)| name).join(", ");
        for (i, (name, _)) in self.0.iter().enumerate() {
            if !known.iter().any(|(k, _)| k == name) {
                let text = format!("there is no setting `{name}` here: use {}", names());
                return Err(Error::Parameter(text));
            }
            if self.0[..i].iter().any(|(earlier, _)| earlier == name) {
                return Err(Error::Parameter(format!("the setting `{name}` is given twice")));
            }
        }
        let mut values = [0.0; N];
        for (value, (name, default)) in values.iter_mut().zip(known) {
            let given = self.0.iter().find(|(n, _)| n == name).map(|(_, v)| *v);
            *value = given.or(default).ok_or_else(|| {
                Error::Parameter(format!("the setting `{name}` is missing: write {name}=NUMBER"))
            })?;
        }
        Ok(values)
    }
}

/// Reads a length of the command line, metres unless a unit follows.
pub(crate) fn length(text: &str) -> Result<f64, String> {
    let split = text.find(|c: char| c.is_ascii_alphabetic() && c != 'e' && c != 'E');
    let (number, unit) = text.split_at(split.unwrap_or(text.len()));
    let metres = match unit {
        "km" => 1e3,
        "" | "m" => 1.0,
        "cm" => 0.01,
        "mm" => 1e-3,
        "um" => 1e-6,
        "in" => 0.0254,
        _ => f64::NAN,
    };
    match number.trim().parse::<f64>().map(|n| n * metres) {
        Ok(length) if length > 0.0 && length.is_finite() => Ok(length),
        _ => Err(
            "write a positive length in metres or with its unit (km, m, cm, mm, um, in), such as 0.1mm"
                .into(),
        ),
    }
}

/// Reads a value of the command line.
pub(crate) fn degrees(text: &str) -> Result<Degrees, String> {
    let wrong =
        || "write degrees such as 4,8,16 or a range such as 2..64, none above 1400".to_owned();
    let degree =
        |part: &str| part.trim().parse::<usize>().ok().filter(|l| *l <= 1400).ok_or_else(wrong);
    let mut list = Vec::new();
    for part in text.split(',') {
        match part.split_once("..") {
            Some((first, last)) => list.extend(degree(first)?..=degree(last)?),
            None => list.push(degree(part)?),
        }
    }
    list.sort_unstable();
    list.dedup();
    if list.is_empty() { Err(wrong()) } else { Ok(Degrees(list)) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lists_sizes_and_points_are_read() {
        assert_eq!(degrees("8,4,8"), Ok(Degrees(vec![4, 8])));
        assert_eq!(degrees("2..5"), Ok(Degrees(vec![2, 3, 4, 5])));
        assert!(degrees("").is_err() && degrees("5..2").is_err() && degrees("9999").is_err());
        assert_eq!(length("2e-3"), Ok(2e-3));
        assert_eq!(length("0.5mm"), Ok(0.5e-3));
        assert!(length("-1").is_err() && length("nan").is_err() && length("1 mile").is_err());
        assert_eq!(size("320x240"), Ok([320, 240]));
        assert!(size("0x3").is_err() && size("320").is_err());
        assert_eq!(point("1, -2,0.5"), Ok(DVec3::new(1.0, -2.0, 0.5)));
        assert_eq!(tolerance("1e-3"), Ok(Tolerance::OfMeanRadius(1e-3)));
        assert!(
            matches!(tolerance("0.5mm"), Ok(Tolerance::Metres(x)) if (x - 5e-4).abs() <= 1e-18)
        );
        assert!(tolerance("0").is_err() && tolerance("mm").is_err());
        assert!(point("1,2").is_err() && point("1,2,nan").is_err());
        assert_eq!(pair("0.5"), Ok([0.5; 2]));
        assert_eq!(pair("0.8, 0.3"), Ok([0.8, 0.3]));
        assert!(pair("").is_err() && pair("1,2,3").is_err() && pair("half").is_err());
        assert_eq!(numbers("1,-2e3"), Ok([1.0, -2e3]));
        assert!(numbers::<2>("1,,2").is_err() && numbers::<0>("").is_err());
    }

    #[test]
    fn settings_are_found_by_name() {
        let given = settings("nu=3.3, sigma=0.2").expect("pairs");
        let known = [("sigma", None), ("nu", None), ("first", Some(2.0))];
        assert_eq!(given.values(known).expect("all there"), [0.2, 3.3, 2.0]);
        for (text, says) in [
            ("nu=1", "`sigma` is missing"),
            ("sigma=1,nu=1,nu=2", "given twice"),
            ("sigma=1,mu=1", "no setting `mu` here: use sigma, nu, first"),
        ] {
            let error = settings(text).expect("pairs").values(known).expect_err("wrong");
            assert!(error.to_string().contains(says), "{error}");
        }
        assert!(settings("sigma").is_err() && settings("sigma=x").is_err());
        assert!(settings("sigma=inf").is_err());
    }
}
