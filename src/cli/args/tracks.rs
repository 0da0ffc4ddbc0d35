//! Options of tracks: which persistent cycles are followed over time.
//!
//! In: words of the command line.
//! Out: the core's options.
//! Must not know: input and output.

use std::num::NonZeroU32;

use clap::Args;
use hopes::topology::{Remember, TrackOptions, TrackRule, ViewSpec};

use super::values::{at_least_one, remember, scale};

/// Which persistent cycles are followed over time.
#[derive(Clone, Copy, Debug, Args)]
#[command(next_help_heading = "Tracks")]
pub struct TrackArgs {
    /// Follow persistent cycles over frames, each under an id that lasts: view, top:M or above:P.
    ///
    /// It says which dots begin tracks: those of the view (-k, -l, --alpha, --full), the M most persistent, or those of
    /// a persistence of at least P. At most 8192 at a time; a warning says how many more there would be.
    #[arg(long, value_name = "WHICH", value_parser = track)]
    track: Option<TrackWord>,
    /// Announce a track when its dot was selected in N frames on end.
    #[arg(long, value_name = "N", default_value = "2", value_parser = at_least_one, requires = "track")]
    track_confirm: NonZeroU32,
    /// End a track when its dot was missing in N frames on end.
    ///
    /// A dot that is no longer selected stays its track's down to half of the persistence that it had when it last was.
    #[arg(long, value_name = "N", default_value = "2", value_parser = at_least_one, requires = "track")]
    track_miss: NonZeroU32,
    /// Remember a track that would end for N frames (or frames:N) or a length of event time (time:T).
    ///
    /// It is unselected meanwhile. If a dot of like radius and persistence comes to where its hole is expected, it is
    /// reselected under its old id. Frames of a stream without times count as none of a length of time.
    #[arg(long, value_name = "T", default_value = "0", value_parser = remember, requires = "track")]
    track_remember: Remember,
    /// Report changes of a track's centre, birth and death only beyond DELTA (a length).
    #[arg(long, value_name = "DELTA", default_value = "0", value_parser = scale, requires = "track")]
    track_delta: f64,
}

impl TrackArgs {
    /// What they ask for, beside a view.
    pub fn options(self, view: ViewSpec) -> Option<TrackOptions> {
        let rule = match self.track? {
            TrackWord::View => TrackRule::View(view),
            TrackWord::Rule(rule) => rule,
        };
        let (confirm, miss, delta) = (self.track_confirm, self.track_miss, self.track_delta);
        Some(TrackOptions { rule, confirm, miss, remember: self.track_remember, delta })
    }
}

/// What is tracked, in a word.
#[derive(Clone, Copy, Debug, PartialEq)]
enum TrackWord {
    View,
    Rule(TrackRule),
}

fn track(word: &str) -> Result<TrackWord, String> {
    let refused = || format!("{word:?} is none of view, top:M (M from 1) and above:P (a persistence above 0)");
    let above = |value: &str| value.parse::<f64>().ok().filter(|least| least.is_finite() && *least > 0.0);
    match word.split_once(':') {
        None if word == "view" => Ok(TrackWord::View),
        Some(("top", most)) => most.parse().map(|most| TrackWord::Rule(TrackRule::Top(most))).map_err(|_| refused()),
        Some(("above", least)) => {
            above(least).map(|least| TrackWord::Rule(TrackRule::Above(least))).ok_or_else(refused)
        }
        _ => Err(refused()),
    }
}
