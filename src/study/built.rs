//! An object of a scene, built, with what is known of it.

use std::sync::Arc;

use super::detail::Detail;
use super::on_surface::Form;
use super::solids::Body;
use crate::fit::Fit;
use crate::scene::Object;

/// An object with what the checks need to know of it.
pub(super) struct Built {
    pub(super) object: Object,
    pub(super) body: Body,
    pub(super) form: Form,
    pub(super) fit: Option<Arc<Fit>>,
    pub(super) detail: Option<Detail>,
    /// What is wrong with the mesh it was made of.
    pub(super) deficiencies: Arc<[String]>,
}

impl Built {
    /// Holds an object of which no more is known.
    pub(super) fn new(object: Object, body: Body) -> Self {
        let deficiencies = Arc::default();
        Self { object, body, form: Form::Plain, fit: None, detail: None, deficiencies }
    }
}
