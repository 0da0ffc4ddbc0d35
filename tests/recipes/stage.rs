//! A folder in which a command of the README finds what it needs, and the command at work in it.
//!
//! In: commands for bash, as the README has them. Out: what they print, how they end.
//!
//! `hopes` is the built program behind a small script, which notes its process and its exit code. Programs and files
//! that a test machine does not have are stand-ins. What is fixed in the README and shared by the machine is replaced:
//! the port 127.0.0.1:8080 by a free one, /tmp/hopes.sock by a socket in the folder.
//!
//! Invariants: nothing is awaited without a deadline; no process outlives its job. Must not know: what commands are
//! for.

use std::fmt::Write as _;
use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::os::unix::fs::{PermissionsExt, symlink};
use std::os::unix::process::CommandExt;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::mpsc::{Receiver, channel};
use std::thread;
use std::time::Duration;

use rustix::process::{Pid, Signal, kill_process, kill_process_group};
use serde_json::Value;
use tempfile::TempDir;

use crate::common::process::eventually;

/// How long a line may take, on a slow and busy machine.
const PATIENCE: Duration = Duration::from_secs(100);

/// Runs the program, and notes its process and its exit code.
const HOPES: &str = r#"#!/usr/bin/env bash
"$HOPES_BIN" "$@" <&0 &
echo $! > "$HOPES_NOTES/$1.new" && mv "$HOPES_NOTES/$1.new" "$HOPES_NOTES/$1.pid"
wait $!
code=$?
echo $code > "$HOPES_NOTES/$1.new" && mv "$HOPES_NOTES/$1.new" "$HOPES_NOTES/$1.code"
exit $code
"#;

/// Gives three frames of video, if it is asked for such.
const FFMPEG: &str = r#"#!/usr/bin/env bash
case " $* " in
    *" -i /dev/video0 "*|*" -i film.mp4 "*) ;;
    *) echo "ffmpeg: no such input: $*" >&2; exit 1 ;;
esac
case "$*" in
    # Most cameras give YUYV, which YUV4MPEG2 cannot hold.
    *" -i /dev/video0 -f "*) echo "ffmpeg: yuv4mpeg can only handle planar and gray pixels" >&2; exit 1 ;;
    *" -f yuv4mpegpipe -") cat video.y4m ;;
    *) echo "ffmpeg: no such output: $*" >&2; exit 1 ;;
esac
"#;

/// A scanner: two seconds of places along a line.
const LIDAR: &str = r#"#!/usr/bin/env bash
echo "x,y,stamp"
for i in {0..200}; do printf '0.%03d,1.5,%d.%02d\n' $((i * 4)) $((i / 100)) $((i % 100)); done
"#;

/// A log of places: a square about an hour before what comes next.
const PLACES: &str = "lon,lat,unix\n8.0,47.0,97\n8.1,47.0,98\n8.1,47.1,99\n8.0,47.1,100\n";

/// Pictures of a folder: two that have a hole in common.
const PICTURES: [(&str, &str); 2] = [("tests/data/edges/coins.png", "1.png"), ("tests/data/edges/coins.png", "2.png")];

/// The folder.
pub struct Stage(TempDir);

impl Stage {
    pub fn new() -> Self {
        let stage = Self(tempfile::tempdir().unwrap());
        for folder in ["bin", "notes", "frames"] {
            std::fs::create_dir(stage.path(folder)).unwrap();
        }
        for (name, script) in [("hopes", HOPES), ("ffmpeg", FFMPEG), ("lidar", LIDAR)] {
            stage.install(name, script);
        }
        match find("jq") {
            // Into a pipe it would keep its output until it has much of it.
            Some(jq) => stage.install("jq", &format!("#!/bin/sh\nexec '{}' --unbuffered \"$@\"\n", jq.display())),
            None => stage.install("jq", JQ),
        }
        std::fs::write(stage.path("places.csv"), PLACES).unwrap();
        std::fs::write(stage.path("video.y4m"), video()).unwrap();
        for (from, to) in PICTURES {
            std::fs::copy(from, stage.path("frames").join(to)).unwrap();
        }
        // What is part of the project is found as it is from its root.
        symlink(root().join("tests"), stage.path("tests")).unwrap();
        stage
    }

