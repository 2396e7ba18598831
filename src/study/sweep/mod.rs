//! What a truncation degree costs and buys, beside the original: errors of shape, bytes as files
//! and as traced, times, and the mesh decimated to as many bytes.

mod decimation;
#[cfg(feature = "plots")]
mod figures;
mod light;
mod limit;
mod quantised;
mod row;
mod storage;
mod timing;

use std::time::{Duration, Instant};

use glam::DVec3;
use rayon::ThreadPool;

#[cfg(feature = "plots")]
pub use figures::{SWEEP_FIGURES, sweep_figures};
pub use light::{Light, LightSettings};
pub use limit::SweepLimit;
pub use row::{Column, Rendition, SweepRow};

#[cfg(feature = "plots")]
pub(super) use storage::numbers_in_f32;

use self::decimation::Decimation;
use self::quantised::quantised;
use self::timing::Timer;
use super::{CompareSettings, Comparison, Subject, compare};
use crate::fit::{Centre, Fit, FitSettings, Shape, Source, enclosed, fit, series_bytes};
use crate::math::stats::quartiles;
use crate::mesh::Mesh;
use crate::sh::Solid;
use crate::surface::{Intersector, MeshSurface, ShSurface, Surface};
use crate::{Error, Result};

/// Holds what is swept.
#[derive(Debug, Clone)]
pub enum Original {
    /// A mesh, metres, and the file it comes from: every degree is a fit.
    Mesh(Mesh, Option<Source>),
    /// A series: every degree is cut from it.
    Series(Shape),
}

impl Original {
    /// Returns it as one of two shapes that are compared.
    pub const fn subject(&self) -> Subject<'_> {
        match self {
            Self::Mesh(mesh, _) => Subject::Mesh(mesh),
            Self::Series(shape) => Subject::Series(shape),
        }
    }

    /// Returns those of some degrees in whose bytes, f32, there is a decimated mesh: it needs four
    /// vertices, and fewer than the whole. A series has none.
    pub fn rivalled(&self, degrees: &[usize]) -> Vec<usize> {
        let Self::Mesh(mesh, _) = self else { return Vec::new() };
        let [vertices, _] = mesh.used_size();
        let fits = |l: &usize| (4..vertices).contains(&storage::vertices_for(series_bytes(*l)));
        degrees.iter().copied().filter(fits).collect()
    }
}

/// A sweep made ready: every line is measured by itself, in any order.
pub struct Sweep<'a> {
    original: &'a Original,
    /// How a mesh is fitted; its degree does not count.
    settings: FitSettings,
    /// The expansion centre of all degrees.
    centre: DVec3,
    /// Whether the mesh is star-shaped about it.
    star: bool,
    mean_radius: f64,
    /// The original about the centre.
    surface: Box<dyn Surface>,
    timer: Timer,
    /// The principal moments of inertia; none of an open mesh.
    moments: Option<[f64; 3]>,
    /// One thread.
    pool: ThreadPool,
}

/// How often what is not a ray is timed, as long as that takes less than [`PATIENCE`] seconds.
const REPEATS: usize = 3;
const PATIENCE: f64 = 0.3;

impl<'a> Sweep<'a> {
    /// Makes a sweep ready; a mesh is fitted as `settings` say, whose degree does not count.
    ///
    /// # Errors
    /// As [`fit`] and [`MeshSurface::new`] of a mesh, [`ShSurface::new`] of a series.
    pub fn new(original: &'a Original, mut settings: FitSettings) -> Result<Self> {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build();
        let pool = pool.map_err(|e| Error::Numeric(format!("no thread to time on: {e}")))?;
        let (centre, star, mean_radius) = match original {
            Original::Mesh(mesh, _) => {
                let ball = fit(mesh, &FitSettings { lmax: 0, ..settings })?;
                settings.centre = Some(Centre::At(ball.centre));
                (ball.centre, ball.folds.is_none(), ball.coefficients.mean())
            }
            Original::Series(shape) => (shape.centre, true, shape.coefficients.mean()),
        };
        let (surface, radius): (Box<dyn Surface>, f64) = match original {
            Original::Mesh(mesh, _) => {
                let moved = mesh.translated(-centre);
                let radius = moved.used_positions().iter().map(|p| p.length()).fold(0.0, f64::max);
                (Box::new(MeshSurface::new(moved)?), radius)
            }
            Original::Series(shape) => {
                let surface = ShSurface::new(&shape.coefficients, Intersector::default())?;
                let radius = surface.body().bounds().max;
                (Box::new(surface), radius)
            }
        };
        let moments = moments(&original.subject());
        let timer = Timer::new(radius);
        Ok(Self { original, settings, centre, star, mean_radius, surface, timer, moments, pool })
    }

