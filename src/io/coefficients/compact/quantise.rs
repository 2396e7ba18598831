//! Chooses the step, the law and the whole numbers of a compact file: as few bits as the tolerance
//! allows.
//!
//! In an orthonormal basis all coefficients share one step (reverse water-filling: the error is
//! white where the signal is above it, and what is below the step vanishes by itself). A value goes
//! to the whole number q that least costs (x - q)^2 + lambda bits(q), in units of the step: near
//! the middle between two numbers the shorter one wins, and the step shrinks a little to pay for
//! it.

use super::model::{Context, LARGEST, Law, Place, Surroundings};

/// Numbers the steps by the upper half of the bits of an f32: the smallest normal one, and the
/// largest.
const FIRST_STEP: u16 = 0x0080;
const LAST_STEP: u16 = 0x7f7f;
/// A factor of two in step numbers.
const OCTAVE: u16 = 128;
/// How far above the least promising step, and below a known one, is searched.
const ROOM: u16 = 12 * OCTAVE;
const REACH: u16 = OCTAVE / 2;

/// The prices of a bit that are tried, in squared steps.
const PRICES: [f64; 5] = [0.04, 0.07, 0.1, 0.13, 0.16];

/// The most coefficients of which all are looked at to choose a law and a price.
const MANY: usize = 1 << 14;

/// Returns the step with a number: all its 8 significant bits are in the 16 bits of the number.
pub(super) fn step(number: u16) -> f64 {
    f64::from(f32::from_bits(u32::from(number) << 16))
}

/// Whether [`step`] is a normal positive number.
pub(super) fn is_step(number: u16) -> bool {
    (FIRST_STEP..=LAST_STEP).contains(&number)
}

/// Holds what goes into a file.
#[derive(Debug, Clone)]
pub(super) struct Choice {
    pub(super) law: Law,
    pub(super) step: u16,
    /// The whole numbers, in the order of [`Place::index`], degree 0 first.
    pub(super) numbers: Vec<i64>,
    bits: f64,
}

/// What is to be coded, and how well.
struct Problem<'a> {
    values: &'a [f64],
    lmax: usize,
    tolerance: f64,
}

/// Quantises orthonormal coefficients (in the order of [`Place::index`]) to a root of summed
/// squared errors of at most `tolerance`, > 0. `None` when no step is small enough.
pub(super) fn choose(values: &[f64], lmax: usize, tolerance: f64) -> Option<Choice> {
    let problem = Problem { values, lmax, tolerance };
    let start = Law { mirrors: 0, tail: 2, decay: 4, level: 24 };
    let plain = largest(&problem, start, 0.0, None)?;
    let mut best = improved(plain, lmax);
    // Past this many coefficients the best price is always about the same.
    let prices = if values.len() > MANY { &PRICES[2..3] } else { &PRICES };
    let (law, near) = (best.law, Some(best.step));
    for price in prices {
        match largest(&problem, law, *price, near) {
            Some(choice) if choice.bits < best.bits => best = choice,
            _ => {}
        }
    }
    Some(improved(best, lmax))
}

/// Finds a largest step that keeps the tolerance at a price, by bisection (the error grows with the
/// step, if not strictly), among all or around `near`.
fn largest(problem: &Problem, law: Law, price: f64, near: Option<u16>) -> Option<Choice> {
    let keeps = |number: u16| {
        let numbers = quantised(problem, number, law, price)?;
        (error(problem.values, &numbers, step(number)) <= problem.tolerance).then_some(numbers)
    };
    // Plain rounding keeps half of the tolerance at this step, whatever the values.
    let least = step_below(problem.tolerance / (problem.values.len() as f64).sqrt())?;
    let (mut low, mut high) = match near {
        Some(near) => (near.saturating_sub(REACH).max(least), near + REACH / 4),
        None => (least, least + ROOM),
    };
    let mut best = keeps(low)?;
    while high - low > 1 {
        let middle = low + (high - low) / 2;
        match keeps(middle) {
            Some(numbers) => (low, best) = (middle, numbers),
            None => high = middle,
        }
    }
    let bits = Known::new(&best, problem.lmax, law, 1).cost(law);
    Some(Choice { law, step: low, numbers: best, bits })
}

