//! 8-bit sRGB PNG from linear Rec. 709 pixels: exposed, brought to 0..1 by a tone curve, and
//! encoded by the transfer function of IEC 61966-2-1.

use rayon::prelude::*;

use super::check_size;
use crate::io::output::SOFTWARE;
use crate::math::Rgb;
use crate::scene::{Display, Tone};
use crate::{Error, Result};

/// What is painted where a pixel is not finite: a magenta that no exposure of a scene gives by
/// accident.
pub const NOT_FINITE: [u8; 3] = [255, 0, 255];

/// Holds an encoded PNG and what its maker should report.
#[derive(Debug, Clone, PartialEq)]
pub struct Png {
    /// The file.
    pub bytes: Vec<u8>,
    /// What the pixels were multiplied with.
    pub exposure: f64,
    /// How many pixels were NaN or infinite; they are painted magenta.
    pub not_finite: usize,
}

/// Encodes linear Rec. 709 `pixels` (`width` x `height`, row by row from the top left) as PNG;
/// `run` is the text that tells of which run it is, if any.
///
/// # Errors
/// [`Error::Parameter`] when the size does not fit the pixels or the exposure is not a positive
/// finite number.
pub fn png(
    width: usize,
    height: usize,
    pixels: &[Rgb],
    display: Display,
    run: Option<&str>,
) -> Result<Png> {
    let exposure = display.exposure.factor(pixels)?;
    let not_finite = pixels.iter().filter(|p| !p.is_finite()).count();
    let samples = shown(pixels, exposure, display.tone);
    Ok(Png { bytes: encode(width, height, samples.as_flattened(), run)?, exposure, not_finite })
}

/// Returns linear Rec. 709 `pixels` as the sRGB values of a screen, exposed by a factor; those that
/// are not finite become [`NOT_FINITE`].
pub fn shown(pixels: &[Rgb], exposure: f64, tone: Tone) -> Vec<[u8; 3]> {
    let level = |value: f64| quantise(tone.shown(value * exposure));
    let one = |p: &Rgb| if p.is_finite() { p.0.map(level) } else { NOT_FINITE };
    pixels.par_iter().map(one).collect()
}

/// Applies the sRGB transfer function to a value from 0 to 1 and rounds to the nearest of 256 levels.
fn quantise(c: f64) -> u8 {
    let encoded = if c <= 0.003_130_8 { 12.92 * c } else { 1.055 * c.powf(1.0 / 2.4) - 0.055 };
    (255.0 * encoded).round() as u8
}

/// Encodes sRGB `samples` (three bytes a pixel, row by row from the top left) as PNG that says sRGB
/// and names this program.
///
/// # Errors
/// [`Error::Parameter`] when the size does not fit the samples; [`Error::Numeric`] with the
/// encoder's complaint.
pub fn encode_png(width: usize, height: usize, samples: &[u8]) -> Result<Vec<u8>> {
    encode(width, height, samples, None)
}

fn encode(width: usize, height: usize, samples: &[u8], run: Option<&str>) -> Result<Vec<u8>> {
    check_size(width, height, samples.len() / 3)?;
    let (Ok(columns), Ok(rows), 0) =
        (u32::try_from(width), u32::try_from(height), samples.len() % 3)
    else {
        return Err(Error::Parameter(format!("an image of {width} x {height} is no PNG")));
    };
    let mut bytes = Vec::new();
    write(&mut bytes, [columns, rows], samples, run)
        .map_err(|e| Error::Numeric(format!("the PNG encoder failed: {e}")))?;
    Ok(bytes)
}

