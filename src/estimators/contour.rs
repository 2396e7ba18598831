//! How much of its view a point has of a polygon, a disc or a sphere: Lambert's contour formula.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use arrayvec::ArrayVec;
use glam::{DVec2, DVec3};

use crate::math::Frame;
use crate::math::quadrature::Rule;

/// Returns the configuration factor of a quadrilateral at `point` for the unit `normal`, its
/// projected solid angle over pi: E = B times it. Positive where the contour runs counter-clockwise
/// as seen from the point, negative from behind; what is below the horizon is cut off.
///
/// The contour need not be flat. A triangle has a corner twice.
pub(super) fn factor(corners: &[DVec3; 4], point: DVec3, normal: DVec3) -> f64 {
    let relative = corners.map(|corner| corner - point);
    let heights = relative.map(|r| r.dot(normal));
    if heights.iter().all(|h| *h <= 0.0) {
        return 0.0;
    }
    let sum = if heights.iter().all(|h| *h >= 0.0) {
        around(&relative, normal)
    } else {
        around(&above_horizon(&relative, &heights), normal)
    };
    // Lambert's sum counts turns about the normal; who looks along it sees them the other way
    // round.
    -sum / TAU
}

/// Adds up angle times normal component over the edges of a polygon relative to the point that sees
/// it.
fn around(corners: &[DVec3], normal: DVec3) -> f64 {
    let next = corners.iter().cycle().skip(1);
    corners.iter().zip(next).map(|(&a, &b)| edge(a, b, normal)).sum()
}

fn edge(a: DVec3, b: DVec3, normal: DVec3) -> f64 {
    let cross = a.cross(b);
    let length = cross.length();
    if length == 0.0 { 0.0 } else { length.atan2(a.dot(b)) * cross.dot(normal) / length }
}

/// Clips a quadrilateral to heights of at least 0 (Sutherland and Hodgman 1974): each edge adds at
/// most its crossing and its end.
fn above_horizon(relative: &[DVec3; 4], heights: &[f64; 4]) -> ArrayVec<DVec3, 8> {
    let mut kept = ArrayVec::new();
    for i in 0..4 {
        let j = (i + 1) % 4;
        if (heights[i] < 0.0) != (heights[j] < 0.0) {
            let t = heights[i] / (heights[i] - heights[j]);
            kept.push(relative[i].lerp(relative[j], t));
        }
        if heights[j] >= 0.0 {
            kept.push(relative[j]);
        }
    }
    kept
}

/// Returns the configuration factor of a disc at the origin, from where it is seen, for the unit
/// `normal`: its projected solid angle over pi. `axis` is the unit normal of the disc on the side
/// that is seen; what is below the horizon is cut off.
///
/// The rim r(phi) turns counter-clockwise about the axis, and n.(r x r') / r^2 is integrated in
/// closed form (Lambert 1760) over the part of it that is above the horizon; a chord along the
/// horizon closes the contour.
pub(super) fn round(centre: DVec3, axis: DVec3, radius: f64, normal: DVec3) -> f64 {
    let rim = Rim::new(centre, axis, radius, normal);
    let (along, height) = (DVec2::new(normal.dot(rim.e1), normal.dot(rim.e2)), normal.dot(centre));
    let rise = radius * along.length();
    let sum = if height >= rise {
        rim.integral(PI) - rim.integral(-PI)
    } else if height <= -rise {
        0.0
    } else {
        let (middle, half) = (along.to_angle(), (-height / rise).acos());
        let [from, to] = [middle - half, middle + half];
        let arc = rim.integral(to) - rim.integral(from);
        arc + edge(rim.at(to), rim.at(from), normal)
    };
    -sum / TAU
}

/// Returns the outline of a sphere at the origin, from where it is seen, as centre, axis and radius
/// of a disc on the unit sphere; `None` from inside.
pub(super) fn outline(centre: DVec3, radius: f64) -> Option<(DVec3, DVec3, f64)> {
    let distance = centre.length();
    (distance > radius).then(|| {
        let cos = ((distance - radius) * (distance + radius)).sqrt() / distance;
        let towards = centre / distance;
        (cos * towards, -towards, radius / distance)
    })
}

