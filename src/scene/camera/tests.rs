use std::f64::consts::{FRAC_PI_2, PI};

use super::*;
use crate::math::sampling::uniform_sphere;

const EYE: DVec3 = DVec3::new(0.3, -1.2, 1.6);
const TO: DVec3 = DVec3::new(2.0, 1.5, 0.4);

/// One of each lens, and the extremes.
fn cameras() -> Vec<Camera> {
    let fisheye = |mapping, degrees: f64, resolution| {
        Camera::fisheye(EYE, TO, mapping, degrees.to_radians(), resolution)
    };
    let mut all = vec![
        Camera::perspective(EYE, TO, 1.1, [64, 40]),
        Camera::perspective(EYE, TO, 0.2, [30, 70]).and_then(|c| c.with_up(DVec3::X)),
        Camera::orthographic(EYE, TO, 3.0, [64, 40]),
        Camera::panorama(EYE, TO, DVec3::Z, [64, 32]),
        Camera::panorama(EYE, TO, DVec3::new(0.1, 0.2, 1.0), [40, 40]),
        fisheye(FisheyeMapping::Equidistant, 360.0, [50, 64]),
        fisheye(FisheyeMapping::Equisolid, 300.0, [50, 64]),
        fisheye(FisheyeMapping::Stereographic, 270.0, [50, 64]),
    ];
    all.extend(FisheyeMapping::ALL.map(|mapping| fisheye(mapping, 180.0, [64, 50])));
    all.extend(FisheyeMapping::ALL.map(|mapping| fisheye(mapping, 80.0, [64, 50])));
    all.into_iter().collect::<Result<_>>().expect("valid")
}

/// Positions all over a picture, none in its middle or on its borders.
fn positions(camera: &Camera) -> impl Iterator<Item = DVec2> + use<> {
    let size = camera.size();
    (0..23).flat_map(move |i| {
        (0..23).map(move |j| DVec2::new(f64::from(i) + 0.37, f64::from(j) + 0.61) / 23.0 * size)
    })
}

#[test]
fn impossible_cameras_are_refused() {
    let at = |to, fov: f64, resolution| Camera::perspective(DVec3::ZERO, to, fov, resolution);
    assert!(at(DVec3::ZERO, 1.0, [4, 4]).is_err());
    assert!(at(DVec3::X, 0.0, [4, 4]).is_err());
    assert!(at(DVec3::X, 4.0, [4, 4]).is_err());
    assert!(at(DVec3::X, 1.0, [4, 0]).is_err());
    assert!(at(DVec3::X, 1.0, [4, 4]).expect("valid").with_up(-DVec3::X).is_err());
    for height in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert!(Camera::orthographic(DVec3::ZERO, DVec3::X, height, [4, 4]).is_err());
    }
    for (mapping, degrees) in [
        (FisheyeMapping::Equidistant, 361.0),
        (FisheyeMapping::Equisolid, 0.0),
        (FisheyeMapping::Orthographic, 181.0),
        (FisheyeMapping::Stereographic, 360.0),
        (FisheyeMapping::Stereographic, f64::NAN),
    ] {
        let fov = degrees.to_radians();
        assert!(Camera::fisheye(DVec3::ZERO, DVec3::X, mapping, fov, [4, 4]).is_err());
    }
    let up = Camera::panorama(DVec3::ZERO, DVec3::Z, DVec3::Z, [4, 2]).expect_err("refused");
    assert!(up.to_string().contains("along the view"), "{up}");
}

#[test]
fn film_positions_map_to_the_field_of_view() {
    let fov = 90.0_f64.to_radians();
    let camera = Camera::perspective(DVec3::ZERO, DVec3::Y, fov, [200, 100]).expect("valid");
    let direction = |x, y| camera.ray(DVec2::new(x, y)).expect("a ray").direction;
    assert!((direction(100.0, 50.0) - DVec3::Y).length() <= 1e-15);
    assert!((direction(100.0, 0.0) - DVec3::new(0.0, 1.0, 1.0).normalize()).length() <= 1e-15);
    assert!((direction(200.0, 50.0) - DVec3::new(2.0, 1.0, 0.0).normalize()).length() <= 1e-15);
}

#[test]
fn looking_down_takes_y_as_up() {
    let camera = Camera::perspective(DVec3::Z, DVec3::ZERO, 1.0, [10, 10]).expect("valid");
    let direction = |x, y| camera.ray(DVec2::new(x, y)).expect("a ray").direction;
    assert!(direction(5.0, 0.0).y > 0.0 && direction(10.0, 5.0).x > 0.0);
}

#[test]
fn parallel_rays_start_on_the_film() {
    let camera = Camera::orthographic(DVec3::Z, DVec3::ZERO, 2.0, [40, 20]).expect("valid");
    for (film, at) in [([20.0, 10.0], [0.0, 0.0]), ([0.0, 0.0], [-2.0, 1.0])] {
        let ray = camera.ray(DVec2::from_array(film)).expect("a ray");
        assert!(ray.origin.distance(DVec2::from_array(at).extend(1.0)) <= 1e-15, "{ray:?}");
        assert_eq!(ray.direction, -DVec3::Z);
    }
    assert_eq!(camera.project(DVec3::Z * 2.0), None);
    assert_eq!(camera.project(DVec3::Z * -2.0).expect("seen").distance, 3.0);
}

