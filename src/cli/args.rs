//! Arguments that several subcommands share, and the small languages of their values.
//!
//! In: words of the command line. Out: the core's options. Invariants: a value that the core could not use is refused here, with
//! what it may be. Must not know: input and output.

use std::num::{NonZeroU32, NonZeroU64};

use clap::Args;
use hopes::topology::{TrackOptions, TrackRule, ViewSpec, Window};
use hopes_protocol as wire;

use super::Failure;
use crate::client::follow::Subscription;
use crate::daemon::{self, Address};

/// Which part of the skeleton is shown.
#[derive(Clone, Copy, Debug, Args)]
pub struct ViewArgs {
    /// Derived skeleton: take the dots above the lowest of the K widest diagonal gaps.
    #[arg(short, long, default_value = "1", value_name = "K")]
    k: NonZeroU32,
    /// Derived skeleton: cut at the leftmost of the L widest vertical gaps.
    #[arg(short, long, default_value = "1", value_name = "L")]
    l: NonZeroU32,
    /// Reduced skeleton instead: at the scale ALPHA (a radius).
    #[arg(long, value_name = "ALPHA", value_parser = scale, conflicts_with_all = ["k", "l", "full"])]
    alpha: Option<f64>,
    /// The whole skeleton instead: the tree and every critical edge.
    #[arg(long, conflicts_with_all = ["k", "l"])]
    full: bool,
}

impl ViewArgs {
    /// The view they ask for.
    pub fn spec(self) -> ViewSpec {
        match self.alpha {
            Some(alpha) => ViewSpec::Reduced { alpha },
            None if self.full => ViewSpec::Full,
            None => ViewSpec::Derived { k: self.k, l: self.l },
        }
    }
}

