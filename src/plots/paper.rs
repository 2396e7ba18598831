//! White paper to draw on: a scene of kuva, and how it becomes SVG and pixels.

use image::RgbImage;
use kuva::backend::png::PngBackend;
use kuva::backend::svg::SvgBackend;
use kuva::render::color::Color;
use kuva::render::render::{PathData, Primitive, Scene, TextAnchor};

use crate::io::images::encode_png;
use crate::io::output::SOFTWARE;
use crate::{Error, Result, memory};

/// Pictures are drawn this many times finer and averaged, as far as memory allows: kuva smears text
/// that runs upwards over a pixel.
const FINER: u32 = 2;
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

/// Returns the size of a plate.
pub(super) fn plate_size(text: &str, size: f64) -> [f64; 2] {
    [text_width(text, size) + 0.5 * size, 1.2 * size]
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

    /// Whether another lies within.
    pub(super) fn holds(&self, other: &Self) -> bool {
        let starts = other.x >= self.x && other.y >= self.y;
        starts && other.right() <= self.right() && other.bottom() <= self.bottom()
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
pub(super) struct Paper(pub(super) Scene);

impl Paper {
    pub(super) fn new(width: f64, height: f64) -> Self {
        let mut scene = Scene::new(width, height);
        scene.font_family = Some(FONT.to_owned());
        Self(scene)
    }

    /// Draws it, `scale` pixels a unit, on a ground.
    pub(super) fn pixels(&mut self, scale: f64, [r, g, b]: Rgb8) -> Result<RgbImage> {
        let failed =
            |e: &dyn std::fmt::Display| Error::Numeric(format!("the plot cannot be drawn: {e}"));
        let size = [self.0.width, self.0.height];
        let [width, height] = size.map(|n| (n * scale).round().max(1.0) as u32);
        let finest = (FINEST / width.max(height)).clamp(1, FINER);
        let finer = (2..=finest).rev().find(|finer| ask_for(width * finer, height * finer).is_ok());
        let finer = finer.unwrap_or(1);
        ask_for(width * finer, height * finer)?;
        self.0.background_color = Some(format!("#{r:02x}{g:02x}{b:02x}"));
        let backend = PngBackend::new().with_scale(scale as f32 * finer as f32);
        let drawn = backend.render_scene(&self.0).map_err(|e| failed(&e))?;
        let fine = image::load_from_memory(&drawn).map_err(|e| failed(&e))?.into_rgb8();
        Ok(image::imageops::thumbnail(&fine, width, height))
    }

    /// Draws it on white as PNG.
    pub(super) fn png(mut self, scale: f64) -> Result<Vec<u8>> {
        let image = self.pixels(scale, WHITE)?;
        encode_png(image.width() as usize, image.height() as usize, image.as_raw())
    }

    /// Writes it as SVG that names this program, with further elements under all that is drawn.
    pub(super) fn svg(&self, under: &str) -> String {
        let svg = SvgBackend::new().render_scene(&self.0);
        // Output knows our files by their name within the first KiB.
        let svg = svg.replacen('>', &format!("><!-- {SOFTWARE} -->"), 1);
        // The first element that is empty is the ground.
        svg.replacen("/>", &format!("/>{under}"), 1)
    }

    pub(super) fn fill(&mut self, area: Area, fill: Rgb8, opacity: Option<f64>) {
        let Area { x, y, width, height } = area;
        let (fill, stroke, stroke_width) = (colour(fill), None, None);
        self.0.add(Primitive::Rect { x, y, width, height, fill, stroke, stroke_width, opacity });
    }

    pub(super) fn frame(&mut self, area: Area, stroke: Rgb8, width: f64) {
        let Area { x, y, .. } = area;
        let (right, bottom) = (area.right(), area.bottom());
        self.polyline(&[[x, y], [right, y], [right, bottom], [x, bottom], [x, y]], stroke, width);
    }

    pub(super) fn polyline(&mut self, points: &[[f64; 2]], stroke: Rgb8, stroke_width: f64) {
        let points = points.iter().copied().map(<(f64, f64)>::from).collect();
        let (stroke, stroke_dasharray) = (colour(stroke), None);
        self.0.add(Primitive::PolyLine { points, stroke, stroke_width, stroke_dasharray });
    }

    pub(super) fn ring(&mut self, [cx, cy]: [f64; 2], r: f64, stroke: Rgb8, width: f64) {
        let (fill, fill_opacity) = (Color::None, None);
        let (stroke, stroke_width) = (Some(colour(stroke)), Some(width));
        self.0.add(Primitive::Circle { cx, cy, r, fill, fill_opacity, stroke, stroke_width });
    }

    pub(super) fn polygon(&mut self, points: &[[f64; 2]], fill: Rgb8) {
        let places: Vec<String> = points.iter().map(|[x, y]| format!("{x:.2} {y:.2}")).collect();
        self.0.add(Primitive::Path(Box::new(PathData {
            d: format!("M {} Z", places.join(" L ")),
            fill: Some(colour(fill)),
            stroke: Color::None,
            stroke_width: 0.0,
            opacity: None,
            stroke_dasharray: None,
        })));
    }

    /// Writes a text; capitals and digits have `at` in the middle of their height.
    pub(super) fn text(&mut self, at: [f64; 2], align: Align, size: f64, ink: Rgb8, text: &str) {
        let size = size.round().max(1.0);
        // Capitals of DejaVu Sans are 0.73 high.
        let half = 0.365 * size;
        let (anchor, rotate, [right, down]) = match align {
            Align::Left => (TextAnchor::Start, None, [0.0, half]),
            Align::Middle => (TextAnchor::Middle, None, [0.0, half]),
            Align::Right => (TextAnchor::End, None, [0.0, half]),
            Align::Upwards => (TextAnchor::Middle, Some(-90.0), [half, 0.0]),
        };
        self.0.add(Primitive::Text {
            x: at[0] + right,
            y: at[1] + down,
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
        self.fill(Area::about(at, plate_size(text, size)), WHITE, Some(0.85));
        self.text(at, Align::Middle, size, BLACK, text);
    }
}

/// Asks for what so many pixels take while they are drawn, coded and read back: 24 bytes each.
fn ask_for(width: u32, height: u32) -> Result<()> {
    let bytes = 24.0 * f64::from(width) * f64::from(height);
    memory::ask(bytes, format_args!("a drawing of {width} x {height} pixels"), |_| {
        "draw a smaller picture, or write an SVG".to_owned()
    })
}

fn colour([r, g, b]: Rgb8) -> Color {
    Color::Rgb(r, g, b)
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
        let svg = paper.svg("<rect id=\"under\"/>");
        assert!(svg.contains("a $x$ &lt;b&gt;") && svg.contains("harmolux "), "{svg}");
        assert!(svg.find("fill=\"white\"") < svg.find("id=\"under\""), "{svg}");
        assert!(svg.find("id=\"under\"") < svg.find("<text"), "{svg}");
    }

    #[test]
    fn picture_has_the_size_and_the_ground_asked_for() {
        let mut paper = Paper::new(200.0, 50.0);
        paper.fill(Area { x: 10.0, y: 10.0, width: 20.0, height: 20.0 }, [200, 100, 0], None);
        let drawn = paper.pixels(2.0, [1, 2, 3]).expect("drawn");
        assert_eq!((drawn.dimensions(), drawn[(5, 5)].0), ((400, 100), [1, 2, 3]));
        assert_eq!((drawn[(22, 22)].0, drawn[(57, 57)].0), ([200, 100, 0], [200, 100, 0]));
    }
}
