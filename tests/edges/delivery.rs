//! `--to`: the messages that a daemon gets.

use hopes_protocol::*;

use crate::common::fake_daemon::{FakeDaemon, Peer};
use crate::{Gray, edges, folder};

/// Accepts all messages to the end. Returns points of batches and times of commits.
fn take_all(peer: &mut Peer, channel: u32) -> Vec<String> {
    let (mut taken, mut frame) = (Vec::new(), 0);
    loop {
        let (on, message) = peer.next().expect("a producer closes before it goes");
        assert_eq!(on, channel);
        match message {
            Message::Batch(Batch { sequence, points, times, tags }) => {
                assert!(times.is_empty() && tags.is_empty());
                peer.send(channel, Accepted { sequence, points: points.len() as u32, placed: Vec::new() });
                taken.push(format!("{points:?}"));
            }
            Message::Commit(Commit { sequence, time }) => {
                frame += 1;
                peer.send(channel, Committed { sequence, frame });
                taken.push(format!("commit {time:?}"));
            }
            Message::Close(Close { end: false }) => {
                peer.send(channel, Closed { frame });
                assert_eq!(peer.expect_goodbye(), "that is all");
                return taken;
            }
            other => panic!("{other:?}"),
        }
    }
}

#[test]
fn each_picture_is_a_frame_of_the_stream() {
    let files =
        [("1.png", Gray::step(9, 3, 4, 200).png()), ("2.png", Vec::new()), ("3.png", Gray::step(9, 1, 2, 200).png())];
    let folder = folder(&files);
    let daemon = FakeDaemon::new();
    let client = edges(folder.path(), "--rate 20 --stream cam --to").with(daemon.address()).start();
    let mut peer = daemon.greet();
    let (channel, open) = peer.open(2);
    assert_eq!((open.name.as_str(), open.window, open.resolution), ("cam", Some(Window::Frames(1)), None));
    let expected = ["[(3.0, 2.0), (3.0, 1.0)]", "[(3.0, 0.0)]", "commit Some(0.0)", "[(1.0, 0.0)]", "commit Some(0.1)"];
    assert_eq!(take_all(&mut peer, channel), expected, "no more points in a message than the daemon takes");
    let log = client.finish();
    assert_eq!((log.code, log.out.len()), (Some(0), 0), "{}", log.err);
    for words in ["2.png: it is neither PNG", "stream cam: 4 points accepted, 1 refused, 0 dropped; 2 frames"] {
        assert!(log.err.contains(words), "{words}: {}", log.err);
    }
}

#[test]
fn an_existing_stream_keeps_its_window() {
    let folder = folder(&[("1.png", Gray::step(9, 1, 4, 200).png())]);
    let refuse = |peer: &mut Peer| {
        let Some((channel, Message::Open(open))) = peer.next() else { panic!("Open comes first") };
        let text = "it has points:10".to_owned();
        peer.send(channel, Report { code: ErrorCode::OtherOptions as u16, answers: 0, text });
        open
    };
    let daemon = FakeDaemon::new();
    let client = edges(folder.path(), "--to").with(daemon.address()).start();
    let mut peer = daemon.greet();
    assert_eq!(refuse(&mut peer).window, Some(Window::Frames(1)));
    let (channel, open) = peer.open(5000);
    assert_eq!((open.name.as_str(), open.window), ("default", None));
    assert_eq!(take_all(&mut peer, channel), ["[(3.0, 0.0)]", "commit None"]);
    assert_eq!(client.finish().code, Some(0));
    // An explicit window must match.
    let daemon = FakeDaemon::new();
    let client = edges(folder.path(), "--window all --to").with(daemon.address()).start();
    let mut peer = daemon.greet();
    assert_eq!(refuse(&mut peer).window, Some(Window::All));
    drop(peer);
    client.finish().fails(1, &["does not open stream default: it has points:10"]);
}

#[test]
fn strict_stops_and_an_empty_input_fails() {
    let bad = folder(&[("1.png", Vec::new()), ("2.png", Gray::step(9, 1, 4, 200).png())]);
    for (path, arguments, code, words) in [
        (bad.path().to_owned(), "--strict --to", 3, "(--strict stops here)"),
        (bad.path().join("1.png"), "--to", 1, "nothing of the input could be used"),
    ] {
        let daemon = FakeDaemon::new();
        let client = edges(path, arguments).with(daemon.address()).start();
        let mut peer = daemon.greet();
        let (channel, _) = peer.open(5000);
        while let Some((_, message)) = peer.next() {
            match message {
                Message::Batch(Batch { sequence, .. }) => {
                    peer.send(channel, Accepted { sequence, points: 1, placed: Vec::new() })
                }
                Message::Commit(Commit { sequence, .. }) => peer.send(channel, Committed { sequence, frame: 1 }),
                Message::Close(_) => peer.send(channel, Closed { frame: 1 }),
                _ => {}
            }
        }
        client.finish().fails(code, &[words]);
    }
}
