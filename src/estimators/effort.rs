//! How many rays gather for a sensor beside the walks that are connected to it.
//!
//! Connections to n walks leave the variance v / n, m gathering rays w / m. With c the cost of a
//! ray in walks, the product of variance and time is least for m / n = sqrt(w / (c v)). Rays are
//! planned when the walks have doubled, from what was seen before. What comes later has its weight
//! whatever was seen, and random numbers of its own, as points of one scrambled sequence know of
//! each other; so, given what came before, its mean is right.

use super::cloud::WALKS;

/// The cost of a gathering ray in walks that are connected to a sensor.
const RAY: f64 = 4.0;

/// The fewest and the most rays to a cloud.
const FEWEST: usize = 4;
const MOST: usize = 128;

/// Holds how many rays gather for a sensor.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Effort {
    /// Rays so far, in each replicate.
    pub(super) rays: u64,
    /// How many of them there were when the last plan was made: where the numbers of the present
    /// plan begin.
    pub(super) planned: u64,
    /// Rays to a cloud of [`WALKS`] walks, from now on.
    to_cloud: usize,
}

impl Default for Effort {
    /// As many rays as walks.
    fn default() -> Self {
        Self { rays: 0, planned: 0, to_cloud: WALKS }
    }
}

impl Effort {
    /// Returns the number of rays, at least one, for a cloud of so many walks.
    pub(super) fn rays_for(self, walks: usize) -> usize {
        (self.to_cloud * walks / WALKS).max(1)
    }

    /// Plans from the variances, over replicates of so many walks, of what connections and what
    /// rays brought.
    pub(super) fn plan(&mut self, walks: u64, connected: f64, gathered: f64) {
        self.planned = self.rays;
        let (v, w) = (connected * walks as f64, gathered * self.rays as f64);
        let ratio = (w / (RAY * v)).sqrt();
        if ratio.is_finite() {
            let rays = (ratio * WALKS as f64).clamp(FEWEST as f64, MOST as f64);
            self.to_cloud = 1 << rays.log2().round() as u32;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rays_go_where_they_lower_variance() {
        let planned = |connected, gathered| {
            let mut effort = Effort { rays: 64, ..Effort::default() };
            effort.plan(64, connected, gathered);
            effort.rays_for(WALKS)
        };
        assert_eq!([planned(1.0, 4.0), planned(1.0, 1.0), planned(1.0, 0.25)], [32, 16, 8]);
        assert_eq!([planned(1.0, 0.0), planned(1e-9, 1.0)], [FEWEST, MOST]);
        // Nothing is known, nothing is changed.
        assert_eq!([planned(0.0, 0.0), planned(f64::NAN, 1.0)], [WALKS, WALKS]);
        assert_eq!(Effort::default().rays_for(4), 4);
        assert_eq!(Effort { to_cloud: FEWEST, ..Effort::default() }.rays_for(4), 1);
    }
}
