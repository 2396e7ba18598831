//! The viewer: one HTML file, complete in itself, that shows shapes at every degree in a browser,
//! with the numbers, pictures and plots of a sweep beside them.
//!
//! `page.html` is joined with its style, its script and the data as JSON. What a browser computes
//! comes from the coefficients alone (docs/how/conventions.md); names are data, and never markup.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use glam::DVec3;
use image::codecs::jpeg::JpegEncoder;
use image::{DynamicImage, ExtendedColorType, RgbImage};
use serde_json::{Value, json};

use crate::fit::Shape;
use crate::io::output::SOFTWARE;
use crate::mesh::Mesh;
use crate::{Error, Result};

use super::sweep::{numbers_in_f32, thinned};

const HTML: &str = include_str!("page.html");
const STYLE: &str = include_str!("page.css");
/// What one file uses stands in those before.
const SCRIPT: &str = concat!(
    include_str!("words.js"),
    include_str!("series.js"),
    include_str!("surfaces.js"),
    include_str!("shapes.js"),
    include_str!("camera.js"),
    include_str!("webgl.js"),
    include_str!("canvas.js"),
    include_str!("stage.js"),
    include_str!("panel.js"),
    include_str!("sections.js"),
    include_str!("controls.js"),
);

/// The faces that a page shows at most.
const MOST_FACES: usize = 60_000;

/// The quality of pictures, of 100.
const QUALITY: u8 = 88;

/// Holds what a page shows, as the JSON that its script reads.
#[derive(Debug, Clone)]
pub struct Page {
    title: String,
    shapes: Vec<Value>,
    original: Option<RgbImage>,
    pictures: Vec<Value>,
    plots: Vec<Value>,
    more: Value,
}

impl Page {
    /// Starts a page.
    pub fn new(title: impl Into<String>) -> Self {
        let more = json!({ "columns": [], "rows": [], "answers": [] });
        let [shapes, pictures, plots] = [(); 3].map(|()| Vec::new());
        Self { title: title.into(), shapes, original: None, pictures, plots, more }
    }

    /// Adds a shape under a name, and the mesh that stands beside it, in the same axes, metres; one
    /// of more than 60 000 faces is thinned, and the page says so.
    ///
    /// # Errors
    /// [`Error::Memory`] for more than is free.
    pub fn shape(&mut self, name: &str, shape: &Shape, mesh: Option<&Mesh>) -> Result<()> {
        self.shapes.push(json!({
            "name": name,
            "source": shape.source.as_ref().map(|source| &source.name),
            "centre": shape.centre.to_array(),
            "lmax": shape.coefficients.lmax(),
            "coefficients": STANDARD.encode(numbers_in_f32(shape)),
            "mesh": mesh.map(mesh_value).transpose()?,
        }));
        Ok(())
    }

    /// Sets the picture of the original, an encoded image, with which others are compared.
    ///
    /// # Errors
    /// As [`Page::picture`].
    pub fn original(&mut self, image: &[u8]) -> Result<()> {
        let original = decoded(image)?;
        self.pictures.push(json!({ "degree": null, "picture": jpeg(&original)? }));
        self.original = Some(original);
        Ok(())
    }

    /// Adds the picture of a degree, an encoded image, and its difference from that of the original.
    ///
    /// # Errors
    /// [`Error::Numeric`] with the complaint of the decoder or the encoder.
    pub fn picture(&mut self, degree: usize, image: &[u8]) -> Result<()> {
        let own = decoded(image)?;
        let difference = self.original.as_ref().map(|other| jpeg(&difference(&own, other)));
        self.pictures.push(json!({
            "degree": degree,
            "picture": jpeg(&own)?,
            "difference": difference.transpose()?,
        }));
        Ok(())
    }

    /// Adds a plot.
    pub fn plot(&mut self, name: &str, svg: &str) {
        self.plots.push(json!({ "name": name, "svg": svg }));
    }

    /// Sets the table: objects with the keys "shape" and "degree" and those of `columns`, which are
    /// objects of "name", "title", "unit", "scale" and "detail", which is true for what stands in
    /// the table alone.
    pub fn table(&mut self, columns: Value, rows: Value) {
        (self.more["columns"], self.more["rows"]) = (columns, rows);
    }

    /// Sets the answers: objects of "tolerance", "degree", "bytes" and "nanoseconds_per_ray".
    pub fn answers(&mut self, answers: Value) {
        self.more["answers"] = answers;
    }

