//! What a plot shows: two axes and curves.

use crate::error::shown;

/// Says how an axis runs.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Scale {
    /// Equal steps are equal differences.
    #[default]
    Linear,
    /// Equal steps are equal ratios; points that are not positive cannot be shown and are left out.
    Logarithmic,
}

/// Describes an axis.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Axis {
    /// What it shows, with its unit: "power, m2".
    pub label: String,
    /// How it runs.
    pub scale: Scale,
}

impl Axis {
    /// Makes a linear axis.
    pub fn linear(label: impl Into<String>) -> Self {
        Self { label: label.into(), scale: Scale::Linear }
    }

    /// Makes a logarithmic axis.
    pub fn logarithmic(label: impl Into<String>) -> Self {
        Self { label: label.into(), scale: Scale::Logarithmic }
    }
}

/// Says how a curve is drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Style {
    /// A line with a marker at each point.
    #[default]
    Both,
    /// A line: many points, or a function.
    Line,
    /// Markers: measurements.
    Points,
}

/// Holds one curve.
#[derive(Debug, Clone, PartialEq)]
pub struct Curve {
    /// What the legend calls it; a figure in which no curve has a name has no legend.
    pub name: String,
    /// The points, in the order they are joined; those that are not finite are left out.
    pub points: Vec<[f64; 2]>,
    /// How far y may be below and above for each point; as many as there are points, or none.
    pub errors: Vec<[f64; 2]>,
    /// How it is drawn.
    pub style: Style,
}

impl Curve {
    /// Makes a curve with line and markers; its name is drawn as [`shown`] shows it.
    pub fn new(name: impl AsRef<str>, points: Vec<[f64; 2]>) -> Self {
        Self { name: shown(name.as_ref()), points, errors: Vec::new(), style: Style::Both }
    }

    /// Draws it otherwise.
    pub fn drawn(mut self, style: Style) -> Self {
        self.style = style;
        self
    }

    /// Adds error bars: how far y may be below and above, for each point.
    ///
    /// # Panics
    /// When there are not as many as points: a programmer's error.
    pub fn with_errors(mut self, errors: Vec<[f64; 2]>) -> Self {
        assert_eq!(errors.len(), self.points.len(), "each point takes one pair of errors");
        self.errors = errors;
        self
    }
}

/// Holds a plot as data.
///
/// ```
/// use harmolux::plots::{Axis, Curve, Figure};
///
/// let points = (1..=8).map(|l| [f64::from(l), 0.1 / f64::from(l * l)]).collect();
/// let axes = [Axis::linear("degree"), Axis::logarithmic("power, m2")];
/// let figure = Figure::new("A spectrum", axes, vec![Curve::new("egg", points)]);
/// assert!(figure.to_svg()?.starts_with("<svg"));
/// # Ok::<(), harmolux::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Figure {
    /// The title above.
    pub title: String,
    /// The horizontal and the vertical axis.
    pub axes: [Axis; 2],
    /// The curves, the first drawn first.
    pub curves: Vec<Curve>,
}

impl Figure {
    /// Joins title, axes and curves.
    pub fn new(title: impl Into<String>, axes: [Axis; 2], curves: Vec<Curve>) -> Self {
        Self { title: title.into(), axes, curves }
    }
}
