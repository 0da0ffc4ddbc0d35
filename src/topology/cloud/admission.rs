//! What a commit does with the points that wait for it.
//!
//! In: what waits of a source, the commit's time.
//! Out: the same in the cloud, each point dated; what is refused by now, and why; whether the time window starts anew.
//! Invariants: a point without a time of its own is of the commit's time, or of the newest time known where the commit
//! has none. A time that is not believed dates nothing, and moves nothing.
//! Must not know: who the sources are.

use super::clocks::{Confirmation, Now, Run, Verdict};
use super::refusal::Refusal;
use super::site::Site;
use super::staging::{Staged, StagedPoint, Staging};
use super::store::Cloud;
use super::window::Window;

/// What a commit has done.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Admission {
    /// Points and retractions that were refused.
    pub refused: u64,
    /// The commit's time, if it has one that counts.
    pub time: Option<f64>,
    /// Why the commit's time does not count.
    pub time_refused: Option<Refusal>,
    /// The time window has started anew.
    pub restart: Option<Restart>,
    /// From this commit on the source is outside the time window, and not believed.
    pub doubt: Option<Refusal>,
}

/// A time window has started anew.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Restart {
    /// What was believed before.
    pub before: f64,
    /// The newest time that is believed.
    pub newest: f64,
    /// Why.
    pub confirmation: Confirmation,
}

/// How points of a commit are dated.
struct Dating {
    /// The time of points without one.
    date: Result<f64, Refusal>,
    /// Times in a row that are believed though they are outside.
    jump: Option<Run>,
    /// The first entry that comes after the jump.
    begin: usize,
    is_beyond: bool,
}

impl<S: Site> Cloud<S> {
    /// The newest event time that is believed.
    pub fn event_time(&self) -> Option<f64> {
        self.newest_time
    }

    /// Gives the cloud what waits, in order, at a commit with a time. Calls `refused` for what it refuses by now, with
    /// its place in what was staged.
    pub fn admit(
        &mut self,
        staging: &mut Staging<S>,
        time: Option<f64>,
        refused: &mut dyn FnMut(usize, Refusal),
    ) -> Admission {
        let not_finite = time.filter(|time| !time.is_finite()).map(Refusal::TimeNotFinite);
        let time = time.filter(|time| time.is_finite());
        let (mut dating, mut admission) = match self.window {
            Window::Time(_) => self.judge(staging, time),
            _ => (Dating::by_frame(self.frame), Admission { time, ..Admission::default() }),
        };
        admission.time_refused = admission.time_refused.or(not_finite);
        self.coming = admission.time;
        for (place, staged) in staging.take().into_iter().enumerate() {
            self.reach(&mut dating, place);
            let admitted = match staged {
                Staged::Point(point) => self.admit_point(&point, &dating),
                Staged::Retraction(position) => {
                    self.retract_at(&position).map(drop).ok_or_else(|| position.not_there())
                }
            };
            if let Err(refusal) = admitted {
                admission.refused += 1;
                refused(place, refusal);
            }
        }
        self.reach(&mut dating, usize::MAX);
        self.coming = None;
        let newest = [self.newest_time, admission.time, dating.jump.map(|run| run.newest)];
        self.newest_time = newest.into_iter().flatten().reduce(f64::max);
        self.expire();
        if let Some(restart) = &mut admission.restart {
            restart.newest = self.newest_time.unwrap_or(restart.newest);
        }
        admission
    }

    /// What is believed in a time window.
    pub(super) fn now(&self) -> Option<Now> {
        let Window::Time(length) = self.window else { return None };
        Some(Now { time: self.newest_time?, length, before: self.before })
    }

    /// Decides what becomes of the times of a commit.
    fn judge(&mut self, staging: &mut Staging<S>, time: Option<f64>) -> (Dating, Admission) {
        let now = self.now();
        if let Some(time) = time {
            let points = staging.undated.max(1);
            self.clocks.note(&mut staging.clock, now, time, points, staging.waiting.len());
        }
        let mut admission = Admission { time, ..Admission::default() };
        let believed = now.map(|now| now.time);
        let (mut known, mut jump) = (believed, None);
        match self.clocks.commit(&mut staging.clock, now) {
            None => {}
            Some(Verdict::Agreed(newest)) => known = Some(known.map_or(newest, |known| known.max(newest))),
            Some(Verdict::Believed(run, confirmation)) => {
                (known, jump) = (Some(run.newest), Some(run));
                // Where nothing was believed, nothing starts anew.
                admission.restart = believed.map(|before| Restart { before, newest: run.newest, confirmation });
            }
            Some(Verdict::Doubted { now, refusal, is_new }) => {
                known = Some(now.time);
                admission.doubt = Some(refusal).filter(|_| is_new);
                (admission.time, admission.time_refused) = (None, time.map(|_| refusal));
            }
        }
        let date = admission.time_refused.map_or(time.or(known).ok_or(Refusal::NoTime), Err);
        // Points that the commit dates must not go with what was there before.
        let begin = jump.map_or(usize::MAX, |run| if run.is_back() && staging.undated > 0 { 0 } else { run.start });
        (Dating { date, jump, begin, is_beyond: false }, admission)
    }

    /// Starts the window anew where the entries of a jump begin.
    fn reach(&mut self, dating: &mut Dating, place: usize) {
        let Some(run) = dating.jump.filter(|_| place >= dating.begin && !dating.is_beyond) else { return };
        dating.is_beyond = true;
        self.before = self.newest_time;
        if run.is_back() {
            self.expire_below(f64::INFINITY);
            self.newest_time = None;
        }
    }

    fn admit_point(&mut self, point: &StagedPoint<S>, dating: &Dating) -> Result<(), Refusal> {
        let key = self.date(point, dating);
        match key.and_then(|key| self.make_room(&point.place.position).map(|()| key)) {
            Ok(key) => {
                let slot = self.take_awaited(&point.place)?;
                self.arrive(slot, key);
                Ok(())
            }
            Err(refusal) => {
                self.give_up(&point.place);
                Err(refusal)
            }
        }
    }

    /// The key of a point in the window.
    fn date(&mut self, point: &StagedPoint<S>, dating: &Dating) -> Result<f64, Refusal> {
        if !matches!(self.window, Window::Time(_)) {
            return dating.date;
        }
        let Some(time) = point.time else { return dating.date };
        if let Some(now) = self.now() {
            now.check(time, dating.is_beyond)?;
        }
        self.note_time(time)?;
        Ok(time)
    }
}

impl Dating {
    /// In windows that know no time.
    fn by_frame(frame: u64) -> Self {
        Self { date: Ok(frame as f64), jump: None, begin: usize::MAX, is_beyond: false }
    }
}