/// The rim of a disc, r = centre + radius (cos phi e1 + sin phi e2), seen from the origin.
struct Rim {
    centre: DVec3,
    radius: f64,
    e1: DVec3,
    e2: DVec3,
    /// n.(r x r') = `constant` + `cos` cos phi + `sin` sin phi.
    constant: f64,
    cos: f64,
    sin: f64,
    /// r^2 = a + b cos phi; the root of a^2 - b^2, and b / (a + root).
    a: f64,
    b: f64,
    root: f64,
    q: f64,
}

impl Rim {
    fn new(centre: DVec3, axis: DVec3, radius: f64, normal: DVec3) -> Self {
        let aside = centre.reject_from_normalized(axis);
        // What is left by rounding alone has no direction; of the rest a second step makes it
        // perpendicular.
        let e1 = if aside.length() > 1e-12 * centre.length() {
            aside.normalize().reject_from_normalized(axis).normalize()
        } else {
            axis.any_orthonormal_vector()
        };
        let e2 = axis.cross(e1);
        let (height, aside) = (centre.dot(axis), centre.dot(e1));
        let turned = normal.cross(centre);
        let squared = |x: f64| x * x + height * height;
        let (nearest, farthest) = (squared(aside - radius), squared(aside + radius));
        let (a, b) = (0.5 * (nearest + farthest), 2.0 * radius * aside);
        let root = (nearest * farthest).sqrt();
        Self {
            centre,
            radius,
            e1,
            e2,
            constant: radius * radius * normal.dot(axis),
            cos: radius * turned.dot(e2),
            sin: -radius * turned.dot(e1),
            a,
            b,
            root,
            q: b / (a + root),
        }
    }

    fn at(&self, angle: f64) -> DVec3 {
        let (sin, cos) = angle.sin_cos();
        self.centre + self.radius * (cos * self.e1 + sin * self.e2)
    }

    /// Returns the integral of n.(r x r') / r^2 up to an angle, but for a constant. With
    /// q = b / (a + root) it is a Fourier series in q that sums to an arc tangent; no difference of
    /// large terms is left as q goes to 0.
    fn integral(&self, angle: f64) -> f64 {
        let Self { a, b, root, q, .. } = *self;
        let (sin, cos) = angle.sin_cos();
        let tangent = (q * sin).atan2(1.0 + q * cos);
        let inverse = (angle - 2.0 * tangent) / root;
        let tangent_by_q = if q > 0.0 { tangent / q } else { sin };
        let of_cos = (2.0 * a / (a + root) * tangent_by_q - q * angle) / root;
        let x = b / a * cos;
        let of_sin = if x.abs() > 0.5 {
            -(self.at(angle).length_squared() / a).ln() / b
        } else {
            let slope = if x == 0.0 { 1.0 } else { x.ln_1p() / x };
            -cos / a * slope
        };
        self.constant * inverse + self.cos * of_cos + self.sin * of_sin
    }
}

/// The largest angle of an arc that one rule integrates over, and the points of the rule.
const ARC: f64 = PI / 8.0;
const POINTS: usize = 8;

/// The side of a cylinder, or of half of one, as it sees polygons.
pub(super) struct Cylinder {
    frame: Frame,
    /// 1 for half a cylinder that faces the tangent of the frame, else 0.
    half: f64,
    /// Whether it stands on a surface, so that what is below does not count.
    stands: bool,
    rule: Rule,
}

impl Cylinder {
    /// Stands along a unit vector, and faces a perpendicular one if it is half a cylinder.
    pub(super) fn new(axis: DVec3, facing: Option<DVec3>, stands: bool) -> Self {
        let tangent = facing.unwrap_or_else(|| axis.any_orthonormal_vector());
        let frame = Frame { tangent, bitangent: axis.cross(tangent), normal: axis };
        let half = f64::from(u8::from(facing.is_some()));
        Self { frame, half, stands, rule: Rule::gauss_legendre(POINTS) }
    }