/// Which persistent cycles are followed over time.
#[derive(Clone, Copy, Debug, Args)]
#[command(next_help_heading = "Tracks")]
pub struct TrackArgs {
    /// Follow persistent cycles over frames, each under an id that lasts: those of the view, the M most persistent, or those of at least a persistence: view, top:M, above:P.
    #[arg(long, value_name = "WHICH", value_parser = track)]
    track: Option<TrackWord>,
    /// Announce a track when it was selected in N frames on end.
    #[arg(long, value_name = "N", default_value = "2", requires = "track")]
    track_confirm: NonZeroU32,
    /// End a track when it was missing in N frames on end.
    #[arg(long, value_name = "N", default_value = "2", requires = "track")]
    track_miss: NonZeroU32,
    /// Tell of changes of a track's centre, birth and death only if one is larger than DELTA (a length).
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
        Some(TrackOptions { rule, confirm, miss, delta })
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

/// What a consumer asks a daemon for.
#[derive(Clone, Copy, Debug, Args)]
pub struct WireViewArgs {
    #[command(flatten)]
    view: ViewArgs,
    /// Also collapse the view's edges of half-length below RADIUS, the shortest first, keeping all cycles [default: vs, or alpha].
    #[arg(long, value_name = "RADIUS", value_parser = scale, num_args = 0..=1, require_equals = true)]
    simplify: Option<Option<f64>>,
}

impl WireViewArgs {
    /// The view they ask for.
    pub fn view(self) -> Result<wire::View, Failure> {
        let simplify = match (self.simplify, self.view.spec()) {
            (None, _) => wire::Simplify::No,
            (Some(Some(threshold)), _) => wire::Simplify::Below(threshold),
            (Some(None), ViewSpec::Full) => {
                return Err(Failure::Usage("--simplify with --full needs a radius: --simplify=RADIUS"));
            }
            (Some(None), _) => wire::Simplify::AtScale,
        };
        Ok(wire::View { cut: daemon::cut(self.view.spec()), simplify })
    }
}

/// The daemon that a consumer listens to.
#[derive(Clone, Debug, Args)]
pub struct From {
    /// Where the daemon listens: unix:PATH or tcp:HOST:PORT.
    #[arg(long, value_name = "ADDRESS")]
    pub from: Address,
}

/// What a consumer follows, and how far.
#[derive(Clone, Debug, Args)]
pub struct FollowArgs {
    #[command(flatten)]
    from: From,
    /// Name of the stream, or a pattern in which * stands for any characters; it may still be to come.
    #[arg(long, value_name = "NAME", default_value = "default", value_parser = pattern)]
    stream: String,
    #[command(flatten)]
    view: WireViewArgs,
    /// Also the most persistent dots whenever they change: so many, or all.
    #[arg(long, value_name = "N|all", value_parser = dots)]
    dots: Option<wire::DotsWanted>,
    /// Also what happens to tracks; the daemon follows them if it was started with --track. With "all", every living track in every frame, too.
    #[arg(long, value_name = "events|all", value_parser = tracks, num_args = 0..=1, require_equals = true, default_missing_value = "events")]
    tracks: Option<wire::TracksWanted>,
    /// End after so many frames.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..))]
    frames: Option<u64>,
    /// Connect again when the connection is lost or the daemon says goodbye, for up to a minute, and resume where possible.
    #[arg(long)]
    reconnect: bool,
}

impl FollowArgs {
    /// The subscription they ask for, with frames taken as they are proved by their checksums.
    pub fn subscription(self) -> Result<Subscription, Failure> {
        Ok(Subscription {
            from: self.from.from,
            pattern: self.stream,
            view: self.view.view()?,
            dots: self.dots.unwrap_or(wire::DotsWanted::No),
            tracks: self.tracks.unwrap_or_default(),
            frames: self.frames,
            check: false,
            reconnect: self.reconnect,
        })
    }
}

/// The daemon that a producer sends to.
#[derive(Clone, Debug, Args)]
pub struct To {
    /// Where the daemon listens: unix:PATH or tcp:HOST:PORT.
    #[arg(long, value_name = "ADDRESS")]
    pub to: Address,
}

/// Dots of the persistence diagram: a number, or `all`.
fn dots(word: &str) -> Result<wire::DotsWanted, String> {
    match word.parse::<NonZeroU32>() {
        _ if word == "all" => Ok(wire::DotsWanted::All),
        Ok(number) => Ok(wire::DotsWanted::Top(number.get())),
        Err(_) => Err(format!("{word:?} is not a number of dots, from 1, nor all")),
    }
}

/// What is told of tracks.
fn tracks(word: &str) -> Result<wire::TracksWanted, String> {
    match word {
        "events" => Ok(wire::TracksWanted::Events),
        "all" => Ok(wire::TracksWanted::Alive),
        _ => Err(format!("{word:?} is neither events nor all")),
    }
}

/// The name of a stream.
pub fn name(word: &str) -> Result<String, String> {
    if wire::is_name(word) { Ok(word.to_owned()) } else { Err(name_rule("a name", ", and no *")) }
}

/// A name, or a pattern with `*`.
fn pattern(word: &str) -> Result<String, String> {
    if wire::is_pattern(word) { Ok(word.to_owned()) } else { Err(name_rule("a name or pattern", "")) }
}

fn name_rule(what: &str, stars: &str) -> String {
    format!("{what} has 1 to {} bytes, no control character{stars}", wire::LONGEST_NAME)
}

/// A rate or a speed: a positive number.
pub fn rate(word: &str) -> Result<f64, String> {
    positive(word, "rate")
}

/// A scale: a number, not negative.
pub fn scale(word: &str) -> Result<f64, String> {
    let value = number(word)?;
    if value >= 0.0 { Ok(value) } else { Err(format!("{value} is negative: a scale is a radius")) }
}

/// The step of a grid: a positive number.
pub fn resolution(word: &str) -> Result<f64, String> {
    positive(word, "step of a grid")
}

/// A window: `all`, `points:N`, `frames:N` or `time:T`.
pub fn window(word: &str) -> Result<Window, String> {
    let (kind, length) = word.split_once(':').unwrap_or((word, ""));
    let count = || length.parse::<NonZeroU64>().map_err(|_| format!("{length:?} is not a number of {kind}, from 1"));
    match (kind, length) {
        ("all", "") => Ok(Window::All),
        ("points", _) => count().map(Window::Points),
        ("frames", _) => count().map(Window::Frames),
        ("time", _) => positive(length, "length of time").map(Window::Time),
        _ => Err("a window is all, points:N, frames:N or time:T".to_owned()),
    }
}

/// A length of real time, such as `100ms` or `2s`; not zero.
pub fn duration(word: &str) -> Result<std::time::Duration, String> {
    let duration = humantime::parse_duration(word).map_err(|error| format!("{error}: write it as 100ms or 2s"))?;
    if duration.is_zero() { Err("a frame must take some time".to_owned()) } else { Ok(duration) }
}

fn positive(word: &str, what: &str) -> Result<f64, String> {
    let value = number(word)?;
    if value > 0.0 { Ok(value) } else { Err(format!("{value} is not a {what}: it must be above 0")) }
}

/// A finite number.
pub fn number(word: &str) -> Result<f64, String> {
    match word.parse::<f64>() {
        Ok(value) if value.is_finite() => Ok(value),
        _ => Err(format!("{word:?} is not a finite number")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn windows_are_read() {
        assert_eq!(window("all"), Ok(Window::All));
        assert_eq!(window("points:10"), Ok(Window::Points(NonZeroU64::new(10).unwrap())));
        assert_eq!(window("frames:1"), Ok(Window::Frames(NonZeroU64::MIN)));
        assert_eq!(window("time:2.5"), Ok(Window::Time(2.5)));
    }

    #[test]
    fn bad_windows_say_what_they_may_be() {
        for (word, says) in [
            ("", "a window is all"),
            ("all:3", "a window is all"),
            ("points:0", "\"0\" is not a number of points, from 1"),
            ("points", "\"\" is not a number of points"),
            ("frames:-1", "\"-1\" is not a number of frames"),
            ("time:0", "0 is not a length of time"),
            ("time:inf", "\"inf\" is not a finite number"),
        ] {
            let error = window(word).unwrap_err();
            assert!(error.contains(says), "{word}: {error}");
        }
    }

    #[test]
    fn dots_and_names_say_what_they_may_be() {
        assert_eq!((dots("all"), dots("3")), (Ok(wire::DotsWanted::All), Ok(wire::DotsWanted::Top(3))));
        assert!(dots("0").is_err() && dots("some").is_err());
        assert!(name("a b").is_ok() && name("a*").is_err() && name("").is_err() && name("a\nb").is_err());
        assert!(pattern("a*").is_ok() && pattern(&"a".repeat(201)).is_err());
    }

    #[test]
    fn scales_and_steps_have_a_sign() {
        assert_eq!(scale("0"), Ok(0.0));
        assert!(scale("-1").is_err() && scale("nan").is_err());
        assert!(resolution("0").is_err() && resolution("0.5") == Ok(0.5));
        assert!(duration("0s").is_err() && duration("20ms").is_ok());
    }
}
