//! The wish to end in good order, for those who work in a loop.
//!
//! In: Ctrl-C and SIGTERM. Out: which came first, if any. Invariants: as in `signals`: a second one ends the process at once. Must not know: who asks.

use std::io;
use std::time::Duration;

use crossbeam_channel::Receiver;

use super::signals;

/// Whether somebody wants an end.
#[derive(Debug)]
pub struct Stop {
    signals: Receiver<&'static str>,
    asked: Option<&'static str>,
}

impl Stop {
    /// From here on signals ask, and do not end the process by themselves.
    pub fn listen() -> io::Result<Self> {
        Ok(Self { signals: signals::channel()?, asked: None })
    }

    /// The name of the signal that has come.
    pub fn asked(&mut self) -> Option<&'static str> {
        self.wait(Duration::ZERO)
    }

    /// As [`asked`](Self::asked), but waits for so long.
    pub fn wait(&mut self, moment: Duration) -> Option<&'static str> {
        if self.asked.is_none() {
            self.asked = self.signals.recv_timeout(moment).ok();
        }
        self.asked
    }
}
