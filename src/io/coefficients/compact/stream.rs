//! The whole numbers as bytes and back, by the range coder of the crate `constriction` under the
//! model of `model.rs`.
//!
//! A number is split by its distribution into a symbol and `shift` last bits. The symbols -2048 and
//! 2048 stand for all beyond; how far beyond follows as an Elias gamma code. Bits written out are
//! coded with even odds, 16 at a time. The 32-bit words of the coder are stored with their most
//! significant byte first; the coder reads zeros past the end, so zeros at the end are not stored.

use constriction::stream::model::UniformModel;
use constriction::stream::queue::{DefaultRangeDecoder, DefaultRangeEncoder};
use constriction::stream::{Decode, Encode};

use super::model::{Context, Distribution, END, Law, PRECISION, Place, clamp};
use crate::{Error, Result};

/// The most bits that are coded at once with even odds.
const CHUNK: u32 = 16;

/// Codes the numbers past degree 0 (in the order of [`Place::index`]) in as few bytes as decode to
/// them.
pub(super) fn write(numbers: &[i64], lmax: usize, law: Law) -> Result<Vec<u8>> {
    let mut writer = Writer(DefaultRangeEncoder::new());
    let mut context = Context::new(law);
    for place in Place::all(lmax) {
        let value = numbers[place.index()];
        writer.value(value, context.next(place))?;
        context.push(value);
    }
    let words = writer.0.into_compressed().map_err(|_| refused())?;
    let bytes = words.into_iter().flat_map(u32::to_be_bytes).collect();
    Ok(shortened(bytes, |bytes| read(bytes, lmax, law).is_some_and(|found| found == numbers[1..])))
}

fn refused() -> Error {
    Error::Numeric("the range coder refused a coefficient".into())
}

/// Drops bytes from the end, the last one that stays raised by one where that helps, as long as
/// `same` holds.
fn shortened(mut bytes: Vec<u8>, same: impl Fn(&[u8]) -> bool) -> Vec<u8> {
    while let Some((_, kept)) = bytes.split_last() {
        let mut raised = kept.to_vec();
        if let Some(last) = raised.last_mut() {
            *last = last.saturating_add(1);
        }
        match [kept.to_vec(), raised].into_iter().find(|bytes| same(bytes)) {
            Some(shorter) => bytes = shorter,
            None => break,
        }
    }
    bytes
}

/// Decodes the numbers past degree 0; `None` when the bytes are not what [`write`] writes.
pub(super) fn read(bytes: &[u8], lmax: usize, law: Law) -> Option<Vec<i64>> {
    let words: Vec<u32> = bytes.chunks(4).map(word).collect();
    let mut reader = Reader(DefaultRangeDecoder::from_compressed(words).ok()?);
    let mut context = Context::new(law);
    for place in Place::all(lmax) {
        let value = reader.value(context.next(place))?;
        context.push(value);
    }
    Some(context.into_values())
}

fn word(bytes: &[u8]) -> u32 {
    let mut word = [0; 4];
    word[..bytes.len()].copy_from_slice(bytes);
    u32::from_be_bytes(word)
}

struct Writer(DefaultRangeEncoder);

impl Writer {
    fn value(&mut self, value: i64, distribution: Distribution) -> Result<()> {
        let (coarse, rest) = distribution.split(value);
        let symbol = clamp(coarse);
        self.0.encode_symbol(symbol, distribution).map_err(|_| refused())?;
        if symbol.abs() == END {
            self.gamma(coarse.unsigned_abs() - u64::from(END.unsigned_abs()))?;
        }
        self.bits(rest, distribution.shift)
    }

    /// Writes the number of digits of n + 1, less one, in unary, and its digits past the first.
    fn gamma(&mut self, n: u64) -> Result<()> {
        let digits = (n + 1).ilog2();
        for _ in 0..digits {
            self.bits(0, 1)?;
        }
        self.bits(1, 1)?;
        self.bits(n + 1 - (1 << digits), digits)
    }

    fn bits(&mut self, bits: u64, count: u32) -> Result<()> {
        let (mut bits, mut left) = (bits, count);
        while left > 0 {
            let taken = left.min(CHUNK);
            let chunk = (bits & ((1 << taken) - 1)) as usize;
            self.0.encode_symbol(chunk, even(taken)).map_err(|_| refused())?;
            bits >>= taken;
            left -= taken;
        }
        Ok(())
    }
}

