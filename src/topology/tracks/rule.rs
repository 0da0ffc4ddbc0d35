//! The options of a tracker: which dots begin tracks, and its hysteresis.
//!
//! In: nothing.
//! Out: the options.
//! Must not know: how tracks are found.

use std::num::NonZeroU32;

use crate::topology::skeleton::ViewSpec;

/// Which dots begin tracks.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum TrackRule {
    /// The dots of a view.
    View(ViewSpec),
    /// The most persistent dots, up to this number.
    Top(NonZeroU32),
    /// The dots of at least this persistence.
    Above(f64),
}

/// How long a track that is missing is remembered.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Remember {
    /// For this number of frames.
    Frames(u64),
    /// For this length of event time. Frames without a time count as none.
    Time(f64),
}

/// What is tracked, and with which hysteresis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TrackOptions {
    /// Which dots begin tracks.
    pub rule: TrackRule,
    /// The number of consecutive frames in which a dot has to be selected before its track is announced, or reported as
    /// selected again.
    pub confirm: NonZeroU32,
    /// The number of consecutive frames in which a dot has to be missing before its track ends, or not selected before
    /// that is reported.
    pub miss: NonZeroU32,
    /// How long a track is remembered that has to end because its dot is missing. Until then it counts as not selected.
    /// If a selected dot of like radius and persistence comes to where its hole is expected, the track goes on.
    pub remember: Remember,
    /// Changes of centre, birth and death up to this are not reported. A length.
    pub delta: f64,
}

impl TrackOptions {
    /// A rule with two frames to confirm, two to miss, nothing remembered, and every change reported.
    pub fn new(rule: TrackRule) -> Self {
        let two = NonZeroU32::MIN.saturating_add(1);
        Self { rule, confirm: two, miss: two, remember: Remember::Frames(0), delta: 0.0 }
    }
}
