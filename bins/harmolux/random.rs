//! `harmolux random`: random shapes.

use std::path::{Path, PathBuf};

use clap::Args;
use harmolux::fit::Shape;
use harmolux::io::coefficients;
use harmolux::io::input::Input;
use harmolux::io::spectra;
use harmolux::sh::{
    Coefficients, GaussianSphere, RandomShape, Spectrum, gaussian, least, power_law, range,
};
use harmolux::{Error, Result};
use serde_json::json;

use crate::common::exit::Code;
use crate::common::shape_file;
use crate::common::values::{Settings, settings};
use crate::common::{folders, paths, say};

/// Draw random shapes
///
/// Gaussian random spheres, or Gaussian radii of a given spectrum. The same seed gives the same
/// shape. With --count the seeds are SEED, SEED+1, ..., and the files DIR/SEED.txt.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  harmolux random --gaussian-sphere sigma=0.2,nu=3.3 -l 32 --seed 1 -o rock.txt
  harmolux random --gaussian-sphere sigma=0.2,nu=3.3 -l 32 --count 100 -o rocks
  harmolux random --power-law rms=0.05,exponent=3 -l 24 --radius 0.01 -o grain.txt
  harmolux random --spectrum head.txt --seed 7 -o stranger.txt

Settings of --gaussian-sphere (Muinonen 1996):
  sigma        standard deviation of the radius over its mean
  nu           exponent of the covariance of the log-radius, c_l ~ l^-nu
  first, last  degrees of the log-radius [default: 2 and LMAX]
Settings of --power-law:
  rms          standard deviation of the radius over its mean
  exponent     of the power per degree, P_l ~ l^-exponent
  first        lowest degree [default: 2]")]
pub(crate) struct Random {
    #[command(flatten)]
    pub(crate) statistics: Statistics,
    /// The degree of the shapes [default: that of the spectrum, else 32]
    #[arg(
        short = 'l', long = "degree", value_name = "LMAX",
        value_parser = clap::value_parser!(u32).range(0..=1400)
    )]
    pub(crate) degree: Option<u32>,
    /// The mean radius, metres [default: that of the spectrum, else 1]
    #[arg(long, value_name = "METRES")]
    pub(crate) radius: Option<f64>,
    /// The seed of the first shape
    #[arg(long, default_value_t = 1)]
    pub(crate) seed: u64,
    /// How many shapes, written into a folder
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=100_000))]
    pub(crate) count: Option<u32>,
    /// Where to write the shape; with --count the folder, made when it is not there
    #[arg(short, long, value_name = "FILE.txt|DIR")]
    pub(crate) output: PathBuf,
    /// Replace files that are there already
    #[arg(long)]
    pub(crate) force: bool,
}

/// What is random about the shapes
#[derive(Debug, Args)]
#[group(required = true, multiple = false)]
pub(crate) struct Statistics {
    /// A log-normal radius, as of rocks and dust
    #[arg(long, value_name = "SETTINGS", value_parser = settings)]
    gaussian_sphere: Option<Settings>,
    /// A Gaussian radius whose power per degree falls as a power of the degree
    #[arg(long, value_name = "SETTINGS", value_parser = settings)]
    power_law: Option<Settings>,
    /// A Gaussian radius of the spectrum of this shape, or of a CSV table of degree and power
    #[arg(long, value_name = "SHAPE.txt|FILE.csv")]
    spectrum: Option<PathBuf>,
}

/// Draws the shape of a seed.
type Draw = Box<dyn Fn(u64) -> Result<RandomShape>>;

/// Runs the verb; a folder made for it does not stay behind empty when it fails.
pub(crate) fn run(verb: &Random, as_json: bool) -> Result<Code> {
    let draw = verb.draw()?;
    let Some(count) = verb.count else {
        let files = [(verb.seed, verb.output.clone())];
        return finish(verb, &files, draw.as_ref(), as_json);
    };
    let folder = &verb.output;
    let file = |i: u32| {
        let seed = verb.seed.wrapping_add(u64::from(i));
        (seed, folder.join(format!("{seed}.txt")))
    };
    let files: Vec<(u64, PathBuf)> = (0..count).map(file).collect();
    folders::within(folder, || finish(verb, &files, draw.as_ref(), as_json))
}

impl Random {
    fn draw(&self) -> Result<Draw> {
        let degree = self.degree.map(|l| l as usize);
        let radius = self.radius.unwrap_or(1.0);
        if let Some(settings) = &self.statistics.gaussian_sphere {
            let lmax = degree.unwrap_or(32);
            let [sigma, nu, first, last] = settings.values([
                ("sigma", None),
                ("nu", None),
                ("first", Some(2.0)),
                ("last", Some(lmax as f64)),
            ])?;
            let (first, last) = (whole("first", first)?, whole("last", last)?);
            let sphere = GaussianSphere { mean_radius: radius, sigma, nu, first, last };
            return Ok(Box::new(move |seed| sphere.draw(lmax, seed)));
        }
        if let Some(settings) = &self.statistics.power_law {
            let [rms, exponent, first] =
                settings.values([("rms", None), ("exponent", None), ("first", Some(2.0))])?;
            let last = degree.unwrap_or(32);
            let powers = power_law((rms * radius).powi(2), exponent, whole("first", first)?, last)?;
            return gaussian_radius(radius, powers);
        }
        let path = self.statistics.spectrum.as_deref().unwrap_or(Path::new(""));
        let mut powers = read_spectrum(path)?;
        let mean = powers.first().map_or(0.0, |p| p.sqrt());
        if let Some(degree) = degree {
            powers.resize(degree + 1, 0.0);
        }
        let mean = if mean > 0.0 { mean } else { 1.0 };
        gaussian_radius(self.radius.unwrap_or(mean), powers)
    }
}

