//! Kills a render twenty times at random moments, resumes it each time, and compares the picture
//! with that of a run left alone: to the bit.
//!
//! ```text
//! cargo build --release && cargo run --release --example kill_resume
//! ```
//!
//! Every other kill or so is SIGKILL, which loses what came after the last checkpoint; the others
//! are SIGTERM (elsewhere than on Unix all are kills), upon which the run saves. The moments follow
//! from a seed, the first argument (1). Ends with 0 when the pictures are equal.

use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitCode, Stdio};
use std::time::{Duration, Instant};

use harmolux::math::hash;

const KILLS: u32 = 20;

const SCENE: &str = r#"format = 1
[materials.grey.lambert]
reflectance = 0.6
[objects.room.box]
min = [0, 0, 0]
max = [4, 5, 3]
inward = true
material = "grey"
[objects.ball.sphere]
centre = [2, 3, 1]
radius = 0.7
material = "grey"
[lights.lamp.point]
at = [1, 1, 2.5]
intensity = 100
[cameras.main.perspective]
from = [2, 0.3, 1.5]
to = [2, 3, 1]
fov = 60
resolution = [96, 72]
[render]
checkpoint = 0.05
stop = { relative_error = 0.005, walks = 8192 }
"#;

type Failure = Box<dyn std::error::Error>;

fn main() -> Result<ExitCode, Failure> {
    let seed = std::env::args().nth(1).map_or(Ok(1), |text| text.parse())?;
    let tool = tool()?;
    let folder = tempfile::tempdir()?;
    std::fs::write(folder.path().join("room.toml"), SCENE)?;
    let started = Instant::now();
    start(&tool, folder.path(), "whole.exr")?.wait()?;
    let whole = started.elapsed();
    println!("left alone: {:.1} s", whole.as_secs_f64());
    for kill in 0..KILLS {
        let moment = hash([seed, u64::from(kill)]);
        let share = (moment >> 11) as f64 / (1_u64 << 53) as f64;
        let mut child = start(&tool, folder.path(), "killed.exr")?;
        std::thread::sleep(Duration::from_millis(30) + whole.mul_f64(share / 24.0));
        let gently = cfg!(unix) && moment % 2 == 0;
        if child.try_wait()?.is_some() {
            println!("over before kill {kill}: the run is too short");
            return Ok(ExitCode::FAILURE);
        }
        if gently {
            Command::new("kill").args(["-TERM", &child.id().to_string()]).status()?;
        } else {
            child.kill()?;
        }
        child.wait()?;
        println!("{} {}", if gently { "SIGTERM" } else { "SIGKILL" }, kill + 1);
    }
    start(&tool, folder.path(), "killed.exr")?.wait()?;
    let read = |name: &str| std::fs::read(folder.path().join(name));
    let equal = read("whole.exr")? == read("killed.exr")?;
    println!(
        "{KILLS} kills: the pictures are {}",
        if equal { "equal to the bit" } else { "DIFFERENT" }
    );
    Ok(if equal { ExitCode::SUCCESS } else { ExitCode::FAILURE })
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
