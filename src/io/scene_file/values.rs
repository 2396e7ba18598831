//! Checked values of scene files: numbers in a range, whole numbers, tables, words, times.
//!
//! Each is a function for `#[serde(deserialize_with)]`. A message is what follows "`key` in [table]
//! "; after a line break it may say how to go on. 2 and 2.0 are the same everywhere.

use std::collections::BTreeMap;
use std::fmt;
use std::marker::PhantomData;
use std::time::Duration;

use serde::de::value::{MapAccessDeserializer, StringDeserializer};
use serde::de::{Deserialize, Deserializer, Error, MapAccess, Visitor};

use crate::math::Choice;

/// Says which numbers a key takes.
pub(super) trait Range {
    /// Completes "must be".
    const MUST: &'static str;
    /// Says why, or how to go on; may be empty.
    const HELP: &'static str = "";
    /// Whether a finite number is allowed.
    fn holds(x: f64) -> bool;
}

macro_rules! ranges {
    ($($name:ident: $holds:expr, $must:literal, $help:literal;)*) => {$(
        #[doc = concat!("Numbers that must be ", $must, ".")]
        #[derive(Debug)]
        pub(super) struct $name;

        impl Range for $name {
            const MUST: &'static str = $must;
            const HELP: &'static str = $help;
            fn holds(x: f64) -> bool {
                let holds: fn(f64) -> bool = $holds;
                holds(x)
            }
        }
    )*};
}

ranges! {
    Any: |_| true, "finite", "";
    Above0: |x| x > 0.0, "above 0", "";
    AtLeast0: |x| x >= 0.0, "0 or more", "";
    Albedo: |x| (0.0..1.0).contains(&x), "from 0 to below 1", "it is the reflected part of the \
        flux; at 1 light would never be absorbed";
    Opening: |x| x > 0.0 && x < 180.0, "between 0 and 180 degrees", "";
    Turn: |x| x > 0.0 && x <= 360.0, "above 0 and at most 360 degrees", "";
    HalfTurn: |x| (0.0..=180.0).contains(&x), "from 0 to 180 degrees", "";
    Share: |x| (0.0..=1.0).contains(&x), "from 0 to 1", "";
    Part: |x| x > 0.0 && x < 1.0, "between 0 and 1", "write 0.01 for one per cent";
    AreaShare: |x| x > 0.0 && x <= 1.0, "above 0 and at most 1", "it is a share of the area: \
        write 0.25 for a quarter";
    Roughness: |x| (0.01..=1.0).contains(&x), "from 0.01 to 1", "below 0.01 a surface is a mirror";
    Index: |x| x > 1.0 && x <= 4.0, "above 1 and at most 4", "glass and varnish have about 1.5";
    Size: |x| x > 0.0 && x <= 1e9, "above 0 and at most 1e9 metres", "";
    Coordinate: |x| x.abs() <= 1e9, "within 1e9 metres of the origin", "";
}

/// Holds a number that obeys `R`.
pub(super) struct Number<R>(pub(super) f64, PhantomData<R>);

impl<'de, R: Range> Deserialize<'de> for Number<R> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(NumberVisitor(PhantomData))
    }
}

pub(super) struct NumberVisitor<R>(PhantomData<R>);

impl<R: Range> NumberVisitor<R> {
    pub(super) fn check<E: Error>(x: f64) -> Result<Number<R>, E> {
        if x.is_finite() && R::holds(x) {
            return Ok(Number(x, PhantomData));
        }
        let (must, help) = if x.is_finite() { (R::MUST, R::HELP) } else { ("a finite number", "") };
        Err(refusal(must, &x, help))
    }
}

impl<R: Range> Visitor<'_> for NumberVisitor<R> {
    type Value = Number<R>;

    fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str("a number")
    }

    fn visit_i64<E: Error>(self, x: i64) -> Result<Self::Value, E> {
        Self::check(x as f64)
    }

    fn visit_u64<E: Error>(self, x: u64) -> Result<Self::Value, E> {
        Self::check(x as f64)
    }

    fn visit_f64<E: Error>(self, x: f64) -> Result<Self::Value, E> {
        Self::check(x)
    }
}

