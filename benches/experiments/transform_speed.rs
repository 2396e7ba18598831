//! Times the transform and the evaluation at scattered points, on one thread, one task a line:
//! `cargo run --release --features experiments --example transform_speed`.
//!
//! Reads lines `plan|synthesis|analysis|values|jets LMAX` and answers each with the microseconds of
//! one call (for `values` and `jets`: at 100 000 random directions). So a script can let it take
//! turns with another program; `benches/peers/transform.py` does that with ducc0 and SHTns. Without
//! input it times the usual degrees and prints the medians of some calls.

use std::collections::btree_map::{BTreeMap, Entry};
use std::error::Error;
use std::hint::black_box;
use std::io::{BufRead, IsTerminal, Write};
use std::time::Instant;

use glam::DVec3;
use harmolux::math::sampling::uniform_sphere;
use harmolux::sh::{Coefficients, Grid, Series, Transform};
use rand::{RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;

const POINTS: usize = 100_000;
const CALLS: usize = 15;

/// What one degree needs, made when it is first asked for.
struct Case {
    coefficients: Coefficients,
    transform: Transform,
    samples: Vec<f64>,
    series: Series,
    directions: Vec<DVec3>,
}

impl Case {
    fn new(lmax: usize) -> harmolux::Result<Self> {
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(1);
        let mut coefficients = Coefficients::zeros(lmax);
        for l in 0..=lmax {
            for m in 0..=l {
                coefficients.set(l, m, rng.random::<f64>() - 0.5, rng.random::<f64>() - 0.5);
            }
        }
        let transform = plan(lmax)?;
        Ok(Self {
            samples: transform.synthesis(&coefficients)?,
            series: Series::new(&coefficients)?,
            directions: (0..POINTS).map(|_| uniform_sphere(rng.random())).collect(),
            coefficients,
            transform,
        })
    }

    /// Does one task and gives the microseconds it took.
    fn time(&self, task: &str) -> Result<f64, Box<dyn Error>> {
        let started = Instant::now();
        match task {
            "plan" => drop(black_box(plan(self.coefficients.lmax())?)),
            "synthesis" => drop(black_box(self.transform.synthesis(&self.coefficients)?)),
            "analysis" => drop(black_box(self.transform.analysis(&self.samples)?)),
            "values" => drop(black_box(self.series.values(&self.directions))),
            "jets" => drop(black_box(self.series.jets(&self.directions))),
            _ => {
                return Err(format!(
                    "`{task}` is no task: use plan, synthesis, analysis, values or jets"
                )
                .into());
            }
        }
        Ok(1e6 * started.elapsed().as_secs_f64())
    }
}

/// The grid of the peers: lmax + 1 Gauss-Legendre rings of 2 lmax + 2 azimuths.
fn plan(lmax: usize) -> harmolux::Result<Transform> {
    Ok(Transform::new(lmax, Grid::gauss_legendre(lmax + 1, 2 * lmax + 2))?.single_threaded())
}

fn main() -> Result<(), Box<dyn Error>> {
    rayon::ThreadPoolBuilder::new().num_threads(1).build_global()?;
    let mut cases = BTreeMap::new();
    let mut time = |line: &str| -> Result<f64, Box<dyn Error>> {
        let (task, degree) =
            line.split_once(' ').ok_or("write a task and a degree, such as `synthesis 511`")?;
        let lmax = degree.trim().parse()?;
        let case = match cases.entry(lmax) {
            Entry::Occupied(known) => known.into_mut(),
            Entry::Vacant(new) => new.insert(Case::new(lmax)?),
        };
        case.time(task)
    };
    if std::io::stdin().is_terminal() {
        for lmax in [32, 127, 255, 511, 1023] {
            for task in ["plan", "synthesis", "analysis"] {
                println!("{task} {lmax}: {:.0} us", median(|| time(&format!("{task} {lmax}")))?);
            }
        }
        for lmax in [8, 16, 32, 64, 128] {
            for task in ["values", "jets"] {
                let call = median(|| time(&format!("{task} {lmax}")))?;
                println!("{task} {lmax}: {:.1} ns a point", 1e3 * call / POINTS as f64);
            }
        }
        return Ok(());
    }
    for line in std::io::stdin().lock().lines() {
        println!("{:.3}", time(&line?)?);
        std::io::stdout().flush()?;
    }
    Ok(())
}

fn median(mut call: impl FnMut() -> Result<f64, Box<dyn Error>>) -> Result<f64, Box<dyn Error>> {
    let mut times = (0..CALLS).map(|_| call()).collect::<Result<Vec<_>, _>>()?;
    times.sort_by(f64::total_cmp);
    Ok(times[CALLS / 2])
}
