//! All connections of a daemon, from their beginning to the end of their threads.
//!
//! In: connected sockets. Out: a reader and a writer thread for each; at the end, all of them joined.
//!
//! Invariants: there are never more connections than the limits say. A peer that is one too many gets an error.
//!
//! Must not know: what peers send.

use std::net::Shutdown;
use std::sync::{Arc, Mutex, Weak};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

use crossbeam_channel::bounded;
use hopes_protocol as wire;

use super::connection::Connection;
use super::report::report;
use super::socket::Socket;
use super::{reader, writer};
use crate::daemon::encoding::encoded;
use crate::daemon::locks::lock;
use crate::daemon::streams::directory::Directory;

/// How long peers may take to read the goodbye.
const GOODBYE: Duration = Duration::from_secs(5);

/// The stack of a connection's thread, in bytes.
const STACK: usize = 1 << 19;

struct Member {
    label: String,
    /// Weak, so that the socket is closed as soon as both threads have ended.
    connection: Weak<Connection>,
    reader: JoinHandle<()>,
    writer: JoinHandle<()>,
}

/// All connections.
pub struct Registry {
    directory: Arc<Directory>,
    members: Mutex<Members>,
}

#[derive(Default)]
struct Members {
    list: Vec<Member>,
    admitted: u64,
    is_closing: bool,
}

impl Registry {
    /// No connections.
    pub fn new(directory: Arc<Directory>) -> Self {
        Self { directory, members: Mutex::default() }
    }

    /// Starts the threads of a connection that came to an address.
    pub fn admit(&self, socket: Socket, place: &str) {
        let mut members = lock(&self.members);
        members.list.retain(|member| !(member.reader.is_finished() && member.writer.is_finished()));
        if members.is_closing {
            return;
        }
        members.admitted += 1;
        let label = format!("peer {} at {place}", members.admitted);
        let most = self.directory.limits.connections;
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
        let (wake, wakes) = bounded(1);
        let connection = Arc::new(Connection::new(label.to_owned(), socket, wake));
        let named = |what: &str| thread::Builder::new().name(what.to_owned()).stack_size(STACK);
        let (directory, of_writer) = (Arc::clone(&self.directory), Arc::clone(&connection));
        let writer = named("peer writer").spawn(move || {
            directory.add_connection();
            writer::run(&of_writer, &wakes, &directory.limits);
            directory.remove_connection();
        })?;
        let (directory, of_reader) = (Arc::clone(&self.directory), Arc::clone(&connection));
        let reader = named("peer reader").spawn(move || reader::run(&directory, &of_reader));
        if reader.is_err() {
            connection.socket.shutdown(Shutdown::Both);
        }
        Ok(Member { label: label.to_owned(), connection: Arc::downgrade(&connection), reader: reader?, writer })
    }

    /// Takes no connection any more, and reads nothing more from those that there are.
    pub fn stop_reading(&self) {
        let mut members = lock(&self.members);
        members.is_closing = true;
        members
            .list
            .iter()
            .filter_map(|member| member.connection.upgrade())
            .for_each(|connection| connection.stop_reading());
    }

    /// Sends goodbye to all, with the last frame of each stream, and waits a bounded time until it is sent.
    pub fn say_goodbye(&self, reason: &str, streams: &[(String, u64)]) {
        let list = std::mem::take(&mut lock(&self.members).list);
        let connections = list.iter().filter_map(|member| member.connection.upgrade());
        connections.for_each(|connection| connection.say_goodbye(reason, streams.to_vec()));
        let deadline = Instant::now() + GOODBYE;
        for member in list {
            while !member.writer.is_finished() && Instant::now() < deadline {
                thread::sleep(Duration::from_millis(2));
            }
            if let Some(connection) = member.connection.upgrade() {
                connection.socket.shutdown(Shutdown::Both);
            }
            for thread in [member.writer, member.reader] {
                if thread.join().is_err() {
                    tracing::error!("{}: a thread of it stopped by itself: please report this", member.label);
                }
            }
        }
    }
}

/// Refuses a peer for want of room. The banner comes first, as always.
fn turn_away(socket: &Socket, reason: String) {
    let Some(message) = encoded(report(wire::ErrorCode::TooManyConnections, 0, reason)) else { return };
    let header = wire::header(wire::Banner::OURS.lowest, message.kind, 0, message.length);
    let bytes = [&wire::Banner::OURS.encode()[..], &header, &message.bytes].concat();
    // A peer that does not take so few bytes at once is not waited for.
    const AT_ONCE: Duration = Duration::from_millis(10);
    let _ = socket.write(&bytes, AT_ONCE).and_then(|()| socket.finish(false, AT_ONCE));
    socket.shutdown(Shutdown::Write);
}
