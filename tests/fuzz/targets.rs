//! What fuzzing asks: a target for each reader, one for rays, and chains of what is done with what
//! was read. The folder `fuzz` and the short fuzz of the test suite share them.
//!
//! A reader may refuse what it is given, and must do nothing else: not panic, not run without end,
//! not allocate more than a constant and a multiple of the number of bytes. Past that bound the
//! allocator fails, which ends the process, which is a finding.

use std::path::Path;
use std::sync::OnceLock;

use glam::DVec3;
use harmolux::fit::{Check, CheckSettings, FitSettings, Shape, fit, fit_points};
use harmolux::io::checkpoint::{self, Fingerprint};
use harmolux::io::coefficients::compact::Tolerance;
use harmolux::io::coefficients::{
    ReadOptions, SeriesFormat, WriteOptions, binary, compact, encode, parse, shape_table,
};
use harmolux::io::images::Exr;
use harmolux::io::points::{self, PointOptions};
use harmolux::io::scene_file::SceneFile;
use harmolux::io::{directions, meshes, rays, sensor_table, spectra};
use harmolux::math::Ray;
use harmolux::sh::{Coefficients, Convention};
use harmolux::surface::{Intersector, ShSurface, StepBisection, Surface};

use crate::ALLOCATOR;

/// What a reader may allocate whatever it reads, bytes: buffers, and tables that are built once.
const CONSTANT: usize = 256 * 1024;

/// What it may allocate more for each byte: the compact form has 64 coefficients in a byte at most,
/// of 8 bytes each, in up to four places; the other readers stay below 200.
const PER_BYTE: usize = 2048;
const PER_BYTE_OF_OTHERS: usize = 256;

