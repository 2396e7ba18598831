//! `OpenEXR` images of named f32 channels with attributes, ZIP-compressed.
//!
//! The unnamed main layer R, G, B is what viewers show; further layers prefix their channels
//! (`stderr.Y`, `direct.R`), as the `OpenEXR` technical introduction asks. Luminance has a layer of
//! its own within that of the colour (`luminance.Y`, `direct.luminance.Y`): beside R, G and B a
//! channel Y would make `OpenEXR`'s RGBA interface show it alone, grey. `chromaticities` say what
//! R, G and B are. Equal images give equal bytes.

mod decode;
mod encode;

use std::collections::BTreeMap;
use std::io::{self, BufWriter, Cursor};
use std::path::Path;

use exr::image::{AnyChannel, AnyChannels, Blocks, Encoding, Image, Layer};
use exr::math::Vec2;
use exr::meta::attribute::{
    AttributeValue, Chromaticities, Compression, IntegerBounds, LineOrder, Text,
};
use exr::meta::header::LayerAttributes;
use exr::prelude::WritableImage;

use encode::{Rows, Samples, sort_attributes};

pub use encode::Computed;

use super::check_size;
use crate::io::input::Input;
use crate::io::output::{ReadWriteSeek, SOFTWARE};
use crate::math::Rgb;
use crate::{Error, Result};

/// Holds the value of one attribute.
#[derive(Debug, Clone, PartialEq)]
pub enum Attribute {
    /// A text, as UTF-8.
    Text(String),
    /// A number; write integers past 2^53 as text.
    Number(f64),
    /// A matrix of four rows.
    Matrix([[f32; 4]; 4]),
}

/// Returns the names of the channels R, G, B and luminance, `luminance.Y`, of the main layer ("")
/// or of a named one.
pub fn colour_channels(layer: &str) -> [String; 4] {
    COLOUR.map(|(channel, _)| channel_name(layer, channel))
}

/// Returns the samples of [`colour_channels`] of a pixel.
pub fn colour_samples(pixel: Rgb) -> [f32; 4] {
    COLOUR.map(|(_, value)| value(&pixel) as f32)
}

type ValueOf = fn(&Rgb) -> f64;

/// The channels of a colour.
const COLOUR: [(&str, ValueOf); 4] =
    [("R", |p| p.0[0]), ("G", |p| p.0[1]), ("B", |p| p.0[2]), (LUMINANCE, |p| p.luminance())];

/// The channel of luminance, and its name in files that other programs, or this one formerly,
/// wrote.
const LUMINANCE: &str = "luminance.Y";
const PLAIN_LUMINANCE: &str = "Y";

/// Rec. 709: its primaries and D65, white.
const REC_709: Chromaticities = Chromaticities {
    red: Vec2(0.64, 0.33),
    green: Vec2(0.30, 0.60),
    blue: Vec2(0.15, 0.06),
    white: Vec2(0.3127, 0.3290),
};

impl From<&str> for Attribute {
    fn from(text: &str) -> Self {
        Self::Text(text.to_owned())
    }
}

impl From<String> for Attribute {
    fn from(text: String) -> Self {
        Self::Text(text)
    }
}

impl From<f64> for Attribute {
    fn from(number: f64) -> Self {
        Self::Number(number)
    }
}

/// Holds named channels of equal size, row by row from the top left, and attributes.
///
/// ```
/// use harmolux::io::images::Exr;
/// use harmolux::math::Rgb;
///
/// let image = Exr::new(2, 1)
///     .with_colour("", &[Rgb::WHITE, Rgb::grey(0.5)])?
///     .with_values("stderr.Y", &[0.01, 0.02])?
///     .with_attribute("seed", "42");
/// let read = Exr::from_bytes("view.exr".as_ref(), &image.to_bytes()?)?;
/// assert_eq!(read.channel("luminance.Y"), Some([1.0, 0.5].as_slice()));
/// # Ok::<(), harmolux::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Exr {
    width: usize,
    height: usize,
    /// Where its first pixel is in the whole picture, column and row.
    origin: [i32; 2],
    /// The size of the whole picture, where it is more.
    whole: Option<[usize; 2]>,
    channels: BTreeMap<String, Vec<f32>>,
    attributes: BTreeMap<String, Attribute>,
}