#[test]
fn fisheye_fills_the_largest_circle_and_nothing_else() {
    for mapping in FisheyeMapping::ALL {
        let camera = Camera::fisheye(DVec3::ZERO, DVec3::Y, mapping, PI, [80, 60]).expect("valid");
        let ray = |x, y| camera.ray(DVec2::new(x, y));
        let right = ray(70.0, 30.0).expect("the rim").direction;
        assert!(right.distance(DVec3::X) <= 1e-7, "{mapping:?} {right}");
        let top = ray(40.0, 0.0).expect("the rim").direction;
        assert!(top.distance(DVec3::Z) <= 1e-7, "{mapping:?} {top}");
        assert_eq!(ray(40.0, 30.0).expect("the middle").direction, DVec3::Y);
        assert!(ray(70.1, 30.0).is_none() && ray(20.0, 2.0).is_none());
        assert!(camera.project(DVec3::new(0.1, -0.1, 0.0)).is_none());
    }
    // Half way to the rim is half of the angle, or where the mapping has it.
    for (mapping, angle) in FisheyeMapping::ALL.into_iter().zip([
        FRAC_PI_2 / 2.0,
        2.0 * (0.5_f64.sqrt() / 2.0).asin(),
        PI / 6.0,
        2.0 * 0.5_f64.atan(),
    ]) {
        let camera = Camera::fisheye(DVec3::ZERO, DVec3::Y, mapping, PI, [80, 80]).expect("valid");
        let half = camera.ray(DVec2::new(60.0, 40.0)).expect("within").direction;
        assert!((half.angle_between(DVec3::Y) - angle).abs() <= 1e-12, "{mapping:?}");
    }
}

#[test]
fn panorama_has_the_zenith_above_and_turns_to_the_right() {
    let camera =
        Camera::panorama(DVec3::ZERO, DVec3::new(1.0, 0.0, 5.0), DVec3::Z, [8, 4]).expect("valid");
    for (film, direction) in [
        ([4.0, 2.0], DVec3::X),
        ([6.0, 2.0], -DVec3::Y),
        ([2.0, 2.0], DVec3::Y),
        ([0.0, 2.0], -DVec3::X),
        ([3.0, 0.0], DVec3::Z),
        ([3.0, 4.0], -DVec3::Z),
    ] {
        let seen = camera.ray(DVec2::from_array(film)).expect("a ray").direction;
        assert!(seen.distance(direction) <= 1e-15, "{film:?}: {seen}");
    }
}

#[test]
fn what_a_ray_meets_is_projected_to_where_the_ray_was() {
    for camera in cameras() {
        let mut seen = 0;
        for film in positions(&camera) {
            let Some(ray) = camera.ray(film) else { continue };
            let back = camera.project(ray.at(2.7)).expect("seen");
            assert!(back.film.distance(film) <= 1e-9, "{camera:?}: {film} {back:?}");
            assert!((back.distance - 2.7).abs() <= 1e-12);
            assert!(back.towards.distance(-ray.direction) <= 1e-12);
            seen += 1;
        }
        // A circle in the longer picture covers 0.61 of it.
        assert!(seen > 300, "{seen} {camera:?}");
    }
}

#[test]
fn density_is_the_film_area_of_a_small_surface() {
    let h = 1e-5;
    for camera in cameras() {
        for film in positions(&camera) {
            let Some(ray) = camera.ray(film) else { continue };
            let point = ray.at(2.7);
            let (u, v) = ray.direction.any_orthonormal_pair();
            let at = |p: DVec3| camera.project(p).map(|seen| seen.film);
            let difference = |w: DVec3| Some((at(point + h * w)? - at(point - h * w)?) / (2.0 * h));
            // At the rim of a circle one of the neighbours is not seen.
            let Some((a, b)) = difference(u).zip(difference(v)) else { continue };
            // Central differences: right behind an all-round fisheye they are at their worst.
            let density = camera.project(point).expect("seen").density;
            let exact = a.perp_dot(b).abs();
            assert!(
                (density - exact).abs() <= 2e-4 * exact,
                "{camera:?} {film}: {density} {exact}"
            );
        }
    }
}

#[test]
fn film_density_makes_up_the_whole_field_of_view() {
    // The integral of 1/density over the film at distance 1 is the solid angle; the middle rule on
    // 200 x 200 cells, cut at circles.
    for (camera, exact) in [
        (Camera::panorama(EYE, TO, DVec3::Z, [64, 32]), 4.0 * PI),
        (Camera::fisheye(EYE, TO, FisheyeMapping::Equidistant, PI, [40, 40]), 2.0 * PI),
        (Camera::fisheye(EYE, TO, FisheyeMapping::Equisolid, 2.0 * PI, [40, 40]), 4.0 * PI),
        (Camera::perspective(EYE, TO, FRAC_PI_2, [40, 40]), 4.0 * PI / 6.0),
    ] {
        let camera = camera.expect("valid");
        let n = 200;
        let cell = camera.size() / f64::from(n);
        let cells = (0..n).flat_map(|i| (0..n).map(move |j| DVec2::new(i.into(), j.into())));
        let rays = cells.filter_map(|c| camera.ray((c + 0.5) * cell));
        let angles = rays.filter_map(|ray| camera.project(ray.at(1.0)));
        let total: f64 = angles.map(|seen| cell.element_product() / seen.density).sum();
        assert!((total / exact - 1.0).abs() <= 5e-3, "{camera:?}: {total} {exact}");
    }
}