    /// Writes the page.
    pub fn to_html(&self) -> String {
        let mut data = self.more.clone();
        data["title"] = self.title.as_str().into();
        data["software"] = SOFTWARE.into();
        data["shapes"] = self.shapes.clone().into();
        data["pictures"] = self.pictures.clone().into();
        data["plots"] = self.plots.clone().into();
        // Within a script only this character could end it.
        let data = data.to_string().replace('<', "\\u003c");
        let title = escaped(&self.title);
        let value = |key: &str| match key {
            "title" => title.as_str(),
            "style" => STYLE,
            "script" => SCRIPT,
            _ => data.as_str(),
        };
        // The mark by which a later run knows its own page.
        let marked = HTML.replacen('\n', &format!("\n<!-- {SOFTWARE} -->\n"), 1);
        let mut pieces = marked.split("{{");
        let mut html = pieces.next().unwrap_or_default().to_owned();
        for (key, text) in pieces.filter_map(|piece| piece.split_once("}}")) {
            html.push_str(value(key));
            html.push_str(text);
        }
        html
    }
}

fn failed(e: &image::ImageError) -> Error {
    Error::Numeric(format!("a picture of the page cannot be made: {e}"))
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

fn decoded(image: &[u8]) -> Result<RgbImage> {
    image::load_from_memory(image).map(DynamicImage::into_rgb8).map_err(|e| failed(&e))
}

/// Takes positions as steps of a 65535th of the box, of a mesh that is not too fine for a page.
fn mesh_value(mesh: &Mesh) -> Result<Value> {
    let faces = mesh.triangles().len();
    let mesh = thinned(mesh, MOST_FACES)?;
    let bounds = mesh.bounds();
    let step = (bounds.max - bounds.min) / 65535.0;
    let steps = |p: &DVec3| {
        let steps = (*p - bounds.min) / step.max(DVec3::splat(f64::MIN_POSITIVE));
        steps.to_array().map(|x| x.round() as u16)
    };
    let positions = mesh.positions().iter().flat_map(steps).flat_map(u16::to_le_bytes);
    let corners = mesh.triangles().as_flattened().iter().flat_map(|v| v.to_le_bytes());
    Ok(json!({
        "min": bounds.min.to_array(),
        "max": bounds.max.to_array(),
        "positions": STANDARD.encode(positions.collect::<Vec<u8>>()),
        "faces": STANDARD.encode(corners.collect::<Vec<u8>>()),
        "faces_of_original": faces,
    }))
}

fn jpeg(picture: &RgbImage) -> Result<String> {
    let mut bytes = Vec::new();
    let (width, height) = picture.dimensions();
    JpegEncoder::new_with_quality(&mut bytes, QUALITY)
        .encode(picture.as_raw(), width, height, ExtendedColorType::Rgb8)
        .map_err(|e| failed(&e))?;
    Ok(format!("data:image/jpeg;base64,{}", STANDARD.encode(bytes)))
}

/// Paints where a picture is lighter (red) or darker (blue) than another, four times as strongly.
fn difference(own: &RgbImage, other: &RgbImage) -> RgbImage {
    RgbImage::from_fn(own.width(), own.height(), |x, y| {
        let sum = |image: &RgbImage| -> i32 {
            image.get_pixel_checked(x, y).map_or(0, |p| p.0.iter().map(|c| i32::from(*c)).sum())
        };
        let change = 4 * (sum(own) - sum(other)) / 3;
        let rest = 255 - change.unsigned_abs().min(255) as u8;
        image::Rgb(if change > 0 { [255, rest, rest] } else { [rest, rest, 255] })
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes;
    use crate::sh::Coefficients;

    #[test]
    fn names_are_no_markup() {
        let mut ball = Coefficients::zeros(2);
        ball.set(0, 0, 1.0, 0.0);
        let name = "</script><script>alert(1)</script>";
        let mut page = Page::new(name);
        let cube = shapes::cube();
        page.shape(name, &Shape::new(ball), Some(&cube)).expect("a small mesh");
        page.plot(name, "<svg></svg>");
        let html = page.to_html();
        assert!(!html.contains(name) && !html.contains("<script>alert"));
        assert!(html.contains("&lt;/script&gt;") && html.contains("\\u003c/script>"));
        for place in ["{{title}}", "{{style}}", "{{script}}", "{{data}}"] {
            assert!(HTML.contains(place) && !html.contains(place), "{place}");
        }
    }

    #[test]
    fn pictures_have_their_difference() {
        let png = |value: u8| {
            crate::io::images::encode_png(2, 1, &[value, 0, 0, 9, 9, 9]).expect("a picture")
        };
        let mut page = Page::new("a");
        page.original(&png(10)).expect("a picture");
        page.picture(3, &png(90)).expect("a picture");
        assert!(page.pictures[0]["difference"].is_null());
        assert!(page.pictures[1]["difference"].as_str().is_some_and(|s| s.starts_with("data:")));
        assert!(page.picture(4, b"no picture").is_err());
    }
}
