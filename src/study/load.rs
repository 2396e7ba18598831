//! From a scene file to a scene: surfaces are built, meshes fitted, sensors laid out, and what cannot be meant is said.

use std::path::Path;
use std::sync::Arc;

use glam::DVec3;

use super::detail::{Detail, detail};
use super::fit::{Fit, FitSettings, fit};
use super::{grids, solids};
use crate::io::coefficients::{self, ReadOptions, SeriesFormat};
use crate::io::meshes;
use crate::io::scene_file::{
    self, BoxFace, CameraSpec, FileRef, LightSpec, MaterialSpec, MeshSpec, ObjectSpec,
    PlacementSpec, SceneFile, SensorSpec, ShSpec,
};
use crate::math::Placement;
use crate::scene::{Material, Object, Perspective, PointLight, Scene, Sensor};
use crate::sh::Coefficients;
use crate::surface::primitives::{AxisBox, Disc, Plane, Rectangle, Sphere};
use crate::surface::{
    Instance, Intersector, MeshReport, MeshSurface, SampleArea, ShSurface, StepBisection, Surface,
};
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
    /// What is probably not meant, a sentence each.
    pub warnings: Vec<String>,
}

/// Names a set of sensors.
#[derive(Debug, Clone, PartialEq)]
pub struct SensorGroup {
    /// The name in the scene file.
    pub name: String,
    /// The sensors.
    pub sensors: Vec<Sensor>,
}

/// Names a fitted object.
#[derive(Debug, Clone, PartialEq)]
pub struct FittedObject {
    /// The name in the scene file.
    pub name: String,
    /// The fit, in the unit of the mesh file.
    pub fit: Fit,
}

/// Names an object whose degree was chosen for a picture.
#[derive(Debug, Clone, PartialEq)]
pub struct DetailedObject {
    /// The name in the scene file.
    pub name: String,
    /// The degree and what it may cost.
    pub detail: Detail,
}

/// An object with what the checks need to know of it.
struct Built {
    object: Object,
    /// Whether its surface has an inside.
    closed: bool,
    fit: Option<Fit>,
    detail: Option<Detail>,
    /// What is wrong with the mesh it was made of.
    deficiencies: Vec<String>,
}

/// Builds the scene that a file describes, all SH objects at their full degree.
///
/// # Errors
/// [`Error::Input`] (or [`Error::Parameter`] for an override) that points at the key concerned: a file that cannot be used, a mesh that cannot be
/// fitted, a light inside an object.
pub fn load(file: &SceneFile) -> Result<Loaded> {
    load_seen(file, None)
}

/// Builds the scene for a picture that `camera` takes: SH objects get the degrees that the `detail` of the file, or of the object, allows.
///
/// # Errors
/// As [`load`].
pub fn load_seen(file: &SceneFile, camera: Option<&Perspective>) -> Result<Loaded> {
    let built = file.objects.iter().map(|(name, spec)| build(file, name, spec, camera));
    let built: Vec<Built> = built.collect::<Result<_>>()?;
    let mut warnings = faulty_meshes(&built);
    warnings.extend(overlaps(&built));
    let lights = lights(file, &built)?;
    let solids: Vec<&Object> = built.iter().filter(|b| b.closed).map(|b| &b.object).collect();
    warnings.extend(misplaced_cameras(file, &solids));
    let fits = built
        .iter()
        .filter_map(|b| Some(FittedObject { name: b.object.name.clone(), fit: b.fit.clone()? }));
    let fits = fits.collect();
    let named = |b: &Built| Some(DetailedObject { name: b.object.name.clone(), detail: b.detail? });
    let details = built.iter().filter_map(named).collect();
    let scene = Scene::new(built.iter().map(|b| b.object.clone()).collect(), lights)?;
    let sensors = sensors(file, &scene)?;
    warnings.extend(misplaced_sensors(&sensors, &solids));
    Ok(Loaded { scene, sensors, fits, details, warnings })
}

/// Builds the camera that `[render]` names, or the only one.
///
/// # Errors
/// As [`SceneFile::camera`].
pub fn camera(file: &SceneFile) -> Result<Perspective> {
    let (_, CameraSpec::Perspective(spec)) = file.camera()?;
    let camera = Perspective::new(spec.from, spec.to, spec.fov.to_radians(), spec.resolution)?;
    spec.up.map_or(Ok(camera), |up| camera.with_up(up))
}

fn material(file: &SceneFile, name: &str) -> Result<Material> {
    match file.materials.get(name) {
        Some(MaterialSpec::Lambert(spec)) => {
            Ok(Material::lambert(spec.reflectance)?.emitting(spec.exitance))
        }
        None => Err(Error::Parameter(format!("unknown material `{name}`"))),
    }
}

