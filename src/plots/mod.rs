//! Plots: curves over two axes as SVG, as PNG and in the terminal, and values in false colour,
//! drawn by crate kuva with the font it brings along.
//!
//! A [`Figure`] is plain data; `drawing` turns it into a scene of kuva. Colours are those of Okabe
//! and Ito (2008), which people of all kinds of colour vision tell apart, and each curve has a
//! marker of its own as well. [`FalseColour`] shows the values of a picture, [`Isolux`] those of a
//! grid of sensors, both by a [`ColourScale`] of a [`Palette`] from crate colorous.

mod colour_scale;
mod drawing;
mod false_colour;
mod figure;
mod isolines;
mod isolux;
mod labels;
mod lattice;
mod legend;
mod palette;
mod paper;
mod refinement;
mod tally;
mod ticks;

pub use colour_scale::{ColourScale, MOST_DECADES, ScaleOptions};
pub use false_colour::FalseColour;
pub use figure::{Axis, Curve, Figure, Scale, Style};
pub use isolux::Isolux;
pub use lattice::Lattice;
pub use palette::Palette;
pub use tally::Tally;

#[cfg(test)]
mod tests;
