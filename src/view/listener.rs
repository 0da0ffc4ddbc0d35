//! Where visitors connect: one port, a thread for each visitor, one answer each.
//!
//! In: a place, and the daemon as access see it. Out: answers, and peers for those who ask for a WebSocket.
//! Invariants: this machine only, unless asked for; a visitor who does not say what he wants, or does not take the
//! answer, is sent away after a while; who is one too many is told so at once; threads are named, and joined. Must not
//! know: what is answered.

use std::net::{IpAddr, Ipv4Addr, Ipv6Addr, Shutdown, SocketAddr, TcpListener, TcpStream};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Weak};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

use super::http::{Answer, LONGEST_HEAD, Refusal, Request};
use super::routes::{Reply, Routes};
use super::websocket::{self, WebSocket};
use crate::daemon::{Address, HttpAccess, ListenError, Socket, StartHttp, StopHttp, bind_tcp};

/// So many visitors there may be in any case: a browser alone comes with half a dozen connections.
const FEWEST: usize = 16;

/// How long a visitor may take to say what he wants.
const HEAD: Duration = Duration::from_secs(10);

/// How long somebody is listened to after the answer, so that it is not lost with what he still says.
const FAREWELL: Duration = Duration::from_millis(500);

/// How long visitors may still read when the daemon ends.
const LAST: Duration = Duration::from_secs(1);

/// A thread of a visitor needs no deep stack.
const STACK: usize = 1 << 19;

/// Where the page is, and what that is called.
#[derive(Clone, Debug)]
pub struct Place {
    /// Host and port to listen at.
    pub address: String,
    /// Names by which it may be asked for, besides its addresses.
    pub names: Vec<String>,
    /// Whether visitors may come from other machines.
    pub allow_remote: bool,
}

/// A page whose place is taken; visitors wait until a daemon opens it.
#[derive(Debug)]
pub struct Page {
    bound: TcpListener,
    at: SocketAddr,
    place: Place,
}

impl Page {
    /// Takes a place.
    ///
    /// # Errors
    /// [`ListenError`]: somebody else has it, or nobody may.
    pub fn bind(place: Place) -> Result<Self, ListenError> {
        let address = Address::Tcp(place.address.clone());
        let bound = bind_tcp(&place.address, &address, place.allow_remote).map_err(|error| match error {
            ListenError::Remote(address) => ListenError::RemotePage(address),
            other => other,
        })?;
        let at = bound.local_addr().map_err(|error| ListenError::System { address, error })?;
        Ok(Self { bound, at, place })
    }

    /// What to open in a browser on this machine.
    pub fn url(&self) -> String {
        format!("http://{}/", SocketAddr::new(reachable(self.at.ip()), self.at.port()))
    }

    /// The way in, for a daemon to open.
    pub fn http(self) -> StartHttp {
        Box::new(move |access| {
            let listener = Listener::start(self, access)?;
            Ok(Box::new(move || listener.stop()) as StopHttp)
        })
    }
}

/// A port that is listened at.
struct Listener {
    at: SocketAddr,
    is_ending: Arc<AtomicBool>,
    thread: JoinHandle<Vec<Visitor>>,
}

/// Somebody who has connected.
struct Visitor {
    /// Gone with its thread, or when it has become a peer.
    socket: Weak<Socket>,
    thread: JoinHandle<()>,
}

/// What all visitors share.
struct House {
    routes: Routes,
    access: HttpAccess,
    /// As given, in small letters.
    names: Vec<String>,
    place: String,
}

impl Listener {
    fn start(page: Page, access: HttpAccess) -> Result<Self, ListenError> {
        let Page { bound, at, place } = page;
        let system = |error| ListenError::System { address: Address::Tcp(place.address.clone()), error };
        tracing::info!("the page is at http://{at}/");
        let names = place.names.iter().map(|name| name.to_ascii_lowercase()).collect();
        let house =
            Arc::new(House { routes: Routes::new(access.clone()), access, names, place: format!("http://{at}") });
        let is_ending = Arc::new(AtomicBool::new(false));
        let ends = Arc::clone(&is_ending);
        let thread = thread::Builder::new()
            .name("page listener".to_owned())
            .spawn(move || accept_all(&bound, &ends, &house))
            .map_err(system)?;
        Ok(Self { at, is_ending, thread })
    }

