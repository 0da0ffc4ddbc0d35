//! The examples of every `--help`, and those of the README's table of commands, taken from the text and run.
//!
//! Each example runs in a shell and a folder of its own, with small inputs. Programs that stand for the reader's own
//! (`sensor`, `camera-edges`, `ffmpeg` and so on) are scripts. A daemon is there for the examples that need one. An
//! example that does not end by itself gets a Ctrl-C. Every `hopes` in it must end with exit code 0, and warn of
//! nothing: an example whose points are refused is none.

mod common;

use std::fs::Permissions;
use std::net::TcpListener;
use std::os::unix::fs::{PermissionsExt, symlink};
use std::os::unix::process::CommandExt;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::thread;
use std::time::{Duration, Instant};

use common::client::{Client, hello};
use common::process::hopes;
use hopes_protocol::{ListPeers, Message, Peers};
use rustix::process::{Pid, Signal, kill_process_group};
use tempfile::TempDir;

/// Commands that may go on until they are asked to end. The others end by themselves, however busy the machine is.
const ENDLESS: [&str; 8] = ["serve", "feed", "watch", "record", "replay", "tracks", "status", "demo"];

/// After so long an example that has not ended gets a Ctrl-C.
const PLAYED: Duration = Duration::from_secs(3);

/// After so long it has failed.
const PATIENCE: Duration = Duration::from_secs(60);

/// What is written in help texts, and stands for a real address in the test.
const SOCKET: &str = "/tmp/hopes.sock";
const PORT: &str = "127.0.0.1:7878";
const PAGE: [&str; 2] = ["127.0.0.1:8080", "127.0.0.1:9000"];
const VICTIM: &str = "disconnect 7 ";

const README: &str = include_str!("../README.md");

/// Records the exit code of every `hopes`. A signal to the shell must not end it before `hopes` has ended.
const WRAPPER: &str = "#!/bin/bash
trap : INT TERM
BINARY \"$@\"
code=$?
echo \"$code hopes $*\" >> \"$CODES\"
exit $code
";

/// Programs of the reader, and what they do here. A frame of `camera-edges` replaces the one before.
const STAND_INS: [(&str, &str); 10] = [
    ("sensor", "cat \"$DATA/points.csv\""),
    ("lidar", "cat \"$DATA/log.csv\""),
    ("lidar3d", "cat \"$DATA/cloud.csv\""),
    ("microphone", "seq 400"),
    ("produce", "cat \"$DATA/points.csv\""),
    ("camera-edges", "cat \"$DATA/edges.jsonl\""),
    // Without `-n +1` the header is not among the last lines.
    ("tail", "case \"$*\" in *'-n +1 '*) cat \"$DATA/log.csv\";; *) sed '1,50d' \"$DATA/log.csv\";; esac"),
    // YUV4MPEG2 has no place for what most cameras give.
    (
        "ffmpeg",
        "case \"$*\" in *video0*' -pix_fmt gray '*) ;; *video0*) exit 1;; esac; case \"$*\" in *rawvideo*) head -c 1843200 /dev/zero;; *) cat \"$DATA/film.y4m\";; esac",
    ),
    ("jq", "cat"),
    ("gzip", "cat"),
];

#[test]
fn examples_run() {
    let world = World::new();
    let examples = examples();
    for command in &subcommands() {
        assert!(examples.iter().any(|(of, _)| of == command), "hopes {command} --help has no example");
    }
    let mut daemon = world.daemon();
    let numbers = daemon.numbers_of_victims();
    let failures: Vec<String> = thread::scope(|scope| {
        let runs: Vec<_> =
            examples.iter().map(|(command, example)| scope.spawn(|| world.run(command, example, numbers))).collect();
        runs.into_iter().filter_map(|run| run.join().expect("an example is run").err()).collect()
    });
    assert!(failures.is_empty(), "{}", failures.join("\n\n"));
    assert!(examples.len() > 30, "only {} examples were found", examples.len());
}

