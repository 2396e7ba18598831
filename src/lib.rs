//! Spherical-harmonic shapes, and light in rooms.
//!
//! Harmolux fits the radius of a star-shaped mesh by a series of spherical harmonics, and traces
//! rays against that series. It computes what is known of a shape from its coefficients: volume,
//! area, rotation, spectrum, distance. It estimates illuminance and luminance in scenes of such
//! shapes, meshes and primitives by Monte Carlo local estimates, each with its standard error.
//! The tool `harmolux` is built on this library.
//!
//! A mesh becomes coefficients, these a surface, and a ray meets it:
//!
//! ```
//! use std::path::Path;
//!
//! use glam::DVec3;
//! use harmolux::fit::{FitSettings, fit};
//! use harmolux::io::meshes;
//! use harmolux::math::Ray;
//! use harmolux::surface::{Intersector, ShSurface, Surface};
//!
//! let mesh = meshes::read(Path::new("data/head.obj"))?;
//! let head = fit(&mesh, &FitSettings::of_degree(8))?;
//! assert_eq!(head.coefficients.count(), 81);
//! assert!(head.relative_rms() <= 0.02); // relative to the mean radius
//!
//! let surface = ShSurface::new(&head.coefficients, Intersector::default())?;
//! let ray = Ray::new(DVec3::new(1.0, 0.0, 0.0), DVec3::NEG_X);
//! let hit = surface.hit(&ray).expect("the ray goes through the centre");
//! assert!(hit.distance > 0.8 && hit.distance < 1.0); // metres
//! assert!(hit.normal.dot(ray.direction) < 0.0); // the outer side
//! # Ok::<(), harmolux::Error>(())
//! ```
//!
//! `examples/` has three programs to start from: `mesh_to_coefficients`, `rays` and `room`.
//!
//! # Conventions
//!
//! * Axes are right-handed with z up. Lengths are metres, angles radians.
//! * Units are photometric: flux lm, intensity cd, illuminance lx, luminance cd/m2, exitance lm/m2.
//!   Colours are linear Rec. 709 triples ([`math::Rgb`]) whose luminance carries the unit.
//! * The basis is Schmidt semi-normalised, with the Condon-Shortley phase: degree l, order m from 0
//!   to l, a cosine and a sine part. `lmax` is the largest degree of a series, which has
//!   (lmax + 1)^2 real coefficients. `docs/how/conventions.md` has the formulas.
//! * Every random estimate is the mean of [`estimators::REPLICATES`] independent replicates. The
//!   same seed gives the same result on any number of threads.
//! * A miss is `None`; an [`Error`] says what is wrong, where, and how to go on. The library does
//!   not print and does not exit.
//!
//! # Rooms
//!
//! Each module is a room that may name only some of the others. `docs/how/architecture.md` has the
//! arrows, and `tests/shapes/rooms.rs` holds the sources to them.
//!
//! * [`math`]: rays, boxes, frames, placements, quadrature, sampling, random streams, statistics.
//! * [`sh`]: conventions, series, grids, transforms, bounds, rotation, integrals, random shapes.
//! * [`mesh`]: triangle meshes, reports of their faults, repair, distances.
//! * [`surface`]: the trait [`surface::Surface`] and all that implement it.
//! * [`fit`]: from meshes and points to coefficients, the error of that, and back to meshes.
//! * [`scene`]: objects, materials, lights, cameras, sensors, the film.
//! * [`estimators`]: walks, the local and the double local estimate, path tracing, two baselines.
//! * [`exact`]: closed forms that the estimators are tested against.
//! * [`plots`]: curves and false colours, as SVG, PNG or text.
//! * [`io`]: files of meshes, coefficients, scenes, images and tables.
//! * [`study`]: what needs several rooms: loading a scene, comparing shapes.
//!
//! [`error`] and [`memory`], what is free of it, are open to all.

pub mod error;
pub mod estimators;
pub mod exact;
pub mod fit;
pub mod io;
pub mod math;
pub mod memory;
pub mod mesh;
#[cfg(feature = "plots")]
pub mod plots;
pub mod scene;
pub mod sh;
pub mod study;
pub mod surface;

pub use error::{Error, Result};

/// Tests the Rust of the book.
#[cfg(doctest)]
#[doc = include_str!("../docs/reference/api.md")]
mod book {}
