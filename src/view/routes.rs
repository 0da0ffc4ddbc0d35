//! Routing: the paths of the server and their responses.
//!
//! In: a request whose host and origin were checked.
//! Out: a response, or which frames are wanted as events.
//! Invariants: a refusal says what is wrong with the request. The number of snapshots that are made at a time is
//! bounded; a client that is slow to read one keeps nobody from another.
//! Must not know: sockets, the rules of HTTP.

use std::time::{Duration, Instant};

use super::assets::Assets;
use super::documents::Documents;
use super::events::FramesRequest;
use super::http::{Body, Refusal, Request, Response};
use super::metrics::{self, Peers};
use super::permits::Permits;
use super::query;
use super::snapshot::{FormatError, SnapshotRequest};
use crate::daemon::{HttpAccess, SnapshotError};

/// Snapshots that are made at one time at the most: each may be many megabytes.
const MAX_SNAPSHOTS: usize = 4;

/// How long the daemon may take to answer a probe of its health.
const HEALTH_TIMEOUT: Duration = Duration::from_secs(1);

/// How long the engine may take until it answers a request for a snapshot.
const SNAPSHOT_TIMEOUT: Duration = Duration::from_secs(10);

/// The path at which the daemon's health is told.
pub const HEALTH: &str = "/healthz";

const JSON: &str = "application/json";
const TEXT: &str = "text/plain; charset=utf-8";

/// The reply to a request.
pub enum Reply {
    /// A response.
    Response(Response),
    /// The response after which a WebSocket begins.
    Upgrade(Vec<u8>),
    /// Frames as events.
    Events(FramesRequest),
}

/// All resources of the server.
pub struct Routes {
    access: HttpAccess,
    assets: Assets,
    /// Permits to make a snapshot.
    snapshots: Permits,
    documents: Documents,
}

impl Routes {
    /// The resources of a daemon.
    pub fn new(access: HttpAccess) -> Self {
        let documents = Documents::new(access.account());
        Self { access, assets: Assets::new(), snapshots: Permits::new(MAX_SNAPSHOTS), documents }
    }

    /// Whether the path is that of the WebSocket.
    pub fn is_websocket(request: &Request) -> bool {
        request.path == "/ws"
    }

    /// The reply to a request for any other path.
    pub fn reply(&self, request: &Request) -> Reply {
        let of_stream = request.path.strip_prefix("/api/streams/").and_then(|rest| rest.rsplit_once('/'));
        let response = match (&request.path[..], of_stream) {
            (_, Some((name, "snapshot"))) => self.snapshot(name, request).unwrap_or_else(Response::from),
            (_, Some((name, "frames"))) => match self.frames(name, request) {
                Ok(frames) => return Reply::Events(frames),
                Err(refusal) => refusal.into(),
            },
            (HEALTH, _) => self.health(),
            ("/metrics", _) => self.metrics(),
            ("/api/streams", _) => self.streams(),
            (path, _) => self.asset(path, request),
        };
        Reply::Response(response)
    }

    fn asset(&self, path: &str, request: &Request) -> Response {
        match self.assets.get(path) {
            Some(asset) => {
                Response::new(asset.media_type, asset.body).version(&asset.tag, request.has_version(&asset.tag))
            }
            None => Refusal::new(404, "there is nothing here: start at /").into(),
        }
    }

    /// Whether the directory and every engine answer.
    fn health(&self) -> Response {
        let unwell = self.access.unwell(HEALTH_TIMEOUT);
        if unwell.is_empty() {
            return Response::new(TEXT, "ok\n");
        }
        let seconds = HEALTH_TIMEOUT.as_secs();
        let lines = unwell.iter().map(|what| format!("{what} has not answered within {seconds} s\n"));
        Response::new(TEXT, lines.collect::<String>()).unavailable()
    }

    fn metrics(&self) -> Response {
        let peers = Peers { list: self.access.peers(), cut_off: self.access.cut_off_count() };
        match metrics::write(self.access.status(), peers, self.access.measured()) {
            Ok(text) => Response::new(metrics::MEDIA_TYPE, text),
            Err(error) => Refusal::new(500, format!("the metrics cannot be written: {error}")).into(),
        }
    }

    /// The same JSON as that of `hopes status --json`.
    fn streams(&self) -> Response {
        match serde_json::to_vec(&self.access.status()) {
            Ok(mut json) => {
                json.push(b'\n');
                Response::new(JSON, json)
            }
            Err(error) => Refusal::new(500, format!("the status cannot be written: {error}")).into(),
        }
    }

    /// The frames of a stream that is there.
    fn frames(&self, name: &str, request: &Request) -> Result<FramesRequest, Refusal> {
        let epoch = |name: &str| self.access.stream(name).map(|stream| stream.epoch);
        let wanted = FramesRequest::parse(name, request, epoch).map_err(|text| Refusal::new(400, text))?;
        let missing = || SnapshotError::NoStream(wanted.name.clone()).to_string();
        epoch(&wanted.name).ok_or_else(|| Refusal::new(404, missing()))?;
        Ok(wanted)
    }

    fn snapshot(&self, name: &str, request: &Request) -> Result<Response, Refusal> {
        let bad = |text| Refusal::new(400, text);
        let name = query::decoded(name).map_err(bad)?;
        let wanted = SnapshotRequest::parse(request.query.as_deref().unwrap_or_default()).map_err(bad)?;
        let timeout = SNAPSHOT_TIMEOUT.min(self.access.limits().timeout);
        let by = Instant::now() + timeout;
        let _permit = self.snapshots.wait(timeout).ok_or_else(|| {
            Refusal::new(503, format!("{MAX_SNAPSHOTS} snapshots are being made, the most at a time: try again"))
        })?;
        let timeout = by.saturating_duration_since(Instant::now());
        let snapshot = self.access.snapshot_once(&name, wanted.view, timeout).map_err(|error| {
            let status = match error {
                SnapshotError::BadView(_) => 400,
                SnapshotError::NoStream(_) | SnapshotError::NoFrame(_) => 404,
                SnapshotError::Busy(_) => 503,
            };
            Refusal::new(status, error.to_string())
        })?;
        let document = self.documents.get(&name, snapshot, wanted.format);
        let body = document.map_err(|error| {
            let status = if matches!(error, FormatError::NoMap(_)) { 400 } else { 500 };
            Refusal::new(status, error.to_string())
        })?;
        Ok(Response::new(wanted.format.media_type(), Body::Shared(body)))
    }
}
