//! `harmolux compare`: how far two pictures are from each other, and whether noise explains it.

use std::path::{Path, PathBuf};

use clap::Args;
use harmolux::error::{InputError, shown_path};
use harmolux::io::images::{Attribute, Exr};
use harmolux::io::output::Output;
use harmolux::plots::{FalseColour, Palette, ScaleOptions};
use harmolux::study::{
    FALSE_ALARMS, FEWEST_REPLICATES, JointLevel, JointTest, PIXELS_PER_DEGREE, Picture,
    PictureComparison, PictureMap, compare_pictures,
};
use harmolux::{Error, Result};
use serde_json::{Value, json};

use crate::common::exit::Code;
use crate::common::flags::choices;
use crate::common::plot::{PlotFormat, unknown_output};
use crate::common::progress::Meter;
use crate::common::target::write_all;
use crate::common::values::{Settings, settings};
use crate::common::{paths, say};

/// The share of the pixels that the scale of a difference reaches.
const COVER: f64 = 0.995;

/// Tell how far two pictures differ, and whether noise explains it
///
/// B is the reference. relMSE is the mean of (a - b)^2 / (b^2 + 1e-4 m^2) over the luminances of
/// all pixels, m being the mean of b; what the standard errors of both make of it is printed beside
/// it. FLIP says how different the pictures look when one flips between them, from 0 to 1
/// (HDR-FLIP, Andersson et al. 2021).
///
/// Pictures with standard errors (stderr.Y, as `render` writes it) are judged by them: the
/// difference of every pixel, of blocks of pixels and of the whole, in standard errors, against a
/// limit that equal pictures exceed once in 1000 comparisons at most. Exit code 4 when they differ,
/// or miss --tolerance.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  harmolux compare new.exr old.exr                              the same but for noise?
  harmolux compare new.exr old.exr -o difference.png            where they differ, in cd/m2
  harmolux compare new.exr old.exr -o flip.png --map flip       where one sees it
  harmolux compare ours.exr mitsuba.exr --tolerance relmse=1e-3,flip=0.05")]
pub(crate) struct Compare {
    /// The picture (.exr)
    pub(crate) a: PathBuf,
    /// The reference (.exr), of the same size
    pub(crate) b: PathBuf,
    /// Write a picture of the difference (.png or .svg); may be repeated
    #[arg(short, long, value_name = "FILE")]
    pub(crate) output: Vec<PathBuf>,
    /// What that picture shows [default: difference]
    #[arg(long, requires = "output", value_parser = choices::<PictureMap>())]
    pub(crate) map: Option<PictureMap>,
    /// Exit with code 4 when relmse, or the mean of flip, is larger: relmse=1e-3,flip=0.05
    #[arg(long, value_name = "NAME=NUMBER", value_parser = settings)]
    pub(crate) tolerance: Option<Settings>,
    /// The pixels in a degree of the eye, for FLIP [default: 67.02, a screen of 3840 pixels seen
    /// from as far as it is wide]
    #[arg(long, value_name = "N", allow_negative_numbers = true)]
    pub(crate) pixels_per_degree: Option<f64>,
    /// Replace output files that are there already
    #[arg(long)]
    pub(crate) force: bool,
}

