//! What is lit and looked at: objects, materials, lights, cameras, sensors, the film.

mod camera;
mod film;
mod filter;
mod glossy;
mod index;
mod layers;
mod light;
mod material;
mod object;
mod sensor;
mod world;

pub use camera::{Camera, FisheyeMapping, Projection, Window};
pub use film::{Film, MAX_PIXELS, Pixel};
pub use filter::Filter;
pub use glossy::{Glossy, SMOOTHEST};
pub use layers::{FirstHits, Layer};
pub use light::{Distribution, PointLight};
pub use material::{Brdf, BrdfSample, Material};
pub use object::{Emitter, Object};
pub use sensor::{Measure, Measured, Sensor};
pub use world::{Scene, Vertex};
