//! The lives of tracks, from their events.
//!
//! In: frames of any number of streams, in the order of each.
//! Out: streams, and for each track when and how it began and ended, where and when it was most persistent, and
//! when it was out of the view.
//! Invariants: memory grows with streams and tracks, not with frames or events. An event that contradicts earlier
//! ones is left out and reported. A track whose beginning was not read begins with its first event.
//! Must not know: how frames are written or lives shown.

use std::collections::BTreeMap;
use std::collections::btree_map::Entry;

use thiserror::Error;

use super::frame::{Change, Event, Frame, Moment, Sight};

/// How a track began.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Began {
    /// By itself.
    Born,
    /// As a part of another.
    Split {
        /// The other.
        from: u64,
    },
    /// Before the first line that was read.
    Before,
}

/// How a track ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ended {
    /// By itself.
    Died,
    /// As a part of another.
    Merged {
        /// The other.
        into: u64,
    },
    /// Not before the last line that was read.
    Alive,
}

/// A track.
#[derive(Clone, Debug, PartialEq)]
pub struct Life {
    pub id: u64,
    pub from: Moment,
    /// Where it ended; for one that lives, where it was last heard of: see [`Stream::to`].
    last: Moment,
    pub began: Began,
    pub ended: Ended,
    /// When it was most persistent.
    pub peak: Moment,
    /// How it was then.
    pub sight: Sight,
    /// When it was out of the view.
    pub hidden: Hidden,
}

/// A stream.
#[derive(Clone, Debug, PartialEq)]
pub struct Stream {
    pub first: Moment,
    pub last: Moment,
    pub frames: u64,
    /// By id.
    pub lives: BTreeMap<u64, Life>,
}

/// What cannot have happened after what has.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum Contradiction {
    /// Frames go back.
    #[error("frame {frame} of stream {stream:?} comes after its frame {last}: the frames of one run must be in order")]
    Order {
        /// Which stream.
        stream: String,
        /// This frame.
        frame: u64,
        /// The newest before it.
        last: u64,
    },
    /// A track begins that is there.
    #[error("frame {frame}: track {id} of stream {stream:?} begins, but there was one with that id")]
    Again {
        /// Which stream.
        stream: String,
        /// This frame.
        frame: u64,
        /// The track.
        id: u64,
    },
    /// A track is heard of after its end.
    #[error("frame {frame}: track {id} of stream {stream:?} had ended in frame {ended}")]
    Ended {
        /// Which stream.
        stream: String,
        /// This frame.
        frame: u64,
        /// The track.
        id: u64,
        /// Where it ended.
        ended: u64,
    },
    /// A track splits off itself, or becomes a part of itself.
    #[error("frame {frame}: track {id} of stream {stream:?} cannot be its own parent or heir")]
    Itself {
        /// Which stream.
        stream: String,
        /// This frame.
        frame: u64,
        /// The track.
        id: u64,
    },
}

/// All streams, by name.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Lives {
    pub streams: BTreeMap<String, Stream>,
}

impl Lives {
    /// Goes on by a frame. What contradicts the past, in the order of the frame's events.
    pub fn take(&mut self, frame: &Frame) -> Vec<Contradiction> {
        let moment = frame.moment;
        if !self.streams.contains_key(&frame.stream) {
            let stream = Stream { first: moment, last: moment, frames: 0, lives: BTreeMap::new() };
            self.streams.insert(frame.stream.clone(), stream);
        }
        let Some(stream) = self.streams.get_mut(&frame.stream) else { return Vec::new() };
        if stream.frames > 0 && moment.frame <= stream.last.frame {
            let (stream, last) = (frame.stream.clone(), stream.last.frame);
            return vec![Contradiction::Order { stream, frame: moment.frame, last }];
        }
        stream.frames += 1;
        stream.last = moment;
        let contradictions = frame.events.iter().filter_map(|event| stream.event(moment, event).err());
        contradictions.map(|odd| odd.contradiction(frame)).collect()
    }

    /// All tracks, with their streams.
    pub fn all(&self) -> impl Iterator<Item = (&str, &Stream, &Life)> + Clone {
        self.streams
            .iter()
            .flat_map(|(name, stream)| stream.lives.values().map(move |life| (name.as_str(), stream, life)))
    }

    /// Whether all moments of all tracks have times.
    pub fn have_times(&self) -> bool {
        let has_time = |moment: Moment| moment.time.is_some();
        self.all().all(|(_, stream, life)| {
            [life.from, stream.to(life), life.peak].into_iter().all(has_time) && life.hidden.moments().all(has_time)
        })
    }

