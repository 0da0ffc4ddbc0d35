//! A daemon process for one measurement.
//!
//! In: the program. Out: its socket, its memory. Invariants: the process is killed when this is dropped.

use std::path::{Path, PathBuf};
use std::process::{Child, ChildStderr, Command, Stdio};
use std::time::{Duration, Instant};

use anyhow::Context;

/// A running daemon.
pub struct Daemon {
    child: Child,
    /// The path of its socket.
    pub socket: PathBuf,
    _folder: tempfile::TempDir,
}

impl Daemon {
    /// Starts a daemon, and waits until it listens.
    pub fn start(hopes: &Path, arguments: &[&str]) -> anyhow::Result<Self> {
        Self::start_with(hopes, &[&["--quiet"], arguments].concat(), Stdio::inherit())
    }

    /// Starts a daemon that logs the time of each frame. Also returns its log.
    pub fn start_traced(hopes: &Path) -> anyhow::Result<(Self, ChildStderr)> {
        let mut daemon = Self::start_with(hopes, &["-vv"], Stdio::piped())?;
        let log = daemon.child.stderr.take().context("the daemon has no log")?;
        Ok((daemon, log))
    }

    fn start_with(hopes: &Path, arguments: &[&str], log: Stdio) -> anyhow::Result<Self> {
        let folder = tempfile::tempdir()?;
        let socket = folder.path().join("hopes.sock");
        let child = Command::new(hopes)
            .args(["serve", "--listen"])
            .arg(format!("unix:{}", socket.display()))
            .args(arguments)
            .stderr(log)
            .spawn()
            .with_context(|| format!("cannot start {}", hopes.display()))?;
        let deadline = Instant::now() + Duration::from_secs(10);
        while !socket.exists() {
            anyhow::ensure!(Instant::now() < deadline, "the daemon does not listen");
            std::thread::sleep(Duration::from_millis(5));
        }
        Ok(Self { child, socket, _folder: folder })
    }

    /// The memory now and its peak, in MiB.
    pub fn memory(&self) -> (u64, u64) {
        let status = std::fs::read_to_string(format!("/proc/{}/status", self.child.id())).unwrap_or_default();
        let field = |name: &str| {
            let line = status.lines().find_map(|line| line.strip_prefix(name));
            line.and_then(|line| line.trim().trim_end_matches(" kB").parse::<u64>().ok()).unwrap_or(0) / 1024
        };
        (field("VmRSS:"), field("VmHWM:"))
    }

    /// Sends SIGTERM. Returns whether the daemon ended cleanly.
    pub fn stop(mut self) -> anyhow::Result<bool> {
        signal(self.child.id(), rustix::process::Signal::TERM);
        let deadline = Instant::now() + Duration::from_secs(15);
        while Instant::now() < deadline {
            if let Some(status) = self.child.try_wait()? {
                return Ok(status.success());
            }
            std::thread::sleep(Duration::from_millis(5));
        }
        Ok(false)
    }
}

impl Drop for Daemon {
    fn drop(&mut self) {
        // It may have ended already.
        drop(self.child.kill());
        drop(self.child.wait());
    }
}

/// Sends a signal to a child process.
pub fn signal(process: u32, signal: rustix::process::Signal) {
    if let Some(process) = rustix::process::Pid::from_raw(process as i32) {
        let _ = rustix::process::kill_process(process, signal);
    }
}
