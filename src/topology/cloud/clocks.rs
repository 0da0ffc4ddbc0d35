//! The clocks of the sources that feed a time window: which event time is believed.
//!
//! In: the event times that sources say, in the order in which they say them, and what is believed so far.
//! Out: whether a time agrees with the window, waits for its commit, or is refused; at a commit, whether a jump is
//! believed.
//! Invariants: a time that is within a window's length of what is believed is believed. Any other is a jump, ahead or
//! back. A jump is believed when more sources stand behind it than behind the time that is believed, or when its
//! source alone confirms it and none contradicts. What a source alone has moved, another one moves back at once.
//! The judgment depends on the order of what was said and on nothing else.
//! Must not know: points, vertices, real clocks.

use std::collections::BTreeMap;

use super::refusal::{CONFIRMING, Refusal};

/// The time that a window believes, and its length.
#[derive(Clone, Copy, Debug)]
pub(super) struct Now {
    pub time: f64,
    pub length: f64,
    /// What was believed before the window last started anew.
    pub before: Option<f64>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Side {
    Ahead,
    Back,
}

impl Now {
    /// Where a time stands, if it is no part of the window and no small step ahead of it.
    fn side(self, time: f64) -> Option<Side> {
        if time > self.time + self.length {
            Some(Side::Ahead)
        } else {
            (time < self.time - self.length).then_some(Side::Back)
        }
    }

    fn is_near(self, one: f64, other: f64) -> bool {
        (one - other).abs() <= self.length
    }

    /// Why a time outside is refused.
    fn refusal(self, side: Side, time: f64) -> Refusal {
        let newest = self.time;
        match (self.before, side) {
            (Some(before), _) if self.is_near(before, time) => Refusal::Outdated { time, before, newest },
            (_, Side::Ahead) => Refusal::Unconfirmed { time, newest },
            (_, Side::Back) => Refusal::TooLate { time, oldest: newest - self.length },
        }
    }

    /// Where times in a row stand. If they are steady, each is believed once the one before is.
    fn side_of(self, run: &Run) -> Option<Side> {
        match self.side(run.newest) {
            Some(Side::Ahead) if run.is_steady => self.side(run.oldest).filter(|side| *side == Side::Ahead),
            side => side,
        }
    }

    /// Why a time would be refused as it stands, unless it may be ahead.
    pub fn check(self, time: f64, may_be_ahead: bool) -> Result<(), Refusal> {
        match self.side(time) {
            Some(side) if side == Side::Back || !may_be_ahead => Err(self.refusal(side, time)),
            _ => Ok(()),
        }
    }
}

/// Times in a row, all on one side of the window. None is before those before by more than the window's length.
#[derive(Clone, Copy, Debug)]
pub(super) struct Run {
    side: Side,
    /// How many times it has.
    times: u64,
    oldest: f64,
    pub newest: f64,
    /// Whether none is ahead of those before by more than the window's length.
    is_steady: bool,
    /// How many words were said before it.
    begun: u64,
    /// Whether its source has committed within it.
    is_over_a_commit: bool,
    /// Its first entry among what waits.
    pub start: usize,
}

impl Run {
    /// Whether the window turns back in time.
    pub fn is_back(&self) -> bool {
        self.side == Side::Back
    }
}

/// The clock of one source.
#[derive(Clone, Debug, Default)]
pub(super) struct SourceClock {
    /// Its number, once it has said a time at a commit.
    id: Option<u64>,
    /// The newest of the times since its last commit that were inside when they came.
    pub reach: Option<f64>,
    /// The oldest of these.
    oldest: f64,
    /// How many these were.
    inside: u64,
    /// Whether none was ahead of those before by more than the window's length.
    is_steady: bool,
    /// How many words were said before the first.
    begun: u64,
    /// The last times, if they are outside.
    run: Option<Run>,
    /// After a commit that was outside and not believed: whether a further one may be.
    doubted: Option<bool>,
}

impl SourceClock {
    /// What is believed, with what the source itself has said since its last commit.
    fn reaching(&self, now: Option<Now>, time: f64) -> Option<(Now, Side)> {
        let now = now?;
        let now = Now { time: self.reach.map_or(now.time, |reach| reach.max(now.time)), ..now };
        Some((now, now.side(time)?))
    }

    fn agree(&mut self, time: f64, length: f64, count: u64, words: u64) {
        match self.reach {
            None => {
                (self.oldest, self.inside, self.begun, self.is_steady) = (time, count, words, true);
                self.reach = Some(time);
            }
            Some(reach) => {
                (self.oldest, self.inside) = (self.oldest.min(time), self.inside + count);
                self.is_steady &= time <= reach + length;
                self.reach = Some(reach.max(time));
            }
        }
        (self.run, self.doubted) = (None, None);
    }