    /// Returns what it gets at a point from a quadrilateral of radiosity 1 that faces it
    /// counter-clockwise: the integral of W / pi over its solid angle.
    ///
    /// By Stokes' theorem the integral of sin theta (1 + cos phi) over a spherical polygon is that
    /// of G (1 + cos phi) dphi around it, G = (theta - sin theta cos theta) / 2, and G(pi) times
    /// the turn about the axis less where the lower pole is inside.
    pub(super) fn sees(&self, corners: &[DVec3; 4], point: DVec3) -> f64 {
        let relative = corners.map(|corner| self.local(corner - point));
        let heights = relative.map(|r| r.z);
        let kept = if self.stands {
            above_horizon(&relative, &heights)
        } else {
            relative.into_iter().collect()
        };
        let (mut sum, mut turn) = (0.0, 0.0);
        for (i, a) in kept.iter().enumerate() {
            let (part, turned) = self.along(*a, kept[(i + 1) % kept.len()]);
            sum += part;
            turn += turned;
        }
        let [a, b, c, d] = relative;
        let normal = (c - a).cross(d - b);
        let is_below = (normal.dot(a) < 0.0) != (normal.z < 0.0);
        if turn.abs() > PI && is_below {
            sum -= FRAC_PI_2 * turn;
        }
        (-sum / (PI * PI)).max(0.0)
    }

    fn local(&self, v: DVec3) -> DVec3 {
        let Frame { tangent, bitangent, normal } = self.frame;
        DVec3::new(v.dot(tangent), v.dot(bitangent), v.dot(normal))
    }

    /// Integrates along the arc of one edge; returns the turn about the axis, too.
    fn along(&self, a: DVec3, b: DVec3) -> (f64, f64) {
        let from = a.normalize_or_zero();
        let normal = from.cross(b);
        // The same corner twice, or a point on the edge.
        if normal.length() <= 4.0 * f64::EPSILON * b.length() {
            return (0.0, 0.0);
        }
        let across = normal.cross(from).normalize();
        let angle = b.dot(across).atan2(b.dot(from));
        let parts = (angle / ARC).ceil().max(1.0);
        let step = angle / parts;
        let at = |t: f64| t.cos() * from + t.sin() * across;
        let sine = |r: DVec3| r.y / r.truncate().length().max(f64::MIN_POSITIVE);
        let (mut sum, mut turn) = (0.0, 0.0);
        for k in 0..parts as usize {
            let (start, end) = (k as f64 * step, (k + 1) as f64 * step);
            let (p, q) = (at(start), at(end));
            let turned = (p.x * q.y - p.y * q.x).atan2(p.x * q.x + p.y * q.y);
            turn += turned;
            // Near a pole phi runs, and G less its value there vanishes.
            let pole = if p.z + q.z < 0.0 { FRAC_PI_2 } else { 0.0 };
            sum += pole * (turned + self.half * (sine(q) - sine(p)));
            let rate = |(x, weight): (f64, f64)| {
                let t = start + 0.5 * (1.0 + x) * step;
                weight * self.rate(at(t), t.cos() * across - t.sin() * from, pole)
            };
            sum += 0.5 * step * self.rule.iter().map(rate).sum::<f64>();
        }
        (sum, turn)
    }

    /// Returns (G - pole) (1 + cos phi) dphi / dt at a unit vector that moves by `along`.
    fn rate(&self, r: DVec3, along: DVec3, pole: f64) -> f64 {
        let rho = r.truncate().length();
        if rho == 0.0 {
            return 0.0;
        }
        // G(pi - theta) = pi / 2 - G(theta).
        let sign = if pole > 0.0 { -1.0 } else { 1.0 };
        let g = 0.5 * sign * (rho.atan2(sign * r.z) - rho * sign * r.z);
        g * (1.0 + self.half * r.x / rho) * (r.x * along.y - r.y * along.x) / (rho * rho)
    }
}

#[cfg(test)]
mod tests {
    use super::super::receiver::Receiver;
    use super::*;
    use crate::scene::{Measure, Sensor};
    use crate::surface::{Division, SampleArea};

    /// The ceiling [0, 1]^2 at z = 1, seen from below.
    fn ceiling() -> [DVec3; 4] {
        [[0.0, 0.0], [0.0, 1.0], [1.0, 1.0], [1.0, 0.0]].map(|[x, y]| DVec3::new(x, y, 1.0))
    }

    #[test]
    fn factor_is_that_of_the_catalogue_on_its_own_side_only() {
        // Point under a corner, parallel: Howell's formula, X = Y = 1.
        let corner = 0.138_531_605_994_89;
        assert!((factor(&ceiling(), DVec3::ZERO, DVec3::Z) - corner).abs() <= 1e-14);
        assert_eq!(factor(&ceiling(), DVec3::ZERO, DVec3::NEG_Z), 0.0);
        let above = factor(&ceiling(), DVec3::new(0.0, 0.0, 2.0), DVec3::NEG_Z);
        assert!((above + corner).abs() <= 1e-14);
        // In its own plane a polygon shows nothing.
        assert!(factor(&ceiling(), DVec3::new(2.0, 0.3, 1.0), DVec3::NEG_Z).abs() <= 1e-15);
    }

