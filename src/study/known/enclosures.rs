//! Closed rooms whose light is known: spheres, alone, divided by a disc or one in the other, and
//! the cube.

use std::f64::consts::PI;

use glam::DVec3;

use super::facts::{
    Grey, NEAR, dark, differs, grey, intensity, lamps, no_lamps, only_lamp, only_object, same,
    two_objects,
};
use super::{Mismatch, Result, Solution};
use crate::exact::Cube;
use crate::exact::enclosures::{CapAndDisc, ConcentricSpheres, IntegratingSphere};
use crate::io::scene_file::{BoxFace, DiscSpec, ObjectSpec, SceneFile, SphereSpec};
use crate::scene::Sensor;

/// Returns what the wall of a sphere receives: of each lamp by itself, and M0/(1 - rho) of its own
/// emission.
pub(super) fn sphere(file: &SceneFile) -> Result<Solution<'_>, Mismatch> {
    let (name, object) = only_object(file)?;
    let ObjectSpec::Sphere(wall) = object else {
        return differs(format!("`{name}` is a {}", object.type_name()));
    };
    if !wall.inward {
        return differs(format!("the normals of `{name}` point outwards"));
    }
    let Grey { reflectance, exitance } = grey(file, &wall.material)?;
    let lamps = lamps(file)?;
    Ok(Box::new(move |sensor| {
        require(on_sphere(sensor, wall))?;
        let towards = (sensor.at - wall.centre).normalize();
        let mut sum = exitance / (1.0 - reflectance);
        for lamp in &lamps {
            let from_centre = lamp.at - wall.centre;
            let problem = IntegratingSphere {
                radius: wall.radius,
                flux: 4.0 * PI * intensity(lamp),
                offset: from_centre.length(),
                boundary: 0.0,
                reflectance: [reflectance; 2],
            };
            let mu = from_centre.normalize_or_zero().dot(towards);
            sum += problem.illuminance(mu.clamp(-1.0, 1.0))?;
        }
        Ok(sum)
    }))
}

/// Returns what a cap and the disc that closes it receive. The disc emits to the side of its normal
/// only, the sphere to both.
pub(super) fn cap(file: &SceneFile) -> Result<Solution<'_>, Mismatch> {
    let (wall, disc) = match two_objects(file)? {
        [ObjectSpec::Sphere(wall), ObjectSpec::Disc(disc)]
        | [ObjectSpec::Disc(disc), ObjectSpec::Sphere(wall)] => (wall, disc),
        [one, other] => {
            return differs(format!("it has a {} and a {}", one.type_name(), other.type_name()));
        }
    };
    no_lamps(file)?;
    if !wall.inward {
        return differs("the normals of the sphere point outwards");
    }
    let off = disc.centre - wall.centre;
    let height = off.dot(disc.normal);
    let [centre, rim] =
        [off.reject_from_normalized(disc.normal).length(), disc.radius.hypot(height)];
    if centre > NEAR * wall.radius || (rim - wall.radius).abs() > NEAR * wall.radius {
        return differs("the rim of the disc is not on the sphere");
    }
    let (around, across) = (grey(file, &wall.material)?, grey(file, &disc.material)?);
    let solve = |fraction: f64, emission: f64| {
        let emission = [around.exitance, emission];
        let reflectance = [around.reflectance, across.reflectance];
        CapAndDisc { fraction, emission, reflectance }.solve()
    };
    // The cap before the disc's normal has the height R - h.
    let before = 0.5 * (1.0 - height / wall.radius);
    let before = [solve(before, across.exitance)?, solve(1.0 - before, 0.0)?];
    Ok(Box::new(move |sensor| {
        let above = (sensor.at - disc.centre).dot(disc.normal);
        if above.abs() <= NEAR * wall.radius {
            require(on_disc(sensor, disc))?;
            let side = usize::from(sensor.normal.dot(disc.normal) < 0.0);
            return Ok(before[side].illuminance[1]);
        }
        require(on_sphere(sensor, wall))?;
        Ok(before[usize::from(above < 0.0)].illuminance[0])
    }))
}

