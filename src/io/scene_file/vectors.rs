//! Checked arrays of scene files: points, directions, colours, columns and rows; see `values` for
//! how they report.

use std::fmt;
use std::marker::PhantomData;

use glam::DVec3;
use serde::de::{Deserialize, Deserializer, Error, SeqAccess, Visitor};

use super::values::{AtLeast0, Coordinate, Number, NumberVisitor, Range, Whole, refusal};
use crate::math::Rgb;

/// Holds an array of exactly `N` values; serde's own accepts longer ones from TOML.
struct Array<T, const N: usize>([T; N]);

impl<'de, T: Deserialize<'de>, const N: usize> Deserialize<'de> for Array<T, N> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(ArrayVisitor(PhantomData))
    }
}

struct ArrayVisitor<T, const N: usize>(PhantomData<T>);

impl<'de, T: Deserialize<'de>, const N: usize> Visitor<'de> for ArrayVisitor<T, N> {
    type Value = Array<T, N>;

    fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
        write!(f, "an array of {N} numbers")
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut seq: A) -> Result<Self::Value, A::Error> {
        let mut items = Vec::new();
        while let Some(item) = seq.next_element()? {
            items.push(item);
        }
        let items: Result<[T; N], _> = items.try_into();
        items.map(Array).map_err(|items| {
            refusal(
                &format!("an array of {N} numbers"),
                &format_args!("{} of them", items.len()),
                "",
            )
        })
    }
}

/// Holds a point.
struct Point(DVec3);

impl<'de> Deserialize<'de> for Point {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let array = Array::<Number<Coordinate>, 3>::deserialize(deserializer)?;
        Ok(Self(DVec3::from_array(array.0.map(|n| n.0))))
    }
}

/// Reads a point or a vector, metres.
pub(super) fn point<'de, D: Deserializer<'de>>(d: D) -> Result<DVec3, D::Error> {
    Point::deserialize(d).map(|p| p.0)
}

/// Reads a point of a key that may be left out.
pub(super) fn point_if<'de, D: Deserializer<'de>>(d: D) -> Result<Option<DVec3>, D::Error> {
    point(d).map(Some)
}

/// Reads one or more points.
pub(super) fn points<'de, D: Deserializer<'de>>(d: D) -> Result<Vec<DVec3>, D::Error> {
    let points = d.deserialize_any(PointsVisitor)?;
    if points.is_empty() {
        Err(D::Error::custom("must hold at least one point"))
    } else {
        Ok(points)
    }
}

struct PointsVisitor;

impl<'de> Visitor<'de> for PointsVisitor {
    type Value = Vec<DVec3>;

    fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str("a list of points, [[x, y, z], ...]")
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut seq: A) -> Result<Self::Value, A::Error> {
        let mut points = Vec::new();
        while let Some(Point(point)) = seq.next_element()? {
            points.push(point);
        }
        Ok(points)
    }
}

/// Reads a vector that is not zero and gives it length 1.
pub(super) fn direction<'de, D: Deserializer<'de>>(d: D) -> Result<DVec3, D::Error> {
    let vector = point(d)?;
    let none = || D::Error::custom("must be a direction, found a vector of length 0");
    vector.try_normalize().ok_or_else(none)
}

/// Reads a direction of a key that may be left out.
pub(super) fn direction_if<'de, D: Deserializer<'de>>(d: D) -> Result<Option<DVec3>, D::Error> {
    direction(d).map(Some)
}

/// Reads a number, meaning grey, or [r, g, b], each obeying `R`.
pub(super) fn spectrum<'de, R: Range, D: Deserializer<'de>>(d: D) -> Result<Rgb, D::Error> {
    d.deserialize_any(SpectrumVisitor::<R>(PhantomData))
}

struct SpectrumVisitor<R>(PhantomData<R>);

impl<'de, R: Range> Visitor<'de> for SpectrumVisitor<R> {
    type Value = Rgb;

    fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str("a number or [r, g, b]")
    }

    fn visit_i64<E: Error>(self, x: i64) -> Result<Rgb, E> {
        self.visit_f64(x as f64)
    }

    fn visit_u64<E: Error>(self, x: u64) -> Result<Rgb, E> {
        self.visit_f64(x as f64)
    }

    fn visit_f64<E: Error>(self, x: f64) -> Result<Rgb, E> {
        NumberVisitor::<R>::check(x).map(|n| Rgb::grey(n.0))
    }

    fn visit_seq<A: SeqAccess<'de>>(self, seq: A) -> Result<Rgb, A::Error> {
        let array = ArrayVisitor::<Number<R>, 3>(PhantomData).visit_seq(seq)?;
        Ok(Rgb(array.0.map(|n| n.0)))
    }
}

/// Reads [r, g, b], of which only the ratio counts, and scales it to luminance 1.
pub(super) fn colour<'de, D: Deserializer<'de>>(d: D) -> Result<Rgb, D::Error> {
    let array = Array::<Number<AtLeast0>, 3>::deserialize(d)?;
    let colour = Rgb(array.0.map(|n| n.0));
    // Scaled by the largest component first, so that neither very large nor very small triples
    // overflow.
    let scaled = colour / colour.max_component();
    let colour = scaled / scaled.luminance();
    let black = "must have a component above 0\nwrite the lamp's strength in `intensity` or `flux`";
    if colour.is_finite() { Ok(colour) } else { Err(D::Error::custom(black)) }
}

/// Reads two whole numbers from 1 to 65536: columns and rows.
pub(super) fn columns_rows<'de, D: Deserializer<'de>>(d: D) -> Result<[u32; 2], D::Error> {
    Array::<Whole<1, 65536>, 2>::deserialize(d).map(|a| a.0.map(|n| n.0 as u32))
}

/// Reads four whole numbers from 0 to 65536: positions of pixels.
pub(super) fn pixels<'de, D: Deserializer<'de>>(d: D) -> Result<[u32; 4], D::Error> {
    Array::<Whole<0, 65536>, 4>::deserialize(d).map(|a| a.0.map(|n| n.0 as u32))
}

/// Reads columns and rows of a key that may be left out.
pub(super) fn columns_rows_if<'de, D: Deserializer<'de>>(
    d: D,
) -> Result<Option<[u32; 2]>, D::Error> {
    columns_rows(d).map(Some)
}
