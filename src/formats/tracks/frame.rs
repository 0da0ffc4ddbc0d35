//! A frame's tracks, out of a line of `serve --track`.
//!
//! In: one line, without its end.
//! Out: the frame's number, its time and its events, or what is wrong with the line.
//! Invariants: keys that are not needed are skipped and never kept. An excerpt of the line in a message is short
//! and printable. A line is good as a whole or refused as a whole.
//! Must not know: other lines, what becomes of the events.

use std::borrow::Cow;
use std::fmt;

use hopes_protocol::is_name;
use serde::de::{Error as _, IgnoredAny, SeqAccess, Visitor};
use serde::{Deserialize, Deserializer};
use thiserror::Error;

use crate::formats::input::Excerpt;

/// A moment of a stream.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Moment {
    /// The frame's number.
    pub frame: u64,
    /// Its time, if it has one.
    pub time: Option<f64>,
}

/// A track as it was in a frame.
#[derive(Clone, Debug, PartialEq)]
pub struct Sight {
    /// None: not finite, or not given.
    pub birth: Option<f64>,
    /// None: not finite, or not given.
    pub death: Option<f64>,
    /// Of the hole, or in a space of the cycle; of at least one coordinate. None: not finite, or not given.
    pub center: Option<Vec<f64>>,
    /// Of the same.
    pub radius: Option<f64>,
}

impl Sight {
    /// None if either end of its life is not finite, or was not given.
    pub fn persistence(&self) -> Option<f64> {
        let (birth, death) = self.birth.zip(self.death)?;
        Some((death - birth).max(0.0))
    }
}

/// What happened to a track.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Change {
    /// It began.
    Born,
    /// It began as a part of another.
    Split {
        /// The other.
        from: u64,
    },
    /// It moved.
    Updated,
    /// It was there. Not an event: a row of the list of the living.
    Seen,
    /// It left the view.
    Unselected,
    /// It came back into the view.
    Reselected,
    /// It became a part of another.
    Merged {
        /// The other.
        into: u64,
    },
    /// It ended.
    Died,
}

/// A track, what happened to it, and how it was then.
#[derive(Clone, Debug, PartialEq)]
pub struct Event {
    pub id: u64,
    pub change: Change,
    pub sight: Sight,
}

/// A frame, as far as tracks go.
#[derive(Clone, Debug, PartialEq)]
pub struct Frame {
    pub stream: String,
    pub moment: Moment,
    /// In the order of the line.
    pub events: Vec<Event>,
}

/// What a line says.
#[derive(Clone, Debug, PartialEq)]
pub enum LineContent {
    /// A frame with its tracks.
    Tracks(Frame),
    /// A frame that was written without them.
    Untracked,
    /// Something that `watch` writes between frames.
    Other,
}

/// Why a line was refused.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum Fault {
    /// It was skipped unread.
    #[error("longer than {limit} bytes: follow fewer points, or write a smaller view")]
    TooLong {
        /// The most that is read.
        limit: usize,
    },
    /// It is no object.
    #[error("{found} is no JSON object: this must be a line of hopes serve --track")]
    NotAnObject {
        /// The beginning of the line.
        found: Excerpt,
    },
    /// It is not JSON, or has a value of the wrong kind.
    #[error("byte {byte}: {message}: this must be a line of hopes serve --track")]
    Json {
        /// Where.
        byte: usize,
        /// What the parser says.
        message: String,
    },
    /// It has no number.
    #[error("no frame: this must be a line of hopes serve --track")]
    NoFrame,
    /// No stream can be called that.
    #[error("{0} is no name of a stream")]
    Name(Excerpt),
    /// An event that is not known, or that lacks the other track.
    #[error("tracks, event {number}: {reason}")]
    Event {
        /// Its place on the line, from 1.
        number: usize,
        /// What is wrong.
        reason: EventFault,
    },
    /// A track in the list of the living cannot be.
    #[error("alive, track {number}: {reason}")]
    Alive {
        /// Its place on the line, from 1.
        number: usize,
        /// What is wrong.
        reason: EventFault,
    },
}

/// What is wrong with an event.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum EventFault {
    /// An unknown event.
    #[error("{0} is none of born, updated, split, merged, unselected, reselected, died")]
    Unknown(Excerpt),
    /// A split or merger without the other track.
    #[error("{event} needs \"{key}\", the id of another track")]
    NoOther {
        /// What happened.
        event: &'static str,
        /// The key that is missing.
        key: &'static str,
    },
    /// A scale below 0.
    #[error("{key} is {value}: it cannot be negative")]
    Negative {
        /// Which.
        key: &'static str,
        /// Its value.
        value: f64,
    },
}

