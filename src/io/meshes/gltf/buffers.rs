//! The buffers of a glTF file, and the numbers that its accessors find in them.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::path::{Component, Path, PathBuf};

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use glam::DVec3;

use super::document::{Accessor, Document};
use super::{broken, item};
use crate::Result;
use crate::io::bytes::field;
use crate::io::meshes::source::Source;

/// Holds the bytes of all buffers, each file once.
pub(super) struct Buffers<'a> {
    /// Where the bytes of each buffer are.
    places: Vec<Place<'a>>,
    files: BTreeMap<PathBuf, Vec<u8>>,
}

enum Place<'a> {
    Inside(Cow<'a, [u8]>),
    File(PathBuf),
}

impl<'a> Buffers<'a> {
    /// Loads what the document names; `binary` is the second chunk of a binary file.
    pub(super) fn load(
        source: &mut Source,
        document: &Document,
        binary: Option<&'a [u8]>,
    ) -> Result<Self> {
        let mut all = Self { places: Vec::new(), files: load_files(source, document)? };
        for (index, buffer) in document.buffers.iter().enumerate() {
            let place = match (&buffer.uri, binary) {
                (None, Some(bytes)) if index == 0 => Place::Inside(Cow::Borrowed(bytes)),
                (None, _) => return Err(broken(source, format!("buffer {index} has no content"))),
                (Some(uri), _) if is_data(uri) => {
                    Place::Inside(Cow::Owned(decoded(source, index, uri)?))
                }
                (Some(uri), _) => Place::File(beside(source, uri)?),
            };
            all.places.push(place);
            let found = all.bytes(index).len();
            if found < buffer.byte_length {
                let message =
                    format!("buffer {index} has {found} bytes instead of {}", buffer.byte_length);
                return Err(broken(source, message));
            }
        }
        Ok(all)
    }

    /// Returns how many bytes came from other files.
    pub(super) fn outside(&self) -> u64 {
        self.files.values().map(|bytes| bytes.len() as u64).sum()
    }

    fn bytes(&self, buffer: usize) -> &[u8] {
        match &self.places[buffer] {
            Place::Inside(bytes) => bytes,
            Place::File(path) => self.files.get(path).map_or(&[], Vec::as_slice),
        }
    }

    /// Returns the items of an accessor: as many bytes apart, each of `components` numbers.
    fn items<'s>(
        &'s self,
        source: &Source,
        document: &'s Document,
        index: usize,
        components: usize,
    ) -> Result<Items<'s>> {
        let accessor = item(source, &document.accessors, index, "accessor")?;
        let wrong = |what: &str| broken(source, format!("accessor {index} {what}"));
        let width = width(accessor.component_type)
            .ok_or_else(|| wrong("has numbers of an unknown type"))?;
        if accessor.sparse.is_some() || accessor.buffer_view.is_none() {
            let message = format!("accessor {index} is sparse or without data");
            return Err(source.fault(message, "export the mesh with whole buffers"));
        }
        let view =
            item(source, &document.buffer_views, accessor.buffer_view.unwrap_or(0), "buffer view")?;
        item(source, &document.buffers, view.buffer, "buffer")?;
        let size = width * components;
        let stride = view.byte_stride.unwrap_or(size);
        let needed = accessor
            .count
            .checked_sub(1)
            .map_or(Some(0), |n| n.checked_mul(stride)?.checked_add(size));
        let end = view.byte_offset.checked_add(view.byte_length);
        let bytes = end.and_then(|end| self.bytes(view.buffer).get(view.byte_offset..end));
        let bytes = bytes
            .and_then(|b| b.get(accessor.byte_offset..))
            .zip(needed)
            .and_then(|(b, n)| b.get(..n));
        match bytes {
            Some(bytes) if stride >= size => Ok(Items { bytes, stride, width, accessor }),
            Some(_) => Err(wrong("has items that overlap")),
            None => Err(wrong(&format!("has {} items, more than its buffer", accessor.count))),
        }
    }

    /// Reads positions: three f32 each, or quantised.
    pub(super) fn positions(
        &self,
        source: &Source,
        document: &Document,
        index: usize,
    ) -> Result<Vec<DVec3>> {
        let items = self.items(source, document, index, 3)?;
        if items.accessor.kind != "VEC3" {
            return Err(broken(
                source,
                format!("accessor {index} of positions is {}", items.accessor.kind),
            ));
        }
        let number = |b: &[u8]| real(items.accessor, b);
        let position = |b: &[u8]| {
            let [x, y, z] = [0, 1, 2].map(|i| number(&b[i * items.width..(i + 1) * items.width]));
            DVec3::new(x, y, z)
        };
        Ok(items.iter().map(position).collect())
    }

    /// Reads the numbers of vertices.
    pub(super) fn indices(
        &self,
        source: &Source,
        document: &Document,
        index: usize,
    ) -> Result<Vec<u32>> {
        let items = self.items(source, document, index, 1)?;
        let is_whole = matches!(items.accessor.component_type, U8 | U16 | U32);
        if items.accessor.kind != "SCALAR" || !is_whole {
            return Err(broken(
                source,
                format!("accessor {index} of indices holds no whole numbers"),
            ));
        }
        let whole = |b: &[u8]| b.iter().rev().fold(0_u32, |n, &byte| n << 8 | u32::from(byte));
        Ok(items.iter().map(whole).collect())
    }
}

