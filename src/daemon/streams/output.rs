//! The output of a stream: where its frames go besides its consumers.
//!
//! In: frames, one at a time. Out: the same to the thread that writes them.
//!
//! Invariants: a few frames are under way at the most. Whoever sends one is woken for other work while it waits.
//!
//! Must not know: how frames are written.

use std::time::{Duration, Instant};

use crossbeam_channel::{Receiver, Select, Sender};
use hopes_protocol as wire;

use super::publishing::any_tracks::AnyTrackFrame;
use crate::daemon::locks::before_waiting;

/// A frame of the output.
#[derive(Debug)]
pub struct OutputFrame {
    /// The stream's number.
    pub stream: u32,
    /// The frame's number.
    pub number: u64,
    /// What has changed in the view: a diff of the plane, or of a space.
    pub diff: wire::Message,
    /// What has happened to tracks, if they are followed.
    pub tracks: Option<AnyTrackFrame>,
}

/// Where a stream's frames go besides its consumers.
#[derive(Clone, Debug)]
pub struct Output {
    /// The view that it shows.
    pub view: wire::View,
    /// Takes the frames.
    pub frames: Sender<OutputFrame>,
    /// Whether the stream ends when the reader has gone.
    pub is_vital: bool,
}

/// What became of a frame.
#[derive(Debug)]
pub enum Sent {
    /// The output has it.
    Taken,
    /// Something else is to be done first.
    NotYet(Box<OutputFrame>),
    /// The reader has gone.
    Gone,
    /// The reader has not taken it in time.
    TooLate,
}

impl Output {
    /// Waits until the output takes a frame, `wakes` wakes, or `until` comes. Gives up at `end_by`, which is looked at
    /// now and then.
    pub fn send(
        &self,
        frame: OutputFrame,
        wakes: &Receiver<()>,
        until: Option<Instant>,
        end_by: Option<Instant>,
    ) -> Sent {
        /// How long to wait before the caller looks whether it has to end.
        const STEP: Duration = Duration::from_millis(500);
        before_waiting("the reader of the output");
        let now = Instant::now();
        if end_by.is_some_and(|end_by| end_by <= now) {
            return Sent::TooLate;
        }
        let deadline = [Some(now + STEP), until, end_by].into_iter().flatten().min().unwrap_or(now);
        let mut select = Select::new();
        let (send, _) = (select.send(&self.frames), select.recv(wakes));
        match select.select_deadline(deadline) {
            Ok(ready) if ready.index() == send => match ready.send(&self.frames, frame) {
                Ok(()) => Sent::Taken,
                Err(_) => Sent::Gone,
            },
            Ok(ready) => {
                // The queue has the other end, so it is no error.
                let _ = ready.recv(wakes);
                Sent::NotYet(Box::new(frame))
            }
            Err(_) => Sent::NotYet(Box::new(frame)),
        }
    }
}