    /// Returns what is swept.
    pub const fn original(&self) -> &Original {
        self.original
    }

    /// Measures the original itself.
    ///
    /// # Errors
    /// As [`Sweep::new`].
    pub fn measure_original(&self) -> Result<SweepRow> {
        let mut row = SweepRow::new(Rendition::Original, None);
        for column in [
            Column::RelativeRms,
            Column::RelativeMax,
            Column::HausdorffLower,
            Column::HausdorffUpper,
            Column::NormalMean,
            Column::Normal95,
            Column::VolumeError,
            Column::AreaError,
            Column::InertiaError,
        ] {
            row[column] = 0.0;
        }
        match self.original {
            Original::Mesh(mesh, _) => {
                storage::mesh(&mut row, mesh)?;
                self.prepare_mesh(mesh, &mut row)?;
            }
            Original::Series(shape) => {
                storage::series(&mut row, shape, 0.0)?;
                self.prepare(shape, &mut row)?;
            }
        }
        self.timer.measure(&*self.surface, &*self.surface, &mut row);
        Ok(row)
    }

    /// Fits or cuts the series of a degree and measures it.
    ///
    /// # Errors
    /// As [`fit`]; [`Error::Geometry`] when its radius is not positive everywhere;
    /// [`Error::Parameter`] for a degree above that of the original series.
    pub fn measure_degree(&self, degree: usize) -> Result<(Shape, SweepRow)> {
        let mut row = SweepRow::new(Rendition::Series, Some(degree));
        let (shape, rms) = match self.original {
            Original::Mesh(mesh, source) => {
                let fitted = self.fit(mesh, degree, &mut row)?;
                row[Column::RelativeRms] = fitted.relative_rms();
                row[Column::RelativeMax] = fitted.relative_max();
                let Fit { coefficients, centre, error, .. } = fitted;
                let source = source.clone();
                let shape = Shape { centre, source, ..Shape::new(coefficients) };
                (shape, Some(error.rms))
            }
            Original::Series(shape) => (cut(shape, degree)?, None),
        };
        let surface = self.prepare(&shape, &mut row)?;
        self.timer.measure(&surface, &*self.surface, &mut row);
        let found = self.compare(Subject::Series(&shape), &mut row)?;
        let rms = rms.or_else(|| found.radial.as_ref().ok().map(|r| r.rms)).unwrap_or_default();
        storage::series(&mut row, &shape, rms)?;
        Ok((shape, row))
    }

    /// Starts to decimate the mesh to the bytes of series.
    ///
    /// # Errors
    /// [`Error::Memory`] for more than is free.
    pub fn rivals(&'a self) -> Result<Rivals<'a>> {
        let decimation = match self.original {
            Original::Mesh(mesh, _) => Some(Decimation::new(mesh, self.centre, self.star)?),
            Original::Series(_) => None,
        };
        Ok(Rivals { sweep: self, decimation })
    }

    /// Fits the mesh, and times that.
    fn fit(&self, mesh: &Mesh, degree: usize, row: &mut SweepRow) -> Result<Fit> {
        let settings = FitSettings { lmax: degree, ..self.settings };
        let made = || fit(mesh, &settings).map(|fitted| (fitted.projection_time, fitted));
        let (fitted, ms) = self.pool.install(|| repeated(made))?;
        row[Column::Fit] = ms;
        Ok(fitted)
    }

    /// Makes a series ready for rays, and times that.
    fn prepare(&self, shape: &Shape, row: &mut SweepRow) -> Result<ShSurface> {
        let made = || ShSurface::new(&shape.coefficients, Intersector::default());
        let (surface, ms) = self.pool.install(|| timed(made))?;
        row[Column::BytesTraced] = surface.patch_bytes() as f64;
        row[Column::Prepare] = ms;
        Ok(surface)
    }

    /// Makes a mesh ready for rays, about the centre, and times that.
    fn prepare_mesh(&self, mesh: &Mesh, row: &mut SweepRow) -> Result<MeshSurface> {
        let made = || MeshSurface::new(mesh.translated(-self.centre));
        let (surface, ms) = self.pool.install(|| timed(made))?;
        (row[Column::BytesTraced], row[Column::Prepare]) = (surface.bytes() as f64, ms);
        Ok(surface)
    }

    /// Compares a shape with the original, as `diff` does.
    fn compare(&self, shape: Subject, row: &mut SweepRow) -> Result<Comparison> {
        let settings = CompareSettings { width: None, centre: self.centre };
        let found = compare(shape, self.original.subject(), &settings)?;
        row[Column::HausdorffLower] = found.hausdorff.lower;
        row[Column::HausdorffUpper] = found.hausdorff.upper;
        row[Column::NormalMean] = found.normals.mean.to_degrees();
        row[Column::Normal95] = found.normals.percentile_95.to_degrees();
        if let (Some(own), Some(original)) = (moments(&shape), self.moments) {
            let pairs = own.into_iter().zip(original);
            let changes = pairs.map(|(a, b)| (a / b - 1.0).abs());
            row[Column::InertiaError] = changes.fold(0.0, f64::max);
        }
        row[Column::AreaError] = found.areas[0] / found.areas[1] - 1.0;
        if let [Some(own), Some(original)] = found.volumes {
            row[Column::VolumeError] = own / original - 1.0;
        }
        if row[Column::RelativeRms].is_nan()
            && let Ok(radial) = &found.radial
        {
            row[Column::RelativeRms] = radial.rms / self.mean_radius;
            row[Column::RelativeMax] = radial.max / self.mean_radius;
        }
        Ok(found)
    }
}

/// A mesh that is decimated to the bytes of series, from the highest degree down.
pub struct Rivals<'a> {
    sweep: &'a Sweep<'a>,
    decimation: Option<Decimation>,
}