fn write(
    bytes: &mut Vec<u8>,
    [columns, rows]: [u32; 2],
    samples: &[u8],
    run: Option<&str>,
) -> Result<(), png::EncodingError> {
    let mut encoder = png::Encoder::new(bytes, columns, rows);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_compression(png::Compression::Balanced);
    encoder.set_filter(png::Filter::Adaptive);
    encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
    encoder.add_text_chunk("Software".to_owned(), SOFTWARE.to_owned())?;
    if let Some(run) = run {
        encoder.add_text_chunk("Run".to_owned(), run.to_owned())?;
    }
    let mut writer = encoder.write_header()?;
    writer.write_image_data(samples)?;
    writer.finish()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::io::output::{Kind, Output};
    use crate::scene::Exposure;
    use image::codecs::png::{CompressionType, FilterType, PngEncoder};
    use image::{ExtendedColorType, ImageEncoder};

    fn decoded(bytes: &[u8]) -> image::RgbImage {
        image::load_from_memory(bytes).expect("a PNG").into_rgb8()
    }

    fn exposed(factor: f64) -> Display {
        Display { exposure: Exposure::Factor(factor), ..Display::default() }
    }

    #[test]
    fn empty_and_misshapen_images_are_refused() {
        assert!(png(0, 0, &[], exposed(1.0), None).is_err());
        assert!(png(2, 2, &[Rgb::WHITE; 3], Display::default(), None).is_err());
        assert!(png(usize::MAX, 2, &[Rgb::WHITE; 2], Display::default(), None).is_err());
        assert!(encode_png(1, 1, &[0; 4]).is_err());
        for exposure in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            let message = png(1, 1, &[Rgb::WHITE], exposed(exposure), None).expect_err("refused");
            assert!(message.to_string().contains("is not a positive number"));
        }
    }

    #[test]
    fn black_image_is_black_at_exposure_one() {
        let made = png(2, 1, &[Rgb::BLACK; 2], Display::default(), None).expect("made");
        assert_eq!((made.exposure, made.not_finite), (1.0, 0));
        assert!(decoded(&made.bytes).pixels().all(|p| p.0 == [0; 3]));
    }

    #[test]
    fn pixels_that_are_not_finite_are_counted_and_shown() {
        let pixels = [
            Rgb([f64::NAN, 1.0, 1.0]),
            Rgb::grey(f64::INFINITY),
            Rgb::grey(2.0),
            Rgb([-1.0, 0.5, 9.0]),
        ];
        let made = png(4, 1, &pixels, exposed(0.5), None).expect("made");
        assert_eq!((made.not_finite, made.exposure), (2, 0.5));
        let shown: Vec<_> = decoded(&made.bytes).pixels().map(|p| p.0).collect();
        assert_eq!(shown, [NOT_FINITE, NOT_FINITE, [255; 3], [0, 137, 255]]);
    }

    #[test]
    fn tone_comes_after_the_exposure_and_before_the_encoding() {
        let display = Display { exposure: Exposure::Factor(0.5), tone: Tone::Filmic };
        let made = png(1, 1, &[Rgb([2.0, 0.2, 1e9])], display, None).expect("made");
        let expected = [1.0, 0.1, 1e9].map(|x| quantise(Tone::Filmic.shown(x)));
        assert_eq!(decoded(&made.bytes)[(0, 0)].0, expected);
    }

    #[test]
    fn transfer_function_is_that_of_the_standard() {
        // Levels from the inverse function of IEC 61966-2-1: v <= 0.04045 ? v/12.92 : ((v +
        // 0.055)/1.055)^2.4.
        for level in 0..=255_u8 {
            let v = f64::from(level) / 255.0;
            let linear = if v <= 0.040_45 { v / 12.92 } else { ((v + 0.055) / 1.055).powf(2.4) };
            assert_eq!(quantise(linear), level);
        }
        assert_eq!([quantise(0.18), quantise(0.5)], [118, 188]);
    }

    #[test]
    fn rows_run_from_the_top_left() {
        let pixels: Vec<Rgb> = (0..6).map(|i| Rgb::grey(f64::from(i) / 5.0)).collect();
        let image = decoded(&png(3, 2, &pixels, exposed(1.0), None).expect("made").bytes);
        assert_eq!(image.dimensions(), (3, 2));
        assert_eq!([image[(0, 0)][0], image[(1, 0)][0], image[(2, 1)][0]], [0, quantise(0.2), 255]);
    }

    #[test]
    fn chunks_say_srgb_and_this_program() {
        let bytes = encode_png(2, 1, &[0, 1, 2, 253, 254, 255]).expect("made");
        // After the 8 + 25 bytes of signature and header: lengths, kinds, contents, checksums.
        assert_eq!(bytes[33..46], *b"\0\0\0\x01sRGB\0\xae\xce\x1c\xe9");
        let text = [b"tEXtSoftware\0", SOFTWARE.as_bytes()].concat();
        let length = (text.len() - 4) as u32;
        assert_eq!(bytes[46..50], length.to_be_bytes());
        assert_eq!(bytes[50..50 + text.len()], text);
        let end = 50 + text.len() + 4;
        assert_eq!(bytes[end + 4..end + 8], *b"IDAT");
    }

    #[test]
    fn pixels_are_packed_as_by_the_encoder_of_crate_image() {
        let samples: Vec<u8> = (0..3 * 67 * 31_u32).map(|i| ((i * i) >> 5) as u8).collect();
        let mut expected = Vec::new();
        PngEncoder::new_with_quality(&mut expected, CompressionType::Default, FilterType::Adaptive)
            .write_image(&samples, 67, 31, ExtendedColorType::Rgb8)
            .expect("made");
        let mut bytes = encode_png(67, 31, &samples).expect("made");
        bytes.drain(33..33 + 13 + 12 + 9 + SOFTWARE.len());
        assert_eq!(bytes, expected);
    }

    #[test]
    fn file_names_this_program_and_is_known_again() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("view.png");
        let made = png(2, 2, &[Rgb::WHITE; 4], Display::default(), Some("run 17")).expect("made");
        let open = || Output::open_again(&path, &Kind::PNG, false);
        open().expect("free").write(&made.bytes).expect("written");
        let mut output = open().expect("ours");
        output.check_run("run 18").expect_err("of run 17");
        output.check_run("run 17").expect("its own");
        drop(output);
        let foreign = {
            let mut bytes = Vec::new();
            PngEncoder::new(&mut bytes)
                .write_image(&[0; 3], 1, 1, ExtendedColorType::Rgb8)
                .expect("made");
            bytes
        };
        std::fs::write(&path, foreign).expect("written");
        assert!(open().is_err());
    }
}
