//! The HTTP listener of the page: one port, one thread per client connection, one response each.
//!
//! In: an address; the daemon's [`HttpAccess`].
//! Out: responses; a read-only connection of the daemon for each WebSocket, and for each client of events.
//! Invariants: only this machine can connect, unless remote clients were allowed. A client that sends no complete head,
//! or does not read the response, is disconnected after a timeout. A client above the limit gets a 503, even if it is
//! silent; a few may still ask for the daemon's health. Threads are named, and joined.
//! Must not know: which resources there are.

use std::io;
use std::net::{IpAddr, Ipv4Addr, Ipv6Addr, Shutdown, SocketAddr, TcpListener, TcpStream};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Weak};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

use super::events::{self, EventStream};
use super::http::{self, MAX_HEAD, Refusal, Request, Response};
use super::names::Names;
use super::routes::{HEALTH, Reply, Routes};
use super::websocket::{self, WebSocket};
use crate::daemon::{Account, Address, HttpAccess, ListenError, Socket, StartHttp, StopHttp, Transport, bind_tcp};

/// The limit of clients is this or more: a browser alone opens half a dozen connections.
const MIN_CLIENTS: usize = 16;

/// Clients above the limit that may still ask for the daemon's health.
const PROBES: usize = 4;

/// How long such a client may take to send a head.
const PROBE_TIMEOUT: Duration = Duration::from_secs(1);

/// How long a client may take to read so many bytes of a response: one that is slower is disconnected.
const STEP_TIMEOUT: Duration = Duration::from_secs(10);

/// Bytes of a response that are sent in one step.
const STEP: usize = 1 << 18;

/// How long a client may take to send a head.
const HEAD_TIMEOUT: Duration = Duration::from_secs(10);

/// How long a client's remaining bytes are read after the response, which a reset of the connection could discard.
const LINGER: Duration = Duration::from_millis(500);

/// How long clients may still read when the daemon ends.
const STOP_TIMEOUT: Duration = Duration::from_secs(1);

/// Where clients of events are said to come to, in logs and lists of peers.
const FRAMES: &str = "/api/streams/*/frames";

/// Bytes of a client thread's stack, which is never deep.
const STACK: usize = 1 << 19;

/// The address of the page, and its names.
#[derive(Clone, Debug, Default)]
pub struct PageAddress {
    /// Host and port to listen at.
    pub address: String,
    /// Host names that requests may use, besides its addresses.
    pub hosts: Vec<String>,
    /// Origins at which proxies show the page, such as `https://example.org`.
    pub origins: Vec<String>,
    /// Whether clients on other machines may connect.
    pub allow_remote: bool,
}

/// A bound port; clients wait until the daemon starts to accept them.
#[derive(Debug)]
pub struct Page {
    bound: TcpListener,
    at: SocketAddr,
    address: PageAddress,
}

impl Page {
    /// Binds the port.
    ///
    /// # Errors
    /// [`ListenError`]: the port is in use, or cannot be bound, or remote clients could connect but are not allowed to.
    pub fn bind(page: PageAddress) -> Result<Self, ListenError> {
        let address = Address::Tcp(page.address.clone());
        let bound = bind_tcp(&page.address, &address, page.allow_remote).map_err(|error| match error {
            ListenError::Remote(address) => ListenError::RemotePage(address),
            other => other,
        })?;
        let at = bound.local_addr().map_err(|error| ListenError::System { address, error })?;
        Ok(Self { bound, at, address: page })
    }

    /// The address to open in a browser on this machine.
    pub fn url(&self) -> String {
        format!("http://{}/", SocketAddr::new(reachable(self.at.ip()), self.at.port()))
    }

    /// Starts the HTTP server when the daemon calls it.
    pub fn http(self) -> StartHttp {
        Box::new(move |access| {
            let listener = Listener::start(self, access)?;
            Ok(Box::new(move || listener.stop()) as StopHttp)
        })
    }
}

/// The listener thread.
struct Listener {
    at: SocketAddr,
    is_stopping: Arc<AtomicBool>,
    thread: JoinHandle<Vec<Client>>,
}

/// A connected client.
struct Client {
    /// Dropped with the thread.
    socket: Weak<Socket>,
    /// It became a connection of the daemon, which ends it.
    is_handed_over: Arc<AtomicBool>,
    thread: JoinHandle<()>,
}

/// What a client's thread knows of its client.
struct Visit {
    /// The address to which it has connected.
    local: SocketAddr,
    number: u64,
    /// It is above this limit, and may only ask for the daemon's health.
    only_health: Option<usize>,
    is_handed_over: Arc<AtomicBool>,
}

/// What all client threads share.
struct Server {
    routes: Routes,
    access: HttpAccess,
    names: Names,
    url: String,
}