impl Rivals<'_> {
    /// Decimates the mesh to the bytes of the series of a degree, one of [`Original::rivalled`], and
    /// measures what is left; `None` where not so many edges can be collapsed. The degrees of calls
    /// descend.
    ///
    /// # Errors
    /// As [`compare`](super::compare()).
    pub fn measure(&mut self, degree: usize) -> Result<Option<SweepRow>> {
        let sweep = self.sweep;
        let target = storage::vertices_for(series_bytes(degree));
        let Some(decimation) = &mut self.decimation else { return Ok(None) };
        let mesh = decimation.down_to(target)?;
        if mesh.positions().len() > target {
            return Ok(None);
        }
        let mut row = SweepRow::new(Rendition::Decimated, Some(degree));
        storage::mesh(&mut row, &mesh)?;
        let surface = sweep.prepare_mesh(&mesh, &mut row)?;
        sweep.timer.measure(&surface, &*sweep.surface, &mut row);
        sweep.compare(Subject::Mesh(&mesh), &mut row)?;
        let rms = row[Column::RelativeRms] * sweep.mean_radius;
        if rms > 0.0 {
            // Rounding to a step is off by a twelfth of its square in the mean.
            let step = storage::PART * rms * 12.0_f64.sqrt();
            row[Column::BytesCompact] = quantised(&mesh, step)?.len() as f64;
        }
        Ok(Some(row))
    }
}

/// Decimates a mesh to about so many faces, for what shows it; one that has no more stays.
#[cfg(feature = "plots")]
pub(super) fn thinned(mesh: &Mesh, faces: usize) -> Result<Mesh> {
    if mesh.triangles().len() <= faces {
        return Ok(mesh.clone());
    }
    Decimation::new(mesh, mesh.bounds().centre(), false)?.down_to(faces / 2 + 2)
}

/// Returns the principal moments of inertia of a closed shape, of unit density.
fn moments(shape: &Subject) -> Option<[f64; 3]> {
    let solid = match shape {
        Subject::Series(shape) => Solid::of(&shape.coefficients).ok()?,
        Subject::Mesh(mesh) => enclosed(mesh, mesh.bounds().centre()),
    };
    (solid.volume > 0.0).then(|| solid.principal_axes().moments)
}

fn cut(shape: &Shape, degree: usize) -> Result<Shape> {
    let highest = shape.coefficients.lmax();
    if degree <= highest {
        return Ok(shape.truncated(degree));
    }
    Err(Error::Parameter(format!(
        "there is no degree above {highest} in the file, as {degree} is: ask for none"
    )))
}

/// Makes something until its time is known, milliseconds: the median.
fn timed<T>(make: impl Fn() -> Result<T>) -> Result<(T, f64)> {
    repeated(|| {
        let started = Instant::now();
        make().map(|made| (started.elapsed(), made))
    })
}

/// The same where what is made tells its time.
fn repeated<T>(make: impl Fn() -> Result<(Duration, T)>) -> Result<(T, f64)> {
    let mut times = Vec::new();
    loop {
        let (time, made) = make()?;
        times.push(1e3 * time.as_secs_f64());
        if times.len() >= REPEATS || times.iter().sum::<f64>() > 1e3 * PATIENCE {
            return Ok((made, quartiles(times)[1]));
        }
    }
}
