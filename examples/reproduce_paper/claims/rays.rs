//! Equations 28 to 33: the normal of the head, and where a ray meets it.

use glam::DVec3;
use harmolux::Result;
use harmolux::math::{Randomness, Ray, Stream, sampling};
use harmolux::sh::Series;
use harmolux::surface::{Intersector, ShSurface, Surface};

use super::{Claim, Equation, Run, largest};

const COMMAND: &str = "cargo run --release --example reproduce_paper -- -o out --only rays";
const COUNT: u64 = 2000;
const ROUNDING: f64 = 1e-12;
/// What differences with a step of this part of the radius leave of a gradient of degree 32.
const STEP: f64 = 1e-4;
const DIFFERENCES: f64 = 1e-5;

pub(super) fn claims(run: &Run) -> Result<Vec<Claim>> {
    let head = Series::new(&run.head.coefficients)?;
    let surface = ShSurface::new(&run.head.coefficients, Intersector::Certified)?;
    let rays: Vec<Ray> = (0..COUNT).map(|i| ray(i, surface.body().bounds().max)).collect();
    let [printed_28, corrected_28] = normals(&head);
    let cosines = largest(rays.iter().map(zenith));
    let azimuths = largest(rays.iter().map(azimuth));
    let offset = |sign: f64| largest(rays.iter().map(|ray| height(ray, sign)));
    let [printed_33, corrected_33, hits] = gaps(&surface, &head, &rays);
    Ok(vec![
        equation_28(printed_28, corrected_28),
        equation_30(cosines),
        equation_31(offset(-1.0), offset(1.0)),
        equation_32(azimuths),
        equation_33(printed_33, corrected_33, hits),
    ])
}

/// Makes a ray from a sphere of twice the radius to a point within the radius.
fn ray(index: u64, radius: f64) -> Ray {
    let mut stream = Stream::new(Randomness::Pseudorandom, 1, index);
    let from = 2.0 * radius * sampling::uniform_sphere(stream.next_2d());
    let [u, v, w, _] = stream.next_4d();
    let to = radius * w * sampling::uniform_sphere([u, v]);
    Ray::new(from, (to - from).normalize())
}

/// Returns by how much (28) differs from grad U, as printed, and divided by r sin(theta).
fn normals(head: &Series) -> [f64; 2] {
    let mut off = [Vec::new(), Vec::new()];
    for i in 0..COUNT {
        let direction =
            sampling::uniform_sphere(Stream::new(Randomness::Pseudorandom, 2, i).next_2d());
        let (cos, sin) = (direction.z, direction.truncate().length());
        let r = head.value(direction);
        let truth = gradient(head, r * direction);
        let printed = equation_28_at(head, direction);
        for (off, value) in off.iter_mut().zip([printed, printed / (r * sin)]) {
            // Near the poles (28) is 0/0: they are left out.
            if cos.abs() < 0.999 {
                off.push((value - truth).length() / truth.length());
            }
        }
    }
    off.map(largest)
}

/// Evaluates the right side of (28) on the surface.
fn equation_28_at(head: &Series, direction: DVec3) -> DVec3 {
    let jet = head.jet(direction);
    let (cos, sin) = (direction.z, direction.truncate().length());
    let (cos_phi, sin_phi) = (direction.x / sin, direction.y / sin);
    let by_theta = jet.gradient.dot(DVec3::new(cos * cos_phi, cos * sin_phi, -sin));
    let by_phi = sin * jet.gradient.dot(DVec3::new(-sin_phi, cos_phi, 0.0));
    let rho = jet.value;
    DVec3::new(
        -rho * sin * sin * cos_phi + sin * cos * cos_phi * by_theta - sin_phi * by_phi,
        -rho * sin * sin * sin_phi + sin * cos * sin_phi * by_theta + cos_phi * by_phi,
        -rho * sin * cos - sin * sin * by_theta,
    )
}

/// Returns grad U of U = f(x / |x|) - |x| by differences of fourth order.
fn gradient(head: &Series, point: DVec3) -> DVec3 {
    let u = |x: DVec3| head.value(x.normalize()) - x.length();
    let h = STEP * point.length();
    let along = |axis: DVec3| {
        let near = u(point + h * axis) - u(point - h * axis);
        let far = u(point + 2.0 * h * axis) - u(point - 2.0 * h * axis);
        (8.0 * near - far) / (12.0 * h)
    };
    DVec3::new(along(DVec3::X), along(DVec3::Y), along(DVec3::Z))
}

fn equation_28(printed: f64, corrected: f64) -> Claim {
    Claim::from(Equation {
        title: "Equation 28: the normal in Cartesian axes",
        printed_words: "grad U = i(-rho sin^2 theta cos phi + sin theta cos theta cos phi U_theta \
                        - sin phi U_phi) + j(-rho sin^2 theta sin phi + sin theta cos theta sin \
                        phi U_theta + cos phi U_phi) + k(-rho sin theta cos theta - sin^2 theta \
                        U_theta)",
        correction: Some(
            "the right side is r sin(theta) grad U. grad U points inward, as U = f - r; at the \
             poles the right side is 0. The library takes e_r - grad f / f, which has neither \
             fault.",
        ),
        printed,
        corrected: Some(corrected),
        tolerance: DIFFERENCES,
        check: format!(
            "{COUNT} directions on the head of degree 32, those within 2.6 degrees of the poles \
             left out, against differences of fourth order of U: the largest relative difference \
             of the vectors."
        ),
        command: COMMAND,
    })
}

