//! Files of rays and of distances: little-endian f32.

use std::fs;
use std::path::Path;

use glam::DVec3;
use harmolux::math::Ray;

use super::Outcome;

/// The bytes of a ray: origin and direction.
const RAY: usize = 24;

/// Reads rays; their directions, unit to f32, are made unit to f64.
pub(super) fn read(path: &Path) -> Outcome<Vec<Ray>> {
    let bytes = fs::read(path).map_err(|error| format!("{}: {error}", path.display()))?;
    if bytes.is_empty() || !bytes.len().is_multiple_of(RAY) {
        return Err(format!(
            "{}: {} bytes, not some rays of {RAY} bytes each; a ray is six little-endian f32, \
             origin and unit direction (--make writes such files)",
            path.display(),
            bytes.len()
        )
        .into());
    }
    let rays = bytes.chunks_exact(RAY).enumerate();
    let rays = rays.map(|(number, ray)| {
        decode(ray).ok_or_else(|| {
            format!(
                "{}: ray {number} (from 0) has an origin or a direction that is not finite, or no \
                 direction; remove it",
                path.display()
            )
            .into()
        })
    });
    rays.collect()
}

fn decode(bytes: &[u8]) -> Option<Ray> {
    let mut values = [0.0; 6];
    for (value, bytes) in values.iter_mut().zip(bytes.chunks_exact(4)) {
        *value = f64::from(f32::from_le_bytes(bytes.try_into().ok()?));
    }
    let [x, y, z, dx, dy, dz] = values;
    let (origin, direction) = (DVec3::new(x, y, z), DVec3::new(dx, dy, dz));
    (origin.is_finite() && direction.is_finite())
        .then(|| direction.try_normalize().map(|unit| Ray::new(origin, unit)))
        .flatten()
}

/// Writes rays.
pub(super) fn write(path: &Path, rays: &[Ray]) -> Outcome<()> {
    let numbers =
        rays.iter().flat_map(|ray| [ray.origin, ray.direction]).flat_map(|v| v.to_array());
    write_numbers(path, numbers)
}

/// Writes distances, infinite for a miss.
pub(super) fn write_distances(path: &Path, distances: &[f64]) -> Outcome<()> {
    write_numbers(path, distances.iter().copied())
}

fn write_numbers(path: &Path, numbers: impl Iterator<Item = f64>) -> Outcome<()> {
    let bytes: Vec<u8> = numbers.flat_map(|x| (x as f32).to_le_bytes()).collect();
    fs::write(path, bytes).map_err(|error| format!("{}: {error}", path.display()).into())
}
