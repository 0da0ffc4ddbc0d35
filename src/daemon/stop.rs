//! The request to stop in good order, for those who work in a loop.
//!
//! In: Ctrl-C and SIGTERM, or a request of this process. Out: the first request, if there was any.
//!
//! Invariants: as in `signals`: a second signal ends the process at once.
//!
//! Must not know: what stops.

use std::io;
use std::time::Duration;

use crossbeam_channel::{Receiver, Sender, bounded};

use super::signals;

/// Receives requests to stop.
#[derive(Debug)]
pub struct Stop {
    requests: Receiver<&'static str>,
    asked: Option<&'static str>,
}

/// Requests a stop.
#[derive(Debug)]
pub struct Stopper(Sender<&'static str>);

impl Stopper {
    /// Requests a stop, for a reason.
    pub fn ask(&self, reason: &'static str) {
        // A receiver that was asked before, or has ended, needs no second request.
        let _ = self.0.try_send(reason);
    }
}

impl Stop {
    /// Receives signals. From here on they do not end the process by themselves.
    ///
    /// # Errors
    /// Those of the system, when the handlers are installed.
    pub fn listen() -> io::Result<Self> {
        Ok(Self { requests: signals::channel()?, asked: None })
    }

    /// Receives requests of this process, and no signals.
    pub fn told() -> (Stopper, Self) {
        let (sender, requests) = bounded(1);
        (Stopper(sender), Self { requests, asked: None })
    }

    /// The channel of requests, for those who wait for several things at once.
    pub fn requests(&self) -> &Receiver<&'static str> {
        &self.requests
    }

    /// The reason of the first request, if there was one.
    pub fn asked(&mut self) -> Option<&'static str> {
        self.wait(Duration::ZERO)
    }

    /// As [`asked`](Self::asked), but waits for so long.
    pub fn wait(&mut self, moment: Duration) -> Option<&'static str> {
        if self.asked.is_none() {
            self.asked = self.requests.recv_timeout(moment).ok();
        }
        self.asked
    }
}
