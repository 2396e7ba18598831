//! Patches: the surface as a height field on the faces of a cube, in polynomials that are certainly
//! above it by less than a known width.
//!
//! The projective map (u, v, w) = (p1/p0, p2/p0, 1/|p0|) of a cube face keeps rays straight, and a
//! star-shaped surface becomes w = 1/Z(u, v), Z = f/s, s = sqrt(1 + u^2 + v^2). A ray visits the
//! few patches in which it comes near the surface (`node`), and in each the first root of a
//! polynomial is found by steps that pass none (`patch`). From outside the surface is taken at its
//! upper bound, from inside at its lower one: the root is at or before the true one, never after,
//! and within the width of it.

mod batch;
mod board;
mod build;
mod certificate;
mod fit;
mod lanes;
mod line;
mod node;
mod patch;
mod route;
mod walk;

use fearless_simd::{Level, Simd, dispatch};

use self::batch::{FirstHits, Marks};
use self::board::Board;
use self::node::Node;
use self::patch::{Patch, Tangent};
use self::route::{Route, Stretch};
use self::walk::Walk;
use super::Hit;
use crate::Result;
use crate::math::{Aabb, Ray};
use crate::sh::{Bounds, Series};

/// Holds the patches of a body and the tree above them. Lengths inside are in largest radii.
#[derive(Debug, Clone)]
pub(super) struct Patches {
    board: Board,
    /// The nodes of each level, the lowest first, row by row and face by face.
    levels: Vec<Vec<Node>>,
    /// Sixteen patches of a node stand together.
    leaves: Vec<Patch>,
    /// The box around the body, metres.
    around: Aabb,
    /// The radius of the ball around the body, metres.
    radius: f64,
    /// The radius of the ball that fills it, metres.
    inner: f64,
    /// The largest width of a patch.
    width: f32,
    level: Level,
}

/// On which side of the surface a ray starts.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Side {
    Outside,
    Inside,
}

/// What patches can say of a ray.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Answer<T> {
    Known(T),
    /// The ray starts so near the surface that only the series can tell on which side, or from so
    /// far that it is coarse.
    AskSeries,
}

impl Side {
    /// Returns 1 outside and -1 inside: the sign of F on this side.
    #[inline(always)]
    fn sign(self) -> f64 {
        match self {
            Self::Outside => 1.0,
            Self::Inside => -1.0,
        }
    }
}

impl Patches {
    /// Builds the patches of a body.
    ///
    /// # Errors
    /// [`crate::Error::Parameter`] for a degree too high to evaluate.
    pub(super) fn new(series: &Series, bounds: &Bounds) -> Result<Self> {
        build::build(series, bounds)
    }

    /// Bounds how far a hit can be from the surface along a radius, metres.
    pub(super) fn error(&self) -> f64 {
        self.radius * (f64::from(self.width) + patch::TOLERANCE)
    }

    /// Returns the box around the body, metres.
    pub(super) fn bounds(&self) -> Aabb {
        self.around
    }

    /// Returns the bytes that patches and tree take.
    pub(super) fn bytes(&self) -> usize {
        let nodes: usize = self.levels.iter().map(|l| size_of_val(&l[..])).sum();
        nodes + size_of_val(&self.leaves[..]) + self.board.bytes()
    }

    /// Finds the first hit of a ray.
    pub(super) fn hit(&self, ray: &Ray) -> Answer<Option<Hit>> {
        dispatch!(self.level, simd => {
            let route = self.route(simd, ray);
            self.follow(simd, ray, &route)
        })
    }

    /// Whether a ray hits anything.
    pub(super) fn blocked(&self, ray: &Ray) -> Answer<bool> {
        dispatch!(self.level, simd => {
            let route = self.route(simd, ray);
            self.obstructed(simd, ray, &route)
        })
    }

