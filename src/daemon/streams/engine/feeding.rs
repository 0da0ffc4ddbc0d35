//! Feeding: what an engine does with the points of its queue.
//!
//! In: points and retractions of producers and of stdin. Out: the same in the pipeline, or waiting for their commits;
//! replies.
//!
//! Invariants: every point is counted, and answered if it is a producer's. What is refused is counted in the frame that
//! it was meant for.
//!
//! Must not know: consumers, how frames are published.

use std::fmt::Display;
use std::sync::atomic::Ordering;
use std::time::Instant;

use hopes::topology::{FirstCoordinates, VertexId, Window};

use super::Engine;
use super::uncommitted::Place;
use crate::daemon::input_errors::{InputErrors, StrictStop};
use crate::daemon::streams::error::EngineError;
use crate::daemon::streams::input::{Batch, Input, Point};
use crate::daemon::streams::queue::{Item, Origin};
use crate::daemon::streams::reply::{BatchReply, RefusalReason};

impl Engine {
    pub(super) fn take(&mut self, item: Item) -> Result<(), EngineError> {
        let Item { input, origin } = item;
        match input {
            Input::Points(batch) => self.insert(&batch, &origin)?,
            Input::Retract(batch) => self.retract(&batch, &origin)?,
            Input::Commit(time) => self.commit(time, &origin)?,
            Input::Close { end } => self.close_source(end, &origin)?,
            Input::Abandon => self.discard(&origin),
            Input::Unreadable(error) => {
                (self.pending, self.rejected) = (true, self.rejected + 1);
                self.input_errors.add(&error)?;
            }
            Input::Failed(reason) => return Err(EngineError::Source(reason)),
        }
        Ok(())
    }

    fn insert(&mut self, batch: &Batch, origin: &Origin) -> Result<(), EngineError> {
        self.settle_dimension(batch);
        let mut reply = BatchReply::new(batch);
        if self.waits(origin) {
            self.stage(&mut reply, batch, origin)?;
        } else {
            self.insert_now(&mut reply, batch)?;
        }
        self.update_stats();
        self.stream.state.stats.accepted.fetch_add(reply.accepted(), Ordering::Relaxed);
        self.stream.state.stats.refused.fetch_add(reply.refused(), Ordering::Relaxed);
        send(reply, origin);
        Ok(())
    }

    /// The first points of a space have the dimension of all that follow.
    fn settle_dimension(&mut self, batch: &Batch) {
        if let (Some(space), Some(dimension)) = (&self.stream.state.space, batch.positions.dimension()) {
            self.pipeline.fix_dimension(space.settle(dimension));
        }
    }

    /// Has points wait for their commit, or for the end of a frame that closes by itself.
    fn stage(&mut self, reply: &mut BatchReply, batch: &Batch, origin: &Origin) -> Result<(), EngineError> {
        self.pending |= self.joins_by_itself(origin);
        let mut next = 0;
        while next < batch.positions.len() {
            let limit = self.settings.frame_points.unwrap_or(u64::MAX);
            let before = reply.accepted();
            next = self.stage_some(reply, batch, origin, next, limit)?;
            if limit < u64::MAX {
                self.points += reply.accepted() - before;
                if self.points >= limit || self.outside >= limit {
                    self.close_by_itself()?;
                }
            }
        }
        Ok(())
    }

    /// Has points from `next` on wait, until the frame in hand has as many as it may. Returns the next one.
    fn stage_some(
        &mut self,
        reply: &mut BatchReply,
        batch: &Batch,
        origin: &Origin,
        mut next: usize,
        limit_of_frame: u64,
    ) -> Result<usize, EngineError> {
        let begun = Instant::now();
        let no_room = self.no_room();
        let (limit, mut room) = (self.limits.points, self.room_for_points());
        let enough = reply.accepted().saturating_add(limit_of_frame.saturating_sub(self.points).max(1));
        let source = self.uncommitted.of(origin.producer(), &self.pipeline);
        while next < batch.positions.len() && reply.accepted() < enough && self.outside < limit_of_frame {
            let (point, time) = (batch.positions.get(next), batch.times.get(next).copied());
            let placed = match &no_room {
                Some(full) => Err(full.clone()),
                None if room == 0 => Err(RefusalReason::StreamFull { what: "points", limit }),
                None => self.pipeline.stage_point(&mut source.staging, point, time).map_err(RefusalReason::Refused),
            };
            match placed {
                Ok(vertex) => {
                    reply.accept(batch, next, vertex);
                    source.places.extend(place(batch, next));
                    room -= 1;
                }
                Err(reason) => {
                    source.rejected += 1;
                    self.outside += u64::from(reason.is_outside_window());
                    report(&mut self.input_errors, place(batch, next), &reason)?;
                    reply.refuse(next, &reason);
                }
            }
            next += 1;
        }
        source.note_size();
        self.worked += begun.elapsed();
        Ok(next)
    }

    /// Points that the stream may still take.
    fn room_for_points(&self) -> u64 {
        let limit = self.limits.points;
        // In a window of so many points the oldest leaves when one comes.
        let makes_room = matches!(self.settings.options.window, Window::Points(length) if length.get() <= limit);
        let taken = self.pipeline.point_count() + self.uncommitted.point_count();
        if makes_room { u64::MAX } else { limit.saturating_sub(taken) }
    }