    /// Listens no more, and waits for those who are being answered; not too long.
    fn stop(self) {
        self.is_ending.store(true, Ordering::Release);
        let here = SocketAddr::new(reachable(self.at.ip()), self.at.port());
        // Accepting ends when somebody comes. Where nobody can, the thread ends with the process.
        if TcpStream::connect_timeout(&here, LAST).is_err() {
            return;
        }
        let joined = self.thread.join();
        let Ok(visitors) = joined else {
            return tracing::error!("the page's thread stopped by itself: please report this");
        };
        let shutdown = |visitor: &Visitor, how| {
            if let Some(socket) = visitor.socket.upgrade() {
                socket.shutdown(how);
            }
        };
        visitors.iter().for_each(|visitor| shutdown(visitor, Shutdown::Read));
        let deadline = Instant::now() + LAST;
        for visitor in visitors {
            while !visitor.thread.is_finished() && Instant::now() < deadline {
                thread::sleep(Duration::from_millis(2));
            }
            shutdown(&visitor, Shutdown::Both);
            if visitor.thread.join().is_err() {
                tracing::error!("a visitor's thread stopped by itself: please report this");
            }
        }
    }
}

/// Where a port can be reached from here that listens at an address.
fn reachable(at: IpAddr) -> IpAddr {
    match at {
        IpAddr::V4(at) if at.is_unspecified() => Ipv4Addr::LOCALHOST.into(),
        IpAddr::V6(at) if at.is_unspecified() => Ipv6Addr::LOCALHOST.into(),
        at => at,
    }
}

/// Takes in visitors to the end. Those who are still there then.
fn accept_all(bound: &TcpListener, is_ending: &AtomicBool, house: &Arc<House>) -> Vec<Visitor> {
    let mut visitors: Vec<Visitor> = Vec::new();
    // Peers, who may be long, have all connections; visitors, who are short, never take the last ones from them.
    let most = (house.access.limits().connections / 4).max(FEWEST);
    let mut visits = 0u64;
    loop {
        let accepted = bound.accept();
        if is_ending.load(Ordering::Acquire) {
            return visitors;
        }
        visitors.retain(|visitor| !visitor.thread.is_finished());
        let welcomed = accepted.and_then(|(stream, _)| {
            stream.set_nodelay(true)?;
            let local = stream.local_addr()?;
            let socket = Arc::new(Socket::Tcp(stream));
            if visitors.len() >= most {
                turn_away(&socket, most);
                return Ok(());
            }
            visits += 1;
            let (house, weak, number) = (Arc::clone(house), Arc::downgrade(&socket), visits);
            let thread = thread::Builder::new()
                .name("page visitor".to_owned())
                .stack_size(STACK)
                .spawn(move || house.visit(socket, local, number))?;
            visitors.push(Visitor { socket: weak, thread });
            Ok(())
        });
        if let Err(error) = welcomed {
            tracing::warn!("{}: cannot accept a visitor: {error}", house.place);
            // Usually too many open files, which takes some time to pass.
            thread::sleep(Duration::from_millis(100));
        }
    }
}

/// Tells somebody that there is no room. Who does not take so few bytes at once is not waited for.
fn turn_away(socket: &Socket, most: usize) {
    tracing::debug!("a visitor is turned away: there are {most}");
    let text = format!("there are {most} visitors, and no more may be: try again later");
    let answer = Answer::from(Refusal::new(503, text)).encode(false);
    let _ = socket.write(&answer, Duration::from_millis(10));
    socket.shutdown(Shutdown::Write);
}

