//! Flags that several verbs have in common.

use std::path::PathBuf;
use std::str::FromStr;

use clap::Args;
use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use glam::DVec3;
use harmolux::Error;
use harmolux::fit::{Centre, Envelope, FitSettings, FoldPolicy};
use harmolux::io::coefficients::{ReadOptions, SeriesFormat};
use harmolux::math::{Choice, Unit};
use harmolux::mesh::UpAxis;
use harmolux::sh::{CondonShortley, Convention, Filter, Normalisation};

use crate::common::repairs::Repairs;
use crate::common::values::{length, point};

/// What verbs that run a scene have in common
#[derive(Debug, Args)]
pub(crate) struct SceneArguments {
    /// The scene file (TOML)
    pub(crate) scene: PathBuf,
    /// Set a key of the scene, such as lights.lamp.point.intensity=250; may be repeated
    #[arg(short = 'D', value_name = "KEY=VALUE")]
    pub(crate) define: Vec<String>,
    /// The seed: the same seed gives the same bytes
    #[arg(long)]
    pub(crate) seed: Option<u64>,
    /// A faster look: a tenth of the walks, or sqrt(10) times the error asked for (and a quarter of
    /// the pixels)
    #[arg(long)]
    pub(crate) quick: bool,
}

/// How the numbers of a mesh file are meant
#[derive(Debug, Args)]
pub(crate) struct MeshHabits {
    /// The unit of the mesh file
    #[arg(long, default_value_t, value_parser = choices::<Unit>())]
    pub(crate) unit: Unit,
    /// The axis of the mesh file that points up
    #[arg(long, default_value_t, value_parser = choices::<UpAxis>())]
    pub(crate) up: UpAxis,
    #[command(flatten)]
    pub(crate) repairs: Repairs,
}

impl MeshHabits {
    /// Lists what is said, and whether it is.
    pub(crate) fn given(&self) -> [(bool, &'static str); 3] {
        [
            (self.unit != Unit::default(), "--unit"),
            (self.up != UpAxis::default(), "--up"),
            (self.repairs.repair, "--repair"),
        ]
    }
}

/// How a mesh is fitted
#[derive(Debug, Args)]
pub(crate) struct FitHabits {
    /// The expansion centre: X,Y,Z in metres, or for each mesh its `origin`, the `centroid` of its
    /// volume, or the `best`, farthest from the planes of all faces [default: the origin if the
    /// mesh is star-shaped about it, else one near the centroid]
    #[arg(long, value_name = "CENTRE", value_parser = centre, allow_hyphen_values = true)]
    pub(crate) centre: Option<Centre>,
    /// Fit an envelope of a mesh that is not star-shaped: which radius stands for a ray that meets
    /// it more than once
    #[arg(long, value_name = "ENVELOPE", value_parser = choices::<Envelope>())]
    pub(crate) not_star: Option<Envelope>,
    /// The largest share of such rays that is accepted, per cent of the solid angle
    #[arg(
        long, value_name = "PERCENT", default_value_t = 5.0, requires = "not_star",
        value_parser = percentage
    )]
    pub(crate) not_star_limit: f64,
    /// Damp the series against ringing: lanczos, or heat=T such as heat=0.001
    #[arg(long)]
    pub(crate) filter: Option<Filter>,
}

impl FitHabits {
    /// Returns the settings of a fit, by the usual projection.
    pub(crate) fn settings(&self, lmax: usize) -> FitSettings {
        let limit = 0.01 * self.not_star_limit;
        FitSettings {
            centre: self.centre,
            not_star: self.not_star.map(|envelope| FoldPolicy { envelope, limit }),
            filter: self.filter,
            ..FitSettings::of_degree(lmax)
        }
    }

