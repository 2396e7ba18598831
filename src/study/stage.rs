//! What the loading of a scene is at.

use std::fmt;

use crate::error::shown;

/// Names the work that begins, for whoever watches a scene being loaded.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LoadingStage<'a> {
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
pub type LoadingObserver<'a> = &'a (dyn Fn(LoadingStage) + Sync);

impl fmt::Display for LoadingStage<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Reading(name) => write!(f, "reading and fitting `{}`", shown(name)),
            Self::Preparing(name) => write!(f, "preparing `{}` for rays", shown(name)),
            Self::LayingOut(name) => write!(f, "laying out sensors `{}`", shown(name)),
            Self::Checking => write!(f, "checking the scene"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_do_not_steer_a_terminal() {
        for (stage, text) in [
            (LoadingStage::Reading("a\x1b[2J"), r"reading and fitting `a\u{1b}[2J`"),
            (LoadingStage::Preparing("a\nb"), r"preparing `a\nb` for rays"),
            (LoadingStage::LayingOut("\u{202e}"), r"laying out sensors `\u{202e}`"),
            (LoadingStage::Checking, "checking the scene"),
        ] {
            assert_eq!(stage.to_string(), text);
        }
    }
}
