//! Admitting connections, and ending all of them.
//!
//! In: connected sockets. Out: a reader and a writer thread for each; at the end, all of them joined.
//!
//! Invariants: there are never more connections than the limits say, and one that is reserved for administration. A
//! peer that is one too many gets an error. Nobody waits for a socket while the list of members is locked.
//!
//! Must not know: what peers send.

use std::net::Shutdown;
use std::sync::Arc;
use std::thread;
use std::time::{Duration, Instant};

use crossbeam_channel::bounded;
use hopes_protocol as wire;

use super::connection::{Arrival, Connection};
use super::members::{Member, Members, Place};
use super::socket::Socket;
use super::{reader, writer};
use crate::daemon::encoding::encoded;
use crate::daemon::locks::before_waiting;
use crate::daemon::memory::Account;
use crate::daemon::report::report;
use crate::daemon::streams::directory::Directory;

/// The stack of a connection's thread, in bytes.
const STACK: usize = 1 << 19;

/// Admits connections.
pub struct Registry {
    directory: Arc<Directory>,
    /// All connections.
    pub members: Arc<Members>,
}

impl Registry {
    /// No connections.
    pub fn new(directory: Arc<Directory>) -> Self {
        Self { directory, members: Arc::default() }
    }

    /// An account for a connection.
    pub fn account(&self) -> Arc<Account> {
        Account::part_of(&self.directory.memory.peers)
    }

    /// Starts the threads of a connection that came to an address. What is held for it is charged to an account.
    pub fn admit(&self, socket: Socket, place: &str, account: Arc<Account>) {
        let most = self.directory.limits.connections;
        let (peer, place_of_peer) = self.members.place(most);
        let is_reserved = matches!(place_of_peer, Place::Reserved) && !socket.is_read_only();
        match place_of_peer {
            Place::Closing => return,
            Place::Ordinary => {}
            Place::Reserved if is_reserved => {}
            Place::Full | Place::Reserved => {
                let reason = format!("there are {most} connections, and no more may be: try again later");
                if let Some(note) = self.directory.logs.admits("connections", place) {
                    tracing::warn!("peer {peer} at {place}: {reason}{note}");
                }
                return turn_away(&socket, reason);
            }
        }
        let arrival = Arrival { peer, place: place.to_owned(), is_reserved };
        match self.start(arrival, socket, account) {
            Ok(member) => self.members.add(member),
            Err(error) => {
                if let Some(note) = self.directory.logs.admits("threads", place) {
                    tracing::error!("peer {peer} at {place}: the system gives no thread for it: {error}{note}");
                }
            }
        }
    }

    fn start(&self, arrival: Arrival, socket: Socket, account: Arc<Account>) -> std::io::Result<Member> {
        let (wake, wakes) = bounded(1);
        let connection = Arc::new(Connection::new(arrival, socket, wake, account));
        let named = |what: &str| thread::Builder::new().name(what.to_owned()).stack_size(STACK);
        let (directory, members) = (Arc::clone(&self.directory), Arc::clone(&self.members));
        let of_writer = Arc::clone(&connection);
        let writer = named("peer writer").spawn(move || {
            directory.add_connection();
            writer::run(&of_writer, &wakes, &directory.limits);
            if of_writer.is_cut_off() {
                members.note_cut_off();
                of_writer.log_cut_off(&directory.logs);
            }
            directory.remove_connection();
        })?;
        let (directory, members) = (Arc::clone(&self.directory), Arc::clone(&self.members));
        let of_reader = Arc::clone(&connection);
        let reader = named("peer reader").spawn(move || reader::run(&directory, &members, &of_reader));
        if reader.is_err() {
            connection.socket.shutdown(Shutdown::Both);
        }
        let label = connection.label.clone();
        Ok(Member { label, connection: Arc::downgrade(&connection), reader: reader?, writer })
    }

    /// Takes no connection any more, and reads nothing more from those that there are.
    pub fn stop_reading(&self) {
        self.members.close();
        self.members.connections().iter().for_each(|connection| connection.stop_reading());
    }

    /// Sends goodbye to all, with the last frame of each stream, and waits until it is sent, but not beyond `by`.
    pub fn say_goodbye(&self, reason: &str, streams: &[(String, u64)], by: Instant) {
        let members = self.members.take();
        let connections = members.iter().filter_map(|member| member.connection.upgrade());
        connections.for_each(|connection| connection.say_goodbye(reason, streams.to_vec()));
        before_waiting("peers");
        for member in members {
            while !member.writer.is_finished() && Instant::now() < by {
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
    let refused = report(wire::ErrorCode::TooManyConnections, 0, reason);
    let Some(message) = encoded(refused, &Arc::default()) else { return };
    let header = wire::header(wire::Banner::OURS.lowest, message.kind, 0, message.length);
    let bytes = [&wire::Banner::OURS.encode()[..], &header, &message.bytes].concat();
    // A peer that does not take so few bytes at once is not waited for.
    const AT_ONCE: Duration = Duration::from_millis(10);
    let _ = socket.write(&bytes, AT_ONCE).and_then(|()| socket.finish(false, AT_ONCE));
    socket.shutdown(Shutdown::Write);
}
