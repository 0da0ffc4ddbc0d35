//! Hostile peers on every kind of socket, while other peers are served as usual.

use hopes_protocol::*;

use crate::common::client::{Client, bytes, hello};
use crate::common::peers::{DERIVED, Daemon, ProducerAndConsumer, open, subscribe};
use crate::common::random::Random;

/// The most memory that a peer may make the daemon use. It starts with some 10 MB.
const MEMORY: u64 = 96 << 20;

/// Attacks daemons of both kinds, then checks them: other peers were served, nothing failed, and no memory was kept.
fn attack_daemons(attack: impl Fn(&Daemon)) {
    for daemon in [Daemon::start(""), Daemon::over_tcp("")] {
        ProducerAndConsumer::while_serving(&daemon, || attack(&daemon));
        #[cfg(target_os = "linux")]
        assert!(daemon.running.peak_memory() < MEMORY, "{} bytes", daemon.running.peak_memory());
        assert!(daemon.status().refused_messages > 0);
        daemon.stop();
    }
}

/// Everything that a client may send, in a valid order.
fn dialogue(name: &str) -> Vec<Vec<u8>> {
    let view = View { simplify: Simplify::Below(0.5), ..DERIVED };
    let points = vec![(0.5, 0.25), (1.5, f64::NAN), (2.0, 2.0)];
    let batch = Batch { sequence: 1, points: points.clone(), times: vec![1.0, 2.0, 3.0], tags: vec![7, 8, 9] };
    let resume = Some(Resume { epoch: 77, frame: 3 });
    vec![
        bytes(0, hello()),
        bytes(1, Open { window: Some(Window::Frames(3)), resolution: Some(0.5), ..open(name) }),
        bytes(1, batch),
        bytes(1, Commit { sequence: 2, time: Some(4.0) }),
        bytes(2, Subscribe { dots: DotsWanted::Top(3), resume, ..subscribe(name, DERIVED) }),
        bytes(1, Retract { sequence: 3, points }),
        bytes(2, ChangeView { view, dots: DotsWanted::All }),
        bytes(3, ListStreams { pattern: "*".to_owned() }),
        bytes(4, StatusWanted {}),
        bytes(2, Unsubscribe {}),
        bytes(1, Close { end: true }),
        bytes(0, Goodbye { reason: "done".to_owned(), streams: vec![("x".to_owned(), 1)] }),
    ]
}

/// Corrects the checksums of header and body.
fn sealed(frame: &mut Vec<u8>) {
    let kind = u16::from_le_bytes([frame[6], frame[7]]);
    let channel = u32::from_le_bytes([frame[8], frame[9], frame[10], frame[11]]);
    let body = frame[HEADER..frame.len() - 4].to_vec();
    let crc = super::handshake::crc32c(&body).to_le_bytes();
    *frame = [&header(VERSION, kind, channel, body.len() as u32)[..], &body, &crc].concat();
}

/// Changes something at a random position.
fn mutated(random: &mut Random, mut frame: Vec<u8>) -> Vec<u8> {
    let at = random.below(frame.len() as u64) as usize;
    match random.below(6) {
        0 => frame[at] ^= 1 << random.below(8),
        1 => frame.truncate(at),
        2 => frame[12..16].copy_from_slice(&(random.word() as u32).to_le_bytes()),
        // Such a frame arrives whole, but its content is wrong.
        3 if at >= HEADER => {
            frame[at] = random.word() as u8;
            sealed(&mut frame);
        }
        4 => {
            let length = frame.len().min(HEADER + at);
            frame.truncate(length.max(HEADER + 4));
            sealed(&mut frame);
        }
        _ => {
            let place = HEADER + random.below((frame.len() - HEADER - 3) as u64) as usize;
            // The largest number that a length can be.
            frame.splice(place..place, [253, 255, 255, 255, 255, 255, 255, 255, 127]);
            sealed(&mut frame);
        }
    }
    frame
}

#[test]
fn random_bytes() {
    attack_daemons(|daemon| {
        let mut random = Random::new(80);
        for round in 0..60 {
            let mut client = Client::without_banner(&daemon.address);
            if round % 3 > 0 {
                // Some clients exchange banners first.
                client.write(&Banner::OURS.encode());
            }
            if round % 3 > 1 {
                client.banner();
                client.hello();
            }
            let noise = random.bytes(1 << 16);
            // The daemon may close the connection as soon as it sees the error.
            let _ = client.try_write(&noise);
        }
    });
}

#[test]
fn dialogues_with_errors() {
    attack_daemons(|daemon| {
        let mut random = Random::new(81);
        for round in 0..300 {
            let mut all = Banner::OURS.encode().to_vec();
            let conversation = dialogue(&format!("stream {}", round % 7));
            let wrong = random.below(conversation.len() as u64) as usize;
            for (place, frame) in conversation.into_iter().enumerate() {
                all.extend(if place == wrong { mutated(&mut random, frame) } else { frame });
            }
            let mut client = Client::without_banner(&daemon.address);
            let _ = client.try_write(&all);
            if round % 2 == 0 {
                // All answers can be read, and the connection ends.
                client.shutdown_write();
                client.try_banner();
                client.rest();
            }
        }
    });
}

#[test]
fn announced_bodies_that_never_arrive() {
    attack_daemons(|daemon| {
        let clients: Vec<Client> = (0..100)
            .map(|_| {
                let mut client = daemon.client();
                // The largest allowed length is announced, and nothing of it is sent.
                client.write(&header(VERSION, 0x0103, 1, 1 << 22));
                client
            })
            .collect();
        let mut refused = daemon.client();
        assert_eq!(refused.is_refused(0, Close { end: true }), ErrorCode::NoChannel as u16);
        drop(clients);
    });
}

#[test]
fn many_silent_peers_and_many_that_do_not_read() {
    attack_daemons(|daemon| {
        let silent: Vec<Client> = (0..100).map(|_| Client::without_banner(&daemon.address)).collect();
        let mut deaf: Vec<Client> = (0..10).map(|_| daemon.client()).collect();
        // Every message is answered by an error, which nobody reads.
        let nonsense = bytes(5, Closed { frame: 1 }).repeat(1000);
        for client in &mut deaf {
            while client.socket.write_nonblocking(&nonsense).unwrap() > 0 {}
        }
        drop(silent);
    });
}
