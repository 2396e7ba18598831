//! Flags that several verbs have in common.

use std::path::PathBuf;

use clap::builder::{PossibleValuesParser, TypedValueParser};
use clap::{Args, ValueEnum};
use harmolux::io::coefficients::{ReadOptions, SeriesFormat};
use harmolux::sh::{CondonShortley, Convention, Normalisation};

use crate::common::repairs::Repairs;

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
    /// A fast look: a tenth of the walks (and a quarter of the pixels)
    #[arg(long)]
    pub(crate) quick: bool,
}

/// How the numbers of a mesh file are meant
#[derive(Debug, Args)]
pub(crate) struct MeshHabits {
    /// The unit of the mesh file
    #[arg(long, value_enum, default_value_t)]
    pub(crate) unit: UnitName,
    /// The axis of the mesh file that points up
    #[arg(long, value_enum, default_value_t)]
    pub(crate) up: UpName,
    #[command(flatten)]
    pub(crate) repairs: Repairs,
}

#[derive(Debug, Clone, Copy, Default, ValueEnum)]
pub(crate) enum UnitName {
    Km,
    #[default]
    M,
    Cm,
    Mm,
    Um,
    In,
}

impl UnitName {
    /// Gives the length of the unit, metres.
    pub(crate) const fn metres(self) -> f64 {
        match self {
            Self::Km => 1000.0,
            Self::M => 1.0,
            Self::Cm => 0.01,
            Self::Mm => 0.001,
            Self::Um => 1e-6,
            Self::In => 0.0254,
        }
    }
}

#[derive(Debug, Clone, Copy, Default, ValueEnum)]
pub(crate) enum UpName {
    X,
    Y,
    #[default]
    Z,
}

/// How a coefficient file that does not say it is meant
#[derive(Debug, Args)]
pub(crate) struct SeriesHabits {
    /// The normalisation of a coefficient file that does not state it: 4pi, ortho, schmidt or unnorm
    #[arg(long)]
    pub(crate) normalisation: Option<Normalisation>,
    /// The phase of a coefficient file that does not state it: 1 without, -1 with Condon-Shortley
    #[arg(long, allow_hyphen_values = true, requires = "normalisation")]
    pub(crate) csphase: Option<CondonShortley>,
}

impl SeriesHabits {
    /// Gives the convention that was stated, if any.
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
    /// The unit of a coefficient file that does not state it [default: m]
    #[arg(long, value_enum)]
    pub(crate) unit: Option<UnitName>,
    /// The row of a table that holds several shapes, counted from 1
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    pub(crate) row: Option<u32>,
}

impl SeriesReading {
    /// Gives what is said of the file.
    pub(crate) fn options(&self) -> ReadOptions {
        ReadOptions {
            format: self.from,
            convention: self.habits.convention(),
            unit: self.unit.map(UnitName::metres),
            row: self.row.map(|row| row as usize),
        }
    }
}

/// Reads the name of a format of coefficients.
pub(crate) fn formats() -> impl TypedValueParser<Value = SeriesFormat> {
    let names = SeriesFormat::ALL.map(SeriesFormat::name);
    PossibleValuesParser::new(names).try_map(|name| name.parse::<SeriesFormat>())
}
