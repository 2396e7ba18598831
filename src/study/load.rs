//! From a scene file to a scene: surfaces are built, meshes fitted, sensors laid out, and
//! implausible scenes are reported.

use std::collections::BTreeMap;
use std::sync::Arc;

use glam::DVec3;
use rayon::prelude::*;

use super::built::Built;
use super::detail::{Detail, detail};
use super::on_surface::Form;
use super::sensors::{SensorGroup, behind, check_distances, sensors};
use super::shared_surfaces::{Preparation, SharedSurfaces};
use super::solids::{self, Body, Solid};
use super::stage::{LoadingObserver, LoadingStage};
use super::warnings::{coincidences, misplaced_cameras, misplaced_sensors, overlaps};
use crate::fit::Fit;
use crate::io::input::FilesRead;
use crate::io::scene_file::{
    BoxFace, CameraSpec, DistributionSpec, FileRef, LightSpec, MaterialSpec, MeshSpec, ObjectSpec,
    SceneFile, ShSpec, Strength,
};
use crate::math::{Placement, Ray};
use crate::scene::{Camera, Distribution, Glossy, Material, Object, PointLight, Scene, Sensor};
use crate::sh::Coefficients;
use crate::surface::primitives::{AxisBox, Disc, Plane, Rectangle, Sphere};
use crate::surface::{Instance, Intersector, SampleArea, StepBisection, Surface};
use crate::{Error, Result};

/// Holds a scene ready to be lit, with what was learnt on the way.
pub struct Loaded {
    /// What light meets.
    pub scene: Scene,
    /// The sensors of the file, group by group.
    pub sensors: Vec<SensorGroup>,
    /// The SH objects that were fitted from meshes.
    pub fits: Vec<FittedObject>,
    /// The degrees that SH objects were given for a picture, with their certificates.
    pub details: Vec<DetailedObject>,
    /// What was read for the objects that have files, by their names.
    pub files: BTreeMap<String, FilesRead>,
    /// What it took to prepare the SH objects for rays.
    pub preparation: Preparation,
    /// What is probably not meant, a sentence each.
    pub warnings: Vec<String>,
    /// Whether each object of the scene has an inside.
    bodies: Vec<Body>,
}

impl Loaded {
    /// Names, for each sensor, the object behind whose surface it is: outside the room, or inside
    /// the object. Such a sensor gets no light.
    pub fn behind(&self, sensors: &[Sensor]) -> Vec<Option<String>> {
        let objects = self.scene.objects().iter().zip(&self.bodies);
        let solids: Vec<Solid> = objects.filter_map(|(o, body)| Solid::new(o, *body)).collect();
        sensors.par_iter().map(|sensor| behind(sensor, None, &self.scene, &solids)).collect()
    }
}

/// Names a fitted object.
#[derive(Debug, Clone, PartialEq)]
pub struct FittedObject {
    /// The name in the scene file.
    pub name: String,
    /// The fit, in the unit of the mesh file; objects of one shape share it.
    pub fit: Arc<Fit>,
}

/// Names an object whose degree was chosen for a picture.
#[derive(Debug, Clone, PartialEq)]
pub struct DetailedObject {
    /// The name in the scene file.
    pub name: String,
    /// The degree and what it may cost.
    pub detail: Detail,
}

/// Builds the scene that a file describes, all SH objects at their full degree.
///
/// # Errors
/// [`Error::Input`] (or [`Error::Parameter`] for an override) that points at the key concerned: a
/// file that cannot be used, a mesh that cannot be fitted, a light inside an object.
pub fn load(file: &SceneFile) -> Result<Loaded> {
    load_for_camera(file, None, &|_| ())
}