/// Says what a value must be, what was found, and why or how to go on.
pub(super) fn refusal<E: Error>(must: &str, found: &dyn fmt::Display, help: &str) -> E {
    let separator = if help.is_empty() { "" } else { "\n" };
    E::custom(format!("must be {must}, found {found}{separator}{help}"))
}

/// Reads a number that obeys `R`.
pub(super) fn number<'de, R: Range, D: Deserializer<'de>>(d: D) -> Result<f64, D::Error> {
    Number::<R>::deserialize(d).map(|n| n.0)
}

/// Reads a number that obeys `R`, of a key that may be left out.
pub(super) fn number_if<'de, R: Range, D: Deserializer<'de>>(
    d: D,
) -> Result<Option<f64>, D::Error> {
    number::<R, D>(d).map(Some)
}

/// Holds a whole number from `MIN` to `MAX`.
pub(super) struct Whole<const MIN: u64, const MAX: u64>(pub(super) u64);

impl<'de, const MIN: u64, const MAX: u64> Deserialize<'de> for Whole<MIN, MAX> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(WholeVisitor::<MIN, MAX>)
    }
}

struct WholeVisitor<const MIN: u64, const MAX: u64>;

impl<const MIN: u64, const MAX: u64> WholeVisitor<MIN, MAX> {
    fn refuse<E: Error>(found: &dyn fmt::Display) -> E {
        let must = match MAX {
            u64::MAX => format!("a whole number, {MIN} or more"),
            _ => format!("a whole number from {MIN} to {MAX}"),
        };
        refusal(&must, found, "")
    }
}

impl<const MIN: u64, const MAX: u64> Visitor<'_> for WholeVisitor<MIN, MAX> {
    type Value = Whole<MIN, MAX>;

    fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str("a whole number")
    }

    fn visit_u64<E: Error>(self, n: u64) -> Result<Self::Value, E> {
        if (MIN..=MAX).contains(&n) { Ok(Whole(n)) } else { Err(Self::refuse(&n)) }
    }

    fn visit_i64<E: Error>(self, n: i64) -> Result<Self::Value, E> {
        u64::try_from(n).map_err(|_| Self::refuse(&n)).and_then(|n| self.visit_u64(n))
    }

    fn visit_f64<E: Error>(self, x: f64) -> Result<Self::Value, E> {
        // Up to 2^53 every whole f64 is the number that was written.
        let exact = x.fract() == 0.0 && (0.0..=9_007_199_254_740_992.0).contains(&x);
        if exact { self.visit_u64(x as u64) } else { Err(Self::refuse(&x)) }
    }
}

/// Reads a whole number from `MIN` to `MAX`, which must fit `T`.
pub(super) fn whole<'de, const MIN: u64, const MAX: u64, T, D>(d: D) -> Result<T, D::Error>
where
    T: TryFrom<u64>,
    D: Deserializer<'de>,
{
    let n = Whole::<MIN, MAX>::deserialize(d)?.0;
    T::try_from(n).map_err(|_| WholeVisitor::<MIN, MAX>::refuse(&n))
}

/// Reads a whole number from 1, of a key that may be left out.
pub(super) fn count_if<'de, T, D>(d: D) -> Result<Option<T>, D::Error>
where
    T: TryFrom<u64>,
    D: Deserializer<'de>,
{
    whole::<1, { u64::MAX }, T, D>(d).map(Some)
}

/// Says what a table with no name of its own holds.
pub(super) trait Inline {
    /// Completes "must be".
    const MUST: &'static str;
}

/// Reads a table; serde's own structs would also take an array, field by field.
pub(super) fn table<'de, T, D>(d: D) -> Result<T, D::Error>
where
    T: Deserialize<'de> + Inline,
    D: Deserializer<'de>,
{
    d.deserialize_any(TableVisitor(PhantomData))
}

