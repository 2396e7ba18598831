//! The stages of a run, and which of their rounds a pixel takes part in.
//!
//! A round is one pass for each replicate. Stages double what there is: round 0, round 1, rounds 2
//! and 3, 4 to 7, 8 to 15, ... Within a stage a pixel of stride s takes part in one round of every
//! s and weighs its sample by s. Strides are fixed before their stage begins, so a stage has the
//! same weight in the mean of a pixel whatever was seen before, and the mean of a fixed number of
//! stages is unbiased: each stage is, given all earlier ones. Numbers of samples that followed what
//! was seen would give bright accidents a lower weight.

use crate::math::hash;

/// The largest stride is 2 to this power: a pixel that is known takes part in one round of 64.
pub(crate) const MAX_STRIDE_LOG2: u8 = 6;

/// Says where in a run a number of complete rounds is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Stage {
    /// Rounds before the stage.
    pub(super) start: u64,
    /// Rounds of the stage.
    pub(super) length: u64,
}

impl Stage {
    /// Returns the stage of a round.
    pub(super) fn of(round: u64) -> Self {
        match round.checked_ilog2() {
            None => Self { start: 0, length: 1 },
            Some(k) => Self { start: 1 << k, length: 1 << k },
        }
    }

    /// Returns the logarithm of the largest stride the stage has room for.
    pub(super) fn longest(&self) -> u8 {
        (self.length.ilog2() as u8).min(MAX_STRIDE_LOG2)
    }

    /// Returns which round of every s a pixel takes part in, s = 2^`stride`; it follows from
    /// nothing seen.
    pub(super) fn phase(&self, pixel: usize, stride: u8) -> u64 {
        if stride == 0 { 0 } else { hash([pixel as u64, self.start]) & ((1 << stride) - 1) }
    }

    /// Returns the weight of what a pixel has gathered in one replicate when the first `rounds` of
    /// the stage are done, the earlier stages included.
    pub(super) fn weight(&self, pixel: usize, stride: u8, rounds: u64) -> u64 {
        let rest = rounds & ((1 << stride) - 1);
        let begun = u64::from(rest > self.phase(pixel, stride));
        self.start + (((rounds >> stride) + begun) << stride)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stages_double() {
        let spans: Vec<_> = (0..9).map(Stage::of).map(|s| (s.start, s.length)).collect();
        assert_eq!(spans[..4], [(0, 1), (1, 1), (2, 2), (2, 2)]);
        assert_eq!(spans[4..], [(4, 4), (4, 4), (4, 4), (4, 4), (8, 8)]);
    }

    #[test]
    fn whole_stage_weighs_its_rounds_whatever_the_stride() {
        let stage = Stage::of(64);
        for (pixel, stride) in (0..50).flat_map(|p| (0..=stage.longest()).map(move |s| (p, s))) {
            assert_eq!(stage.weight(pixel, stride, 0), 64);
            assert_eq!(stage.weight(pixel, stride, 64), 128);
            let phase = stage.phase(pixel, stride);
            let mut weight = 64;
            for round in 0..64 {
                let active = round & ((1 << stride) - 1) == phase;
                weight += if active { 1 << stride } else { 0 };
                assert_eq!(stage.weight(pixel, stride, round + 1), weight);
            }
        }
    }
}
