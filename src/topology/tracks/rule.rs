//! Which dots begin tracks, and how patiently they are followed.
//!
//! In: nothing. Out: a tracker's options. Must not know: how tracks are found.

use std::num::NonZeroU32;

use crate::topology::skeleton::ViewSpec;

/// Which dots begin tracks.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum TrackRule {
    /// Those that a view shows.
    View(ViewSpec),
    /// So many, the most persistent ones.
    Top(NonZeroU32),
    /// Those of at least this persistence.
    Above(f64),
}

/// What is followed, and how patiently.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TrackOptions {
    /// Which dots begin tracks.
    pub rule: TrackRule,
    /// In so many frames on end a dot has to be selected before its track is announced, or told to be back in the selection.
    pub confirm: NonZeroU32,
    /// In so many frames on end it has to be missing before its track ends, or is told to be out of the selection.
    pub miss: NonZeroU32,
    /// Changes of centre, birth and death of no more than this are not told. A length.
    pub delta: f64,
}

impl TrackOptions {
    /// By a rule, with two frames to confirm, two to miss, and every change told.
    pub fn new(rule: TrackRule) -> Self {
        let two = NonZeroU32::MIN.saturating_add(1);
        Self { rule, confirm: two, miss: two, delta: 0.0 }
    }
}
