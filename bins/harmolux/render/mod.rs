//! `harmolux render`: a scene becomes a picture.

mod detail;
mod foresight;
mod keep;
mod preview;
mod report;
mod target;

use std::path::PathBuf;
use std::time::{Duration, Instant};

use clap::Args;
use harmolux::estimators::{
    Checkpointer, Ending, ImageSettings, Progress, Rendering, SHARE_WITHIN, resume,
};
use harmolux::io::output::Output;
use harmolux::io::scene_file::{RenderSpec, SceneFile};
use harmolux::scene::{Camera, Exposure, Layer, Scene, Tone, Window};
use harmolux::study::{camera, check_view, image_settings};
use harmolux::{Error, Result};

use self::foresight::Foresight;
use self::keep::{Kept, Place, finish};
use self::preview::Preview;
use self::target::{Image, View, open_outputs};
use crate::common::about::about;
use crate::common::exit::Code;
use crate::common::flags::{SceneArguments, choices};
use crate::common::progress::{self, Meter};
use crate::common::scenes::{load_scene, read_scene, stop};
use crate::common::surveys::code;
use crate::common::values::size;
use crate::common::{idle, interrupt, say};

/// Render the luminance, cd/m2, that a camera sees
///
/// Writes a PNG to look at and an EXR with the measured values: R, G, B, luminance.Y, its standard
/// error stderr.Y, and layers.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  harmolux render room.toml                          room.png and room.exr, here
  harmolux render room.toml -o out/a.png --quick     only a small PNG, fast
  harmolux render room.toml -D render.stop.time=30s  stop after half a minute
  harmolux render room.toml -D render.estimator=path the reference estimator
  harmolux render room.toml --resume                 go on after Ctrl-C
  harmolux render room.toml --camera glare           another camera of the scene
  harmolux render room.toml --crop 100,50,420,290    a part of the picture, the same pixels to the \
                                                     bit
  harmolux render room.toml --layers normal,depth    these layers only in the EXR

Cameras, filters, layers and files: docs/reference/pictures.md")]
#[allow(clippy::option_option, reason = "--resume is absent, alone, or has a file")]
pub(crate) struct Render {
    #[command(flatten)]
    pub(crate) common: SceneArguments,
    /// Replace output files that are there already
    #[arg(long)]
    pub(crate) force: bool,
    /// Where to write: FILE.png or FILE.exr; may be repeated [default: the scene's name, both
    /// kinds, in this folder]
    #[arg(short, long, value_name = "FILE")]
    pub(crate) output: Vec<PathBuf>,
    /// The number of pixels, such as 320x240
    #[arg(long, value_name = "WxH", value_parser = size)]
    pub(crate) size: Option<[u32; 2]>,
    /// The camera of the scene that takes the picture
    #[arg(long, value_name = "NAME")]
    pub(crate) camera: Option<String>,
    /// Only this part of the picture: left,top,right,bottom in pixels of its full size, right and
    /// bottom not included
    #[arg(long, value_name = "X0,Y0,X1,Y1", value_parser = crop)]
    pub(crate) crop: Option<[u32; 4]>,
    /// PNG value per cd/m2, or the share of the pixels that stays below white, such as 98%
    /// [default: 0.18 / geometric mean luminance]
    #[arg(long, value_name = "FACTOR|PERCENT", value_parser = str::parse::<Exposure>)]
    pub(crate) exposure: Option<Exposure>,
    /// What the PNG shows of values near and above white
    #[arg(long, value_name = "CURVE", value_parser = choices::<Tone>())]
    pub(crate) tone: Option<Tone>,
    /// Draw the picture on the terminal while it is rendered
    #[arg(long)]
    pub(crate) preview: bool,
    /// The layers of the EXR: all, none, or some of direct,indirect,normal,depth,id,albedo
    /// [default: all]
    #[arg(long, value_name = "NAMES", value_delimiter = ',', value_parser = LAYERS)]
    pub(crate) layers: Vec<String>,
    /// Where the state of the run is saved, and stays [default: NAME.checkpoint beside the picture,
    /// removed when the run is complete]
    #[arg(long, value_name = "FILE")]
    pub(crate) checkpoint: Option<PathBuf>,
    /// Go on with an interrupted run, or add walks to a complete one [default: NAME.checkpoint
    /// beside the picture]
    #[arg(long, value_name = "FILE", num_args = 0..=1, require_equals = true)]
    pub(crate) resume: Option<Option<PathBuf>>,
}

