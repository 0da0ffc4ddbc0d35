//! All peers of a daemon, from the moment they connect to the moment their threads have ended.
//!
//! In: connected sockets. Out: a reader and a writer thread for each; at the end, all of them joined. Invariants: there are never more peers than the limits say; a peer that is one too many is told so. Must not
//! know: what peers say.

use std::net::Shutdown;
use std::sync::{Arc, Mutex, Weak};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

use crossbeam_channel::bounded;
use hopes_protocol as wire;

use super::{Peer, Socket, reader, report, writer};
use crate::daemon::convert::encoded;
use crate::daemon::streams::{Hub, lock};

/// How long peers may take to read their farewell.
const FAREWELL: Duration = Duration::from_secs(5);

/// A thread of a peer needs no deep stack.
const STACK: usize = 1 << 19;

struct Member {
    label: String,
    /// Gone with its threads, and its socket with it, whenever others look here next.
    peer: Weak<Peer>,
    reader: JoinHandle<()>,
    writer: JoinHandle<()>,
}

/// The peers.
pub struct Registry {
    hub: Arc<Hub>,
    members: Mutex<Members>,
}

#[derive(Default)]
struct Members {
    list: Vec<Member>,
    admitted: u64,
    is_closing: bool,
}

impl Registry {
    /// Nobody has connected yet.
    pub fn new(hub: Arc<Hub>) -> Self {
        Self { hub, members: Mutex::default() }
    }

    /// Begins to talk with whoever has connected at a place.
    pub fn admit(&self, socket: Socket, place: &str) {
        let mut members = lock(&self.members);
        members.list.retain(|member| !(member.reader.is_finished() && member.writer.is_finished()));
        if members.is_closing {
            return;
        }
        members.admitted += 1;
        let label = format!("peer {} at {place}", members.admitted);
        let most = self.hub.limits.connections;
        if members.list.len() >= most {
            let reason = format!("there are {most} connections, and no more may be: try again later");
            tracing::warn!("{label}: {reason}");
            return turn_away(&socket, reason);
        }
        match self.start(socket, &label) {
            Ok(member) => members.list.push(member),
            Err(error) => tracing::error!("{label}: the system gives no thread for it: {error}"),
        }
    }

    fn start(&self, socket: Socket, label: &str) -> std::io::Result<Member> {
        let (bell, rings) = bounded(1);
        let peer = Arc::new(Peer::new(label.to_owned(), socket, bell));
        let named = |what: &str| thread::Builder::new().name(what.to_owned()).stack_size(STACK);
        let (hub, of_writer) = (Arc::clone(&self.hub), Arc::clone(&peer));
        let writer = named("peer writer").spawn(move || {
            hub.count_connection();
            writer::run(&of_writer, &rings, &hub.limits);
            hub.discount_connection();
        })?;
        let (hub, of_reader) = (Arc::clone(&self.hub), Arc::clone(&peer));
        let reader = named("peer reader").spawn(move || reader::run(&hub, &of_reader));
        if reader.is_err() {
            peer.socket.shutdown(Shutdown::Both);
        }
        Ok(Member { label: label.to_owned(), peer: Arc::downgrade(&peer), reader: reader?, writer })
    }

    /// Admits nobody any more and takes in nothing more from those who are there.
    pub fn stop_reading(&self) {
        let mut members = lock(&self.members);
        members.is_closing = true;
        members.list.iter().filter_map(|member| member.peer.upgrade()).for_each(|peer| peer.stop_reading());
    }

    /// Says goodbye to all, with the last frame of each stream, and waits until they have heard it; not too long.
    pub fn say_goodbye(&self, reason: &str, streams: &[(String, u64)]) {
        let list = std::mem::take(&mut lock(&self.members).list);
        let peers = list.iter().filter_map(|member| member.peer.upgrade());
        peers.for_each(|peer| peer.say_goodbye(reason, streams.to_vec()));
        let deadline = Instant::now() + FAREWELL;
        for member in list {
            while !member.writer.is_finished() && Instant::now() < deadline {
                thread::sleep(Duration::from_millis(2));
            }
            if let Some(peer) = member.peer.upgrade() {
                peer.socket.shutdown(Shutdown::Both);
            }
            for thread in [member.writer, member.reader] {
                if thread.join().is_err() {
                    tracing::error!("{}: a thread of it stopped by itself: please report this", member.label);
                }
            }
        }
    }
}

/// Tells somebody that there is no room. They have said nothing yet; the banner comes first all the same.
fn turn_away(socket: &Socket, reason: String) {
    let Some(message) = encoded(report(wire::ErrorCode::TooManyConnections, 0, reason)) else { return };
    let header = wire::header(wire::Banner::OURS.lowest, message.kind, 0, message.length);
    let bytes = [&wire::Banner::OURS.encode()[..], &header, &message.bytes].concat();
    // Who does not take so few bytes at once is not waited for.
    const AT_ONCE: Duration = Duration::from_millis(10);
    let _ = socket.write(&bytes, AT_ONCE).and_then(|()| socket.finish(false, AT_ONCE));
    socket.shutdown(Shutdown::Write);
}
