//! How light is divided between connections to walks and gathering rays (see
//! [`connect`](super::connect)).

use std::f64::consts::PI;

use crate::scene::Scene;

/// Divides light between connections to walks (share c) and gathering rays (share 1 - c), as a
/// function of the kernel K in 1/m2.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Weighting {
    /// The paper's plain estimate, for pictures its strategy A: all by connection, c = 1; its
    /// variance is unbounded near edges.
    Walk,
    /// The paper's strategy B (eq. 12 as written): a gathering ray finds an intermediate point (c =
    /// 0), and all is connected to that (c = 1 there). Its variance is unbounded, too, where the
    /// intermediate point is near an edge.
    Gather,
    /// The bounded kernel, c = min(1, b / (K s)), s the peak of the reflection there.
    Bounded {
        /// The largest K s that is connected in full, 1/m2.
        bound: f64,
    },
}

/// See [`Weighting::raised`].
const PEAK: f64 = 16.0;

impl Weighting {
    /// Takes the default of the crate for a scene: the bounded kernel with b = 20 / total area. Of
    /// 5, 10, 20, 40, 80 and 200 it takes the least time to a given error in two rooms, or as good
    /// as the least (80 takes 1.1 to 2.4 times, 5 takes 2.4 to 2.9 times as much), and 2 to 5 times
    /// the least between discs.
    pub fn of(scene: &Scene) -> Self {
        if scene.area() > 0.0 { Self::Bounded { bound: 20.0 / scene.area() } } else { Self::Walk }
    }

    /// Raises the bound of the kernel to [`PEAK`] times the illuminance of a receiver per lumen
    /// that is shed, 1/m2, so that no hit of a walk brings more than that many times the mean.
    /// Where light is gathered before it has spread over the scene, the bound for the scene is far
    /// less.
    pub(super) fn raised(self, illuminance: f64) -> Self {
        match self {
            Self::Bounded { bound } => Self::Bounded { bound: bound.max(PEAK * illuminance) },
            Self::Walk | Self::Gather => self,
        }
    }

    /// Returns the share of the connection to a hit of a walk, for the first estimate or for one
    /// that a gathering ray led to.
    pub(super) fn share(&self, first: bool, kernel: f64, peak: f64) -> f64 {
        (self.limit(first) / (kernel * peak)).min(1.0)
    }

    /// Returns up to which K s a hit is connected in full, 1/m2: of K s, min(K s, limit) is the
    /// share of the connection.
    pub(super) fn limit(&self, first: bool) -> f64 {
        match *self {
            Self::Gather if first => 0.0,
            Self::Walk | Self::Gather => f64::INFINITY,
            Self::Bounded { bound } => bound,
        }
    }

    /// Whether connections leave anything to the gathering ray of the first estimate, or of one
    /// that a gathering ray led to.
    pub(super) fn gathers(&self, first: bool) -> bool {
        self.limit(first).is_finite()
    }

    /// Returns the share of the connection to a walk's start, which has a known density p: c =
    /// min(1, pi p / K), where K / pi is the density with which the gathering ray finds it.
    ///
    /// So the connection brings pi M at most, and the ray is left with what it finds more often
    /// than walks start there. The balance heuristic, c = pi p / (pi p + K), leaves a little of
    /// everything to the ray: of a small lamp, which it seldom meets, a rare large term whose
    /// absence no interval knows.
    pub(super) fn start_share(&self, kernel: f64, density: f64) -> f64 {
        match self {
            Self::Walk | Self::Gather => 1.0,
            Self::Bounded { .. } if kernel <= PI * density => 1.0,
            Self::Bounded { .. } => PI * density / kernel,
        }
    }

    /// Returns how far a gathering ray can find anything that the connection leaves to it: emission
    /// at any distance, diffuse reflection only where the kernel is cut.
    pub(super) fn reach(&self, scene: &Scene) -> f64 {
        match self {
            Self::Bounded { bound } if scene.emitters().is_empty() && scene.is_diffuse() => {
                bound.sqrt().recip()
            }
            _ => f64::INFINITY,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bounds_are_raised_where_it_is_bright_and_never_lowered() {
        let bounded = |bound| Weighting::Bounded { bound };
        let raised = [0.0, 0.1, 2.0, f64::NAN].map(|e| bounded(4.0).raised(e));
        assert_eq!(raised, [4.0, 4.0, 2.0 * PEAK, 4.0].map(bounded));
        assert_eq!(
            [Weighting::Walk, Weighting::Gather].map(|w| w.raised(9.0)),
            [Weighting::Walk, Weighting::Gather]
        );
    }
}