/// What `--layers` takes.
const LAYERS: [&str; 8] = ["all", "none", "direct", "indirect", "normal", "depth", "id", "albedo"];

/// Reads a value of the command line.
fn crop(text: &str) -> std::result::Result<[u32; 4], String> {
    let wrong = || "write left,top,right,bottom in pixels, such as 100,50,420,290".to_owned();
    let numbers = text.split(',').map(|part| part.trim().parse().ok());
    let numbers: Vec<u32> = numbers.collect::<Option<_>>().ok_or_else(wrong)?;
    let [x0, y0, x1, y1] = numbers.try_into().map_err(|_| wrong())?;
    if x0 < x1 && y0 < y1 {
        return Ok([x0, y0, x1, y1]);
    }
    Err("empty crop: right must exceed left, and bottom top".to_owned())
}

/// The least time between two pictures of a preview.
const PREVIEW_EVERY: Duration = Duration::from_secs(1);

/// What the target of a picture is about.
const ERROR: &str = "relative error of 95 % of the pixels";

/// Runs the verb.
pub(crate) fn run(verb: &Render, as_json: bool) -> Result<Code> {
    let file = with_options(read_scene(&verb.common.scene, &verb.common.define)?, verb)?;
    let camera = framed(camera(&file)?, &file, verb)?;
    let mut outputs = open_outputs(verb)?;
    let shows = verb.preview || outputs.iter().any(|(image, _)| *image == Image::Png);
    idle::refuse("no PNG is written", &[(verb.tone.is_some() && !shows, "--tone")])?;
    let place = Place::open(verb, &outputs)?;
    let meter = Meter::start("reading the scene");
    let loaded = load_scene(&file, Some(&camera), &meter)?;
    check_view(&file, &loaded.scene, &camera)?;
    detail::tell(&loaded.details);
    let settings = settings(&file.render, &loaded.scene, &verb.common);
    meter.stage("making room for the picture");
    let (film, mut kept) = place.take(&file, &camera, &settings, &loaded, &mut outputs)?;
    interrupt::saves();
    meter.stage("rendering");
    let view = View { scene: &loaded.scene, camera: &camera, file: &file, settings: &settings };
    let mark = kept.run();
    let write = |image: Image, output: &mut Output, stage, rendering: &Rendering| {
        image.write(output, stage, rendering, view, &mark)
    };
    let preview = verb.preview.then(|| Preview::new(film.size(), file.render.display())).flatten();
    let (every, mut saved) = (Kept::every(&file), Instant::now());
    let mut save = |so_far: &Rendering| {
        if let Some(preview) = &preview {
            preview.show(so_far, &meter);
        }
        if preview.is_none() || saved.elapsed() >= every {
            kept.save(so_far, &mut outputs, &write);
            saved = Instant::now();
        }
    };
    let often = if preview.is_some() { every.min(PREVIEW_EVERY) } else { every };
    let keeper = Checkpointer { every: often, save: &mut save };
    let foresight = Foresight::new(&settings);
    let watch = |p: &Progress| {
        foresight.look(p);
        meter.show(p, ERROR)
    };
    let rendering = resume(&loaded.scene, &camera, &settings, film, &watch, Some(keeper))
        .map_err(|e| about(&verb.common.scene, e))?;
    meter.stage("writing");
    // What is said from here on stands below the last picture.
    let meter = Some(meter).filter(|_| preview.is_none());
    if let Some(preview) = &preview {
        preview.leave(&rendering);
    }
    if rendering.unfinished == Some(0.0) {
        kept.end(&rendering, false);
        return Ok(nothing_done(&rendering));
    }
    let written = finish(kept, &mut outputs, &rendering, &write)?;
    drop(meter);
    report::warn(&rendering);
    if as_json {
        say::json(&report::json(&loaded, &rendering, settings.stop.relative_error, &written));
    } else {
        report::print(&loaded.fits, &rendering, &written);
    }
    let reached = rendering.film.relative_error_of(SHARE_WITHIN);
    Ok(match code(rendering.ending, settings.stop, reached, ERROR) {
        Code::Done if rendering.unfinished.is_some() => Code::NotMet,
        code => code,
    })
}

