use glam::DVec3;

use super::*;
use crate::fit::{project_conforming, star};
use crate::mesh::MeshReport;
use crate::sh::{Series, volume};

fn bumpy() -> Coefficients {
    let mut c = Coefficients::zeros(8);
    c.set(0, 0, 1.0, 0.0);
    for l in 1..=8 {
        for m in 0..=l {
            let k = 0.3 / ((l * l + 2) as f64);
            c.set(l, m, k * ((3 * l + m) as f64).sin(), k * ((l + 5 * m) as f64).cos());
        }
    }
    c
}

const CENTRE: DVec3 = DVec3::new(0.3, -2.0, 5.0);

const ALL: [Resolution; 3] = [
    Resolution::Icosphere { frequency: 7 },
    Resolution::LatLong { bands: 12, azimuths: 20 },
    Resolution::Adaptive { tolerance: 2e-3 },
];

fn refusal(c: &Coefficients, resolution: Resolution) -> String {
    tessellate(c, DVec3::ZERO, resolution).expect_err("refused").to_string()
}

#[test]
fn resolutions_out_of_range_are_refused() {
    let c = bumpy();
    assert!(refusal(&c, Resolution::Icosphere { frequency: 0 }).contains("at least 1"));
    assert!(
        refusal(&c, Resolution::LatLong { bands: 1, azimuths: 9 }).contains("at least 2 bands")
    );
    assert!(refusal(&c, Resolution::LatLong { bands: 2, azimuths: 2 }).contains("3 azimuths"));
    let huge = [
        Resolution::Icosphere { frequency: usize::MAX },
        Resolution::LatLong { bands: usize::MAX, azimuths: 3 },
    ];
    for resolution in huge {
        assert!(refusal(&c, resolution).contains("too large"));
    }
    for tolerance in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert!(refusal(&c, Resolution::Adaptive { tolerance }).contains("positive number"));
    }
    assert!(refusal(&c, Resolution::Adaptive { tolerance: 1e-12 }).contains("more than 33554432"));
}

#[test]
fn a_radius_that_is_not_positive_is_refused_with_the_direction() {
    let mut c = Coefficients::zeros(1);
    c.set(0, 0, 1.0, 0.0);
    c.set(1, 0, 1.5, 0.0);
    for resolution in ALL {
        let message = refusal(&c, resolution);
        assert!(message.contains("the radius towards") && message.contains("positive one"));
    }
    assert!(refusal(&Coefficients::zeros(0), ALL[0]).contains("0.000e0"));
}

#[test]
fn meshes_are_closed_outward_star_shaped_and_on_the_surface() {
    let c = bumpy();
    let series = Series::new(&c).expect("degree 8");
    for resolution in ALL {
        let made = tessellate(&c, CENTRE, resolution).expect("made");
        let report = MeshReport::of(&made.mesh);
        assert!(report.is_closed() && !report.is_inside_out(), "{resolution:?}");
        assert_eq!(report.deficiencies(), Vec::<String>::new(), "{resolution:?}");
        assert_eq!((report.euler(), report.components), (2, 1));
        assert!(star::test(&made.mesh, CENTRE).expect("faces").is_star_shaped());
        for p in made.mesh.positions() {
            let from = *p - CENTRE;
            // Rounding of the sum with a centre 5 away.
            assert!((from.length() - series.value(from.normalize())).abs() <= 4e-15);
        }
    }
}

#[test]
fn tolerance_is_met_between_the_samples_too() {
    let c = bumpy();
    let series = Series::new(&c).expect("degree 8");
    let tolerance = 2e-3;
    let made = tessellate(&c, DVec3::ZERO, Resolution::Adaptive { tolerance }).expect("made");
    let (measured, bound) = (made.chord_error.measured, made.chord_error.bound.expect("bounded"));
    assert!(measured <= tolerance && measured >= 0.5 * tolerance, "{measured}");
    assert!(bound >= measured && bound <= 3.0 * tolerance, "{bound}");
    // 45 points of each face against the 13 that were judged; between samples a smooth error grows
    // by a few percent only.
    for face in 0..made.mesh.triangles().len() {
        let [a, b, c] = made.mesh.corners(face);
        for j in 0..=8 {
            for k in 0..=8 - j {
                let below = a + f64::from(j) / 8.0 * (b - a) + f64::from(k) / 8.0 * (c - a);
                let above = series.value(below.normalize()) * below.normalize();
                let nearest = crate::mesh::triangle::nearest_on_triangle(above, [a, b, c]);
                assert!(above.distance(nearest) <= 1.1 * tolerance);
                assert!(above.distance(below) <= bound);
            }
        }
    }
}

