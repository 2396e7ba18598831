//! Direct light between black surfaces: point lights by I cos/d^2, rectangles and faces of boxes by
//! Lambert's formula less what a box or a rectangle hides.
//!
//! Cases 5.2, 5.3, 5.4, 5.6 and 5.7 of CIE 171 are of this kind.

use glam::DVec3;

use super::facts::{NEAR, differs, lambert};
use super::{Mismatch, Result, Solution};
use crate::exact::form_factors::{cut_polygon, polygon, polygon_through};
use crate::io::scene_file::{BoxFace, BoxSpec, ObjectSpec, RectangleSpec, SceneFile};
use crate::scene::{PointLight, Sensor};
use crate::study::load;

/// A flat piece of an object.
struct Face {
    object: usize,
    corners: [DVec3; 4],
    normal: DVec3,
    /// What it emits to the side of its normal, lm/m2.
    exitance: f64,
    /// Whether it hides what is behind it: not the walls of a room, which are around everything.
    hides: bool,
    /// Whether it can be seen from behind.
    two_sided: bool,
}

struct Direct<'a> {
    lamps: Vec<PointLight>,
    faces: Vec<Face>,
    room: Option<&'a BoxSpec>,
    objects: usize,
}

pub(super) fn direct(file: &SceneFile) -> Result<Solution<'_>, Mismatch> {
    let mut found = Direct {
        lamps: file.lights.iter().map(|(name, light)| load::light(name, light)).collect(),
        faces: Vec::new(),
        room: None,
        objects: file.objects.len(),
    };
    for (i, (name, object)) in file.objects.iter().enumerate() {
        match object {
            ObjectSpec::Rectangle(spec) => found.faces.push(rectangle(file, i, spec)?),
            ObjectSpec::Box(spec) => {
                if spec.inward && found.room.replace(spec).is_some() {
                    return differs("several boxes have `inward = true`");
                }
                for face in BoxFace::ALL {
                    found.faces.push(box_face(file, i, spec, face)?);
                }
            }
            other => return differs(format!("`{name}` is a {}", other.type_name())),
        }
    }
    found.check_room(file)?;
    Ok(Box::new(move |sensor| found.illuminance(sensor)))
}

/// Returns the exitance of a black Lambert material.
fn exitance(file: &SceneFile, material: &str) -> Result<f64, Mismatch> {
    let (reflectance, exitance) = lambert(file, material)?;
    if !reflectance.is_black() {
        return differs(format!("material `{material}` reflects"));
    }
    Ok(exitance.luminance())
}

fn rectangle(file: &SceneFile, object: usize, spec: &RectangleSpec) -> Result<Face, Mismatch> {
    let (o, u, v) = (spec.corner, spec.edge_u, spec.edge_v);
    Ok(Face {
        object,
        corners: [o, o + u, o + u + v, o + v],
        normal: u.cross(v).normalize(),
        exitance: exitance(file, &spec.material)?,
        hides: true,
        two_sided: true,
    })
}

fn box_face(
    file: &SceneFile,
    object: usize,
    spec: &BoxSpec,
    face: BoxFace,
) -> Result<Face, Mismatch> {
    let axis = face.axis();
    let at_max = matches!(face, BoxFace::XMax | BoxFace::YMax | BoxFace::ZMax);
    let corner = |u_max: bool, v_max: bool| {
        let pick = |max: bool, i: usize| if max { spec.max[i] } else { spec.min[i] };
        let mut place = [0.0; 3];
        place[axis] = pick(at_max, axis);
        place[(axis + 1) % 3] = pick(u_max, (axis + 1) % 3);
        place[(axis + 2) % 3] = pick(v_max, (axis + 2) % 3);
        DVec3::from_array(place)
    };
    let outward = if at_max { DVec3::AXES[axis] } else { -DVec3::AXES[axis] };
    Ok(Face {
        object,
        corners: [
            corner(false, false),
            corner(true, false),
            corner(true, true),
            corner(false, true),
        ],
        normal: if spec.inward { -outward } else { outward },
        exitance: exitance(file, spec.face_material(face))?,
        hides: !spec.inward,
        two_sided: false,
    })
}

