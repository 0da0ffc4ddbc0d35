//! Options of producers and consumers of a daemon.
//!
//! In: words of the command line.
//! Out: addresses, subscriptions.
//! Must not know: how a daemon is talked to.

use std::num::NonZeroU32;

use clap::Args;
use hopes_protocol as wire;

use super::place::address;
use super::values::from_one;
use super::view::SimplifiedViewArgs;
use crate::cli::Failure;
use crate::client::follow::Subscription;
use crate::daemon::Address;

/// The daemon that a producer sends to.
#[derive(Clone, Debug, Args)]
pub struct To {
    /// Where the daemon listens: unix:PATH or tcp:HOST:PORT [default: $HOPES_ADDRESS, else your own socket].
    #[arg(long, value_name = "ADDRESS")]
    to: Option<Address>,
}

impl To {
    /// The address.
    pub fn address(&self) -> Result<Address, Failure> {
        address(self.to.as_ref())
    }
}

/// The daemon that a consumer connects to.
#[derive(Clone, Debug, Args)]
struct From {
    /// Where the daemon listens: unix:PATH or tcp:HOST:PORT [default: $HOPES_ADDRESS, else your own socket].
    #[arg(long, value_name = "ADDRESS")]
    from: Option<Address>,
}

/// The daemon that is asked or administered.
#[derive(Clone, Debug, Args)]
pub struct Connect {
    /// Where the daemon listens: unix:PATH or tcp:HOST:PORT [default: $HOPES_ADDRESS, else your own socket].
    #[arg(long, value_name = "ADDRESS", visible_alias = "from")]
    connect: Option<Address>,
}

impl Connect {
    /// The address.
    pub fn address(&self) -> Result<Address, Failure> {
        address(self.connect.as_ref())
    }
}

/// What a consumer follows, and how far.
#[derive(Clone, Debug, Args)]
pub struct FollowArgs {
    #[command(flatten)]
    from: From,
    /// Name of the stream, or a pattern such as 'cam*', in which * stands for any characters.
    ///
    /// Streams that are created later are followed too.
    #[arg(long, value_name = "NAME", default_value = "default", value_parser = pattern)]
    stream: String,
    /// Also the N most persistent dots, or all, whenever they change.
    #[arg(long, value_name = "N|all", value_parser = dots)]
    dots: Option<wire::DotsWanted>,
    /// Also what happens to tracks; with "all", every living track in every frame, too.
    ///
    /// The daemon follows tracks if it was started with --track.
    #[arg(
        long,
        value_name = "events|all",
        value_parser = tracks,
        num_args = 0..=1,
        require_equals = true,
        default_missing_value = "events"
    )]
    tracks: Option<wire::TracksWanted>,
    /// End after so many frames.
    #[arg(long, value_name = "N", value_parser = from_one)]
    frames: Option<u64>,
    /// Connect again when the connection is lost or the daemon says goodbye.
    ///
    /// It tries for up to a minute, and resumes after the last frame where the daemon still can.
    #[arg(long)]
    reconnect: bool,
    #[command(flatten)]
    view: SimplifiedViewArgs,
}

impl FollowArgs {
    /// The subscription they ask for, with frames taken as they are proved by their checksums.
    pub fn subscription(self) -> Result<Subscription, Failure> {
        Ok(Subscription {
            from: address(self.from.from.as_ref())?,
            pattern: self.stream,
            view: self.view.wire()?,
            dots: self.dots.unwrap_or(wire::DotsWanted::No),
            tracks: self.tracks.unwrap_or_default(),
            frames: self.frames,
            check: false,
            reconnect: self.reconnect,
        })
    }
}

/// Dots of the persistence diagram: a number, or `all`.
fn dots(word: &str) -> Result<wire::DotsWanted, String> {
    match word.parse::<NonZeroU32>() {
        _ if word == "all" => Ok(wire::DotsWanted::All),
        Ok(number) => Ok(wire::DotsWanted::Top(number.get())),
        Err(_) => Err(format!("{word:?} is not a number of dots, from 1, nor all")),
    }
}

/// What is sent of tracks.
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dots_and_names_are_checked() {
        assert_eq!((dots("all"), dots("3")), (Ok(wire::DotsWanted::All), Ok(wire::DotsWanted::Top(3))));
        assert!(dots("0").is_err() && dots("some").is_err());
        assert!(name("a b").is_ok() && name("a*").is_err() && name("").is_err() && name("a\nb").is_err());
        assert!(pattern("a*").is_ok() && pattern(&"a".repeat(201)).is_err());
    }
}
