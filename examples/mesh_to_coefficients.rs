//! A mesh becomes coefficients: fits spherical harmonics of degree 32 to the radius of a mesh.
//!
//!     cargo run --release --example mesh_to_coefficients [MESH]

use std::path::PathBuf;

use harmolux::Result;
use harmolux::fit::{FitSettings, fit, mesh_bytes, series_bytes};
use harmolux::io::meshes;

fn main() -> Result<()> {
    // Any OBJ, PLY, STL, OFF or glTF file of a closed mesh.
    let path = std::env::args_os().nth(1).map_or_else(|| "data/head.obj".into(), PathBuf::from);
    let mesh = meshes::read(&path)?;

    // Each ray from the centre must meet the mesh once: its distance is the radius that is fitted.
    // The centre is the origin of the mesh, or a better point where the origin does not serve.
    let fitted = fit(&mesh, &FitSettings::of_degree(32))?;

    // Degree l has 2 l + 1 real coefficients, so that degrees 0 to 32 have 33^2.
    let series = &fitted.coefficients;
    let size = fitted.mesh_size;
    println!("mesh          {} vertices, {} faces, {} B", size[0], size[1], mesh_bytes(size));
    println!("coefficients  {}, {} B", series.count(), series_bytes(series.lmax()));
    println!("centre        {:.4} m", fitted.centre);
    println!("mean radius   {:.4} m", series.mean());

    // The RMS error is taken over all directions, the largest over points of the mesh.
    println!("RMS error     {:.3} % of the mean radius", 100.0 * fitted.relative_rms());
    println!("largest error {:.2} % of the mean radius", 100.0 * fitted.relative_max());
    Ok(())
}
