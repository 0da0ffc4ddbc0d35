//! Messages that were sent and are not answered yet, and the outcome of all others.
//!
//! In: messages as they are sent, answers as they come, from two threads.
//! Out: counts; whether there is room to send more; why the delivery ended.
//! Invariants: every message has one answer, and every answer belongs to a message. A refused point is reported
//! with the line that it stands on. The first reason to end is the one that is reported.
//! Must not know: sockets, how points are read.

use std::collections::BTreeMap;
use std::fmt::Display;
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use hopes::topology::FirstCoordinates;
use hopes_protocol::{Message, Overloaded, Policy, Refused, Report};

use super::error::DeliveryError;
use crate::daemon::{Batch, Input, InputErrors};

/// A message that was sent.
#[derive(Debug)]
pub enum Sent {
    /// Points to add.
    Batch(Batch),
    /// Points to take back.
    Retract(Batch),
    /// The end of a frame.
    Commit,
}

impl Sent {
    fn points(&self) -> u64 {
        match self {
            Self::Batch(batch) | Self::Retract(batch) => batch.positions.len() as u64,
            Self::Commit => 0,
        }
    }
}

/// How many points and frames had which outcome.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counts {
    /// Points that were read, to be added or taken back.
    pub read: u64,
    /// What was read and is no point, or cannot be used.
    pub unusable: u64,
    /// Points of messages that were sent.
    pub sent: u64,
    /// Of these, those that no answer has come for.
    pub unanswered: u64,
    pub accepted: u64,
    pub taken_back: u64,
    /// Points that the daemon has refused, and all that is unusable.
    pub refused: u64,
    pub dropped: u64,
    pub frames: u64,
    /// Number of the stream's last known frame.
    pub newest: u64,
}

/// Shared by the thread that sends and the thread that takes answers.
#[derive(Debug)]
pub struct Ledger {
    state: Mutex<State>,
    changed: Condvar,
}

#[derive(Debug)]
struct State {
    unanswered: BTreeMap<u64, Sent>,
    input_errors: InputErrors,
    counts: Counts,
    /// Whether this side has asked for the end.
    is_closing: bool,
    end: Option<End>,
}

#[derive(Debug)]
enum End {
    /// In good order.
    Closed,
    Failed(DeliveryError),
}

impl Ledger {
    /// Nothing is sent yet.
    pub fn new(input_errors: InputErrors) -> Self {
        let state = State {
            unanswered: BTreeMap::new(),
            input_errors,
            counts: Counts::default(),
            is_closing: false,
            end: None,
        };
        Self { state: Mutex::new(state), changed: Condvar::new() }
    }

    /// A message is about to be sent.
    pub fn note(&self, sequence: u64, sent: Sent) {
        let mut state = self.state();
        state.counts.sent += sent.points();
        state.counts.unanswered += sent.points();
        state.unanswered.insert(sequence, sent);
    }

    /// Points were read, whether they are sent or not.
    pub fn read(&self, input: &Input) {
        if let Input::Points(batch) | Input::Retract(batch) = input {
            self.state().counts.read += batch.positions.len() as u64;
        }
    }

    /// Waits until fewer messages than that are unanswered, or the delivery has ended, or the moment has passed.
    /// How many are unanswered; none if the delivery has ended.
    pub fn wait(&self, fewer_than: usize, moment: Duration) -> Option<usize> {
        let goes_on = |state: &mut State| state.end.is_none() && state.unanswered.len() >= fewer_than;
        let waited = self.changed.wait_timeout_while(self.state(), moment, goes_on);
        let (state, _) = waited.unwrap_or_else(PoisonError::into_inner);
        state.end.is_none().then_some(state.unanswered.len())
    }

    /// Waits until the delivery has ended or the moment has passed; whether it has ended.
    pub fn wait_for_end(&self, moment: Duration) -> bool {
        self.wait(0, moment).is_none()
    }

    /// This side asks for the end.
    pub fn closes(&self) {
        self.state().is_closing = true;
    }

    /// Reports something in the input that cannot be used.
    pub fn report_error(&self, what: &dyn Display) {
        let mut state = self.state();
        state.counts.refused += 1;
        state.counts.unusable += 1;
        state.report_error(what);
        self.changed.notify_all();
    }

    /// Ends the delivery with an error.
    pub fn fail(&self, error: impl Into<DeliveryError>) {
        self.state().end(End::Failed(error.into()));
        self.changed.notify_all();
    }

    /// Takes a message of the daemon.
    pub fn take(&self, message: Message) {
        let mut state = self.state();
        if let Err(error) = state.take(message) {
            state.end(End::Failed(error));
        }
        self.changed.notify_all();
    }

