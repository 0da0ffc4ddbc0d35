//! What the HTTP server may see and do: the daemon's status, snapshots, connections that only read.
//!
//! In: questions, and sockets that carry the protocol. Out: status, the newest frame of a stream, connections.
//!
//! Invariants: nothing asked here changes a stream; no engine waits for an answer to be taken.
//!
//! Must not know: HTTP.

use std::fmt;
use std::sync::Arc;
use std::time::{Duration, Instant};

use hopes_protocol as wire;
use thiserror::Error;

use super::connections::listener::ListenError;
use super::connections::registry::Registry;
use super::connections::socket::{Socket, Transport};
use super::memory::{Account, Charged};
use super::settings::{Limits, SOFTWARE};
use super::streams::convert;
use super::streams::directory::Directory;
use super::streams::stream::Probe;
use super::streams::stream_state::Measured;

/// Starts an HTTP server, once the daemon listens; returns what stops it.
pub type StartHttp = Box<dyn FnOnce(HttpAccess) -> Result<StopHttp, ListenError>>;

/// Stops an HTTP server.
pub type StopHttp = Box<dyn FnOnce()>;

/// Why there is no snapshot.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum SnapshotError {
    /// There is no such view.
    #[error("{0}")]
    BadView(&'static str),
    /// There is no such stream.
    #[error("there is no stream {0:?}")]
    NoStream(String),
    /// The stream has no frame.
    #[error("stream {0:?} has no frame yet")]
    NoFrame(String),
    /// The engine did not answer in time.
    #[error("stream {0:?} has not answered in time: try again")]
    Busy(String),
}

/// The daemon, as the HTTP server sees it.
#[derive(Clone)]
pub struct HttpAccess {
    directory: Arc<Directory>,
    registry: Arc<Registry>,
}

impl fmt::Debug for HttpAccess {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("HttpAccess").finish_non_exhaustive()
    }
}

impl HttpAccess {
    /// Access to a daemon.
    pub fn new(directory: Arc<Directory>, registry: Arc<Registry>) -> Self {
        Self { directory, registry }
    }

    /// The daemon's limits.
    pub fn limits(&self) -> &Limits {
        &self.directory.limits
    }

    /// The daemon's status.
    pub fn status(&self) -> wire::Status {
        self.directory.status(SOFTWARE)
    }

    /// What is known of all peers.
    pub fn peers(&self) -> Vec<wire::Peer> {
        self.registry.members.peers()
    }

    /// Peers that were cut off so far.
    pub fn cut_off_count(&self) -> u64 {
        self.registry.members.cut_off_count()
    }

    /// An account for what is held for visitors.
    pub fn account(&self) -> Arc<Account> {
        self.registry.account()
    }

    /// What does not answer within `patience`: nothing, if the daemon is well.
    pub fn unwell(&self, patience: Duration) -> Vec<String> {
        let deadline = Instant::now() + patience;
        if !self.directory.answers(patience) {
            return vec!["the directory of streams".to_owned()];
        }
        let streams = self.directory.streams();
        let probes: Vec<_> = streams.iter().map(|stream| (stream, stream.probe())).collect();
        let left = || deadline.saturating_duration_since(Instant::now());
        let is_unwell = |(_, probe): &(_, Probe)| !probe.is_answered_within(left());
        let unwell = probes.into_iter().filter(is_unwell);
        unwell.map(|(stream, _)| format!("stream {:?}", stream.state.name)).collect()
    }

    /// What is measured of each stream beyond its status.
    pub fn measured(&self) -> Vec<Measured> {
        self.directory.streams().iter().map(|stream| stream.state.measured()).collect()
    }

    /// The newest frame of a stream. Waits for its engine at most as long as `patience`.
    ///
    /// # Errors
    /// [`SnapshotError`].
    pub fn snapshot_once(
        &self,
        name: &str,
        view: wire::View,
        patience: Duration,
    ) -> Result<Arc<Charged<wire::Message>>, SnapshotError> {
        convert::check_view(view).map_err(SnapshotError::BadView)?;
        let stream = self.directory.stream(name).ok_or_else(|| SnapshotError::NoStream(name.to_owned()))?;
        if stream.state.stats.frame() == 0 {
            return Err(SnapshotError::NoFrame(name.to_owned()));
        }
        stream.snapshot_once(view, patience).ok_or_else(|| SnapshotError::Busy(name.to_owned()))
    }

    /// A stream's entry in the list of streams, if it is there.
    pub fn stream(&self, name: &str) -> Option<wire::StreamInfo> {
        self.directory.stream(name).map(|stream| stream.info())
    }

    /// Starts a connection that may only read. What is held for it is charged to an account of its own, as is what
    /// its transport holds.
    pub fn admit(&self, transport: Box<dyn Transport>, place: &str, account: Arc<Account>) {
        self.registry.admit(Socket::Tunnel(transport), place, account);
    }
}
