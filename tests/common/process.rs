//! The program as a process: started, fed, listened to, sent signals, and never waited for without a deadline.
//!
//! `hopes("compute - --full").reads("0,0\n1,1\n")` runs it from beginning to end; `hopes("serve").start()` is a dialogue.

use std::ffi::{OsStr, OsString};
use std::io::{BufRead, BufReader, Read, Write};
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::thread;
use std::time::{Duration, Instant};

use rustix::process::{Pid, Signal, kill_process};

/// How long anything may take before a test gives up, on a slow and busy machine.
const PATIENCE: Duration = Duration::from_secs(100);

/// The program with its arguments, not started yet.
#[derive(Clone)]
pub struct Hopes(Vec<OsString>);

/// The program with arguments, separated by blanks.
pub fn hopes(arguments: &str) -> Hopes {
    Hopes(arguments.split_whitespace().map(OsString::from).collect())
}

impl Hopes {
    /// More arguments, separated by blanks.
    pub fn and(&self, arguments: &str) -> Self {
        let mut more = self.clone();
        more.0.extend(hopes(arguments).0);
        more
    }

    /// One argument more, such as a path with blanks.
    pub fn with(&self, argument: impl AsRef<OsStr>) -> Self {
        let mut more = self.clone();
        more.0.push(argument.as_ref().to_owned());
        more
    }

    /// Runs on an input to the end.
    pub fn reads(&self, input: impl AsRef<[u8]>) -> Finished {
        let mut running = self.start();
        let (mut stdin, input) = (running.take_stdin(), input.as_ref().to_owned());
        // That nobody wants all of the input is no failure.
        let feeder = thread::spawn(move || drop(stdin.write_all(&input)));
        let finished = running.finish();
        feeder.join().unwrap();
        finished
    }

    /// Runs on an empty input to the end.
    pub fn runs(&self) -> Finished {
        self.reads("")
    }

    /// As a command with other ends than pipes.
    pub fn command(&self) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_hopes"));
        command.args(&self.0).stdin(Stdio::null());
        command
    }

    /// Starts a dialogue.
    pub fn start(&self) -> Running {
        let mut command = self.command();
        command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped());
        let mut child = command.spawn().unwrap_or_else(|error| panic!("{:?} does not start: {error}", self.0));
        let log = lines_of(child.stderr.take().unwrap());
        Running {
            stdin: child.stdin.take(),
            stdout: child.stdout.take(),
            child,
            lines: None,
            log,
            logged: String::new(),
        }
    }
}

/// What a process has left behind.
#[derive(Debug, PartialEq)]
pub struct Finished {
    /// The exit code; none if a signal has killed it.
    pub code: Option<i32>,
    pub out: Vec<u8>,
    pub err: String,
}

impl Finished {
    /// It has done its work. What it wrote.
    pub fn out(self) -> Vec<u8> {
        assert_eq!(self.code, Some(0), "{}", self.err);
        self.out
    }

    pub fn text(self) -> String {
        String::from_utf8(self.out()).expect("the output is text")
    }

    /// It has failed with that code, said why in all of these words, and written nothing.
    pub fn fails(self, code: i32, words: &[&str]) {
        assert_eq!(self.code, Some(code), "{}", self.err);
        assert!(self.out.is_empty(), "stdout has {:?}", String::from_utf8_lossy(&self.out));
        for word in words {
            assert!(self.err.contains(word), "{word:?} is missing in {:?}", self.err);
        }
        assert!(!self.err.contains("panicked"), "{}", self.err);
    }
}

/// A process at work. It is killed when the test lets go of it.
pub struct Running {
    child: Child,
    stdin: Option<ChildStdin>,
    /// Until somebody listens.
    stdout: Option<ChildStdout>,
    lines: Option<Receiver<Vec<u8>>>,
    log: Receiver<Vec<u8>>,
    logged: String,
}

impl Running {
    /// Feeds it.
    pub fn say(&mut self, input: impl AsRef<[u8]>) {
        self.stdin.as_mut().expect("stdin is open").write_all(input.as_ref()).expect("the program listens");
    }

    /// Its stdin, for a thread of its own.
    pub fn take_stdin(&mut self) -> ChildStdin {
        self.stdin.take().expect("stdin is open")
    }

    /// Its stdout, for those who do not want all of it.
    pub fn take_stdout(&mut self) -> ChildStdout {
        self.stdout.take().expect("nobody listens yet")
    }

    /// The next line of its output; none at the end. From the first call on somebody listens.
    pub fn line(&mut self) -> Option<String> {
        self.raw_line().map(|line| {
            let line = String::from_utf8(line).expect("the output is text");
            line.strip_suffix('\n').expect("a line has an end").to_owned()
        })
    }

    fn raw_line(&mut self) -> Option<Vec<u8>> {
        let lines = self.lines.get_or_insert_with(|| lines_of(self.stdout.take().expect("stdout is ours")));
        match lines.recv_timeout(PATIENCE) {
            Ok(line) => Some(line),
            Err(RecvTimeoutError::Disconnected) => None,
            Err(RecvTimeoutError::Timeout) => panic!("no output within {PATIENCE:?}; the log is {:?}", self.logged),
        }
    }

    /// Waits until it logs a line with that in it. The line.
    pub fn until_log(&mut self, words: &str) -> String {
        loop {
            let line = self.log.recv_timeout(PATIENCE);
            let line = line.unwrap_or_else(|_| panic!("{words:?} never came in the log, only {:?}", self.logged));
            let line = String::from_utf8_lossy(&line);
            self.logged.push_str(&line);
            if line.contains(words) {
                return line.into_owned();
            }
        }
    }

