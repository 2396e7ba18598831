//! What is lit and looked at: objects, materials, lights, cameras, sensors, the film.

mod brdf;
mod camera;
mod display;
mod film;
mod filter;
mod glossy;
mod index;
mod layers;
mod light;
mod material;
mod mixture;
mod object;
mod reflectance;
mod sensor;
mod settle;
mod world;

pub use brdf::{Brdf, BrdfSample};
pub use camera::{Camera, FisheyeMapping, Projection, Window};
pub(crate) use display::ACES;
pub use display::{Display, Exposure, Tone};
pub(crate) use film::MAX_STRIDE_LOG2;
pub use film::{Film, MAX_PIXELS, MIN_RELATIVE_LUMINANCE, SplitLight};
pub use filter::Filter;
pub use glossy::{Glossy, MIN_ROUGHNESS};
pub use layers::{FirstHits, Layer};
pub use light::{Distribution, PointLight};
pub use material::Material;
pub use mixture::Mixture;
pub use object::{Emitter, Object};
pub use sensor::{Measure, Measured, Sensor};
pub use world::{Scene, Vertex};
