//! Idle streams and connections: heartbeats, timeouts, and their cost.

use std::thread;
use std::time::{Duration, Instant};

use hopes_protocol::*;

use crate::common::client::{Client, Socket, bytes};
use crate::common::peers::{Consumer, DERIVED, Daemon, FULL, ProducerAndConsumer, subscribe};

const HASTY: &str = "--heartbeat 200ms --timeout 1s";

#[test]
fn an_idle_stream_sends_heartbeats() {
    let daemon = Daemon::start("--heartbeat 50ms");
    let mut producer = daemon.producer("cam");
    let mut consumer = daemon.consumer("cam", FULL);
    let stream = consumer.opened.stream;
    let heartbeat = |consumer: &mut Consumer| loop {
        match consumer.client.next() {
            Some((Consumer::CHANNEL, Message::Heartbeat(heartbeat))) => return heartbeat,
            Some((Consumer::CHANNEL, Message::Snapshot(_))) | Some((0, Message::Ping(_))) => {}
            other => panic!("{other:?}"),
        }
    };
    assert_eq!(heartbeat(&mut consumer), Heartbeat { stream, frame: 0 });
    producer.frame(&[(0.0, 0.0)]);
    while heartbeat(&mut consumer).frame == 0 {}
    assert_eq!(heartbeat(&mut consumer), Heartbeat { stream, frame: 1 });
    daemon.stop();
}

#[test]
fn a_client_that_does_not_answer_pings_is_disconnected() {
    for daemon in [Daemon::start(HASTY), Daemon::over_tcp(HASTY)] {
        let began = Instant::now();
        let (mut answers, mut silent) = (daemon.client(), daemon.client());
        thread::scope(|scope| {
            scope.spawn(|| {
                // For three times as long as the other client has, only pings are answered.
                while began.elapsed() < Duration::from_secs(3) {
                    match answers.next() {
                        Some((0, Message::Ping(Ping { token }))) => answers.send(0, Pong { token }),
                        other => panic!("{other:?}"),
                    }
                }
                answers.ping();
            });
            let (pings, code) = read_until_timeout(&mut silent);
            assert!(pings >= 2, "{pings} pings");
            assert_eq!(code, ErrorCode::TooSlow as u16);
            assert!(began.elapsed() >= Duration::from_secs(1), "{:?}", began.elapsed());
        });
        daemon.stop();
    }
}

#[test]
fn a_busy_consumer_that_sends_nothing_stays_connected() {
    let daemon = Daemon::start(HASTY);
    let began = Instant::now();
    ProducerAndConsumer::while_serving(&daemon, || {
        let mut listener = daemon.consumer("beside", FULL);
        // Frames arrive all the time, so no ping is due on this connection.
        while began.elapsed() < Duration::from_secs(3) {
            listener.next();
        }
    });
    daemon.stop();
}

/// Reads pings without answering until the daemon closes the connection. Returns their number and the code of the last
/// error.
fn read_until_timeout(client: &mut Client) -> (usize, u16) {
    let mut rest: Vec<Message> = std::iter::from_fn(|| client.next()).map(|(_, message)| message).collect();
    assert!(matches!(rest.pop(), Some(Message::Goodbye(_))));
    let code = match rest.pop() {
        Some(Message::Error(report)) => report.code,
        other => panic!("{other:?}"),
    };
    assert!(rest.iter().all(|message| matches!(message, Message::Ping(_))), "{rest:?}");
    (rest.len(), code)
}

#[test]
fn a_client_that_never_sends_anything_is_disconnected() {
    for daemon in [Daemon::start(HASTY), Daemon::over_tcp(HASTY)] {
        ProducerAndConsumer::while_serving(&daemon, || {
            let mut nothing = Client::without_banner(&daemon.address);
            nothing.banner();
            let mut no_hello = Client::new(&daemon.address);
            assert_eq!(read_until_timeout(&mut nothing).1, ErrorCode::TooSlow as u16);
            assert_eq!(read_until_timeout(&mut no_hello).1, ErrorCode::TooSlow as u16);
        });
        daemon.stop();
    }
}

#[test]
fn a_client_that_sends_byte_by_byte_is_disconnected() {
    for daemon in [Daemon::start(HASTY), Daemon::over_tcp(HASTY)] {
        // One client never finishes its banner, the other never finishes its message.
        let open = bytes(1, Open { name: "x".repeat(200), window: None, resolution: None });
        ProducerAndConsumer::while_serving(&daemon, || {
            let banner = Banner::OURS.encode().to_vec();
            for (mut client, bytes) in [(Client::without_banner(&daemon.address), banner), (daemon.client(), open)] {
                let mut bytes = bytes.into_iter();
                // Often enough that the connection is never idle, until the daemon closes it.
                while bytes.next().is_some_and(|byte| client.try_write(&[byte]).is_ok()) {
                    thread::sleep(Duration::from_millis(100));
                }
                assert!(bytes.len() > 0, "it came to the end");
                if matches!(client.socket, Socket::Unix(_)) {
                    // Over TCP, data in flight may be lost when the connection breaks.
                    client.expect_too_slow();
                }
            }
        });
        daemon.stop();
    }
}

impl Client {
    fn expect_too_slow(&mut self) {
        let _ = self.try_banner();
        assert_eq!(read_until_timeout(self).1, ErrorCode::TooSlow as u16);
    }
}

#[test]
fn a_client_that_never_reads_is_disconnected() {
    for daemon in [Daemon::start(HASTY), Daemon::over_tcp(HASTY)] {
        ProducerAndConsumer::while_serving(&daemon, || {
            let mut deaf = daemon.client();
            // Each of these is answered until sockets are full. Then nothing more is read, and at last the connection
            // ends.
            let asked = [bytes(0, Ping { token: 1 }), bytes(9, StatusWanted {})].concat().repeat(100);
            while deaf.try_write_for(&asked, Duration::from_millis(100)) {}
        });
        daemon.stop();
    }
}

#[test]
#[cfg(target_os = "linux")]
fn an_idle_daemon_uses_no_processor_time() {
    let daemon = Daemon::start("--heartbeat 5s --timeout 60s --stream cam");
    let mut producer = daemon.producer("cam");
    producer.frame(&[(0.0, 0.0), (1.0, 0.0)]);
    let mut consumers: Vec<Consumer> = (0..20).map(|_| daemon.consumer("cam", DERIVED)).collect();
    for consumer in &mut consumers {
        consumer.expect_snapshot(Cause::Start);
    }
    let mut later = daemon.client();
    later.send(1, subscribe("nothing", FULL));
    later.ping();
    let before = daemon.running.ticks();
    thread::sleep(Duration::from_secs(1));
    let spent = daemon.running.ticks() - before;
    assert!(spent < 5, "{spent} ticks");
    daemon.stop();
}