    /// The outcomes so far.
    pub fn counts(&self) -> Counts {
        self.state().counts
    }

    /// How the delivery ended.
    pub fn settle(&self) -> Result<(), DeliveryError> {
        let mut state = self.state();
        state.input_errors.sum_up();
        let Counts { accepted, taken_back, dropped, .. } = state.counts;
        let rejected = state.input_errors.count();
        match state.end.take() {
            Some(End::Closed) if accepted + taken_back + dropped == 0 && rejected > 0 => {
                Err(DeliveryError::NothingUsable { rejected })
            }
            None | Some(End::Closed) => Ok(()),
            Some(End::Failed(error)) => Err(error),
        }
    }

    fn state(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl State {
    /// Only the first end is kept.
    fn end(&mut self, end: End) {
        self.end.get_or_insert(end);
    }

    fn report_error(&mut self, what: &dyn Display) {
        if let Err(stop) = self.input_errors.add(what) {
            self.end(End::Failed(stop.into()));
        }
    }

    fn take(&mut self, message: Message) -> Result<(), DeliveryError> {
        match message {
            Message::Accepted(accepted) => match self.answered(accepted.sequence)? {
                Sent::Commit => return Err(DeliveryError::OtherAnswer { answer: "Accepted" }),
                Sent::Batch(_) => self.counts.accepted += u64::from(accepted.points),
                Sent::Retract(_) => self.counts.taken_back += u64::from(accepted.points),
            },
            Message::Refused(refused) => self.refused(&refused)?,
            Message::Overloaded(overloaded) => self.overloaded(overloaded)?,
            Message::Committed(committed) => match self.answered(committed.sequence)? {
                Sent::Commit => {
                    self.counts.frames += 1;
                    self.counts.newest = committed.frame;
                }
                Sent::Batch(_) | Sent::Retract(_) => return Err(DeliveryError::OtherAnswer { answer: "Committed" }),
            },
            Message::Closed(closed) if self.is_closing => {
                self.counts.newest = closed.frame;
                self.end(End::Closed);
            }
            Message::Closed(closed) => {
                return Err(DeliveryError::Ended { frame: closed.frame });
            }
            Message::Goodbye(goodbye) => {
                let unanswered = self.unanswered.len();
                return Err(DeliveryError::Goodbye { reason: goodbye.reason, unanswered });
            }
            Message::Error(Report { text, .. }) => return Err(DeliveryError::Refused(text)),
            other => return Err(DeliveryError::NoAnswer { kind: other.kind() }),
        }
        Ok(())
    }

    fn answered(&mut self, sequence: u64) -> Result<Sent, DeliveryError> {
        let sent = self.unanswered.remove(&sequence).ok_or(DeliveryError::NotAsked { sequence })?;
        self.counts.unanswered -= sent.points();
        Ok(sent)
    }

    fn refused(&mut self, refused: &Refused) -> Result<(), DeliveryError> {
        let points = match self.answered(refused.sequence)? {
            Sent::Commit => return Err(DeliveryError::OtherAnswer { answer: "Refused" }),
            Sent::Batch(points) => {
                self.counts.accepted += u64::from(refused.accepted);
                points
            }
            Sent::Retract(points) => {
                self.counts.taken_back += u64::from(refused.accepted);
                points
            }
        };
        self.counts.refused += u64::from(refused.refused);
        let place = points.place;
        for reason in &refused.reasons {
            let index = reason.index as usize;
            match points.lines.get(index) {
                Some(line) => {
                    let point = points.positions.get(index).with_coordinates(|point| FirstCoordinates::from(point));
                    self.report_error(&format_args!("{place} {line}, point {point}: {}", reason.text));
                }
                None => self.report_error(&format_args!("a point: {}", reason.text)),
            }
        }
        let unlisted = u64::from(refused.refused).saturating_sub(refused.reasons.len() as u64);
        if let (true, Some(first), Some(last)) = (unlisted > 0, points.lines.first(), points.lines.last()) {
            self.report_error(&format_args!("{unlisted} more points between {place} {first} and {place} {last}"));
        }
        Ok(())
    }

    fn overloaded(&mut self, overloaded: Overloaded) -> Result<(), DeliveryError> {
        self.answered(overloaded.sequence)?;
        if self.counts.dropped == 0 {
            let which = match overloaded.policy {
                Policy::DropOldest => "oldest",
                Policy::DropNewest => "newest",
            };
            tracing::warn!("the daemon does not keep up and drops the {which} points: they are counted");
        }
        self.counts.dropped += u64::from(overloaded.points);
        Ok(())
    }
}
