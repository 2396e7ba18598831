//! Level of detail with a certificate: the lowest degree at which an SH object, seen by a camera,
//! looks the same within a tolerance.
//!
//! Let t = f - f' be what truncation leaves out, |t| <= e and |grad_S t| <= s everywhere (see
//! [`crate::sh::TruncationError`]).
//!
//! * Position. In every direction from the centre the surface moves by |t|, at most by E = k e in
//!   the room, k the scale of the object. How far that is in the picture, pixels,
//!   [`Camera::movement`] bounds for every lens.
//! * Normal. An outward normal is n = f e_r - grad_S f, of length f at least; that of the truncated
//!   series in the same direction is off by -t e_r + grad_S t, that is by sqrt(e^2 + s^2) at most.
//!   The line of n' passes the tip of n at |n - n'| at most, so the angle between the two has a
//!   sine of at most sqrt(e^2 + s^2) / min f. (On an image the truncated surface may also show
//!   another direction at a pixel; that is the error of position.) This is the largest turn
//!   anywhere: without its last degree of 32 the head turns normals about its ears by 9 degrees,
//!   though half of its normals turn by less than 2. So it counts only where it is asked for.
//!
//! What is seen in other ways (shadows, light that is reflected) follows the truncated shape too
//! and is not in the pixels.

use std::f64::consts::PI;

use crate::Result;
use crate::io::scene_file::DetailSpec;
use crate::math::Placement;
use crate::scene::Camera;
use crate::sh::{Coefficients, TruncationError, range, sufficient_degree};

/// Certifies the degree chosen for an object.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Detail {
    /// The degree to use.
    pub degree: usize,
    /// The degree of the whole series.
    pub full_degree: usize,
    /// The distance of the eye (of the film, where all rays are parallel) from the ball that holds
    /// the object, metres; 0 inside.
    pub distance: f64,
    /// The largest distance, metres, by which the surface moves.
    pub error: f64,
    /// The largest distance, pixels, by which a point of the surface moves in the image.
    pub pixels: f64,
    /// The largest angle, radians, by which a normal turns; pi where nothing bounds it.
    pub normal: f64,
    /// The degree that the pixels alone would allow: lower than `degree` where it is the angle that
    /// asks for more.
    pub degree_by_pixels: usize,
}

/// The part of the smallest radius that truncation may take away: what is left is certainly
/// star-shaped.
const LARGEST_SHARE: f64 = 0.5;

/// Chooses the degree of an object whose radius is `series`, placed in a room, for a picture. It is
/// the full degree if the eye is within the ball that holds the object, if a tolerance is 0, and if
/// nothing lower will do.
///
/// # Errors
/// [`crate::Error::Parameter`] for a degree too high to evaluate.
pub fn detail(
    series: &Coefficients,
    placement: &Placement,
    camera: &Camera,
    tolerance: &DetailSpec,
) -> Result<Detail> {
    let (min, max) = range(series)?;
    let scale = placement.scale();
    let (centre, radius) = (placement.translation(), scale * max);
    let distance = (camera.distance(centre) - radius).max(0.0);
    let pixels = |error: f64| camera.movement(centre, radius, error);
    let normal = tolerance.normal.to_radians();
    let full_degree = series.lmax();
    let whole = TruncationError { degree: full_degree, value: 0.0, slope: 0.0 };
    let exact = distance == 0.0 || tolerance.pixels == 0.0;
    let within = |normal: f64| {
        let accepts = |value: f64, slope: f64| {
            value <= LARGEST_SHARE * min
                && pixels(scale * value) <= tolerance.pixels
                && turn(value, slope, min) <= normal
        };
        if exact || normal == 0.0 { Ok(whole) } else { sufficient_degree(series, accepts) }
    };
    let mut found = within(normal)?;
    if found.degree < full_degree && range(&series.truncated(found.degree))?.0 <= 0.0 {
        found = whole;
    }
    let degree_by_pixels = if normal < PI { within(PI)?.degree } else { found.degree };
    let error = scale * found.value;
    Ok(Detail {
        degree: found.degree,
        full_degree,
        distance,
        error,
        pixels: pixels(error),
        normal: turn(found.value, found.slope, min),
        degree_by_pixels,
    })
}

/// Bounds the angle, radians, by which a normal turns: pi when nothing is known.
fn turn(value: f64, slope: f64, min_radius: f64) -> f64 {
    let sine = value.hypot(slope) / min_radius;
    if sine < 1.0 { sine.asin() } else { PI }
}

#[cfg(test)]
mod tests {
    use glam::{DQuat, DVec2, DVec3};