/// Returns the number of the largest step up to `size`, when there is one with room above it.
fn step_below(size: f64) -> Option<u16> {
    let number = ((size as f32).to_bits() >> 16) as u16;
    (FIRST_STEP..LAST_STEP - ROOM).contains(&number).then_some(number)
}

fn quantised(problem: &Problem, number: u16, law: Law, price: f64) -> Option<Vec<i64>> {
    let step = step(number);
    if price == 0.0 {
        return problem.values.iter().map(|value| whole(value / step)).collect();
    }
    let mut context = Context::new(law);
    let mut numbers = Vec::with_capacity(problem.values.len());
    numbers.push(whole(problem.values.first()? / step)?);
    for place in Place::all(problem.lmax) {
        let value = cheapest(problem.values[place.index()] / step, &context, place, price)?;
        context.push(value);
        numbers.push(value);
    }
    Some(numbers)
}

/// Chooses between the nearest number, its neighbour towards zero, and zero.
fn cheapest(x: f64, context: &Context, place: Place, price: f64) -> Option<i64> {
    let distribution = context.next(place);
    let nearest = whole(x)?;
    if distribution.shift > 0 {
        return Some(nearest);
    }
    let cost = |value: i64| (x - value as f64).powi(2) + price * distribution.bits(value);
    let mut best = (nearest, cost(nearest));
    for value in [nearest - nearest.signum(), 0] {
        let cost = cost(value);
        if cost < best.1 {
            best = (value, cost);
        }
    }
    Some(best.0)
}

fn whole(x: f64) -> Option<i64> {
    (x.abs() <= LARGEST as f64).then(|| x.round() as i64)
}

/// Returns the root of the summed squared errors.
fn error(values: &[f64], numbers: &[i64], step: f64) -> f64 {
    let squares = values.iter().zip(numbers).map(|(x, q)| (x - *q as f64 * step).powi(2));
    squares.sum::<f64>().sqrt()
}

/// Chooses the law anew for the numbers that are given.
fn improved(choice: Choice, lmax: usize) -> Choice {
    // Of very many numbers some tell as much; an odd stride meets cosines and sines alike.
    let stride = choice.numbers.len().div_ceil(MANY) | 1;
    let known_as = |law: Law| Known::new(&choice.numbers, lmax, law, stride);
    let mut best = (known_as(choice.law).cost(choice.law), choice.law);
    for mirrors in 0..8 {
        // What stands around a place depends on the mirrors alone: the rest of the law is cheap to
        // vary.
        let known = known_as(Law { mirrors, ..choice.law });
        let mut law = Law { mirrors, ..best.1 };
        let mut bits = known.cost(law);
        loop {
            let before = law;
            for other in neighbours(before) {
                let cost = known.cost(other);
                if cost < bits {
                    (bits, law) = (cost, other);
                }
            }
            if law == before {
                break;
            }
        }
        if bits < best.0 {
            best = (bits, law);
        }
    }
    let law = best.1;
    let bits = Known::new(&choice.numbers, lmax, law, 1).cost(law);
    Choice { law, bits, ..choice }
}

/// Lists the laws that differ in the tail, or a little in the power law.
fn neighbours(law: Law) -> impl Iterator<Item = Law> {
    let tails = (0..4).map(move |tail| Law { tail, ..law });
    let powers = [-1, 0, 1].into_iter().flat_map(move |steeper| {
        [-4, -1, 0, 1, 4].map(move |up| Law {
            decay: law.decay.saturating_add_signed(steeper).min(7),
            level: law.level.saturating_add_signed(up),
            ..law
        })
    });
    tails.chain(powers)
}

/// Holds numbers, all or one of so many, together with what stands around each.
struct Known(Vec<(usize, Surroundings, i64)>);

impl Known {
    fn new(numbers: &[i64], lmax: usize, law: Law, stride: usize) -> Self {
        let mut context = Context::new(law);
        let mut known = Vec::with_capacity(numbers.len() / stride + 1);
        for place in Place::all(lmax) {
            let value = numbers[place.index()];
            if place.index().is_multiple_of(stride) {
                known.push((place.l, context.surroundings(place), value));
            }
            context.push(value);
        }
        Self(known)
    }

    /// Returns the information in these numbers, bits.
    fn cost(&self, law: Law) -> f64 {
        self.0.iter().map(|(l, around, value)| law.distribution(*l, *around).bits(*value)).sum()
    }
}