/// Builds the scene for a picture that `camera` takes, if one is given: SH objects get the degrees
/// that the `detail` of the file, or of the object, allows. `observer` is told what is begun.
///
/// # Errors
/// As [`load`].
pub fn load_for_camera(
    file: &SceneFile,
    camera: Option<&Camera>,
    observer: LoadingObserver,
) -> Result<Loaded> {
    let mut shared = SharedSurfaces::default();
    let objects = file.objects.iter();
    let built =
        objects.map(|(name, spec)| build(file, &mut shared, name, spec, (camera, observer)));
    let built: Vec<Built> = built.collect::<Result<_>>()?;
    observer(LoadingStage::Checking);
    let solids: Vec<Solid> = built.iter().filter_map(|b| Solid::new(&b.object, b.body)).collect();
    let mut warnings = faulty_meshes(&built);
    warnings.extend(overlaps(&solids));
    let lights = lights(file, &built, &solids)?;
    warnings.extend(misplaced_cameras(file, &solids));
    let fits = built
        .iter()
        .filter_map(|b| Some(FittedObject { name: b.object.name.clone(), fit: b.fit.clone()? }));
    let fits = fits.collect();
    let named = |b: &Built| Some(DetailedObject { name: b.object.name.clone(), detail: b.detail? });
    let details = built.iter().filter_map(named).collect();
    let files = file.objects.iter().filter_map(|(name, spec)| {
        Some((name.clone(), shared.read(&spec.file()?.resolved)?.clone()))
    });
    let files = files.collect();
    let scene = Scene::new(built.iter().map(|b| b.object.clone()).collect(), lights)?;
    let sensors = sensors(file, &scene, (&built, &solids), observer)?;
    observer(LoadingStage::Checking);
    check_distances(file, &sensors, scene.lights())?;
    warnings.extend(coincidences(&scene, &solids));
    warnings.extend(misplaced_sensors(&sensors, &scene));
    let preparation = shared.preparation();
    let bodies = built.iter().map(|b| b.body).collect();
    Ok(Loaded { scene, sensors, fits, details, files, preparation, warnings, bodies })
}

/// Builds the camera that `[render]` names, or the only one.
///
/// # Errors
/// As [`SceneFile::camera`].
pub fn camera(file: &SceneFile) -> Result<Camera> {
    let (camera, up) = match file.camera()?.1 {
        CameraSpec::Perspective(s) => {
            (Camera::perspective(s.from, s.to, s.fov.to_radians(), s.resolution)?, s.up)
        }
        CameraSpec::Orthographic(s) => {
            (Camera::orthographic(s.from, s.to, s.film_height(), s.resolution)?, s.up)
        }
        CameraSpec::Fisheye(s) => {
            (Camera::fisheye(s.from, s.to, s.mapping, s.fov.to_radians(), s.resolution)?, s.up)
        }
        CameraSpec::Panorama(s) => {
            (Camera::panorama(s.from, s.towards(), s.pole(), s.resolution)?, None)
        }
    };
    up.map_or(Ok(camera), |up| camera.with_up(up))
}

fn material(file: &SceneFile, name: &str) -> Result<Material> {
    match file.materials.get(name) {
        Some(MaterialSpec::Lambert(spec)) => {
            Ok(Material::lambert(spec.reflectance)?.emitting(spec.exitance))
        }
        Some(MaterialSpec::Metal(spec)) => {
            let surface = Glossy::metal(spec.reflectance, spec.roughness)?;
            Ok(Material::glossy(surface).emitting(spec.exitance))
        }
        Some(MaterialSpec::Coated(spec)) => {
            let surface = Glossy::coated(spec.reflectance, spec.index, spec.roughness)?;
            Ok(Material::glossy(surface).emitting(spec.exitance))
        }
        Some(MaterialSpec::Mirror(spec)) => {
            Ok(Material::mirror(spec.reflectance)?.emitting(spec.exitance))
        }
        Some(MaterialSpec::Mixture(spec)) => {
            let part = |(part, share)| Ok((share, material(file, part)?));
            Material::mixture(&spec.shares().map(part).collect::<Result<Vec<_>>>()?)
        }
        None => Err(Error::Parameter(format!("unknown material `{name}`"))),
    }
}

fn build(
    file: &SceneFile,
    shared: &mut SharedSurfaces,
    name: &str,
    spec: &ObjectSpec,
    (camera, observer): (Option<&Camera>, LoadingObserver),
) -> Result<Built> {
    let own = material(file, spec.material())?;
    match spec {
        ObjectSpec::Box(s) => {
            let surface = AxisBox::new(s.min, s.max)?.turned_inward(s.inward);
            let materials = BoxFace::ALL.iter().map(|face| material(file, s.face_material(*face)));
            let materials = materials.collect::<Result<_>>()?;
            let object = Object { materials, ..Object::new(name, surface, own) };
            Ok(Built::new(object, Body::Convex))
        }
        ObjectSpec::Sphere(s) => {
            let surface = Sphere::new(s.centre, s.radius)?.turned_inward(s.inward);
            Ok(Built::new(Object::new(name, surface, own), Body::Convex))
        }
        ObjectSpec::Rectangle(s) => {
            let surface = Rectangle::new(s.corner, s.edge_u, s.edge_v)?;
            Ok(Built::new(Object::new(name, surface, own), Body::Open))
        }
        ObjectSpec::Disc(s) => {
            let surface = Disc::new(s.centre, s.normal, s.radius)?;
            Ok(Built::new(Object::new(name, surface, own), Body::Open))
        }
        ObjectSpec::Plane(s) => {
            let surface: Arc<dyn Surface> = Arc::new(Plane::new(s.point, s.normal)?);
            let materials = vec![own];
            let object = Object { name: name.to_owned(), surface, area: None, materials };
            Ok(Built::new(object, Body::Open))
        }
        ObjectSpec::Mesh(s) => {
            observer(LoadingStage::Preparing(name));
            build_mesh(file, shared, name, s, own)
        }
        ObjectSpec::Sh(s) => build_sh(file, shared, (name, s), own, (camera, observer)),
    }
}