    /// Finds the first hits of many rays; gives the places of those that only the series can
    /// answer.
    pub(super) fn hits(&self, rays: &[Ray], hits: &mut [Option<Hit>]) -> Vec<usize> {
        for hit in hits.iter_mut() {
            *hit = None;
        }
        let mut answers = FirstHits { hits, unanswered: Vec::new() };
        dispatch!(self.level, simd => self.answer(simd, rays, &mut answers));
        answers.unanswered
    }

    /// Marks the rays that hit anything, passing over those marked already; gives the places of
    /// those that only the series can answer.
    pub(super) fn mark_blocked(&self, rays: &[Ray], blocked: &mut [bool]) -> Vec<usize> {
        let mut answers = Marks { blocked, unanswered: Vec::new() };
        dispatch!(self.level, simd => self.answer(simd, rays, &mut answers));
        answers.unanswered
    }

    #[inline(always)]
    fn follow<S: Simd>(&self, simd: S, ray: &Ray, route: &Route) -> Answer<Option<Hit>> {
        Answer::Known(match route {
            Route::Nowhere => None,
            Route::Series => return Answer::AskSeries,
            Route::Outside { stretch, .. } => self.first_on(simd, ray, Side::Outside, stretch),
            Route::Inside(stretches) => self.way_out(ray, stretches),
        })
    }

    /// Finds the first hit of a ray from inside; a function of its own, since it is rare and long.
    #[inline(never)]
    fn way_out(&self, ray: &Ray, stretches: &[Stretch; 2]) -> Option<Hit> {
        dispatch!(self.level, simd => {
            let mut hit = None;
            for stretch in stretches {
                // One without length starts at the centre perhaps, which is on no face.
                if hit.is_none() && stretch.length > 0.0 {
                    hit = self.first_on(simd, ray, Side::Inside, stretch);
                }
            }
            hit
        })
    }

    #[inline(always)]
    fn first_on<S: Simd>(&self, simd: S, ray: &Ray, side: Side, stretch: &Stretch) -> Option<Hit> {
        let (walk, tangent) = self.trace::<_, false>(simd, Walk::new(self, side, stretch))?;
        Some(self.describe(ray, stretch.start, stretch.length, &walk, &tangent))
    }

    #[inline(always)]
    fn obstructed<S: Simd>(&self, simd: S, ray: &Ray, route: &Route) -> Answer<bool> {
        Answer::Known(match route {
            Route::Nowhere => false,
            Route::Series => return Answer::AskSeries,
            Route::Outside { enters: true, .. } => true,
            Route::Outside { stretch, .. } => {
                self.trace::<_, true>(simd, Walk::new(self, Side::Outside, stretch)).is_some()
            }
            Route::Inside(stretches) => self.way_out(ray, stretches).is_some(),
        })
    }

