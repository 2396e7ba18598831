//! Values and gradients of a series at scattered directions, one thread: `cargo bench --bench
//! series`.
//!
//! Peers: ducc0's synthesis_general and sphericart at the same degree and points.

use divan::counter::ItemsCount;
use divan::{Bencher, black_box};
use glam::DVec3;
use harmolux::math::sampling::uniform_sphere;
use harmolux::sh::{Coefficients, Series};

const POINTS: u32 = 1000;

fn main() {
    divan::main();
}

fn series(lmax: usize) -> Series {
    let mut c = Coefficients::zeros(lmax);
    for l in 0..=lmax {
        for m in 0..=l {
            c.set(l, m, 1.0 / (1 + l * l + m) as f64, 0.3 / (1 + l + m) as f64);
        }
    }
    Series::new(&c).expect("a moderate degree")
}

fn directions() -> Vec<DVec3> {
    let golden = 0.618_033_988_749_895;
    (0..POINTS)
        .map(|i| {
            uniform_sphere([
                (f64::from(i) + 0.5) / f64::from(POINTS),
                (f64::from(i) * golden).fract(),
            ])
        })
        .collect()
}

#[divan::bench(args = [8, 16, 32, 64, 128])]
fn value(bencher: Bencher, lmax: usize) {
    let (f, directions) = (series(lmax), directions());
    bencher
        .counter(ItemsCount::new(directions.len()))
        .bench_local(|| directions.iter().map(|w| f.value(black_box(*w))).sum::<f64>());
}

#[divan::bench(args = [8, 16, 32, 64, 128])]
fn value_and_gradient(bencher: Bencher, lmax: usize) {
    let (f, directions) = (series(lmax), directions());
    bencher
        .counter(ItemsCount::new(directions.len()))
        .bench_local(|| directions.iter().map(|w| f.jet(black_box(*w)).gradient.x).sum::<f64>());
}
