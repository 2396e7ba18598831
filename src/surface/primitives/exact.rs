//! Double-double arithmetic (Dekker 1971; Hida, Li, Bailey 2001), 32 digits: the truth against
//! which error bounds are tested.

use std::ops::{Add, Mul, Sub};

use glam::{DMat3, DVec3};

/// A number as the unevaluated sum of two.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Twofold(f64, f64);

impl From<f64> for Twofold {
    fn from(x: f64) -> Self {
        Self(x, 0.0)
    }
}

/// Returns a + b without error.
fn two_sum(a: f64, b: f64) -> Twofold {
    let s = a + b;
    let t = s - a;
    Twofold(s, (a - (s - t)) + (b - t))
}

impl Add for Twofold {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        let (s, t) = (two_sum(self.0, other.0), two_sum(self.1, other.1));
        let v = two_sum(s.0, s.1 + t.0);
        two_sum(v.0, v.1 + t.1)
    }
}

impl Sub for Twofold {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        self + Self(-other.0, -other.1)
    }
}

impl Mul for Twofold {
    type Output = Self;
    fn mul(self, other: Self) -> Self {
        let p = self.0 * other.0;
        let e = self.0.mul_add(other.0, -p) + (self.0 * other.1 + self.1 * other.0);
        two_sum(p, e)
    }
}

impl Twofold {
    pub(crate) fn value(self) -> f64 {
        self.0 + self.1
    }
}

/// A vector of such numbers.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Exact(pub(crate) [Twofold; 3]);

impl From<DVec3> for Exact {
    fn from(v: DVec3) -> Self {
        Self(v.to_array().map(Twofold::from))
    }
}

impl Exact {
    pub(crate) fn minus(self, other: Self) -> Self {
        Self(std::array::from_fn(|i| self.0[i] - other.0[i]))
    }

    pub(crate) fn plus(self, other: Self) -> Self {
        Self(std::array::from_fn(|i| self.0[i] + other.0[i]))
    }

    pub(crate) fn dot(self, other: Self) -> Twofold {
        self.0[0] * other.0[0] + self.0[1] * other.0[1] + self.0[2] * other.0[2]
    }

    pub(crate) fn cross(self, other: Self) -> Self {
        let (a, b) = (self.0, other.0);
        Self([a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]])
    }

    pub(crate) fn times(self, k: f64) -> Self {
        Self(self.0.map(|x| x * k.into()))
    }

    pub(crate) fn turned(self, m: DMat3) -> Self {
        Self([0, 1, 2].map(|row| self.dot(m.row(row).into())))
    }

    pub(crate) fn value(self) -> DVec3 {
        DVec3::from_array(self.0.map(Twofold::value))
    }
}

/// Returns the signed distance of a point from a sphere, positive outside.
pub(crate) fn from_sphere(point: Exact, centre: DVec3, radius: f64) -> f64 {
    let v = point.minus(centre.into());
    let (squared, radius) = (v.dot(v), Twofold::from(radius));
    (squared - radius * radius).value() / (squared.value().sqrt() + radius.value())
}

/// Returns the signed distance of a point from a plane.
pub(crate) fn from_plane(point: Exact, on: DVec3, normal: Exact) -> f64 {
    normal.dot(point.minus(on.into())).value() / normal.value().length()
}
