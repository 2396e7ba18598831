//! What receives light: sensors and surfaces that an eye sees, by how they answer light from each
//! direction.

use std::f64::consts::PI;

use glam::DVec3;

use super::cloud::Plane;
use super::contour::Cylinder;
use crate::math::{Frame, Rgb, sampling};
use crate::scene::{Brdf, BrdfSample, Measure, Sensor, Vertex};
use crate::surface::Hit;

/// Receives light at a point of the scene.
#[derive(Debug, Clone, Copy)]
pub struct Receiver<'a> {
    /// Where, with the error bound its rays leave by.
    pub hit: Hit,
    /// The normal of a surface or plane, the axis of a cylinder.
    normal: DVec3,
    response: Response<'a>,
    /// What mirrors on the way to it leave of the light.
    tint: Rgb,
    /// Whether it stands on a surface, which fills what is below.
    stands: bool,
}

/// How light from a direction counts, W.
#[derive(Debug, Clone, Copy)]
enum Response<'a> {
    /// By the cosine to the normal: the illuminance of a plane.
    Plane,
    /// By sin / pi of the angle to the axis: the mean illuminance of the side of a small cylinder.
    Cylinder,
    /// By (1 + cos phi) sin / pi, phi the azimuth from the unit vector it faces: the same of half a
    /// cylinder.
    SemiCylinder(DVec3),
    /// By f cos: the luminance that a surface reflects to an eye.
    Reflection(&'a Brdf, DVec3),
}

impl<'a> Receiver<'a> {
    /// Measures illuminance.
    pub fn sensor(sensor: &Sensor) -> Self {
        let response = match sensor.measure {
            Measure::Plane => Response::Plane,
            Measure::Cylinder => Response::Cylinder,
            Measure::SemiCylinder { facing } => Response::SemiCylinder(facing),
        };
        let stands = sensor.error > 0.0;
        Self { hit: sensor.as_hit(), normal: sensor.normal, response, tint: Rgb::WHITE, stands }
    }

    /// Measures the luminance that a vertex reflects towards `vertex.outgoing`.
    pub fn reflecting(vertex: &Vertex<'a>) -> Self {
        let response = Response::Reflection(&vertex.material.brdf, vertex.outgoing);
        let (hit, normal) = (vertex.hit, vertex.normal);
        Self { hit, normal, response, tint: Rgb::WHITE, stands: true }
    }

    /// Sees it through mirrors that leave this of its light.
    pub(super) fn through(self, tint: Rgb) -> Self {
        Self { tint, ..self }
    }

    /// Measures the illuminance of one side of a surface: that of its normal for a positive `sign`,
    /// the other for a negative one.
    pub(super) fn side(hit: &Hit, sign: f64) -> Self {
        let (response, tint) = (Response::Plane, Rgb::WHITE);
        Self { hit: *hit, normal: sign * hit.normal, response, tint, stands: true }
    }

    /// Returns the normal of what is no cylinder.
    pub(super) fn plane_normal(&self) -> Option<DVec3> {
        match self.response {
            Response::Plane | Response::Reflection(..) => Some(self.normal),
            Response::Cylinder | Response::SemiCylinder(_) => None,
        }
    }

    /// Returns the cylinder that it is, if any.
    pub(super) fn cylinder(&self) -> Option<Cylinder> {
        let facing = match self.response {
            Response::Cylinder => None,
            Response::SemiCylinder(facing) => Some(facing),
            Response::Plane | Response::Reflection(..) => return None,
        };
        Some(Cylinder::new(self.normal, facing, self.stands))
    }

    /// Returns, where W is proportional to the cosine above a plane, its normal and W / cos.
    pub(super) fn cosine(&self) -> Option<(DVec3, Rgb)> {
        match self.response {
            Response::Plane => Some((self.normal, self.tint)),
            Response::Reflection(Brdf::Lambert { reflectance }, _) => {
                Some((self.normal, self.tint * *reflectance / PI))
            }
            _ => None,
        }
    }

    /// Returns it as a plane that answers by the cosine, where it is one.
    pub(super) fn plane(&self) -> Option<Plane> {
        let (normal, factor) = self.cosine()?;
        Some(Plane::new(&self.hit, normal, factor))
    }

    /// Returns W for light that comes from the unit vector `direction`; black from below a surface.
    #[inline]
    pub fn response(&self, direction: DVec3) -> Rgb {
        let projection = self.projection(direction);
        if projection <= 0.0 || self.is_below(direction) {
            return Rgb::BLACK;
        }
        let response = match self.response {
            Response::Plane | Response::Cylinder => Rgb::grey(projection),
            Response::SemiCylinder(facing) => {
                Rgb::grey(projection * (1.0 + self.azimuth_cos(direction, facing)))
            }
            Response::Reflection(brdf, outgoing) => {
                brdf.eval(self.normal, direction, outgoing) * projection
            }
        };
        response * self.tint
    }

    /// Whether nothing can be received from along a vector of any length.
    #[inline]
    pub(super) fn turns_away(&self, from: DVec3) -> bool {
        match self.response {
            Response::Plane | Response::Reflection(..) => self.normal.dot(from) <= 0.0,
            Response::Cylinder | Response::SemiCylinder(_) => false,
        }
    }

    /// Returns the part of W that is known without a reflection or a side to face. Not above 0 from
    /// where nothing is received.
    #[inline]
    fn projection(&self, direction: DVec3) -> f64 {
        let cos = self.normal.dot(direction);
        match self.response {
            Response::Plane | Response::Reflection(..) => cos,
            Response::Cylinder | Response::SemiCylinder(_) => {
                (1.0 - cos * cos).max(0.0).sqrt() / PI
            }
        }
    }

