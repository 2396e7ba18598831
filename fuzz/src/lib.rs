//! What the fuzz targets share: one call for each reader, under a bound on the memory it may take,
//! and one for rays.
//!
//! A reader may refuse what it is given, and must do nothing else: not panic, not run without end,
//! not allocate more than a constant and a multiple of the number of bytes. Past that bound the
//! allocator fails, which ends the process, which is a finding.

use std::alloc::System;
use std::path::Path;
use std::sync::OnceLock;

use cap::Cap;
use glam::DVec3;
use harmolux::io::coefficients::{ReadOptions, SeriesFormat, binary, compact, parse};
use harmolux::fit::Shape;
use harmolux::io::{meshes, scene_file::SceneFile};
use harmolux::math::Ray;
use harmolux::sh::{Coefficients, Convention};
use harmolux::surface::{Intersector, ShSurface, StepBisection, Surface};

#[global_allocator]
static ALLOCATOR: Cap<System> = Cap::new(System, usize::MAX);

/// What a reader may allocate whatever it reads, bytes: buffers, and tables that are built once.
const CONSTANT: usize = 256 * 1024;

/// What it may allocate more for each byte: the compact form has 64 coefficients in a byte at most,
/// of 8 bytes each, in up to four places; the other readers stay below 200.
const PER_BYTE: usize = 2048;
const PER_BYTE_OF_OTHERS: usize = 256;

/// Runs a reader with the memory that `per_byte` allows.
fn bounded(data: &[u8], per_byte: usize, read: impl FnOnce(&[u8])) {
    let bound = ALLOCATOR.allocated() + CONSTANT + per_byte * data.len();
    ALLOCATOR.set_limit(bound).expect("a bound above what is allocated now");
    read(data);
    ALLOCATOR.set_limit(usize::MAX).expect("no bound");
}

/// Reads a mesh.
pub fn mesh(name: &str, data: &[u8]) {
    bounded(data, PER_BYTE_OF_OTHERS, |data| drop(meshes::parse(Path::new(name), data)));
}

/// Reads a coefficient file of a format, with a convention and without.
pub fn series(format: SeriesFormat, data: &[u8]) {
    for convention in [None, Some(Convention::default())] {
        let options = ReadOptions { format: Some(format), convention, ..ReadOptions::default() };
        bounded(data, PER_BYTE_OF_OTHERS, |data| {
            if let Ok(shape) = parse(Path::new("shape"), data, &options) {
                check(&shape);
            }
        });
    }
}

/// Reads a binary file as it is and with its checksums put right, whole and cut; what is read whole
/// is written as it was.
pub fn binary(data: &[u8]) {
    let path = Path::new("shape.hxb");
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
pub fn compact(data: &[u8]) {
    let path = Path::new("shape.hxc");
    let sealed = [data, &crc32fast::hash(data).to_le_bytes()].concat();
    for data in [data, &sealed] {
        bounded(data, PER_BYTE, |data| {
            if let Ok(shape) = compact::parse(path, data) {
                check(&shape);
            }
        });
    }
}

/// Reads a scene.
pub fn scene(data: &[u8]) {
    let Ok(text) = std::str::from_utf8(data) else { return };
    bounded(data, PER_BYTE, |_| drop(SceneFile::parse(Path::new("scene.toml"), text, &[])));
}

/// Asks a sphere and a bumpy body what rays of any bits hit, one by one and as a batch, by every
/// intersector.
pub fn rays(data: &[u8]) {
    static SURFACES: OnceLock<Vec<ShSurface>> = OnceLock::new();
    let rays: Vec<Ray> = data.as_chunks::<64>().0.iter().filter_map(ray).collect();
    for surface in SURFACES.get_or_init(surfaces) {
        let single: Vec<_> = rays.iter().map(|ray| surface.hit(ray)).collect();
        let mut batch = vec![None; rays.len()];
        surface.hits(&rays, &mut batch);
        assert_eq!(single, batch);
        let mut marks = vec![false; rays.len()];
        surface.mark_blocked(&rays, &mut marks);
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

/// Checks what every shape promises.
fn check(shape: &Shape) {
    let mut numbers = shape.coefficients.cosines().iter().chain(shape.coefficients.sines());
    assert!(numbers.all(|x| x.is_finite()) && shape.centre.is_finite());
}
