//! Ends renders of four scenes a hundred times at random moments, resumes them each time, and
//! compares the pictures with those of runs left alone: to the bit.
//!
//! ```text
//! cargo build --release && cargo run --release --features experiments --example kill_resume
//! ```
//!
//! HUP, INT, TERM and KILL come in random turns. Upon the first three the run saves; KILL loses
//! what came after the last checkpoint (elsewhere than on Unix all are kills). Signals and moments
//! follow from a seed, the first argument (1). Ends with 0 when all pictures are equal.

use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitCode, Stdio};
use std::time::{Duration, Instant};

use harmolux::math::hash;

#[expect(unreachable_pub, reason = "tests share it")]
#[path = "../../tests/common/scenes.rs"]
mod scenes;

use scenes::{BALL, CAMERA, LAMP, ROOM};

/// Of each scene.
const KILLS: u32 = 25;

const SIGNALS: [&str; 4] = ["HUP", "INT", "TERM", "KILL"];

/// How the room is rendered; what a scene adds follows.
const RENDER: &str = "resolution = [96, 72]
[render]
checkpoint = 0.05
";

/// The scenes: what is another in each, and what it ends with.
const SCENES: [(&str, &str, &str, &str); 4] = [
    ("local", "", "", "stop = { relative_error = 0.005, walks = 8192 }"),
    ("path", "", "", "estimator = \"path\"\nstop = { walks = 2048 }"),
    ("lamp", LAMP, SHINING, "stop = { walks = 4096 }"),
    ("crop", "fov = 60", "fov = 90", "crop = [20, 10, 80, 60]\nstop = { relative_error = 0.005 }"),
];

/// A lamp with a size, and a mirror beside it.
const SHINING: &str = r#"[materials.shining.lambert]
reflectance = 0.2
exitance = 5000
[materials.silver.mirror]
reflectance = 0.9
[objects.lamp.sphere]
centre = [1, 1, 2.5]
radius = 0.1
material = "shining"
[objects.mirror.disc]
centre = [0.2, 2.5, 1.5]
normal = [1, 0, 0]
radius = 0.8
material = "silver"
"#;

type Failure = Box<dyn std::error::Error>;

fn main() -> Result<ExitCode, Failure> {
    let seed = std::env::args().nth(1).map_or(Ok(1), |text| text.parse())?;
    let tool = tool()?;
    let mut all_equal = true;
    for (number, (name, from, to, end)) in SCENES.into_iter().enumerate() {
        let scene = [ROOM, BALL, LAMP, CAMERA, RENDER].concat().replace(from, to) + end;
        let equal = survives(&tool, &scene, hash([seed, number as u64]))?;
        println!("{name}: {KILLS} times, {}", if equal { "equal to the bit" } else { "DIFFERENT" });
        all_equal &= equal;
    }
    Ok(if all_equal { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}

/// Whether a picture is the same when its run is ended again and again.
fn survives(tool: &Path, scene: &str, seed: u64) -> Result<bool, Failure> {
    let folder = tempfile::tempdir()?;
    std::fs::write(folder.path().join("room.toml"), scene)?;
    let started = Instant::now();
    start(tool, folder.path(), "whole.exr")?.wait()?;
    let whole = started.elapsed();
    println!("left alone: {:.1} s", whole.as_secs_f64());
    for kill in 0..KILLS {
        let moment = hash([seed, u64::from(kill)]);
        let share = (moment >> 11) as f64 / (1_u64 << 53) as f64;
        let mut child = start(tool, folder.path(), "killed.exr")?;
        std::thread::sleep(Duration::from_millis(30) + whole.mul_f64(share / 30.0));
        if child.try_wait()?.is_some() {
            return Err(format!("over before kill {kill}: the run is too short").into());
        }
        let signal = if cfg!(unix) { SIGNALS[(moment % 4) as usize] } else { "KILL" };
        if signal == "KILL" {
            child.kill()?;
        } else {
            Command::new("kill").args([&format!("-{signal}"), &child.id().to_string()]).status()?;
        }
        child.wait()?;
        println!("{signal} {}", kill + 1);
    }
    start(tool, folder.path(), "killed.exr")?.wait()?;
    let read = |name: &str| std::fs::read(folder.path().join(name));
    Ok(read("whole.exr")? == read("killed.exr")?)
}

/// Finds the tool beside this example.
fn tool() -> Result<PathBuf, Failure> {
    let own = std::env::current_exe()?;
    let folder = own.parent().and_then(Path::parent).ok_or("no folder of builds")?;
    let tool = folder.join(format!("harmolux{}", std::env::consts::EXE_SUFFIX));
    if tool.exists() { Ok(tool) } else { Err("build the tool first: cargo build --release".into()) }
}

fn start(tool: &Path, folder: &Path, output: &str) -> Result<Child, Failure> {
    let mut command = Command::new(tool);
    command.current_dir(folder).args(["render", "room.toml", "-o", output, "--resume"]);
    Ok(command.stdout(Stdio::null()).stderr(Stdio::null()).spawn()?)
}