    fn extend(&mut self, now: Now, side: Side, time: f64, count: u64, words: u64, start: usize) {
        let goes_on = |run: &Run| now.side(run.newest) == Some(side) && time >= run.newest - now.length;
        match &mut self.run {
            Some(run) if run.side == side && goes_on(run) => {
                run.times += count;
                run.is_steady &= time <= run.newest + now.length;
                (run.oldest, run.newest) = (run.oldest.min(time), run.newest.max(time));
            }
            run => {
                let (times, begun) = (count, words);
                let (oldest, newest, is_steady, is_over_a_commit) = (time, time, true, false);
                *run = Some(Run { side, times, oldest, newest, is_steady, begun, is_over_a_commit, start });
            }
        }
    }

    /// What its commit is about: its last times in a row outside, else those that were inside when they came. And where
    /// they stand, if they are outside.
    fn subject(&self, now: Option<Now>, length: f64) -> Option<(Run, Option<(Now, Side)>)> {
        let inside = self.reach.map(|newest| Run {
            side: Side::Ahead,
            times: self.inside,
            oldest: self.oldest,
            newest,
            is_steady: self.is_steady,
            begun: self.begun,
            is_over_a_commit: false,
            start: 0,
        });
        let place = |run: &Run, now: Option<Now>| now.and_then(|now| Some((now, now.side_of(run)?)));
        match (self.run, inside) {
            (None, inside) => inside.map(|run| (run, place(&run, now))),
            (Some(run), Some(inside)) if place(&inside, now).is_none() => {
                let now = now.unwrap_or(Now { time: inside.newest, length, before: None });
                let now = Now { time: now.time.max(inside.newest), ..now };
                Some((run, place(&run, Some(now))))
            }
            (Some(run), _) => Some((run, place(&run, now))),
        }
    }
}

/// What a source has said at its last commit.
#[derive(Clone, Copy, Debug)]
struct Word {
    time: f64,
    /// Its place among all words.
    heard: u64,
    /// Whether it was outside when it was said, and not believed.
    is_outside: bool,
    /// Whether it has moved the window alone, and another source has moved it back.
    is_outvoted: bool,
}

/// Why a jump is believed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Confirmation {
    /// More sources say so than do not.
    Others,
    /// Its source says so over enough times, and no other contradicts.
    Alone,
    /// It undoes what another source has said alone.
    Undone,
}

/// What becomes of the times of a commit.
#[derive(Clone, Copy, Debug)]
pub(super) enum Verdict {
    /// They agree with the window. The newest of them.
    Agreed(f64),
    /// They are outside, and believed from here on.
    Believed(Run, Confirmation),
    /// They are outside, and not believed.
    Doubted {
        /// What is believed, with what agrees of the commit.
        now: Now,
        /// Why.
        refusal: Refusal,
        /// Whether the source's commit before was believed.
        is_new: bool,
    },
}

/// A source has moved the window alone, while there were others.
#[derive(Clone, Copy, Debug)]
struct Lone {
    source: u64,
    /// What was believed before.
    before: f64,
}

/// The clocks of all sources that have said a time.
#[derive(Clone, Debug, Default)]
pub(super) struct Clocks {
    /// Of the window.
    length: f64,
    words: BTreeMap<u64, Word>,
    next_id: u64,
    /// How many words were said.
    said: u64,
    lone: Option<Lone>,
    /// The last word that was outside and not believed.
    disputed: Option<(u64, f64)>,
    /// Who said the last word that agreed with the window, and its place among all words.
    agreed: Option<(u64, u64)>,
}

impl Clocks {
    /// No source has said a time of a window of this length.
    pub fn new(length: f64) -> Self {
        Self { length, ..Self::default() }
    }

    /// A source says a time of a point, which would wait at a place. Its later commit judges.
    ///
    /// # Errors [`Refusal`], if the point shall not wait.
    pub fn say(&self, clock: &mut SourceClock, now: Option<Now>, time: f64, place: usize) -> Result<(), Refusal> {
        let Some((now, side)) = self.note(clock, now, time, 1, place) else { return Ok(()) };
        let is_near = |other: f64| now.is_near(other, time);
        let is_new = side == Side::Ahead && clock.doubted.is_none();
        let is_contradicted = self
            .agreed
            .is_some_and(|(source, heard)| Some(source) != clock.id && clock.run.is_some_and(|run| heard > run.begun));
        let may_be_believed = is_new
            || (clock.doubted == Some(true) && !is_contradicted)
            || self.lone.is_some_and(|lone| Some(lone.source) != clock.id && is_near(lone.before))
            || self.disputed.is_some_and(|(source, time)| Some(source) != clock.id && is_near(time));
        if may_be_believed { Ok(()) } else { Err(now.refusal(side, time)) }
    }

