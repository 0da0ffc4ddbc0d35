//! Administration of a daemon by its peers: what it holds, who is there; ends of streams and of connections.
//!
//! In: requests. Out: answers.
//!
//! Invariants: whoever waits for an end waits a bounded time, and holds nobody else up.
//!
//! Must not know: channels, who asks.

use std::sync::Arc;
use std::thread;
use std::time::{Duration, Instant};

use hopes_protocol::{self as wire, ErrorCode, Message};

use super::members::Members;
use crate::daemon::locks::before_waiting;
use crate::daemon::settings::SOFTWARE;
use crate::daemon::streams::directory::Directory;
use crate::daemon::streams::stream::Stream;

/// The protocol's word for what was wrong, and the same for people.
pub type Refused = (ErrorCode, String);

/// How long a stream may take to finish what it has.
const PATIENCE: Duration = Duration::from_secs(5);

/// The answer to a request.
///
/// # Errors
/// [`Refused`]: there is no such stream or peer, or the message is no such request.
pub fn answer(directory: &Directory, members: &Members, request: &Message) -> Result<Message, Refused> {
    Ok(match request {
        Message::GetStatus(_) => directory.status(SOFTWARE).into(),
        Message::ListPeers(_) => wire::Peers { peers: members.peers() }.into(),
        Message::GetMemory(_) => memory(directory).into(),
        Message::StopStream(stop) => stop_stream(directory, &stop.name)?.into(),
        Message::Disconnect(wire::Disconnect { peer }) => {
            if !members.disconnect(*peer, "an administrator has disconnected this peer") {
                return Err((ErrorCode::NoPeer, format!("there is no peer {peer}: see `hopes status --peers`")));
            }
            wire::Disconnected { peer: *peer }.into()
        }
        _ => return Err((ErrorCode::Unexpected, "this is no request for administration".to_owned())),
    })
}

fn memory(directory: &Directory) -> wire::Memory {
    let memory = &directory.memory;
    let of_stream = |stream: &Arc<Stream>| {
        let accounts = &stream.state.accounts;
        let (points, views, queue) = (accounts.points.held(), accounts.views.held(), accounts.queue.held());
        wire::StreamMemory { name: stream.state.name.clone(), points, views, queue }
    };
    wire::Memory {
        limit: memory.limit,
        held: memory.whole.held(),
        peers: memory.peers.held(),
        streams: directory.streams().iter().map(of_stream).collect(),
    }
}

/// Names that are listed, at most.
const NAMED: usize = 10;

/// Which streams there are, after the name of one that is not.
fn there_are(directory: &Directory) -> String {
    let names: Vec<String> = directory.streams().iter().map(|stream| stream.state.name.clone()).collect();
    match names.len() {
        0 => ": there is none".to_owned(),
        number => {
            let rest = if number > NAMED { " and others: see `hopes status`" } else { "" };
            format!(": there are {}{rest}", names[..number.min(NAMED)].join(", "))
        }
    }
}

fn stop_stream(directory: &Directory, name: &str) -> Result<wire::StreamStopped, Refused> {
    if !wire::is_name(name) {
        return Err((ErrorCode::BadName, format!("{name:?} is no name of a stream")));
    }
    let Some(stream) = directory.stream(name) else {
        return Err((ErrorCode::NoStream, format!("there is no stream {name:?}{}", there_are(directory))));
    };
    let deadline = Instant::now() + PATIENCE;
    stream.finish(deadline);
    before_waiting("the end of a stream");
    while !stream.has_ended() && Instant::now() < deadline {
        thread::sleep(Duration::from_millis(2));
    }
    Ok(wire::StreamStopped { name: name.to_owned(), frame: stream.state.stats.frame() })
}
