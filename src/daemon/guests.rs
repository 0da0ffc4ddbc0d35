//! What those may see and do who come by another way than the daemon's sockets, such as its page.
//!
//! In: questions, and connections that carry the protocol. Out: how the daemon is, the newest frame of a stream, a
//! peer who may only read. Invariants: nothing asked here changes a stream, and no engine waits for who asks. Must not
//! know: how guests come.

use std::fmt;
use std::sync::Arc;
use std::time::Duration;

use hopes_protocol as wire;
use thiserror::Error;

use super::Limits;
use super::convert;
use super::peer::{Carrier, ListenError, Registry, SOFTWARE, Socket};
use super::streams::Hub;

/// Opens another way in, once there is something to see; gives what closes it.
pub type Door = Box<dyn FnOnce(Guests) -> Result<Closing, ListenError>>;

/// Closes a way in.
pub type Closing = Box<dyn FnOnce()>;

/// Why a frame cannot be seen.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum GlanceError {
    /// There is no such view.
    #[error("{0}")]
    BadView(&'static str),
    /// There is no such stream.
    #[error("there is no stream {0:?}")]
    NoStream(String),
    /// There is nothing to see.
    #[error("stream {0:?} has no frame yet")]
    NoFrame(String),
    /// It has too much to do.
    #[error("stream {0:?} has not answered in time: try again")]
    Busy(String),
}

/// The daemon, as guests see it.
#[derive(Clone)]
pub struct Guests {
    hub: Arc<Hub>,
    registry: Arc<Registry>,
}

impl fmt::Debug for Guests {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Guests").finish_non_exhaustive()
    }
}

impl Guests {
    /// Guests of a daemon.
    pub fn new(hub: Arc<Hub>, registry: Arc<Registry>) -> Self {
        Self { hub, registry }
    }

    /// How much of everything there may be.
    pub fn limits(&self) -> &Limits {
        &self.hub.limits
    }

    /// How everything is.
    pub fn status(&self) -> wire::Status {
        self.hub.status(SOFTWARE)
    }

    /// The newest frame of a stream; waits for the engine so long at the most.
    ///
    /// # Errors
    /// [`GlanceError`].
    pub fn glance(&self, name: &str, view: wire::View, patience: Duration) -> Result<Arc<wire::Snapshot>, GlanceError> {
        convert::check_view(view).map_err(GlanceError::BadView)?;
        let stream = self.hub.stream(name).ok_or_else(|| GlanceError::NoStream(name.to_owned()))?;
        if stream.stats.frame() == 0 {
            return Err(GlanceError::NoFrame(name.to_owned()));
        }
        stream.glance(view, patience).ok_or_else(|| GlanceError::Busy(name.to_owned()))
    }

    /// Talks with somebody who may only read.
    pub fn admit(&self, carrier: Box<dyn Carrier>, place: &str) {
        self.registry.admit(Socket::Carried(carrier), place);
    }
}