fn build(
    file: &SceneFile,
    name: &str,
    spec: &ObjectSpec,
    camera: Option<&Perspective>,
) -> Result<Built> {
    let own = material(file, spec.material())?;
    let bare = |object, closed| Built {
        object,
        closed,
        fit: None,
        detail: None,
        deficiencies: Vec::new(),
    };
    let solid = |object| bare(object, true);
    let open = |object| bare(object, false);
    match spec {
        ObjectSpec::Box(s) => {
            let surface = AxisBox::new(s.min, s.max)?.turned_inward(s.inward);
            let materials = BoxFace::ALL.iter().map(|face| material(file, s.face_material(*face)));
            let materials = materials.collect::<Result<_>>()?;
            Ok(solid(Object { materials, ..Object::new(name, surface, own) }))
        }
        ObjectSpec::Sphere(s) => {
            let surface = Sphere::new(s.centre, s.radius)?.turned_inward(s.inward);
            Ok(solid(Object::new(name, surface, own)))
        }
        ObjectSpec::Rectangle(s) => {
            Ok(open(Object::new(name, Rectangle::new(s.corner, s.edge_u, s.edge_v)?, own)))
        }
        ObjectSpec::Disc(s) => {
            Ok(open(Object::new(name, Disc::new(s.centre, s.normal, s.radius)?, own)))
        }
        ObjectSpec::Plane(s) => {
            let surface: Arc<dyn Surface> = Arc::new(Plane::new(s.point, s.normal)?);
            let materials = vec![own];
            Ok(open(Object { name: name.to_owned(), surface, area: None, materials }))
        }
        ObjectSpec::Mesh(s) => build_mesh(file, name, s, own),
        ObjectSpec::Sh(s) => build_sh(file, name, s, own, camera),
    }
}

fn build_mesh(file: &SceneFile, name: &str, spec: &MeshSpec, own: Material) -> Result<Built> {
    let key = ["objects", name, "mesh", "file"];
    let mesh = read(file, &key, &spec.file, meshes::read)?;
    let report = MeshReport::of(&mesh);
    let surface = if spec.smooth { MeshSurface::smooth(mesh) } else { MeshSurface::new(mesh) };
    let surface = surface.map_err(|e| at_key(file, &key, &spec.file, &e))?;
    let object = place(name, surface, &spec.placement(), DVec3::ZERO, own)?;
    let closed = report.is_closed() && !report.is_inside_out();
    Ok(Built { object, closed, fit: None, detail: None, deficiencies: report.deficiencies() })
}

fn build_sh(
    file: &SceneFile,
    name: &str,
    spec: &ShSpec,
    own: Material,
    camera: Option<&Perspective>,
) -> Result<Built> {
    let key = ["objects", name, "sh", "file"];
    let (series, centre, fit) = if SeriesFormat::of_extension(&spec.file.resolved).is_some() {
        let shape =
            read(file, &key, &spec.file, |path| coefficients::read(path, &ReadOptions::default()))?;
        (shape.coefficients.truncated(spec.degree), shape.centre, None)
    } else {
        let mesh = read(file, &key, &spec.file, meshes::read)?;
        let settings = FitSettings { centre: spec.centre, ..FitSettings::of_degree(spec.degree) };
        let fit = fit(&mesh, &settings).map_err(|e| at_key(file, &key, &spec.file, &e))?;
        (fit.coefficients.clone(), fit.centre, Some(fit))
    };
    let (series, detail) =
        simplified(series, &spec.placement().about(centre)?, file, spec, camera)?;
    let surface = ShSurface::new(&series, intersector(spec))
        .map_err(|e| at_key(file, &key, &spec.file, &e))?;
    let object = place(name, surface, &spec.placement(), centre, own)?;
    Ok(Built { object, closed: true, fit, detail, deficiencies: Vec::new() })
}

/// Truncates a series as far as a picture allows; not at all where nothing asks for it.
fn simplified(
    series: Coefficients,
    placement: &Placement,
    file: &SceneFile,
    spec: &ShSpec,
    camera: Option<&Perspective>,
) -> Result<(Coefficients, Option<Detail>)> {
    let (Some(camera), Some(tolerance)) = (camera, spec.detail.or(file.render.detail)) else {
        return Ok((series, None));
    };
    let chosen = detail(&series, placement, camera, &tolerance)?;
    Ok((series.truncated(chosen.degree), Some(chosen)))
}

fn intersector(spec: &ShSpec) -> Intersector {
    let default = StepBisection::default();
    match spec.intersector {
        scene_file::Intersector::Patches => Intersector::Patches,
        scene_file::Intersector::Certified => Intersector::Certified,
        scene_file::Intersector::StepBisection => Intersector::StepBisection(StepBisection {
            step: spec.step.unwrap_or(default.step),
            tolerance: spec.tolerance.unwrap_or(default.tolerance),
        }),
    }
}

/// Places a surface whose origin is the point `origin` of its file.
fn place<S: SampleArea + 'static>(
    name: &str,
    surface: S,
    spec: &PlacementSpec,
    origin: DVec3,
    own: Material,
) -> Result<Object> {
    Ok(Object::new(name, Instance::new(Arc::new(surface), spec.about(origin)?), own))
}

