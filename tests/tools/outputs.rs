//! Where output goes: files that are replaced as a whole or not at all, and a stdout that is closed, full, read-only or
//! not wanted.

use std::fs::{self, File};
use std::io::Read;
use std::os::unix::fs::{MetadataExt, PermissionsExt, symlink};
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};

use hopes_protocol::*;
use rustix::process::Signal;
use tempfile::TempDir;

use crate::common::fake_daemon::FakeDaemon;
use crate::common::growing_stream::{GrowingStream, recording};
use crate::common::process::{Hopes, eventually, hopes};
use crate::replay::{at_once, messages};

const SQUARE: &str = "0,0\n1,0\n1,1\n0,1\n";

/// Inputs, in a folder of their own.
struct Inputs(TempDir);

impl Inputs {
    fn new() -> Self {
        let folder = tempfile::tempdir().unwrap();
        fs::write(folder.path().join("points.csv"), SQUARE).unwrap();
        let tracked = hopes("serve --track view").reads(SQUARE).out();
        fs::write(folder.path().join("tracked.jsonl"), tracked).unwrap();
        fs::write(folder.path().join("whole.hopes"), recording(&at_once(&messages()))).unwrap();
        Self(folder)
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    /// Every command that writes to stdout and needs no daemon, with an input that it ends on.
    fn commands(&self) -> Vec<Hopes> {
        let on = |words: &str, name: &str| hopes(words).with(self.path(name));
        let picture = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/edges/horse.png");
        vec![
            on("compute", "points.csv"),
            on("compute --format svg -o -", "points.csv"),
            hopes("serve"),
            hopes("serve --output bin"),
            on("replay --fast", "whole.hopes"),
            on("replay --fast --output bin", "whole.hopes"),
            on("tracks", "tracked.jsonl"),
            hopes("scene --list"),
            hopes("scene pinch --frames 2"),
            hopes("edges").with(&picture),
            hopes("edges --format bin -o -").with(&picture),
            hopes("--help"),
            hopes("compute --help"),
            hopes("--version"),
        ]
    }
}

/// Runs to its end, where `redirection` is as in a shell.
fn redirected(program: &Hopes, redirection: &str) -> Output {
    let command = program.command();
    let script = format!("exec \"$0\" \"$@\" {redirection}");
    let mut shell = Command::new("sh");
    shell.arg("-c").arg(script).arg(command.get_program()).args(command.get_args());
    shell.stdin(Stdio::piped()).output().unwrap()
}

fn expect(program: &Hopes, redirection: &str, code: i32, words: &[&str]) {
    let output = redirected(program, redirection);
    let (log, arguments) = (String::from_utf8_lossy(&output.stderr), format!("{:?} {redirection}", program.command()));
    assert_eq!(output.status.code(), Some(code), "{arguments}: {log}");
    words.iter().for_each(|word| assert!(log.contains(word), "{arguments}: {word:?} is missing in {log}"));
    assert!(!log.contains("panicked"), "{arguments}: {log}");
}

// ---- stdout

#[test]
fn a_closed_stdout_is_an_error() {
    let inputs = Inputs::new();
    let no_daemon = ["watch --from", "status --from", "record -o - --from"];
    let clients = no_daemon.map(|words| hopes(words).with(format!("unix:{}", inputs.path("none").display())));
    for program in inputs.commands().into_iter().chain(clients).chain([hopes("demo --frames 1")]) {
        expect(&program, ">&-", 1, &["cannot write to stdout: stdout is closed"]);
    }
}

#[test]
fn a_closed_stdout_does_not_matter_to_who_does_not_write_there() {
    let inputs = Inputs::new();
    let answer = inputs.path("answer");
    let picture = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/edges/horse.png");
    for program in [
        hopes("compute").with(inputs.path("points.csv")),
        hopes("scene pinch --frames 2"),
        hopes("edges").with(&picture),
    ] {
        expect(&program.and("-o").with(&answer), ">&-", 0, &[]);
        assert!(fs::metadata(&answer).unwrap().len() > 0);
        fs::remove_file(&answer).unwrap();
    }
}

#[test]
fn a_closed_stdin_is_an_error_and_no_empty_input() {
    let inputs = Inputs::new();
    let none = format!("unix:{}", inputs.path("none").display());
    for words in ["compute -", "serve", "replay -", "tracks -", "edges -", &format!("feed - --to {none}")] {
        expect(&hopes(words), "<&-", 1, &["cannot read stdin: stdin is closed"]);
    }
    expect(&hopes("compute").with(inputs.path("points.csv")), "<&-", 0, &[]);
}

#[test]
fn a_stdout_that_is_not_wanted_is_no_error() {
    for program in Inputs::new().commands() {
        for redirection in [">/dev/null", "1<>/dev/null", ">>/dev/null"] {
            expect(&program, redirection, 0, &[]);
        }
    }
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_or_read_only_stdout_is_an_error() {
    let inputs = Inputs::new();
    let readable = format!("1<{}", inputs.path("points.csv").display());
    for program in inputs.commands() {
        // Without a frame nothing is written.
        let program = if format!("{program:?}").contains("serve") { program.and("--frame-every 1ms") } else { program };
        let say = |redirection: &str| format!("{redirection} <{}", inputs.path("points.csv").display());
        expect(&program, &say(">/dev/full"), 1, &["cannot write", "No space left"]);
        expect(&program, &say(&readable), 1, &["cannot write", "Bad file descriptor"]);
    }
    for form in ["text", "events", "jsonl", "bin"] {
        let daemon = FakeDaemon::new();
        let full = File::options().write(true).open("/dev/full").unwrap();
        let mut command = hopes("watch --output").and(form).and("--tracks --from").with(daemon.address()).command();
        let child = command.stdout(full).stderr(Stdio::piped()).spawn().unwrap();
        let mut peer = daemon.greet();
        let (channel, _) = peer.expect_subscribe();
        let scene = GrowingStream::new(3);
        peer.send(channel, scene.opened("default", 7));
        peer.send(channel, scene.snapshot(Cause::Start));
        peer.send(channel, StreamClosed { stream: 3, frame: 1, reason: "over".to_owned() });
        let output = child.wait_with_output().unwrap();
        let log = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.code() == Some(1) && log.contains("No space left"), "{form}: {log}");
    }
}

#[test]
fn a_pipe_that_is_closed_is_no_error() {
    for program in Inputs::new().commands() {
        let (reader, writer) = std::io::pipe().unwrap();
        drop(reader);
        let output = program.command().stdout(writer).output().unwrap();
        let log = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(0), "{program:?}: {log}");
    }
}

