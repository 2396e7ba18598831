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

use std::time::Instant;

use glam::DVec3;
use rayon::ThreadPool;

#[cfg(feature = "plots")]
pub use figures::sweep_figures;
pub use light::{Light, LightSettings};
pub use limit::SweepLimit;
pub use row::{Column, Rendition, SweepRow};

#[cfg(feature = "plots")]
pub(super) use storage::numbers_in_f32;

use self::decimation::Decimation;
use self::quantised::quantised;
use self::timing::{Timer, quartiles};
use super::{CompareSettings, Comparison, Subject, compare};
use crate::fit::{Fit, FitSettings, Shape, Source, enclosed, fit, series_bytes};
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
}

/// A sweep made ready: every line is measured by itself, in any order.
pub struct Sweep {
    original: Original,
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

impl Sweep {
    /// Makes a sweep ready; a mesh is fitted as `settings` say, whose degree does not count.
    ///
    /// # Errors
    /// As [`fit`] and [`MeshSurface::new`] of a mesh, [`ShSurface::new`] of a series.
    pub fn new(original: Original, settings: FitSettings) -> Result<Self> {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build();
        let pool = pool.map_err(|e| Error::Numeric(format!("no thread to time on: {e}")))?;
        let (centre, star, mean_radius) = match &original {
            Original::Mesh(mesh, _) => {
                let ball = fit(mesh, &FitSettings { lmax: 0, ..settings })?;
                (ball.centre, ball.folds.is_none(), ball.coefficients.mean())
            }
            Original::Series(shape) => (shape.centre, true, shape.coefficients.mean()),
        };
        let (surface, radius): (Box<dyn Surface>, f64) = match &original {
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
        &self.original
    }

    /// Measures the original itself.
    ///
    /// # Errors
    /// As [`Sweep::new`].
    pub fn measure_original(&self) -> Result<SweepRow> {
        let degree = match &self.original {
            Original::Mesh(..) => None,
            Original::Series(shape) => Some(shape.coefficients.lmax()),
        };
        let mut row = SweepRow::new(Rendition::Original, degree);
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
        match &self.original {
            Original::Mesh(mesh, _) => {
                storage::mesh(&mut row, mesh)?;
                let made = || MeshSurface::new(mesh.translated(-self.centre));
                let (surface, ms) = self.pool.install(|| timed(made))?;
                row[Column::BytesTraced] = surface.bytes() as f64;
                row[Column::Prepare] = ms;
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
        let (shape, rms) = match &self.original {
            Original::Mesh(mesh, source) => {
                let fitted = self.fit(mesh, degree, &mut row)?;
                let Fit { coefficients, centre, error, .. } = fitted;
                row[Column::RelativeRms] = error.rms / coefficients.mean();
                row[Column::RelativeMax] = error.max / coefficients.mean();
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
    pub fn rivals(&self) -> Result<Rivals<'_>> {
        let decimation = match &self.original {
            Original::Mesh(mesh, _) => Some(Decimation::new(mesh, self.centre, self.star)?),
            Original::Series(_) => None,
        };
        Ok(Rivals { sweep: self, decimation })
    }

    /// Fits the mesh, and times that.
    fn fit(&self, mesh: &Mesh, degree: usize, row: &mut SweepRow) -> Result<Fit> {
        let settings = FitSettings { lmax: degree, ..self.settings };
        let mut times = Vec::new();
        loop {
            let fitted = self.pool.install(|| fit(mesh, &settings))?;
            times.push(1e3 * fitted.projection_time.as_secs_f64());
            if times.len() >= REPEATS || times.iter().sum::<f64>() > 1e3 * PATIENCE {
                row[Column::Fit] = quartiles(times)[1];
                return Ok(fitted);
            }
        }
    }

    /// Makes a series ready for rays, and times that.
    fn prepare(&self, shape: &Shape, row: &mut SweepRow) -> Result<ShSurface> {
        let made = || ShSurface::new(&shape.coefficients, Intersector::default());
        let (surface, ms) = self.pool.install(|| timed(made))?;
        row[Column::BytesTraced] = surface.patch_bytes() as f64;
        row[Column::Prepare] = ms;
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
    sweep: &'a Sweep,
    decimation: Option<Decimation>,
}

impl Rivals<'_> {
    /// Decimates the mesh to the bytes of the series of a degree, both in f32, and measures what is
    /// left; `None` of a series, where no mesh is as small, and where the mesh itself takes no
    /// more. The degrees of calls descend.
    ///
    /// # Errors
    /// As [`compare`](super::compare()).
    pub fn measure(&mut self, degree: usize) -> Result<Option<SweepRow>> {
        let sweep = self.sweep;
        let target = storage::vertices_for(series_bytes(degree));
        let Some(decimation) = self.decimation.as_mut().filter(|_| target >= 4) else {
            return Ok(None);
        };
        let mesh = decimation.down_to(target)?;
        if mesh.positions().len() > target {
            return Ok(None);
        }
        let mut row = SweepRow::new(Rendition::Decimated, Some(degree));
        storage::mesh(&mut row, &mesh)?;
        let made = || MeshSurface::new(mesh.translated(-sweep.centre));
        let (surface, ms) = sweep.pool.install(|| timed(made))?;
        (row[Column::BytesTraced], row[Column::Prepare]) = (surface.bytes() as f64, ms);
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
///
/// # Errors
/// As [`Sweep::rivals`].
pub fn thinned(mesh: &Mesh, faces: usize) -> Result<Mesh> {
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
        "degree {degree} is above {highest}, that of the file: ask for none above it"
    )))
}

/// Makes something until its time is known, milliseconds: the median.
fn timed<T>(make: impl Fn() -> Result<T>) -> Result<(T, f64)> {
    let mut times = Vec::new();
    loop {
        let started = Instant::now();
        let made = make()?;
        times.push(1e3 * started.elapsed().as_secs_f64());
        if times.len() >= REPEATS || times.iter().sum::<f64>() > 1e3 * PATIENCE {
            return Ok((made, quartiles(times)[1]));
        }
    }
}