/// Names a target, how many inputs the test suite gives it, and what it does with some bytes.
pub(crate) type Target = (&'static str, u64, fn(&[u8]));

/// How many inputs are given to what takes microseconds, and how many to chains, which take
/// milliseconds.
const QUICK: u64 = 16_000;
const CHAINS: u64 = 800;

/// All targets.
pub(crate) const TARGETS: [Target; 27] = [
    ("obj", QUICK, |data| mesh("mesh.obj", data)),
    ("ply", QUICK, |data| mesh("mesh.ply", data)),
    ("stl", QUICK, |data| mesh("mesh.stl", data)),
    ("off", QUICK, |data| mesh("mesh.off", data)),
    ("gltf", QUICK, |data| mesh("mesh.gltf", data)),
    ("text", QUICK, |data| series(SeriesFormat::Text, data)),
    ("dov", QUICK, |data| series(SeriesFormat::Dov, data)),
    ("bshc", QUICK, |data| series(SeriesFormat::Bshc, data)),
    ("npy", QUICK, |data| series(SeriesFormat::Npy, data)),
    ("alm", QUICK, |data| series(SeriesFormat::Alm, data)),
    ("fits", QUICK, |data| series(SeriesFormat::Fits, data)),
    ("spharm_pdm", QUICK, |data| series(SeriesFormat::SpharmPdm, data)),
    ("aics", QUICK, |data| series(SeriesFormat::Aics, data)),
    ("shadr", QUICK, |data| series(SeriesFormat::Shadr, data)),
    ("icgem", QUICK, |data| series(SeriesFormat::Icgem, data)),
    ("binary", QUICK, in_binary),
    ("compact", QUICK, in_compact),
    ("scene", QUICK, scene),
    ("points", QUICK, in_points),
    ("csv", QUICK, tables),
    ("probe", QUICK, probe),
    ("exr", QUICK, |data| bounded(data, PER_BYTE, |data| drop(Exr::from_bytes(at("a.exr"), data)))),
    ("checkpoint", QUICK, in_checkpoint),
    ("rays", QUICK, rays_of_any_bits),
    ("mesh_to_fit", CHAINS, mesh_to_fit),
    ("series_to_rays", CHAINS, series_to_rays),
    ("table", QUICK, in_table),
];

fn at(name: &str) -> &Path {
    Path::new(name)
}

/// Runs a reader with the memory that `per_byte` allows.
fn bounded(data: &[u8], per_byte: usize, read: impl FnOnce(&[u8])) {
    let bound = ALLOCATOR.allocated() + CONSTANT + per_byte * data.len();
    ALLOCATOR.set_limit(bound).expect("a bound above what is allocated now");
    read(data);
    ALLOCATOR.set_limit(usize::MAX).expect("no bound");
}

fn mesh(name: &str, data: &[u8]) {
    bounded(data, PER_BYTE_OF_OTHERS, |data| drop(meshes::parse(at(name), data)));
}

/// Reads points, with weights and without.
fn in_points(data: &[u8]) {
    for weights in [false, true] {
        let options = PointOptions { weights };
        bounded(data, PER_BYTE_OF_OTHERS, |data| drop(points::parse(at("a.xyz"), data, options)));
    }
}

/// Reads a coefficient file of a format, with a convention and without.
fn series(format: SeriesFormat, data: &[u8]) {
    for convention in [None, Some(Convention::default())] {
        let options = ReadOptions { format: Some(format), convention, ..ReadOptions::default() };
        bounded(data, PER_BYTE_OF_OTHERS, |data| {
            if let Ok(shape) = parse(at("shape"), data, &options) {
                check(&shape);
            }
        });
    }
}

/// Reads a table of shapes, a row of it and all.
fn in_table(data: &[u8]) {
    series(SeriesFormat::Table, data);
    bounded(data, PER_BYTE_OF_OTHERS, |data| {
        let options = ReadOptions::default();
        let rows = shape_table::parse_all(at("a.csv"), data, SeriesFormat::Table, &options);
        rows.into_iter().flatten().for_each(|(_, shape)| check(&shape));
    });
}

/// Reads a binary file as it is and with its checksums put right, whole and cut; what is read whole
/// is written as it was.
fn in_binary(data: &[u8]) {
    let path = at("shape.hxb");
    let mut sealed = data.to_vec();
    seal_binary(&mut sealed);
    for data in [data, &sealed] {
        bounded(data, PER_BYTE_OF_OTHERS, |data| {
            drop(binary::parse_truncated(path, data, 3));
            if let Ok(shape) = binary::parse(path, data) {
                check(&shape);
                let again = binary::encode(&shape).expect("what was read can be written");
                assert_eq!(binary::parse(path, &again).expect("and read"), shape);
            }
        });
    }
}

/// Puts right the checksum of the header, and of each degree, of what may be a binary file.
fn seal_binary(data: &mut [u8]) {
    let Some(length) = data.get(52..54) else { return };
    let mut end = 54 + usize::from(u16::from_le_bytes([length[0], length[1]]));
    let mut seal = None;
    for l in 0_u32.. {
        let start = if seal.is_none() { 0 } else { end + 4 };
        if seal.is_some() {
            end = start + 8 * (2 * l as usize - 1);
        }
        if data.len() < end + 4 {
            break;
        }
        let mut hasher = crc32fast::Hasher::new();
        if let Some(seal) = seal {
            hasher.update(&u32::to_le_bytes(seal));
            hasher.update(&(l - 1).to_le_bytes());
        }
        hasher.update(&data[start..end]);
        let check = hasher.finalize();
        data[end..end + 4].copy_from_slice(&check.to_le_bytes());
        seal = seal.or(Some(check));
    }
}

/// Reads a compact file as it is and, since no chance finds a checksum, with its checksum put
/// right.
fn in_compact(data: &[u8]) {
    let sealed = [data, &crc32fast::hash(data).to_le_bytes()].concat();
    for data in [data, &sealed] {
        bounded(data, PER_BYTE, |data| {
            if let Ok(shape) = compact::parse(at("shape.hxc"), data) {
                check(&shape);
            }
        });
    }
}

fn scene(data: &[u8]) {
    let Ok(text) = std::str::from_utf8(data) else { return };
    bounded(data, PER_BYTE, |_| drop(SceneFile::parse(at("scene.toml"), text, &[])));
}

/// Reads tables of sensors, of spectra and of directions.
fn tables(data: &[u8]) {
    bounded(data, PER_BYTE_OF_OTHERS, |data| {
        drop(directions::parse(at("a.csv"), data));
        drop(sensor_table::parse(at("a.csv"), data, "illuminance_lx"));
        drop(spectra::parse(at("a.csv"), data));
    });
}

fn probe(data: &[u8]) {
    let Ok(text) = std::str::from_utf8(data) else { return };
    bounded(data, PER_BYTE_OF_OTHERS, |_| drop(rays::parse(at("rays.txt"), text)));
}

/// Reads a checkpoint as it is and with the checksum of its header and of all of it put right.
fn in_checkpoint(data: &[u8]) {
    let present = checkpoint_of();
    for data in [data, &sealed_checkpoint(data)] {
        bounded(data, PER_BYTE_OF_OTHERS, |data| {
            drop(checkpoint::parse(at("a.checkpoint"), data, &present));
        });
    }
}

/// Puts right the checksum of the header, and that of all, of what may be a checkpoint.
fn sealed_checkpoint(data: &[u8]) -> Vec<u8> {
    let mut sealed = data.to_vec();
    let number = |at: usize| {
        data.get(at..at + 4).map(|b| u32::from_le_bytes([b[0], b[1], b[2], b[3]]) as usize)
    };
    // Magic and version; then the number of fields, two texts each; then the rest of the header.
    let mut end = 14;
    for _ in 0..2 * number(10).unwrap_or(0).min(64) {
        end += 4 + number(end).unwrap_or(0).min(data.len());
    }
    for end in [end + 61, data.len().saturating_sub(4)] {
        if sealed.len() >= end + 4 {
            let check = crc32fast::hash(&sealed[..end]);
            sealed[end..end + 4].copy_from_slice(&check.to_le_bytes());
        }
    }
    sealed
}

/// Says what the seeds of checkpoints are of.
pub(crate) fn checkpoint_of() -> Fingerprint {
    Fingerprint::new().with("size", "3 x 2")
}

/// Asks a sphere and a bumpy body what rays of any bits hit, one by one and as a batch, by every
/// intersector.
fn rays_of_any_bits(data: &[u8]) {
    static SURFACES: OnceLock<Vec<ShSurface>> = OnceLock::new();
    let rays: Vec<Ray> = data.as_chunks::<64>().0.iter().filter_map(ray).collect();
    for surface in SURFACES.get_or_init(surfaces) {
        ask(surface, &rays);
    }
}

/// Asks a surface what rays hit, one by one and as a batch.
fn ask(surface: &ShSurface, rays: &[Ray]) {
    let single: Vec<_> = rays.iter().map(|ray| surface.hit(ray)).collect();
    let mut batch = vec![None; rays.len()];
    surface.hits(rays, &mut batch);
    assert_eq!(single, batch);
    let mut marks = vec![false; rays.len()];
    surface.mark_blocked(rays, &mut marks);
    for ((ray, hit), mark) in rays.iter().zip(single).zip(marks) {
        assert_eq!(mark, surface.blocked(ray), "{ray:?}");
        let Some(hit) = hit else { continue };
        for hit in [hit, surface.refine(&hit)] {
            assert!(hit.point.is_finite() && hit.error > 0.0 && hit.error.is_finite(), "{ray:?}");
            assert!((hit.normal.length() - 1.0).abs() <= 1e-12, "{ray:?}");
            assert!(ray.contains(hit.distance), "{ray:?}");
        }
    }
}

/// Takes eight numbers as origin, direction (made a unit vector) and ends of a ray; `None` where
/// that is no direction.
fn ray(bytes: &[u8; 64]) -> Option<Ray> {
    let [x, y, z, u, v, w, t_min, t_max] =
        std::array::from_fn(|i| f64::from_le_bytes(std::array::from_fn(|k| bytes[8 * i + k])));
    let direction = DVec3::new(u, v, w).try_normalize()?;
    Some(Ray { t_min, t_max, ..Ray::new(DVec3::new(x, y, z), direction) })
}

/// Makes a sphere and a body of degree 6, for each intersector.
fn surfaces() -> Vec<ShSurface> {
    let mut body = Coefficients::zeros(6);
    body.set(0, 0, 1.0, 0.0);
    let sphere = body.truncated(0);
    for (l, m) in (1..=6).flat_map(|l| (0..=l).map(move |m| (l, m))) {
        let x = (7 * l + 3 * m) as f64;
        body.set(l, m, 0.3 * x.sin() / (l * l) as f64, 0.3 * x.cos() / (l * l) as f64);
    }
    let march = Intersector::StepBisection(StepBisection { step: 0.2, tolerance: 1e-6 });
    let with = |shape: &Coefficients| {
        [Intersector::Patches, Intersector::Certified, march]
            .map(|intersector| ShSurface::new(shape, intersector).expect("a positive radius"))
    };
    [with(&sphere), with(&body)].concat()
}

/// Reads a mesh of any format, examines it, repairs it, and fits what is star-shaped; its points
/// are fitted too.
fn mesh_to_fit(data: &[u8]) {
    let name = match data.first() {
        Some(b'p') => "mesh.ply",
        Some(b's') => "mesh.stl",
        Some(b'O') => "mesh.off",
        Some(b'{') => "mesh.gltf",
        _ => "mesh.obj",
    };
    let Ok(mesh) = meshes::parse(at(name), data) else { return };
    if let Ok(found) = Check::of(&mesh, &CheckSettings { crossings: true, centre: None }) {
        assert_eq!(found.faults(&mesh).len(), mesh.triangles().len());
    }
    let settings = FitSettings::of_degree(3);
    if let Ok(fit) = fit(&mesh, &settings) {
        check(&Shape::new(fit.coefficients));
    }
    if let Ok(points) = points::parse(at("a.xyz"), data, PointOptions::default())
        && let Ok(fit) = fit_points(&points, &settings)
    {
        check(&Shape::new(fit.coefficients));
    }
}

/// Reads coefficients, writes them in every format and reads them again, and asks the surface a
/// few rays.
fn series_to_rays(data: &[u8]) {
    let options = ReadOptions::default();
    let Ok(shape) = parse(at("shape.sh"), data, &options) else { return };
    check(&shape);
    for format in SeriesFormat::ALL {
        let Ok(bytes) = encode(&shape, format, &WriteOptions::default()) else { continue };
        let options = ReadOptions { format: Some(format), ..ReadOptions::default() };
        if let Ok(again) = parse(at("again"), &bytes, &options) {
            check(&again);
        }
    }
    drop(compact::encode(&shape, Tolerance::OfMeanRadius(1e-3)));
    let c = shape.coefficients.truncated(shape.coefficients.lmax().min(8));
    let Ok(surface) = ShSurface::new(&c, Intersector::Patches) else { return };
    let from = 3.0 * surface.bounds().max.abs().max_element() * DVec3::new(0.6, 0.8, 0.1);
    let towards = [-DVec3::new(0.6, 0.8, 0.1), DVec3::X, -DVec3::Y];
    ask(&surface, &towards.map(|d| Ray::new(from, d.normalize())));
}

/// Checks what every shape promises.
fn check(shape: &Shape) {
    let mut numbers = shape.coefficients.cosines().iter().chain(shape.coefficients.sines());
    assert!(numbers.all(|x| x.is_finite()) && shape.centre.is_finite());
}
