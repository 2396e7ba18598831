//! Gauss-Legendre rules on the intervals the other rooms integrate over.

use std::num::NonZeroUsize;

use gauss_quad::GaussLegendre;

/// Holds the nodes and weights of a quadrature rule on an interval.
#[derive(Debug, Clone, PartialEq)]
pub struct Rule {
    /// The nodes in ascending order.
    pub nodes: Vec<f64>,
    /// The weights, in the order of the nodes; they add up to the length of the interval.
    pub weights: Vec<f64>,
}

impl Rule {
    /// Builds the Gauss-Legendre rule with `n` nodes (at least 1) on [-1, 1]: exact for polynomials
    /// of degree 2n - 1.
    pub fn gauss_legendre(n: usize) -> Self {
        let n = NonZeroUsize::new(n).unwrap_or(NonZeroUsize::MIN);
        let mut pairs: Vec<(f64, f64)> =
            GaussLegendre::new(n).iter().map(|(x, w)| (*x, *w)).collect();
        pairs.sort_by(|a, b| a.0.total_cmp(&b.0));
        let (nodes, weights) = pairs.into_iter().unzip();
        Self { nodes, weights }
    }

    /// Moves the rule from [-1, 1] to [a, b].
    pub fn on(mut self, a: f64, b: f64) -> Self {
        let (half, middle) = (0.5 * (b - a), 0.5 * (a + b));
        self.nodes.iter_mut().for_each(|x| *x = middle + half * *x);
        self.weights.iter_mut().for_each(|w| *w *= half);
        self
    }

    /// Returns (node, weight) pairs.
    pub fn iter(&self) -> impl ExactSizeIterator<Item = (f64, f64)> + '_ {
        self.nodes.iter().copied().zip(self.weights.iter().copied())
    }

    /// Integrates `f` over the interval of the rule.
    pub fn integrate(&self, mut f: impl FnMut(f64) -> f64) -> f64 {
        self.iter().map(|(x, w)| w * f(x)).sum()
    }
}

#[cfg(test)]
mod tests {
    use approx::assert_abs_diff_eq;

    use super::*;

    #[test]
    fn rule_is_exact_for_its_degree() {
        for n in [1, 2, 5, 33, 400] {
            let rule = Rule::gauss_legendre(n);
            let degree = i32::try_from(2 * n - 2).expect("small");
            let exact = 2.0 / f64::from(degree + 1);
            // Nodes and weights are good to 4e-16; powers amplify that by the degree.
            let tolerance = 1e-15 * f64::from(degree + 2);
            assert!((rule.integrate(|x| x.powi(degree)) - exact).abs() <= tolerance, "n = {n}");
        }
    }

    #[test]
    fn moved_rule_keeps_the_length() {
        let rule = Rule::gauss_legendre(7).on(2.0, 5.0);
        assert_abs_diff_eq!(rule.integrate(|_| 1.0), 3.0, epsilon = 1e-14);
        assert_abs_diff_eq!(rule.integrate(|x| x * x), 39.0, epsilon = 1e-12);
    }
}