/// All examples, each with its subcommand.
fn examples() -> Vec<(String, String)> {
    let mut examples = of_help("", &hopes("--help").runs().text());
    for command in subcommands() {
        examples.extend(of_help(&command, &hopes(&format!("{command} --help")).runs().text()));
    }
    examples.extend(of_readme());
    examples
}

/// What stands in the last column of the README's table of commands.
fn of_readme() -> Vec<(String, String)> {
    let (_, section) = README.split_once("\n## Commands\n").expect("README has commands");
    let rows = section.lines().skip_while(|line| !line.starts_with('|')).take_while(|line| line.starts_with('|'));
    let cells = |row: &str| -> Option<(String, String)> {
        let row = row.replace("\\|", "\u{0}");
        let [name, _, example] = row.trim_matches('|').split('|').map(str::trim).collect::<Vec<_>>().try_into().ok()?;
        let bare = |cell: &str| cell.trim_matches('`').replace('\u{0}', "|");
        Some((format!("{} in README", bare(name)), bare(example)))
    };
    rows.skip(2).filter_map(cells).collect()
}

/// The names below `Commands:`.
fn subcommands() -> Vec<String> {
    let help = hopes("--help").runs().text();
    let lines = help.lines().skip_while(|line| *line != "Commands:").skip(1).take_while(|line| !line.is_empty());
    let names = lines.filter_map(|line| line.strip_prefix("  ").filter(|line| !line.starts_with(' ')));
    names.filter_map(|line| line.split(' ').next()).filter(|&name| name != "help").map(str::to_owned).collect()
}

/// Lines below `Examples:`, without what is said of them after three blanks. A line that ends in `|` goes on in the
/// next.
fn of_help(command: &str, help: &str) -> Vec<(String, String)> {
    let lines = help.lines().skip_while(|line| !line.starts_with("Example")).skip(1);
    let mut examples: Vec<(String, String)> = Vec::new();
    for line in lines.take_while(|line| line.starts_with("  ")) {
        let line = line.trim().split("   ").next().unwrap_or_default();
        match examples.last_mut() {
            Some((_, begun)) if begun.ends_with('|') => begun.extend([" ", line]),
            _ => examples.push((command.to_owned(), line.to_owned())),
        }
    }
    examples
}

/// Inputs, stand-ins, and the addresses of a daemon.
struct World {
    folder: TempDir,
    port: u16,
}

/// The daemon and its producers. They are killed at the end.
struct Daemon {
    children: Vec<Child>,
    /// Peers that examples disconnect.
    victims: [Client; 2],
}