// ---- files

/// Commands that write a file when they are whole, up to its name.
fn writers(inputs: &Inputs) -> Vec<Hopes> {
    let picture = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/edges/horse.png");
    vec![
        hopes("compute --format svg").with(inputs.path("points.csv")).and("-o"),
        hopes("scene pinch --frames 20 -o"),
        hopes("scene pinch --frames 200 --truth"),
        hopes("edges").with(picture).and("-o"),
        hopes("tracks").with(inputs.path("tracked.jsonl")).and("--svg"),
    ]
}

/// The names in a folder.
fn names(folder: &Path) -> Vec<String> {
    let mut names: Vec<String> =
        fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
    names.sort();
    names
}

#[test]
fn a_file_is_made_with_the_usual_permissions_and_replaced_with_its_own() {
    let inputs = Inputs::new();
    for writer in writers(&inputs) {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("out");
        let program = writer.with(&file);
        let command = program.command();
        let mut shell = Command::new("sh");
        shell.args(["-c", "umask 027; exec \"$0\" \"$@\""]).arg(command.get_program()).args(command.get_args());
        let output = shell.stdin(Stdio::null()).output().unwrap();
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        let mode = |file: &Path| fs::metadata(file).unwrap().mode() & 0o7777;
        assert_eq!(mode(&file), 0o640, "{program:?}");
        let whole = fs::read(&file).unwrap();
        assert!(!whole.is_empty());

        fs::write(&file, "old, and longer than what comes: ".repeat(10_000)).unwrap();
        fs::set_permissions(&file, PermissionsExt::from_mode(0o604)).unwrap();
        let old = fs::metadata(&file).unwrap().ino();
        assert_eq!(program.runs().code, Some(0));
        assert!(fs::read(&file).unwrap() == whole, "{program:?}");
        assert_eq!(mode(&file), 0o604, "{program:?}");
        assert_ne!(fs::metadata(&file).unwrap().ino(), old, "{program:?}: it is another file");
        assert_eq!(names(folder.path()), ["out"]);
    }
}