/// Reads a line that is not blank.
pub fn read(line: &[u8]) -> Result<LineContent, Fault> {
    let line = line.trim_ascii_start();
    if !line.starts_with(b"{") {
        return Err(Fault::NotAnObject { found: Excerpt::of(line) });
    }
    let line: Line<'_> = serde_json::from_slice(line).map_err(|error| json_fault(&error))?;
    if line.lagged.is_some() || line.dots.is_some() {
        return Ok(LineContent::Other);
    }
    let frame = line.frame.ok_or(Fault::NoFrame)?;
    let Some(tracks) = line.tracks else { return Ok(LineContent::Untracked) };
    let stream = line.stream.unwrap_or_default();
    if !is_name(&stream) {
        return Err(Fault::Name(Excerpt::of(stream.as_bytes())));
    }
    let mut events = Vec::with_capacity(tracks.len());
    for (index, track) in tracks.into_iter().enumerate() {
        events.push(track.event().map_err(|reason| Fault::Event { number: index + 1, reason })?);
    }
    for (index, alive) in line.alive.unwrap_or_default().into_iter().enumerate() {
        events.push(seen(alive).map_err(|reason| Fault::Alive { number: index + 1, reason })?);
    }
    Ok(LineContent::Tracks(Frame { stream: stream.into_owned(), moment: Moment { frame, time: line.time }, events }))
}

/// What of a line is looked at.
#[derive(Deserialize)]
struct Line<'a> {
    #[serde(borrow)]
    stream: Option<Cow<'a, str>>,
    frame: Option<u64>,
    time: Option<f64>,
    #[serde(borrow)]
    tracks: Option<Vec<Track<'a>>>,
    alive: Option<Vec<Alive>>,
    /// A line of `watch`, and no frame.
    lagged: Option<IgnoredAny>,
    /// A line of `watch`, and no frame.
    dots: Option<IgnoredAny>,
}

/// `[id,x,y,radius,birth,death]`, in a space with other coordinates in the place of x and y.
struct Alive {
    id: u64,
    center: Vec<Option<f64>>,
    radius: Option<f64>,
    birth: Option<f64>,
    death: Option<f64>,
}

impl<'de> Deserialize<'de> for Alive {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_seq(AliveVisitor)
    }
}

struct AliveVisitor;

impl<'de> Visitor<'de> for AliveVisitor {
    type Value = Alive;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a list of an id, coordinates, radius, birth and death")
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut list: A) -> Result<Alive, A::Error> {
        let id = list.next_element()?.ok_or_else(|| A::Error::invalid_length(0, &self))?;
        let mut center = Vec::new();
        while let Some(number) = list.next_element::<Option<f64>>()? {
            center.push(number);
        }
        let length = center.len() + 1;
        let label = center.len().checked_sub(3).filter(|&dimension| dimension > 0).map(|at| center.split_off(at));
        match label.as_deref() {
            Some(&[radius, birth, death]) => Ok(Alive { id, center, radius, birth, death }),
            _ => Err(A::Error::invalid_length(length, &self)),
        }
    }
}

#[derive(Deserialize)]
struct Track<'a> {
    id: u64,
    #[serde(borrow)]
    event: Cow<'a, str>,
    birth: Option<f64>,
    death: Option<f64>,
    center: Option<Vec<Option<f64>>>,
    radius: Option<f64>,
    from: Option<u64>,
    into: Option<u64>,
}

impl Track<'_> {
    fn event(self) -> Result<Event, EventFault> {
        let change = match &*self.event {
            "born" => Change::Born,
            "updated" => Change::Updated,
            "split" => Change::Split { from: other("split", "from", self.from)? },
            "merged" => Change::Merged { into: other("merged", "into", self.into)? },
            "unselected" => Change::Unselected,
            "reselected" => Change::Reselected,
            "died" => Change::Died,
            unknown => return Err(EventFault::Unknown(Excerpt::of(unknown.as_bytes()))),
        };
        let center = self.center.unwrap_or_default();
        Ok(Event { id: self.id, change, sight: sight(center, self.radius, self.birth, self.death)? })
    }
}

fn seen(Alive { id, center, radius, birth, death }: Alive) -> Result<Event, EventFault> {
    Ok(Event { id, change: Change::Seen, sight: sight(center, radius, birth, death)? })
}

fn other(event: &'static str, key: &'static str, id: Option<u64>) -> Result<u64, EventFault> {
    id.ok_or(EventFault::NoOther { event, key })
}

fn sight(
    center: Vec<Option<f64>>,
    radius: Option<f64>,
    birth: Option<f64>,
    death: Option<f64>,
) -> Result<Sight, EventFault> {
    for (key, value) in [("birth", birth), ("death", death), ("radius", radius)] {
        if let Some(value) = value.filter(|&value| value < 0.0) {
            return Err(EventFault::Negative { key, value });
        }
    }
    let center: Option<Vec<f64>> = center.into_iter().collect();
    Ok(Sight { birth, death, center: center.filter(|center| !center.is_empty()), radius })
}

/// The most that a message takes from the parser, which may quote the line.
const MESSAGE: usize = 100;