impl House {
    /// Answers one question of a visitor, or makes a peer of him.
    fn visit(&self, socket: Arc<Socket>, local: SocketAddr, number: u64) {
        let Some((asked, early)) = hear(&socket, HEAD.min(self.access.limits().timeout)) else { return };
        let is_head = asked.as_ref().is_ok_and(|request| request.is_head);
        let is_name = |host: &str| self.is_name(host, local);
        let reply = asked.and_then(|request| {
            let is_socket = Routes::is_socket(&request);
            request.check_origin(is_name, is_socket)?;
            if is_socket { websocket::handshake(&request).map(Reply::Socket) } else { Ok(self.routes.answer(&request)) }
        });
        let patience = self.access.limits().timeout;
        let answer = match reply {
            Ok(Reply::Socket(handshake)) => {
                if socket.write(&handshake, patience).is_ok() {
                    self.access.admit(Box::new(WebSocket::new(socket, early)), &format!("{}/ws", self.place));
                }
                return;
            }
            Ok(Reply::Answer(answer, turn)) => (answer, turn),
            Err(refusal) => (refusal.into(), None),
        };
        let (answer, _turn) = answer;
        match socket.write(&answer.encode(is_head), patience) {
            Ok(()) => part(&socket),
            Err(error) => tracing::debug!("visitor {number}: cannot answer: {error}"),
        }
    }

    /// Whether this place is called so, as reached at an address of this machine.
    fn is_name(&self, host: &str, local: SocketAddr) -> bool {
        let (ip, port) = (local.ip().to_canonical(), local.port());
        let own = ["localhost".to_owned(), "127.0.0.1".to_owned(), "[::1]".to_owned(), written(ip)];
        let is = |name: &str| {
            let without = host.strip_prefix(name);
            without
                .is_some_and(|rest| rest.strip_prefix(':') == Some(&port.to_string()) || rest.is_empty() && port == 80)
        };
        // What stands before this place may have another port.
        own.iter().any(|name| is(name)) || self.names.iter().any(|name| is(name) || host == name)
    }
}

fn written(ip: IpAddr) -> String {
    match ip {
        IpAddr::V4(ip) => ip.to_string(),
        IpAddr::V6(ip) => format!("[{ip}]"),
    }
}

/// The question of a visitor, or why it is none, and what came after it; nothing, if he has gone or said nothing.
fn hear(socket: &Socket, patience: Duration) -> Option<(Result<Request, Refusal>, Vec<u8>)> {
    let deadline = Instant::now() + patience;
    let mut heard = Vec::new();
    let mut buffer = [0; 4096];
    loop {
        let left = deadline.saturating_duration_since(Instant::now()).max(Duration::from_millis(1));
        match socket.read(&mut buffer, left) {
            Ok(Some([])) | Err(_) => return None,
            Ok(Some(bytes)) => heard.extend_from_slice(bytes),
            Ok(None) => {}
        }
        match Request::parse(&heard) {
            Ok(Some((request, length))) => return Some((Ok(request), heard.split_off(length))),
            Err(refusal) => return Some((Err(refusal), Vec::new())),
            Ok(None) if Instant::now() < deadline => {}
            Ok(None) if heard.is_empty() => return None,
            Ok(None) => {
                let text = format!("the head of a request, of at most {LONGEST_HEAD} bytes, has to come in time");
                return Some((Err(Refusal::new(408, text)), Vec::new()));
            }
        }
    }
}

/// Hangs up. What the visitor still says is read for a moment: a system that throws it away tells him to throw our
/// answer away.
fn part(socket: &Socket) {
    socket.shutdown(Shutdown::Write);
    let deadline = Instant::now() + FAREWELL;
    let mut buffer = [0; 4096];
    while Instant::now() < deadline {
        match socket.read(&mut buffer, FAREWELL) {
            Ok(Some([])) | Ok(None) | Err(_) => return,
            Ok(Some(_)) => {}
        }
    }
}
