//! Streams that end while their readers flood the engine with requests.

use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::Duration;

use hopes_protocol::*;

use super::scene::{assert_ends_well, follow, stream_of, view};
use crate::common::client::bytes;
use crate::common::peers::{Daemon, ProducerAndConsumer, points};
use crate::common::random::Random;

#[test]
fn a_stream_ends_while_its_readers_change_their_views() {
    for round in 0..3 {
        let daemon = Daemon::start("");
        let (mut producer, _) = stream_of(&daemon, "cam", 5_000);
        let over = AtomicBool::new(false);
        thread::scope(|scope| {
            for reader in 0..4 {
                let (mut client, over) = (daemon.client(), &over);
                follow(&mut client, 1, "*", view(0));
                scope.spawn(move || {
                    for number in 0.. {
                        let change = ChangeView { view: view((number + 7 * reader) % 300), dots: DotsWanted::No };
                        let short = Duration::from_millis(50);
                        if over.load(Ordering::Acquire) || !client.try_write_for(&bytes(1, change), short) {
                            return;
                        }
                    }
                });
            }
            thread::sleep(Duration::from_millis(300));
            assert_eq!(producer.close(true), 1);
            over.store(true, Ordering::Release);
        });
        // The directory answers: the name is free, and another stream is served.
        ProducerAndConsumer::new(&daemon, &format!("beside{round}")).step();
        let (mut again, _) = stream_of(&daemon, "cam", 10);
        assert_eq!(again.close(true), 1);
        assert_ends_well(daemon, None);
    }
}

#[test]
fn many_readers_come_back_while_stdout_hangs() {
    let daemon = Daemon::start("--output jsonl --full --max-connections 600");
    let mut producer = daemon.producer("default");
    let mut random = Random::new(3);
    // Nobody reads stdout: the stream that it shows comes to a halt.
    for _ in 0..50 {
        producer.batch(&points(&mut random, 1_000));
        producer.commit();
    }
    let mut clients: Vec<_> = (0..256).map(|_| daemon.client()).collect();
    for _ in 0..3 {
        for client in &mut clients {
            follow(client, 1, "default", view(0));
            client.write(&bytes(1, Unsubscribe {}));
        }
    }
    ProducerAndConsumer::new(&daemon, "beside").step();
    let finished = assert_ends_well(daemon, None);
    assert!(finished.err.contains("the reader of stdout took nothing"), "{}", finished.err);
}
