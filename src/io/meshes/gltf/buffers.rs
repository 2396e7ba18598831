//! The buffers of a glTF file, and the numbers that its accessors find in them.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::path::{Component, Path, PathBuf};

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use glam::DVec3;

use super::document::{Accessor, Document, Sparse};
use super::{broken, item};
use crate::io::bytes::field;
use crate::io::source::Source;
use crate::{Error, Result};

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

    /// Reads positions: three f32 each, or quantised. `most` bounds those without a buffer.
    pub(super) fn positions(
        &self,
        source: &Source,
        document: &Document,
        index: usize,
        most: u64,
    ) -> Result<Vec<DVec3>> {
        let accessor = item(source, &document.accessors, index, "accessor")?;
        if accessor.kind != "VEC3" {
            let message = format!("accessor {index} of positions is {}", accessor.kind);
            return Err(broken(source, message));
        }
        let reader = Accessed { buffers: self, source, document, index, accessor };
        let position = |b: &[u8]| {
            let [x, y, z] = [0, 1, 2].map(|i| real(accessor, &b[i * b.len() / 3..]));
            DVec3::new(x, y, z)
        };
        reader.values(3, most, position)
    }

    /// Reads the numbers of vertices. `most` bounds those without a buffer.
    pub(super) fn indices(
        &self,
        source: &Source,
        document: &Document,
        index: usize,
        most: u64,
    ) -> Result<Vec<u32>> {
        let accessor = item(source, &document.accessors, index, "accessor")?;
        if accessor.kind != "SCALAR" || !is_whole(accessor.component_type) {
            let message = format!("accessor {index} of indices holds no whole numbers");
            return Err(broken(source, message));
        }
        let reader = Accessed { buffers: self, source, document, index, accessor };
        reader.values(1, most, whole)
    }
}

/// An accessor that is being read.
struct Accessed<'s> {
    buffers: &'s Buffers<'s>,
    source: &'s Source<'s>,
    document: &'s Document<'s>,
    index: usize,
    accessor: &'s Accessor,
}

impl<'s> Accessed<'s> {
    fn broken(&self, what: &str) -> Error {
        broken(self.source, format!("accessor {} {what}", self.index))
    }

    /// Reads all values, each of so many numbers: those of its buffer, zeros where there is none,
    /// and in the place of some those of its sparse part.
    fn values<T: Clone + Default>(
        &self,
        components: usize,
        most: u64,
        decode: impl Fn(&[u8]) -> T,
    ) -> Result<Vec<T>> {
        let accessor = self.accessor;
        let size = components * self.width(accessor.component_type)?;
        let mut values = match accessor.buffer_view {
            Some(view) => {
                let items = self.items(view, accessor.byte_offset, accessor.count, size)?;
                items.map(&decode).collect()
            }
            None if accessor.sparse.is_none() => return Err(self.broken("has no data")),
            None if accessor.count as u64 > most => {
                return Err(self.broken(&format!(
                    "has {} items without a buffer, more than are read of such a file",
                    accessor.count
                )));
            }
            None => vec![T::default(); accessor.count],
        };
        let Some(Sparse { count, indices, values: others }) = &accessor.sparse else {
            return Ok(values);
        };
        let kind = indices.component_type.filter(|&kind| is_whole(kind));
        let kind = kind.ok_or_else(|| self.broken("has sparse indices that are none"))?;
        let width = self.width(kind)?;
        let places = self.items(indices.buffer_view, indices.byte_offset, *count, width)?;
        let others = self.items(others.buffer_view, others.byte_offset, *count, size)?;
        for (place, other) in places.map(whole).zip(others) {
            let place = values.get_mut(place as usize);
            *place.ok_or_else(|| self.broken("has a sparse index beyond its items"))? =
                decode(other);
        }
        Ok(values)
    }

    fn width(&self, kind: u32) -> Result<usize> {
        width(kind).ok_or_else(|| self.broken("has numbers of an unknown type"))
    }

    /// Returns items of `size` bytes in a buffer view.
    fn items(
        &self,
        view: usize,
        offset: usize,
        count: usize,
        size: usize,
    ) -> Result<impl Iterator<Item = &'s [u8]>> {
        let view = item(self.source, &self.document.buffer_views, view, "buffer view")?;
        item(self.source, &self.document.buffers, view.buffer, "buffer")?;
        let stride = view.byte_stride.unwrap_or(size);
        let needed =
            count.checked_sub(1).map_or(Some(0), |n| n.checked_mul(stride)?.checked_add(size));
        let end = view.byte_offset.checked_add(view.byte_length);
        let bytes = end.and_then(|end| self.buffers.bytes(view.buffer).get(view.byte_offset..end));
        let bytes = bytes.and_then(|b| b.get(offset..)).zip(needed).and_then(|(b, n)| b.get(..n));
        match bytes {
            Some(bytes) if stride >= size => Ok(bytes.chunks(stride).map(move |b| &b[..size])),
            Some(_) => Err(self.broken("has items that overlap")),
            None => Err(self.broken(&format!("has {count} items, more than its buffer"))),
        }
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

fn is_whole(component: u32) -> bool {
    matches!(component, U8 | U16 | U32)
}

fn whole(bytes: &[u8]) -> u32 {
    bytes.iter().rev().fold(0, |n, &byte| n << 8 | u32::from(byte))
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
