//! Rays against a shape of spherical harmonics: distances, normals and error bounds.
//!
//!     cargo run --release --example rays

use glam::DVec3;
use harmolux::Result;
use harmolux::math::Ray;
use harmolux::sh::Coefficients;
use harmolux::surface::{Intersector, ShSurface, Surface};

fn main() -> Result<()> {
    // A radius in metres, as a series: a sphere, longer along z, with three lobes about z.
    let mut radius = Coefficients::zeros(3);
    radius.set(0, 0, 1.0, 0.0);
    radius.set(2, 0, 0.2, 0.0);
    radius.set(3, 3, 0.3, 0.0); // degree, order, cosine part, sine part

    // The default intersector builds patches with certified error bounds: no ray misses.
    let shape = ShSurface::new(&radius, Intersector::default())?;
    let (lowest, highest) = (shape.bounds().min, shape.bounds().max);
    println!("within {lowest:.3} to {highest:.3} m");

    // A row of rays straight down from a height of 5 m.
    for i in -4..=4 {
        let x = 0.4 * f64::from(i);
        let ray = Ray::new(DVec3::new(x, 0.0, 5.0), DVec3::NEG_Z);
        match shape.hit(&ray) {
            // A hit lies within `error` of the surface; its normal points outward.
            Some(hit) => println!(
                "x = {x:4.1}: {:.6} m, normal {:.3}, error {:.0e} m",
                hit.distance, hit.normal, hit.error
            ),
            None => println!("x = {x:4.1}: no hit"),
        }
    }

    // Whether anything is in the way between two points is a question of its own, and faster.
    let shadow = Ray::between(DVec3::new(0.0, 0.0, 5.0), DVec3::new(0.0, 0.0, -5.0));
    println!("blocked: {}", shadow.is_some_and(|ray| shape.blocked(&ray)));
    Ok(())
}