    use super::*;
    use crate::math::sampling::uniform_sphere;
    use crate::sh::{Series, gaussian, power_law};

    /// A body of degree 24 and mean radius 1.
    fn body() -> Coefficients {
        let mut f = gaussian(&power_law(0.01, 3.5, 1, 24).expect("valid"), 3).expect("valid");
        f.set(0, 0, 1.0, 0.0);
        f
    }

    fn camera() -> Camera {
        Camera::perspective(DVec3::ZERO, DVec3::X, 0.8, [320, 240]).expect("valid")
    }

    fn at(distance: f64, scale: f64) -> Placement {
        let turn = DQuat::from_rotation_z(0.4);
        Placement::new(turn, scale, DVec3::X * distance).expect("valid")
    }

    const TOLERANCE: DetailSpec = DetailSpec { pixels: 0.25, normal: 180.0 };

    fn seen(distance: f64, tolerance: DetailSpec) -> Detail {
        detail(&body(), &at(distance, 0.5), &camera(), &tolerance).expect("valid")
    }

    #[test]
    fn far_objects_get_lower_degrees_than_near_ones() {
        let degrees: Vec<usize> =
            [1.0, 3.0, 10.0, 30.0, 1000.0].map(|d| seen(d, TOLERANCE).degree).to_vec();
        assert!(degrees.is_sorted_by(|a, b| a >= b), "{degrees:?}");
        assert!(degrees[1] > degrees[3] && degrees[4] < 3, "{degrees:?}");
    }

    #[test]
    fn nothing_is_simplified_without_tolerance_or_from_within() {
        let none =
            [DetailSpec { pixels: 0.0, ..TOLERANCE }, DetailSpec { normal: 0.0, ..TOLERANCE }];
        for found in [seen(50.0, none[0]), seen(50.0, none[1]), seen(0.1, TOLERANCE)] {
            assert_eq!((found.degree, found.full_degree), (24, 24));
            assert_eq!((found.error, found.pixels, found.normal), (0.0, 0.0, 0.0));
        }
        assert_eq!(seen(0.1, TOLERANCE).distance, 0.0);
    }

    #[test]
    fn tolerance_of_normals_raises_the_degree() {
        let strict = seen(200.0, DetailSpec { normal: 2.0, ..TOLERANCE });
        let free = seen(200.0, TOLERANCE);
        assert!(strict.degree > free.degree, "{strict:?}");
        assert_eq!([strict, free].map(|d| d.degree_by_pixels), [free.degree; 2]);
        assert!(strict.normal <= 2.0_f64.to_radians() && strict.pixels <= 0.25);
    }

    /// Points and normals of the whole and of the truncated body, as the camera sees them.
    #[test]
    fn certificate_holds_in_the_image_and_is_of_use() {
        for (distance, normal) in [(4.0, 180.0), (30.0, 3.0)] {
            let (found, placed) =
                (seen(distance, DetailSpec { normal, ..TOLERANCE }), at(distance, 0.5));
            let (whole, low) = (Series::new(&body()), Series::new(&body().truncated(found.degree)));
            let (whole, low) = (whole.expect("valid"), low.expect("valid"));
            let (mut moved, mut turned) = (0.0_f64, 0.0_f64);
            for i in 0..20_000 {
                let u =
                    [(f64::from(i) + 0.5) / 20_000.0, (f64::from(i) * 0.618_033_988_75).fract()];
                let w = uniform_sphere(u);
                let (a, b) = (whole.jet(w), low.jet(w));
                let [p, q] = [a, b].map(|jet| film(placed.apply(jet.value * w)));
                moved = moved.max(p.distance(q));
                let [m, n] = [a, b].map(|jet| jet.value * w - jet.gradient);
                turned = turned.max(m.angle_between(n));
            }
            assert!(found.degree < 24 && found.pixels <= 0.25, "{found:?}");
            assert!(moved <= found.pixels && turned <= found.normal, "{moved} {turned} {found:?}");
            // From the front and from the middle of the image: the bound takes the corner and the
            // nearest point.
            assert!(found.pixels <= 4.0 * moved, "{moved} {found:?}");
        }
    }

    /// Returns where a point is in the image of `camera()`, pixels.
    fn film(point: DVec3) -> DVec2 {
        camera().project(point).expect("in front").film
    }

    #[test]
    fn placements_scale_the_error() {
        let found = seen(30.0, TOLERANCE);
        let exact = crate::sh::truncation_error(&body(), found.degree).expect("valid");
        assert_eq!(found.error, 0.5 * exact.value);
    }
}
