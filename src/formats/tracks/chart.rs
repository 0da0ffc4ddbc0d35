//! The lives of tracks as a barcode.
//!
//! In: lives, how many bars there may be, which axis.
//! Out: a [`Barcode`].
//! Invariants: the most persistent tracks are shown, of equals the first ones. The picture says how many are left
//! out. A link is drawn if both of its tracks are.
//! Must not know: pixels.

use std::collections::HashMap;

use thiserror::Error;

use super::frame::Moment;
use super::lives::{Began, Ended, Life, Lives, Stream};
use super::order::order;
use crate::formats::picture::{Bar, Barcode, Link, LinkKind, count, shortened};
use crate::formats::short::Short;

/// What bars are drawn over.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Axis {
    /// Frames, by number.
    #[default]
    Frame,
    /// Their times.
    Time,
}

/// Why there is no picture.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum ChartError {
    /// A frame has no time.
    #[error("--axis time: not all frames have a time: leave it out, or give every frame one")]
    NoTimes,
    /// Numbers end before that.
    #[error("--axis time: times from {from} to {to} are too far apart to be drawn")]
    TooFar {
        /// The first.
        from: f64,
        /// The last.
        to: f64,
    },
}

/// A track that is shown.
struct Shown<'a> {
    name: &'a str,
    stream: &'a Stream,
    life: &'a Life,
}

/// Makes the picture of the `most` most persistent tracks.
pub fn chart(lives: &Lives, most: usize, axis: Axis, name: Option<&str>) -> Result<Barcode, ChartError> {
    if axis == Axis::Time && !lives.have_times() {
        return Err(ChartError::NoTimes);
    }
    let shown = shown(lives, most);
    let place = |moment: Moment| match axis {
        Axis::Frame => moment.frame as f64,
        Axis::Time => moment.time.unwrap_or_default(),
    };
    let links = links(&shown, &place);
    let rows = order(shown.len(), &links.iter().map(|link| link.bars).collect::<Vec<_>>());
    let mut row_of = vec![0; shown.len()];
    for (row, &index) in rows.iter().enumerate() {
        row_of[index] = row;
    }
    let has_streams = lives.streams.len() > 1;
    let bars = rows.iter().map(|&index| bar(&shown[index], has_streams, &place)).collect();
    let links = links.into_iter().map(|link| Link { bars: link.bars.map(|index| row_of[index]), ..link }).collect();
    let range = range(lives, &place)?;
    let title = name.map_or("Lives of tracks".to_owned(), |name| format!("{}: lives of tracks", shortened(name)));
    let axis = if axis == Axis::Frame { "frame" } else { "time" };
    Ok(Barcode { title, facts: facts(lives, shown.len()), axis, range, bars, links })
}

/// By stream and beginning.
fn shown(lives: &Lives, most: usize) -> Vec<Shown<'_>> {
    let mut shown: Vec<Shown<'_>> = lives.all().map(|(name, stream, life)| Shown { name, stream, life }).collect();
    // Stable: of equals the first.
    let strength = |shown: &Shown<'_>| shown.life.sight.persistence().unwrap_or(0.0);
    shown.sort_by(|a, b| strength(b).total_cmp(&strength(a)));
    shown.truncate(most);
    shown.sort_by_key(|shown| (shown.name, shown.life.from.frame, shown.life.id));
    shown
}

/// By moment, between numbers of shown tracks.
fn links(shown: &[Shown<'_>], place: &impl Fn(Moment) -> f64) -> Vec<Link> {
    let key = |name, id| (name, id);
    let index: HashMap<(&str, u64), usize> =
        shown.iter().enumerate().map(|(index, shown)| (key(shown.name, shown.life.id), index)).collect();
    let mut links = Vec::new();
    for (own, Shown { name, stream, life }) in shown.iter().enumerate() {
        let mut link = |other: u64, moment: Moment, kind| {
            if let Some(&other) = index.get(&key(name, other)) {
                links.push(Link { at: place(moment), bars: [other, own], kind });
            }
        };
        if let Began::Split { from } = life.began {
            link(from, life.from, LinkKind::Split);
        }
        if let Ended::Merged { into } = life.ended {
            link(into, stream.to(life), LinkKind::Merger);
        }
    }
    links.sort_by(|a, b| a.at.total_cmp(&b.at).then(a.bars.cmp(&b.bars)));
    links
}

fn bar(shown: &Shown<'_>, has_streams: bool, place: &impl Fn(Moment) -> f64) -> Bar {
    let Shown { name, stream, life } = shown;
    let to = stream.to(life);
    Bar {
        from: place(life.from),
        to: place(to),
        pale: life.hidden.until(to).map(|ends| ends.map(place)).collect(),
        strength: life.sight.persistence().unwrap_or(0.0),
        goes_on: life.ended == Ended::Alive,
        name: if has_streams { format!("{name} {}", life.id) } else { life.id.to_string() },
        hint: hint(name, stream, life),
    }
}

fn hint(name: &str, stream: &Stream, life: &Life) -> String {
    let began = match life.began {
        Began::Born => "born".to_owned(),
        Began::Split { from } => format!("split from {from}"),
        Began::Before => "there before".to_owned(),
    };
    let ended = match life.ended {
        Ended::Died => "died".to_owned(),
        Ended::Merged { into } => format!("merged into {into}"),
        Ended::Alive => "alive".to_owned(),
    };
    let (from, to) = (life.from.frame, stream.to(life).frame);
    let mut hint = format!("{name}, track {}: {began} in frame {from}, {ended} in frame {to}", life.id);
    if let Some(persistence) = life.sight.persistence() {
        hint += &format!(", persistence {} in frame {}", Short(persistence), life.peak.frame);
    }
    if let Some(center) = &life.sight.center {
        let shown: Vec<String> = center.iter().take(3).map(|&number| Short(number).to_string()).collect();
        let more = if center.len() > 3 { ", .." } else { "" };
        hint += &format!(" at ({}{more})", shown.join(", "));
    }
    hint
}

/// From the first frame of all streams to the last.
fn range(lives: &Lives, place: &impl Fn(Moment) -> f64) -> Result<[f64; 2], ChartError> {
    let ends = lives.streams.values().flat_map(|stream| [stream.first, stream.last]).map(place);
    // Times may go back.
    let of_tracks = lives.all().flat_map(|(_, stream, life)| [life.from, stream.to(life)]).map(place);
    let all = ends.chain(of_tracks);
    let [from, to] = all.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], at| [low.min(at), high.max(at)]);
    if from > to {
        return Ok([0.0, 1.0]);
    }
    if (to - from).is_finite() { Ok([from, to]) } else { Err(ChartError::TooFar { from, to }) }
}

fn facts(lives: &Lives, shown: usize) -> String {
    let frames = lives.streams.values().fold(0u64, |sum, stream| sum.saturating_add(stream.frames));
    let all = || lives.all().map(|(_, _, life)| life);
    let splits = all().filter(|life| matches!(life.began, Began::Split { .. })).count();
    let mergers = all().filter(|life| matches!(life.ended, Ended::Merged { .. })).count();
    let tracks = all().count();
    let mut facts = vec![count(usize::try_from(frames).unwrap_or(usize::MAX), "frame")];
    if lives.streams.len() > 1 {
        facts.push(count(lives.streams.len(), "stream"));
    }
    facts.extend([count(tracks, "track"), count(splits, "split"), count(mergers, "merger")]);
    if tracks > shown {
        facts.push(format!("the {shown} most persistent shown, {} left out", tracks - shown));
    }
    facts.join(" \u{b7} ")
}