    /// Lists what is said, and whether it is.
    pub(crate) fn given(&self) -> [(bool, &'static str); 3] {
        [
            (self.centre.is_some(), "--centre"),
            (self.not_star.is_some(), "--not-star"),
            (self.filter.is_some(), "--filter"),
        ]
    }
}

/// How a coefficient file that does not say it is meant
#[derive(Debug, Args)]
pub(crate) struct SeriesHabits {
    /// The normalisation of a coefficient file that does not state it: 4pi, ortho, schmidt or
    /// unnorm
    #[arg(long)]
    pub(crate) normalisation: Option<Normalisation>,
    /// The phase of a coefficient file that does not state it: 1 without, -1 with Condon-Shortley
    #[arg(long, allow_hyphen_values = true, requires = "normalisation")]
    pub(crate) csphase: Option<CondonShortley>,
}

impl SeriesHabits {
    /// Lists what is said, and whether it is.
    pub(crate) fn given(&self) -> [(bool, &'static str); 2] {
        let (normalisation, csphase) = (self.normalisation.is_some(), self.csphase.is_some());
        [(normalisation, "--normalisation"), (csphase, "--csphase")]
    }

    /// Returns the convention that was stated, if any.
    pub(crate) fn convention(&self) -> Option<Convention> {
        let phase = self.csphase.unwrap_or_default();
        self.normalisation.map(|normalisation| Convention { normalisation, phase })
    }
}

/// How a coefficient file is to be read
#[derive(Debug, Args)]
pub(crate) struct SeriesReading {
    /// The format of the coefficient file [default: told by its content]
    #[arg(long, value_name = "FORMAT", value_parser = formats())]
    pub(crate) from: Option<SeriesFormat>,
    #[command(flatten)]
    pub(crate) habits: SeriesHabits,
    /// The unit of a file that does not state it [default: m]
    #[arg(long, value_parser = choices::<Unit>())]
    pub(crate) unit: Option<Unit>,
    /// Add this radius, metres or with its unit, to a file of heights above it
    #[arg(long, value_name = "LENGTH", value_parser = length)]
    pub(crate) add_radius: Option<f64>,
    /// The row of a table that holds several shapes, counted from 1
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    pub(crate) row: Option<u32>,
}

impl SeriesReading {
    /// Lists what is said of coefficients alone, and whether it is.
    pub(crate) fn of_series(&self) -> [(bool, &'static str); 4] {
        let [normalisation, csphase] = self.habits.given();
        [
            normalisation,
            csphase,
            (self.add_radius.is_some(), "--add-radius"),
            (self.row.is_some(), "--row"),
        ]
    }

    /// Returns how many metres the unit has that was said; 1 where none was.
    pub(crate) fn metres(&self) -> f64 {
        self.unit.map_or(1.0, Unit::metres)
    }

    /// Returns what is said of the file.
    pub(crate) fn options(&self) -> ReadOptions {
        ReadOptions {
            format: self.from,
            convention: self.habits.convention(),
            unit: self.unit.map(Unit::metres),
            add_radius: self.add_radius,
            row: self.row.map(|row| row as usize),
        }
    }
}

/// Reads the name of a choice.
pub(crate) fn choices<T: Choice + FromStr<Err = Error> + Send + Sync>()
-> impl TypedValueParser<Value = T> {
    let values = T::NAMES.iter().zip(T::MEANINGS);
    let values = values.map(|(name, meaning)| {
        let value = PossibleValue::new(*name);
        if meaning.is_empty() { value } else { value.help(*meaning) }
    });
    PossibleValuesParser::new(values).try_map(|name| name.parse::<T>())
}

/// Reads the name of a format of coefficients.
pub(crate) fn formats() -> impl TypedValueParser<Value = SeriesFormat> {
    let names = SeriesFormat::ALL.map(SeriesFormat::name);
    PossibleValuesParser::new(names).try_map(|name| name.parse::<SeriesFormat>())
}

/// Reads a value of the command line.
fn centre(text: &str) -> Result<Centre, String> {
    match text {
        "origin" => Ok(Centre::At(DVec3::ZERO)),
        "centroid" => Ok(Centre::Centroid),
        "best" => Ok(Centre::Best),
        _ => point(text)
            .map(Centre::At)
            .map_err(|e| format!("{e}, or one of origin, centroid, best")),
    }
}

fn percentage(text: &str) -> Result<f64, String> {
    let share = text.trim_end_matches('%').trim().parse::<f64>().ok();
    share.filter(|p| (0.0..=100.0).contains(p)).ok_or_else(|| "write a number from 0 to 100".into())
}
