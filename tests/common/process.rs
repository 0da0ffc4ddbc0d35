//! The program as a process: tests start it, write to it, read from it and send it signals. Every wait has a deadline.
//!
//! `hopes("compute - --full").reads("0,0\n1,1\n")` runs it to its end. `hopes("serve").start()` starts it for a
//! dialogue.

use std::ffi::{OsStr, OsString};
use std::io::{BufRead, BufReader, Read, Write};
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::thread;
use std::time::{Duration, Instant};

use rustix::process::{Pid, Signal, kill_process};

/// The longest wait before a test fails, on a slow and busy machine.
const TIMEOUT: Duration = Duration::from_secs(100);

/// The program with its arguments, before it is started.
#[derive(Clone, Debug)]
pub struct Hopes(Vec<OsString>, Vec<(OsString, OsString)>);

/// The program with arguments, separated by spaces.
pub fn hopes(arguments: &str) -> Hopes {
    Hopes(arguments.split_whitespace().map(OsString::from).collect(), Vec::new())
}

impl Hopes {
    /// Appends arguments, separated by spaces.
    pub fn and(&self, arguments: &str) -> Self {
        let mut more = self.clone();
        more.0.extend(hopes(arguments).0);
        more
    }

    /// Appends one argument, such as a path with spaces.
    pub fn with(&self, argument: impl AsRef<OsStr>) -> Self {
        let mut more = self.clone();
        more.0.push(argument.as_ref().to_owned());
        more
    }

    /// Sets a variable of its environment.
    pub fn set(&self, name: &str, value: impl AsRef<OsStr>) -> Self {
        let mut more = self.clone();
        more.1.push((name.into(), value.as_ref().to_owned()));
        more
    }

    /// Runs to its end on an input.
    pub fn reads(&self, input: impl AsRef<[u8]>) -> Finished {
        let mut running = self.start();
        let (mut stdin, input) = (running.take_stdin(), input.as_ref().to_owned());
        // The process may end before it has read all of the input.
        let feeder = thread::spawn(move || drop(stdin.write_all(&input)));
        let finished = running.finish();
        feeder.join().unwrap();
        finished
    }

    /// Runs to its end on an empty input.
    pub fn runs(&self) -> Finished {
        self.reads("")
    }

    /// The command, for tests that need other things than pipes.
    pub fn command(&self) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_hopes"));
        command.args(&self.0).envs(self.1.iter().cloned()).stdin(Stdio::null());
        command
    }

    /// Starts the process for a dialogue.
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

/// The result of a process.
#[derive(Debug, PartialEq)]
pub struct Finished {
    /// The exit code. None if a signal ended it.
    pub code: Option<i32>,
    pub out: Vec<u8>,
    pub err: String,
}

impl Finished {
    /// Expects success. Returns stdout.
    pub fn out(self) -> Vec<u8> {
        assert_eq!(self.code, Some(0), "{}", self.err);
        self.out
    }

    pub fn text(self) -> String {
        String::from_utf8(self.out()).expect("the output is text")
    }

    /// Expects this exit code, an empty stdout, and all of these words on stderr.
    pub fn fails(self, code: i32, words: &[&str]) {
        assert_eq!(self.code, Some(code), "{}", self.err);
        assert!(self.out.is_empty(), "stdout has {:?}", String::from_utf8_lossy(&self.out));
        for word in words {
            assert!(self.err.contains(word), "{word:?} is missing in {:?}", self.err);
        }
        assert!(!self.err.contains("panicked"), "{}", self.err);
    }
}

/// A running process. It is killed when this is dropped.
pub struct Running {
    child: Child,
    stdin: Option<ChildStdin>,
    /// None once a thread reads it.
    stdout: Option<ChildStdout>,
    lines: Option<Receiver<Vec<u8>>>,
    log: Receiver<Vec<u8>>,
    logged: String,
}

impl Running {
    /// Writes to its stdin.
    pub fn say(&mut self, input: impl AsRef<[u8]>) {
        self.stdin.as_mut().expect("stdin is open").write_all(input.as_ref()).expect("the program listens");
    }

    /// Its stdin, for another thread.
    pub fn take_stdin(&mut self) -> ChildStdin {
        self.stdin.take().expect("stdin is open")
    }

    /// Its stdout, for tests that do not read all of it.
    pub fn take_stdout(&mut self) -> ChildStdout {
        self.stdout.take().expect("nobody listens yet")
    }