/// Runs the verb.
pub(crate) fn run(verb: &Compare, as_json: bool) -> Result<Code> {
    let open = |path: &PathBuf| {
        let format =
            PlotFormat::of_extension(path).ok_or_else(|| unknown_output(path, ".png or .svg"))?;
        Ok((format, Output::open(path, &format.kind(), verb.force)?))
    };
    let limits = Limits::of(verb)?;
    let targets = verb.output.iter().map(open).collect::<Result<Vec<_>>>()?;
    let meter = Meter::start("reading the pictures");
    let (a, b) = (Side::open(&verb.a)?, Side::open(&verb.b)?);
    meter.stage("comparing the pictures");
    let eye = verb.pixels_per_degree.unwrap_or(PIXELS_PER_DEGREE);
    let found = compare_pictures(&a.picture, &b.picture, eye).map_err(|e| about_both(verb, e))?;
    let written = if targets.is_empty() {
        Ok(())
    } else {
        let map = map(verb, &found, [&a, &b])?;
        write_all(targets.into_iter().map(|(format, output)| match format {
            PlotFormat::Png => output.write(&map.to_png()?),
            PlotFormat::Svg => output.write(map.to_svg()?.as_bytes()),
        }))
    };
    drop(meter);
    let result = Judged { untested: untested(verb, &found, [&a, &b]), found, limits };
    if as_json {
        say::json(&result.json(verb, eye));
    } else {
        result.report(verb, &a.unit);
    }
    written?;
    if a.seed.is_some() && a.seed == b.seed && result.found.unequal > 0 {
        say::note("both have the same seed: their errors may be alike, and the test sees less");
    }
    Ok(result.code())
}

/// A picture, and what its file says besides.
struct Side {
    picture: Picture,
    unit: String,
    seed: Option<String>,
}

impl Side {
    fn open(path: &Path) -> Result<Self> {
        let exr = Exr::read(path).map_err(|error| match error {
            Error::Input(e) if e.help.is_none() => {
                let help = "give EXR pictures, as `harmolux render -o view.exr` writes them: one \
                            layer with the channels R, G and B";
                InputError::new(path, e.message).help(help).into()
            }
            other => other,
        })?;
        let text = |name: &str| match exr.attribute(name) {
            Some(Attribute::Text(text)) => Some(text.clone()),
            _ => None,
        };
        let unit = say::unit(&text("unit").unwrap_or_default());
        Ok(Self { picture: Picture::from_exr(path, &exr)?, unit, seed: text("seed") })
    }
}

/// What may not be exceeded; infinite where nothing was asked for.
struct Limits {
    given: bool,
    relative_mse: f64,
    flip: f64,
}

impl Limits {
    fn of(verb: &Compare) -> Result<Self> {
        let open = Some(f64::INFINITY);
        let given = verb.tolerance.is_some();
        let known = [("relmse", open), ("flip", open)];
        let [relative_mse, flip] = match &verb.tolerance {
            Some(settings) => settings.values(known)?,
            None => [f64::INFINITY; 2],
        };
        if relative_mse < 0.0 || flip < 0.0 {
            return Err(Error::Parameter("a tolerance cannot be below 0".to_owned()));
        }
        Ok(Self { given, relative_mse, flip })
    }
}

/// Says why there is no joint test, where there is none.
fn untested(verb: &Compare, found: &PictureComparison, both: [&Side; 2]) -> Option<String> {
    if found.joint.is_some() {
        return None;
    }
    let without = [&verb.a, &verb.b].into_iter().zip(both);
    let without = without.filter(|(_, read)| read.picture.errors.is_empty());
    let names: Vec<String> = without.map(|(path, _)| shown_path(path)).collect();
    let replicates = both.iter().filter_map(|side| side.picture.replicates).min();
    Some(match (names.as_slice(), replicates) {
        ([], Some(n)) if n < FEWEST_REPLICATES => {
            let few = format!("errors from {n} replicates allow any difference");
            format!("{few}: render with more walks, {FEWEST_REPLICATES} replicates at least")
        }
        ([], _) => "no pixel has a known standard error in both".to_owned(),
        (names, _) => format!("no standard errors (channel stderr.Y) in {}", names.join(" and ")),
    })
}

fn about_both(verb: &Compare, error: Error) -> Error {
    let names = format!("{} and {}", verb.a.display(), verb.b.display());
    error.map(|error| match error {
        Error::Parameter(text) => Error::Parameter(format!("{names}: {text}")),
        other => other,
    })
}

