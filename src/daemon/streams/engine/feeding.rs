//! Feeding: what an engine does with the items of its queue.
//!
//! In: points, retractions and commits of producers and of stdin. Out: the same in the pipeline, replies.
//!
//! Invariants: every point is counted, and answered if it is a producer's. What is refused is counted in the frame that
//! it was meant for.
//!
//! Must not know: consumers, how frames are published.

use std::sync::atomic::Ordering;
use std::time::Instant;

use hopes::topology::{VertexId, Window};

use super::Engine;
use crate::daemon::streams::error::EngineError;
use crate::daemon::streams::input::{Batch, Input};
use crate::daemon::streams::queue::{Item, Origin};
use crate::daemon::streams::reply::{BatchReply, RefusalReason, ReplyTo};

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

    fn commit(&mut self, time: Option<f64>, origin: &Origin) -> Result<(), EngineError> {
        self.feed_uncommitted(origin);
        if let Some(Err(refusal)) = time.map(|time| self.pipeline.feed_time(time)) {
            self.rejected += 1;
            if matches!(origin, Origin::Stdin) {
                self.input_errors.add(&refusal)?;
            }
        }
        self.close_frame(time.filter(|time| time.is_finite()))?;
        if let Origin::Producer(reply_to) = origin {
            reply_to.committed(self.pipeline.committed());
        }
        Ok(())
    }

    /// Feeds what a producer has sent since its last commit.
    fn feed_uncommitted(&mut self, origin: &Origin) {
        let Origin::Producer(reply_to) = origin else { return };
        let begun = Instant::now();
        let fed = self.uncommitted.feed(reply_to.sink(), &mut self.pipeline);
        self.pending |= fed.is_any;
        self.rejected += fed.rejected;
        self.newest_time = fed.newest_time.into_iter().chain(self.newest_time).reduce(f64::max);
        self.worked += begun.elapsed();
    }

    /// Forgets what a producer has sent since its last commit.
    fn discard(&mut self, origin: &Origin) {
        let Origin::Producer(reply_to) = origin else { return };
        let points = self.uncommitted.discard(reply_to.sink(), &mut self.pipeline);
        if points > 0 {
            let name = &self.stream.state.name;
            tracing::info!("stream {name:?}: {points} points are left out: their producer has ended without a commit");
        }
        self.update_stats();
    }

    fn close_source(&mut self, ends_stream: bool, origin: &Origin) -> Result<(), EngineError> {
        // What stdin has said after its last commit is a frame.
        if matches!(origin, Origin::Stdin) && self.pending {
            self.close_frame(None)?;
        }
        if ends_stream {
            // The end of the stream is a commit of the producer that ends it.
            self.feed_uncommitted(origin);
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
        let (accepted, rejected) =
            (self.stream.state.stats.accepted.load(Ordering::Relaxed), self.input_errors.count());
        if ends_stream && accepted == 0 && rejected > 0 {
            return Err(EngineError::NothingUsable { rejected });
        }
        Ok(())
    }

    /// Whether the stream's frames are closed by its producers alone.
    fn has_commits_only(&self) -> bool {
        self.settings.frame_points.is_none() && self.settings.frame_every.is_none()
    }

    fn insert(&mut self, batch: &Batch, origin: &Origin) -> Result<(), EngineError> {
        let mut reply = BatchReply::new(batch);
        match origin {
            Origin::Producer(reply_to) if self.has_commits_only() => self.stage(&mut reply, batch, reply_to),
            _ => self.insert_now(&mut reply, batch)?,
        }
        self.update_stats();
        self.stream.state.stats.accepted.fetch_add(reply.accepted(), Ordering::Relaxed);
        self.stream.state.stats.refused.fetch_add(reply.refused(), Ordering::Relaxed);
        send(reply, origin);
        Ok(())
    }

    /// Has points wait for their producer's commit.
    fn stage(&mut self, reply: &mut BatchReply, batch: &Batch, reply_to: &ReplyTo) {
        let begun = Instant::now();
        let no_room = self.no_room();
        let (limit, mut room) = (self.limits.points, self.room_for_points());
        let source = self.uncommitted.of(reply_to.sink());
        for (index, &(x, y)) in batch.positions.iter().enumerate() {
            let time = batch.times.get(index).copied();
            let placed = match &no_room {
                Some(full) => Err(full.clone()),
                None if room == 0 => Err(RefusalReason::StreamFull { what: "points", limit }),
                None => self.pipeline.stage_point(&mut source.staging, x, y, time).map_err(RefusalReason::Refused),
            };
            match placed {
                Ok(vertex) => {
                    reply.accept(batch, index, vertex);
                    room -= 1;
                }
                Err(reason) => {
                    reply.refuse(index, &reason);
                    source.rejected += 1;
                }
            }
        }
        source.note_size();
        self.worked += begun.elapsed();
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
        for (index, &(x, y)) in batch.positions.iter().enumerate() {
            self.pending = true;
            let time = batch.times.get(index).copied();
            let placed = match &no_room {
                Some(full) => Err(full.clone()),
                None => self.insert_one(x, y, time),
            };
            self.note(reply, batch, index, placed)?;
            if self.settings.frame_points.is_some_and(|limit| self.points >= limit) {
                self.worked += begun.elapsed();
                self.close_frame(None)?;
                begun = Instant::now();
            }
        }
        self.worked += begun.elapsed();
        Ok(())
    }

    fn insert_one(&mut self, x: f64, y: f64, time: Option<f64>) -> Result<VertexId, RefusalReason> {
        if self.room_for_points() == 0 {
            return Err(RefusalReason::StreamFull { what: "points", limit: self.limits.points });
        }
        let vertex = self.pipeline.feed_point(x, y, time).map_err(RefusalReason::Refused)?;
        self.points += 1;
        self.newest_time = time.into_iter().chain(self.newest_time).reduce(f64::max);
        Ok(vertex)
    }

    fn retract(&mut self, batch: &Batch, origin: &Origin) -> Result<(), EngineError> {
        let mut reply = BatchReply::new(batch);
        match origin {
            Origin::Producer(reply_to) if self.has_commits_only() => {
                self.stage_retractions(&mut reply, batch, reply_to);
            }
            _ => self.retract_now(&mut reply, batch)?,
        }
        self.update_stats();
        self.stream.state.stats.refused.fetch_add(reply.refused(), Ordering::Relaxed);
        send(reply, origin);
        Ok(())
    }

    fn stage_retractions(&mut self, reply: &mut BatchReply, batch: &Batch, reply_to: &ReplyTo) {
        let begun = Instant::now();
        let source = self.uncommitted.of(reply_to.sink());
        for (index, &(x, y)) in batch.positions.iter().enumerate() {
            match self.pipeline.stage_retraction(&mut source.staging, x, y) {
                Ok(()) => reply.accept(batch, index, VertexId(0)),
                Err(refusal) => {
                    reply.refuse(index, &RefusalReason::Refused(refusal));
                    source.rejected += 1;
                }
            }
        }
        source.note_size();
        self.worked += begun.elapsed();
    }

    fn retract_now(&mut self, reply: &mut BatchReply, batch: &Batch) -> Result<(), EngineError> {
        self.pending = true;
        let begun = Instant::now();
        for (index, &(x, y)) in batch.positions.iter().enumerate() {
            let retracted = self.pipeline.feed_retraction(x, y).map(|()| VertexId(0)).map_err(RefusalReason::Refused);
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
                if let Some(line) = batch.lines.get(index) {
                    let (x, y) = batch.positions[index];
                    self.input_errors.add(&format_args!("{} {line}, point ({x}, {y}): {reason}", batch.place))?;
                }
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

/// Replies to a producer; stdin gets no reply.
fn send(reply: BatchReply, origin: &Origin) {
    if let Origin::Producer(reply_to) = origin {
        reply.send(reply_to);
    }
}
