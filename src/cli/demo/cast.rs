//! Who plays in a demo: threads that can be asked to end, and their end in order.
//!
//! In: roles as they start. Out: whether it is over, and how it went. Invariants: everybody is joined; the producer leaves before the daemon, and the
//! teller hears the daemon's goodbye. Must not know: what anybody does.

use std::thread::{self, Scope, ScopedJoinHandle};
use std::time::Duration;

use anyhow::{Context, anyhow};

use super::OVER;
use crate::cli::Failure;
use crate::daemon::{Stop, Stopper};

/// A thread, and who can end it.
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

/// All who play.
pub struct Cast<'scope> {
    pub daemon: Role<'scope>,
    pub teller: Option<Role<'scope>>,
    pub producer: Option<Role<'scope>>,
}

impl Cast<'_> {
    /// Why it is over, if within that time a signal comes or somebody has ended.
    pub fn is_over(&self, signals: &mut Stop, moment: Duration) -> Option<&'static str> {
        let roles = [Some(&self.daemon), self.teller.as_ref(), self.producer.as_ref()];
        let has_ended = roles.into_iter().flatten().any(|role| role.thread.is_finished());
        if has_ended { Some(OVER) } else { signals.wait(moment) }
    }

    /// Ends all in order. The daemon's failure counts more than what came of it.
    pub fn end(self, reason: &'static str) -> Result<(), Failure> {
        let produced = self.producer.map_or(Ok(()), |producer| producer.leave(reason));
        let served = self.daemon.leave(reason);
        // It is not asked: the daemon's goodbye comes after all that there is to tell.
        let told = self.teller.map_or(Ok(()), Role::join);
        served.and(told).and(produced)
    }
}