impl Listener {
    fn start(page: Page, access: HttpAccess) -> Result<Self, ListenError> {
        let Page { bound, at, address } = page;
        let system = |error| ListenError::System { address: Address::Tcp(address.address.clone()), error };
        tracing::info!("the page is at http://{at}/");
        let names = Names::new(&address.hosts, &address.origins);
        let routes = Routes::new(access.clone());
        let server = Arc::new(Server { routes, access, names, url: format!("http://{at}") });
        let is_stopping = Arc::new(AtomicBool::new(false));
        let stopping = Arc::clone(&is_stopping);
        let thread = thread::Builder::new()
            .name("page listener".to_owned())
            .spawn(move || accept_all(&bound, &stopping, &server))
            .map_err(system)?;
        Ok(Self { at, is_stopping, thread })
    }

    /// Stops accepting, and waits a while for responses that are being sent.
    fn stop(self) {
        self.is_stopping.store(true, Ordering::Release);
        let here = SocketAddr::new(reachable(self.at.ip()), self.at.port());
        // This connection wakes the accepting thread. If it cannot be made, the thread ends with the process.
        if TcpStream::connect_timeout(&here, STOP_TIMEOUT).is_err() {
            return;
        }
        let Ok(clients) = self.thread.join() else {
            return tracing::error!("the page's listener thread panicked: please report this");
        };
        let shutdown = |client: &Client, how| {
            if let Some(socket) = client.socket.upgrade().filter(|_| !client.is_handed_over.load(Ordering::Acquire)) {
                socket.shutdown(how);
            }
        };
        clients.iter().for_each(|client| shutdown(client, Shutdown::Read));
        let deadline = Instant::now() + STOP_TIMEOUT;
        for client in clients {
            while !client.thread.is_finished() && Instant::now() < deadline {
                thread::sleep(Duration::from_millis(2));
            }
            shutdown(&client, Shutdown::Both);
            if client.thread.join().is_err() {
                tracing::error!("a page client's thread panicked: please report this");
            }
        }
    }
}

/// The address at which this machine reaches a port that is bound to an address.
fn reachable(at: IpAddr) -> IpAddr {
    match at {
        IpAddr::V4(at) if at.is_unspecified() => Ipv4Addr::LOCALHOST.into(),
        IpAddr::V6(at) if at.is_unspecified() => Ipv6Addr::LOCALHOST.into(),
        at => at,
    }
}

/// Accepts clients until the listener stops. Returns those that are still connected then.
fn accept_all(bound: &TcpListener, is_stopping: &AtomicBool, server: &Arc<Server>) -> Vec<Client> {
    let mut clients: Vec<Client> = Vec::new();
    // A quarter of the daemon's limit, on top of it: requests never take the place of a connection of the daemon.
    let limit = (server.access.limits().connections / 4).max(MIN_CLIENTS);
    let mut accepted = 0u64;
    loop {
        let connection = bound.accept();
        if is_stopping.load(Ordering::Acquire) {
            return clients;
        }
        clients.retain(|client| !client.thread.is_finished());
        let started = connection.and_then(|(stream, _)| {
            stream.set_nodelay(true)?;
            let local = stream.local_addr()?;
            let socket = Arc::new(Socket::Tcp(stream));
            let is_full = clients.len() >= limit;
            if clients.len() >= limit + PROBES {
                refuse_client(&socket, limit);
                return Ok(());
            }
            accepted += 1;
            let (server, weak) = (Arc::clone(server), Arc::downgrade(&socket));
            let is_handed_over = Arc::<AtomicBool>::default();
            let only_health = is_full.then_some(limit);
            let client = Visit { local, number: accepted, only_health, is_handed_over: Arc::clone(&is_handed_over) };
            let thread = thread::Builder::new()
                .name("page client".to_owned())
                .stack_size(STACK)
                .spawn(move || server.serve(socket, client))?;
            clients.push(Client { socket: weak, is_handed_over, thread });
            Ok(())
        });
        if let Err(error) = started {
            tracing::warn!("{}: cannot accept a client: {error}", server.url);
            // The usual reason is too many open files, which takes a while to pass.
            thread::sleep(Duration::from_millis(100));
        }
    }
}

fn too_many_clients(limit: usize) -> Refusal {
    Refusal::new(503, format!("{limit} clients are connected, the most at a time: try again later"))
}

/// Sends a 503 to a client above the limit. A socket without room for so few bytes is not waited for.
fn refuse_client(socket: &Socket, limit: usize) {
    tracing::debug!("a client is refused: {limit} are connected");
    let (head, body) = Response::from(too_many_clients(limit)).encode(false);
    let _ = socket.write(&[&head, &body[..]].concat(), Duration::from_millis(10));
    socket.shutdown(Shutdown::Write);
}

