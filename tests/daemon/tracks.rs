//! Tracks over sockets: only consumers that ask for tracks get them, from the frame of their last message on.

use hopes_protocol::*;

use crate::common::client::{Client, brief, bytes, hello};
use crate::common::peers::{Consumer, DERIVED, Daemon, Point, Producer, open};
use crate::common::process::hopes;

/// A circle of radius 1 with fourteen points for each radius of length.
fn circle([x, y]: [f64; 2]) -> Vec<Point> {
    let angle = |step: u32| std::f64::consts::TAU * f64::from(step) / 90.0;
    (0..90).map(|step| (x + angle(step).cos(), y + angle(step).sin())).collect()
}

/// A stream whose frames replace each other: a circle that moves, and in every third frame a second one.
struct Film {
    producer: Producer,
    frame: u64,
}

impl Film {
    fn new(daemon: &Daemon) -> Self {
        let open = Open { window: Some(Window::Frames(1)), ..open("film") };
        Self { producer: Producer::open(daemon.client(), open), frame: 0 }
    }

    fn step(&mut self) -> u64 {
        let mut points = circle([self.frame as f64 * 0.05, 0.0]);
        if self.frame % 6 >= 3 {
            points.extend(circle([0.0, 9.0]));
        }
        self.frame += 1;
        assert_eq!(self.producer.frame(&points), self.frame);
        self.frame
    }

    fn steps(&mut self, count: usize) {
        for _ in 0..count {
            self.step();
        }
    }
}

/// A consumer of a stream and its tracks.
struct Watcher {
    consumer: Consumer,
    tracks: TrackMirror,
}

impl Watcher {
    fn new(daemon: &Daemon, wanted: TracksWanted) -> Self {
        let mut consumer = daemon.consumer("film", DERIVED);
        consumer.client.send(Consumer::CHANNEL, WantTracks { tracks: wanted });
        Self { consumer, tracks: TrackMirror::new() }
    }

    /// The next message about tracks.
    fn next_tracks(&mut self) -> Tracks {
        loop {
            if let Message::Tracks(tracks) = self.consumer.next() {
                assert!(tracks.frame <= self.consumer.mirror.number(), "the frame was sent before");
                self.tracks.apply(&tracks).unwrap();
                return tracks;
            }
        }
    }

    fn tracks_to(&mut self, frame: u64) -> Vec<Tracks> {
        let mut messages = Vec::new();
        while self.tracks.frame() < frame {
            messages.push(self.next_tracks());
        }
        messages
    }
}

const TRACKS: &str = "--track above:0.5";

#[test]
fn a_consumer_that_asks_for_tracks_gets_them_in_every_frame() {
    let daemon = Daemon::start(TRACKS);
    let mut film = Film::new(&daemon);
    let mut watcher = Watcher::new(&daemon, TracksWanted::Alive);
    let mut other = daemon.consumer("film", DERIVED);
    for frame in 1..=12 {
        film.step();
        let tracks = watcher.next_tracks();
        assert_eq!((tracks.frame, tracks.from), (frame, frame - 1));
        assert_eq!(tracks.alive.map(|alive| alive.len()), Some(watcher.tracks.alive().len()));
    }
    let ids: Vec<u64> = watcher.tracks.alive().keys().copied().collect();
    assert_eq!(ids, [1, 3], "the second circle's first track has ended");
    let track = watcher.tracks.alive()[&1];
    assert!((track.velocity.0 - 0.05).abs() < 0.01 && (track.area - std::f64::consts::PI).abs() < 0.1, "{track:?}");
    let heard = other.follow_to(12);
    assert!(!heard.iter().any(|message| matches!(message, Message::Tracks(_))), "{}", brief(&heard));
    daemon.stop();
}

#[test]
fn events_alone_are_sent_only_for_frames_with_events() {
    let daemon = Daemon::start("--track above:0.5 --track-delta 100");
    let mut film = Film::new(&daemon);
    let mut watcher = Watcher::new(&daemon, TracksWanted::Events);
    film.steps(20);
    let messages = watcher.tracks_to(20);
    assert!(messages.iter().all(|tracks| (tracks.from == 0) == tracks.alive.is_some()));
    assert!(messages.iter().all(|tracks| tracks.from == 0 || !tracks.events.is_empty()));
    let events = messages.iter().flat_map(|tracks| &tracks.events);
    let story: Vec<(u64, u64, Happening)> =
        events.map(|event| (event.frame, event.track.id, event.happening)).collect();
    let (born, died) = (Happening::Born, Happening::Died);
    let whole = [(2, 1, born), (5, 2, born), (8, 2, died), (11, 3, born), (14, 3, died), (17, 4, born), (20, 4, died)];
    // A consumer that joins before the first frame gets all events, a later one those after its start.
    assert!(whole.ends_with(&story) && story.len() >= 5, "{story:?}");
    daemon.stop();
}

