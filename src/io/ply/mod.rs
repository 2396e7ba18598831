//! PLY files, read: the header, and the rows of each element, as text and as binary of either byte
//! order.

mod header;
mod rows;

use super::source::unmarked;

pub(in crate::io) use header::{Element, Header, Shape};
pub(in crate::io) use rows::{Place, Rows, Value};

/// Whether a file begins as PLY does.
pub(in crate::io) fn is_ply(head: &[u8]) -> bool {
    let rest = unmarked(head).strip_prefix(b"ply");
    rest.is_some_and(|rest| rest.first().is_none_or(u8::is_ascii_whitespace))
}