impl Exr {
    /// Starts an image of `width` x `height` pixels without channels; its `software` attribute
    /// names this program.
    pub fn new(width: usize, height: usize) -> Self {
        let attributes = BTreeMap::from([("software".to_owned(), SOFTWARE.into())]);
        Self { width, height, origin: [0, 0], whole: None, channels: BTreeMap::new(), attributes }
    }

    /// Makes it a part of a picture of `whole` columns and rows, its first pixel being at the
    /// column and row `origin` there: the data window within the display window.
    #[must_use]
    pub fn within(mut self, whole: [u32; 2], origin: [u32; 2]) -> Self {
        self.origin = origin.map(|n| i32::try_from(n).unwrap_or(i32::MAX));
        self.whole = Some(whole.map(|n| n as usize));
        self
    }

    /// Adds R, G, B and the luminance, `luminance.Y`, of linear Rec. 709 `pixels`, in the main
    /// layer ("") or in a named one.
    ///
    /// # Errors
    /// [`Error::Parameter`] when the number of pixels does not fit the size, or a channel of that
    /// name is there already.
    pub fn with_colour(self, layer: &str, pixels: &[Rgb]) -> Result<Self> {
        COLOUR.into_iter().try_fold(self, |exr, (channel, value)| {
            let samples = pixels.iter().map(|p| value(p) as f32).collect();
            exr.with_samples(&channel_name(layer, channel), samples)
        })
    }

    /// Adds one channel; `name` is `LAYER.CHANNEL`, as `stderr.Y`. NaN and infinities are stored as
    /// they are.
    ///
    /// # Errors
    /// As [`Exr::with_colour`].
    pub fn with_values(self, name: &str, values: &[f64]) -> Result<Self> {
        self.with_samples(name, values.iter().map(|v| *v as f32).collect())
    }

    /// Adds one channel as it will be stored.
    ///
    /// # Errors
    /// As [`Exr::with_colour`].
    pub fn with_samples(mut self, name: &str, samples: Vec<f32>) -> Result<Self> {
        check_size(self.width, self.height, samples.len())?;
        if name.is_empty() || self.channels.insert(name.to_owned(), samples).is_some() {
            return Err(Error::Parameter(format!("`{name}` cannot name one more channel")));
        }
        Ok(self)
    }

    /// Adds or replaces an attribute: `scene`, `seed`, `estimator`, `replicates`, ... (`software`
    /// is set).
    pub fn with_attribute(mut self, name: &str, value: impl Into<Attribute>) -> Self {
        self.attributes.insert(name.to_owned(), value.into());
        self
    }

    /// Returns the width in pixels.
    pub const fn width(&self) -> usize {
        self.width
    }

    /// Returns the height in pixels.
    pub const fn height(&self) -> usize {
        self.height
    }

    /// Returns which part of a larger picture it is: the column and row of its first pixel there,
    /// and the columns and rows of the whole; `None` for a whole picture.
    pub fn part(&self) -> Option<([i32; 2], [usize; 2])> {
        self.whole.map(|whole| (self.origin, whole))
    }

    /// Returns the samples of a channel; `None` when there is no such channel.
    pub fn channel(&self, name: &str) -> Option<&[f32]> {
        self.channels.get(name).map(Vec::as_slice)
    }

    /// Returns the samples of a channel, of a luminance under either name: `luminance.Y` finds `Y`
    /// and `direct.Y` finds `direct.luminance.Y`.
    pub fn find(&self, name: &str) -> Option<&[f32]> {
        let renamed = || match name.strip_suffix(LUMINANCE) {
            Some(layer) => Some(format!("{layer}{PLAIN_LUMINANCE}")),
            None => Some(format!("{}{LUMINANCE}", name.strip_suffix(PLAIN_LUMINANCE)?)),
        };
        self.channel(name).or_else(|| self.channel(&renamed()?))
    }