    fn install(&self, name: &str, script: &str) {
        let path = self.path("bin").join(name);
        std::fs::write(&path, script).unwrap();
        std::fs::set_permissions(&path, PermissionsExt::from_mode(0o755)).unwrap();
    }

    /// A file of the folder.
    pub fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    /// Starts commands.
    pub fn start(&self, commands: &str) -> Job {
        let socket = format!("unix:{}", self.path("hopes.sock").display());
        let commands = commands.replace("127.0.0.1:8080", "127.0.0.1:0").replace("unix:/tmp/hopes.sock", &socket);
        self.spawn(Command::new("bash").arg("-c").arg(&commands), commands.clone())
    }

    /// Starts a script, with lines before it.
    pub fn python(&self, before: &str, script: &str) -> Job {
        let socket = format!("unix:{}", self.path("hopes.sock").display());
        let script = format!("{before}\n{script}").replace("unix:/tmp/hopes.sock", &socket);
        let mut command = Command::new("python3");
        command.args(["-u", "-B", "-c", &script]).env("PYTHONPATH", root().join("protocol/python"));
        self.spawn(&mut command, script)
    }

    fn spawn(&self, command: &mut Command, text: String) -> Job {
        let path = std::env::var_os("PATH").unwrap_or_default();
        let paths = [self.path("bin")].into_iter().chain(std::env::split_paths(&path));
        command
            .current_dir(self.0.path())
            .env("PATH", std::env::join_paths(paths).unwrap())
            .env("HOPES_ADDRESS", format!("unix:{}", self.path("hopes.sock").display()))
            .env("HOPES_BIN", env!("CARGO_BIN_EXE_hopes"))
            .env("HOPES_NOTES", self.path("notes"))
            .stdin(Stdio::null())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            // A job is ended as a whole.
            .process_group(0);
        let mut child = command.spawn().unwrap_or_else(|error| panic!("{text:?} does not start: {error}"));
        let out = lines_of(child.stdout.take().unwrap());
        let log = lines_of(child.stderr.take().unwrap());
        Job { child, text, notes: self.path("notes"), out, log, logged: String::new() }
    }
}

/// Commands at work. They are killed when the test drops them.
pub struct Job {
    child: Child,
    text: String,
    notes: PathBuf,
    out: Receiver<String>,
    log: Receiver<String>,
    logged: String,
}

impl Job {
    /// The next line of output.
    pub fn line(&mut self) -> String {
        let line = self.out.recv_timeout(PATIENCE);
        line.unwrap_or_else(|error| self.fail(&format!("no further line of output: {error}")))
    }

    /// The next line of output that is wanted.
    pub fn lines_until(&mut self, wanted: impl Fn(&str) -> bool) -> String {
        loop {
            let line = self.line();
            if wanted(&line) {
                return line;
            }
        }
    }

    /// The next line of the log with these words.
    pub fn until_log(&mut self, words: &str) -> String {
        loop {
            let line = self.log.recv_timeout(PATIENCE);
            let line = line.unwrap_or_else(|error| self.fail(&format!("{words:?} is not logged: {error}")));
            self.logged.push_str(&line);
            if line.contains(words) {
                return line;
            }
        }
    }

    /// The port of the page that was started.
    pub fn page_port(&mut self) -> u16 {
        let line = self.until_log("http://127.0.0.1:");
        let (_, rest) = line.split_once("http://127.0.0.1:").unwrap();
        let digits: String = rest.chars().take_while(char::is_ascii_digit).collect();
        digits.parse().unwrap()
    }

    /// Ends `hopes COMMAND` as a user does, by a signal. It must not have ended before.
    pub fn end_well(&mut self, command: &str) {
        let pid = self.note(command, "pid").parse().unwrap();
        kill_process(Pid::from_raw(pid).unwrap(), Signal::TERM).unwrap_or_else(|error| self.fail(&error.to_string()));
        let code = self.note(command, "code");
        assert_eq!(code, "0", "hopes {command} of {:?}", self.text);
    }

    fn note(&self, command: &str, kind: &str) -> String {
        let path = self.notes.join(format!("{command}.{kind}"));
        let note = || std::fs::read_to_string(&path).ok().map(|note| note.trim().to_owned());
        eventually(&format!("hopes {command} has its {kind}"), note)
    }

