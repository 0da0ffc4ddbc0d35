//! What a client of events wants.
//!
//! In: the path, the query and the fields of a request.
//! Out: the stream, the view, whether whole frames or changes are wanted, the last event that the client has.
//! Invariants: a request that cannot be met is refused with the reason.
//! Must not know: streams, sockets.

use std::fmt;

use hopes_protocol::{Resume, View};

use crate::view::http::Request;
use crate::view::query::{Query, decoded};

/// The frames that a client wants.
#[derive(Clone, Debug, PartialEq)]
pub struct FramesRequest {
    /// The stream.
    pub name: String,
    /// The view.
    pub view: View,
    /// Only what has changed is wanted, and not every frame as a whole.
    pub changes: bool,
    /// The frame that the client has.
    pub last: Option<Resume>,
}

impl FramesRequest {
    /// The request of a client; the part of the path that is the stream's name is given. The epoch of the stream of
    /// that name is asked for, if there is one.
    ///
    /// # Errors
    /// The text says what is wrong with it, and what may be requested.
    pub fn parse(name: &str, request: &Request, epoch: impl Fn(&str) -> Option<u64>) -> Result<Self, String> {
        let name = decoded(name)?;
        let query = Query::parse(request.query.as_deref().unwrap_or_default(), &["changes"])?;
        let last = match request.header("last-event-id") {
            None if request.has("last-event-id") => return Err("a request has one Last-Event-ID, not two".to_owned()),
            None | Some("") => None,
            Some(id) => Some(LastId::parse(id)?),
        };
        // A number alone is one of the stream that is there now.
        let epoch = last.and_then(|last| last.epoch.or_else(|| epoch(&name)));
        let last = last.zip(epoch).map(|(last, epoch)| Resume { epoch, frame: last.frame });
        Ok(Self { view: query.view()?, changes: query.has("changes")?, name, last })
    }
}

/// The id of an event: the number of its frame, and the epoch of its stream, which differs between streams that had
/// the same name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LastId {
    frame: u64,
    epoch: Option<u64>,
}

impl LastId {
    /// The id of a frame.
    pub fn new(frame: u64, epoch: u64) -> Self {
        Self { frame, epoch: Some(epoch) }
    }

    fn parse(id: &str) -> Result<Self, String> {
        let (frame, epoch) = id.split_once('-').map_or((id, None), |(frame, epoch)| (frame, Some(epoch)));
        let epoch = epoch.map(|epoch| u64::from_str_radix(epoch, 16)).transpose();
        let frame = frame.parse().ok().filter(|frame| *frame > 0);
        frame.zip(epoch.ok()).map(|(frame, epoch)| Self { frame, epoch }).ok_or_else(|| {
            format!("Last-Event-ID is the id of an event, such as 17-6a3f, or the number of a frame, not {id:?}")
        })
    }
}

impl fmt::Display for LastId {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.epoch {
            Some(epoch) => write!(f, "{}-{epoch:x}", self.frame),
            None => write!(f, "{}", self.frame),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ids_are_read_as_they_are_written() {
        for id in [LastId::new(1, 0), LastId::new(u64::MAX, u64::MAX), LastId { frame: 5, epoch: None }] {
            assert_eq!(LastId::parse(&id.to_string()), Ok(id));
        }
        for id in ["", "0", "-1", "5-", "5-g", "5-1-1", "x", "1.5", "99999999999999999999", "5-fffffffffffffffff"] {
            assert!(LastId::parse(id).unwrap_err().contains("the id of an event"), "{id}");
        }
    }
}