impl Server {
    /// Responds to one request of a client, or makes it a connection of the daemon.
    fn serve(&self, socket: Arc<Socket>, client: Visit) {
        let timeout = self.access.limits().timeout;
        let patience = if client.only_health.is_some() { PROBE_TIMEOUT } else { HEAD_TIMEOUT };
        let silent = || client.only_health.map(|limit| (Err(too_many_clients(limit)), Vec::new()));
        let Some((request, early)) = read_request(&socket, patience.min(timeout)).or_else(silent) else { return };
        let is_head = request.as_ref().is_ok_and(|request| request.is_head);
        let response = match request.and_then(|request| self.reply(&request, &client)) {
            Ok(Reply::Upgrade(handshake)) => {
                if socket.write(&handshake, timeout).is_ok() {
                    client.is_handed_over.store(true, Ordering::Release);
                    self.admit("/ws", |_| Box::new(WebSocket::new(socket, early)));
                }
                return;
            }
            Ok(Reply::Events(_)) if is_head => {
                if socket.write(&http::endless(events::MEDIA_TYPE), timeout).is_ok() {
                    close(&socket);
                }
                return;
            }
            Ok(Reply::Events(wanted)) => {
                client.is_handed_over.store(true, Ordering::Release);
                return self.admit(FRAMES, |account| Box::new(EventStream::new(socket, wanted, account)));
            }
            Ok(Reply::Response(response)) => response,
            Err(refusal) => refusal.into(),
        };
        match send(&socket, response, is_head, STEP_TIMEOUT.min(timeout)) {
            Ok(()) => close(&socket),
            Err(error) => tracing::debug!("client {}: cannot respond: {error}", client.number),
        }
    }

    /// Makes a client a connection of the daemon that only reads.
    fn admit(&self, path: &str, transport: impl FnOnce(&Arc<Account>) -> Box<dyn Transport>) {
        let account = self.access.account();
        self.access.admit(transport(&account), &format!("{}{path}", self.url), account);
    }

    fn reply(&self, request: &Request, client: &Visit) -> Result<Reply, Refusal> {
        let is_websocket = Routes::is_websocket(request);
        self.names.check(request, client.local, is_websocket)?;
        if let Some(limit) = client.only_health.filter(|_| request.path != HEALTH) {
            return Err(too_many_clients(limit));
        }
        if is_websocket { websocket::handshake(request).map(Reply::Upgrade) } else { Ok(self.routes.reply(request)) }
    }
}

/// Sends a response step by step: a client that takes too long for one is given up.
fn send(socket: &Socket, response: Response, is_head: bool, patience: Duration) -> io::Result<()> {
    let (head, body) = response.encode(is_head);
    if body.len() < STEP {
        return socket.write(&[&head, &body[..]].concat(), patience);
    }
    socket.write(&head, patience)?;
    body.chunks(STEP).try_for_each(|step| socket.write(step, patience))
}

/// The request of a client, or its refusal, and the bytes after it; none if the client closed or sent nothing.
fn read_request(socket: &Socket, timeout: Duration) -> Option<(Result<Request, Refusal>, Vec<u8>)> {
    let deadline = Instant::now() + timeout;
    let mut received = Vec::new();
    let mut buffer = [0; 4096];
    loop {
        let left = deadline.saturating_duration_since(Instant::now()).max(Duration::from_millis(1));
        match socket.read(&mut buffer, left) {
            Ok(Some([])) | Err(_) => return None,
            Ok(Some(bytes)) => received.extend_from_slice(bytes),
            Ok(None) => {}
        }
        match Request::parse(&received) {
            Ok(Some((request, length))) => return Some((Ok(request), received.split_off(length))),
            Err(refusal) => return Some((Err(refusal), Vec::new())),
            Ok(None) if Instant::now() < deadline => {}
            Ok(None) if received.is_empty() => return None,
            Ok(None) => {
                let text = format!("the head of a request, of at most {MAX_HEAD} bytes, must be complete in time");
                return Some((Err(Refusal::new(408, text)), Vec::new()));
            }
        }
    }
}

/// Closes a connection. What the client still sends is read for a moment: unread bytes would reset the connection, and
/// a reset can discard the response at the client.
fn close(socket: &Socket) {
    socket.shutdown(Shutdown::Write);
    let deadline = Instant::now() + LINGER;
    let mut buffer = [0; 4096];
    while Instant::now() < deadline {
        match socket.read(&mut buffer, LINGER) {
            Ok(Some([])) | Ok(None) | Err(_) => return,
            Ok(Some(_)) => {}
        }
    }
}