/// Reads a file that the scene names; a file that is missing points at the key, a file that is wrong at itself.
fn read<T>(
    file: &SceneFile,
    key: &[&str],
    named: &FileRef,
    reader: impl Fn(&Path) -> Result<T>,
) -> Result<T> {
    reader(&named.resolved).map_err(|error| match error {
        Error::Io { .. } => at_key(file, key, named, &error),
        other => other,
    })
}

fn at_key(file: &SceneFile, key: &[&str], named: &FileRef, error: &Error) -> Error {
    let text = error.to_string();
    let own = named.resolved.display().to_string();
    let message = if text.starts_with(&own) { text } else { format!("{own}: {text}") };
    file.source.error(key, message, None)
}

fn lights(file: &SceneFile, built: &[Built]) -> Result<Vec<PointLight>> {
    let mut lights = Vec::new();
    for (name, LightSpec::Point(spec)) in &file.lights {
        if let Some(solid) =
            built.iter().find(|b| b.closed && solids::is_behind(&*b.object.surface, spec.at))
        {
            return Err(file.source.error(
                &["lights", name, "point", "at"],
                format!(
                    "light `{name}` is behind the surface of `{}`: outside the room, or inside the object",
                    solid.object.name
                ),
                Some(
                    "move the light, or turn the normals of a room with `inward = true`".to_owned(),
                ),
            ));
        }
        lights.push(PointLight { name: name.clone(), at: spec.at, intensity: spec.intensity() });
    }
    Ok(lights)
}

/// Says what is wrong with the meshes that are shown as they are.
fn faulty_meshes(built: &[Built]) -> Vec<String> {
    let of = |b: &Built| -> Vec<String> {
        b.deficiencies.iter().map(|text| format!("object `{}`: {text}", b.object.name)).collect()
    };
    built.iter().flat_map(of).collect()
}

/// Says which objects cut through or lie behind closed ones.
fn overlaps(built: &[Built]) -> Vec<String> {
    let mut warnings = Vec::new();
    for one in built.iter().filter(|b| b.closed) {
        // The smaller of two is judged against the larger: a room lies around its contents.
        for other in built.iter().filter(|b| b.closed && size(b) > size(one)) {
            let (name, into) = (&one.object.name, &other.object.name);
            match solids::share_behind(&one.object, &*other.object.surface) {
                Some(share) if share >= 1.0 => {
                    warnings.push(format!("object `{name}` is entirely outside the room, or inside the object, `{into}`"));
                }
                Some(share) if share > 0.0 => warnings.push(format!(
                    "object `{name}` cuts through `{into}`: about {:.0} % of its surface is behind it",
                    100.0 * share.max(0.01)
                )),
                _ => {}
            }
        }
    }
    warnings
}

/// Gives the diagonal of an object's bounds, metres.
fn size(built: &Built) -> f64 {
    built.object.surface.bounds().extent().length()
}

fn misplaced_cameras(file: &SceneFile, solids: &[&Object]) -> Vec<String> {
    let eyes = file.cameras.iter().map(|(name, CameraSpec::Perspective(spec))| (name, spec.from));
    eyes.filter_map(|(name, from)| {
        let solid = solids.iter().find(|o| solids::is_behind(&*o.surface, from))?;
        Some(format!("camera `{name}` is outside the room, or inside the object, `{}`", solid.name))
    })
    .collect()
}

fn sensors(file: &SceneFile, scene: &Scene) -> Result<Vec<SensorGroup>> {
    let lay_out = |name: &str, spec: &SensorSpec| match spec {
        SensorSpec::Points(points) => {
            Ok(points.at.iter().map(|&at| Sensor { at, normal: points.normal }).collect())
        }
        SensorSpec::Grid(grid) => grids::sensors(grid, file, scene.bounds()).map_err(|count| {
            let message = format!(
                "the grid `{name}` would have {count:.3e} sensors, more than {}",
                grids::MAX_SENSORS
            );
            let help = "write a larger `spacing`, or a smaller `count`".to_owned();
            file.source.error(&["sensors", name, "grid"], message, Some(help))
        }),
    };
    file.sensors
        .iter()
        .map(|(name, spec)| Ok(SensorGroup { name: name.clone(), sensors: lay_out(name, spec)? }))
        .collect()
}

fn misplaced_sensors(groups: &[SensorGroup], solids: &[&Object]) -> Vec<String> {
    let mut warnings = Vec::new();
    for group in groups {
        if group.sensors.is_empty() {
            warnings.push(format!(
                "sensors `{}`: the border leaves no area, so there are none",
                group.name
            ));
        }
        // A sensor on a wall is judged by a point just before it.
        let before = |s: &Sensor| s.at + 1e-6 * s.at.length().max(1.0) * s.normal;
        for solid in solids {
            let hidden = group
                .sensors
                .iter()
                .filter(|s| solids::is_behind(&*solid.surface, before(s)))
                .count();
            if hidden > 0 {
                warnings.push(format!(
                    "sensors `{}`: {hidden} of {} are outside the room, or inside the object, `{}` and get no light",
                    group.name,
                    group.sensors.len(),
                    solid.name
                ));
            }
        }
    }
    warnings
}
