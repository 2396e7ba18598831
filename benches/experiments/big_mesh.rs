//! Shows what ten million triangles take: makes them as a file of each format, reads it, examines
//! it and tests it for star shape, each in a process of its own, and prints the peak of its memory
//! beside that of the mesh (24 B a vertex, 12 B a face). OBJ takes most, while tobj parses it.
//!
//!     cargo run --release --features experiments --example big_mesh
//!
//! On Linux, with 0.6 GB of disk and 2.3 GB of memory; for a tenth of it:
//!
//!     cargo run --release --features experiments --example big_mesh -- 0.1

use std::error::Error;
use std::f64::consts::{PI, TAU};
use std::fs::{self, File};
use std::io::{BufWriter, Write};
use std::path::Path;
use std::process::Command;
use std::time::Instant;

use glam::DVec3;
use harmolux::fit::star;
use harmolux::io::meshes;
use harmolux::mesh::MeshReport;

type Outcome<T> = Result<T, Box<dyn Error>>;

fn main() -> Outcome<()> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    if let [verb, path] = &arguments[..]
        && verb == "examine"
    {
        return examine(Path::new(path));
    }
    let share: f64 = arguments.first().map_or(Ok(1.0), |text| text.parse())?;
    let ball = Ball::new(share);
    let folder = tempfile::tempdir()?;
    println!(
        "| file | bytes | read, s | report, s | star, s | peak after each, MB | mesh, MB | peak / \
         mesh |"
    );
    println!("|---|---|---|---|---|---|---|---|");
    for extension in ["ply", "stl", "obj"] {
        let path = folder.path().join("ball").with_extension(extension);
        ball.write(&path, extension)?;
        let done = Command::new(std::env::current_exe()?).arg("examine").arg(&path).status()?;
        if !done.success() {
            return Err(format!("{extension}: {done}").into());
        }
        fs::remove_file(&path)?;
    }
    Ok(())
}

/// Reads and examines one file, and prints a line.
fn examine(path: &Path) -> Outcome<()> {
    let started = Instant::now();
    let mesh = meshes::read(path)?;
    let read = (started.elapsed().as_secs_f64(), peak()?);
    let started = Instant::now();
    let report = MeshReport::of(&mesh);
    report.require_closed()?;
    let examined = (started.elapsed().as_secs_f64(), peak()?);
    let started = Instant::now();
    assert!(star::test(&mesh, DVec3::ZERO)?.is_star_shaped());
    let tested = (started.elapsed().as_secs_f64(), peak()?);
    let size = (24 * mesh.positions().len() + 12 * mesh.triangles().len()) as f64;
    println!(
        "| {} faces as {} | {} | {:.1} | {:.1} | {:.1} | {:.0}, {:.0}, {:.0} | {:.0} | {:.2} |",
        report.faces,
        path.extension().unwrap_or_default().display(),
        fs::metadata(path)?.len(),
        read.0,
        examined.0,
        tested.0,
        read.1 / 1e6,
        examined.1 / 1e6,
        tested.1 / 1e6,
        size / 1e6,
        tested.1 / size
    );
    Ok(())
}

/// Returns the most memory this process has had, bytes.
fn peak() -> Outcome<f64> {
    let status = fs::read_to_string("/proc/self/status")?;
    let line = status.lines().find(|l| l.starts_with("VmHWM:")).ok_or("no VmHWM in the status")?;
    let kilobytes: f64 = line.split_whitespace().nth(1).ok_or("VmHWM without a number")?.parse()?;
    Ok(1024.0 * kilobytes)
}

/// A bumpy ball of rings between two poles, made vertex by vertex.
struct Ball {
    rings: u32,
    columns: u32,
}

impl Ball {
    fn new(share: f64) -> Self {
        let scale = share.clamp(1e-4, 10.0).sqrt();
        Self { rings: (2000.0 * scale) as u32, columns: (2500.0 * scale) as u32 }
    }