#[test]
fn links_are_followed() {
    let inputs = Inputs::new();
    for writer in writers(&inputs) {
        let folder = tempfile::tempdir().unwrap();
        let [link, other, file] = ["link", "other", "file"].map(|name| folder.path().join(name));
        symlink("other", &link).unwrap();
        symlink(&file, &other).unwrap();
        for _ in 0..2 {
            // The first time the links lead nowhere.
            let finished = writer.with(&link).runs();
            assert_eq!(finished.code, Some(0), "{}", finished.err);
            assert!(link.is_symlink() && other.is_symlink() && !file.is_symlink());
            assert!(fs::metadata(&file).unwrap().len() > 0);
            fs::write(&file, "").unwrap();
        }
        fs::remove_file(&file).unwrap();
        symlink("link", &file).unwrap();
        writer.with(&link).runs().fails(1, &["cannot write", "symbolic links"]);
    }
}

#[cfg(target_os = "linux")]
#[test]
fn what_is_no_file_is_written_as_it_is() {
    let inputs = Inputs::new();
    for writer in writers(&inputs) {
        assert_eq!(writer.with("/dev/null").runs().code, Some(0));
        let full = writer.with("/dev/full").runs();
        assert_eq!(full.code, Some(1), "{}", full.err);
        assert!(full.err.contains("/dev/full") && full.err.contains("No space left"), "{}", full.err);
        let folder = tempfile::tempdir().unwrap();
        let pipe = folder.path().join("pipe");
        rustix::fs::mknodat(rustix::fs::CWD, &pipe, rustix::fs::FileType::Fifo, 0o600.into(), 0).unwrap();
        let mut running = writer.with(&pipe).command().stdout(Stdio::null()).spawn().unwrap();
        let mut read = Vec::new();
        File::open(&pipe).unwrap().read_to_end(&mut read).unwrap();
        assert!(running.wait().unwrap().success() && !read.is_empty());
        assert_eq!(names(folder.path()), ["pipe"]);
        // An open file by its number: what is written there goes where it stands, not beside it.
        let file = folder.path().join("file");
        let open = File::create(&file).unwrap();
        let ino = open.metadata().unwrap().ino();
        assert!(writer.with("/dev/stderr").command().stdout(Stdio::null()).stderr(open).status().unwrap().success());
        assert_eq!(fs::metadata(&file).unwrap().ino(), ino);
        assert!(fs::metadata(&file).unwrap().len() > 0);
    }
    let file = inputs.path("points.csv");
    let output = hopes("compute --format csv").with(&file).and("-o /dev/stdout").runs().text();
    assert_eq!(output, hopes("compute --format csv").with(&file).runs().text());
}

#[test]
fn what_cannot_be_made_or_replaced_is_an_error() {
    let inputs = Inputs::new();
    for writer in writers(&inputs) {
        let folder = tempfile::tempdir().unwrap();
        let name = |name: &str| format!("{}/{name}", folder.path().display());
        for (path, reason) in [
            (name("none/out"), "No such file"),
            (name(""), "Is a directory"),
            (name("out/"), "irectory"),
            (name(&"long".repeat(70)), "too long"),
        ] {
            writer.with(&path).runs().fails(1, &["cannot write", reason]);
        }
        assert!(names(folder.path()).is_empty());
    }
}