/// Returns what two concentric spheres receive from each other and, the outer one, from itself.
pub(super) fn concentric(file: &SceneFile) -> Result<Solution<'_>, Mismatch> {
    let [ObjectSpec::Sphere(one), ObjectSpec::Sphere(other)] = two_objects(file)? else {
        return differs("its two objects are not both spheres");
    };
    no_lamps(file)?;
    let (inner, outer) = if one.inward { (other, one) } else { (one, other) };
    if inner.inward || !outer.inward {
        return differs("the normals of the spheres do not point to each other");
    }
    if inner.centre.distance(outer.centre) > NEAR * outer.radius {
        return differs("the spheres have different centres");
    }
    let materials = [grey(file, &inner.material)?, grey(file, &outer.material)?];
    let problem = ConcentricSpheres {
        radius: [inner.radius, outer.radius],
        emission: materials.map(|m| m.exitance),
        reflectance: materials.map(|m| m.reflectance),
    };
    let balance = problem.solve()?;
    Ok(Box::new(move |sensor| match [inner, outer].map(|s| on_sphere(sensor, s)) {
        [true, _] => Ok(balance.illuminance[0]),
        [_, true] => Ok(balance.illuminance[1]),
        _ => Err(Mismatch::Sensor(ASIDE)),
    }))
}

/// Returns what the faces of a cube receive (case 5.8 of CIE 171), pointwise.
pub(super) fn cube(file: &SceneFile) -> Result<Solution<'_>, Mismatch> {
    let (name, object) = only_object(file)?;
    let ObjectSpec::Box(room) = object else {
        return differs(format!("`{name}` is a {}", object.type_name()));
    };
    if !room.inward {
        return differs(format!("the normals of `{name}` point outwards"));
    }
    let edges = room.max - room.min;
    let edge = edges.x;
    if (edges - DVec3::splat(edge)).abs().max_element() > NEAR * edge {
        return differs(format!("the edges of `{name}` differ"));
    }
    let faces = BoxFace::ALL.map(|face| dark(file, room.face_material(face)));
    let reflectance = dark(file, &room.material)?;
    for face in faces {
        if face? != reflectance {
            return differs(format!("the faces of `{name}` reflect differently"));
        }
    }
    let (lamp, centre) = (only_lamp(file)?, 0.5 * (room.min + room.max));
    if lamp.at.distance(centre) > NEAR * edge {
        return differs("the light is not in the middle");
    }
    let light = Cube { edge, flux: 4.0 * PI * intensity(lamp), reflectance }.solve()?;
    Ok(Box::new(move |sensor| {
        let from_centre = (sensor.at - centre).to_array();
        let faces = |i: &usize| {
            let away = from_centre[*i];
            let inward = -DVec3::AXES[*i] * away.signum();
            (away.abs() - 0.5 * edge).abs() <= NEAR * edge && same(sensor.normal, inward)
        };
        let Some(axis) = (0..3).find(faces) else { return Err(Mismatch::Sensor(ASIDE)) };
        let [x, y] = [from_centre[(axis + 1) % 3], from_centre[(axis + 2) % 3]];
        Ok(light.illuminance(x, y)?)
    }))
}

/// What is said of a sensor that is on no surface.
const ASIDE: &str = "is not on a surface of the problem, or looks another way";

fn require(lies: bool) -> Result<(), Mismatch> {
    if lies { Ok(()) } else { Err(Mismatch::Sensor(ASIDE)) }
}

/// Whether a sensor is on a sphere and looks the way of its normal.
fn on_sphere(sensor: &Sensor, sphere: &SphereSpec) -> bool {
    let off = sensor.at - sphere.centre;
    let outward = if sphere.inward { -1.0 } else { 1.0 };
    (off.length() - sphere.radius).abs() <= NEAR * sphere.radius
        && same(sensor.normal, outward * off.normalize_or_zero())
}

/// Whether a sensor in the plane of a disc is inside its rim and looks to either side.
fn on_disc(sensor: &Sensor, disc: &DiscSpec) -> bool {
    let inside = sensor.at.distance(disc.centre) < disc.radius;
    inside && [disc.normal, -disc.normal].into_iter().any(|n| same(sensor.normal, n))
}