struct Items<'a> {
    bytes: &'a [u8],
    stride: usize,
    /// The bytes of one number.
    width: usize,
    accessor: &'a Accessor,
}

impl<'a> Items<'a> {
    fn iter(&self) -> impl Iterator<Item = &'a [u8]> {
        self.bytes.chunks(self.stride)
    }
}

const I8: u32 = 5120;
const U8: u32 = 5121;
const I16: u32 = 5122;
const U16: u32 = 5123;
const U32: u32 = 5125;
const F32: u32 = 5126;

fn width(component: u32) -> Option<usize> {
    match component {
        I8 | U8 => Some(1),
        I16 | U16 => Some(2),
        U32 | F32 => Some(4),
        _ => None,
    }
}

/// Reads one number; integers of normalised accessors reach from 0 or -1 to 1.
fn real(accessor: &Accessor, b: &[u8]) -> f64 {
    let (value, largest) = match accessor.component_type {
        I8 => (f64::from(field::<i8>(b, 0)), 127.0),
        U8 => (f64::from(b[0]), 255.0),
        I16 => (f64::from(field::<i16>(b, 0)), 32_767.0),
        U16 => (f64::from(field::<u16>(b, 0)), 65_535.0),
        U32 => (f64::from(field::<u32>(b, 0)), 4_294_967_295.0),
        _ => return f64::from(field::<f32>(b, 0)),
    };
    if accessor.normalized { (value / largest).max(-1.0) } else { value }
}

fn decoded(source: &Source, index: usize, uri: &str) -> Result<Vec<u8>> {
    let content = uri.split_once(";base64,").map(|(_, content)| STANDARD.decode(content));
    match content {
        Some(Ok(bytes)) => Ok(bytes),
        Some(Err(e)) => Err(broken(source, format!("buffer {index} is no base64 text: {e}"))),
        None => Err(broken(source, format!("buffer {index} is a data URI without base64"))),
    }
}

/// Returns the path of a buffer beside the file. Only relative names that stay in its folder will
/// do.
fn beside(source: &Source, uri: &str) -> Result<PathBuf> {
    let name = percent_decoded(uri);
    let relative = Path::new(&name);
    let climbs = relative.components().any(|c| c == Component::ParentDir);
    if name.contains(':') || relative.is_absolute() || relative.has_root() || climbs {
        let message = format!("the buffer `{uri}` is not beside the file");
        return Err(
            source.fault(message, "put the buffer in the folder of the file, or export as .glb")
        );
    }
    Ok(source.path().parent().unwrap_or(Path::new("")).join(relative))
}

fn percent_decoded(uri: &str) -> String {
    let bytes = uri.as_bytes();
    let mut decoded = Vec::with_capacity(bytes.len());
    let mut at = 0;
    while at < bytes.len() {
        let escaped = (bytes[at] == b'%').then(|| uri.get(at + 1..at + 3)).flatten();
        let byte = escaped.and_then(|hex| u8::from_str_radix(hex, 16).ok());
        decoded.push(byte.unwrap_or(bytes[at]));
        at += if byte.is_some() { 3 } else { 1 };
    }
    String::from_utf8_lossy(&decoded).into_owned()
}

/// Whether a buffer stands in the document itself.
fn is_data(uri: &str) -> bool {
    uri.starts_with("data:")
}

/// Reads the files beside the document, each once, as far as the longest of its buffers goes.
fn load_files(source: &mut Source, document: &Document) -> Result<BTreeMap<PathBuf, Vec<u8>>> {
    let mut lengths: BTreeMap<PathBuf, usize> = BTreeMap::new();
    for buffer in &document.buffers {
        if let Some(uri) = buffer.uri.as_deref().filter(|uri| !is_data(uri)) {
            let longest = lengths.entry(beside(source, uri)?).or_default();
            *longest = buffer.byte_length.max(*longest);
        }
    }
    let load = |(path, length): (PathBuf, usize)| {
        let bytes = source.read_beside(&path, length as u64)?;
        Ok((path, bytes))
    };
    lengths.into_iter().map(load).collect()
}