    /// Returns the luminance of the main layer: its own channel, or that of R, G and B; `None` when
    /// there is neither.
    pub fn luminance(&self) -> Option<Vec<f64>> {
        if let Some(samples) = self.find(LUMINANCE) {
            return Some(samples.iter().copied().map(f64::from).collect());
        }
        Some(self.colours()?.into_iter().map(Rgb::luminance).collect())
    }

    /// Returns R, G and B of the main layer; `None` when one of them is not there.
    pub fn colours(&self) -> Option<Vec<Rgb>> {
        let [r, g, b] = ["R", "G", "B"].map(|c| self.channel(c));
        let pixels = r?.iter().zip(g?).zip(b?);
        Some(pixels.map(|((r, g), b)| Rgb([*r, *g, *b].map(f64::from))).collect())
    }

    /// Returns the channel names in alphabetical order.
    pub fn channel_names(&self) -> impl Iterator<Item = &str> {
        self.channels.keys().map(String::as_str)
    }

    /// Returns an attribute; `None` when there is none of that name.
    pub fn attribute(&self, name: &str) -> Option<&Attribute> {
        self.attributes.get(name)
    }

    /// Encodes the image.
    ///
    /// # Errors
    /// [`Error::Parameter`] when there is no channel; [`Error::Numeric`] with the encoder's
    /// complaint.
    pub fn to_bytes(&self) -> Result<Vec<u8>> {
        let mut bytes = Cursor::new(Vec::new());
        self.write(&Computed::default(), &mut bytes).map_err(|e| match e.kind() {
            io::ErrorKind::InvalidInput => Error::Parameter(e.to_string()),
            _ => Error::Numeric(e.to_string()),
        })?;
        Ok(bytes.into_inner())
    }

    /// Writes the image, with computed channels more, some rows at a time: it needs no memory beyond
    /// that of the stored channels. The file begins where `to` does.
    ///
    /// # Errors
    /// [`io::ErrorKind::InvalidInput`] when there is no channel, or one twice; what `to` refuses,
    /// or the encoder's complaint.
    pub fn write(&self, computed: &Computed, to: &mut dyn ReadWriteSeek) -> io::Result<()> {
        let rows = Rows::new(computed, [self.width, self.height]);
        let stored = self.channels.iter().map(|(name, samples)| (name, Samples::Stored(samples)));
        let names = computed.names.iter().enumerate();
        let computed = names.map(|(channel, name)| (name, Samples::Computed(&rows, channel)));
        let mut channels: Vec<_> = stored.chain(computed).collect();
        channels.sort_by_key(|(name, _)| *name);
        let refuse = |why: &str| Err(io::Error::new(io::ErrorKind::InvalidInput, why.to_owned()));
        if channels.is_empty() {
            return refuse("an image needs at least one channel");
        }
        if let Some(twice) = channels.windows(2).find(|pair| pair[0].0 == pair[1].0) {
            return refuse(&format!("`{}` cannot name two channels", twice[0].0));
        }
        let channels = channels.into_iter().map(|(name, s)| AnyChannel::new(text(name), s));
        let encoding = Encoding {
            compression: Compression::ZIP16,
            blocks: Blocks::ScanLines,
            line_order: LineOrder::Increasing,
        };
        let layer = Layer::new(
            (self.width, self.height),
            self.layer_attributes(),
            encoding,
            AnyChannels::sort(channels.collect()),
        );
        let mut image = Image::from_layer(layer);
        let whole = self.whole.unwrap_or([self.width, self.height]);
        image.attributes.display_window = IntegerBounds::from_dimensions((whole[0], whole[1]));
        image.attributes.chromaticities = Some(REC_709);
        image.write().to_buffered(BufWriter::new(&mut *to)).map_err(|e| match e {
            exr::error::Error::Io(e) => e,
            e => io::Error::other(format!("the EXR encoder failed: {e}")),
        })?;
        sort_attributes(to)
    }