    /// Returns W / cos and the normal of a receiver that answers light from its whole hemisphere by
    /// the cosine; `None` for another, and where a shading normal is not that of the surface.
    pub(super) fn diffuse(&self) -> Option<(Rgb, DVec3)> {
        let (normal, factor) = self.cosine()?;
        (self.hit.normal.dot(normal).abs() >= 1.0 - 1e-12).then_some((factor, normal))
    }

    /// Samples a direction to look along.
    pub(super) fn sample(&self, u: [f64; 2]) -> Option<BrdfSample> {
        match self.response {
            Response::Plane => {
                let local = sampling::cosine_hemisphere(u);
                (local.z > 0.0).then(|| BrdfSample {
                    direction: Frame::about(self.normal).to_world(local),
                    weight: Rgb::grey(PI),
                    density: sampling::cosine_pdf(local.z),
                })
            }
            Response::Cylinder => Some(self.sample_around(u, |_| 1.0)),
            Response::SemiCylinder(facing) => {
                Some(self.sample_around(u, |d| 1.0 + self.azimuth_cos(d, facing)))
            }
            Response::Reflection(brdf, outgoing) => brdf.sample(self.normal, outgoing, u),
        }
        .filter(|sample| !self.is_below(sample.direction))
        .map(|sample| BrdfSample { weight: sample.weight * self.tint, ..sample })
    }

    /// Returns the density per steradian with which [`Receiver::sample`] looks along `direction`.
    #[inline]
    pub(super) fn density(&self, direction: DVec3) -> f64 {
        match self.response {
            Response::Plane => sampling::cosine_pdf(self.normal.dot(direction)),
            Response::Cylinder | Response::SemiCylinder(_) => self.projection(direction) / PI,
            Response::Reflection(brdf, outgoing) => brdf.density(self.normal, direction, outgoing),
        }
    }

    /// Samples in proportion to the sine of the angle to the axis.
    fn sample_around(&self, u: [f64; 2], factor: impl Fn(DVec3) -> f64) -> BrdfSample {
        let direction = Frame::about(self.normal).to_world(sampling::sine_sphere(u));
        let weight = Rgb::grey(PI * factor(direction));
        BrdfSample { direction, weight, density: self.projection(direction) / PI }
    }

    /// Returns the cosine of the azimuth between two directions about the axis; 0 along it.
    fn azimuth_cos(&self, direction: DVec3, facing: DVec3) -> f64 {
        direction.reject_from_normalized(self.normal).normalize_or_zero().dot(facing)
    }

    /// Whether a direction is below the true surface, seen from the side the receiver faces; that
    /// differs from the shading cosine on smooth meshes only, and around a cylinder there is no
    /// surface.
    #[inline]
    fn is_below(&self, direction: DVec3) -> bool {
        match self.response {
            Response::Cylinder | Response::SemiCylinder(_) => {
                self.stands && self.normal.dot(direction) <= 0.0
            }
            Response::Plane | Response::Reflection(..) => {
                let side = 1.0_f64.copysign(self.hit.normal.dot(self.normal));
                self.hit.normal.dot(direction) * side <= 0.0
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn receivers() -> [Receiver<'static>; 3] {
        let axis = DVec3::new(0.0, 0.6, 0.8);
        let facing = DVec3::X;
        [Measure::Plane, Measure::Cylinder, Measure::SemiCylinder { facing }]
            .map(|measure| Receiver::sensor(&Sensor { measure, ..Sensor::plane(DVec3::ONE, axis) }))
    }

    fn grid() -> impl Iterator<Item = [f64; 2]> {
        (0..400 * 400).map(|i| [i / 400, i % 400].map(|k| (f64::from(k) + 0.5) / 400.0))
    }

    #[test]
    fn every_response_to_uniform_light_is_pi() {
        for receiver in receivers() {
            let all: f64 = grid()
                .map(|u| receiver.response(sampling::uniform_sphere(u)).luminance() * 4.0 * PI)
                .sum();
            assert!((all / 160_000.0 - PI).abs() <= 1e-3, "{receiver:?}: {all}");
        }
    }

    #[test]
    fn samples_weigh_the_response_by_their_density() {
        for receiver in receivers() {
            for u in grid().step_by(97) {
                let s = receiver.sample(u).expect("above the plane");
                let expected = receiver.response(s.direction).luminance();
                assert!(
                    (s.weight.luminance() * s.density - expected).abs() <= 1e-9,
                    "{receiver:?}"
                );
                assert!((s.density - receiver.density(s.direction)).abs() <= 1e-9);
            }
            // The density is that of the samples: the mean of x^2 + x over it by both ways.
            let test = |d: DVec3| d.x * d.x + d.x + d.z;
            let by_samples: f64 =
                grid().map(|u| test(receiver.sample(u).expect("above").direction)).sum();
            let by_density: f64 = grid()
                .map(sampling::uniform_sphere)
                .map(|d| test(d) * receiver.density(d) * 4.0 * PI)
                .sum();
            assert!((by_samples - by_density).abs() / 160_000.0 <= 1e-3, "{receiver:?}");
        }
    }

    #[test]
    fn half_a_cylinder_sees_twice_what_it_faces_and_nothing_behind() {
        let [_, cylinder, half] = receivers();
        let response = |r: &Receiver, d: DVec3| r.response(d).luminance();
        assert!((response(&half, DVec3::X) - 2.0 / PI).abs() <= 1e-15);
        assert!(response(&half, DVec3::NEG_X).abs() <= 1e-15);
        assert!((response(&cylinder, DVec3::NEG_X) - 1.0 / PI).abs() <= 1e-15);
    }
}
