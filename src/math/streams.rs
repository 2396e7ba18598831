//! Random streams: numbers in [0, 1) that depend on a seed and an index only, never on the thread
//! that asks.
//!
//! Owen-scrambled Sobol points (Burley, "Practical Hash-based Owen Scrambling", JCGT 9(4), 2020)
//! carry 2^16 points a scramble and 256 dimensions; past either limit a stream continues under an
//! independent scramble. Plain random numbers are there to compare with.

use rand::{RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;

/// Chooses where random numbers come from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Randomness {
    /// Owen-scrambled Sobol points: the same mean, a smaller variance.
    #[default]
    Sobol,
    /// Pseudo-random numbers, as in the paper of 2012.
    Pseudorandom,
}

/// Mixes words into one 64-bit number (`SplitMix64` steps); equal inputs give equal outputs,
/// neighbours unrelated ones.
pub fn hash<const N: usize>(words: [u64; N]) -> u64 {
    words.into_iter().fold(0x9e37_79b9_7f4a_7c15, |state, word| {
        let mut z = (state ^ word).wrapping_add(0x9e37_79b9_7f4a_7c15);
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    })
}

/// Hands out the coordinates of one sample, four at a time.
#[derive(Debug, Clone)]
pub struct Stream {
    source: Source,
}

#[derive(Debug, Clone)]
enum Source {
    Sobol { seed: u64, index: u64, set: u32 },
    Pseudorandom(Xoshiro256PlusPlus),
}

/// Points one scramble can give.
const POINTS_PER_SCRAMBLE: u64 = 1 << 16;
/// Groups of four dimensions one scramble can give.
const SETS_PER_SCRAMBLE: u32 = 64;

impl Stream {
    /// Opens the stream of sample `index` of the sequence `seed`. Sequences with different seeds
    /// are independent.
    pub fn new(randomness: Randomness, seed: u64, index: u64) -> Self {
        let source = match randomness {
            Randomness::Sobol => Source::Sobol { seed, index, set: 0 },
            Randomness::Pseudorandom => {
                Source::Pseudorandom(Xoshiro256PlusPlus::seed_from_u64(hash([seed, index])))
            }
        };
        Self { source }
    }

    /// Returns the next four coordinates, each uniform in [0, 1).
    pub fn next_4d(&mut self) -> [f64; 4] {
        match &mut self.source {
            Source::Sobol { seed, index, set } => {
                let scramble = hash([
                    *seed,
                    *index / POINTS_PER_SCRAMBLE,
                    u64::from(*set / SETS_PER_SCRAMBLE),
                ]);
                let point = sobol_burley::sample_4d(
                    (*index % POINTS_PER_SCRAMBLE) as u32,
                    *set % SETS_PER_SCRAMBLE,
                    (scramble >> 32) as u32,
                );
                *set += 1;
                point.map(f64::from)
            }
            Source::Pseudorandom(rng) => rng.random(),
        }
    }

    /// Returns two coordinates, each uniform in [0, 1); the other two of their group are dropped.
    pub fn next_2d(&mut self) -> [f64; 2] {
        let [u, v, ..] = self.next_4d();
        [u, v]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stream_depends_on_seed_and_index_only() {
        for randomness in [Randomness::Sobol, Randomness::Pseudorandom] {
            let take = |seed, index| {
                let mut s = Stream::new(randomness, seed, index);
                [s.next_4d(), s.next_4d()]
            };
            assert_eq!(take(7, 3), take(7, 3));
            assert_ne!(take(7, 3), take(8, 3));
            assert_ne!(take(7, 3), take(7, 4));
        }
    }

    #[test]
    fn stream_goes_on_past_the_limits_of_one_scramble() {
        let mut s = Stream::new(Randomness::Sobol, 1, (1 << 16) + 5);
        let points: Vec<_> = (0..130).map(|_| s.next_4d()).collect();
        assert!(points.iter().flatten().all(|u| (0.0..1.0).contains(u)));
        assert_ne!(points[0], points[64]);
        assert_ne!(Stream::new(Randomness::Sobol, 1, 5).next_4d(), points[0]);
    }

    #[test]
    fn sobol_points_fill_evenly() {
        // 256 points of a (0, m, 2)-net hit each of 256 elementary intervals along one axis exactly
        // once.
        let mut seen = [false; 256];
        for i in 0..256 {
            let [u, ..] = Stream::new(Randomness::Sobol, 42, i).next_4d();
            seen[(u * 256.0) as usize] = true;
        }
        assert!(seen.into_iter().all(|s| s));
    }
}
