//! Clients that are stopped (SIGSTOP) for longer than any timeout, and go on: the time does not count, and a daemon
//! that has given them up is told from one that is gone.

use std::thread;
use std::time::Duration;

use hopes_protocol::*;
use rustix::process::Signal;

use crate::common::fake_daemon::{FakeDaemon, Peer, welcome};
use crate::common::growing_stream::GrowingStream;
use crate::common::peers::{Daemon, FULL};
use crate::common::process::{Running, hopes};

/// What the daemon announces.
const TIMEOUT: Duration = Duration::from_millis(1500);

/// Longer than that.
const LONG: Duration = Duration::from_secs(4);

fn patient() -> Welcome {
    Welcome { timeout_ms: TIMEOUT.as_millis() as u32, ..welcome() }
}

/// The token of pings.
const LAST: u64 = 100;

/// Stops a program for a long time.
fn stop(client: &Running, meanwhile: impl FnOnce()) {
    client.signal(Signal::STOP);
    meanwhile();
    thread::sleep(LONG);
    client.signal(Signal::CONT);
}

/// What a daemon does that keeps a peer which does not answer: nothing, or what it always does.
fn ways() -> [fn(&mut Peer); 2] {
    [|_| (), |peer| (0..3).for_each(|_| peer.send(0, Ping { token: LAST }))]
}

#[test]
fn a_consumer_goes_on() {
    for (program, meanwhile) in ["watch --output jsonl", "record -o -"].into_iter().zip(ways()) {
        let daemon = FakeDaemon::new();
        let client = hopes(program).and("--from").with(daemon.address()).start();
        let mut peer = daemon.greet_as(patient());
        let (channel, _) = peer.expect_subscribe();
        let mut scene = GrowingStream::new(3);
        peer.send(channel, scene.opened("default", 7));
        peer.send(channel, scene.snapshot(Cause::Start));
        peer.ping_and_wait(99);
        stop(&client, || meanwhile(&mut peer));
        peer.send(channel, scene.diff());
        peer.ping_and_wait(LAST);
        peer.goodbye(&[("default", 2)]);
        let finished = client.finish();
        assert_eq!(finished.code, Some(0), "{program}: {}", finished.err);
        assert!(finished.err.contains("stream default: the last frame is 2"), "{program}: {}", finished.err);
    }
}

#[test]
fn a_producer_goes_on() {
    for meanwhile in ways() {
        let daemon = FakeDaemon::new();
        let mut client = hopes("feed - --to").with(daemon.address()).start();
        client.say("1,2\n");
        let mut peer = daemon.greet_as(patient());
        let (channel, _) = peer.open(5000);
        assert!(matches!(peer.next(), Some((_, Message::Batch(_)))));
        stop(&client, || meanwhile(&mut peer));
        peer.send(channel, Accepted { sequence: 0, points: 1, placed: Vec::new() });
        peer.ping_and_wait(LAST);
        drop(client.take_stdin());
        // Pongs may come between.
        let next = |peer: &mut Peer| std::iter::from_fn(|| peer.next()).find(|(on, _)| *on == channel);
        assert!(matches!(next(&mut peer), Some((_, Message::Commit(_)))));
        peer.send(channel, Committed { sequence: 1, frame: 1 });
        assert_eq!(next(&mut peer), Some((channel, Close { end: false }.into())));
        peer.send(channel, Closed { frame: 1 });
        peer.expect_goodbye();
        let finished = client.finish();
        assert_eq!(finished.code, Some(0), "{}", finished.err);
    }
}

