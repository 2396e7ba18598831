//! A broken rule: which, by which answer to which ray; printed with all bits, so that the ray can
//! become a regression test.

use std::fmt;

use glam::DVec3;

use harmolux::math::Ray;
use harmolux::surface::Hit;

/// Faults whose rays are kept; the others are only counted.
pub(super) const FAULTS_KEPT: usize = 8;

/// Names the way a surface was asked.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum RayQuestion {
    /// The first hit of one ray.
    Hit,
    /// The first hits of a batch.
    Hits,
    /// Whether one ray is blocked.
    Blocked,
    /// Which rays of a batch are blocked.
    MarkBlocked,
}

/// Names what an answer must keep to. G is the gap of the body at a place, h the depth across the
/// surface there: -G for a ray that starts outside, G for one that starts inside.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum RayRule {
    /// A hit has finite numbers, a unit normal and a positive error bound.
    Sound,
    /// A hit lies on its ray, between `t_min` and `t_max`.
    OnRay,
    /// |G| at the hit is within the error bound of the hit.
    WithinError,
    /// A ray that leaves the surface by `Hit::leave` is not reported to hit it where it is no
    /// nearer to it than half the gap it started with.
    LeavesSurface,
    /// Before the hit (without one, before the ray ends) the ray is nowhere deeper across the
    /// surface than the error bound there.
    PassesNothing,
    /// A blocked ray comes within the error bound of the surface somewhere.
    BlockedBySomething,
    /// A ray that is marked already stays marked.
    MarkLost,
}

/// Describes an answer that broke a rule.
#[derive(Debug, Clone, PartialEq)]
pub struct RayFault {
    /// How the surface was asked.
    pub question: RayQuestion,
    /// What its answer broke.
    pub rule: RayRule,
    /// The ray.
    pub ray: Ray,
    /// What kind of ray it is.
    pub kind: &'static str,
    /// The hit that was reported, when one was asked for.
    pub found: Option<Hit>,
    /// The hit of certified stepping.
    pub certified: Option<Hit>,
}

/// Writes a number so that Rust reads the same bits back.
struct Bits(f64);

impl fmt::Display for Bits {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        write!(f, "f64::from_bits({:#018x})", self.0.to_bits())
    }
}

fn vector(f: &mut fmt::Formatter, name: &str, v: DVec3) -> fmt::Result {
    writeln!(f, "    {name}: DVec3::new({}, {}, {}), // {v:?}", Bits(v.x), Bits(v.y), Bits(v.z))
}

fn number(f: &mut fmt::Formatter, name: &str, x: f64) -> fmt::Result {
    writeln!(f, "    {name}: {}, // {x:?}", Bits(x))
}

impl fmt::Display for RayFault {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        writeln!(f, "{:?} broke {:?} ({} ray):", self.question, self.rule, self.kind)?;
        writeln!(f, "Ray {{")?;
        vector(f, "origin", self.ray.origin)?;
        vector(f, "direction", self.ray.direction)?;
        number(f, "t_min", self.ray.t_min)?;
        number(f, "t_max", self.ray.t_max)?;
        writeln!(f, "}}")?;
        for (name, hit) in [("reported ", &self.found), ("certified", &self.certified)] {
            match hit {
                Some(h) => writeln!(f, "{name} {:?}, error {:e}", h.distance, h.error)?,
                None => writeln!(f, "{name} nothing")?,
            }
        }
        Ok(())
    }
}
