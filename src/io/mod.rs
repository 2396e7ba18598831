//! Files in and out. Names scene, surface, sh and math, never the estimators.

pub mod scene_file;
