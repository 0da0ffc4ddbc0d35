//! The end of a recording: who writes it, what it says, and what is said of a recording that has none.

use std::fs;
use std::time::Duration;

use hopes_protocol::*;
use rustix::process::Signal;

use crate::common::fake_daemon::{FakeDaemon, Peer};
use crate::common::growing_stream::{GrowingStream, recording};
use crate::common::process::{Finished, Hopes, Running, eventually, hopes};
use crate::replay::{at_once, messages, replay};

/// The messages of a recording, all of which are whole.
fn recorded(bytes: &[u8]) -> Vec<(u32, Message)> {
    let mut decoder = Decoder::new(LARGEST_FRAME);
    decoder.push(bytes);
    decoder.banner().unwrap().expect("a banner is due");
    let mut messages = Vec::new();
    while let Some(frame) = decoder.frame().unwrap() {
        match frame.message().unwrap() {
            Message::Elapsed(_) => {}
            message => messages.push((frame.channel, message)),
        }
    }
    assert!(!decoder.is_within_frame());
    messages
}

/// The end of a recording.
fn end(bytes: &[u8]) -> Goodbye {
    let messages = recorded(bytes);
    let ends = messages.iter().filter(|(_, message)| matches!(message, Message::Goodbye(_))).count();
    assert_eq!(ends, 1);
    match messages.last() {
        Some((0, Message::Goodbye(goodbye))) => goodbye.clone(),
        other => panic!("the end is due, not {other:?}"),
    }
}

fn last(name: &str, frame: u64) -> Vec<(String, u64)> {
    vec![(name.to_owned(), frame)]
}

/// Two frames of a stream, to a client that records it.
fn followed(daemon: &FakeDaemon, program: &Hopes) -> (Running, Peer, u32, GrowingStream) {
    let client = program.start();
    let mut peer = daemon.greet();
    let (channel, _) = peer.expect_subscribe();
    let mut scene = GrowingStream::new(3);
    peer.send(channel, scene.opened("cam", 7));
    peer.send(channel, scene.snapshot(Cause::Start));
    peer.send(channel, scene.diff());
    (client, peer, channel, scene)
}

/// What a client has recorded of two frames, when its daemon has done that.
fn after(say: &dyn Fn(&mut Running, Peer, u32, GrowingStream), code: i32) -> Goodbye {
    let mut ends = ["record -o -", "watch --output bin"].map(|program| {
        let daemon = FakeDaemon::new();
        let (mut client, peer, channel, scene) =
            followed(&daemon, &hopes(program).and("--stream cam --from").with(daemon.address()));
        say(&mut client, peer, channel, scene);
        let finished = client.finish();
        assert_eq!(finished.code, Some(code), "{}", finished.err);
        let replayed = replay("--fast --strict", &finished.out);
        assert_eq!(replayed.code, Some(0), "{}", replayed.err);
        let mut end = end(&finished.out);
        assert!(replayed.err.contains(&end.reason), "{}", replayed.err);
        end.reason = end.reason.replace(&daemon.address(), "there");
        end
    });
    assert_eq!(ends[0], ends[1]);
    std::mem::replace(&mut ends[0], Goodbye { reason: String::new(), streams: Vec::new() })
}

#[test]
fn a_recording_ends_with_the_daemons_goodbye() {
    let goodbye = |_: &mut Running, peer: Peer, _, _| peer.goodbye(&[("cam", 2), ("other", 9)]);
    let reason = "the daemon says goodbye: going home".to_owned();
    assert_eq!(after(&goodbye, 0), Goodbye { reason: reason.clone(), streams: last("cam", 2) });
    let closed = |_: &mut Running, mut peer: Peer, channel, scene: GrowingStream| {
        peer.send(channel, StreamClosed { stream: scene.stream, frame: 2, reason: "over".to_owned() });
        peer.goodbye(&[]);
    };
    assert_eq!(after(&closed, 0), Goodbye { reason, streams: Vec::new() });
}

#[test]
fn a_signal_ends_a_recording_in_good_order() {
    for (signal, name) in [(Signal::INT, "SIGINT"), (Signal::TERM, "SIGTERM")] {
        let stop = |client: &mut Running, mut peer: Peer, _, _| {
            // The client has taken all that was sent when it answers.
            peer.ping_and_wait(5);
            client.signal(signal);
            assert_eq!(peer.expect_goodbye(), name);
        };
        assert_eq!(after(&stop, 0), Goodbye { reason: name.to_owned(), streams: last("cam", 2) });
    }
}

#[test]
fn a_recording_says_that_its_connection_was_lost() {
    let end = after(&|_, peer, _, _| drop(peer), 1);
    assert!(end.reason.contains("the daemon at there closed the connection without a goodbye"), "{}", end.reason);
    assert_eq!(end.streams, last("cam", 2));
}

