//! How far two pictures are from each other: by their squares ([`RelativeMse`]), as they look
//! ([`flip`]), and by what their errors allow ([`joint_test`]).

mod flip;
mod joint;
mod picture;

pub use flip::{Flip, PIXELS_PER_DEGREE, flip, flip_ldr};
pub use joint::{FALSE_ALARMS, FEWEST_REPLICATES, JointLevel, JointTest, joint_test};
pub use picture::Picture;

use crate::math::choice::choice;
use crate::{Error, Result};

/// What keeps dark pixels from counting without bound: this part of the square of the reference's
/// mean luminance.
const DARK: f64 = 1e-4;

/// Holds what two pictures differ in.
#[derive(Debug, Clone, PartialEq)]
pub struct PictureComparison {
    /// Columns and rows.
    pub size: [usize; 2],
    /// The mean luminances of the first and of the reference.
    pub means: [f64; 2],
    /// The relative mean square error.
    pub relative_mse: RelativeMse,
    /// How different they look.
    pub flip: Flip,
    /// What their errors allow; `None` where one has none.
    pub joint: Option<JointTest>,
    /// How many pixels are not equal, but for the rounding of single precision.
    pub unequal: usize,
}

/// Holds the relative mean square error of a picture x against a reference r: the mean over all
/// pixels of (x - r)^2 / (r^2 + 1e-4 m^2), m being the mean luminance of r.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RelativeMse {
    /// That of the luminances.
    pub luminance: f64,
    /// That of R, G and B, their mean.
    pub colours: f64,
    /// What the errors of both pictures make of it in the mean: (s_x^2 + s_r^2) in place of
    /// (x - r)^2, over the pixels whose errors are known. `None` where none is.
    pub noise: Option<f64>,
}

impl RelativeMse {
    /// Returns what is left of that of the luminances beyond the noise, with a sign: it scatters
    /// about zero where the pictures are the same.
    pub fn beyond_noise(&self) -> Option<f64> {
        self.noise.map(|noise| self.luminance - noise)
    }
}

/// Names what a picture of the difference shows at each pixel.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum PictureMap {
    /// The difference of the luminances, the reference's taken off.
    #[default]
    Difference,
    /// The FLIP error.
    Flip,
    /// The difference in standard errors.
    Z,
}

choice!(PictureMap, "map":
    Difference = "difference" "luminance of A less that of B",
    Flip = "flip" "how different they look, from 0 to 1",
    Z = "z" "the difference in standard errors",
);

/// Compares a picture with a reference; `pixels_per_degree` is that of [`flip`].
///
/// # Errors
/// [`Error::Parameter`] when they have not the same size or are not the same part of a whole, and
/// as [`flip`].
pub fn compare_pictures(
    picture: &Picture,
    reference: &Picture,
    pixels_per_degree: f64,
) -> Result<PictureComparison> {
    require_same_window(picture, reference)?;
    let (a, b) = (&picture.pixels, &reference.pixels);
    let flip = flip(b, a, picture.size, pixels_per_degree)?;
    let means = [picture, reference].map(mean_luminance);
    let differs = |x: f64, r: f64| (x - r).abs() > joint::ROUNDING * x.abs().max(r.abs());
    let unequal = a.iter().zip(b).filter(|(x, r)| (0..3).any(|c| differs(x.0[c], r.0[c])));
    Ok(PictureComparison {
        size: picture.size,
        means,
        relative_mse: relative_mse(picture, reference),
        flip,
        joint: joint_test(picture, reference),
        unequal: unequal.count(),
    })
}

impl PictureComparison {
    /// Returns what a map shows at each pixel, top row first; z is NaN where an error is not known,
    /// and infinite where exact pixels differ.
    pub fn map(&self, map: PictureMap, picture: &Picture, reference: &Picture) -> Vec<f64> {
        let pixels = picture.pixels.iter().zip(&reference.pixels);
        match map {
            PictureMap::Difference => pixels.map(|(a, b)| a.luminance() - b.luminance()).collect(),
            PictureMap::Flip => self.flip.map.clone(),
            PictureMap::Z => joint::deviations(picture, reference),
        }
    }
}

fn require_same_window(a: &Picture, b: &Picture) -> Result<()> {
    if a.size != b.size {
        let [a, b] = [a, b].map(|p| format!("{} x {}", p.size[0], p.size[1]));
        return Err(Error::Parameter(format!(
            "{a} pixels against {b}: only pictures of one size are compared; render one of them \
             anew with the size, and the crop, of the other"
        )));
    }
    if a.part != b.part {
        let [a, b] = [a, b].map(|picture| match picture.part {
            Some(([x, y], [width, height])) => {
                format!("the part from pixel ({x}, {y}) of {width} x {height}")
            }
            None => "a whole picture".to_owned(),
        });
        return Err(Error::Parameter(format!(
            "{a} against {b}: only the same part of a picture is compared; render one of them \
             anew with the size and the crop of the other"
        )));
    }
    Ok(())
}