/// Says that no row of the picture was done in time.
fn nothing_done(rendering: &Rendering) -> Code {
    say::warning(&format!(
        "the run ended after {} before the first row of the picture was done, so nothing is \
         written; give it more time (`render.stop.time`), or take a smaller `--size`",
        progress::duration(rendering.elapsed)
    ));
    match rendering.ending {
        Ending::Interrupted => Code::Interrupted,
        _ => Code::NotMet,
    }
}

fn settings(spec: &RenderSpec, scene: &Scene, common: &SceneArguments) -> ImageSettings {
    let spec = RenderSpec {
        stop: stop(spec.stop, common.quick),
        seed: common.seed.unwrap_or(spec.seed),
        ..spec.clone()
    };
    image_settings(&spec, scene)
}

/// Puts what the command line says of the picture in the place of what the scene says.
fn with_options(mut file: SceneFile, verb: &Render) -> Result<SceneFile> {
    if let Some(name) = &verb.camera {
        if !file.cameras.contains_key(name) {
            let names: Vec<&str> = file.cameras.keys().map(String::as_str).collect();
            return Err(Error::Parameter(format!(
                "--camera {name}: the scene has no camera of that name; {}",
                if names.is_empty() {
                    "it has none".to_owned()
                } else {
                    format!("there are {}", names.join(", "))
                }
            )));
        }
        file.render.camera = Some(name.clone());
    }
    if let Some([x0, y0, x1, y1]) = verb.crop {
        file.render.crop = Some(Window::new([x0, y0], [x1, y1])?);
    }
    file.render.exposure = verb.exposure.unwrap_or(file.render.exposure);
    file.render.tone = verb.tone.unwrap_or(file.render.tone);
    if verb.layers.len() > 1 && verb.layers.iter().any(|name| name == "none") {
        return Err(Error::Parameter(format!(
            "--layers {}: `none` stands alone; leave it out, or the others",
            verb.layers.join(",")
        )));
    }
    if !verb.layers.is_empty() {
        let named = |layer: &Layer| verb.layers.iter().any(|n| n == "all" || n == layer.name());
        file.render.layers = Some(Layer::ALL.into_iter().filter(named).collect());
    }
    Ok(file)
}

/// Returns the camera the size and the window that are asked for. A crop counts pixels of the full
/// size, which a quick look halves with it.
fn framed(camera: Camera, file: &SceneFile, verb: &Render) -> Result<Camera> {
    let full = verb.size.map_or(camera, |size| camera.with_resolution(size));
    let crop = file.render.crop;
    let crop = crop.map(|window| full.with_window(window).map(|_| window));
    let crop = crop.transpose().map_err(|e| match verb.crop {
        Some(_) => Error::Parameter(format!("--crop: {e}")),
        None => file.source.error(&["render", "crop"], e.to_string(), None),
    })?;
    let halve = verb.common.quick && verb.size.is_none();
    let camera =
        if halve { full.with_resolution(full.resolution().map(|n| n.div_ceil(2))) } else { full };
    let crop = crop.map(|window| if halve { window.halved() } else { window });
    crop.map_or(Ok(camera), |window| camera.with_window(window))
}
