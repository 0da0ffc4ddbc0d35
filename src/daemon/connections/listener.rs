//! Addresses where peers connect: Unix sockets and TCP ports.
//!
//! In: an [`Address`]. Out: connected sockets for the [`Registry`].
//!
//! Invariants: a Unix socket is never open to others than its owner, not even for a moment. The socket of a daemon that
//! is gone is replaced, that of a running one is not; of daemons that start at one path at once, one gets it. TCP is
//! open to this machine only, unless asked for.
//!
//! Must not know: the protocol.

use std::fs::{self, File, TryLockError};
use std::io;
use std::net::{IpAddr, TcpListener, TcpStream, ToSocketAddrs};
use std::os::unix::fs::{DirBuilderExt, FileTypeExt, MetadataExt, OpenOptionsExt, PermissionsExt};
use std::os::unix::net::{UnixListener, UnixStream};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

use thiserror::Error;

use super::registry::Registry;
use super::socket::Socket;
use crate::daemon::address::Address;
use crate::daemon::log_limits::LogLimits;

/// Why an address cannot be listened at.
#[derive(Debug, Error)]
pub enum ListenError {
    /// Another daemon listens there.
    #[error("another daemon is listening at {0}: stop it, or take another place")]
    InUse(Address),
    /// The path is a file that is no socket.
    #[error("{path} is there and no socket: move it away, or take another place", path = .0.display())]
    NotASocket(PathBuf),
    /// Other machines can reach it, and the settings do not allow that.
    #[error(
        "{0} can be reached from other machines, which may then feed and read all streams: add --allow-remote if you want that"
    )]
    Remote(Address),
    /// Other machines can reach the page, and the settings do not allow that.
    #[error(
        "{0} can be reached from other machines, which may then see all streams: add --allow-remote if you want that"
    )]
    RemotePage(Address),
    /// The system refuses.
    #[error("cannot listen at {address}: {error}")]
    System {
        /// Where.
        address: Address,
        /// Why.
        error: io::Error,
    },
}

enum Bound {
    Unix(UnixListener, PathBuf, (u64, u64)),
    Tcp(TcpListener),
}

/// An address that is listened at, by a thread of its own.
pub struct Listener {
    bound: Arc<Bound>,
    is_ending: Arc<AtomicBool>,
    thread: JoinHandle<()>,
}

impl Listener {
    /// Listens at an address, and hands each connection to the registry.
    ///
    /// # Errors
    /// [`ListenError`].
    pub fn start(address: &Address, allow_remote: bool, registry: Arc<Registry>) -> Result<Self, ListenError> {
        let system = |error| ListenError::System { address: address.clone(), error };
        let bound = Arc::new(match address {
            Address::Unix(path) => bind_unix(path, address)?,
            Address::Tcp(host) => Bound::Tcp(bind_tcp(host, address, allow_remote)?),
        });
        tracing::info!("listening at {}", bound.place());
        let is_ending = Arc::new(AtomicBool::new(false));
        let (accepting, ends) = (Arc::clone(&bound), Arc::clone(&is_ending));
        let thread = thread::Builder::new()
            .name("listener".to_owned())
            .spawn(move || accepting.accept_all(&ends, &registry))
            .map_err(system)?;
        Ok(Self { bound, is_ending, thread })
    }

    /// Listens no more.
    pub fn stop(self) {
        self.is_ending.store(true, Ordering::Release);
        // The thread is blocked in accept: a connection of our own wakes it.
        let has_come = match &*self.bound {
            // The socket of another daemon may be there by now.
            Bound::Unix(_, path, identity) => is_at(path, *identity) && UnixStream::connect(path).is_ok(),
            Bound::Tcp(listener) => listener.local_addr().is_ok_and(|at| {
                let loopback =
                    if at.is_ipv4() { IpAddr::from([127, 0, 0, 1]) } else { IpAddr::from([0, 0, 0, 0, 0, 0, 0, 1]) };
                let here = if at.ip().is_unspecified() { (loopback, at.port()).into() } else { at };
                TcpStream::connect_timeout(&here, Duration::from_secs(1)).is_ok()
            }),
        };
        // If the socket was moved away, nothing can wake the thread; it ends with the process.
        if has_come && self.thread.join().is_err() {
            tracing::error!("a listener's thread stopped by itself: please report this");
        }
        if let Bound::Unix(_, path, identity) = &*self.bound
            && is_at(path, *identity)
        {
            let _ = fs::remove_file(path);
        }
    }
}

impl Bound {
    fn place(&self) -> String {
        match self {
            Self::Unix(_, path, ..) => Address::Unix(path.clone()).to_string(),
            Self::Tcp(listener) => listener
                .local_addr()
                .map_or_else(|error| error.to_string(), |at| Address::Tcp(at.to_string()).to_string()),
        }
    }