    /// Whether any frame that is named has a time.
    pub fn have_any_time(&self) -> bool {
        self.all().any(|(_, stream, life)| life.from.time.or(stream.to(life).time).is_some())
    }
}

/// What is wrong with an event.
enum Odd {
    Again { id: u64 },
    Ended { id: u64, ended: u64 },
    Itself { id: u64 },
}

impl Odd {
    fn contradiction(self, at: &Frame) -> Contradiction {
        let (stream, frame) = (at.stream.clone(), at.moment.frame);
        match self {
            Self::Again { id } => Contradiction::Again { stream, frame, id },
            Self::Ended { id, ended } => Contradiction::Ended { stream, frame, id, ended },
            Self::Itself { id } => Contradiction::Itself { stream, frame, id },
        }
    }
}

impl Stream {
    /// The last moment of a life of this stream.
    pub fn to(&self, life: &Life) -> Moment {
        if life.ended == Ended::Alive { self.last } else { life.last }
    }

    fn event(&mut self, moment: Moment, event: &Event) -> Result<(), Odd> {
        let id = event.id;
        let (begins, ends) = match event.change {
            Change::Split { from: other } | Change::Merged { into: other } if other == id => {
                return Err(Odd::Itself { id });
            }
            Change::Born => (Some(Began::Born), None),
            Change::Split { from } => (Some(Began::Split { from }), None),
            Change::Merged { into } => (None, Some(Ended::Merged { into })),
            Change::Died => (None, Some(Ended::Died)),
            Change::Updated | Change::Seen | Change::Unselected | Change::Reselected => (None, None),
        };
        let life = match self.lives.entry(id) {
            Entry::Occupied(_) if begins.is_some() => return Err(Odd::Again { id }),
            Entry::Occupied(entry) => entry.into_mut(),
            Entry::Vacant(entry) => {
                entry.insert(Life::new(id, moment, begins.unwrap_or(Began::Before), event.sight.clone()))
            }
        };
        if life.ended != Ended::Alive {
            return Err(Odd::Ended { id, ended: life.last.frame });
        }
        life.go_on(moment, event);
        life.ended = ends.unwrap_or(Ended::Alive);
        Ok(())
    }
}

impl Life {
    fn new(id: u64, from: Moment, began: Began, sight: Sight) -> Self {
        Self { id, from, last: from, began, ended: Ended::Alive, peak: from, sight, hidden: Hidden::default() }
    }

    fn go_on(&mut self, moment: Moment, event: &Event) {
        self.last = moment;
        if event.sight.persistence() > self.sight.persistence() {
            (self.peak, self.sight) = (moment, event.sight.clone());
        }
        match event.change {
            Change::Unselected => self.hidden.begin(moment),
            Change::Reselected => self.hidden.end(moment),
            _ => {}
        }
    }
}

/// When a track was out of the view: stretches in order, apart from each other.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Hidden {
    over: Vec<[Moment; 2]>,
    since: Option<Moment>,
}

impl Hidden {
    /// Of more stretches, the two that are nearest to each other become one.
    const MOST: usize = 64;

    /// All stretches of a life that ends there.
    pub fn until(&self, to: Moment) -> impl Iterator<Item = [Moment; 2]> {
        self.over.iter().copied().chain(self.since.map(|since| [since, to]))
    }

    fn moments(&self) -> impl Iterator<Item = Moment> {
        self.over.iter().flatten().copied().chain(self.since)
    }

    fn begin(&mut self, moment: Moment) {
        self.since.get_or_insert(moment);
    }

    fn end(&mut self, moment: Moment) {
        let Some(since) = self.since.take() else { return };
        self.over.push([since, moment]);
        if self.over.len() > Self::MOST {
            self.join_nearest();
        }
    }

