//! The paper's intersector: march with a fixed step until the gap changes sign, then bisect (the
//! "fork" method after eq. 33).
//!
//! It is kept because the paper's figures are made with it. **It can miss**: a lobe thinner than
//! the step, or a ray that grazes, is jumped over without notice. Use certified stepping where a
//! miss matters.

use super::radial::{Gap, RadialBody};
use crate::math::Ray;

/// Sets the march, relative to the largest radius of the body.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StepBisection {
    /// The step of the march, in largest radii; at least [`StepBisection::SHORTEST_STEP`].
    pub step: f64,
    /// The length, in largest radii, of the bracket at which bisection ends; positive.
    pub tolerance: f64,
}

impl Default for StepBisection {
    fn default() -> Self {
        Self { step: 0.01, tolerance: 1e-9 }
    }
}

impl StepBisection {
    /// The shortest step, in largest radii: a ray through the body takes 200 000 of them.
    pub const SHORTEST_STEP: f64 = 1e-5;

    /// Finds the first sign change of the gap that the march sees, with the gap at the end of the
    /// bisection.
    pub fn first_crossing(&self, body: &RadialBody, ray: &Ray) -> Option<(f64, Gap)> {
        let chord = body.chord(ray)?;
        let step = self.step * body.bounds().max;
        let mut before = chord.start;
        let inside = body.gap_value(ray.at(before)) < 0.0;
        while before < chord.end {
            let after = (before + step).max(before.next_up()).min(chord.end);
            if (body.gap_value(ray.at(after)) < 0.0) != inside {
                return Some(self.bisect(body, ray, before, after, inside));
            }
            before = after;
        }
        None
    }

    fn bisect(
        &self,
        body: &RadialBody,
        ray: &Ray,
        before: f64,
        after: f64,
        inside: bool,
    ) -> (f64, Gap) {
        let width = self.tolerance * body.bounds().max;
        let (mut low, mut high) = (before, after);
        while high - low > width {
            let middle = 0.5 * (low + high);
            if middle <= low || middle >= high {
                break;
            }
            if (body.gap_value(ray.at(middle)) < 0.0) == inside {
                low = middle;
            } else {
                high = middle;
            }
        }
        (low, body.gap(ray, low))
    }
}
