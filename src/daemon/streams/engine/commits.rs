//! Commits: how the frames of a stream are closed, and what they have.
//!
//! In: commits and ends of producers and of stdin; what waits for them. Out: frames.
//!
//! Invariants: a frame has what its source has sent since its last commit, dated by the commit in a time window. What
//! a commit refuses is counted in its frame, and told: with its line if it is stdin's, else in the log and the metrics.
//!
//! Must not know: consumers, how frames are published.

use std::sync::atomic::Ordering;
use std::time::Instant;

use hopes::topology::{Confirmation, Restart, Window};

use super::Engine;
use super::feeding::report;
use super::uncommitted::Fed;
use crate::daemon::streams::error::EngineError;
use crate::daemon::streams::queue::Origin;

impl Engine {
    pub(super) fn commit(&mut self, time: Option<f64>, origin: &Origin) -> Result<(), EngineError> {
        let time = if self.waits(origin) { self.feed_source(time, origin)? } else { self.pass_time(time, origin)? };
        if self.is_timed() && !self.has_commits_only() {
            self.feed_joined()?;
        }
        self.close_frame(time)?;
        if let Origin::Producer(reply_to) = origin {
            reply_to.committed(self.pipeline.committed());
        }
        Ok(())
    }

    /// Closes a frame that nobody has committed.
    pub(super) fn close_by_itself(&mut self) -> Result<(), EngineError> {
        if self.is_timed() {
            self.feed_joined()?;
        }
        self.close_frame(None)
    }

    /// Whether points of a source wait for the end of their frame. In a time window all do: it dates them.
    pub(super) fn waits(&self, origin: &Origin) -> bool {
        self.is_timed() || (matches!(origin, Origin::Producer(_)) && self.has_commits_only())
    }

    /// Whether what comes from a source is in the next frame, whoever closes it.
    pub(super) fn joins_by_itself(&self, origin: &Origin) -> bool {
        matches!(origin, Origin::Stdin) || !self.has_commits_only()
    }

    pub(super) fn is_timed(&self) -> bool {
        matches!(self.settings.options.window, Window::Time(_))
    }

    /// Whether the stream's frames are closed by its producers alone.
    fn has_commits_only(&self) -> bool {
        self.settings.frame_points.is_none() && self.settings.frame_every.is_none()
    }

    /// Moves event time to that of a commit for which nothing waits. Returns the time, if it can be used.
    fn pass_time(&mut self, time: Option<f64>, origin: &Origin) -> Result<Option<f64>, EngineError> {
        if let Some(Err(refusal)) = time.map(|time| self.pipeline.feed_time(time)) {
            self.rejected += 1;
            if matches!(origin, Origin::Stdin) {
                self.input_errors.add(&refusal)?;
            }
        }
        Ok(time.filter(|time| time.is_finite()))
    }

    /// Feeds what a source has sent since its last commit. Returns the commit's time, if it counts.
    fn feed_source(&mut self, time: Option<f64>, origin: &Origin) -> Result<Option<f64>, EngineError> {
        let begun = Instant::now();
        let fed = self.uncommitted.feed(origin.producer(), &mut self.pipeline, time);
        self.worked += begun.elapsed();
        let (time, time_refused) = (fed.admission.time, fed.admission.time_refused);
        if let Some(refusal) = time_refused.filter(|_| fed.admission.refused == 0) {
            self.rejected += 1;
            if matches!(origin, Origin::Stdin) {
                self.input_errors.add(&refusal)?;
            }
        }
        self.note_fed(fed)?;
        Ok(time)
    }

    /// Feeds what waits for a frame that nobody commits.
    fn feed_joined(&mut self) -> Result<(), EngineError> {
        let begun = Instant::now();
        let all = match self.has_commits_only() {
            true => vec![self.uncommitted.feed(None, &mut self.pipeline, None)],
            false => self.uncommitted.feed_all(&mut self.pipeline),
        };
        self.worked += begun.elapsed();
        all.into_iter().try_for_each(|fed| self.note_fed(fed))
    }

    /// Counts and tells what a commit has done.
    fn note_fed(&mut self, fed: Fed) -> Result<(), EngineError> {
        let Fed { is_any, rejected, admission, newest_time, refused, first } = fed;
        self.pending |= is_any;
        self.rejected += rejected + admission.refused;
        self.newest_time = match self.is_timed() {
            true => self.pipeline.event_time(),
            false => newest_time.into_iter().chain(self.newest_time).reduce(f64::max),
        };
        let (name, stats) = (&self.stream.state.name, &self.stream.state.stats);
        stats.refused_late.fetch_add(admission.refused, Ordering::Relaxed);
        if let Some(Restart { before, newest, confirmation }) = admission.restart {
            stats.restarts.fetch_add(1, Ordering::Relaxed);
            let why = match confirmation {
                Confirmation::Others => "most producers say so",
                Confirmation::Alone => "its producer says so again and again, and no other contradicts",
                Confirmation::Undone => "only one producer had said otherwise",
            };
            tracing::warn!("stream {name:?}: the time window starts anew: {before} was believed, now {newest}: {why}");
        }
        if let Some(doubt) = admission.doubt {
            tracing::warn!("stream {name:?}: a producer is outside the time window: {doubt}");
        } else if let Some(first) = first.filter(|_| refused.is_empty()) {
            let count = admission.refused;
            tracing::warn!("stream {name:?}: {count} points are refused at their producer's commit: {first}");
        }
        refused.iter().try_for_each(|(place, refusal)| report(&mut self.input_errors, Some(*place), refusal))?;
        Ok(())
    }

    /// Forgets what a producer has sent since its last commit.
    pub(super) fn discard(&mut self, origin: &Origin) {
        let Origin::Producer(reply_to) = origin else { return };
        let points = self.uncommitted.discard(Some(reply_to.sink()), &mut self.pipeline);
        if points > 0 {
            let name = &self.stream.state.name;
            tracing::info!("stream {name:?}: {points} points are left out: their producer has ended without a commit");
        }
        self.update_stats();
    }

    pub(super) fn close_source(&mut self, ends_stream: bool, origin: &Origin) -> Result<(), EngineError> {
        // What stdin has said after its last commit is a frame.
        if matches!(origin, Origin::Stdin) && self.pending {
            self.close_by_itself()?;
        }
        if ends_stream {
            // The end of the stream is a commit of the producer that ends it.
            if self.waits(origin) {
                self.feed_source(None, origin)?;
            }
            self.close_last_frame()?;
            // A producer may open the name anew as soon as it gets the reply: the name must be free by then.
            self.stream.queue.close();
            self.roster.remove(&self.stream);
            self.is_over = true;
        }
        self.discard(origin);
        if let Origin::Producer(reply_to) = origin {
            self.stream.remove_producer(reply_to.sink());
            reply_to.sink().close(self.pipeline.committed());
        }
        let stats = &self.stream.state.stats;
        let accepted = stats.accepted.load(Ordering::Relaxed);
        let refused_late = stats.refused_late.load(Ordering::Relaxed);
        let rejected = self.input_errors.count();
        if ends_stream && accepted <= refused_late && rejected > 0 {
            return Err(EngineError::NothingUsable { rejected });
        }
        Ok(())
    }
}