impl Face {
    /// Returns how far a point is before the face.
    fn height(&self, point: DVec3) -> f64 {
        (point - self.corners[0]).dot(self.normal)
    }

    /// Whether the face stands before a point, as far as it can hide anything: whether the point is
    /// off its plane, on a side that can be seen.
    fn stands_before(&self, point: DVec3) -> bool {
        let size = self.corners[0].distance(self.corners[2]);
        let height = self.height(point);
        let before = if self.two_sided { height.abs() } else { height };
        self.hides && before > NEAR * size
    }

    /// Whether the face meets the segment between two points off its plane.
    fn cuts(&self, from: DVec3, to: DVec3) -> bool {
        let [a, b] = [from, to].map(|p| self.height(p));
        if a * b >= 0.0 {
            return false;
        }
        let crossing = from.lerp(to, a / (a - b));
        let side = |i: usize| {
            let (p, q) = (self.corners[i], self.corners[(i + 1) % 4]);
            (q - p).cross(crossing - p).dot(self.normal)
        };
        let sides = [0, 1, 2, 3].map(side);
        sides.iter().all(|s| *s >= 0.0) || sides.iter().all(|s| *s <= 0.0)
    }
}

impl Direct<'_> {
    /// Rejects objects that touch the walls of the room or are outside, if they emit or hide: only
    /// what is certainly before a wall is seen.
    fn check_room(&self, file: &SceneFile) -> Result<(), Mismatch> {
        let Some(room) = self.room else { return Ok(()) };
        let margin = DVec3::splat(NEAR * (room.max - room.min).max_element());
        for face in self.faces.iter().filter(|face| face.hides) {
            // A lamp in the plane of a wall is behind it as much as before it.
            let edge = if face.exitance > 0.0 { margin } else { -margin };
            let inside =
                |c: &DVec3| c.cmpge(room.min + edge).all() && c.cmple(room.max - edge).all();
            if !face.corners.iter().all(inside) {
                let name = file.objects.keys().nth(face.object).map_or("", String::as_str);
                return differs(format!(
                    "`{name}` is not inside the room; move it off the wall by a millimetre"
                ));
            }
        }
        Ok(())
    }

    fn illuminance(&self, sensor: &Sensor) -> Result<f64, Mismatch> {
        let (at, normal) = (sensor.at, sensor.normal);
        let mut sum = 0.0;
        for lamp in &self.lamps {
            let to_lamp = lamp.at - at;
            let cos = to_lamp.normalize().dot(normal);
            let hidden = |f: &Face| f.stands_before(at) && f.cuts(at, lamp.at);
            if cos > 0.0 && !self.faces.iter().any(hidden) {
                let intensity = lamp.towards(-to_lamp.normalize()).luminance();
                sum += intensity * cos / to_lamp.length_squared();
            }
        }
        for lamp in self.faces.iter().filter(|face| face.exitance > 0.0) {
            if lamp.height(at) > 0.0 {
                sum += lamp.exitance * self.seen(lamp, at, normal)?;
            }
        }
        Ok(sum)
    }

    /// Returns the configuration factor of what is seen of a face that emits.
    fn seen(&self, lamp: &Face, at: DVec3, normal: DVec3) -> Result<f64, Mismatch> {
        let all = polygon(&lamp.corners, at, normal);
        let mut hidden = 0.0;
        for object in (0..self.objects).filter(|object| *object != lamp.object) {
            let own = self.faces.iter().filter(|f| f.object == object && f.stands_before(at));
            let by_face = own.map(|face| {
                // What is behind the lamp hides nothing of it.
                let before = cut_polygon(&face.corners, lamp.corners[0], lamp.normal);
                polygon_through(&lamp.corners, &before, at, normal)
            });
            let part: f64 = by_face.sum();
            if part > NEAR * all && hidden > 0.0 {
                return Err(Mismatch::Sensor("sees a lamp past two objects"));
            }
            hidden += if part > NEAR * all { part } else { 0.0 };
        }
        Ok((all - hidden).max(0.0))
    }
}