    /// Waits for the end: all must have succeeded. The rest of the output.
    pub fn finish(mut self) -> String {
        let status = eventually("the commands end", || self.child.try_wait().unwrap());
        let mut rest = String::new();
        while let Ok(line) = self.out.recv_timeout(PATIENCE) {
            writeln!(rest, "{line}").unwrap();
        }
        if !status.success() {
            self.fail(&format!("{status}, after {rest:?}"));
        }
        for note in std::fs::read_dir(&self.notes).unwrap().map(|note| note.unwrap().path()) {
            if note.extension().is_some_and(|kind| kind == "code") {
                let code = std::fs::read_to_string(&note).unwrap();
                assert_eq!(code.trim(), "0", "{} of {:?}", note.display(), self.text);
            }
        }
        rest
    }

    fn fail(&mut self, what: &str) -> ! {
        while let Ok(line) = self.log.recv_timeout(Duration::from_millis(100)) {
            self.logged.push_str(&line);
        }
        panic!("{what}\nin {}\nthe log is {:?}", self.text, self.logged)
    }
}

impl Drop for Job {
    fn drop(&mut self) {
        let group = Pid::from_child(&self.child);
        // There may be none left.
        let _ = kill_process_group(group, Signal::KILL);
        let _ = self.child.wait();
    }
}

fn lines_of(source: impl Read + Send + 'static) -> Receiver<String> {
    let (sender, receiver) = channel();
    thread::spawn(move || {
        for line in BufReader::new(source).lines().map_while(Result::ok) {
            if sender.send(line).is_err() {
                return;
            }
        }
    });
    receiver
}

// ---- what the tests look at

/// The status of the only stream of a page, once it is as wanted.
pub fn stream_on_page(port: u16, wanted: impl Fn(&Value) -> bool) -> Value {
    eventually("the stream on the page is as wanted", || {
        let status: Value = serde_json::from_str(&get(port, "/api/streams")?).ok()?;
        let stream = status["streams"].get(0)?;
        wanted(stream).then(|| stream.clone())
    })
}

fn get(port: u16, path: &str) -> Option<String> {
    let mut page = TcpStream::connect(("127.0.0.1", port)).ok()?;
    write!(page, "GET {path} HTTP/1.1\r\nHost: 127.0.0.1:{port}\r\n\r\n").ok()?;
    let mut answer = String::new();
    page.read_to_string(&mut answer).ok()?;
    answer.split_once("\r\n\r\n").map(|(_, body)| body.to_owned())
}

/// Adds to a file.
pub fn append(path: &Path, text: &str) {
    let mut file = std::fs::OpenOptions::new().append(true).open(path).unwrap();
    file.write_all(text.as_bytes()).unwrap();
}

/// Where the machine has a program.
pub fn find(program: &str) -> Option<PathBuf> {
    let path = std::env::var_os("PATH").unwrap_or_default();
    std::env::split_paths(&path).map(|folder| folder.join(program)).find(|path| path.is_file())
}

// ---- what commands find

/// The only thing that a recipe asks of `jq`.
const JQ: &str = r#"#!/usr/bin/env python3
import json, sys
assert sys.argv[1:] == ["-c", "[.time, .points, .view.cycles]"], "a stand-in: only for the README's recipe"
for line in sys.stdin:
    frame = json.loads(line)
    print(json.dumps([frame["time"], frame["points"], frame["view"]["cycles"]]), flush=True)
"#;

/// Three frames of gray video: a frame of a film, three times.
fn video() -> Vec<u8> {
    let file = std::fs::File::open(root().join("tests/data/edges/bunny-gray.png")).unwrap();
    let mut reader = png::Decoder::new(BufReader::new(file)).read_info().unwrap();
    let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
    let frame = reader.next_frame(&mut pixels).unwrap();
    let mut video = format!("YUV4MPEG2 W{} H{} F25:1 Cmono\n", frame.width, frame.height).into_bytes();
    for _ in 0..3 {
        video.extend(b"FRAME\n");
        video.extend(&pixels[..frame.buffer_size()]);
    }
    video
}

/// The project's folder.
fn root() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR"))
}