/// Makes the picture of the difference: with a sign about white, FLIP as its authors show it.
fn map(verb: &Compare, found: &PictureComparison, [a, b]: [&Side; 2]) -> Result<FalseColour> {
    let map = verb.map.unwrap_or_default();
    if let (PictureMap::Z, Some(why)) = (map, untested(verb, found, [a, b])) {
        return Err(Error::Parameter(format!(
            "a map of z needs standard errors: {why}; `--map difference` needs none"
        )));
    }
    let values = found.map(map, &a.picture, &b.picture);
    let open = ScaleOptions::default();
    let wish = if map == PictureMap::Flip {
        ScaleOptions { low: Some(0.0), high: Some(1.0), palette: Palette::Magma, ..open }
    } else {
        let sizes: Vec<f64> = values.iter().map(|value| value.abs()).collect();
        let [_, end] = open.fitted(&sizes, COVER)?.range();
        ScaleOptions { low: Some(-end), high: Some(end), palette: Palette::Balance, ..open }
    };
    let unit = match map {
        PictureMap::Difference => a.unit.clone(),
        PictureMap::Flip => "FLIP".to_owned(),
        PictureMap::Z => "std. errors".to_owned(),
    };
    let scale = wish.fitted(&values, 1.0)?;
    let [width, height] = found.size;
    let (lines, extremes, endless) = (false, false, false);
    Ok(FalseColour { width, height, values, scale, unit, lines, extremes, endless })
}

/// What was found, and what was asked of it.
struct Judged {
    found: PictureComparison,
    limits: Limits,
    /// Why there is no joint test.
    untested: Option<String>,
}

impl Judged {
    fn differ(&self) -> Option<bool> {
        self.found.joint.as_ref().map(JointTest::differ)
    }

