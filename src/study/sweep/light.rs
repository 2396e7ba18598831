//! What a truncation degree costs and buys in a scene: the picture and the illuminances, beside
//! those with the original, and what noise alone changes in them.

use std::io::Write;
use std::ops::ControlFlow;
use std::path::Path;
use std::time::Duration;

use rayon::prelude::*;
use tempfile::NamedTempFile;

use super::Original;
use super::row::{Column, Rendition, SweepRow};
use crate::estimators::{
    Estimator, ImageSettings, REPLICATES, Rendering, Stop, illuminance, resume, walks_per_sample,
};
use crate::fit::Shape;
use crate::io::coefficients::{SeriesFormat, WriteOptions, encode};
use crate::io::scene_file::{FileRef, MeshSpec, ObjectSpec, SceneFile, ShSpec};
use crate::math::Unit;
use crate::mesh::UpAxis;
use crate::scene::{Camera, Film, FirstHits, Scene, Sensor};
use crate::study::{
    PIXELS_PER_DEGREE, Picture, camera, compare_pictures, image_settings, load, relative_mse,
    sensor_settings,
};
use crate::{Error, Result};

/// Sets what is looked at in a scene.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct LightSettings {
    /// The columns and rows of the pictures; without them the camera's, scaled to a width of 200 at
    /// most.
    pub size: Option<[u32; 2]>,
    /// The eye rays of a pixel.
    pub samples: u32,
    /// How the file of what is swept was read; the scene must say the same of it.
    pub unit: Unit,
    /// The axis of that file that points up.
    pub up: UpAxis,
}

/// The largest width of a picture whose size was not asked for.
const WIDTH: u32 = 200;

/// A scene with an object that is swept.
pub struct Light {
    file: SceneFile,
    /// The objects that are made of what is swept.
    names: Vec<String>,
    /// Who takes the pictures, if anyone.
    camera: Option<Camera>,
    samples: u32,
    original: Seen,
    noise: SweepRow,
}

/// What a scene looks like and receives.
struct Seen {
    shots: Option<Shots>,
    /// Which pixels see the object in their middle.
    mask: Vec<bool>,
    lux: Vec<f64>,
}

/// The pictures of a run.
struct Shots {
    /// After the samples that are asked for, and the time they took.
    picture: Picture,
    time: Duration,
    /// After the time that the original took.
    at_equal_time: Picture,
}

/// What stands for an object: the mesh of its file, or a series in a file of its own.
enum Stand {
    Mesh,
    Series(NamedTempFile, usize),
}

impl Stand {
    fn series(shape: &Shape) -> Result<Self> {
        let failed = |e| Error::io("a temporary file".as_ref(), "write", e);
        let mut file = tempfile::Builder::new().suffix(".txt").tempfile().map_err(failed)?;
        let text = encode(shape, SeriesFormat::Text, &WriteOptions::default())?;
        file.write_all(&text).map_err(failed)?;
        Ok(Self::Series(file, shape.coefficients.lmax()))
    }
}

impl Light {
    /// Takes the pictures and illuminances of the original, twice: `path` is its file, which
    /// `scene` has as one SH object or more.
    ///
    /// # Errors
    /// [`Error::Parameter`] when the scene has no SH object of that file, or neither a camera nor
    /// sensors; as [`load`] and [`illuminance`].
    pub fn new(
        scene: SceneFile,
        path: &Path,
        original: &Original,
        settings: LightSettings,
    ) -> Result<Self> {
        let names = objects_of(&scene, path)?;
        require_same_reading(&scene, &names, original, settings)?;
        let camera = if scene.cameras.is_empty() { None } else { Some(camera(&scene)?) };
        if camera.is_none() && scene.sensors.is_empty() {
            let text = "the scene has neither a camera nor sensors: there is nothing to compare";
            return Err(Error::Parameter(text.to_owned()));
        }
        let camera = camera.map(|camera| {
            let [width, height] = camera.resolution();
            let narrow = width.min(WIDTH);
            let scaled = [narrow, (height * narrow).div_ceil(width)];
            camera.with_resolution(settings.size.unwrap_or(scaled))
        });
        let noise = SweepRow::new(Rendition::Original, None);
        let stand = match original {
            Original::Mesh(..) => Stand::Mesh,
            Original::Series(shape) => Stand::series(shape)?,
        };
        let original = Seen { shots: None, mask: Vec::new(), lux: Vec::new() };
        let mut light =
            Self { file: scene, names, camera, samples: settings.samples, original, noise };
        light.original = light.look(&stand, 0, None)?;
        let other = light.look(&stand, 1, light.time())?;
        let mut noise = light.noise.clone();
        light.judge(&other, &mut noise)?;
        light.noise = noise;
        Ok(light)
    }

    /// Returns the picture of the original, if any are taken.
    pub fn picture(&self) -> Option<&Picture> {
        self.original.shots.as_ref().map(|shots| &shots.picture)
    }