fn whole(name: &str, value: f64) -> Result<usize> {
    if value.fract() == 0.0 && (0.0..=1400.0).contains(&value) {
        return Ok(value as usize);
    }
    Err(Error::Parameter(format!("{name} must be a degree from 0 to 1400, found {value}")))
}

/// Reads a spectrum: of a coefficient file, or a table.
fn read_spectrum(path: &Path) -> Result<Vec<f64>> {
    let mut input = Input::open(path)?;
    let is_table = input.name().extension().is_some_and(|e| e.eq_ignore_ascii_case("csv"));
    if is_table || spectra::recognise(input.ahead()?) {
        return spectra::parse(path, &input.rest()?);
    }
    let shape = coefficients::read_as_stated(input)?.0;
    Ok(Spectrum::of(&shape.coefficients).degrees().iter().map(|d| d.power).collect())
}

/// Draws Gaussian coefficients about a fixed mean radius.
fn gaussian_radius(radius: f64, mut powers: Vec<f64>) -> Result<Draw> {
    if !(radius.is_finite() && radius > 0.0) {
        return Err(Error::Parameter(format!(
            "the mean radius must be positive and finite, found {radius}"
        )));
    }
    if let Some(zero) = powers.first_mut() {
        *zero = 0.0;
    }
    Ok(Box::new(move |seed| {
        let mut coefficients = gaussian(&powers, seed)?;
        coefficients.set(0, 0, radius, 0.0);
        Ok(RandomShape { coefficients, rms: 0.0, max: 0.0 })
    }))
}

/// Holds what is said of one shape.
struct Row {
    seed: u64,
    mean_radius: f64,
    deviation: f64,
    /// Certain bounds of the radius, m.
    bounds: (f64, f64),
    rms: f64,
}

impl Row {
    fn of(seed: u64, drawn: &RandomShape) -> Result<Self> {
        let c = &drawn.coefficients;
        let bounds = positive(seed, c)?;
        let deviation = Spectrum::of(c).deviation();
        Ok(Self { seed, mean_radius: c.mean(), deviation, bounds, rms: drawn.rms })
    }
}

/// Bounds the radius; refuses one that is not certainly positive: skipping the seed would bend the
/// law.
fn positive(seed: u64, c: &Coefficients) -> Result<(f64, f64)> {
    let (min, max) = range(c)?;
    if min > 0.0 {
        return Ok((min, max));
    }
    let least = least(c)?.value;
    let how = if least > 0.0 { "not certainly" } else { "not" };
    Err(Error::Geometry(format!(
        "the radius of seed {seed} is {how} positive in every direction (the least found is \
         {least:.3e} m): lower its deviation, raise the exponent, or, for a Gaussian random \
         sphere, raise the degree"
    )))
}

/// Draws and writes one shape after the other, once all can be written; when one fails, those
/// before it stand.
fn finish(
    verb: &Random,
    files: &[(u64, PathBuf)],
    draw: &dyn Fn(u64) -> Result<RandomShape>,
    as_json: bool,
) -> Result<Code> {
    let mut rows = Vec::with_capacity(files.len());
    files.iter().try_for_each(|(_, path)| shape_file::open(path, verb.force).map(drop))?;
    for (seed, path) in files {
        let output = shape_file::open(path, verb.force)?;
        let drawn = draw(*seed)?;
        rows.push(Row::of(*seed, &drawn)?);
        output.write(&Shape::new(drawn.coefficients))?;
    }
    if as_json {
        let list = rows.iter().map(|r| {
            json!({
                "seed": r.seed,
                "mean_radius": r.mean_radius,
                "deviation": r.deviation,
                "radius_bounds": [r.bounds.0, r.bounds.1],
                "truncation_rms": r.rms,
            })
        });
        let mut value = json!({ "shapes": list.collect::<Vec<_>>() });
        paths::put(&mut value, "written", &verb.output);
        say::json(&value);
    } else {
        report(&rows);
        say::note(&format!("written to {}", verb.output.display()));
    }
    Ok(Code::Done)
}

fn report(rows: &[Row]) {
    let mut table = say::table(&[
        "seed",
        "mean radius, m",
        "deviation",
        "radius from",
        "to, m",
        "truncation RMS",
    ]);
    for r in rows {
        table.add_row([
            r.seed.to_string(),
            say::significant(r.mean_radius, 5),
            say::percent(r.deviation / r.mean_radius),
            say::significant(r.bounds.0, 4),
            say::significant(r.bounds.1, 4),
            say::percent(r.rms / r.mean_radius),
        ]);
    }
    say::data(&table.to_string());
}