    fn accept_all(&self, is_ending: &AtomicBool, registry: &Registry) {
        let place = self.place();
        let limits = LogLimits::default();
        loop {
            let accepted = self.accept();
            if is_ending.load(Ordering::Acquire) {
                return;
            }
            match accepted {
                Ok(socket) => registry.admit(socket, &place, registry.account()),
                Err(error) => {
                    if let Some(note) = limits.admits("accept", &place) {
                        tracing::warn!("{place}: cannot accept a connection: {error}{note}");
                    }
                    // Usually too many open files, which takes some time to pass.
                    thread::sleep(Duration::from_millis(100));
                }
            }
        }
    }

    fn accept(&self) -> io::Result<Socket> {
        match self {
            Self::Unix(listener, ..) => listener.accept().map(|(stream, _)| Socket::Unix(stream)),
            Self::Tcp(listener) => {
                let (stream, _) = listener.accept()?;
                // Frames are sent when they are due: waiting for more to send with them would only delay them.
                stream.set_nodelay(true)?;
                Ok(Socket::Tcp(stream))
            }
        }
    }
}

/// A locked file beside a socket's path, while a daemon looks at what is there and takes its place: of several that are
/// started at once, the others look when one is listening.
struct PathLock {
    path: PathBuf,
    /// Locked until it is closed, also by a daemon that is killed.
    _file: File,
}

impl PathLock {
    /// The lock of a path; none if another daemon has it for too long.
    fn take(of: &Path) -> io::Result<Option<Self>> {
        const PATIENCE: Duration = Duration::from_secs(5);
        let mut path = of.as_os_str().to_owned();
        path.push(".lock");
        let (path, deadline) = (PathBuf::from(path), Instant::now() + PATIENCE);
        while Instant::now() < deadline {
            let file = File::options().create(true).truncate(false).write(true).mode(0o600).open(&path)?;
            match file.try_lock() {
                // Whoever had it before may have removed the file between its opening and its locking.
                Ok(()) if is_at(&path, file.metadata().map(|data| (data.dev(), data.ino()))?) => {
                    return Ok(Some(Self { path, _file: file }));
                }
                Ok(()) => {}
                Err(TryLockError::WouldBlock) => thread::sleep(Duration::from_millis(2)),
                Err(TryLockError::Error(error)) => return Err(error),
            }
        }
        Ok(None)
    }
}

impl Drop for PathLock {
    /// Removes the file while it is locked: whoever waits for it finds out, and makes another.
    fn drop(&mut self) {
        let _ = fs::remove_file(&self.path);
    }
}

/// Binds within a folder that only this user can enter, and moves the socket to its path when its permissions are set.
fn bind_unix(path: &Path, address: &Address) -> Result<Bound, ListenError> {
    let system = |error| ListenError::System { address: address.clone(), error };
    let _lock = PathLock::take(path).map_err(system)?.ok_or_else(|| ListenError::InUse(address.clone()))?;
    match fs::symlink_metadata(path) {
        Ok(data) if !data.file_type().is_socket() => return Err(ListenError::NotASocket(path.to_owned())),
        Ok(_) if UnixStream::connect(path).is_ok() => return Err(ListenError::InUse(address.clone())),
        Ok(_) => tracing::debug!("{address}: replacing the socket of a daemon that is gone"),
        Err(_) => {}
    }
    let mut folder = path.as_os_str().to_owned();
    folder.push(format!(".{}", std::process::id()));
    let folder = PathBuf::from(folder);
    fs::DirBuilder::new().mode(0o700).create(&folder).map_err(system)?;
    let within = folder.join("s");
    let bound = UnixListener::bind(&within).and_then(|listener| {
        fs::set_permissions(&within, fs::Permissions::from_mode(0o600))?;
        let identity = identity_of(&within)?;
        fs::rename(&within, path)?;
        Ok(Bound::Unix(listener, path.to_owned(), identity))
    });
    let _ = fs::remove_file(&within);
    let _ = fs::remove_dir(&folder);
    bound.map_err(system)
}

/// Whether the socket at a path is ours, and not one that has replaced it.
fn is_at(path: &Path, identity: (u64, u64)) -> bool {
    identity_of(path).is_ok_and(|found| found == identity)
}

fn identity_of(path: &Path) -> io::Result<(u64, u64)> {
    fs::symlink_metadata(path).map(|data| (data.dev(), data.ino()))
}

/// Binds a port: of this machine only, unless other machines are allowed.
///
/// # Errors
/// [`ListenError`].
pub fn bind_tcp(host: &str, address: &Address, allow_remote: bool) -> Result<TcpListener, ListenError> {
    let system = |error| ListenError::System { address: address.clone(), error };
    let places: Vec<_> = host.to_socket_addrs().map_err(system)?.collect();
    if !allow_remote && !places.iter().all(|place| place.ip().is_loopback()) {
        return Err(ListenError::Remote(address.clone()));
    }
    match TcpListener::bind(&places[..]) {
        Ok(listener) => Ok(listener),
        Err(error) if error.kind() == io::ErrorKind::AddrInUse => Err(ListenError::InUse(address.clone())),
        Err(error) => Err(system(error)),
    }
}
