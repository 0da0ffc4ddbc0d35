//! The roles of a demo: threads that can be asked to end, and their end in order.
//!
//! In: roles as they start.
//! Out: whether one of them has ended, and how the demo went.
//! Invariants: all threads are joined. The producer leaves before the daemon, and the printer writes all that the
//! daemon has sent before its goodbye.
//! Must not know: what a role does.

use std::thread::{self, Scope, ScopedJoinHandle};
use std::time::Duration;

use anyhow::{Context, anyhow};

use crate::cli::Failure;
use crate::daemon::{Stop, Stopper};

/// The reason of an end that no signal asked for.
pub const OVER: &str = "the demo is over";

/// A thread, and how to end it.
pub struct Role<'scope> {
    thread: ScopedJoinHandle<'scope, Result<(), Failure>>,
    stopper: Stopper,
}

impl<'scope> Role<'scope> {
    /// Starts.
    pub fn start(
        scope: &'scope Scope<'scope, '_>,
        name: &str,
        play: impl FnOnce(Stop) -> Result<(), Failure> + Send + 'scope,
    ) -> Result<Self, Failure> {
        let (stopper, stop) = Stop::told();
        let thread = thread::Builder::new().name(name.to_owned()).spawn_scoped(scope, || play(stop));
        Ok(Self { thread: thread.with_context(|| format!("cannot start the {name}'s thread"))?, stopper })
    }

    fn leave(self, reason: &'static str) -> Result<(), Failure> {
        self.stopper.ask(reason);
        self.join()
    }

    fn join(self) -> Result<(), Failure> {
        let stopped = || anyhow!("a thread of the demo stopped by itself: please report this").into();
        self.thread.join().unwrap_or_else(|_| Err(stopped()))
    }
}

/// All roles that have started.
pub struct Roles<'scope> {
    pub daemon: Role<'scope>,
    pub printer: Option<Role<'scope>>,
    pub producer: Option<Role<'scope>>,
}

impl Roles<'_> {
    /// The reason to end, if within that time a signal comes or a role has ended.
    pub fn ended(&self, signals: &mut Stop, moment: Duration) -> Option<&'static str> {
        let roles = [Some(&self.daemon), self.printer.as_ref(), self.producer.as_ref()];
        let has_ended = roles.into_iter().flatten().any(|role| role.thread.is_finished());
        if has_ended { Some(OVER) } else { signals.wait(moment) }
    }

    /// Ends all in order. If several fail, the daemon's failure is reported: it may have caused the others.
    pub fn end(self, reason: &'static str) -> Result<(), Failure> {
        let produced = self.producer.map_or(Ok(()), |producer| producer.leave(reason));
        let served = self.daemon.leave(reason);
        // The printer is not asked: it ends with the daemon's goodbye, after all frames.
        let printed = self.printer.map_or(Ok(()), Role::join);
        served.and(printed).and(produced)
    }
}
