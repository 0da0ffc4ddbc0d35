//! What a peer does as a producer: opening streams, feeding them, closing its channels.
//!
//! In: messages of a peer. Out: items for the queues of streams, replies.
//!
//! Invariants: a message that does not fit its stream is answered with an error, and feeds nothing.
//!
//! Must not know: consumers, bytes, what engines do.

use std::sync::Arc;

use hopes_protocol::{self as wire, ErrorCode, Message};

use super::super::administration::Refused;
use super::super::outbox::PendingAnswer;
use super::super::producer::ProducerChannel;
use super::super::space_points::SpacePoints;
use super::{Channel, Session};
use crate::daemon::streams::convert;
use crate::daemon::streams::directory::Wanted;
use crate::daemon::streams::input::{Batch, Input, Positions};
use crate::daemon::streams::queue::{Closed, Item, Origin};
use crate::daemon::streams::reply::{ReplySink, ReplyTo};
use crate::daemon::streams::stream_state::StreamState;

impl Session<'_> {
    pub(super) fn open(&mut self, channel: u32, wanted: &Wanted) -> Result<(), Refused> {
        self.check_room(channel)?;
        let (outbox, account) = (Arc::clone(&self.connection.outbox), Arc::clone(&self.connection.consumer.account));
        let producer = Arc::new(ProducerChannel::new(channel, outbox, account));
        let sink: Arc<dyn ReplySink> = Arc::clone(&producer) as _;
        loop {
            let may_make = self.streams_made() < self.directory.limits.peer_streams;
            let (stream, created) = self.directory.open(wanted, may_make).map_err(|error| (error.code, error.text))?;
            if created {
                self.made.push(Arc::downgrade(&stream));
            }
            let opened = wire::Opened {
                stream: stream.state.number,
                epoch: stream.state.epoch,
                created,
                window: convert::wire_window(stream.state.options.window),
                resolution: stream.state.options.resolution,
                frame: stream.state.stats.frame(),
                largest_batch: self.directory.limits.largest_batch,
            };
            // A stream that has just ended takes no producer; the next round opens another one.
            let welcome = || self.connection.send(channel, opened_of(opened, &stream.state));
            if stream.add_producer(&sink, welcome) {
                self.set_channel(channel, Channel::Producer(producer, stream));
                return Ok(());
            }
        }
    }

    /// Streams that the peer has made and that are still there.
    fn streams_made(&mut self) -> usize {
        self.made.retain(|stream| stream.upgrade().is_some_and(|stream| !stream.has_ended()));
        self.made.len()
    }

    pub(super) fn batch(
        &mut self,
        channel: u32,
        batch: wire::Batch,
        mut pending: PendingAnswer,
    ) -> Result<(), Refused> {
        let wire::Batch { sequence, points, times, tags } = batch;
        // Each tag is answered with itself and an id.
        pending.expect(16 * tags.len());
        check_counts(points.len(), &times, &tags)?;
        self.check_size(points.len())?;
        self.check_plane(channel)?;
        let batch = Batch { positions: Positions::Plane(points), times, tags, ..Batch::default() };
        self.feed(channel, Input::Points(batch), sequence, Some(pending))
    }

    pub(super) fn retract(
        &mut self,
        channel: u32,
        retract: wire::Retract,
        pending: PendingAnswer,
    ) -> Result<(), Refused> {
        self.check_size(retract.points.len())?;
        self.check_plane(channel)?;
        let batch = Batch { positions: Positions::Plane(retract.points), ..Batch::default() };
        self.feed(channel, Input::Retract(batch), retract.sequence, Some(pending))
    }

    pub(super) fn space_batch(
        &mut self,
        channel: u32,
        batch: wire::SpaceBatch,
        mut pending: PendingAnswer,
    ) -> Result<(), Refused> {
        let wire::SpaceBatch { sequence, dimension, coordinates, times, tags } = batch;
        pending.expect(16 * tags.len());
        let points = SpacePoints::new(dimension, coordinates)?;
        check_counts(points.len(), &times, &tags)?;
        self.check_size(points.len())?;
        self.check_space(channel, &points)?;
        let batch = Batch { positions: points.into_positions(), times, tags, ..Batch::default() };
        self.feed(channel, Input::Points(batch), sequence, Some(pending))
    }

    pub(super) fn space_retract(
        &mut self,
        channel: u32,
        retract: wire::SpaceRetract,
        pending: PendingAnswer,
    ) -> Result<(), Refused> {
        let points = SpacePoints::new(retract.dimension, retract.coordinates)?;
        self.check_size(points.len())?;
        self.check_space(channel, &points)?;
        let batch = Batch { positions: points.into_positions(), ..Batch::default() };
        self.feed(channel, Input::Retract(batch), retract.sequence, Some(pending))
    }

    /// Whether the stream of a channel takes points of the plane.
    fn check_plane(&self, channel: u32) -> Result<(), Refused> {
        match self.channels.get(&channel) {
            Some(Channel::Producer(_, stream)) if stream.state.space.is_some() => {
                let name = &stream.state.name;
                let text = format!("stream {name:?} is of points in R^d: send SpaceBatch and SpaceRetract");
                Err((ErrorCode::OtherSpace, text))
            }
            _ => Ok(()),
        }
    }

    /// Whether the stream of a channel takes these points.
    fn check_space(&self, channel: u32, points: &SpacePoints) -> Result<(), Refused> {
        match self.channels.get(&channel) {
            Some(Channel::Producer(_, stream)) => points.check(&stream.state),
            // Such a channel has an answer of its own.
            _ => Ok(()),
        }
    }

    fn check_size(&self, points: usize) -> Result<(), Refused> {
        let largest = self.directory.limits.largest_batch;
        if points > largest as usize {
            return Err((
                ErrorCode::TooLarge,
                format!("a batch of {points} points, where the largest taken has {largest}"),
            ));
        }
        Ok(())
    }

    /// Hands something on to the stream of a channel; waits while the stream is full.
    pub(super) fn feed(
        &mut self,
        channel: u32,
        input: Input,
        sequence: u64,
        pending: Option<PendingAnswer>,
    ) -> Result<(), Refused> {
        let Some(Channel::Producer(producer, stream)) = self.channels.get(&channel) else {
            return Err((ErrorCode::NoChannel, format!("channel {channel} feeds no stream: send Open on it first")));
        };
        let sink: Arc<dyn ReplySink> = Arc::clone(producer) as _;
        let reply_to = ReplyTo::new(sink, sequence, pending.map(|pending| Box::new(pending) as _));
        let origin = Origin::Producer(reply_to);
        stream.queue.push(Item { input, origin }).map_err(|Closed| {
            self.end_channel(channel);
            (ErrorCode::NoChannel, format!("the stream that channel {channel} fed has ended"))
        })
    }

    pub(super) fn close(&mut self, channel: u32, end: bool) -> Result<(), Refused> {
        self.feed(channel, Input::Close { end }, 0, None)?;
        self.end_channel(channel);
        Ok(())
    }
}

/// What a producer is sent first: the same for the plane and for spaces, where it has more.
fn opened_of(opened: wire::Opened, stream: &StreamState) -> Message {
    let Some(space) = &stream.space else { return opened.into() };
    let (metric, dimension, max_vertices) = (space.metric, space.dimension(), space.max_vertices);
    wire::SpaceOpened { opened, metric, dimension, max_vertices }.into()
}

fn check_counts(points: usize, times: &[f64], tags: &[u64]) -> Result<(), Refused> {
    for (what, count) in [("times", times.len()), ("tags", tags.len())] {
        if count != 0 && count != points {
            let text = format!("there are {count} {what} for {points} points: give none, or one for each");
            return Err((ErrorCode::Unreadable, text));
        }
    }
    Ok(())
}
