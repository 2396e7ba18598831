//! Light: the estimators and scenes against exact answers, each other and symmetries.

#[path = "../common/mod.rs"]
mod common;

mod baselines;
mod exact_scenes;
mod light;
mod limits;
mod mirrors;
mod non_finite;
mod strategies;
mod symmetries;