/// Some distances along each ray, in lengths of its origin.
const ALONG: [f64; 5] = [0.1, 0.4, 0.7, 1.1, 1.6];

/// Returns the largest of a function over distances along a ray.
fn over(ray: &Ray, f: impl Fn(f64, DVec3) -> f64) -> f64 {
    let distances = ALONG.map(|t| t * ray.origin.length());
    largest(distances.map(|xi| f(xi, ray.at(xi))))
}

fn zenith(ray: &Ray) -> f64 {
    over(ray, |xi, point| {
        let (r, l) = (ray.origin, ray.direction);
        let length = (r.length_squared() + xi * xi + 2.0 * xi * l.dot(r)).sqrt();
        ((r.z + l.z * xi) / length - point.z / point.length()).abs()
    })
}

fn equation_30(off: f64) -> Claim {
    Claim::from(Equation {
        title: "Equations 29 and 30: the zenith angle along a ray",
        printed_words: "r = r0 + xi l; cos theta = (z0 + l_z xi) / sqrt(r0^2 + xi^2 + 2 xi (l, \
                        r0))",
        correction: None,
        printed: off,
        corrected: None,
        tolerance: ROUNDING,
        check: format!("{COUNT} rays, five points each, against z / |r| of the point."),
        command: COMMAND,
    })
}

/// Returns the height above the plane z = 0, which should be 0, of (31), in lengths of the origin.
fn height(ray: &Ray, sign: f64) -> f64 {
    over(ray, |xi, point| {
        let rho = point - DVec3::Z * (ray.origin.z + sign * ray.direction.z * xi);
        rho.z.abs() / ray.origin.length()
    })
}

fn equation_31(printed: f64, corrected: f64) -> Claim {
    Claim::from(Equation {
        title: "Equation 31: the vector in the horizontal plane",
        printed_words: "rho = r - k (k, r) = r0 + xi l - k (z0 - l_z xi)",
        correction: Some("z0 + l_z xi, as in (32)."),
        printed,
        corrected: Some(corrected),
        tolerance: ROUNDING,
        check: format!(
            "{COUNT} rays, five points each: the largest height of rho, in |r0|, where 0 is right."
        ),
        command: COMMAND,
    })
}

fn azimuth(ray: &Ray) -> f64 {
    over(ray, |xi, point| {
        let (r, l) = (ray.origin, ray.direction);
        let rho = (r + xi * l - DVec3::Z * r.z - DVec3::Z * l.z * xi).length();
        let (sin, cos) = point.y.atan2(point.x).sin_cos();
        let (x, y) = ((r.x + l.x * xi) / rho, (r.y + l.y * xi) / rho);
        (x - cos).abs().max((y - sin).abs())
    })
}

fn equation_32(off: f64) -> Claim {
    Claim::from(Equation {
        title: "Equation 32: the azimuth along a ray",
        printed_words: "cos phi = (x0 + l_x xi) / |r0 + xi l - k z0 - k l_z xi|; sin phi = (y0 + \
                        l_y xi) / the same",
        correction: None,
        printed: off,
        corrected: None,
        tolerance: ROUNDING,
        check: format!("{COUNT} rays, five points each, against atan2(y, x) of the point."),
        command: COMMAND,
    })
}

/// Returns what both forms of (33) leave where the rays meet the head, relative to its radius
/// there, and the number of hits.
fn gaps(surface: &ShSurface, head: &Series, rays: &[Ray]) -> [f64; 3] {
    let hits = rays.iter().filter_map(|ray| Some((ray, surface.hit(ray)?.distance)));
    let gap = |(ray, xi): (&Ray, f64)| {
        let point = ray.at(xi);
        let f = head.value(point.normalize());
        [(f - ray.origin.length() - xi).abs() / f, (f - point.length()).abs() / f]
    };
    let gaps: Vec<[f64; 2]> = hits.map(gap).collect();
    let worst = |i: usize| largest(gaps.iter().map(|gap| gap[i]));
    [worst(0), worst(1), gaps.len() as f64]
}

fn equation_33(printed: f64, corrected: f64, hits: f64) -> Claim {
    Claim::from(Equation {
        title: "Equation 33: where a ray meets the surface",
        printed_words: "f(theta(xi), phi(xi)) - r0 - xi l = 0",
        correction: Some(
            "f - |r0 + xi l| = 0: a radius cannot be compared with a vector. The printed form is \
             read with lengths, f - |r0| - xi.",
        ),
        printed,
        corrected: Some(corrected),
        tolerance: HITS,
        check: format!(
            "{hits} hits of {COUNT} rays on the head of degree 32, found by certified steps: what \
             both forms leave there, relative to the radius."
        ),
        command: COMMAND,
    })
}

/// To which part of the radius certified steps meet the surface.
const HITS: f64 = 1e-9;
