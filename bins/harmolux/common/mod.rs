//! What several verbs share.

pub(crate) mod about;
pub(crate) mod advice;
pub(crate) mod exit;
pub(crate) mod flags;
pub(crate) mod folders;
pub(crate) mod growing;
pub(crate) mod idle;
pub(crate) mod inputs;
pub(crate) mod interrupt;
pub(crate) mod measures;
pub(crate) mod paths;
pub(crate) mod plot;
pub(crate) mod progress;
pub(crate) mod repairs;
pub(crate) mod resources;
pub(crate) mod say;
pub(crate) mod scenes;
pub(crate) mod shape_file;
pub(crate) mod subject;
pub(crate) mod surveys;
pub(crate) mod target;
pub(crate) mod values;