fn json_fault(error: &serde_json::Error) -> Fault {
    let text = error.to_string();
    // The parser counts lines within what it is given, which is always one line here.
    let message = text.rsplit_once(" at line ").map_or(text.as_str(), |(message, _)| message);
    let printable = |c: char| if c.is_control() { '\u{fffd}' } else { c };
    Fault::Json { byte: error.column(), message: message.chars().take(MESSAGE).map(printable).collect() }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tracks(line: &str) -> Frame {
        match read(line.as_bytes()).unwrap() {
            LineContent::Tracks(frame) => frame,
            other => panic!("{other:?}"),
        }
    }

    fn fault(line: &str) -> String {
        read(line.as_bytes()).unwrap_err().to_string()
    }

    #[test]
    fn events_and_the_living_are_read() {
        let frame = tracks(
            r#"{"stream":"cam","frame":7,"new":[{}],"time":0.5,"tracks":[
                {"id":3,"event":"split","age":1,"birth":0.5,"death":2,"center":[1,null],"radius":2,"from":1}],
                "alive":[[1,0.5,1,2,0.25,null]]}"#,
        );
        assert_eq!((frame.stream.as_str(), frame.moment), ("cam", Moment { frame: 7, time: Some(0.5) }));
        let split = Sight { birth: Some(0.5), death: Some(2.0), center: None, radius: Some(2.0) };
        let alive = Sight { birth: Some(0.25), death: None, center: Some(vec![0.5, 1.0]), radius: Some(2.0) };
        assert_eq!((split.persistence(), alive.persistence()), (Some(1.5), None));
        let events = [
            Event { id: 3, change: Change::Split { from: 1 }, sight: split },
            Event { id: 1, change: Change::Seen, sight: alive },
        ];
        assert_eq!(frame.events, events);
    }

    #[test]
    fn centres_of_spaces_have_any_number_of_coordinates() {
        let frame = tracks(
            r#"{"stream":"cam","frame":7,"tracks":[{"id":3,"event":"born","center":[1,2,3],"radius":2}],
                "alive":[[1,0.5,1,0.25,null],[2,1,2,3,4,9,0.5,1.5]]}"#,
        );
        let centers: Vec<Option<Vec<f64>>> = frame.events.iter().map(|event| event.sight.center.clone()).collect();
        assert_eq!(centers, [Some(vec![1.0, 2.0, 3.0]), Some(vec![0.5]), Some(vec![1.0, 2.0, 3.0, 4.0])]);
        let last = &frame.events[2].sight;
        assert_eq!((last.radius, last.birth, last.death), (Some(9.0), Some(0.5), Some(1.5)));
    }

    #[test]
    fn lines_that_are_no_frames_say_nothing() {
        assert_eq!(read(br#"{"stream":"a","lagged":[3,4]}"#), Ok(LineContent::Other));
        assert_eq!(read(br#"{"stream":"a","frame":2,"dots":[],"total":0}"#), Ok(LineContent::Other));
        assert_eq!(read(br#"{"stream":"a","frame":2,"edges":{}}"#), Ok(LineContent::Untracked));
    }

    #[test]
    fn refusals_say_what_is_wrong() {
        let event = |event: &str| fault(&format!(r#"{{"stream":"a","frame":1,"tracks":[{event}]}}"#));
        for (said, words) in [
            (fault(" [1,2]"), "\"[1,2]\" is no JSON object"),
            (fault(r#"{"stream":"a""#), "byte 13: EOF while parsing"),
            (fault(r#"{"stream":"a"}"#), "no frame: this must be a line of hopes serve --track"),
            (fault(r#"{"frame":1,"tracks":[]}"#), "\"\" is no name of a stream"),
            (fault(r#"{"stream":"a\u0007","frame":1,"tracks":[]}"#), r#""a\u{7}" is no name of a stream"#),
            (fault(r#"{"stream":"a","frame":-1,"tracks":[]}"#), "invalid value: integer `-1`"),
            (fault(r#"{"stream":"a","frame":1,"time":1e999,"tracks":[]}"#), "number out of range"),
            (event(r#"{"id":1,"event":"hid"}"#), "tracks, event 1: \"hid\" is none of born, updated,"),
            (event(r#"{"id":1,"event":"split","into":2}"#), "event 1: split needs \"from\""),
            (event(r#"{"id":1,"event":"merged"}"#), "event 1: merged needs \"into\""),
            (event(r#"{"id":1,"event":"born","death":-1}"#), "event 1: death is -1: it cannot be negative"),
            (event(r#"{"event":"born"}"#), "missing field `id`"),
            (fault(r#"{"stream":"a","frame":1,"tracks":[],"alive":[[1,2]]}"#), "invalid length 2"),
            (fault(r#"{"stream":"a","frame":1,"tracks":[],"alive":[[1,0,0,-1,0,0]]}"#), "alive, track 1: radius"),
        ] {
            assert!(said.contains(words), "{words:?} is missing in {said:?}");
        }
    }

    #[test]
    fn messages_are_short_and_printable() {
        let said = fault(&format!(r#"{{"stream":"a","frame":"\u001b{}","tracks":[]}}"#, "x".repeat(100_000)));
        assert!(said.len() < 200 && !said.contains('\u{1b}'), "{said}");
    }
}