#[test]
fn angles_stay_bounded_however_fine() {
    let c = bumpy();
    let made = tessellate(&c, DVec3::ZERO, Resolution::Adaptive { tolerance: 2e-4 }).expect("made");
    let smallest = (0..made.mesh.triangles().len())
        .map(|face| {
            let [a, b, c] = made.mesh.corners(face);
            [(a, b, c), (b, c, a), (c, a, b)]
                .map(|(p, q, r)| (q - p).angle_between(r - p))
                .into_iter()
                .fold(f64::MAX, f64::min)
        })
        .fold(f64::MAX, f64::min);
    // Rivara: not below half the smallest angle of the start, here about 35 degrees on the steepest
    // flank.
    assert!(smallest >= 12_f64.to_radians(), "{}", smallest.to_degrees());
}

#[test]
fn volume_converges_to_that_of_the_series() {
    let c = bumpy();
    let exact = volume(&c).expect("degree 8");
    let error = |frequency| {
        let made = tessellate(&c, CENTRE, Resolution::Icosphere { frequency }).expect("made");
        (made.mesh.volume() / exact - 1.0).abs()
    };
    let [coarse, fine] = [16, 32].map(error);
    // The chord error is of second order: halving the edges quarters it.
    assert!(coarse <= 1e-2 && (coarse / fine - 4.0).abs() <= 0.4, "{coarse} {fine}");
}

#[test]
fn fit_of_the_mesh_returns_the_coefficients() {
    let c = bumpy();
    let made = tessellate(&c, CENTRE, Resolution::Adaptive { tolerance: 1e-4 }).expect("made");
    let fitted = project_conforming(&made.mesh, CENTRE, 8).expect("degree 8");
    let bound = made.chord_error.bound.expect("bounded");
    // |int g Y| <= max |g| for the mean; sqrt(2l+1) times that for the others.
    let pairs =
        c.cosines().iter().zip(fitted.cosines()).chain(c.sines().iter().zip(fitted.sines()));
    let worst = pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    assert!(worst <= 17_f64.sqrt() * bound, "{worst} {bound}");
}

#[test]
fn a_ball_takes_an_icosahedron_when_that_will_do() {
    let mut ball = Coefficients::zeros(0);
    ball.set(0, 0, 3.0, 0.0);
    let made = tessellate(&ball, CENTRE, Resolution::Adaptive { tolerance: 10.0 }).expect("made");
    assert_eq!(made.mesh.triangles().len(), 20);
    // 3 minus the inradius, 3 (3 + sqrt 5) / (4 sqrt 3 sin(2 pi / 5)).
    let exact = 3.0 - 3.0 * 0.794_654_472_291_766;
    let ChordError { measured, bound } = made.chord_error;
    assert!(measured <= exact && measured >= 0.9 * exact, "{measured} {exact}");
    assert!(bound.is_some_and(|b| b >= exact && b <= 1.25 * exact));
}

#[test]
fn radii_whose_areas_no_number_holds_are_refused() {
    for radius in [1e-310, 1e-100, 1e150, 1e300] {
        let mut ball = Coefficients::zeros(1);
        ball.set(0, 0, radius, 0.0);
        let resolution = Resolution::Adaptive { tolerance: 1e-3 * radius };
        let error = tessellate(&ball, DVec3::ZERO, resolution).expect_err("refused").to_string();
        assert!(error.starts_with("the mean radius is"), "{error}");
    }
}
