//! What was sent and is not answered yet, and what came of the rest.
//!
//! In: messages as they are sent, answers as they come, from two threads. Out: counts; whether there is room to send
//! more; why it is over. Invariants: every message has one answer, and every answer belongs to a message; what is
//! refused is reported with the line that it stands on; the first reason to end is the one that is told. Must not know:
//! sockets, how points are read.

use std::collections::BTreeMap;
use std::fmt::Display;
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use anyhow::anyhow;
use hopes_protocol::{Message, Overloaded, Policy, Refused, Report};

use crate::cli::Failure;
use crate::client::ClientError;
use crate::daemon::{Batch, InputErrors, StrictStop};

/// A message under way.
#[derive(Debug)]
pub enum Sent {
    /// Points to add.
    Batch(Batch),
    /// Points to take back.
    Retract(Batch),
    /// The end of a frame.
    Commit,
}

/// What came of it so far.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counts {
    pub accepted: u64,
    pub taken_back: u64,
    pub refused: u64,
    pub dropped: u64,
    pub frames: u64,
    /// Number of the stream's last frame that is known.
    pub newest: u64,
}

/// Shared by who sends and who receives.
#[derive(Debug)]
pub struct Ledger {
    state: Mutex<State>,
    changed: Condvar,
    /// What the place of a point is: a line, or a byte.
    place: &'static str,
}

#[derive(Debug)]
struct State {
    unanswered: BTreeMap<u64, Sent>,
    input_errors: InputErrors,
    counts: Counts,
    /// Whether we want the end that may come.
    is_closing: bool,
    end: Option<End>,
}

#[derive(Debug)]
enum End {
    /// As it should.
    Closed,
    Strict(StrictStop),
    Failed(anyhow::Error),
}

impl Ledger {
    /// Nothing is under way.
    pub fn new(strict: bool, place: &'static str) -> Self {
        let state = State {
            unanswered: BTreeMap::new(),
            input_errors: InputErrors::new(strict),
            counts: Counts::default(),
            is_closing: false,
            end: None,
        };
        Self { state: Mutex::new(state), changed: Condvar::new(), place }
    }

    /// A message is about to be sent.
    pub fn note(&self, sequence: u64, sent: Sent) {
        self.state().unanswered.insert(sequence, sent);
    }

    /// Waits until fewer messages than that are under way, or it is over, or a moment has passed. How many are under
    /// way, none if it is over.
    pub fn wait(&self, fewer_than: usize, moment: Duration) -> Option<usize> {
        let goes_on = |state: &mut State| state.end.is_none() && state.unanswered.len() >= fewer_than;
        let waited = self.changed.wait_timeout_while(self.state(), moment, goes_on);
        let (state, _) = waited.unwrap_or_else(PoisonError::into_inner);
        state.end.is_none().then_some(state.unanswered.len())
    }

    /// Waits until it is over, or a moment has passed; whether it is over.
    pub fn wait_for_end(&self, moment: Duration) -> bool {
        self.wait(0, moment).is_none()
    }

    /// The end is wanted from here on.
    pub fn closes(&self) {
        self.state().is_closing = true;
    }

    /// Something in the input that cannot be used.
    pub fn report_error(&self, what: &dyn Display) {
        let mut state = self.state();
        state.counts.refused += 1;
        state.report_error(what);
        self.changed.notify_all();
    }

    /// It cannot go on.
    pub fn fail(&self, error: impl Into<anyhow::Error>) {
        self.state().end(End::Failed(error.into()));
        self.changed.notify_all();
    }

    /// Takes what the daemon says.
    pub fn take(&self, message: Message) {
        let mut state = self.state();
        if let Err(error) = state.take(message, self.place) {
            state.end(End::Failed(error));
        }
        self.changed.notify_all();
    }

    /// What came of it, as far as it is known.
    pub fn counts(&self) -> Counts {
        self.state().counts
    }

    /// The end of it all.
    pub fn settle(&self) -> Result<Counts, Failure> {
        let mut state = self.state();
        state.input_errors.sum_up();
        match state.end.take() {
            None | Some(End::Closed) => Ok(state.counts),
            Some(End::Strict(stop)) => Err(stop.into()),
            Some(End::Failed(error)) => Err(Failure::Failed(error)),
        }
    }

    fn state(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl State {
    /// The first end counts.
    fn end(&mut self, end: End) {
        self.end.get_or_insert(end);
    }

    fn report_error(&mut self, what: &dyn Display) {
        if let Err(stop) = self.input_errors.add(what) {
            self.end(End::Strict(stop));
        }
    }

    fn take(&mut self, message: Message, place: &str) -> anyhow::Result<()> {
        match message {
            Message::Accepted(accepted) => match self.answered(accepted.sequence)? {
                Sent::Commit => return Err(out_of_place("Accepted")),
                Sent::Batch(_) => self.counts.accepted += u64::from(accepted.points),
                Sent::Retract(_) => self.counts.taken_back += u64::from(accepted.points),
            },
            Message::Refused(refused) => self.refused(&refused, place)?,
            Message::Overloaded(overloaded) => self.overloaded(overloaded)?,
            Message::Committed(committed) => match self.answered(committed.sequence)? {
                Sent::Commit => {
                    self.counts.frames += 1;
                    self.counts.newest = committed.frame;
                }
                Sent::Batch(_) | Sent::Retract(_) => return Err(out_of_place("Committed")),
            },
            Message::Closed(closed) if self.is_closing => {
                self.counts.newest = closed.frame;
                self.end(End::Closed);
            }
            Message::Closed(closed) => {
                return Err(anyhow!("somebody else has ended the stream, after frame {}", closed.frame));
            }
            Message::Goodbye(goodbye) => {
                let (reason, left) = (goodbye.reason, self.unanswered.len());
                return Err(anyhow!("the daemon says goodbye: {reason}; {left} messages are not answered"));
            }
            Message::Error(Report { text, .. }) => return Err(anyhow!("the daemon refuses: {text}")),
            other => return Err(anyhow!("the daemon answers with a message of type {:#06x}", other.kind())),
        }
        Ok(())
    }

    fn answered(&mut self, sequence: u64) -> anyhow::Result<Sent> {
        let sent = self.unanswered.remove(&sequence);
        sent.ok_or_else(|| anyhow!("the daemon answers message {sequence}, which does not wait for an answer"))
    }

    fn refused(&mut self, refused: &Refused, place: &str) -> anyhow::Result<()> {
        let points = match self.answered(refused.sequence)? {
            Sent::Commit => return Err(out_of_place("Refused")),
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
        for reason in &refused.reasons {
            let index = reason.index as usize;
            match points.positions.get(index).zip(points.lines.get(index)) {
                Some(((x, y), line)) => {
                    self.report_error(&format_args!("{place} {line}, point ({x}, {y}): {}", reason.text));
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

    fn overloaded(&mut self, overloaded: Overloaded) -> anyhow::Result<()> {
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

fn out_of_place(answer: &str) -> anyhow::Error {
    anyhow!("the daemon answers with {answer} to something else")
}

/// The connection ended, and nobody has said why.
pub fn hung_up(address: &crate::daemon::Address) -> ClientError {
    ClientError::Closed { address: address.clone(), when: "before it had answered everything" }
}
