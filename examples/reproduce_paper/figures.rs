//! The figures of the page: files beside the Markdown, and parts of the HTML.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;

/// Holds a figure as the bytes of its file.
pub(crate) struct Picture {
    /// The name of the file beside the page, `.svg` or `.png`.
    pub(crate) name: &'static str,
    /// What it shows, in words.
    pub(crate) caption: String,
    /// The file.
    pub(crate) bytes: Vec<u8>,
}

impl Picture {
    /// Returns what stands for the figure in a page without files beside it.
    pub(crate) fn inline(&self) -> String {
        let kind = if self.bytes.starts_with(b"<svg") { "svg+xml" } else { "png" };
        let alt = crate::html::escaped(&self.caption);
        let data = STANDARD.encode(&self.bytes);
        format!("<img alt=\"{alt}\" src=\"data:image/{kind};base64,{data}\">")
    }
}