    /// Returns the time that the picture of the original took.
    fn time(&self) -> Option<Duration> {
        self.original.shots.as_ref().map(|shots| shots.time)
    }

    /// Writes into the line of the original what noise alone brings.
    pub fn measure_original(&self, row: &mut SweepRow) {
        self.tell_noise(row);
        for zero in [Column::RelMse, Column::Silhouette, Column::LuxMax] {
            row[zero] = if self.noise[zero].is_nan() { f64::NAN } else { 0.0 };
        }
        if let Some(time) = self.time() {
            (row[Column::Render], row[Column::RenderRatio]) = (time.as_secs_f64(), 1.0);
        }
        for same in [Column::RelMseEqualTime, Column::Flip] {
            row[same] = self.noise[same];
        }
    }

    /// Looks at the scene with a series in the place of the original, and returns the picture.
    ///
    /// # Errors
    /// As [`Light::new`].
    pub fn measure(&self, shape: &Shape, row: &mut SweepRow) -> Result<Option<Picture>> {
        let seen = self.look(&Stand::series(shape)?, 1, self.time())?;
        self.judge(&seen, row)?;
        self.tell_noise(row);
        let beyond = row[Column::RelMse] - self.noise[Column::RelMse];
        // Unlike `max`, this keeps what is not known.
        row[Column::RelMse] = beyond.clamp(0.0, f64::INFINITY);
        Ok(seen.shots.map(|shots| shots.picture))
    }

    /// Writes into a line what noise alone brings.
    fn tell_noise(&self, row: &mut SweepRow) {
        for (column, found) in [
            (Column::RelMseNoise, Column::RelMse),
            (Column::FlipNoise, Column::Flip),
            (Column::LuxNoise, Column::LuxMax),
        ] {
            row[column] = self.noise[found];
        }
    }

    fn judge(&self, seen: &Seen, row: &mut SweepRow) -> Result<()> {
        let original = &self.original;
        if let (Some(own), Some(other)) = (&seen.shots, &original.shots) {
            let found = compare_pictures(&own.picture, &other.picture, PIXELS_PER_DEGREE)?;
            row[Column::RelMse] = found.relative_mse.luminance;
            row[Column::Flip] = found.flip.mean;
            row[Column::RelMseEqualTime] =
                relative_mse(&own.at_equal_time, &other.picture).luminance;
            let changed = seen.mask.iter().zip(&original.mask).filter(|(a, b)| a != b).count();
            row[Column::Silhouette] = changed as f64;
            row[Column::Render] = own.time.as_secs_f64();
            row[Column::RenderRatio] = own.time.as_secs_f64() / other.time.as_secs_f64();
        }
        let changes = seen.lux.iter().zip(&original.lux).filter(|(_, lux)| **lux > 0.0);
        let changes = changes.map(|(own, lux)| (own / lux - 1.0).abs());
        row[Column::LuxMax] = changes.fold(f64::NAN, f64::max);
        Ok(())
    }

    /// Takes picture and illuminances; `more` is added to the seeds, `limit` the time at which a
    /// second picture is taken.
    fn look(&self, stand: &Stand, more: u64, limit: Option<Duration>) -> Result<Seen> {
        let file = self.with(stand);
        let loaded = load(&file)?;
        let mut seen = Seen { shots: None, mask: Vec::new(), lux: Vec::new() };
        if let Some(camera) = &self.camera {
            let mut settings = image_settings(&file.render, &loaded.scene);
            settings.seed = settings.seed.wrapping_add(more);
            let walks = u64::from(self.samples) * walks_per_sample(&settings.estimator) as u64;
            seen.shots = Some(shoot(&loaded.scene, camera, &settings, walks, limit)?);
            let hits = FirstHits { scene: &loaded.scene, camera, filter: settings.filter };
            let objects = loaded.scene.objects();
            let is_own = |id: f32| {
                let object = (id as usize).checked_sub(1).and_then(|id| objects.get(id));
                object.is_some_and(|object| self.names.contains(&object.name))
            };
            seen.mask = hits.id().into_par_iter().map(is_own).collect();
        }
        let sensors: Vec<Sensor> = loaded.sensors.iter().flat_map(|g| g.sensors.clone()).collect();
        if !sensors.is_empty() {
            let mut settings = sensor_settings(&file.illum, &loaded.scene);
            settings.seed = settings.seed.wrapping_add(more);
            if settings.stop == Stop::default()
                && !matches!(settings.estimator, Estimator::Radiosity(_))
            {
                settings.stop.walks = Some(1 << 18);
            }
            let survey =
                illuminance(&loaded.scene, &sensors, &settings, &|_| ControlFlow::Continue(()))?;
            seen.lux = survey.results.iter().map(|result| result.total.mean).collect();
        }
        Ok(seen)
    }