#[test]
fn movements_are_bounded_in_every_picture() {
    // Balls in all directions, points all over them, moved in all directions: none is seen to move
    // farther than the bound.
    let spread = |n: u32| {
        (0..n).map(move |i| {
            uniform_sphere([
                (f64::from(i) + 0.5) / f64::from(n),
                (f64::from(i) * 0.618_033_988_75).fract(),
            ])
        })
    };
    for camera in cameras() {
        let (mut bounded, mut nearest) = (0, 0.0_f64);
        let ahead = spread(10).map(|w| (camera.forward() + 0.1 * w).normalize());
        for way in spread(40).chain(ahead) {
            let (centre, radius, error) = (EYE + 4.0 * way, 0.3, 0.02);
            let bound = camera.movement(centre, radius, error);
            assert!(bound > 0.0);
            for point in spread(12).map(|w| centre + radius * w) {
                for moved in spread(12).map(|w| point + error * w) {
                    let Some((a, b)) = camera.project(point).zip(camera.project(moved)) else {
                        continue;
                    };
                    if !inside(&camera, a.film) {
                        continue;
                    }
                    let margin = camera.size().max_element();
                    let copies = camera.repeats(b.film, margin).map(|film| film.distance(a.film));
                    let distance = copies.fold(f64::INFINITY, f64::min);
                    assert!(distance <= bound, "{camera:?} {way}: {distance} {bound}");
                    nearest = nearest.max(distance / bound);
                }
            }
            bounded += usize::from(bound.is_finite());
        }
        assert!(bounded >= 10 && nearest >= 0.3, "{bounded} {nearest} {camera:?}");
        assert_eq!(camera.movement(EYE + DVec3::X, 0.3, 0.0), 0.0);
        assert!(camera.movement(EYE + 0.1 * camera.forward(), 0.3, 0.01).is_infinite());
    }
}

fn inside(camera: &Camera, film: DVec2) -> bool {
    film.cmpge(DVec2::ZERO).all() && film.cmple(camera.size()).all()
}

#[test]
fn positions_beyond_the_borders_of_a_panorama_show_what_repeats_there() {
    let camera = Camera::panorama(EYE, TO, DVec3::Z, [64, 32]).expect("valid");
    for (film, count) in [([0.2, 16.0], 2), ([10.0, 0.5], 2), ([63.9, 31.9], 3), ([30.0, 16.0], 1)]
    {
        let film = DVec2::from_array(film);
        let all: Vec<DVec2> = camera.repeats(film, 1.0).collect();
        assert_eq!(all.len(), count, "{film}: {all:?}");
        let direction = camera.ray(film).expect("a ray").direction;
        for at in all {
            let same = camera.ray(at).expect("a ray").direction;
            assert!(same.distance(direction) <= 1e-12, "{film} {at}");
        }
    }
    let plain = Camera::perspective(EYE, TO, 1.0, [64, 32]).expect("valid");
    assert_eq!(plain.repeats(DVec2::new(0.2, 16.0), 1.0).count(), 1);
}

#[test]
fn windows_are_parts_of_the_picture() {
    let camera = Camera::perspective(EYE, TO, 1.0, [64, 32]).expect("valid");
    assert_eq!(camera.window().size(), [64, 32]);
    let window = Window::new([10, 20], [64, 32]).expect("valid");
    assert_eq!(camera.with_window(window).expect("within").window().size(), [54, 12]);
    let half = window.halved();
    assert_eq!((half.min(), half.max()), ([5, 10], [32, 16]));
    let error = camera.with_window(Window::new([0, 0], [65, 3]).expect("valid"));
    let error = error.expect_err("refused").to_string();
    assert!(error.contains("0,0,65,3") && error.contains("64 x 32"), "{error}");
    assert!(Window::new([3, 0], [3, 4]).is_err() && Window::new([0, 5], [3, 4]).is_err());
}

#[test]
fn camera_coordinates_have_the_view_along_minus_z() {
    let camera = Camera::perspective(EYE, TO, 1.0, [64, 32]).expect("valid");
    let m = camera.world_to_camera();
    let apply = |p: DVec3| {
        let row = [p.x, p.y, p.z, 1.0];
        DVec3::from_array(std::array::from_fn(|k| (0..4).map(|i| row[i] * m[i][k]).sum()))
    };
    assert!(apply(EYE).length() <= 1e-12);
    assert!(apply(TO).distance(-DVec3::Z * TO.distance(EYE)) <= 1e-12);
    assert!(apply(EYE + DVec3::Z).y > 0.0);
}
