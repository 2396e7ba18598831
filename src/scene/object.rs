//! A named surface with its materials, and what it takes to start walks on it.

use std::sync::Arc;

use crate::surface::{Hit, SampleArea, Surface};

use super::Material;

/// Places a surface with its materials in a scene.
#[derive(Clone)]
pub struct Object {
    /// The name in the scene file; reports use it.
    pub name: String,
    /// What rays meet.
    pub surface: Arc<dyn Surface>,
    /// The same surface as something that can be sampled by area; needed when a material emits.
    pub area: Option<Arc<dyn SampleArea>>,
    /// One material for all, or one for each part of the surface.
    pub materials: Vec<Material>,
}

impl Object {
    /// Makes an object that can be sampled by area, all of one material.
    pub fn new<S: SampleArea + 'static>(name: &str, surface: S, material: Material) -> Self {
        let shared = Arc::new(surface);
        Self {
            name: name.to_owned(),
            surface: shared.clone(),
            area: Some(shared),
            materials: vec![material],
        }
    }

    /// Returns the material at a hit.
    pub fn material(&self, hit: &Hit) -> &Material {
        let part = (hit.part as usize).min(self.materials.len() - 1);
        &self.materials[part]
    }

    /// Whether any of its materials emits.
    pub fn emits(&self) -> bool {
        self.materials.iter().any(|m| !m.exitance.is_black())
    }
}

/// An object whose surface emits: where walks may start.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Emitter {
    /// The index of the object in the scene.
    pub object: usize,
    /// The largest exitance times the area: the power with which the emitter is picked, lm.
    pub power: f64,
}
