//! What those may see and do who come by another way than the daemon's sockets, such as its page.
//!
//! In: questions, and connections that carry the protocol. Out: how the daemon is, the newest frame of a stream, a
//! peer who may only read. Invariants: nothing asked here changes a stream, and no engine waits for who asks. Must not
//! know: how access come.

use std::fmt;
use std::sync::Arc;
use std::time::Duration;

use hopes_protocol as wire;
use thiserror::Error;

use super::Limits;
use super::convert;
use super::frame_times::FrameTimes;
use super::peer::{ListenError, Registry, SOFTWARE, Socket, Transport};
use super::streams::Hub;

/// Opens another way in, once there is something to see; gives what closes it.
pub type StartHttp = Box<dyn FnOnce(HttpAccess) -> Result<StopHttp, ListenError>>;

/// Closes a way in.
pub type StopHttp = Box<dyn FnOnce()>;

/// Why a frame cannot be seen.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum SnapshotError {
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

/// The daemon, as access see it.
#[derive(Clone)]
pub struct HttpAccess {
    hub: Arc<Hub>,
    registry: Arc<Registry>,
}

impl fmt::Debug for HttpAccess {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("HttpAccess").finish_non_exhaustive()
    }
}

impl HttpAccess {
    /// HttpAccess of a daemon.
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

    /// How long the frames of each stream take, by the stream's name.
    pub fn frame_times(&self) -> Vec<(String, FrameTimes)> {
        self.hub.streams().iter().map(|stream| (stream.name.clone(), stream.stats.times.clone())).collect()
    }

    /// The newest frame of a stream; waits for the engine so long at the most.
    ///
    /// # Errors
    /// [`SnapshotError`].
    pub fn snapshot_once(
        &self,
        name: &str,
        view: wire::View,
        patience: Duration,
    ) -> Result<Arc<wire::Snapshot>, SnapshotError> {
        convert::check_view(view).map_err(SnapshotError::BadView)?;
        let stream = self.hub.stream(name).ok_or_else(|| SnapshotError::NoStream(name.to_owned()))?;
        if stream.stats.frame() == 0 {
            return Err(SnapshotError::NoFrame(name.to_owned()));
        }
        stream.snapshot_once(view, patience).ok_or_else(|| SnapshotError::Busy(name.to_owned()))
    }

    /// Talks with somebody who may only read.
    pub fn admit(&self, transport: Box<dyn Transport>, place: &str) {
        self.registry.admit(Socket::Tunnel(transport), place);
    }
}
