//! `harmolux falsecolor`: pictures and grids of sensors in colours that stand for values.

mod grids;

use std::path::PathBuf;

use clap::Args;
use glam::DVec3;
use harmolux::error::{InputError, shown};
use harmolux::io::images::{Attribute, Exr};
use harmolux::io::input::Input;
use harmolux::io::output::Output;
use harmolux::io::sensor_table::{self, MeasuredGroup};
use harmolux::plots::{ColourScale, FalseColour, Isolux, Palette, Scale, ScaleOptions, Tally};
use harmolux::{Error, Result};
use serde_json::json;

use self::grids::choose;
use crate::common::exit::Code;
use crate::common::flags::choices;
use crate::common::plot::{PlotFormat, unknown_output};
use crate::common::target::write_all;
use crate::common::{paths, say};

/// The share of the pixels that a scale reaches by itself: the brightest, lamps and their glints,
/// would leave the rest dark.
const COVER: f64 = 0.995;
/// How an EXR image begins.
const EXR: &[u8] = &[0x76, 0x2f, 0x31, 0x01];
/// The column that is shown unless another is named.
const ILLUMINANCE: &str = "illuminance_lx";

/// Show luminance or illuminance in false colour
///
/// An EXR picture, as `render` writes it, becomes the same picture in colours that stand for cd/m2.
/// A CSV table, as `illum` writes it, becomes the isolux picture of a grid of sensors on whatever
/// plane: each sensor a cell with its value, lines of equal illuminance with theirs, axes in
/// metres; sensors behind objects are hatched and do not count. The scale is linear from 0 (of a
/// grid whose least value is above half of the largest, from there) to a round number above the
/// largest value, or of a picture above 99.5 % of the pixels; where values are beyond it, its
/// legend has a tip. What is not finite is magenta; a depth without end, where there is nothing, is
/// grey.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  harmolux falsecolor view.exr -o view_cd.png                  0 to what 99.5 % of the pixels have
  harmolux falsecolor view.exr -o view_cd.png --scale 1000 --log 3 --lines --points
  harmolux falsecolor view.exr -o error.png --channel stderr.Y
  harmolux illum room.toml -o lux.csv && harmolux falsecolor lux.csv -o floor.svg --group floor
  harmolux falsecolor lux.csv -o floor.png --scale 500 --divisions 5 --bands --palette turbo")]
pub(crate) struct Falsecolor {
    /// A picture (.exr) or a table of sensors (.csv)
    pub(crate) input: PathBuf,
    /// Write a picture (.png) or a drawing (.svg); may be repeated
    #[arg(short, long, required = true, value_name = "FILE")]
    pub(crate) output: Vec<PathBuf>,
    /// The sensors to show [default: those that are a grid, if only one group is]
    #[arg(long, value_name = "NAME")]
    pub(crate) group: Option<String>,
    /// The channel of the picture [default: its luminance] or the column of the table [default:
    /// illuminance_lx]
    #[arg(long, value_name = "NAME")]
    pub(crate) channel: Option<String>,
    #[command(flatten)]
    pub(crate) scale: ScaleArguments,
    /// Draw isolines over a picture, smoothed over five pixels; a grid has them always
    #[arg(long)]
    pub(crate) lines: bool,
    /// Mark the largest and the least value
    #[arg(short = 'e', long)]
    pub(crate) points: bool,
    /// The unit over the legend [default: what the file says]
    #[arg(short, long, value_name = "UNIT")]
    pub(crate) label: Option<String>,
    /// Replace output files that are there already
    #[arg(long)]
    pub(crate) force: bool,
}

/// Which colour stands for which value
#[derive(Debug, Args)]
pub(crate) struct ScaleArguments {
    /// The value of the last colour
    #[arg(short, long, value_name = "MAX", allow_negative_numbers = true)]
    pub(crate) scale: Option<f64>,
    /// The value of the first colour
    #[arg(long, value_name = "MIN", conflicts_with = "log", allow_negative_numbers = true)]
    pub(crate) min: Option<f64>,
    /// A logarithmic scale of so many decades below its end: above 0 and at most 30
    #[arg(long, value_name = "DECADES", allow_negative_numbers = true)]
    pub(crate) log: Option<f64>,
    /// Divide the scale into so many equal parts [default: at round values]
    #[arg(
        short = 'n', long, value_name = "N",
        value_parser = clap::value_parser!(u16).range(1..=100)
    )]
    pub(crate) divisions: Option<u16>,
    /// The colours; all but turbo, a rainbow, and balance, for differences, get lighter in even
    /// steps
    #[arg(long, default_value_t, value_parser = choices::<Palette>())]
    pub(crate) palette: Palette,
    /// Give each division one colour
    #[arg(long)]
    pub(crate) bands: bool,
}

