//! Pictures from the bytes of EXR files.

use std::collections::BTreeMap;
use std::io::Cursor;
use std::path::Path;

use exr::image::FlatSamples;
use exr::image::read::read as reader;
use exr::math::Vec2;
use exr::meta::MetaData;
use exr::meta::attribute::AttributeValue;
use exr::meta::header::LayerAttributes;
use exr::prelude::{ReadChannels, ReadLayers};

use super::{Attribute, Exr, TO_CAMERA, string};
use crate::error::{InputError, shown_path};
use crate::{Error, Result, memory};

impl Exr {
    /// Decodes the bytes of an EXR file; `path` is for messages.
    ///
    /// # Errors
    /// [`Error::Input`] when they are not an image of one flat layer.
    pub fn from_bytes(path: &Path, bytes: &[u8]) -> Result<Self> {
        let refuse = |e: exr::error::Error| {
            Error::from(InputError::new(path, format!("this is not a readable EXR image: {e}")))
        };
        check_header(path, &MetaData::read_from_buffered(bytes, false).map_err(refuse)?, bytes)?;
        let image = reader()
            .no_deep_data()
            .largest_resolution_level()
            .all_channels()
            .first_valid_layer()
            .all_attributes()
            .from_buffered(Cursor::new(bytes))
            .map_err(refuse)?;
        let display = image.attributes.display_window;
        let layer = image.layer_data;
        let channels = layer.channel_data.list.into_iter();
        let Vec2(x, y) = layer.attributes.layer_position;
        let is_whole =
            layer.attributes.layer_position == display.position && layer.size == display.size;
        Ok(Self {
            width: layer.size.0,
            height: layer.size.1,
            origin: [x, y],
            whole: (!is_whole).then_some([display.size.0, display.size.1]),
            channels: channels.map(|c| (string(&c.name), values(c.sample_data))).collect(),
            attributes: attributes_of(&layer.attributes),
        })
    }
}

/// Returns samples as they are kept, those of four bytes without a copy.
fn values(samples: FlatSamples) -> Vec<f32> {
    match samples {
        FlatSamples::F32(values) => values,
        other => other.values_as_f32().collect(),
    }
}

fn attributes_of(layer: &LayerAttributes) -> BTreeMap<String, Attribute> {
    let software = layer.software_name.iter().map(|s| ("software".to_owned(), string(s).into()));
    let others = layer.other.iter().filter_map(|(name, value)| {
        let value = match value {
            AttributeValue::Text(value) => Attribute::Text(string(value)),
            AttributeValue::F64(value) => Attribute::Number(*value),
            AttributeValue::F32(value) => Attribute::Number(f64::from(*value)),
            AttributeValue::I32(value) => Attribute::Number(f64::from(*value)),
            _ => return None,
        };
        Some((string(name), value))
    });
    let matrix = layer.world_to_camera.map(|m| {
        let row = |r: usize| std::array::from_fn(|c| m[4 * r + c]);
        (TO_CAMERA.to_owned(), Attribute::Matrix(std::array::from_fn(row)))
    });
    software.chain(matrix).chain(others).collect()
}

/// Rejects what the decoder would not survive or not show as it is: several or subsampled layers,
/// and sizes that the bytes cannot hold.
fn check_header(path: &Path, meta: &MetaData, bytes: &[u8]) -> Result<()> {
    // Deflate packs at most 1032 to 1; the other methods stay far below.
    const DENSEST: usize = 1032;
    let refuse = |message: String| Err(InputError::new(path, message).into());
    let [header] = meta.headers.as_slice() else {
        return refuse(format!("{} layers, where one is expected", meta.headers.len()));
    };
    if header.channels.list.iter().any(|c| c.sampling.0 != 1 || c.sampling.1 != 1) {
        return refuse("subsampled channels cannot be compared pixel by pixel".to_owned());
    }
    let Vec2(width, height) = header.layer_size;
    let needed = width.saturating_mul(height).saturating_mul(header.channels.bytes_per_pixel);
    if needed > bytes.len().saturating_mul(DENSEST) {
        return refuse(format!("{} bytes cannot hold {width} x {height} pixels", bytes.len()));
    }
    // The bytes as decoded, and as they are kept.
    let kept = width as f64 * height as f64 * (4 * header.channels.list.len()) as f64;
    let name = format!("{}: a picture of {width} x {height} pixels", shown_path(path));
    memory::ask(needed as f64 + kept, name, |share| {
        format!("about {:.0} % of it would fit; take a part of the picture", 100.0 * share)
    })
}