fn mean_luminance(picture: &Picture) -> f64 {
    picture.pixels.iter().map(|c| c.luminance()).sum::<f64>() / picture.pixels.len() as f64
}

/// Computes the relative mean square error of a picture against one of the same size.
pub(super) fn relative_mse(picture: &Picture, reference: &Picture) -> RelativeMse {
    let least = DARK * mean_luminance(reference).powi(2);
    let ratio = |square: f64, r: f64| match r * r + least {
        _ if square == 0.0 => 0.0,
        whole => square / whole,
    };
    let (mut luminance, mut colours, mut noise) = (0.0, 0.0, (0.0, 0_usize));
    for (i, (x, r)) in picture.pixels.iter().zip(&reference.pixels).enumerate() {
        let known = r.luminance();
        luminance += ratio((x.luminance() - known).powi(2), known);
        colours += (0..3).map(|c| ratio((x.0[c] - r.0[c]).powi(2), r.0[c])).sum::<f64>() / 3.0;
        let error = joint::error(picture, reference, i);
        if !error.is_nan() {
            noise = (noise.0 + ratio(error * error, known), noise.1 + 1);
        }
    }
    let n = picture.pixels.len() as f64;
    RelativeMse {
        luminance: luminance / n,
        colours: colours / n,
        noise: (noise.1 > 0).then(|| noise.0 / noise.1 as f64),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Rgb;

    fn picture(size: [usize; 2], values: &[f64], errors: &[f64]) -> Picture {
        let pixels = values.iter().copied().map(Rgb::grey).collect();
        Picture { size, part: None, pixels, errors: errors.to_vec(), replicates: Some(32) }
    }

    fn compared(a: &Picture, b: &Picture) -> PictureComparison {
        compare_pictures(a, b, PIXELS_PER_DEGREE).expect("the same size")
    }

    #[test]
    fn equal_pictures_have_no_difference() {
        let a = picture([2, 1], &[1.0, 3.0], &[0.1, 0.0]);
        let found = compared(&a, &a);
        assert_eq!((found.relative_mse.luminance, found.flip.max, found.unequal), (0.0, 0.0, 0));
        assert_eq!(found.joint.expect("errors are there").exact, 1);
    }

    #[test]
    fn relative_squares_are_as_they_are_defined() {
        let (a, b) =
            (picture([2, 1], &[1.5, 2.0], &[0.3, 0.0]), picture([2, 1], &[1.0, 3.0], &[0.4, 0.0]));
        let found = compared(&a, &b).relative_mse;
        // The mean of the reference is 2.
        let expected = 0.5 * (0.25 / 1.0004 + 1.0 / 9.0004);
        assert!(
            (found.luminance - expected).abs() <= 1e-15
                && (found.colours - expected).abs() <= 1e-15
        );
        let noise = 0.5 * 0.25 / 1.0004;
        assert!((found.noise.expect("known") - noise).abs() <= 1e-15);
        assert!((found.beyond_noise().expect("known") - (expected - noise)).abs() <= 1e-15);
        let bare = Picture { errors: Vec::new(), ..a.clone() };
        assert_eq!(compared(&bare, &b).relative_mse.beyond_noise(), None);
        let black = picture([2, 1], &[0.0; 2], &[]);
        assert_eq!(compared(&black, &black).relative_mse.luminance, 0.0);
        assert_eq!(compared(&a, &black).relative_mse.luminance, f64::INFINITY);
    }

    #[test]
    fn maps_show_what_they_say() {
        let (a, b) =
            (picture([2, 1], &[1.5, 2.0], &[0.3; 2]), picture([2, 1], &[1.0, 3.0], &[0.4; 2]));
        let found = compared(&a, &b);
        assert_eq!(found.map(PictureMap::Difference, &a, &b), [0.5, -1.0]);
        assert_eq!(found.map(PictureMap::Flip, &a, &b), found.flip.map);
        let z = found.map(PictureMap::Z, &a, &b);
        assert!((z[0] - 1.0).abs() <= 1e-5 && (z[1] + 2.0).abs() <= 1e-5, "{z:?}");
    }

    #[test]
    fn other_sizes_and_parts_are_refused() {
        let a = picture([2, 1], &[1.0, 3.0], &[]);
        let refused = |b: &Picture| {
            compare_pictures(&a, b, PIXELS_PER_DEGREE).expect_err("refused").to_string()
        };
        let message = refused(&picture([1, 2], &[1.0, 3.0], &[]));
        assert!(message.contains("2 x 1 pixels against 1 x 2"), "{message}");
        let message = refused(&Picture { part: Some(([3, 4], [8, 6])), ..a.clone() });
        assert!(message.contains("against the part from pixel (3, 4) of 8 x 6"), "{message}");
    }
}
