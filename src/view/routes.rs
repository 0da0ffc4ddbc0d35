//! What is where: paths and their answers.
//!
//! In: a request that is meant for this place. Out: an answer. Invariants: what is not there is told as such, and what
//! is wrong with a question by name; few snapshots are made at a time. Must not know: sockets, HTTP's own rules.

use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Duration;

use super::assets::Assets;
use super::http::{Answer, Refusal, Request};
use super::metrics;
use super::snapshot::{self, Wanted};
use crate::daemon::{HttpAccess, SnapshotError};

/// Snapshots that are made or sent at one time: each may be many megabytes.
const SNAPSHOTS: usize = 4;

/// How long an engine may take to come to a question.
const PATIENCE: Duration = Duration::from_secs(10);

const JSON: &str = "application/json";
const TEXT: &str = "text/plain; charset=utf-8";

/// What comes of a request.
pub enum Reply {
    /// An answer, and the turn that it took.
    Answer(Answer, Option<Turn>),
    /// The answer after which a WebSocket begins.
    Socket(Vec<u8>),
}

/// All that is here.
pub struct Routes {
    access: HttpAccess,
    assets: Assets,
    snapshots: Arc<AtomicUsize>,
}

/// One of the few who may have a snapshot at a time, until this is dropped.
pub struct Turn(Arc<AtomicUsize>);

impl Drop for Turn {
    fn drop(&mut self) {
        self.0.fetch_sub(1, Ordering::AcqRel);
    }
}

impl Routes {
    /// Of a daemon.
    pub fn new(access: HttpAccess) -> Self {
        Self { access, assets: Assets::new(), snapshots: Arc::default() }
    }

    /// Whether that is where the protocol is spoken.
    pub fn is_socket(request: &Request) -> bool {
        request.path == "/ws"
    }

    /// Answers a request for anything else.
    pub fn answer(&self, request: &Request) -> Reply {
        let of_stream = request.path.strip_prefix("/api/streams/").and_then(|rest| rest.strip_suffix("/snapshot"));
        let answer = match (&request.path[..], of_stream) {
            (_, Some(name)) => match self.snapshot(name, request) {
                Ok((answer, turn)) => return Reply::Answer(answer, Some(turn)),
                Err(refusal) => refusal.into(),
            },
            ("/healthz", _) => Answer::new(TEXT, "ok\n"),
            ("/metrics", _) => Answer::new(metrics::KIND, metrics::write(&self.access.status())),
            ("/api/streams", _) => self.streams(),
            (path, _) => self.asset(path, request),
        };
        Reply::Answer(answer, None)
    }

    fn asset(&self, path: &str, request: &Request) -> Answer {
        match self.assets.get(path) {
            Some(asset) => {
                Answer::new(asset.media_type, asset.body).version(&asset.tag, request.has_version(&asset.tag))
            }
            None => Refusal::new(404, "there is nothing here: begin at /").into(),
        }
    }

    /// As `hopes status --json`.
    fn streams(&self) -> Answer {
        match serde_json::to_vec(&self.access.status()) {
            Ok(mut json) => {
                json.push(b'\n');
                Answer::new(JSON, json)
            }
            Err(error) => Refusal::new(500, format!("the numbers cannot be written: {error}")).into(),
        }
    }

    fn snapshot(&self, name: &str, request: &Request) -> Result<(Answer, Turn), Refusal> {
        let bad = |text| Refusal::new(400, text);
        let name = snapshot::decoded(name).map_err(bad)?;
        let wanted = Wanted::parse(request.query.as_deref().unwrap_or_default()).map_err(bad)?;
        let turn = self.turn().ok_or_else(|| {
            Refusal::new(503, format!("{SNAPSHOTS} snapshots are being made, and no more at a time: try again"))
        })?;
        let patience = PATIENCE.min(self.access.limits().timeout);
        let seen = self.access.snapshot_once(&name, wanted.view, patience).map_err(|error| {
            let status = match error {
                SnapshotError::BadView(_) => 400,
                SnapshotError::NoStream(_) | SnapshotError::NoFrame(_) => 404,
                SnapshotError::Busy(_) => 503,
            };
            Refusal::new(status, error.to_string())
        })?;
        let body = wanted.form.write(&name, &seen).map_err(|error| Refusal::new(500, error.to_string()))?;
        Ok((Answer::new(wanted.form.kind(), body), turn))
    }

    fn turn(&self) -> Option<Turn> {
        let turn = Turn(Arc::clone(&self.snapshots));
        // Who comes too late gives the turn back by dropping it.
        (self.snapshots.fetch_add(1, Ordering::AcqRel) < SNAPSHOTS).then_some(turn)
    }
}