    /// Lists what was asked for, as it is named: what is, and what it may be.
    fn tolerances(&self) -> [(&'static str, f64, f64); 2] {
        let (found, limits) = (&self.found, &self.limits);
        [
            ("relMSE", found.relative_mse.luminance, limits.relative_mse),
            ("the mean of FLIP", found.flip.mean, limits.flip),
        ]
    }

    fn within_tolerance(&self) -> Option<bool> {
        let within = self.tolerances().iter().all(|(_, is, most)| is <= most);
        self.limits.given.then_some(within)
    }

    fn code(&self) -> Code {
        for (name, is, most) in self.tolerances().iter().filter(|(_, is, most)| is > most) {
            let [is, most] = [is, most].map(|x| say::significant(*x, 4));
            say::warning(&format!("{name}, {is}, is above the tolerance of {most}"));
        }
        let missed = self.within_tolerance() == Some(false);
        if self.differ() == Some(true) || missed { Code::NotMet } else { Code::Done }
    }

    fn flip_max_at(&self) -> [usize; 2] {
        let flip = &self.found.flip;
        let i = flip.map.iter().position(|error| *error == flip.max).unwrap_or(0);
        [i % self.found.size[0], i / self.found.size[0]]
    }

    fn report(&self, verb: &Compare, unit: &str) {
        let found = &self.found;
        let four = |x: f64| say::significant(x, 4);
        let [mean_a, mean_b] = found.means.map(four);
        let share = |n: usize| say::percent(n as f64 / found.flip.map.len() as f64);
        let mse = &found.relative_mse;
        let noise = match (mse.noise, mse.beyond_noise()) {
            (Some(noise), Some(beyond)) => {
                format!(", {} of it noise, {} beyond", four(noise), four(beyond))
            }
            _ => String::new(),
        };
        let flip = &found.flip;
        let [mean, most, max] = [flip.mean, flip.percentile_95, flip.max].map(four);
        let mut lines = vec![
            ("pictures".to_owned(), format!("{} x {}", found.size[0], found.size[1])),
            ("means".to_owned(), format!("{mean_a} and {mean_b} {unit}").trim_end().to_owned()),
            ("relMSE".to_owned(), format!("{}{noise}", four(mse.luminance))),
            ("relMSE of R, G, B".to_owned(), four(mse.colours)),
            (
                "FLIP".to_owned(),
                format!("mean {mean}, 95 % below {most}, largest {max} at {}", self.at()),
            ),
            ("not equal".to_owned(), format!("{} pixels, {}", found.unequal, share(found.unequal))),
        ];
        lines.extend(found.joint.iter().flat_map(tested));
        lines.push(("verdict".to_owned(), self.verdict()));
        let written = verb.output.iter().map(|p| ("written".to_owned(), p.display().to_string()));
        lines.extend(written);
        let lines: Vec<_> = lines.iter().map(|(n, value)| (n.as_str(), value.clone())).collect();
        say::pairs(&lines);
    }

    fn at(&self) -> String {
        place(self.flip_max_at())
    }

    fn verdict(&self) -> String {
        match (self.differ(), &self.untested) {
            (Some(true), _) => "they differ by more than their errors".to_owned(),
            (Some(false), _) => "no difference beyond their errors".to_owned(),
            (None, why) => format!("not judged: {}", why.as_deref().unwrap_or_default()),
        }
    }

    fn json(&self, verb: &Compare, pixels_per_degree: f64) -> Value {
        let found = &self.found;
        let (mse, flip, joint) = (&found.relative_mse, &found.flip, found.joint.as_ref());
        let level = |level: &JointLevel| {
            json!({
                "side": level.side, "blocks": level.blocks, "z": level.z, "at": level.at,
                "limit": level.limit, "beyond": level.beyond,
            })
        };
        let levels = joint.map(|test| test.levels.iter().map(level).collect::<Vec<_>>());
        let mut value = json!({
            "resolution": found.size,
            "mean_luminance_a": found.means[0],
            "mean_luminance_b": found.means[1],
            "relmse": mse.luminance,
            "relmse_of_colours": mse.colours,
            "relmse_of_noise": mse.noise,
            "relmse_beyond_noise": mse.beyond_noise(),
            "flip_mean": flip.mean,
            "flip_95": flip.percentile_95,
            "flip_max": flip.max,
            "flip_max_at": self.flip_max_at(),
            "pixels_per_degree": pixels_per_degree,
            "unequal_pixels": found.unequal,
            "tested_pixels": joint.map_or(0, |test| test.tested),
            "exact_pixels": joint.map(|test| test.exact),
            "pixels_without_error": joint.map(|test| test.unknown),
            "outside_95_share": joint.map(|test| test.beyond_95),
            "replicates": joint.and_then(|test| test.replicates),
            "levels": levels,
            "differ": self.differ(),
            "not_judged_because": self.untested,
            "within_tolerance": self.within_tolerance(),
        });
        paths::put(&mut value, "a", &verb.a);
        paths::put(&mut value, "b", &verb.b);
        paths::put_all(&mut value, "written", verb.output.iter().map(PathBuf::as_path));
        value
    }
}

/// Lists what the joint test found.
fn tested(test: &JointTest) -> Vec<(String, String)> {
    let mut lines = Vec::new();
    for level in &test.levels {
        let name = match level {
            JointLevel { side: 1, .. } => "largest z of pixels".to_owned(),
            JointLevel { blocks: 1, .. } => "z of the whole".to_owned(),
            JointLevel { side, .. } => format!("of {side} x {side} blocks"),
        };
        let [z, limit] = [level.z, level.limit].map(|x| say::significant(x, 3));
        let text = match (level.blocks, level.beyond) {
            (1, _) => format!("{z}, limit {limit}"),
            (blocks, beyond) => {
                format!("{z} at {}, limit {limit}; {beyond} of {blocks} beyond", place(level.at))
            }
        };
        lines.push((name, text));
    }
    let chance = format!("{} of the pixels, 5 % by chance", say::percent(test.beyond_95));
    lines.push(("outside their 95 %".to_owned(), chance));
    let from = match test.replicates {
        Some(n) => format!("{n} replicates"),
        None => "replicates whose number is not said: taken as exact".to_owned(),
    };
    lines.push(("errors".to_owned(), format!("from {from}; false alarms {FALSE_ALARMS}")));
    for (name, count) in [("errors not known", test.unknown), ("errors of zero", test.exact)] {
        if count > 0 {
            lines.push((name.to_owned(), format!("{count} pixels")));
        }
    }
    lines
}

fn place([x, y]: [usize; 2]) -> String {
    format!("({x}, {y})")
}