    fn layer_attributes(&self) -> LayerAttributes {
        let values = self.attributes.iter().map(|(name, value)| match value {
            Attribute::Text(value) => (text(name), AttributeValue::Text(text(value))),
            Attribute::Number(value) => (text(name), AttributeValue::F64(*value)),
            Attribute::Matrix(rows) => (text(name), AttributeValue::Matrix4x4(flat(rows))),
        });
        let mut attributes = LayerAttributes { other: values.collect(), ..Default::default() };
        attributes.layer_position = Vec2(self.origin[0], self.origin[1]);
        // All numbers are cd/m2, one of which is therefore the luminance of white.
        attributes.white_luminance = Some(1.0);
        // The crate knows these by fields of their own and takes them nowhere else.
        if let Some(AttributeValue::Matrix4x4(m)) = attributes.other.remove(&text(TO_CAMERA)) {
            attributes.world_to_camera = Some(m);
        }
        if let Some(AttributeValue::Text(software)) = attributes.other.remove(&text("software")) {
            attributes.software_name = Some(software);
        }
        attributes
    }

    /// Reads an EXR file of one flat layer, ours or another's: all its channels, and its text and
    /// number attributes.
    ///
    /// # Errors
    /// [`Error::Io`] when the file cannot be read, [`Error::Input`] when it is not such an image.
    pub fn read(path: &Path) -> Result<Self> {
        Self::from_bytes(path, &Input::open(path)?.rest()?)
    }
}

/// The attribute of the matrix from the room to the camera.
const TO_CAMERA: &str = "worldToCamera";

fn flat(rows: &[[f32; 4]; 4]) -> [f32; 16] {
    std::array::from_fn(|k| rows[k / 4][k % 4])
}

fn channel_name(layer: &str, channel: &str) -> String {
    if layer.is_empty() { channel.to_owned() } else { format!("{layer}.{channel}") }
}

/// Wraps UTF-8 as it is; the crate's own conversion panics beyond Latin-1.
fn text(value: &str) -> Text {
    Text::from_slice_unchecked(value.as_bytes())
}