/// Runs the verb.
pub(crate) fn run(verb: &Falsecolor, as_json: bool) -> Result<Code> {
    let open = |path: &PathBuf| {
        let format =
            PlotFormat::of_extension(path).ok_or_else(|| unknown_output(path, ".png or .svg"))?;
        Ok((format, Output::open(path, &format.kind(), verb.force)?))
    };
    let targets = verb.output.iter().map(open).collect::<Result<Vec<_>>>()?;
    let shown = Shown::read(verb)?;
    write_all(targets.into_iter().map(|(format, output)| match format {
        PlotFormat::Png => output.write(&shown.to_png()?),
        PlotFormat::Svg => output.write(shown.to_svg()?.as_bytes()),
    }))?;
    let tally = shown.tally();
    if tally.not_finite > 0 {
        let count = tally.not_finite;
        let verb = if count == 1 { "value is" } else { "values are" };
        say::warning(&format!("{count} {verb} not finite; shown magenta"));
    }
    if as_json {
        say::json(&shown.json(&tally, &verb.output));
    } else {
        shown.report(&tally, &verb.output);
    }
    Ok(Code::Done)
}

/// What is shown.
struct Shown {
    drawing: Drawing,
    /// What it is, for people.
    subject: (&'static str, String),
    scale: ColourScale,
    unit: String,
    /// What counts of it.
    values: Vec<f64>,
}

enum Drawing {
    Picture(FalseColour),
    Grid { grid: Isolux, at: Vec<DVec3> },
}

impl Shown {
    fn read(verb: &Falsecolor) -> Result<Self> {
        let path = &verb.input;
        let bytes = Input::open(path)?.rest()?;
        if bytes.starts_with(EXR) {
            return Self::picture(verb, &Exr::from_bytes(path, &bytes)?);
        }
        let is_table = path.extension().is_some_and(|e| e.eq_ignore_ascii_case("csv"));
        if !is_table && !sensor_table::recognise(&bytes) {
            let message = "this is neither an EXR picture nor a CSV table";
            let help =
                "give what `harmolux render -o view.exr` or `harmolux illum -o lux.csv` wrote";
            return Err(InputError::new(path, message).help(help).into());
        }
        let column = verb.channel.as_deref().unwrap_or(ILLUMINANCE);
        Self::grid(verb, sensor_table::parse(path, &bytes, column)?, column)
    }

    fn picture(verb: &Falsecolor, exr: &Exr) -> Result<Self> {
        if let Some(group) = &verb.group {
            return Err(Error::Parameter(format!(
                "{}: a picture has no group `{group}` of sensors: leave --group out, or give the \
                 table of `harmolux illum -o lux.csv`",
                verb.input.display()
            )));
        }
        let values = channel(verb, exr)?;
        // The unit of the file is that of light; the other layers of `render` have their own.
        let layer = verb.channel.as_deref().and_then(|name| name.split('.').next());
        let shape = match layer {
            Some("depth") => Some("m"),
            Some("id" | "normal" | "albedo") => Some(""),
            _ => None,
        };
        let given = verb.label.as_deref().or(shape);
        let unit = match (given, exr.attribute("unit")) {
            (Some(label), _) => label.to_owned(),
            (None, Some(Attribute::Text(unit))) => unit.clone(),
            _ => String::new(),
        };
        let unit = say::unit(&unit);
        let scale = verb.scale.wish().fitted(&values, COVER)?;
        let (width, height) = (exr.width(), exr.height());
        let picture = FalseColour {
            width,
            height,
            values: values.clone(),
            scale: scale.clone(),
            unit: unit.clone(),
            lines: verb.lines,
            extremes: verb.points,
            endless: layer == Some("depth"),
        };
        let subject = ("picture", format!("{width} x {height}"));
        Ok(Self { drawing: Drawing::Picture(picture), subject, scale, unit, values })
    }

    fn grid(verb: &Falsecolor, groups: Vec<MeasuredGroup>, column: &str) -> Result<Self> {
        let (group, lattice) = choose(verb, groups)?;
        let values: Vec<f64> = group.values.iter().flatten().copied().collect();
        let scale = verb.scale.wish().tight().fitted(&values, 1.0)?;
        let unit = if column.ends_with("_lx") { "lx" } else { "" };
        let unit = say::unit(verb.label.as_deref().unwrap_or(unit));
        let hidden = group.values.len() - values.len();
        let behind =
            if hidden == 0 { String::new() } else { format!(", {hidden} behind an object") };
        let [columns, rows] = lattice.size;
        let name = shown(&group.name);
        let subject = ("grid", format!("{name}, {columns} x {rows}{behind}"));
        let title = match column {
            ILLUMINANCE => name,
            other => format!("{name}: {other}"),
        };
        let grid = Isolux {
            title,
            unit: unit.clone(),
            lattice,
            values: group.values,
            scale: scale.clone(),
            extremes: verb.points,
        };
        Ok(Self { drawing: Drawing::Grid { grid, at: group.at }, subject, scale, unit, values })
    }