fn build_mesh(
    file: &SceneFile,
    shared: &mut SharedSurfaces,
    name: &str,
    spec: &MeshSpec,
    own: Material,
) -> Result<Built> {
    let mesh = shared.mesh(&spec.file.resolved, spec.smooth);
    let mesh =
        mesh.map_err(|e| at_file(file, &["objects", name, "mesh", "file"], &spec.file, e))?;
    let placed = Arc::new(Instance::new(mesh.surface, spec.placement().about(DVec3::ZERO)?));
    let object = shared_object(name, &placed, own);
    let body = if mesh.closed { Body::Closed } else { Body::Open };
    let form = Form::Mesh(placed);
    Ok(Built { deficiencies: mesh.deficiencies, form, ..Built::new(object, body) })
}

fn build_sh(
    file: &SceneFile,
    shared: &mut SharedSurfaces,
    (name, spec): (&str, &ShSpec),
    own: Material,
    (camera, observer): (Option<&Camera>, LoadingObserver),
) -> Result<Built> {
    let at_key = |e| at_file(file, &["objects", name, "sh", "file"], &spec.file, e);
    observer(LoadingStage::Reading(name));
    let shape = shared.sh(&spec.file.resolved, spec.degree, spec.centre).map_err(at_key)?;
    observer(LoadingStage::Preparing(name));
    let placement = spec.placement().about(shape.centre)?;
    let detail = seen_detail(&shape.series, &placement, file, spec, camera).map_err(at_key)?;
    let degree = detail.map_or(shape.series.lmax(), |d| d.degree);
    let surface = shape.surface(degree, intersector(spec)).map_err(at_key)?;
    let placed = Arc::new(Instance::new(surface, placement));
    let object = shared_object(name, &placed, own);
    let form = Form::Sh(placed);
    Ok(Built { fit: shape.fit.clone(), detail, form, ..Built::new(object, Body::Closed) })
}

/// Chooses the degree that a picture allows; nothing where nothing asks for it.
fn seen_detail(
    series: &Coefficients,
    placement: &Placement,
    file: &SceneFile,
    spec: &ShSpec,
    camera: Option<&Camera>,
) -> Result<Option<Detail>> {
    let asked = camera.zip(spec.detail.or(file.render.detail));
    asked.map(|(camera, tolerance)| detail(series, placement, camera, &tolerance)).transpose()
}

fn intersector(spec: &ShSpec) -> Intersector {
    match spec.intersector {
        Intersector::StepBisection(usual) => Intersector::StepBisection(StepBisection {
            step: spec.step.unwrap_or(usual.step),
            tolerance: spec.tolerance.unwrap_or(usual.tolerance),
        }),
        other => other,
    }
}

/// Makes an object of a surface that is needed elsewhere too.
fn shared_object<S: SampleArea + 'static>(name: &str, surface: &Arc<S>, own: Material) -> Object {
    Object {
        name: name.to_owned(),
        surface: surface.clone(),
        area: Some(surface.clone()),
        materials: vec![own],
    }
}

/// Points at the key that names a file: the file is missing, or its shape cannot be used. A file
/// that is wrong in itself says where.
fn at_file(file: &SceneFile, key: &[&str], named: &FileRef, error: Error) -> Error {
    error.map(|error| {
        if matches!(error, Error::Input(_)) {
            return error;
        }
        let text = error.to_string();
        let own = named.resolved.display().to_string();
        let message = if text.starts_with(&own) { text } else { format!("{own}: {text}") };
        file.source.error(key, message, None)
    })
}

fn lights(file: &SceneFile, built: &[Built], solids: &[Solid]) -> Result<Vec<PointLight>> {
    let mut lights = Vec::new();
    let objects = || built.iter().map(|b| &b.object);
    for (name, spec) in &file.lights {
        if let Some(object) = objects().find(|o| lies_on(&*o.surface, spec.at)) {
            return Err(file.source.error(
                &["lights", name, spec.type_name(), "at"],
                format!("light `{name}` is on the surface of `{}`", object.name),
                Some("move it off, by a millimetre if it is mounted there".to_owned()),
            ));
        }
        if let Some(solid) = solids::behind(spec.at, None, solids) {
            return Err(file.source.error(
                &["lights", name, spec.type_name(), "at"],
                format!(
                    "light `{name}` is behind the surface of `{}`: outside the room, or inside \
                     the object",
                    solid.name()
                ),
                Some(
                    "move the light, or turn the normals of a room with `inward = true`".to_owned(),
                ),
            ));
        }
        lights.push(light(name, spec));
    }
    Ok(lights)
}