    fn vertices(&self) -> u32 {
        self.rings * self.columns + 2
    }

    fn faces(&self) -> u32 {
        2 * self.rings * self.columns
    }

    fn vertex(&self, number: u32) -> DVec3 {
        let Some(inner) = number.checked_sub(1).filter(|_| number + 1 < self.vertices()) else {
            return if number == 0 { DVec3::Z } else { DVec3::NEG_Z };
        };
        let theta = PI * f64::from(inner / self.columns + 1) / f64::from(self.rings + 1);
        let phi = TAU * f64::from(inner % self.columns) / f64::from(self.columns);
        let radius = 1.0 + 0.1 * theta.sin().powi(3) * (3.0 * phi).cos();
        radius * DVec3::new(theta.sin() * phi.cos(), theta.sin() * phi.sin(), theta.cos())
    }

    /// Returns face `number`: those at the upper pole, two for each cell between the rings, those
    /// at the lower pole.
    fn face(&self, number: u32) -> [u32; 3] {
        let columns = self.columns;
        let at = |ring: u32, column: u32| 1 + ring * columns + column % columns;
        if number < columns {
            return [0, at(0, number), at(0, number + 1)];
        }
        let inner = number - columns;
        let (cell, half) = (inner / 2, inner % 2);
        let (ring, column) = (cell / columns, cell % columns);
        if ring + 1 < self.rings {
            let (a, b) = (at(ring, column), at(ring, column + 1));
            let (c, d) = (at(ring + 1, column), at(ring + 1, column + 1));
            return if half == 0 { [a, c, d] } else { [a, d, b] };
        }
        let column = number - (self.faces() - columns);
        [self.vertices() - 1, at(self.rings - 1, column + 1), at(self.rings - 1, column)]
    }

    fn write(&self, path: &Path, extension: &str) -> Outcome<()> {
        let mut out = BufWriter::new(File::create(path)?);
        match extension {
            "ply" => self.write_ply(&mut out)?,
            "stl" => self.write_stl(&mut out)?,
            _ => self.write_obj(&mut out)?,
        }
        Ok(out.flush()?)
    }

    fn write_ply(&self, out: &mut impl Write) -> std::io::Result<()> {
        write!(
            out,
            "ply\nformat binary_little_endian 1.0\nelement vertex {}\nproperty double x\n\
             property double y\nproperty double z\nelement face {}\n\
             property list uchar int vertex_indices\nend_header\n",
            self.vertices(),
            self.faces()
        )?;
        for v in 0..self.vertices() {
            self.vertex(v).to_array().iter().try_for_each(|x| out.write_all(&x.to_le_bytes()))?;
        }
        for f in 0..self.faces() {
            out.write_all(&[3])?;
            self.face(f).iter().try_for_each(|v| out.write_all(&v.to_le_bytes()))?;
        }
        Ok(())
    }

    fn write_stl(&self, out: &mut impl Write) -> std::io::Result<()> {
        out.write_all(&[b' '; 80])?;
        out.write_all(&self.faces().to_le_bytes())?;
        for f in 0..self.faces() {
            out.write_all(&[0; 12])?;
            for v in self.face(f) {
                let position = self.vertex(v).as_vec3().to_array();
                position.iter().try_for_each(|x| out.write_all(&x.to_le_bytes()))?;
            }
            out.write_all(&[0; 2])?;
        }
        Ok(())
    }

    fn write_obj(&self, out: &mut impl Write) -> std::io::Result<()> {
        for v in 0..self.vertices() {
            let DVec3 { x, y, z } = self.vertex(v);
            writeln!(out, "v {x:.9} {y:.9} {z:.9}")?;
        }
        for f in 0..self.faces() {
            let [a, b, c] = self.face(f).map(|v| v + 1);
            writeln!(out, "f {a} {b} {c}")?;
        }
        Ok(())
    }
}