#[test]
fn a_recording_grows_message_by_message_and_a_killed_one_is_known() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("cam.hopes");
    fs::write(&file, "what was there before ".repeat(1000)).unwrap();
    let daemon = FakeDaemon::new();
    let program = hopes("record --stream cam --from").with(daemon.address()).and("-o").with(&file);
    let client = program.start();
    let mut peer = daemon.greet();
    let (channel, _) = peer.expect_subscribe();
    peer.ping_and_wait(1);
    assert!(fs::read_to_string(&file).unwrap().starts_with("what was there"), "until something comes it is left");
    let mut scene = GrowingStream::new(3);
    // The first frame shows in which version the recording is.
    peer.send(channel, scene.opened("cam", 7));
    for message in [scene.snapshot(Cause::Start), scene.diff()] {
        peer.send(channel, message.clone());
        eventually("the message is in the file", || {
            let bytes = fs::read(&file).unwrap();
            (bytes.starts_with(b"HOPES") && recorded(&bytes).last() == Some(&(channel, message.clone()))).then_some(())
        });
    }
    client.signal(Signal::KILL);
    assert_eq!(client.ends().code, None);
    let cut = hopes("replay --fast").with(&file);
    let finished = cut.runs();
    assert_eq!((finished.code, finished.out.iter().filter(|&&byte| byte == b'\n').count()), (Some(0), 2));
    assert!(finished.err.contains("has no end after 2 frames: it was cut off"), "{}", finished.err);
    let strict = cut.and("--strict").runs();
    assert_eq!(strict.code, Some(3), "{}", strict.err);
    assert!(strict.out == finished.out && strict.err.contains("has no end after 2 frames"), "{}", strict.err);
}

#[test]
fn a_record_that_gets_nothing_leaves_what_is_there() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("cam.hopes");
    let none = format!("unix:{}/none", folder.path().display());
    let ends = |address: &str, meet: &dyn Fn(&mut Running)| -> Finished {
        let mut client = hopes("record --from").with(address).and("-o").with(&file).start();
        meet(&mut client);
        client.finish()
    };
    for old in [None, Some("old")] {
        if let Some(old) = old {
            fs::write(&file, old).unwrap();
        }
        assert_eq!(ends(&none, &|_| ()).code, Some(1));
        assert_eq!(fs::read_to_string(&file).ok().as_deref(), old);
        let daemon = FakeDaemon::new();
        let refused = ends(&daemon.address(), &|_| {
            let mut peer = daemon.greet();
            let (channel, _) = peer.expect_subscribe();
            peer.send(channel, Report { code: 9, answers: 0x0201, text: "no such view".to_owned() });
        });
        assert_eq!(refused.code, Some(1), "{}", refused.err);
        assert_eq!(fs::read_to_string(&file).ok().as_deref(), old);
        let stopped = ends(&daemon.address(), &|client| {
            let mut peer = daemon.greet();
            peer.expect_subscribe();
            client.signal(Signal::TERM);
            peer.expect_goodbye();
        });
        assert!(stopped.code == Some(0) && stopped.err.contains("0 frames recorded"), "{}", stopped.err);
        match old {
            Some(old) => {
                assert_eq!(fs::read_to_string(&file).unwrap(), old);
                assert!(stopped.err.contains("is left as it was"), "{}", stopped.err);
            }
            None => assert_eq!(end(&fs::read(&file).unwrap()).reason, "SIGTERM", "an empty recording is one too"),
        }
        fs::remove_file(&file).unwrap();
    }
}

#[test]
fn serve_ends_its_recording() {
    let serve = hopes("serve --output bin --window frames:1");
    let finished = serve.reads("0,0\n\n1,1\n\n");
    let whole = finished.out();
    assert_eq!(end(&whole), Goodbye { reason: "the daemon has ended".to_owned(), streams: last("default", 2) });
    assert_eq!(replay("--fast --strict", &whole).code, Some(0));
    assert_eq!(end(&serve.reads("").out()).streams, last("default", 1), "the end of the input closes a frame");
    let strict = serve.and("--strict").reads("0,0\n\nbad\n");
    assert_eq!(strict.code, Some(3), "{}", strict.err);
    assert!(end(&strict.out).reason.contains("line 3"), "{:?}", end(&strict.out));

    let mut running = serve.start();
    running.say("0,0\n\n");
    eventually("a frame is written", || (running.unread() > 20).then_some(()));
    running.signal(Signal::TERM);
    let stopped = running.finish();
    assert_eq!(end(&stopped.out()).streams, last("default", 1));
    let mut running = serve.start();
    running.say("0,0\n\n");
    eventually("a frame is written", || (running.unread() > 20).then_some(()));
    running.signal(Signal::KILL);
    let killed = running.finish();
    assert_eq!((killed.code, replay("--fast --strict", killed.out).code), (None, Some(3)));
}

#[test]
fn a_replay_hands_the_end_on() {
    let mut whole: Vec<(Duration, Message)> = at_once(&messages());
    let cut = recording(&whole);
    assert_eq!(replay("--fast --output bin", &cut).out(), cut, "a cut recording stays cut");
    whole.push((Duration::ZERO, Goodbye { reason: "a\u{1b}[2Jb".to_owned(), streams: Vec::new() }.into()));
    let mut bytes = recording(&whole);
    let replayed = replay("--fast --strict --output bin", &bytes);
    assert!(replayed.err.contains("ends after 4 frames: a [2Jb"), "{}", replayed.err);
    assert_eq!(replayed.out(), bytes);
    for length in cut.len() + 1..bytes.len() {
        let finished = replay("--fast --strict", &bytes[..length]);
        assert_eq!(finished.code, Some(3), "{length}: {}", finished.err);
    }
    bytes.extend(&recording(&whole)[Banner::LENGTH..]);
    let finished = replay("--fast", &bytes);
    assert!(finished.code == Some(1) && finished.err.contains("something follows the end"), "{}", finished.err);

    let mut running = hopes("replay - --output bin").start();
    running.say(&cut);
    eventually("all is written", || (running.unread() >= cut.len() as u64).then_some(()));
    running.signal(Signal::TERM);
    running.until_log("SIGTERM: stopped after 4 frames");
    let stopped = running.finish();
    assert_eq!((stopped.code, end(&stopped.out).reason.as_str()), (Some(0), "SIGTERM"));
}