    /// Describes a crossing on a stretch by where that starts and how long it is; the rounding of
    /// the point counts as error too.
    #[inline(always)]
    fn describe(&self, ray: &Ray, start: f64, length: f64, walk: &Walk, tangent: &Tangent) -> Hit {
        let normal = walk.normal(tangent).normalize();
        let distance = start + walk.progress(length) * self.radius;
        let distance = distance.max(ray.t_min).min(ray.t_max);
        let rounding = 4.0 * f64::EPSILON * (ray.origin.abs().element_sum() + distance.abs());
        Hit {
            distance,
            point: ray.at(distance),
            normal,
            shading_normal: normal,
            error: self.error() + rounding,
            part: 0,
        }
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;
    use rand::{RngExt, SeedableRng};
    use rand_xoshiro::Xoshiro256PlusPlus;

    use super::*;
    use crate::math::sampling::uniform_sphere;
    use crate::sh::Coefficients;

    fn bumpy(lmax: usize) -> Coefficients {
        let mut c = Coefficients::zeros(lmax);
        c.set(0, 0, 1.0, 0.0);
        for l in 1..=lmax {
            for m in 0..=l {
                let k = 0.3 / (l * l) as f64;
                c.set(l, m, k * ((3 * l + m) as f64).sin(), k * ((l + 2 * m) as f64).cos());
            }
        }
        c
    }

    /// Makes rays in a plane p[j] = c p[i] that cannot pass by a ball about the centre: towards it,
    /// away from points in it and from the centre.
    fn rays_in_plane(i: usize, j: usize, c: f64, ball: f64, count: usize) -> Vec<Ray> {
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(7);
        let mut point = |radius: f64| {
            let mut p = uniform_sphere(rng.random());
            p[j] = c * p[i];
            radius / p.length() * p
        };
        (0..count)
            .filter_map(|k| {
                let (from, to) = match k % 3 {
                    0 => (point(3.0), point(ball)),
                    1 => (point(ball), point(3.0)),
                    _ => (DVec3::ZERO, point(1.0)),
                };
                Ray::between(from, to).map(|ray| ray.up_to(f64::INFINITY))
            })
            .collect()
    }

    #[test]
    fn rays_on_borders_of_faces_and_cells_hit_in_every_way() {
        for lmax in [0, 6, 12] {
            let shape = bumpy(lmax);
            let bounds = Bounds::of(&shape).expect("small");
            let series = Series::new(&shape).expect("small");
            let patches = Patches::new(&series, &bounds).expect("positive");
            let cells =
                (1..8).map(|k| (std::f64::consts::FRAC_PI_4 * (f64::from(k) / 4.0 - 1.0)).tan());
            for c in [1.0, -1.0, -0.0].into_iter().chain(cells) {
                for (i, j) in [(0, 1), (1, 2), (2, 0), (1, 0), (2, 1), (0, 2)] {
                    let rays = rays_in_plane(i, j, c, 0.99 * bounds.min, 90);
                    let mut hits = vec![None; rays.len()];
                    let mut blocked = vec![false; rays.len()];
                    assert_eq!(patches.hits(&rays, &mut hits), [0; 0]);
                    assert_eq!(patches.mark_blocked(&rays, &mut blocked), [0; 0]);
                    for (k, ray) in rays.iter().enumerate() {
                        let single = patches.hit(ray);
                        assert!(matches!(single, Answer::Known(Some(_))), "{lmax}: {ray:?}");
                        assert_eq!(single, Answer::Known(hits[k]));
                        assert_eq!(patches.blocked(ray), Answer::Known(true));
                        assert!(blocked[k], "{lmax}: {ray:?}");
                    }
                }
            }
        }
    }

    #[test]
    fn instruction_sets_agree_within_the_bound() {
        let c = bumpy(12);
        let (series, bounds) = (Series::new(&c).expect("small"), Bounds::of(&c).expect("small"));
        let widest = Patches::new(&series, &bounds).expect("positive");
        let narrow = Patches { level: Level::baseline(), ..widest.clone() };
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(12);
        let mut met = 0;
        for _ in 0..4000 {
            let mut point = || 2.0 * uniform_sphere(rng.random());
            let Some(ray) = Ray::between(point(), point()) else { continue };
            let (Answer::Known(a), Answer::Known(b)) = (widest.hit(&ray), narrow.hit(&ray)) else {
                panic!("rays from outside are answered by patches");
            };
            // Both lie within the bound above the surface; a ray that only one of them meets grazes
            // it by as little.
            let gap = |p: DVec3| (p.length() - series.value(p.normalize())).abs();
            for hit in [a, b].into_iter().flatten() {
                assert!(gap(hit.point) <= hit.error);
            }
            if let (Some(a), Some(b)) = (a, b) {
                met += 1;
                // At a slope of 1e-2 or steeper along the ray, two points that near the surface are
                // that near each other.
                let slope = (a.normal.dot(ray.direction)).abs();
                assert!(
                    slope < 1e-2 || (a.distance - b.distance).abs() <= (a.error + b.error) / slope
                );
            }
        }
        assert!(met > 1000, "{met}");
    }
}