#[cfg(target_os = "linux")]
#[test]
fn a_program_that_fails_while_it_writes_leaves_the_old_file() {
    let inputs = Inputs::new();
    let points: String = (0..3000).map(|index| format!("{},{}\n", index % 61, index * index % 67)).collect();
    fs::write(inputs.path("points.csv"), points).unwrap();
    let writers = [
        hopes("compute").with(inputs.path("points.csv")).and("-o"),
        hopes("scene pinch --frames 200 -o"),
        hopes("scene pinch --frames 2000 --truth"),
        hopes("edges").with(Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/edges/horse.png")).and("-o"),
    ];
    for writer in writers {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("out");
        let command = writer.with(&file).command();
        for old in [None, Some("old\n")] {
            if let Some(old) = old {
                fs::write(&file, old).unwrap();
            }
            // Files may have some kilobytes: more is an error, or with the signal's usual action the end.
            for trap in ["trap '' XFSZ", ":"] {
                let script = format!("{trap}; ulimit -c 0; ulimit -f 4; exec \"$0\" \"$@\" >/dev/null");
                let mut shell = Command::new("sh");
                shell.arg("-c").arg(script).arg(command.get_program()).args(command.get_args());
                let output = shell.stdin(Stdio::null()).output().unwrap();
                let log = String::from_utf8_lossy(&output.stderr);
                let code = if trap == ":" { None } else { Some(1) };
                assert_eq!(output.status.code(), code, "{command:?}: {log}");
                assert_eq!(fs::read_to_string(&file).ok().as_deref(), old, "{command:?}: {log}");
                assert_eq!(names(folder.path()).len(), old.iter().len(), "{command:?}: nothing else is left");
            }
        }
    }
}

#[cfg(target_os = "linux")]
#[test]
fn a_program_that_is_killed_leaves_the_old_file() {
    for arguments in ["scene crowd --frames 1000000 -o", "scene crowd --frames 1000000 --truth"] {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("out");
        fs::write(&file, "old\n").unwrap();
        let mut running = hopes(arguments).with(&file).start();
        let mut stdout = running.take_stdout();
        let reader = std::thread::spawn(move || drop(std::io::copy(&mut stdout, &mut std::io::sink())));
        eventually("it has written much", || (running.written() > 1 << 20).then_some(()));
        assert_eq!(fs::read_to_string(&file).unwrap(), "old\n", "nothing is seen meanwhile");
        running.signal(Signal::KILL);
        assert_eq!(running.ends().code, None);
        reader.join().unwrap();
        assert_eq!(fs::read_to_string(&file).unwrap(), "old\n");
        assert_eq!(names(folder.path()), ["out"]);
    }
}

/// Whether these tests ignore Ctrl-C, and so all that they start.
fn ignores_interrupts() -> bool {
    let status = fs::read_to_string("/proc/self/status").unwrap_or_default();
    let ignored = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    ignored.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok()).is_some_and(|mask| mask & 2 != 0)
}

#[test]
fn a_signal_that_ends_a_computation_leaves_the_old_file() {
    // A program that is started in the background by a shell without job control has to ignore Ctrl-C.
    let signals = [Signal::INT, Signal::TERM, Signal::KILL].into_iter();
    for signal in signals.filter(|&signal| signal != Signal::INT || !ignores_interrupts()) {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("out");
        fs::write(&file, "old\n").unwrap();
        let mut running = hopes("compute - -o").with(&file).start();
        running.say(SQUARE);
        running.signal(signal);
        assert_eq!(running.ends().code, None);
        assert_eq!(fs::read_to_string(&file).unwrap(), "old\n");
        assert_eq!(names(folder.path()), ["out"]);
    }
}

#[test]
fn edges_of_what_comes_on_stdin_are_seen_as_they_come() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("out");
    fs::write(&file, "old\n").unwrap();
    let mut running = hopes("edges - --size 4x4 -o").with(&file).start();
    let frame: [u8; 16] = [0, 0, 255, 255, 0, 0, 255, 255, 0, 0, 255, 255, 0, 0, 255, 255];
    assert_eq!(fs::read_to_string(&file).unwrap(), "old\n");
    running.say(frame);
    let first = eventually("a frame is there", || {
        Some(fs::read_to_string(&file).unwrap()).filter(|text| text.ends_with("\n\n"))
    });
    running.say(frame);
    eventually("another one is there", || (fs::read_to_string(&file).unwrap() == first.repeat(2)).then_some(()));
    assert_eq!(running.finish().code, Some(0));
}