/// Whether a point is on a surface, as well as numbers of its size can say: whether one of three
/// rays towards it meets the surface there.
fn lies_on(surface: &dyn Surface, point: DVec3) -> bool {
    let bounds = surface.bounds();
    let coordinate = point.abs().max_element();
    let size = if bounds.is_finite() { bounds.extent().length() } else { coordinate.max(1.0) };
    let (run, rounding) = (1e-3 * size, 1e-12 * size + 16.0 * f64::EPSILON * coordinate);
    [DVec3::X, DVec3::Y, DVec3::Z].into_iter().any(|axis| {
        // From a little beside an axis, so that no edge of a box is met.
        let direction = (axis + DVec3::new(0.013, 0.017, 0.019)).normalize();
        let hit = surface.hit(&Ray::new(point - run * direction, direction));
        hit.is_some_and(|hit| (hit.distance - run).abs() <= rounding + hit.error)
    })
}

/// Makes the light that a file describes; a flux is turned into the intensity that gives it.
pub(super) fn light(name: &str, spec: &LightSpec) -> PointLight {
    let distribution = match spec.distribution {
        DistributionSpec::Isotropic => Distribution::Isotropic,
        DistributionSpec::Lambert { direction } => Distribution::Lambert { axis: direction },
        DistributionSpec::Spot { direction, inner, outer } => Distribution::Spot {
            axis: direction,
            inner: inner.to_radians().cos(),
            outer: outer.to_radians().cos(),
        },
    };
    let intensity = match spec.strength {
        Strength::Intensity(candela) => spec.colour * candela,
        Strength::Flux(lumen) => spec.colour * (lumen / distribution.integral()),
    };
    PointLight { name: name.to_owned(), at: spec.at, intensity, distribution }
}

/// Says what is wrong with the meshes that are shown as they are.
fn faulty_meshes(built: &[Built]) -> Vec<String> {
    let of = |b: &Built| -> Vec<String> {
        b.deficiencies.iter().map(|text| format!("object `{}`: {text}", b.object.name)).collect()
    };
    built.iter().flat_map(of).collect()
}

#[cfg(test)]
mod tests {
    use std::fmt::Write;
    use std::ops::ControlFlow;
    use std::path::Path;

    use super::*;
    use crate::estimators::{Estimator, SensorSettings, Stop, Weighting, illuminance};
    use crate::fit::Shape;
    use crate::io::coefficients::{SeriesFormat, WriteOptions, encode};
    use crate::io::scene_file::DetailSpec;
    use crate::math::Randomness;

    const HALL: &str = r#"format = 1
[materials.grey.lambert]
reflectance = 0.5
[objects.hall.box]
min = [0, 0, 0]
max = [100, 100, 3]
inward = true
material = "grey"
[lights.lamp.point]
at = [50, 50, 2.9]
intensity = 1000
[sensors.floor.points]
at = [[1, 1, 0], [50, 52, 0]]
normal = [0, 0, 1]
"#;

    /// Writes a hall with `count` heads of degree 4 from one file, in rows 3 m apart, and reads it.
    fn hall(folder: &Path, count: usize) -> SceneFile {
        let mut c = Coefficients::zeros(4);
        c.set(0, 0, 1.0, 0.0);
        c.set(3, 1, 0.1, 0.05);
        c.set(4, 2, -0.05, 0.1);
        let shape = Shape::new(c);
        let bytes = encode(&shape, SeriesFormat::Text, &WriteOptions::default()).expect("encodes");
        std::fs::write(folder.join("head.csv"), bytes).expect("written");
        let mut text = HALL.to_owned();
        for i in 0..count {
            let (x, y) = (2 + 3 * (i % 32), 2 + 3 * (i / 32));
            write!(
                text,
                "[objects.head{i}.sh]\nfile = \"head.csv\"\ndegree = 4\nat = [{x}, {y}, 1.5]\n\
                 rotate = {{ axis = [0, 0, 1], degrees = {i} }}\nmaterial = \"grey\"\n"
            )
            .expect("a string");
        }
        let path = folder.join("hall.toml");
        std::fs::write(&path, text).expect("written");
        SceneFile::read(&path, &[]).expect("a valid scene")
    }