impl World {
    fn new() -> Self {
        let port = TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap().port();
        let world = Self { folder: tempfile::tempdir().unwrap(), port };
        world.stand_ins();
        world.inputs();
        world
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    fn stand_ins(&self) {
        std::fs::create_dir(self.path("bin")).unwrap();
        let script = |name: &str, text: &str| {
            let file = self.path("bin").join(name);
            std::fs::write(&file, text).unwrap();
            std::fs::set_permissions(file, Permissions::from_mode(0o755)).unwrap();
        };
        script("hopes", &WRAPPER.replace("BINARY", env!("CARGO_BIN_EXE_hopes")));
        for (name, body) in STAND_INS {
            script(name, &format!("#!/bin/bash\n{body}\n"));
        }
    }

    /// The files that examples name.
    fn inputs(&self) {
        let data = self.path("data");
        std::fs::create_dir_all(data.join("frames")).unwrap();
        let write = |name: &str, bytes: Vec<u8>| std::fs::write(data.join(name), bytes).unwrap();
        let ring = |separator: &str| -> String {
            let place = |i: u32| (f64::from(i) / 10.0).sin_cos();
            (0..60).map(place).map(|(x, y)| format!("{x:.3}{separator}{y:.3}\n")).collect()
        };
        write("points.csv", ring(",").into_bytes());
        write("scan.tsv", format!("lon\tlat\n{}", ring("\t")).into_bytes());
        write(
            "log.csv",
            (0..60).fold("lon,lat,unix\n".to_owned(), |log, i| log + &format!("{i}.5,{i},{i}\n")).into_bytes(),
        );
        let place = |i: u32| [i % 7, i % 5, i % 3].map(f64::from);
        let row = |[x, y, z]: [f64; 3]| format!("{x},{y},{z}\n");
        write("cloud.csv", (0..40).map(place).map(row).fold("x,y,z\n".to_owned(), |all, row| all + &row).into_bytes());
        write("distances.csv", b"1\n2,1\n1,2,1\n".to_vec());
        write(
            "signal.csv",
            (0..200).map(|i| format!("{}\n", (f64::from(i) / 5.0).sin())).collect::<String>().into_bytes(),
        );
        let header = "{'descr': '<f8', 'fortran_order': False, 'shape': (40, 3), }";
        let mut vectors = b"\x93NUMPY\x01\x00\x76\x00".to_vec();
        vectors.extend(format!("{header:<117}\n").into_bytes());
        vectors.extend((1..41).flat_map(place).flat_map(|value| (value + 1.0).to_le_bytes()));
        write("vectors.npy", vectors);
        let squares = |count: usize| "0,0\n2,0\n2,2\n0,2\n\n0,0\n3,0\n3,3\n0,3\n\n".repeat(count);
        write("points.txt", squares(1).into_bytes());
        write("points", squares(1).into_bytes());
        let edges = r#"{"points":[[0,0],[2,0],[2,2],[0,2]]}"#.to_owned() + "\n{\"commit\":true}\n";
        write("edges.jsonl", edges.repeat(4).into_bytes());
        let mut film = b"YUV4MPEG2 W16 H8 F25:1 Cmono\n".to_vec();
        for _ in 0..3 {
            film.extend(b"FRAME\n");
            film.extend((0..128).map(|at| if at % 16 < 8 { 0 } else { 255 }));
        }
        write("film.y4m", film);
        let tests = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/edges");
        symlink(tests.join("bunny-gray.jpg"), data.join("photo.jpg")).unwrap();
        for name in ["text.png", "coins.png"] {
            symlink(tests.join(name), data.join("frames").join(name)).unwrap();
        }
        let points = hopes("scene pinch --frames 3 --format bin").runs().out();
        write("points.hopes", points);
        let served = |options: &str| hopes(&format!("serve --window frames:1 {options}")).reads(squares(3)).out();
        write("camera.hopes", served("--output bin"));
        write("frames.jsonl", served("--track view"));
    }

    /// A daemon with streams that get a frame sixty times a second, and two that examples stop.
    fn daemon(&self) -> Daemon {
        let (socket, port) = (self.path("hopes.sock"), self.port);
        let listen = hopes("serve --track view --stream scan --stream hall --stream").with("hall 2").and("--listen");
        let listen = listen.with(format!("unix:{}", socket.display()));
        let mut children = vec![quiet(&mut listen.and(&format!("--listen tcp:127.0.0.1:{port}")).command())];
        let begun = Instant::now();
        while !socket.exists() {
            assert!(begun.elapsed() < PATIENCE, "the daemon starts");
            thread::sleep(Duration::from_millis(10));
        }
        for stream in ["default", "cam", "camera"] {
            let feed = hopes("feed --input jsonl --window frames:1 --loop --rate 60 --stream").with(stream);
            let feed = feed.with("--to").with(format!("unix:{}", socket.display()));
            children.push(quiet(&mut feed.with(self.path("data/edges.jsonl")).command()));
        }
        let victim = || Client::with_hello(&format!("unix:{}", socket.display()));
        Daemon { children, victims: [victim(), victim()] }
    }

    /// Runs an example. What is wrong with it, if anything. `numbers` are those of peers that may be disconnected.
    fn run(&self, command: &str, example: &str, numbers: [u64; 2]) -> Result<(), String> {
        let folder = tempfile::tempdir().unwrap();
        for entry in std::fs::read_dir(self.path("data")).unwrap() {
            let entry = entry.unwrap();
            symlink(entry.path(), folder.path().join(entry.file_name())).unwrap();
        }
        let own = folder.path().join("hopes.sock");
        let is_daemon = example.contains("--listen");
        let usual = if is_daemon { own.clone() } else { self.path("hopes.sock") };
        let socket = if is_daemon { own } else { self.path("hopes.sock") };
        let port = if is_daemon { 0 } else { self.port };
        let mut line = example.replace(SOCKET, &socket.to_string_lossy());
        let number = numbers[usize::from(command.ends_with("README"))];
        line = line.replace(VICTIM, &format!("disconnect {number} "));
        line = line.replace(PORT, &format!("127.0.0.1:{port}"));
        for page in PAGE {
            line = line.replace(page, "127.0.0.1:0");
        }
        let (out, log, codes) = (folder.path().join(".out"), folder.path().join(".log"), folder.path().join(".codes"));
        let create = |path: &Path| std::fs::File::create(path).unwrap();
        let path = format!("{}:{}", self.path("bin").display(), std::env::var("PATH").unwrap_or_default());
        let mut shell = Command::new("bash");
        shell.args(["-c", &format!("trap : INT; {line}\nwait")]).current_dir(folder.path()).process_group(0);
        shell.env("PATH", path).env("DATA", self.path("data")).env("CODES", &codes);
        shell.env("HOPES_ADDRESS", format!("unix:{}", usual.display()));
        shell.stdin(Stdio::null()).stdout(create(&out)).stderr(create(&log));
        let is_endless = ENDLESS.iter().any(|command| example.contains(&format!("hopes {command}")));
        let ended = to_the_end(shell.spawn().unwrap(), is_endless);
        let log = std::fs::read_to_string(log).unwrap();
        let codes = std::fs::read_to_string(codes).unwrap_or_default();
        let is_good = ended && !codes.is_empty() && codes.lines().all(|code| code.starts_with("0 "));
        if is_good && !log.contains("ERROR") && !log.contains("WARN") && !log.contains("not found") {
            return Ok(());
        }
        Err(format!("hopes {command} --help: {example}\nended: {ended}\ncodes:\n{codes}log:\n{log}"))
    }
}

impl Daemon {
    /// The numbers of the peers that examples disconnect. They are the only ones with the name of a test.
    fn numbers_of_victims(&mut self) -> [u64; 2] {
        let Message::Peers(Peers { peers }) = self.victims[0].ask(1, ListPeers {}) else { panic!("Peers is due") };
        let named: Vec<u64> =
            peers.iter().filter(|peer| peer.software == hello().software).map(|peer| peer.peer).collect();
        named.try_into().unwrap_or_else(|named| panic!("{named:?} of {peers:?}"))
    }
}

impl Drop for Daemon {
    fn drop(&mut self) {
        for child in self.children.iter_mut().rev() {
            drop(child.kill());
            drop(child.wait());
        }
    }
}

fn quiet(command: &mut Command) -> Child {
    command.stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap()
}

/// Waits for the end, of what is endless if need be after a Ctrl-C; whether there was an end.
fn to_the_end(mut shell: Child, is_endless: bool) -> bool {
    let (begun, group) = (Instant::now(), Pid::from_child(&shell));
    let mut is_asked = false;
    loop {
        match shell.try_wait().unwrap() {
            Some(_) => return true,
            None if begun.elapsed() > PATIENCE => {
                kill_process_group(group, Signal::KILL).unwrap();
                shell.wait().unwrap();
                return false;
            }
            None if is_endless && begun.elapsed() > PLAYED && !is_asked => {
                is_asked = true;
                kill_process_group(group, Signal::INT).unwrap();
            }
            None => thread::sleep(Duration::from_millis(20)),
        }
    }
}