    /// Notes a time that so many points have. Where it stands, if it is outside.
    pub fn note(
        &self,
        clock: &mut SourceClock,
        now: Option<Now>,
        time: f64,
        count: u64,
        place: usize,
    ) -> Option<(Now, Side)> {
        // A source that says the first time of all is measured by itself.
        let own = clock.reach.map(|time| Now { time, length: self.length, before: None });
        let outside = clock.reaching(now.or(own), time);
        match outside {
            None => clock.agree(time, self.length, count, self.said),
            Some((now, side)) => clock.extend(now, side, time, count, self.said, place),
        }
        outside
    }

    /// A source commits. What becomes of the times that it has said since its last commit, if there are any.
    pub fn commit(&mut self, clock: &mut SourceClock, now: Option<Now>) -> Option<Verdict> {
        let (run, outside) = clock.subject(now, self.length)?;
        let id = *clock.id.get_or_insert_with(|| {
            self.next_id += 1;
            self.next_id
        });
        self.said += 1;
        let reach = clock.reach.take();
        let is_outvoted = self.words.get(&id).is_some_and(|word| word.is_outvoted);
        let mut word = Word { time: run.newest, heard: self.said, is_outside: false, is_outvoted };
        let verdict = match outside {
            Some((now, side)) => self.judge(id, clock, now, Run { side, ..run }, &mut word),
            None => {
                word.time = reach.map_or(run.newest, |reach| reach.max(run.newest));
                // Who was outvoted has to fall in with the others first.
                word.is_outvoted &= now.is_some_and(|now| word.time > now.time);
                self.lone = self.lone.filter(|lone| lone.source == id);
                (clock.run, clock.doubted) = (None, None);
                self.agreed = Some((id, self.said));
                Verdict::Agreed(word.time)
            }
        };
        self.words.insert(id, word);
        Some(verdict)
    }

    fn judge(&mut self, id: u64, clock: &mut SourceClock, now: Now, mut run: Run, word: &mut Word) -> Verdict {
        let is_near = |one, other| now.is_near(one, other);
        let others = || self.words.iter().filter(|(other, _)| **other != id).map(|(_, word)| word);
        let against = others().filter(|other| is_near(other.time, now.time)).count();
        let is_contradicted = others().any(|other| is_near(other.time, now.time) && other.heard > run.begun);
        let with = others()
            .filter(|other| other.is_outside && is_near(other.time, run.newest) && !is_near(other.time, now.time));
        let with = with.count();
        let may_go_alone = !(is_contradicted || word.is_outvoted && against > 0);
        let is_alone = run.times >= CONFIRMING
            && may_go_alone
            && (run.is_over_a_commit || (run.side == Side::Ahead && against == 0));
        let undone = self.lone.filter(|lone| lone.source != id && is_near(lone.before, run.newest));
        let confirmation = if let Some(lone) = undone {
            if let Some(word) = self.words.get_mut(&lone.source) {
                word.is_outvoted = true;
            }
            Confirmation::Undone
        } else if with > 0 && with + 1 > against {
            Confirmation::Others
        } else if is_alone {
            Confirmation::Alone
        } else {
            word.is_outside = true;
            self.disputed = Some((id, run.newest));
            let is_new = clock.doubted.replace(may_go_alone).is_none();
            (run.is_over_a_commit, run.start) = (true, 0);
            // A source that is contradicted has to begin again.
            clock.run = Some(run).filter(|_| !is_contradicted);
            return Verdict::Doubted { now, refusal: now.refusal(run.side, run.newest), is_new };
        };
        // A source that goes on alone still stands against what was believed before it did.
        let before = self.lone.filter(|lone| lone.source == id).map_or(now.time, |lone| lone.before);
        let is_lone = confirmation == Confirmation::Alone && self.words.keys().any(|other| *other != id);
        self.lone = is_lone.then_some(Lone { source: id, before });
        word.is_outvoted &= confirmation == Confirmation::Alone;
        (clock.run, clock.doubted, self.agreed) = (None, None, None);
        Verdict::Believed(run, confirmation)
    }

    /// A source is gone: its clock counts no more.
    pub fn forget(&mut self, clock: &mut SourceClock) {
        if let Some(id) = std::mem::take(clock).id {
            self.words.remove(&id);
            self.disputed = self.disputed.filter(|(source, _)| *source != id);
        }
    }

    /// About how many bytes it takes.
    pub fn bytes(&self) -> usize {
        self.words.len() * size_of::<(u64, Word)>()
    }
}