    #[test]
    fn thousand_heads_load_and_are_lit() {
        let folder = tempfile::tempdir().expect("a folder");
        let loaded = load(&hall(folder.path(), 1000)).expect("loads");
        assert_eq!(loaded.scene.objects().len(), 1001);
        assert!(loaded.warnings.is_empty(), "{:?}", loaded.warnings);
        let settings = SensorSettings {
            estimator: Estimator::Local(Weighting::of(&loaded.scene)),
            randomness: Randomness::Sobol,
            seed: 1,
            stop: Stop { walks: Some(64), ..Stop::default() },
        };
        let sensors = &loaded.sensors[0].sensors;
        let lit = illuminance(&loaded.scene, sensors, &settings, &|_| ControlFlow::Continue(()));
        let lit = lit.expect("there is a lamp").results;
        assert!(lit.iter().all(|r| r.total.mean > 0.0), "{lit:?}");
    }

    #[test]
    fn heads_of_one_file_and_chosen_degree_share_a_surface_and_far_ones_have_lower_degrees() {
        let folder = tempfile::tempdir().expect("a folder");
        let mut file = hall(folder.path(), 32);
        file.render.detail = Some(DetailSpec { pixels: 1.0, ..DetailSpec::default() });
        let eye = DVec3::new(0.2, 2.0, 1.5);
        let camera = Camera::perspective(eye, eye + DVec3::X, 1.0, [64, 48]).expect("valid");
        let mut shared = SharedSurfaces::default();
        let built: Vec<Built> = (0..32)
            .map(|i| format!("head{i}"))
            .map(|name| {
                build(&file, &mut shared, &name, &file.objects[&name], (Some(&camera), &|_| ()))
            })
            .collect::<Result<_>>()
            .expect("builds");
        let degrees: Vec<usize> = built.iter().filter_map(|b| b.detail).map(|d| d.degree).collect();
        assert_eq!(degrees.len(), 32);
        assert!(degrees[0] == 4 && degrees[31] < 4, "{degrees:?}");
        assert!(degrees.is_sorted_by(|near, far| near >= far), "{degrees:?}");
        let of_file = shared.sh(&folder.path().join("head.csv"), 4, None).expect("is there");
        for degree in 0..=4 {
            let surface = of_file.surface(degree, Intersector::Patches).expect("a body");
            let users = degrees.iter().filter(|d| **d == degree).count();
            // One more holds the store, and one this test.
            assert_eq!(Arc::strong_count(&surface), users + 2, "degree {degree} of {degrees:?}");
        }
    }

    #[test]
    fn heads_that_cut_through_a_wall_or_another_are_told() {
        let folder = tempfile::tempdir().expect("a folder");
        let mut file = hall(folder.path(), 3);
        let at = |file: &mut SceneFile, name: &str, place: DVec3, scale: f64| {
            let Some(ObjectSpec::Sh(spec)) = file.objects.get_mut(name) else {
                panic!("`{name}` is an SH object");
            };
            (spec.at, spec.scale) = (place, scale);
        };
        at(&mut file, "head0", DVec3::new(0.0, 50.0, 1.5), 1.0);
        at(&mut file, "head1", DVec3::new(200.0, 50.0, 1.5), 1.0);
        at(&mut file, "head2", DVec3::new(200.0, 50.0, 1.5), 0.5);
        let warnings = load(&file).expect("loads").warnings;
        let told = |a: &str, b: &str| {
            warnings.iter().any(|w| w.contains(&format!("`{a}`")) && w.contains(&format!("`{b}`")))
        };
        assert_eq!(warnings.len(), 4, "{warnings:?}");
        assert!(told("head0", "hall") && told("head1", "hall"), "{warnings:?}");
        assert!(told("head2", "hall") && told("head2", "head1"), "{warnings:?}");
    }

    #[test]
    fn lamps_where_light_cannot_leave_or_arrive_are_refused() {
        let folder = Path::new("dir");
        for (from, to, message) in [
            ("at = [50, 50, 2.9]", "at = [50, 50, 3]", "light `lamp` is on the surface of `hall`"),
            ("at = [50, 50, 2.9]", "at = [50, 50, 3.1]", "behind the surface of `hall`"),
            ("[1, 1, 0]", "[50, 50, 2.9]", "sensor 1 of `floor` is where light `lamp` is"),
        ] {
            let text = HALL.replace(from, to);
            let file = SceneFile::parse(&folder.join("hall.toml"), &text, &[]).expect("parses");
            let error = load(&file).err().expect("refused").to_string();
            assert!(error.contains(message), "{error}");
        }
    }
}
