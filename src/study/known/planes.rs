//! Sobolev's problem: a point source between two planes, or between two coaxial discs.

use glam::DVec3;

use super::facts::{NEAR, dark, differs, intensity, only_lamp, same, two_objects};
use super::{Mismatch, Result, Solution};
use crate::exact::{Plane, SobolevProblem};
use crate::io::scene_file::{DiscSpec, LightSpec, ObjectSpec, SceneFile};
use crate::scene::Sensor;

/// A plane of the scene: any point, the normal, the material.
struct Side<'a> {
    point: DVec3,
    normal: DVec3,
    material: &'a str,
}

/// The problem as a scene states it; the first side counts as the lower.
struct Sobolev<'a> {
    problem: SobolevProblem,
    sides: [Side<'a>; 2],
    lamp: &'a LightSpec,
}

pub(super) fn sobolev(file: &SceneFile) -> Result<Solution<'_>, Mismatch> {
    let [lower, upper] = two_objects(file)?;
    let found = Sobolev::of(file, [plane(lower)?, plane(upper)?])?;
    Ok(Box::new(move |sensor| {
        let (plane, r) = found.place(sensor)?;
        Ok(found.problem.illuminance(plane, r)?)
    }))
}

pub(super) fn discs(file: &SceneFile) -> Result<Solution<'_>, Mismatch> {
    let [lower, upper] = two_objects(file)?;
    let discs = [disc(lower)?, disc(upper)?];
    let [lower, upper] = discs;
    let side = |i: usize| Side {
        point: discs[i].centre,
        normal: discs[i].normal,
        material: &discs[i].material,
    };
    let found = Sobolev::of(file, [side(0), side(1)])?;
    let off = |point: DVec3| (point - lower.centre).reject_from_normalized(lower.normal).length();
    let radius = lower.radius;
    if (upper.radius - radius).abs() > NEAR * radius {
        return differs("the discs have different radii");
    }
    if off(upper.centre) > NEAR * radius {
        return differs("the discs have no common axis");
    }
    if off(found.lamp.at) > NEAR * found.problem.gap {
        return differs("the light is not on the axis of the discs");
    }
    let solved = found.problem.discs(radius)?;
    Ok(Box::new(move |sensor| {
        let (plane, r) = found.place(sensor)?;
        Ok(solved.illuminance(plane, r)?)
    }))
}

fn plane(object: &ObjectSpec) -> Result<Side<'_>, Mismatch> {
    let ObjectSpec::Plane(plane) = object else {
        return differs(format!("there is a {}", object.type_name()));
    };
    Ok(Side { point: plane.point, normal: plane.normal, material: &plane.material })
}

fn disc(object: &ObjectSpec) -> Result<&DiscSpec, Mismatch> {
    let ObjectSpec::Disc(disc) = object else {
        return differs(format!("there is a {}", object.type_name()));
    };
    Ok(disc)
}

impl<'a> Sobolev<'a> {
    fn of(file: &'a SceneFile, sides: [Side<'a>; 2]) -> Result<Self, Mismatch> {
        let lamp = only_lamp(file)?;
        let [lower, upper] = &sides;
        let gap = (upper.point - lower.point).dot(lower.normal);
        let source_height = (lamp.at - lower.point).dot(lower.normal);
        if !same(lower.normal, -upper.normal) || gap <= 0.0 {
            return differs("the two do not face each other");
        }
        if source_height <= 0.0 || source_height >= gap {
            return differs("the light is not between the two");
        }
        let problem = SobolevProblem {
            reflectance: [dark(file, lower.material)?, dark(file, upper.material)?],
            source_height,
            gap,
            intensity: intensity(lamp),
        };
        Ok(Self { problem, sides, lamp })
    }

    /// Returns on which side a sensor is, and how far from the axis.
    fn place(&self, sensor: &Sensor) -> Result<(Plane, f64), Mismatch> {
        let along = self.sides[0].normal;
        let lies = |side: &Side| {
            (sensor.at - side.point).dot(along).abs() <= NEAR * self.problem.gap
                && same(sensor.normal, side.normal)
        };
        let plane = match self.sides.each_ref().map(lies) {
            [true, _] => Plane::Lower,
            [_, true] => Plane::Upper,
            _ => return Err(Mismatch::Sensor("is not on a plane")),
        };
        let off = sensor.at - self.lamp.at;
        Ok((plane, off.reject_from_normalized(along).length()))
    }
}