#[test]
fn a_late_consumer_gets_the_living_tracks() {
    let daemon = Daemon::start(TRACKS);
    let mut film = Film::new(&daemon);
    let mut first = Watcher::new(&daemon, TracksWanted::Cycles);
    film.steps(5);
    first.tracks_to(5);
    let mut late = Watcher::new(&daemon, TracksWanted::Cycles);
    let tracks = late.next_tracks();
    assert_eq!((tracks.from, tracks.frame, tracks.cycles.len()), (0, 5, 2));
    for cycle in &tracks.cycles {
        assert_eq!(cycle.walks.iter().map(Vec::len).collect::<Vec<_>>(), [90]);
        assert!(cycle.walks[0].iter().all(|vertex| late.consumer.mirror.vertices().contains_key(vertex)));
    }
    for _ in 0..8 {
        film.step();
        assert_eq!(late.next_tracks(), first.next_tracks());
    }
    assert_eq!((late.tracks.alive(), late.tracks.cycles()), (first.tracks.alive(), first.tracks.cycles()));
    daemon.stop();
}

#[test]
fn a_slow_consumer_misses_no_event() {
    let daemon = Daemon::start("--track above:0.5 --consumer-queue 1KiB");
    let mut film = Film::new(&daemon);
    film.step();
    let mut slow = Watcher::new(&daemon, TracksWanted::Events);
    slow.next_tracks();
    film.steps(400);
    let messages = slow.tracks_to(400);
    let mut births: Vec<u64> = messages
        .iter()
        .flat_map(|tracks| &tracks.events)
        .filter(|event| event.happening == Happening::Born)
        .map(|event| event.track.id)
        .collect();
    births.dedup();
    assert_eq!(births, (1..=births.len() as u64).collect::<Vec<_>>());
    assert!(births.len() > 60, "{births:?}");
    daemon.stop();
}

#[test]
fn tracks_can_be_switched_off_and_on() {
    let daemon = Daemon::start(TRACKS);
    let mut film = Film::new(&daemon);
    let mut watcher = Watcher::new(&daemon, TracksWanted::Alive);
    film.steps(3);
    watcher.tracks_to(3);
    watcher.consumer.client.send(Consumer::CHANNEL, WantTracks { tracks: TracksWanted::No });
    watcher.consumer.client.drain();
    film.step();
    watcher.consumer.expect_diff(4);
    film.step();
    watcher.consumer.expect_diff(5);
    watcher.consumer.client.send(Consumer::CHANNEL, WantTracks { tracks: TracksWanted::Alive });
    let again = watcher.next_tracks();
    assert_eq!((again.from, again.frame), (0, 5));
    daemon.stop();
}

#[test]
fn invalid_requests_for_tracks_are_refused() {
    let without = Daemon::start("");
    Film::new(&without).step();
    let wanted = WantTracks { tracks: TracksWanted::Alive };
    let mut consumer = without.consumer("film", DERIVED);
    consumer.expect_snapshot(Cause::Start);
    assert_eq!(consumer.client.is_refused(Consumer::CHANNEL, wanted), ErrorCode::BadOptions as u16);
    assert_eq!(consumer.client.is_refused(7, wanted), ErrorCode::NoChannel as u16);
    without.stop();
}

/// A client of version 1 does not know these messages, so they are unknown types.
#[test]
fn in_version_1_there_are_no_tracks() {
    let daemon = Daemon::start(TRACKS);
    let mut client = Client::without_banner(&daemon.address);
    client.write(&Banner { lowest: 1, highest: 1 }.encode());
    client.banner();
    client.set_version(1);
    client.write(&encode(1, 0, &hello().into()).unwrap());
    assert!(matches!(client.receive_on(0), Message::Welcome(_)));
    let wanted = bytes(3, WantTracks { tracks: TracksWanted::Alive });
    client.write(&[&header(1, 0x020D, 3, 1), &wanted[HEADER..]].concat());
    let report = client.expect_error_on(3);
    assert_eq!((report.code, report.answers), (ErrorCode::Unexpected as u16, 0x020D), "{}", report.text);
    daemon.stop();
}

#[test]
fn watch_shows_tracks() {
    let daemon = Daemon::start(TRACKS);
    let mut film = Film::new(&daemon);
    film.step();
    let from = format!("--from {} --stream film --frames 6", daemon.address);
    let watches = ["--tracks=all", "--tracks=all --output jsonl", "--output events"].map(|output| {
        let mut running = hopes("watch").and(&from).and(output).start();
        let first = running.line().expect("the frame that is there");
        (running, first)
    });
    film.steps(8);
    let [text, lines, events] = watches.map(|(running, first)| first + "\n" + &running.finish().text());
    assert!(text.contains("film  frame 1  0 tracks are alive\n"), "{text}");
    assert!(!text.contains("film  frame 7"), "{text}");
    assert!(text.contains("film  frame 2  track 1 is born: at (0.05, 0), 0.0349..1\n"), "{text}");
    let lists = lines.lines().filter(|line| line.contains(r#""alive":[[1,"#)).count();
    assert!(lists >= 4, "{lines}");
    let of_tracks: Vec<&str> = text.lines().filter(|line| line.contains(" track")).collect();
    assert_eq!(events.lines().collect::<Vec<_>>(), of_tracks);
    daemon.stop();
}