    /// The next line of its output. None at the end. The first call starts a thread that reads the output.
    pub fn line(&mut self) -> Option<String> {
        self.raw_line().map(|line| {
            let line = String::from_utf8(line).expect("the output is text");
            line.strip_suffix('\n').expect("a line has an end").to_owned()
        })
    }

    fn raw_line(&mut self) -> Option<Vec<u8>> {
        let lines = self.lines.get_or_insert_with(|| lines_of(self.stdout.take().expect("stdout is ours")));
        match lines.recv_timeout(TIMEOUT) {
            Ok(line) => Some(line),
            Err(RecvTimeoutError::Disconnected) => None,
            Err(RecvTimeoutError::Timeout) => panic!("no output within {TIMEOUT:?}; the log is {:?}", self.logged),
        }
    }

    /// Waits for a line of the log that contains `words`. Returns the line.
    pub fn until_log(&mut self, words: &str) -> String {
        loop {
            let line = self.log.recv_timeout(TIMEOUT);
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

    /// Closes its stdin, reads the rest of its output, and waits for its end.
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

    /// Waits for its end. An open stdin stays open, and an unread stdout stays unread.
    pub fn ends(self) -> Finished {
        self.end(Vec::new())
    }

    fn end(mut self, out: Vec<u8>) -> Finished {
        let child = &mut self.child;
        let status = eventually("the program ends", || child.try_wait().unwrap());
        while let Ok(line) = self.log.recv_timeout(TIMEOUT) {
            self.logged.push_str(&String::from_utf8_lossy(&line));
        }
        Finished { code: status.code(), out, err: std::mem::take(&mut self.logged) }
    }
}

/// What the operating system says about the process.
#[cfg(target_os = "linux")]
impl Running {
    /// The peak of its resident memory in bytes.
    pub fn peak_memory(&self) -> u64 {
        self.peak_if_alive().expect("it is alive")
    }

    /// The same for a process that may have ended. None in that case.
    pub fn peak_if_alive(&self) -> Option<u64> {
        let status = std::fs::read_to_string(format!("/proc/{}/status", self.child.id())).ok()?;
        let peak = field(&status, "VmHWM").strip_suffix("kB")?.trim();
        Some(peak.parse::<u64>().ok()? * 1024)
    }

    /// Its resident memory in bytes, without that of files.
    pub fn own_memory(&self) -> u64 {
        let status = std::fs::read_to_string(format!("/proc/{}/status", self.child.id())).unwrap();
        let own = field(&status, "RssAnon").strip_suffix("kB").unwrap().trim();
        own.parse::<u64>().unwrap() * 1024
    }

    /// The processor time it has used, in clock ticks.
    pub fn ticks(&self) -> u64 {
        let stat = std::fs::read_to_string(format!("/proc/{}/stat", self.child.id())).unwrap();
        // The name is in brackets and may contain anything.
        let (_, fields) = stat.rsplit_once(')').expect("the name ends");
        fields.split_whitespace().skip(11).take(2).map(|ticks| ticks.parse::<u64>().unwrap()).sum()
    }

    /// The number of bytes that it has written, to whatever.
    pub fn written(&self) -> u64 {
        let io = std::fs::read_to_string(format!("/proc/{}/io", self.child.id())).unwrap();
        field(&io, "wchar").parse().unwrap()
    }

    /// Waits until it has read all of its input.
    pub fn until_read(&self) {
        let stdin = self.stdin.as_ref().expect("stdin is open");
        eventually("all input is read", || (rustix::io::ioctl_fionread(stdin).unwrap() == 0).then_some(()));
    }

    /// The number of bytes of its output that are not read.
    pub fn unread(&self) -> u64 {
        rustix::io::ioctl_fionread(self.stdout.as_ref().expect("nobody listens yet")).unwrap()
    }

    /// Waits until a signal is neither pending nor being handled in any thread.
    pub fn until_handled(&self, signal: Signal) {
        let bit = 1u64 << (signal.as_raw() - 1);
        let tasks = format!("/proc/{}/task", self.child.id());
        let busy = || {
            std::fs::read_dir(&tasks).unwrap().any(|task| {
                // A thread may end meanwhile.
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

/// Waits until `answer` returns a value.
pub fn eventually<T>(what: &str, mut answer: impl FnMut() -> Option<T>) -> T {
    let deadline = Instant::now() + TIMEOUT;
    loop {
        if let Some(answer) = answer() {
            return answer;
        }
        assert!(Instant::now() < deadline, "within {TIMEOUT:?} it never came that {what}");
        thread::sleep(Duration::from_millis(2));
    }
}

/// Waits until a value has not changed for the time `quiet`.
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

/// Sends lines, with their ends, as they are read.
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