    pub fn signal(&self, signal: Signal) {
        kill_process(Pid::from_child(&self.child), signal).expect("the process is there");
    }

    pub fn is_alive(&mut self) -> bool {
        self.child.try_wait().unwrap().is_none()
    }

    /// Closes its stdin, takes what it still has to say, and waits for its end.
    pub fn finish(mut self) -> Finished {
        self.stdin = None;
        let mut out = Vec::new();
        if self.lines.is_some() || self.stdout.is_some() {
            while let Some(mut line) = self.raw_line() {
                out.append(&mut line);
            }
        }
        self.end(out)
    }

    /// Waits for its end, with stdin open (if it was) and with nobody to listen (if nobody did).
    pub fn ends(self) -> Finished {
        self.end(Vec::new())
    }

    fn end(mut self, out: Vec<u8>) -> Finished {
        let child = &mut self.child;
        let status = eventually("the program ends", || child.try_wait().unwrap());
        while let Ok(line) = self.log.recv_timeout(PATIENCE) {
            self.logged.push_str(&String::from_utf8_lossy(&line));
        }
        Finished { code: status.code(), out, err: std::mem::take(&mut self.logged) }
    }
}

/// What the system says of a process.
#[cfg(target_os = "linux")]
impl Running {
    /// The most memory that it has ever had resident, in bytes.
    pub fn peak_memory(&self) -> u64 {
        self.peak_if_alive().expect("it is alive")
    }

    /// As that, of one that may have ended: then nothing is known.
    pub fn peak_if_alive(&self) -> Option<u64> {
        let status = std::fs::read_to_string(format!("/proc/{}/status", self.child.id())).ok()?;
        let peak = field(&status, "VmHWM").strip_suffix("kB")?.trim();
        Some(peak.parse::<u64>().ok()? * 1024)
    }

    /// The time that it has spent on processors, in clock ticks.
    pub fn ticks(&self) -> u64 {
        let stat = std::fs::read_to_string(format!("/proc/{}/stat", self.child.id())).unwrap();
        // The name, in brackets, may have anything in it.
        let (_, fields) = stat.rsplit_once(')').expect("the name ends");
        fields.split_whitespace().skip(11).take(2).map(|ticks| ticks.parse::<u64>().unwrap()).sum()
    }

    /// Waits until it has read all that was said to it.
    pub fn until_read(&self) {
        let stdin = self.stdin.as_ref().expect("stdin is open");
        eventually("all input is read", || (rustix::io::ioctl_fionread(stdin).unwrap() == 0).then_some(()));
    }

    /// How many bytes of its output wait for a reader.
    pub fn unread(&self) -> u64 {
        rustix::io::ioctl_fionread(self.stdout.as_ref().expect("nobody listens yet")).unwrap()
    }

    /// Waits until a signal is neither pending nor being handled in any thread.
    pub fn until_handled(&self, signal: Signal) {
        let bit = 1u64 << (signal.as_raw() - 1);
        let tasks = format!("/proc/{}/task", self.child.id());
        let busy = || {
            std::fs::read_dir(&tasks).unwrap().any(|task| {
                // A thread may end while we look.
                let status = std::fs::read_to_string(task.unwrap().path().join("status")).unwrap_or_default();
                let mask = |name| u64::from_str_radix(field(&status, name), 16).unwrap_or(0);
                ["SigPnd", "ShdPnd", "SigBlk"].into_iter().any(|name| mask(name) & bit != 0)
            })
        };
        eventually("the signal is handled", || (!busy() && !busy()).then_some(()));
    }
}

#[cfg(target_os = "linux")]
fn field<'a>(status: &'a str, name: &str) -> &'a str {
    let line = status.lines().find_map(|line| line.strip_prefix(name)?.strip_prefix(':'));
    line.unwrap_or_default().trim()
}

impl Drop for Running {
    fn drop(&mut self) {
        drop(self.child.kill());
        drop(self.child.wait());
    }
}

/// Waits until there is an answer.
pub fn eventually<T>(what: &str, mut answer: impl FnMut() -> Option<T>) -> T {
    let deadline = Instant::now() + PATIENCE;
    loop {
        if let Some(answer) = answer() {
            return answer;
        }
        assert!(Instant::now() < deadline, "within {PATIENCE:?} it never came that {what}");
        thread::sleep(Duration::from_millis(2));
    }
}

/// Waits until there is a value that stays the same for that long.
pub fn settled<T: PartialEq>(quiet: Duration, mut value: impl FnMut() -> Option<T>) -> T {
    let (mut last, mut since) = (value(), Instant::now());
    eventually("things settle", || {
        let now = value();
        if now != last {
            (last, since) = (now, Instant::now());
        }
        if since.elapsed() >= quiet { last.take() } else { None }
    })
}

/// Reads lines, ends included, as they come.
fn lines_of(source: impl Read + Send + 'static) -> Receiver<Vec<u8>> {
    let (sender, receiver) = channel();
    thread::spawn(move || {
        let mut source = BufReader::new(source);
        loop {
            let mut line = Vec::new();
            match source.read_until(b'\n', &mut line) {
                Ok(1..) if sender.send(line).is_ok() => {}
                _ => return,
            }
        }
    });
    receiver
}