    #[test]
    fn horizon_cuts_a_polygon() {
        // A wall from 1 m below the floor to 1 m above it, at 1 m: the upper half counts.
        let wall = |low: f64| {
            [[-1.0, low], [-1.0, 1.0], [1.0, 1.0], [1.0, low]].map(|[x, z]| DVec3::new(x, 1.0, z))
        };
        let whole = factor(&wall(-1.0), DVec3::ZERO, DVec3::Z);
        let half = factor(&wall(0.0), DVec3::ZERO, DVec3::Z);
        assert!(half.abs() > 0.05 && (whole - half).abs() <= 1e-15, "{whole} {half}");
    }

    #[test]
    fn triangles_have_a_corner_twice() {
        let [a, b, c, d] = ceiling();
        let at = DVec3::new(0.3, 0.7, 0.0);
        let parts = factor(&[a, b, c, c], at, DVec3::Z) + factor(&[a, c, d, d], at, DVec3::Z);
        assert!((parts - factor(&ceiling(), at, DVec3::Z)).abs() <= 1e-15);
    }

    /// The midpoint rule over n x n parts, as W / pi.
    fn by_parts(corners: &[DVec3; 4], sensor: &Sensor, n: usize) -> f64 {
        let [a, b, c, d] = *corners;
        let at = |i: usize, j: usize, o: f64| {
            let (u, v) = ((i as f64 + o) / n as f64, (j as f64 + o) / n as f64);
            a.lerp(b, u).lerp(d.lerp(c, u), v)
        };
        let receiver = Receiver::sensor(sensor);
        let of = |k: usize| {
            let (i, j) = (k % n, k / n);
            let to = at(i, j, 0.5) - sensor.at;
            let (along, across) =
                (at(i + 1, j, 0.0) - at(i, j, 0.0), at(i, j + 1, 0.0) - at(i, j, 0.0));
            let projected = -along.cross(across).dot(to.normalize());
            projected * receiver.response(to.normalize()).luminance() / (PI * to.length_squared())
        };
        (0..n * n).map(of).sum()
    }

    fn cylinders(at: DVec3) -> [Sensor; 2] {
        let facing = DVec3::new(0.6, -0.8, 0.0);
        [Measure::Cylinder, Measure::SemiCylinder { facing }]
            .map(|measure| Sensor { measure, ..Sensor::plane(at, DVec3::Z) })
    }

    fn seen(corners: &[DVec3; 4], sensor: &Sensor) -> f64 {
        let facing = match sensor.measure {
            Measure::SemiCylinder { facing } => Some(facing),
            _ => None,
        };
        Cylinder::new(sensor.normal, facing, false).sees(corners, sensor.at)
    }

    #[test]
    fn cylinders_see_polygons_as_many_small_parts() {
        for z in [0.0, 0.9, 2.0] {
            // From below, with the pole inside and outside; from above it is turned round.
            for (x, y) in [(0.4, 0.6), (3.0, -1.0), (0.5, -0.01)] {
                let mut corners = ceiling();
                if z > 1.0 {
                    corners.reverse();
                }
                let [a, b, c, d] = corners;
                for sensor in cylinders(DVec3::new(x, y, z)) {
                    let parts = seen(&[a, b, c, c], &sensor) + seen(&[a, c, d, d], &sensor);
                    assert!((parts - seen(&corners, &sensor)).abs() <= 1e-9, "{sensor:?}");
                    let (found, fine) = (seen(&corners, &sensor), by_parts(&corners, &sensor, 600));
                    assert!((found - fine).abs() <= 2e-4 * fine, "{sensor:?}: {found} {fine}");
                }
            }
        }
    }

