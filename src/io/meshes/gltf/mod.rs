//! glTF 2.0, as text with its buffers inside or beside it, and as one binary file: the triangles of
//! the default scene.
//!
//! All nodes of the scene are placed by their transforms, coordinates stay in the file's own axes
//! (y up). A vertex of glTF is a position with a normal, a colour and so on: where those differ the
//! format repeats the position. Positions of one node that are equal to the last bit are therefore
//! one vertex here. Points, lines and morph targets are passed over, and skins, but that the
//! transform of a node with a skin places nothing, as the specification says.
//!
//! (Crate gltf 1 adds offsets and lengths of the file without a check and subtracts one from counts
//! of zero: it panics. It knows neither quantised positions nor where in the text a fault is. What
//! a mesh needs of the format is little.)

mod assembly;
mod buffers;
mod document;

use std::borrow::Cow;

use crate::error::InputError;
use crate::io::bytes::{Cursor, number_at};
use crate::io::source::{Source, unmarked};
use crate::mesh::Mesh;
use crate::{Error, Result};
use assembly::Assembly;
use buffers::Buffers;
use document::Document;

const MAGIC: &[u8] = b"glTF";
/// The types of the chunks of a binary file.
const JSON: &[u8] = b"JSON";
const BINARY: &[u8] = b"BIN\0";

/// Whether a file begins as the binary form does.
pub(super) fn is_binary(head: &[u8]) -> bool {
    head.starts_with(MAGIC)
}

/// Whether a file begins as the text form does, which JSON of all kinds does: an object of names.
pub(super) fn is_text(head: &[u8]) -> bool {
    let names = unmarked(head).trim_ascii_start().strip_prefix(b"{");
    names.is_some_and(|names| matches!(names.trim_ascii_start().first(), None | Some(b'"' | b'}')))
}

/// Reads the content of a glTF file; its buffers are looked for beside it.
pub(super) fn parse(source: &mut Source) -> Result<Mesh> {
    let bytes = source.rest()?;
    let parts =
        if is_binary(&bytes) { Container::of(source, &bytes)? } else { Container::text(&bytes) };
    let document = read_document(source, &parts)?;
    check_version(source, &document)?;
    let buffers = Buffers::load(source, &document, parts.binary)?;
    let room = bytes.len() as u64 + buffers.outside();
    Assembly::of(source, &document, &buffers, room)?.finish(source)
}

/// The two parts of a binary file, or a text alone.
struct Container<'a> {
    json: &'a [u8],
    binary: Option<&'a [u8]>,
    is_text: bool,
}

impl<'a> Container<'a> {
    fn text(bytes: &'a [u8]) -> Self {
        Self { json: unmarked(bytes), binary: None, is_text: true }
    }

    fn of(source: &Source, bytes: &'a [u8]) -> Result<Self> {
        let help = "the file is cut short or damaged; export it again";
        let broken = |what: &str| source.fault(format!("binary glTF {what}"), help);
        let version = number_at::<u32>(bytes, 4).ok_or_else(|| broken("without a header"))?;
        if version != 2 {
            let message = format!("binary glTF of version {version}");
            return Err(source.fault(message, "export it as glTF 2.0"));
        }
        let length = number_at::<u32>(bytes, 8).map(|n| n as usize);
        let whole = length.and_then(|n| bytes.get(..n)).ok_or_else(|| {
            broken(&format!(
                "that says it has {} bytes and has {}",
                length.unwrap_or(0),
                bytes.len()
            ))
        })?;
        let mut rest = Cursor(whole.get(12..).unwrap_or_default());
        let json = chunk(&mut rest).filter(|(kind, _)| *kind == JSON);
        let (_, json) = json.ok_or_else(|| broken("without a whole chunk of JSON"))?;
        let mut binary = None;
        while !rest.0.is_empty() {
            let (kind, content) =
                chunk(&mut rest).ok_or_else(|| broken("with a chunk that is not whole"))?;
            // Those of other kinds are of extensions.
            if kind == BINARY {
                binary = binary.or(Some(content));
            }
        }
        Ok(Self { json, binary, is_text: false })
    }
}

/// Takes a chunk: its type and its content.
fn chunk<'a>(rest: &mut Cursor<'a>) -> Option<(&'a [u8], &'a [u8])> {
    let length = rest.number::<u32>()?;
    Some((rest.take(4)?, rest.take(length as usize)?))
}

fn read_document<'a>(source: &Source, parts: &Container<'a>) -> Result<Document<'a>> {
    serde_json::from_slice(parts.json).map_err(|e| {
        let text = e.to_string();
        // The place is told apart.
        let what = text.rsplit_once(" at line ").map_or(text.as_str(), |(what, _)| what);
        let help = "check that this is a glTF file; export it again";
        let error =
            InputError::new(source.path(), format!("this is no glTF file: {what}")).help(help);
        let error = if parts.is_text && e.line() > 0 {
            error.at(e.line(), Some(e.column().max(1)))
        } else {
            error
        };
        error.into()
    })
}

/// What leaves the triangles as they are, by the beginning of the name.
const HARMLESS: [&str; 5] =
    ["KHR_mesh_quantization", "KHR_materials_", "KHR_texture_", "EXT_texture_", "KHR_lights_"];

fn check_version(source: &Source, document: &Document) -> Result<()> {
    let version = &document.asset.version;
    if !version.starts_with("2.") {
        let message = format!("this is glTF of version {version}");
        return Err(source.fault(message, "export it as glTF 2.0"));
    }
    let needed = &document.extensions_required;
    let unknown = needed.iter().find(|e| !HARMLESS.iter().any(|h| e.starts_with(h)));
    unknown.map_or(Ok(()), |extension| {
        let message = format!("the file needs the extension {extension}, which is not read");
        Err(source.fault(message, "export it without compression and extensions"))
    })
}

/// Names a thing of a list of the document.
fn item<'d, T>(source: &Source, list: &'d [T], index: usize, what: &str) -> Result<&'d T> {
    list.get(index).ok_or_else(|| broken(source, format!("{what} {index} is not there")))
}

fn broken(source: &Source, message: impl Into<Cow<'static, str>>) -> Error {
    source.fault(message.into(), "the file contradicts itself; export it again")
}

#[cfg(test)]
mod tests;
