//! White paper to draw on with a scene of kuva, and how such scenes become SVG and pixels.

use image::RgbImage;
use image::imageops::FilterType;
use kuva::backend::png::PngBackend;
use kuva::backend::svg::SvgBackend;
use kuva::render::color::Color;
use kuva::render::render::{PathData, Primitive, Scene, TextAnchor};

use crate::io::output::SOFTWARE;
use crate::{Error, Result};

/// The sizes of a picture that can be made, pixels a side.
pub(super) const PIXELS: std::ops::RangeInclusive<u32> = 200..=4096;
/// Pictures are drawn this many times finer and averaged, as far as memory allows: kuva smears text
/// that runs upwards over a pixel.
const FINER: u32 = 3;
/// The largest side that is drawn, pixels.
const FINEST: u32 = 8192;
/// The font that kuva draws into pixels, and what is like it.
const FONT: &str = "DejaVu Sans, Verdana, Arial, sans-serif";

/// A colour, sRGB.
pub(super) type Rgb8 = [u8; 3];

pub(super) const BLACK: Rgb8 = [0; 3];
pub(super) const WHITE: Rgb8 = [255; 3];
/// The colour of text that explains.
pub(super) const INK: Rgb8 = [0x22; 3];
/// The colour of axes and frames.
pub(super) const FRAME: Rgb8 = [0x66; 3];

/// Writes a scene as SVG that names this program.
pub(super) fn svg(scene: &Scene) -> String {
    let svg = SvgBackend::new().render_scene(scene);
    match svg.split_once('>') {
        // Output knows our files by their name within the first KiB.
        Some((start, rest)) => format!("{start}><!-- {SOFTWARE} -->{rest}"),
        None => svg,
    }
}

/// Draws a scene, `scale` pixels a unit, into a picture of this size.
pub(super) fn pixels(scene: &Scene, scale: f64, [width, height]: [u32; 2]) -> Result<RgbImage> {
    let finer = (FINEST / width.max(height).max(1)).clamp(1, FINER);
    let backend = PngBackend::new().with_scale(scale as f32 * finer as f32);
    let drawn = backend.render_scene(scene).map_err(|e| failed(&e))?;
    let fine = image::load_from_memory(&drawn).map_err(|e| failed(&e))?.into_rgb8();
    Ok(image::imageops::resize(&fine, width, height, FilterType::Triangle))
}

pub(super) fn failed(what: &dyn std::fmt::Display) -> Error {
    Error::Numeric(format!("the plot cannot be drawn: {what}"))
}

/// Keeps kuva from reading formulas between dollar signs.
pub(super) fn plain(text: &str) -> String {
    text.replace('$', "\\$")
}

/// Estimates the width of a text from the advances of DejaVu Sans, a little more rather than less.
pub(super) fn text_width(text: &str, size: f64) -> f64 {
    let advance = |c: char| match c {
        '0'..='9' => 0.64,
        '.' | ',' | ' ' | ':' | ';' | 'i' | 'l' | 'j' | '\'' | '|' => 0.32,
        'm' | 'w' | 'M' | 'W' | '%' | '@' => 0.97,
        '\u{2212}' | '+' | '=' | '<' | '>' | '\u{d7}' => 0.838,
        'A'..='Z' => 0.72,
        c if c.is_ascii() => 0.6,
        _ => 0.8,
    };
    size * text.chars().map(advance).sum::<f64>()
}

/// A rectangle of the paper: left, top, width and height.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Area {
    pub(super) x: f64,
    pub(super) y: f64,
    pub(super) width: f64,
    pub(super) height: f64,
}

impl Area {
    /// Makes one about a middle.
    pub(super) fn about([x, y]: [f64; 2], [width, height]: [f64; 2]) -> Self {
        Self { x: x - 0.5 * width, y: y - 0.5 * height, width, height }
    }

    pub(super) fn right(&self) -> f64 {
        self.x + self.width
    }