    #[test]
    fn cylinders_in_a_glowing_cube_get_all_there_is() {
        let cube = crate::surface::primitives::AxisBox::new(DVec3::ZERO, DVec3::ONE);
        let facets =
            cube.expect("valid").turned_inward(true).facets(&Division { count: 1, lights: &[] });
        for at in
            [DVec3::splat(0.5), DVec3::new(1e-9, 0.3, 0.7), DVec3::new(1e-9, 1e-6, 1.0 - 1e-9)]
        {
            for sensor in cylinders(at) {
                let sum: f64 = facets.iter().map(|f| seen(&f.corners, &sensor)).sum();
                // Coordinates are rounded to 1e-7 of the distance to the walls.
                assert!((sum - 1.0).abs() <= 1e-5, "{sensor:?}: {sum}");
            }
        }
    }

    /// The midpoint rule over a fine polygon along the rim.
    fn by_polygon(centre: DVec3, axis: DVec3, radius: f64, normal: DVec3) -> f64 {
        let rim = Rim::new(centre, axis, radius, normal);
        let n = 40_000;
        let at = |k: usize| rim.at(TAU * k as f64 / n as f64);
        let of = |k: usize| factor(&[centre, at(k), at(k + 1), at(k + 1)], DVec3::ZERO, normal);
        (0..n).map(of).sum()
    }

    #[test]
    fn disc_is_that_of_the_catalogue_and_of_a_fine_polygon() {
        // Parallel, h above it and r aside: (1 - (q - R^2) / sqrt((q + R^2)^2 - 4 R^2 r^2)) / 2, q
        // = h^2 + r^2.
        let parallel = |radius: f64, h: f64, r: f64| {
            let (q, r2) = (h * h + r * r, radius * radius);
            0.5 * (1.0 - (q - r2) / ((q + r2).powi(2) - 4.0 * r2 * r * r).sqrt())
        };
        for (radius, h, r) in
            [(0.1, 0.05, 0.0), (0.1, 0.05, 0.1), (0.1, 0.001, 0.102), (1.0, 3.0, 5.0)]
        {
            let found = round(DVec3::new(r, 0.0, h), DVec3::NEG_Z, radius, DVec3::Z);
            let exact = parallel(radius, h, r);
            assert!((found / exact - 1.0).abs() <= 1e-10, "{radius} {h} {r}: {found} {exact}");
        }
        let axis = DVec3::new(0.2, -0.4, -1.0).normalize();
        for centre in [DVec3::new(0.5, 0.3, 1.0), DVec3::new(-2.0, 0.1, 0.3), 0.2 * DVec3::Z] {
            for normal in [DVec3::Z, DVec3::X, DVec3::new(-1.0, 2.0, -0.3).normalize(), -axis] {
                let found = round(centre, axis, 0.7, normal);
                let fine = by_polygon(centre, axis, 0.7, normal);
                assert!((found - fine).abs() <= 1e-8, "{centre} {normal}: {found} {fine}");
            }
        }
    }

    #[test]
    fn sphere_is_its_outline() {
        let factor = |centre: DVec3, radius: f64, normal: DVec3| {
            outline(centre, radius).map_or(0.0, |(c, axis, r)| round(c, axis, r, normal))
        };
        let up = DVec3::new(0.6, 0.0, 0.8);
        assert!((factor(5.0 * up, 0.5, DVec3::Z) - 0.01 * 0.8).abs() <= 1e-15);
        for k in 1..50 {
            let angle = f64::from(k);
            let towards = DVec3::new(angle.cos(), angle.sin(), 0.3 + 0.01 * angle).normalize();
            let found = factor(5.0 * towards, 0.5, DVec3::Z);
            assert!((found - 0.01 * towards.z).abs() <= 1e-15, "{towards}: {found}");
        }
        // Half below the horizon: a ball on the horizon at distance d. Howell's formula for a plane
        // that cuts a sphere, h = 0: F = (asin(1 / D) - sqrt(D^2 - 1) / D^2) / pi, D = d / r.
        let d: f64 = 2.0;
        let half = ((1.0 / d).asin() - (d * d - 1.0).sqrt() / (d * d)) / PI;
        assert!((factor(2.0 * DVec3::X, 1.0, DVec3::Z) - half).abs() <= 1e-14);
        assert_eq!(factor(DVec3::NEG_Z, 0.5, DVec3::Z), 0.0);
        assert_eq!(factor(0.2 * DVec3::Z, 0.5, DVec3::Z), 0.0);
        // Nearly touching it sees nothing else.
        assert!((factor((1.0 + 1e-12) * DVec3::Z, 1.0, DVec3::Z) - 1.0).abs() <= 1e-11);
    }
}
