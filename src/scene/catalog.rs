//! The kinds of scenes of all families, by name.
//!
//! In: names.
//! Out: kinds, and what is said of each.
//! Invariants: each name stands for one kind.
//! Must not know: how scenes are made.

use std::str::FromStr;

use thiserror::Error;

use super::Kind;
use super::signal::SignalKind;
use super::space::SpaceKind;

/// A kind of scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AnyKind {
    /// In the plane.
    Plane(Kind),
    /// In R^d.
    Space(SpaceKind),
    /// A series of numbers.
    Signal(SignalKind),
}

/// A scene of this name does not exist.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[error("there is no scene {found:?}{among}: choose one of {}", choices.join(", "))]
pub struct UnknownScene {
    /// The name.
    pub found: String,
    /// In which family it was looked for, with a blank before. Empty: in all.
    among: &'static str,
    choices: Vec<String>,
}

impl AnyKind {
    /// Every kind, by family.
    pub fn all() -> [Vec<Self>; 3] {
        [
            Kind::ALL.map(Self::Plane).to_vec(),
            SpaceKind::ALL.map(Self::Space).to_vec(),
            SignalKind::ALL.map(Self::Signal).to_vec(),
        ]
    }

    /// The name of the kind.
    pub fn name(self) -> String {
        match self {
            Self::Plane(kind) => kind.name().to_owned(),
            Self::Space(kind) => kind.name(),
            Self::Signal(kind) => kind.name().to_owned(),
        }
    }

    /// A description of one line.
    pub fn about(self) -> &'static str {
        match self {
            Self::Plane(kind) => kind.about(),
            Self::Space(kind) => kind.about(),
            Self::Signal(kind) => kind.about(),
        }
    }
}

impl UnknownScene {
    fn new(found: &str, among: &'static str, choices: Vec<String>) -> Self {
        Self { found: found.chars().take(40).collect(), among, choices }
    }
}

impl FromStr for Kind {
    type Err = UnknownScene;

    fn from_str(word: &str) -> Result<Self, UnknownScene> {
        let names = || Self::ALL.map(|kind| kind.name().to_owned()).to_vec();
        let kind = Self::ALL.into_iter().find(|kind| kind.name() == word);
        kind.ok_or_else(|| UnknownScene::new(word, " in the plane", names()))
    }
}

impl FromStr for AnyKind {
    type Err = UnknownScene;

    fn from_str(word: &str) -> Result<Self, UnknownScene> {
        let all = Self::all().concat();
        let named = all.iter().copied().find(|kind| kind.name() == word);
        let found = named.or_else(|| SpaceKind::with_dimension(word).map(Self::Space));
        found.ok_or_else(|| UnknownScene::new(word, "", all.iter().map(|kind| kind.name()).collect()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scenes_have_names() {
        for kind in AnyKind::all().concat() {
            assert_eq!(kind.name().parse(), Ok(kind));
            assert!(!kind.about().is_empty());
        }
        for kind in Kind::ALL {
            assert_eq!(kind.name().parse(), Ok(kind));
        }
        assert_eq!("cube:7".parse(), Ok(AnyKind::Space(SpaceKind::Cube(7))));
        assert_eq!("delay:2".parse(), Ok(AnyKind::Space(SpaceKind::Delay(2))));
    }

    #[test]
    fn unknown_names_are_refused_with_all_choices() {
        let plane = "torus".parse::<Kind>().unwrap_err().to_string();
        assert!(plane.starts_with("there is no scene \"torus\" in the plane: choose one of drift, static"), "{plane}");
        for word in ["pinched", "cube", "cube:0", "cube:4097", "cube:+3", "delay:1", "delay:101", "torus:3"] {
            let error = word.parse::<AnyKind>().unwrap_err().to_string();
            let begin = format!("there is no scene \"{word}\": choose one of drift, static, pinch, fuse");
            assert!(error.starts_with(&begin) && error.ends_with("gait, sine"), "{error}");
        }
    }
}