    pub(super) fn bottom(&self) -> f64 {
        self.y + self.height
    }

    /// Returns the size of what two areas share.
    pub(super) fn overlap(&self, other: &Self) -> f64 {
        let width = self.right().min(other.right()) - self.x.max(other.x);
        let height = self.bottom().min(other.bottom()) - self.y.max(other.y);
        width.max(0.0) * height.max(0.0)
    }

    /// Whether a point lies within.
    pub(super) fn contains(&self, [x, y]: [f64; 2]) -> bool {
        (self.x..=self.right()).contains(&x) && (self.y..=self.bottom()).contains(&y)
    }

    /// Whether another lies within.
    pub(super) fn holds(&self, other: &Self) -> bool {
        other.x >= self.x
            && other.y >= self.y
            && other.right() <= self.right()
            && other.bottom() <= self.bottom()
    }
}

/// Says where a text stands about its point.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Align {
    Left,
    Middle,
    Right,
    /// In the middle, running upwards.
    Upwards,
}

/// Collects what is drawn, the first under the rest.
pub(super) struct Paper {
    scene: Scene,
}

impl Paper {
    pub(super) fn new(width: f64, height: f64) -> Self {
        let mut scene = Scene::new(width, height);
        scene.font_family = Some(FONT.to_owned());
        Self { scene }
    }

    /// Returns the size of a picture of so many pixels a unit.
    pub(super) fn size(&self, scale: f64) -> [u32; 2] {
        [self.scene.width, self.scene.height].map(|n| (n * scale).round().max(1.0) as u32)
    }

    /// Changes the ground.
    pub(super) fn on(&mut self, ground: Rgb8) {
        self.scene.background_color = Some(hex(ground));
    }

    pub(super) fn pixels(&self, scale: f64) -> Result<RgbImage> {
        pixels(&self.scene, scale, self.size(scale))
    }

    pub(super) fn svg(&self) -> String {
        svg(&self.scene)
    }

    /// Keeps a place among what is drawn that [`mark`] finds in the SVG.
    pub(super) fn place(&mut self, name: &str) {
        let extra_attrs = Some(format!("id=\"{name}\""));
        self.scene.add(Primitive::GroupStart { transform: None, title: None, extra_attrs });
        self.scene.add(Primitive::GroupEnd);
    }

    pub(super) fn fill(&mut self, area: Area, fill: Rgb8, opacity: Option<f64>) {
        let Area { x, y, width, height } = area;
        self.scene.add(Primitive::Rect {
            x,
            y,
            width,
            height,
            fill: colour(fill),
            stroke: None,
            stroke_width: None,
            opacity,
        });
    }

    pub(super) fn frame(&mut self, area: Area, stroke: Rgb8, width: f64) {
        let Area { x, y, .. } = area;
        let (right, bottom) = (area.right(), area.bottom());
        let corners = vec![[x, y], [right, y], [right, bottom], [x, bottom], [x, y]];
        self.polyline(corners, stroke, width);
    }

    pub(super) fn polyline(&mut self, points: Vec<[f64; 2]>, stroke: Rgb8, stroke_width: f64) {
        self.scene.add(Primitive::PolyLine {
            points: points.into_iter().map(<(f64, f64)>::from).collect(),
            stroke: colour(stroke),
            stroke_width,
            stroke_dasharray: None,
        });
    }

    pub(super) fn ring(&mut self, [cx, cy]: [f64; 2], r: f64, stroke: Rgb8, width: f64) {
        self.scene.add(Primitive::Circle {
            cx,
            cy,
            r,
            fill: Color::None,
            fill_opacity: None,
            stroke: Some(colour(stroke)),
            stroke_width: Some(width),
        });
    }

