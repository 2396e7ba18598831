//! An orthonormal frame about a normal.

use glam::DVec3;

/// Holds three orthonormal axes, `normal` being the local z.
///
/// Branch-free construction after Duff et al., "Building an Orthonormal Basis, Revisited", JCGT
/// 6(1), 2017.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Frame {
    /// Local x.
    pub tangent: DVec3,
    /// Local y.
    pub bitangent: DVec3,
    /// Local z.
    pub normal: DVec3,
}

impl Frame {
    /// Builds a right-handed frame whose z is the unit vector `normal`.
    pub fn about(normal: DVec3) -> Self {
        let n = normal;
        let sign = 1.0_f64.copysign(n.z);
        let a = -1.0 / (sign + n.z);
        let b = n.x * n.y * a;
        Self {
            tangent: DVec3::new(1.0 + sign * n.x * n.x * a, sign * b, -sign * n.x),
            bitangent: DVec3::new(b, sign + n.y * n.y * a, -n.y),
            normal,
        }
    }

    /// Turns local coordinates into the outer ones.
    pub fn to_world(&self, local: DVec3) -> DVec3 {
        local.x * self.tangent + local.y * self.bitangent + local.z * self.normal
    }

    /// Turns outer coordinates into the local ones.
    pub fn to_local(&self, world: DVec3) -> DVec3 {
        DVec3::new(world.dot(self.tangent), world.dot(self.bitangent), world.dot(self.normal))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frame_is_orthonormal_and_right_handed_everywhere() {
        for normal in [
            DVec3::Z,
            DVec3::NEG_Z,
            DVec3::X,
            DVec3::new(1e-9, -1e-9, -1.0).normalize(),
            DVec3::new(0.3, -0.5, 0.2).normalize(),
        ] {
            let f = Frame::about(normal);
            assert!((f.tangent.cross(f.bitangent) - normal).length() <= 1e-15);
            assert!((f.tangent.length() - 1.0).abs() <= 1e-15);
            let v = DVec3::new(0.1, 0.2, 0.3);
            assert!((f.to_local(f.to_world(v)) - v).length() <= 1e-15);
        }
    }
}