    fn join_nearest(&mut self) {
        let gap = |index: &usize| self.over[index + 1][0].frame - self.over[*index][1].frame;
        if let Some(index) = (0..self.over.len() - 1).min_by_key(gap) {
            self.over[index][1] = self.over[index + 1][1];
            self.over.remove(index + 1);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn moment(frame: u64) -> Moment {
        Moment { frame, time: None }
    }

    fn event(id: u64, change: Change, death: f64) -> Event {
        let sight = Sight { birth: Some(0.0), death: Some(death), center: Some(vec![death, 0.0]), radius: Some(death) };
        Event { id, change, sight }
    }

    fn frame(number: u64, events: &[Event]) -> Frame {
        Frame { stream: "s".to_owned(), moment: moment(number), events: events.to_vec() }
    }

    fn lives(frames: &[Frame]) -> (Stream, Vec<Contradiction>) {
        let mut lives = Lives::default();
        let told = frames.iter().flat_map(|frame| lives.take(frame)).collect();
        (lives.streams["s"].clone(), told)
    }

    #[test]
    fn a_life_has_a_beginning_a_peak_and_an_end() {
        let (stream, told) = lives(&[
            frame(1, &[event(1, Change::Born, 2.0)]),
            frame(3, &[event(1, Change::Updated, 5.0), event(2, Change::Split { from: 1 }, 1.0)]),
            frame(8, &[event(1, Change::Updated, 3.0), event(2, Change::Merged { into: 1 }, 0.5)]),
            frame(9, &[]),
        ]);
        assert_eq!(told, []);
        let [one, two] = [1, 2].map(|id| &stream.lives[&id]);
        assert_eq!((one.began, one.ended, one.from, stream.to(one)), (Began::Born, Ended::Alive, moment(1), moment(9)));
        assert_eq!((one.peak, one.sight.center.clone()), (moment(3), Some(vec![5.0, 0.0])));
        assert_eq!((two.began, two.ended), (Began::Split { from: 1 }, Ended::Merged { into: 1 }));
        assert_eq!((two.from, stream.to(two), two.peak), (moment(3), moment(8), moment(3)));
        assert_eq!((stream.first, stream.last, stream.frames), (moment(1), moment(9), 4));
    }

    #[test]
    fn tracks_from_before_the_first_line_begin_there() {
        let (stream, told) =
            lives(&[frame(50, &[event(7, Change::Seen, 1.0)]), frame(51, &[event(8, Change::Died, 1.0)])]);
        assert_eq!(told, []);
        assert_eq!((stream.lives[&7].began, stream.lives[&7].from), (Began::Before, moment(50)));
        assert_eq!((stream.lives[&8].began, stream.lives[&8].ended), (Began::Before, Ended::Died));
    }

    #[test]
    fn contradictions_are_reported_and_change_nothing() {
        let good = [
            frame(1, &[event(1, Change::Born, 1.0), event(2, Change::Born, 1.0)]),
            frame(2, &[event(2, Change::Died, 1.0)]),
        ];
        let odd = frame(
            3,
            &[
                event(1, Change::Born, 9.0),
                event(2, Change::Updated, 9.0),
                event(2, Change::Split { from: 1 }, 9.0),
                event(1, Change::Merged { into: 1 }, 9.0),
            ],
        );
        let late = frame(3, &[event(3, Change::Born, 1.0)]);
        let (stream, told) = lives(&[&good[..], &[odd, late]].concat());
        let said: Vec<String> = told.iter().map(ToString::to_string).collect();
        assert_eq!(said.len(), 5, "{said:?}");
        for (said, words) in said.iter().zip([
            "track 1 of stream \"s\" begins",
            "ended in frame 2",
            "begins",
            "its own parent",
            "frame 3 of stream \"s\" comes after its frame 3",
        ]) {
            assert!(said.contains(words), "{words:?} is missing in {said:?}");
        }
        let (mut expected, _) = lives(&good);
        (expected.last, expected.frames) = (moment(3), 3);
        assert_eq!(stream, expected);
    }

    #[test]
    fn stretches_out_of_the_view_are_kept_apart_up_to_a_number() {
        let toggles = |from: u64| {
            [frame(from, &[event(1, Change::Unselected, 1.0)]), frame(from + 2, &[event(1, Change::Reselected, 1.0)])]
        };
        let mut frames = vec![frame(1, &[event(1, Change::Born, 1.0)])];
        frames.extend((1..=200).flat_map(|step| toggles(10 * step)));
        frames.extend([
            frame(2100, &[event(1, Change::Unselected, 1.0)]),
            frame(2200, &[event(1, Change::Unselected, 1.0)]),
        ]);
        let (stream, told) = lives(&frames);
        let life = &stream.lives[&1];
        let stretches: Vec<[u64; 2]> =
            life.hidden.until(stream.to(life)).map(|ends| ends.map(|end| end.frame)).collect();
        assert_eq!((told.len(), stretches.len()), (0, Hidden::MOST + 1));
        assert_eq!((stretches[0][0], stretches[Hidden::MOST]), (10, [2100, 2200]));
        assert!(stretches.iter().flatten().is_sorted_by(|a, b| a < b), "{stretches:?}");
    }
}
