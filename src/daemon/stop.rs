//! The wish to end in good order, for those who work in a loop.
//!
//! In: Ctrl-C and SIGTERM, or the word of somebody in this process. Out: which came first, if any. Invariants: as in `signals`: a second signal ends the process at once. Must not know: who asks.

use std::io;
use std::time::Duration;

use crossbeam_channel::{Receiver, Sender, bounded};

use super::signals;

/// Whether somebody wants an end.
#[derive(Debug)]
pub struct Stop {
    wishes: Receiver<&'static str>,
    asked: Option<&'static str>,
}

/// Asks somebody to end.
#[derive(Debug)]
pub struct Stopper(Sender<&'static str>);

impl Stopper {
    /// Asks, and says why.
    pub fn ask(&self, reason: &'static str) {
        // Who was asked before, or has ended by himself, need not hear it.
        let _ = self.0.try_send(reason);
    }
}

impl Stop {
    /// From here on signals ask, and do not end the process by themselves.
    pub fn listen() -> io::Result<Self> {
        Ok(Self { wishes: signals::channel()?, asked: None })
    }

    /// Somebody in this process asks, and no signal.
    pub fn told() -> (Stopper, Self) {
        let (sender, wishes) = bounded(1);
        (Stopper(sender), Self { wishes, asked: None })
    }

    /// Where wishes come from, for those who wait for several things at once.
    pub fn wishes(&self) -> &Receiver<&'static str> {
        &self.wishes
    }

    /// The name of the signal that has come.
    pub fn asked(&mut self) -> Option<&'static str> {
        self.wait(Duration::ZERO)
    }

    /// As [`asked`](Self::asked), but waits for so long.
    pub fn wait(&mut self, moment: Duration) -> Option<&'static str> {
        if self.asked.is_none() {
            self.asked = self.wishes.recv_timeout(moment).ok();
        }
        self.asked
    }
}
