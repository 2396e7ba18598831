//! Plots: curves over two axes as SVG, as PNG and in the terminal, drawn by crate kuva with the font it brings along.
//!
//! A [`Figure`] is plain data; `drawing` turns it into a scene of kuva. Colours are those of Okabe and Ito (2008), which people of all kinds of colour
//! vision tell apart, and each curve has a marker of its own as well.

mod drawing;
mod figure;

pub use figure::{Axis, Curve, Figure, Scale, Style};

#[cfg(test)]
mod tests;