    /// Puts what stands for the objects in their place.
    fn with(&self, stand: &Stand) -> SceneFile {
        let mut file = self.file.clone();
        for name in &self.names {
            if let Some(ObjectSpec::Sh(spec)) = self.file.objects.get(name) {
                file.objects.insert(name.clone(), replaced(spec, stand));
            }
        }
        file
    }
}

/// Finds the SH objects of a scene that are made of a file.
fn objects_of(scene: &SceneFile, path: &Path) -> Result<Vec<String>> {
    let canonical = |path: &Path| std::fs::canonicalize(path).ok();
    let own = canonical(path);
    let of_file = |spec: &ObjectSpec| match spec {
        ObjectSpec::Sh(spec) => own.is_some() && canonical(&spec.file.resolved) == own,
        _ => false,
    };
    let names: Vec<String> = scene
        .objects
        .iter()
        .filter(|(_, spec)| of_file(spec))
        .map(|(name, _)| name.clone())
        .collect();
    if !names.is_empty() {
        return Ok(names);
    }
    let files = scene.objects.values().filter_map(|spec| match spec {
        ObjectSpec::Sh(spec) => Some(spec.file.written.display().to_string()),
        _ => None,
    });
    let files: Vec<String> = files.collect();
    let others = match files.as_slice() {
        [] => "it has no `sh` object at all; write the mesh as one, with a `degree`".to_owned(),
        files => format!("its `sh` objects are of {}", files.join(", ")),
    };
    Err(Error::Parameter(format!(
        "the scene has no [objects.NAME.sh] whose file is {}: {others}",
        path.display()
    )))
}

/// Rejects objects whose file the scene reads otherwise: they would have another size.
fn require_same_reading(
    scene: &SceneFile,
    names: &[String],
    original: &Original,
    as_read: LightSettings,
) -> Result<()> {
    let LightSettings { unit, up, .. } = as_read;
    for name in names {
        if let Some(ObjectSpec::Sh(spec)) = scene.objects.get(name)
            && (spec.unit, spec.up) != (unit, up)
        {
            let help = match original {
                Original::Mesh(..) => format!("say `--unit {}` and `--up {}`", spec.unit, spec.up),
                Original::Series(_) => "leave them out of the scene".to_owned(),
            };
            return Err(Error::Parameter(format!(
                "[objects.{name}.sh] reads its file with unit = \"{}\" and up = \"{}\", the sweep \
                 with {unit} and {up}: {help}",
                spec.unit, spec.up
            )));
        }
    }
    Ok(())
}

fn replaced(spec: &ShSpec, stand: &Stand) -> ObjectSpec {
    match stand {
        Stand::Mesh => ObjectSpec::Mesh(MeshSpec {
            file: spec.file.clone(),
            at: spec.at,
            scale: spec.scale,
            rotate: spec.rotate,
            unit: spec.unit,
            up: spec.up,
            smooth: false,
            material: spec.material.clone(),
        }),
        Stand::Series(file, degree) => ObjectSpec::Sh(ShSpec {
            file: FileRef { written: file.path().to_owned(), resolved: file.path().to_owned() },
            degree: *degree,
            unit: Unit::Metre,
            up: UpAxis::Z,
            centre: None,
            detail: None,
            ..spec.clone()
        }),
    }
}

/// Takes a picture of so many walks a pixel, and another after `limit`, which is the same where
/// there is no limit: one run, looked at twice.
fn shoot(
    scene: &Scene,
    camera: &Camera,
    settings: &ImageSettings,
    walks: u64,
    limit: Option<Duration>,
) -> Result<Shots> {
    let go_on = |film: Film, stop: Stop| -> Result<Rendering> {
        let settings = ImageSettings { stop, ..*settings };
        resume(scene, camera, &settings, film, &|_| ControlFlow::Continue(()), None)
    };
    let by_walks = Stop { walks: Some(walks), ..Stop::default() };
    let film = Film::new(camera.window().size(), REPLICATES)?;
    let Some(limit) = limit else {
        let run = go_on(film, by_walks)?;
        let picture = Picture::from(&run.film);
        return Ok(Shots { at_equal_time: picture.clone(), picture, time: run.elapsed });
    };
    let first = go_on(film, Stop { time: Some(limit), ..by_walks })?;
    let early = Picture::from(&first.film);
    if first.walks_per_pixel < walks {
        let whole = go_on(first.film, by_walks)?;
        let time = first.elapsed + whole.elapsed;
        return Ok(Shots { picture: Picture::from(&whole.film), time, at_equal_time: early });
    }
    let left = limit.saturating_sub(first.elapsed);
    let later = go_on(first.film, Stop { time: Some(left), ..Stop::default() })?;
    let at_equal_time = Picture::from(&later.film);
    Ok(Shots { picture: early, time: first.elapsed, at_equal_time })
}