/// Reads tables by name.
pub(super) fn tables<'de, T, D>(d: D) -> Result<BTreeMap<String, T>, D::Error>
where
    T: Deserialize<'de> + Inline,
    D: Deserializer<'de>,
{
    let written = BTreeMap::<String, InlineTable<T>>::deserialize(d)?;
    Ok(written.into_iter().map(|(name, table)| (name, table.0)).collect())
}

/// A table among others.
struct InlineTable<T>(T);

impl<'de, T: Deserialize<'de> + Inline> Deserialize<'de> for InlineTable<T> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        table(deserializer).map(Self)
    }
}

/// Reads a table, of a key that may be left out.
pub(super) fn table_if<'de, T, D>(d: D) -> Result<Option<T>, D::Error>
where
    T: Deserialize<'de> + Inline,
    D: Deserializer<'de>,
{
    table(d).map(Some)
}

struct TableVisitor<T>(PhantomData<T>);

impl<'de, T: Deserialize<'de> + Inline> Visitor<'de> for TableVisitor<T> {
    type Value = T;

    fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(T::MUST)
    }

    fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<T, A::Error> {
        T::deserialize(MapAccessDeserializer::new(map))
    }
}

/// Reads one of the words of `T`.
pub(super) fn word<'de, T: Deserialize<'de>, D: Deserializer<'de>>(d: D) -> Result<T, D::Error> {
    T::deserialize(StringDeserializer::new(String::deserialize(d)?))
}

/// Reads the name of a choice.
pub(super) fn choice<'de, T: Choice, D: Deserializer<'de>>(d: D) -> Result<T, D::Error> {
    let word = String::deserialize(d)?;
    T::named(&word).ok_or_else(|| D::Error::unknown_variant(&word, T::NAMES))
}

/// Reads a time: "10m", "90s", "1.5h", or a number of seconds.
pub(super) fn time_if<'de, D: Deserializer<'de>>(d: D) -> Result<Option<Duration>, D::Error> {
    d.deserialize_any(TimeVisitor).map(Some)
}

struct TimeVisitor;

impl TimeVisitor {
    const MUST: &'static str =
        "a time above 0 such as \"10m\", \"90s\", \"1h\" or a number of seconds";
}

impl Visitor<'_> for TimeVisitor {
    type Value = Duration;

    fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(Self::MUST)
    }

    fn visit_i64<E: Error>(self, x: i64) -> Result<Duration, E> {
        self.visit_f64(x as f64)
    }

    fn visit_f64<E: Error>(self, seconds: f64) -> Result<Duration, E> {
        let time = Duration::try_from_secs_f64(seconds).ok().filter(|time| !time.is_zero());
        time.ok_or_else(|| refusal(Self::MUST, &seconds, ""))
    }

    fn visit_str<E: Error>(self, text: &str) -> Result<Duration, E> {
        let refuse = || refusal(Self::MUST, &format_args!("{text:?}"), "");
        let digits = text.trim_end_matches(|c: char| c.is_ascii_alphabetic());
        let unit = match &text[digits.len()..] {
            "s" => 1.0,
            "m" => 60.0,
            "h" => 3600.0,
            _ => return Err(refuse()),
        };
        let count: f64 = digits.trim_end().parse().map_err(|_| refuse())?;
        self.visit_f64(count * unit).map_err(|_: E| refuse())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn time(text: &str) -> Option<Duration> {
        TimeVisitor.visit_str::<serde::de::value::Error>(text).ok()
    }

    #[test]
    fn times_need_a_number_and_a_unit() {
        for text in ["", "m", "10", "10 minutes", "-1s", "0s", "infs", "nans", "1e300h", "é"] {
            assert_eq!(time(text), None, "{text}");
        }
        assert_eq!(time("10m"), Some(Duration::from_secs(600)));
        assert_eq!(time("1.5 h"), Some(Duration::from_secs(5400)));
    }
}