fn string(value: &Text) -> String {
    String::from_utf8_lossy(value.as_slice()).into_owned()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::io::failing;
    use crate::io::output::{Kind, Output};
    use crate::memory;
    use ::exr::meta::MetaData;

    fn pixels() -> Vec<Rgb> {
        (0..6).map(|i| Rgb([f64::from(i), 0.1, 1e-3 * f64::from(i * i)])).collect()
    }

    fn image() -> Exr {
        Exr::new(3, 2)
            .with_colour("", &pixels())
            .and_then(|e| e.with_values("stderr.Y", &[0.1, 0.2, 0.3, 0.4, 0.5, 0.6]))
            .expect("fits")
            .with_attribute("scene", "salle à manger.toml")
            .with_attribute("seed", u64::MAX.to_string())
            .with_attribute("replicates", 32.0)
            .with_attribute("estimator", "double-local")
    }

    #[test]
    fn empty_and_misshapen_images_are_refused() {
        assert!(Exr::new(1, 1).to_bytes().is_err());
        assert!(Exr::new(0, 0).with_colour("", &[]).is_err());
        assert!(Exr::new(2, 2).with_values("Z", &[0.0; 3]).is_err());
        assert!(image().with_colour("", &pixels()).is_err());
        assert!(image().with_values("", &[0.0; 6]).is_err());
    }

    #[test]
    fn image_comes_back_to_the_last_bit_of_f32() {
        let written = image();
        let bytes = written.to_bytes().expect("encoded");
        let read = Exr::from_bytes(Path::new("x.exr"), &bytes).expect("decoded");
        assert_eq!(read, written);
        assert_eq!((read.width(), read.height()), (3, 2));
        // A root of R, G, B alone: with a Y there OpenEXR's RGBA interface takes the file for a
        // grey one.
        assert!(read.channel_names().eq(["B", "G", "R", "luminance.Y", "stderr.Y"]));
        let luminance: Vec<f32> = pixels().iter().map(|p| p.luminance() as f32).collect();
        assert_eq!(read.channel("luminance.Y"), Some(luminance.as_slice()));
        assert_eq!(read.attribute("replicates"), Some(&Attribute::Number(32.0)));
        assert_eq!(read.attribute("software"), Some(&SOFTWARE.into()));
        assert_eq!(read.attribute("seed"), Some(&u64::MAX.to_string().into()));
        assert_eq!((read.channel("Z"), read.attribute("author")), (None, None));
    }

    #[test]
    fn every_failed_write_is_told() {
        let writes = failing::in_turn(&Kind::EXR, "exr", &mut |file| {
            image().write(&Computed::default(), file)
        });
        assert!(writes > 5, "{writes}");
    }

    #[test]
    fn a_picture_that_does_not_fit_is_refused_before_it_is_decoded() {
        let bytes = image().to_bytes().expect("encoded");
        let read = || Exr::from_bytes(Path::new("x.exr"), &bytes);
        assert_eq!(memory::faults::in_turn(read), 1);
    }

    #[test]
    fn computed_channels_are_written_as_stored_ones() {
        let pixels = pixels();
        let mut names = Vec::from(colour_channels("direct"));
        names.push("Z".to_owned());
        let light = Computed::new(names, |i, values| {
            values[..4].copy_from_slice(&colour_samples(pixels[i]));
            values[4] = i as f32;
        });
        let mut bytes = Cursor::new(Vec::new());
        image().write(&light, &mut bytes).expect("written");
        let stored = image().with_colour("direct", &pixels).expect("fits");
        let stored = stored.with_values("Z", &[0.0, 1.0, 2.0, 3.0, 4.0, 5.0]).expect("fits");
        assert_eq!(bytes.into_inner(), stored.to_bytes().expect("encoded"));
        let twice = Computed::new(vec!["R".to_owned()], |_, values| values[0] = 0.0);
        let refused = image().write(&twice, &mut Cursor::new(Vec::new())).expect_err("refused");
        assert_eq!(refused.to_string(), "`R` cannot name two channels");
    }

    #[test]
    fn equal_images_give_equal_bytes() {
        let bytes = image().to_bytes().expect("encoded");
        assert!((0..5).all(|_| image().to_bytes().is_ok_and(|again| again == bytes)));
    }

    #[test]
    fn part_of_a_picture_says_where_it_belongs_and_who_saw_it() {
        let rows = std::array::from_fn(|r| std::array::from_fn(|c| (4 * r + c) as f32));
        let part = image()
            .within([640, 480], [100, 50])
            .with_attribute(TO_CAMERA, Attribute::Matrix(rows));
        let bytes = part.to_bytes().expect("encoded");
        let meta = MetaData::read_from_buffered(bytes.as_slice(), false).expect("a header");
        let header = &meta.headers[0];
        assert_eq!(header.own_attributes.layer_position, Vec2(100, 50));
        assert_eq!(header.layer_size, Vec2(3, 2));
        assert_eq!(header.shared_attributes.display_window.size, Vec2(640, 480));
        assert_eq!(header.own_attributes.white_luminance, Some(1.0));
        let primaries = header.shared_attributes.chromaticities.expect("written");
        assert_eq!((primaries.red, primaries.white), (Vec2(0.64, 0.33), Vec2(0.3127, 0.3290)));
        let read = Exr::from_bytes(Path::new("x.exr"), &bytes).expect("decoded");
        assert_eq!((&read, read.part()), (&part, Some(([100, 50], [640, 480]))));
        assert_eq!(image().part(), None);
    }

    #[test]
    fn what_is_not_finite_stays_so() {
        let values = [f64::NAN, f64::INFINITY, -1.0, 1e300];
        let bytes = Exr::new(4, 1).with_values("Y", &values).and_then(|e| e.to_bytes());
        let read = Exr::from_bytes(Path::new("x.exr"), &bytes.expect("encoded")).expect("decoded");
        let samples = read.channel("Y").expect("there");
        assert!(samples[0].is_nan() && samples[1..] == [f32::INFINITY, -1.0, f32::INFINITY]);
    }

    #[test]
    fn further_colour_layers_are_prefixed() {
        let image = image().with_colour("direct", &pixels()).expect("fits");
        let bytes = image.to_bytes().expect("encoded");
        let read = Exr::from_bytes(Path::new("x.exr"), &bytes).expect("decoded");
        assert_eq!(read.channel("direct.R"), image.channel("R"));
        let own = |name: &&str| name.strip_prefix("direct.").is_some_and(|c| !c.contains('.'));
        assert!(read.channel_names().filter(own).eq(["direct.B", "direct.G", "direct.R"]));
        assert_eq!(read.find("direct.Y"), read.channel("direct.luminance.Y"));
    }

    #[test]
    fn luminance_is_found_under_its_old_name_and_from_colours() {
        let expected: Vec<f64> = pixels().iter().map(|p| f64::from(p.luminance() as f32)).collect();
        let single = Exr::new(3, 2).with_values("Y", &expected).expect("fits");
        for (name, found) in [("luminance.Y", true), ("Y", true), ("Z", false), ("direct.Y", false)]
        {
            assert_eq!(single.find(name).is_some(), found, "{name}");
        }
        assert_eq!(single.luminance(), Some(expected.clone()));
        assert_eq!(image().luminance(), Some(expected.clone()));
        let (r, g, b) = (image(), image(), image());
        let colours = [("R", r), ("G", g), ("B", b)]
            .into_iter()
            .try_fold(Exr::new(3, 2), |exr, (name, from)| {
                exr.with_samples(name, from.channel(name).expect("there").to_vec())
            });
        let found = colours.expect("fits").luminance().expect("of R, G and B");
        assert!(found.iter().zip(&expected).all(|(a, b)| (a - b).abs() <= 1e-6 * (1.0 + b)));
        assert_eq!(Exr::new(3, 2).luminance(), None);
    }

    #[test]
    fn larger_image_with_many_blocks_comes_back() {
        let values: Vec<f64> = (0..150 * 101).map(|i| f64::from(i).sin()).collect();
        let image = Exr::new(150, 101).with_values("Y", &values).expect("fits");
        let bytes = image.to_bytes().expect("encoded");
        assert_eq!(Exr::from_bytes(Path::new("x.exr"), &bytes).expect("decoded"), image);
    }

    #[test]
    fn broken_files_are_refused() {
        let bytes = image().to_bytes().expect("encoded");
        for broken in
            [&b""[..], b"not an image", &bytes[..7], &bytes[..60], &bytes[..bytes.len() - 9]]
        {
            let error = Exr::from_bytes(Path::new("x.exr"), broken).expect_err("refused");
            assert!(error.to_string().starts_with("x.exr: this is not a readable EXR image"));
        }
        assert!(matches!(Exr::read(Path::new("/no/such.exr")), Err(Error::Io { .. })));
    }

    #[test]
    fn size_that_the_bytes_cannot_hold_is_refused_before_memory_is_taken() {
        let mut bytes = image().to_bytes().expect("encoded");
        for name in [&b"dataWindow\0box2i\0"[..], b"displayWindow\0box2i\0"] {
            let at = bytes.windows(name.len()).position(|w| w == name).expect("there");
            // After name, type and length: x_min, y_min, x_max, y_max.
            let upper = at + name.len() + 4 + 8;
            for corner in [upper, upper + 4] {
                bytes[corner..corner + 4].copy_from_slice(&1_000_000_i32.to_le_bytes());
            }
        }
        let message = Exr::from_bytes(Path::new("x.exr"), &bytes).expect_err("refused").to_string();
        assert!(message.contains("cannot hold 1000001 x 1000001 pixels"), "{message}");
    }

    #[test]
    fn file_is_known_again_however_long_its_attributes() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("view.exr");
        let bytes =
            image().with_attribute("comment", "x".repeat(5000)).to_bytes().expect("encoded");
        let open = || Output::open_again(&path, &Kind::EXR, false);
        for _ in 0..2 {
            open().expect("free, then ours").write(&bytes).expect("written");
        }
        let foreign = image().with_attribute("software", "another").to_bytes().expect("encoded");
        std::fs::write(&path, foreign).expect("written");
        assert!(open().is_err());
        assert_eq!(
            Exr::read(&path).expect("readable").attribute("software"),
            Some(&"another".into())
        );
    }
}
