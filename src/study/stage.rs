//! What the loading of a scene is at.

use std::fmt;

/// Names the work that begins, for whoever watches a scene being loaded.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Stage<'a> {
    /// The file of an object is read, and fitted where it is a mesh that stands for a series.
    Reading(&'a str),
    /// The surface of an object is prepared for rays.
    Preparing(&'a str),
    /// The sensors of a group are laid out.
    LayingOut(&'a str),
    /// What is probably not meant is looked for.
    Checking,
}

/// Is told of each stage as it begins.
pub type StageObserver<'a> = &'a (dyn Fn(Stage) + Sync);

impl fmt::Display for Stage<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Reading(name) => write!(f, "reading and fitting `{name}`"),
            Self::Preparing(name) => write!(f, "preparing `{name}` for rays"),
            Self::LayingOut(name) => write!(f, "laying out sensors `{name}`"),
            Self::Checking => write!(f, "checking the scene"),
        }
    }
}
