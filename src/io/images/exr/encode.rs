//! How channels and attributes are written: line by line, and in an order of their own.

use std::io::{self, Read, SeekFrom};
use std::ops::Range;
use std::sync::{Mutex, PoisonError};

use exr::block::lines::LineRefMut;
use exr::image::write::samples::{SamplesWriter, WritableSamples};
use exr::math::{RoundingMode, Vec2};
use exr::meta::attribute::{LevelMode, SampleType};
use exr::meta::header::Header;
use rayon::prelude::*;

use crate::io::bytes::number_at;
use crate::io::output::ReadWriteSeek;

/// How many rows of computed channels are made at a time.
const ROWS: usize = 64;

/// Holds channels that are computed when the image is written.
#[derive(Default)]
pub struct Computed<'a> {
    pub(super) names: Vec<String>,
    of_pixel: Option<OfPixel<'a>>,
}

type OfPixel<'a> = Box<dyn Fn(usize, &mut [f32]) + Sync + 'a>;

impl<'a> Computed<'a> {
    /// Names channels, `LAYER.CHANNEL`, and says what puts down their values of a pixel, counted
    /// row by row from the top left.
    pub fn new(names: Vec<String>, of_pixel: impl Fn(usize, &mut [f32]) + Sync + 'a) -> Self {
        Self { names, of_pixel: Some(Box::new(of_pixel)) }
    }
}

/// Computes the channels, some rows at a time on all threads: the encoder asks for line after line
/// of channel after channel, on one.
pub(super) struct Rows<'a> {
    computed: &'a Computed<'a>,
    size: [usize; 2],
    /// The rows that are made, and the values of their pixels.
    made: Mutex<(Range<usize>, Vec<f32>)>,
}

impl<'a> Rows<'a> {
    pub(super) fn new(computed: &'a Computed<'a>, size: [usize; 2]) -> Self {
        Self { computed, size, made: Mutex::new((0..0, Vec::new())) }
    }

    /// Puts down a line of a channel.
    fn write(&self, channel: usize, line: LineRefMut) -> exr::error::UnitResult {
        let Vec2(x, y) = line.location.position;
        let [width, height] = self.size;
        let each = self.computed.names.len();
        let mut made = self.made.lock().unwrap_or_else(PoisonError::into_inner);
        let (rows, values) = &mut *made;
        if !rows.contains(&y) {
            *rows = y..height.min(y + ROWS);
            values.resize(rows.len() * width * each, 0.0);
            if let Some(of_pixel) = &self.computed.of_pixel {
                let pixels = values.par_chunks_exact_mut(each).enumerate().with_min_len(1 << 10);
                pixels.for_each(|(i, values)| of_pixel(y * width + i, values));
            }
        }
        let first = (y - rows.start) * width + x;
        line.write_samples(|i| values[(first + i) * each + channel])
    }
}

/// Where samples come from when they are written.
pub(super) enum Samples<'a> {
    Stored(&'a [f32]),
    /// The channel of that number.
    Computed(&'a Rows<'a>, usize),
}

/// Writes them line by line.
pub(super) struct Lines<'a> {
    width: usize,
    samples: &'a Samples<'a>,
}

impl<'a> WritableSamples<'a> for Samples<'_> {
    type Writer = Lines<'a>;

    fn sample_type(&self) -> SampleType {
        SampleType::F32
    }

    fn infer_level_modes(&self) -> (LevelMode, RoundingMode) {
        (LevelMode::Singular, RoundingMode::Down)
    }

    fn create_samples_writer(&'a self, header: &Header) -> Lines<'a> {
        Lines { width: header.layer_size.0, samples: self }
    }
}

impl SamplesWriter for Lines<'_> {
    fn extract_line(&self, line: LineRefMut) {
        let Vec2(x, y) = line.location.position;
        let first = y * self.width + x;
        let written = match self.samples {
            Samples::Stored(samples) => line.write_samples(|i| samples[first + i]),
            Samples::Computed(rows, channel) => rows.write(*channel, line),
        };
        written.expect("a line is as long as what is written there");
    }
}

/// Puts the header's attributes in a fixed order, `software` first: the encoder takes them from a
/// hash map, so equal images would give different bytes and the mark of this program could stand
/// anywhere. The header keeps its length, so all offsets hold.
pub(super) fn sort_attributes(file: &mut dyn ReadWriteSeek) -> io::Result<()> {
    // The header follows 4 bytes of magic number and 4 of version, and ends with an empty name.
    const START: u64 = 8;
    let mut bytes = Vec::new();
    let mut attributes = loop {
        // As much again as there is, until the end of the header is in it.
        let more = (bytes.len() as u64).max(1 << 12);
        file.seek(SeekFrom::Start(START + bytes.len() as u64))?;
        let found = (&mut *file).take(more).read_to_end(&mut bytes)?;
        let mut attributes = Vec::new();
        let mut rest = bytes.as_slice();
        while let Some(length) = attribute_length(rest) {
            attributes.push(&rest[..length]);
            rest = &rest[length..];
        }
        if rest.first() == Some(&0) {
            break attributes.into_iter().map(<[u8]>::to_vec).collect::<Vec<_>>();
        }
        if found == 0 {
            return Err(io::Error::other("the EXR encoder wrote a header without an end"));
        }
    };
    attributes.sort_by_key(|a| (!a.starts_with(b"software\0"), a.clone()));
    file.seek(SeekFrom::Start(START))?;
    file.write_all(&attributes.concat())?;
    file.seek(SeekFrom::End(0)).map(drop)
}

/// Measures the attribute at the start of `bytes` (name, type, length, value); `None` at the end of
/// the header.
fn attribute_length(bytes: &[u8]) -> Option<usize> {
    let zero = |from: usize| Some(from + bytes.get(from..)?.iter().position(|b| *b == 0)?);
    let name = zero(0).filter(|end| *end > 0)?;
    let kind = zero(name + 1)?;
    let length = kind + 5 + number_at::<u32>(bytes, kind + 1)? as usize;
    (length <= bytes.len()).then_some(length)
}
