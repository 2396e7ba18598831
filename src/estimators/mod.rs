//! How light is estimated: walks from the lights, the local and the double local estimate, path
//! tracing as the reference, radiosity and the counting of photons as the baselines.

mod candidates;
mod cloud;
mod connect;
mod contour;
mod direct;
mod effort;
mod estimator;
mod gather;
mod groups;
mod image;
mod integrator;
mod known_lights;
mod local;
mod luminance;
mod path;
mod photon;
mod radiosity;
mod receiver;
mod replicates;
mod results;
mod survey;
mod walk;
mod weighting;

pub use estimator::{Estimator, MAX_PATCHES, RadiositySettings, SensorSettings};
pub use groups::{Bracket, GroupSummary};
pub use image::{
    Checkpointer, ImageSettings, Rendering, SHARE_WITHIN, render, resume, walks_per_sample,
};
pub use luminance::luminance;
pub use receiver::Receiver;
pub use replicates::{Ending, Observer, Progress, REPLICATES, Stop};
pub use results::{Exchange, Survey};
pub use survey::illuminance;
pub use walk::{Launcher, Node};
pub use weighting::Weighting;

pub use crate::scene::SplitLight;