    fn insert_now(&mut self, reply: &mut BatchReply, batch: &Batch) -> Result<(), EngineError> {
        let no_room = self.no_room();
        let mut begun = Instant::now();
        for index in 0..batch.positions.len() {
            self.pending = true;
            let time = batch.times.get(index).copied();
            let placed = match &no_room {
                Some(full) => Err(full.clone()),
                None => self.insert_one(batch.positions.get(index), time),
            };
            self.note(reply, batch, index, placed)?;
            if self.settings.frame_points.is_some_and(|limit| self.points >= limit) {
                self.worked += begun.elapsed();
                self.close_by_itself()?;
                begun = Instant::now();
            }
        }
        self.worked += begun.elapsed();
        Ok(())
    }

    fn insert_one(&mut self, point: Point, time: Option<f64>) -> Result<VertexId, RefusalReason> {
        if self.room_for_points() == 0 {
            return Err(RefusalReason::StreamFull { what: "points", limit: self.limits.points });
        }
        let vertex = self.pipeline.feed_point(point, time).map_err(RefusalReason::Refused)?;
        self.points += 1;
        self.newest_time = time.into_iter().chain(self.newest_time).reduce(f64::max);
        Ok(vertex)
    }

    fn retract(&mut self, batch: &Batch, origin: &Origin) -> Result<(), EngineError> {
        let mut reply = BatchReply::new(batch);
        if self.waits(origin) {
            self.stage_retractions(&mut reply, batch, origin)?;
        } else {
            self.retract_now(&mut reply, batch)?;
        }
        self.update_stats();
        self.stream.state.stats.refused.fetch_add(reply.refused(), Ordering::Relaxed);
        send(reply, origin);
        Ok(())
    }

    fn stage_retractions(&mut self, reply: &mut BatchReply, batch: &Batch, origin: &Origin) -> Result<(), EngineError> {
        self.pending |= self.joins_by_itself(origin);
        let begun = Instant::now();
        let source = self.uncommitted.of(origin.producer(), &self.pipeline);
        for index in 0..batch.positions.len() {
            match self.pipeline.stage_retraction(&mut source.staging, batch.positions.get(index)) {
                Ok(()) => {
                    reply.accept(batch, index, VertexId(0));
                    source.places.extend(place(batch, index));
                }
                Err(refusal) => {
                    source.rejected += 1;
                    report(&mut self.input_errors, place(batch, index), &refusal)?;
                    reply.refuse(index, &RefusalReason::Refused(refusal));
                }
            }
        }
        source.note_size();
        self.worked += begun.elapsed();
        Ok(())
    }

    fn retract_now(&mut self, reply: &mut BatchReply, batch: &Batch) -> Result<(), EngineError> {
        self.pending = true;
        let begun = Instant::now();
        for index in 0..batch.positions.len() {
            let point = batch.positions.get(index);
            let retracted = self.pipeline.feed_retraction(point).map(|()| VertexId(0)).map_err(RefusalReason::Refused);
            self.note(reply, batch, index, retracted)?;
        }
        self.worked += begun.elapsed();
        Ok(())
    }

    /// Counts what became of a point.
    fn note(
        &mut self,
        reply: &mut BatchReply,
        batch: &Batch,
        index: usize,
        placed: Result<VertexId, RefusalReason>,
    ) -> Result<(), EngineError> {
        match placed {
            Ok(vertex) => reply.accept(batch, index, vertex),
            Err(reason) => {
                self.rejected += 1;
                report(&mut self.input_errors, place(batch, index), &reason)?;
                reply.refuse(index, &reason);
            }
        }
        Ok(())
    }

    /// Why no batch can be taken now, if that is so.
    fn no_room(&self) -> Option<RefusalReason> {
        let limits = &self.limits;
        if self.pipeline.vertex_count() as u64 >= limits.vertices {
            return Some(RefusalReason::StreamFull { what: "distinct positions", limit: limits.vertices });
        }
        // What consumers take is dropped before points are refused.
        let (held, limit) = (self.memory.points.held(), self.memory.limit);
        self.memory.is_full_of_points().then_some(RefusalReason::DaemonFull { held, limit })
    }
}

/// Where a point stands in the input, if it is one of stdin.
fn place(batch: &Batch, index: usize) -> Option<Place> {
    let point = || batch.positions.get(index).with_coordinates(|point| FirstCoordinates::from(point));
    batch.lines.get(index).map(|&line| Place { line, unit: batch.place, point: point() })
}

/// Counts and logs a point of stdin that is refused. A producer's is in the reply.
pub(super) fn report(
    input_errors: &mut InputErrors,
    place: Option<Place>,
    reason: &dyn Display,
) -> Result<(), StrictStop> {
    let Some(Place { line, unit, point }) = place else { return Ok(()) };
    input_errors.add(&format_args!("{unit} {line}, point {point}: {reason}"))
}

/// Replies to a producer; stdin gets no reply.
fn send(reply: BatchReply, origin: &Origin) {
    if let Origin::Producer(reply_to) = origin {
        reply.send(reply_to);
    }
}