#[test]
fn a_producer_that_is_stopped_within_a_message_goes_on() {
    let daemon = FakeDaemon::new();
    let mut client = hopes("feed - --input jsonl --to").with(daemon.address()).start();
    let line = format!("{{\"points\":{:?}}}\n", vec![[0.25, 0.5]; 4096]);
    let mut stdin = client.take_stdin();
    // More than the socket's buffers hold.
    let feeder = thread::spawn(move || drop(std::io::Write::write_all(&mut stdin, line.repeat(100).as_bytes())));
    let mut peer = daemon.greet_as(patient());
    let (channel, _) = peer.open(5000);
    thread::sleep(Duration::from_millis(500));
    stop(&client, || ());
    let mut points = 0;
    while points < 100 * 4096 {
        match peer.next() {
            Some((0, _)) => {}
            Some((_, Message::Batch(Batch { sequence, points: sent, .. }))) => {
                points += sent.len();
                peer.send(channel, Accepted { sequence, points: sent.len() as u32, placed: Vec::new() });
            }
            other => panic!("{other:?}"),
        }
    }
    feeder.join().unwrap();
    assert!(client.is_alive());
}

#[test]
fn a_greeting_goes_on() {
    let daemon = FakeDaemon::new();
    let client = hopes("status --from").with(daemon.address()).start();
    let mut peer = daemon.accept();
    assert_eq!(peer.banner(), Banner::OURS);
    // A greeting may take ten seconds.
    client.signal(Signal::STOP);
    thread::sleep(Duration::from_secs(11));
    client.signal(Signal::CONT);
    thread::sleep(Duration::from_millis(500));
    peer.write(&Banner::OURS.encode());
    assert!(matches!(peer.next(), Some((0, Message::Hello(_)))));
    peer.send(0, welcome());
    assert!(matches!(peer.next(), Some((_, Message::GetStatus(_)))));
}

// ---- a real daemon

#[test]
fn a_daemon_with_patience_keeps_a_client_that_is_stopped() {
    let daemon = Daemon::start("--heartbeat 200ms --timeout 60s");
    let mut producer = daemon.producer("cam");
    producer.frame(&[(0.0, 0.0)]);
    let mut client = hopes("watch --output jsonl --stream cam --frames 2 --from").with(&daemon.address).start();
    assert!(client.line().is_some());
    stop(&client, || ());
    producer.frame(&[(1.0, 1.0)]);
    assert!(client.line().unwrap().contains("\"frame\":2"));
    assert_eq!(client.finish().code, Some(0));
    daemon.stop();
}

#[test]
fn a_client_that_the_daemon_has_given_up_says_so() {
    for daemon in [Daemon::start("--timeout 2s"), Daemon::over_tcp("--timeout 2s")] {
        let mut producer = daemon.producer("cam");
        producer.frame(&[(0.0, 0.0)]);
        let mut other = daemon.producer("fed");
        let mut consumer = daemon.consumer("fed", FULL);
        let mut watching = hopes("watch --output jsonl --stream cam --from").with(&daemon.address).start();
        let mut returning =
            hopes("watch --reconnect --output jsonl --stream cam --frames 2 --from").with(&daemon.address).start();
        let mut feeding = hopes("feed - --stream fed --to").with(&daemon.address).start();
        feeding.say("1,2\n\n");
        for client in [&mut watching, &mut returning] {
            assert!(client.line().is_some());
        }
        consumer.follow_to(1);
        let clients = [&watching, &returning, &feeding];
        clients.iter().for_each(|client| client.signal(Signal::STOP));
        // The test's own clients answer meanwhile.
        for _ in 0..12 {
            thread::sleep(Duration::from_millis(400));
            producer.client.ping();
            other.client.ping();
            consumer.client.ping();
        }
        clients.iter().for_each(|client| client.signal(Signal::CONT));
        let words = ["has ended the connection, since this program was stopped or blocked for", "longer than 2 s"];
        for (client, sums_up) in [(watching, ""), (feeding, "1 points accepted, 0 refused")] {
            let finished = client.ends();
            assert_eq!(finished.code, Some(1), "{}", finished.err);
            let all = words.into_iter().chain([sums_up]);
            all.for_each(|word| assert!(finished.err.contains(word), "{word}: {}", finished.err));
        }
        returning.until_log(words[0]);
        producer.frame(&[(1.0, 1.0)]);
        assert!(returning.line().unwrap().contains("\"frame\":2"));
        assert_eq!(returning.finish().code, Some(0));
        daemon.stop();
    }
}