struct Reader(DefaultRangeDecoder);

impl Reader {
    fn value(&mut self, distribution: Distribution) -> Option<i64> {
        let symbol = self.0.decode_symbol(distribution).ok()?;
        let mut coarse = i64::from(symbol);
        if symbol.abs() == END {
            coarse += i64::from(symbol.signum()) * i64::try_from(self.gamma()?).ok()?;
        }
        let rest = self.bits(distribution.shift)?;
        distribution.join(coarse, rest)
    }

    fn gamma(&mut self) -> Option<u64> {
        let mut digits = 0;
        while self.bits(1)? == 0 {
            digits += 1;
            if digits > 60 {
                return None;
            }
        }
        Some((1 << digits) - 1 + self.bits(digits)?)
    }

    fn bits(&mut self, count: u32) -> Option<u64> {
        let (mut bits, mut done) = (0, 0);
        while done < count {
            let taken = (count - done).min(CHUNK);
            let chunk = self.0.decode_symbol(even(taken)).ok()?;
            bits |= (chunk as u64) << done;
            done += taken;
        }
        Some(bits)
    }
}

/// Returns all numbers of so many bits the same probability.
fn even(bits: u32) -> UniformModel<u32, PRECISION> {
    UniformModel::new(1 << bits)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::io::coefficients::compact::model::LARGEST;

    const LAW: Law = Law { mirrors: 1, tail: 2, decay: 4, level: 20 };

    /// Numbers of all sizes in an order without sense.
    fn numbers(count: usize, largest: u32) -> Vec<i64> {
        let mut state = 1_u64;
        let mut next = || {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            state >> 33
        };
        (0..count)
            .map(|_| {
                let size = next() % u64::from(largest + 1);
                let value = ((next() << 31 | next()) & ((1 << size) - 1)) as i64;
                if next() % 2 == 0 { value } else { -value }
            })
            .collect()
    }

    #[test]
    fn degree_zero_takes_no_bytes() {
        assert!(write(&[5], 0, LAW).expect("coded").is_empty());
        assert_eq!(read(&[], 0, LAW), Some(vec![]));
    }

    #[test]
    fn numbers_of_all_sizes_come_back() {
        for (largest, degrees) in [(3, 0..=64), (0, 1..=9), (10, 1..=9), (20, 1..=9), (50, 1..=9)] {
            for lmax in degrees {
                for law in [
                    LAW,
                    Law { mirrors: 7, tail: 0, decay: 0, level: 0 },
                    Law { mirrors: 0, tail: 3, decay: 7, level: 255 },
                ] {
                    let numbers = numbers((lmax + 1) * (lmax + 1), largest);
                    let bytes = write(&numbers, lmax, law).expect("coded");
                    assert_eq!(read(&bytes, lmax, law).expect("decoded"), numbers[1..]);
                }
            }
        }
        let extremes = [0, LARGEST, -LARGEST, 0];
        let bytes = write(&extremes, 1, LAW).expect("coded");
        assert_eq!(read(&bytes, 1, LAW).expect("decoded"), extremes[1..]);
    }

    #[test]
    fn length_is_the_information() {
        let (lmax, numbers) = (20, numbers(441, 6));
        let mut context = Context::new(LAW);
        let bits: f64 = Place::all(lmax)
            .map(|place| {
                let bits = context.next(place).bits(numbers[place.index()]);
                context.push(numbers[place.index()]);
                bits
            })
            .sum();
        let bytes = write(&numbers, lmax, LAW).expect("coded");
        // The coder ends on a whole byte, and zeros that its words happen to end with are not
        // stored.
        let spare = 8.0 * bytes.len() as f64 - bits;
        assert!((-16.0..=16.0).contains(&spare), "{spare}");
    }

    #[test]
    fn bytes_without_sense_do_no_harm() {
        for seed in 0..500_u64 {
            let noise: Vec<u8> =
                (0..60).map(|i| (((seed * 77 + i * i * 31) * 2_654_435_761) >> 13) as u8).collect();
            let law = Law::from_bytes([noise[0], noise[1]]);
            if let Some(values) = read(&noise[2..], 12, law) {
                assert!(values.iter().all(|v| v.abs() <= LARGEST));
            }
        }
    }
}
