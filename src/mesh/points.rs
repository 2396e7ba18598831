//! Points without faces.

use glam::DVec3;

/// Holds points in space with their weights.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Points {
    /// The points, metres as the file has them.
    pub positions: Vec<DVec3>,
    /// The weight of each point, at least 0; 1 where the file has none.
    pub weights: Vec<f64>,
}