    pub(super) fn polygon(&mut self, points: &[[f64; 2]], fill: Rgb8) {
        let places: Vec<String> = points.iter().map(|[x, y]| format!("{x:.2} {y:.2}")).collect();
        self.scene.add(Primitive::Path(Box::new(PathData {
            d: format!("M {} Z", places.join(" L ")),
            fill: Some(colour(fill)),
            stroke: Color::None,
            stroke_width: 0.0,
            opacity: None,
            stroke_dasharray: None,
        })));
    }

    /// Writes a text; capitals and digits have `at` in the middle of their height.
    pub(super) fn text(
        &mut self,
        [x, y]: [f64; 2],
        align: Align,
        size: f64,
        ink: Rgb8,
        text: &str,
    ) {
        let size = size.round().max(1.0);
        // Capitals of DejaVu Sans are 0.73 high.
        let half = 0.365 * size;
        let (anchor, rotate, [x, y]) = match align {
            Align::Left => (TextAnchor::Start, None, [x, y + half]),
            Align::Middle => (TextAnchor::Middle, None, [x, y + half]),
            Align::Right => (TextAnchor::End, None, [x, y + half]),
            Align::Upwards => (TextAnchor::Middle, Some(-90.0), [x + half, y]),
        };
        self.scene.add(Primitive::Text {
            x,
            y,
            content: plain(text),
            size: size as u32,
            anchor,
            rotate,
            bold: false,
            color: Some(colour(ink)),
        });
    }

    /// Writes a text on a light plate.
    pub(super) fn plate(&mut self, at: [f64; 2], size: f64, text: &str) {
        let area = Area::about(at, plate_size(text, size));
        self.fill(area, WHITE, Some(0.85));
        self.text(at, Align::Middle, size, BLACK, text);
    }
}

/// Returns the size of a plate.
pub(super) fn plate_size(text: &str, size: f64) -> [f64; 2] {
    [text_width(text, size) + 0.5 * size, 1.2 * size]
}

/// Puts SVG elements where [`Paper::place`] kept a place.
pub(super) fn put(svg: &str, name: &str, elements: &str) -> String {
    let place = format!("<g id=\"{name}\">");
    svg.replacen(&place, &format!("{place}{elements}"), 1)
}

fn colour([r, g, b]: Rgb8) -> Color {
    Color::Rgb(r, g, b)
}

fn hex([r, g, b]: Rgb8) -> String {
    format!("#{r:02x}{g:02x}{b:02x}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn areas_overlap_and_hold_each_other() {
        let a = Area { x: 0.0, y: 0.0, width: 4.0, height: 2.0 };
        let b = Area::about([4.0, 1.0], [2.0, 2.0]);
        assert_eq!((a.overlap(&b), a.overlap(&a)), (2.0, 8.0));
        assert!(a.holds(&a) && !a.holds(&b));
        assert_eq!(a.overlap(&Area { x: 9.0, ..b }), 0.0);
    }

    #[test]
    fn texts_with_dollar_signs_and_brackets_are_texts() {
        let mut paper = Paper::new(200.0, 50.0);
        paper.text([10.0, 20.0], Align::Left, 12.0, INK, "a $x$ <b>");
        paper.place("here");
        let svg = paper.svg();
        assert!(svg.contains("a $x$ &lt;b&gt;") && svg.contains("harmolux "), "{svg}");
        assert!(put(&svg, "here", "<rect/>").contains("<g id=\"here\"><rect/></g>"));
    }

    #[test]
    fn picture_has_the_size_and_the_ground_asked_for() {
        let mut paper = Paper::new(200.0, 50.0);
        paper.on([1, 2, 3]);
        paper.fill(Area { x: 10.0, y: 10.0, width: 20.0, height: 20.0 }, [200, 100, 0], None);
        let drawn = paper.pixels(2.0).expect("drawn");
        assert_eq!((drawn.dimensions(), drawn[(5, 5)].0), ((400, 100), [1, 2, 3]));
        assert_eq!((drawn[(22, 22)].0, drawn[(57, 57)].0), ([200, 100, 0], [200, 100, 0]));
    }
}
