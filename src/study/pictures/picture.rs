//! A picture as it is compared: its pixels and what is known of their errors.

#[cfg(feature = "images")]
use std::path::Path;

#[cfg(feature = "images")]
use crate::Result;
#[cfg(feature = "images")]
use crate::error::InputError;
#[cfg(feature = "images")]
use crate::io::images::{Attribute, Exr};
use crate::math::Rgb;
use crate::scene::Film;

/// Holds a picture and the standard errors of its pixels, where they are known.
#[derive(Debug, Clone, PartialEq)]
pub struct Picture {
    /// Columns and rows.
    pub size: [usize; 2],
    /// Which part of a larger picture it is: the column and row of its first pixel, and the
    /// columns and rows of the whole. `None` for a whole one.
    pub part: Option<([i32; 2], [usize; 2])>,
    /// The pixels in linear Rec. 709, top row first.
    pub pixels: Vec<Rgb>,
    /// The standard error of the luminance of each pixel, 0 where it is exact, not finite where it
    /// is not known; empty where none is.
    pub errors: Vec<f64>,
    /// How many independent replicates the errors come from; `None` where that is not said, and
    /// errors are taken as exact.
    pub replicates: Option<usize>,
}

impl From<&Film> for Picture {
    fn from(film: &Film) -> Self {
        Self {
            size: film.size(),
            part: None,
            pixels: film.image(),
            errors: film.standard_errors(),
            replicates: Some(film.replicates()),
        }
    }
}

#[cfg(feature = "images")]
impl Picture {
    /// Takes R, G and B of an EXR image, or else its luminance as grey, with `stderr.Y` and the
    /// attribute `replicates` where they are; `path` is for messages.
    ///
    /// # Errors
    /// [`crate::Error::Input`] when there is neither colour nor luminance, or a pixel is not
    /// finite.
    pub fn from_exr(path: &Path, exr: &Exr) -> Result<Self> {
        let grey = || Some(exr.luminance()?.into_iter().map(Rgb::grey).collect());
        let Some(pixels) = exr.colours().or_else(grey) else {
            let names = exr.channel_names().collect::<Vec<_>>().join(", ");
            let message = format!("the picture has no channels R, G, B and no luminance: {names}");
            let help = "write the beauty pass as one layer with the channels R, G and B";
            return Err(InputError::new(path, message).help(help).into());
        };
        let size = [exr.width(), exr.height()];
        require_finite(path, size, &pixels)?;
        let errors = exr.channel("stderr.Y").unwrap_or_default();
        let replicates = match exr.attribute("replicates") {
            Some(Attribute::Number(n)) if *n >= 1.0 && *n < 1e9 => Some(*n as usize),
            _ => None,
        };
        let errors = errors.iter().copied().map(f64::from).collect();
        Ok(Self { size, part: exr.part(), pixels, errors, replicates })
    }
}

#[cfg(feature = "images")]
fn require_finite(path: &Path, size: [usize; 2], pixels: &[Rgb]) -> Result<()> {
    let mut wrong = (0..pixels.len()).filter(|i| !pixels[*i].is_finite());
    let Some(first) = wrong.next() else { return Ok(()) };
    let (x, y) = (first % size[0], first / size[0]);
    let more = match wrong.count() {
        0 => String::new(),
        n => format!(", nor are {n} more"),
    };
    let message = format!("pixel ({x}, {y}) is not finite{more}");
    let help = "a picture with such pixels is compared with nothing: render it anew, or crop them \
                away; `harmolux falsecolor` shows them magenta";
    Err(InputError::new(path, message).help(help).into())
}

#[cfg(all(test, feature = "images"))]
mod tests {
    use super::*;

    fn read(exr: &Exr) -> Result<Picture> {
        Picture::from_exr("x.exr".as_ref(), exr)
    }

    #[test]
    fn colours_and_errors_are_taken() {
        let pixels = [Rgb([1.0, 2.0, 3.0]), Rgb::BLACK];
        let plain = Exr::new(2, 1).with_colour("", &pixels).expect("fits");
        let picture = read(&plain).expect("a picture");
        assert_eq!((picture.pixels.as_slice(), picture.size), (&pixels[..], [2, 1]));
        assert!(picture.errors.is_empty() && picture.replicates.is_none());
        let full = plain.with_values("stderr.Y", &[0.5, 0.25]).expect("fits");
        let full = full.with_attribute("replicates", 32.0).within([8, 6], [3, 1]);
        let picture = read(&full).expect("a picture");
        assert_eq!((picture.errors, picture.replicates), (vec![0.5, 0.25], Some(32)));
        assert_eq!(picture.part, Some(([3, 1], [8, 6])));
    }

    #[test]
    fn luminance_alone_is_grey() {
        let exr = Exr::new(1, 1).with_values("Y", &[2.5]).expect("fits");
        assert_eq!(read(&exr).expect("a picture").pixels, [Rgb::grey(2.5)]);
    }

    #[test]
    fn pictures_without_light_or_with_holes_are_refused() {
        let exr = Exr::new(1, 1).with_values("depth.Z", &[2.5]).expect("fits");
        let message = read(&exr).expect_err("refused").to_string();
        assert!(message.contains("no channels R, G, B and no luminance: depth.Z"), "{message}");
        let values = [1.0, f64::NAN, 1.0, f64::INFINITY].map(Rgb::grey);
        let exr = Exr::new(2, 2).with_colour("", &values).expect("fits");
        let message = read(&exr).expect_err("refused").to_string();
        assert!(message.contains("pixel (1, 0) is not finite, nor are 1 more"), "{message}");
    }
}