    fn to_png(&self) -> Result<Vec<u8>> {
        match &self.drawing {
            Drawing::Picture(picture) => picture.to_png(),
            Drawing::Grid { grid, .. } => grid.to_png(),
        }
    }

    fn to_svg(&self) -> Result<String> {
        match &self.drawing {
            Drawing::Picture(picture) => picture.to_svg(),
            Drawing::Grid { grid, .. } => grid.to_svg(),
        }
    }

    fn tally(&self) -> Tally {
        match &self.drawing {
            Drawing::Picture(picture) => picture.tally(),
            Drawing::Grid { grid, .. } => grid.tally(),
        }
    }

    /// Counts the pixels that show nothing.
    fn nothing(&self) -> usize {
        match &self.drawing {
            Drawing::Picture(picture) => picture.nothing(),
            Drawing::Grid { .. } => 0,
        }
    }

    /// Returns where a value is: a pixel from the top left, counted from 0, or a point, metres.
    fn place(&self, place: usize) -> Vec<f64> {
        match &self.drawing {
            Drawing::Picture(FalseColour { width, .. }) => {
                vec![(place % width) as f64, (place / width) as f64]
            }
            Drawing::Grid { at, .. } => at[place].to_array().to_vec(),
        }
    }

    fn report(&self, tally: &Tally, outputs: &[PathBuf]) {
        let kind = match self.scale.kind() {
            Scale::Linear => "linear",
            Scale::Logarithmic => "logarithmic",
        };
        let [low, high] = self.scale.range().map(|v| say::significant(v, 4));
        let mut lines = vec![
            (self.subject.0, self.subject.1.clone()),
            ("scale", format!("{low} to {high} {}, {kind}, {}", self.unit, self.scale.palette())),
            ("mean", format!("{} {}", say::significant(tally.mean, 4), self.unit)),
        ];
        for (name, extreme) in [("least", tally.least), ("largest", tally.largest)] {
            if let Some((place, value)) = extreme {
                let place: Vec<String> = self.place(place).into_iter().map(coordinate).collect();
                let value = say::significant(value, 4);
                lines.push((name, format!("{value} {} at ({})", self.unit, place.join(", "))));
            }
        }
        let [below, above] = self.scale.outside(&self.values);
        for (name, count) in [
            ("below the scale", below),
            ("above the scale", above),
            ("nothing there", self.nothing()),
        ] {
            if count > 0 {
                let share = say::percent(count as f64 / self.values.len() as f64);
                lines.push((name, format!("{count}, {share}")));
            }
        }
        lines.extend(outputs.iter().map(|path| ("written", path.display().to_string())));
        say::pairs(&lines);
    }

    fn json(&self, tally: &Tally, outputs: &[PathBuf]) -> serde_json::Value {
        let extreme = |extreme: Option<(usize, f64)>| {
            extreme.map(|(place, value)| json!({ "value": value, "at": self.place(place) }))
        };
        let [low, high] = self.scale.range();
        let [below, above] = self.scale.outside(&self.values);
        let mut value = json!({
            "unit": self.unit,
            "low": low,
            "high": high,
            "logarithmic": self.scale.kind() == Scale::Logarithmic,
            "levels": self.scale.levels(),
            "palette": self.scale.palette().name(),
            "mean": tally.mean,
            "least": extreme(tally.least),
            "largest": extreme(tally.largest),
            "non_finite": tally.not_finite,
            "nothing": self.nothing(),
            "below": below,
            "above": above,
        });
        paths::put_all(&mut value, "written", outputs.iter().map(PathBuf::as_path));
        value
    }
}

impl ScaleArguments {
    fn wish(&self) -> ScaleOptions {
        ScaleOptions {
            high: self.scale,
            low: self.min,
            decades: self.log,
            divisions: self.divisions,
            palette: self.palette,
            bands: self.bands,
            ..ScaleOptions::default()
        }
    }
}

/// Takes a channel of a picture; its luminance unless one is named.
fn channel(verb: &Falsecolor, exr: &Exr) -> Result<Vec<f64>> {
    let named = |name: &str| Some(exr.find(name)?.iter().copied().map(f64::from).collect());
    if let Some(values) = verb.channel.as_deref().map_or_else(|| exr.luminance(), named) {
        return Ok(values);
    }
    let missing =
        verb.channel.as_deref().map_or("luminance".to_owned(), |n| format!("channel `{n}`"));
    let names = exr.channel_names().collect::<Vec<_>>().join(", ");
    let message = format!("the picture has no {missing}, only {names}");
    Err(InputError::new(&verb.input, message).help("name one with --channel").into())
}

/// Writes a coordinate to a tenth of a millimetre.
fn coordinate(x: f64) -> String {
    format!("{}", (x * 1e4).round() / 1e4 + 0.0)
}
