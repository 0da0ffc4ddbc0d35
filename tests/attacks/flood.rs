//! Floods of requests.

use std::time::Duration;

use hopes_protocol::*;

use super::scene::{assert_beside_is_served, assert_ends_well, follow, stream_of, view};
use crate::common::client::{Client, bytes};
use crate::common::peers::{Daemon, Producer, points};
use crate::common::process::{eventually, hopes};
use crate::common::random::Random;

const LIMIT: u64 = 512 << 20;

/// So many changes of the view are about a megabyte.
const CHANGES: u32 = 22_000;

fn changes() -> Vec<u8> {
    let change = |number| bytes(1, ChangeView { view: view(number), dots: DotsWanted::All });
    (0..CHANGES).flat_map(change).collect()
}

fn flood(client: &mut Client, is_over: &dyn Fn() -> bool) {
    follow(client, 1, "cam", view(0));
    let changes = changes();
    while !is_over() {
        for some in changes.chunks(1 << 14) {
            if is_over() {
                return;
            }
            client.try_write_for(some, Duration::from_millis(50));
        }
    }
}

#[test]
fn changes_of_the_view_delay_no_other_stream() {
    let daemon = Daemon::start("--max-memory 512MiB");
    let (producer, _) = stream_of(&daemon, "cam", 20_000);
    let address = daemon.address.clone();
    assert_beside_is_served(&daemon, |is_over| flood(&mut Client::with_hello(&address), is_over));
    drop(producer);
    assert_ends_well(daemon, Some(LIMIT));
}

#[test]
fn changes_of_the_view_leave_the_streams_own_producer_its_share() {
    let daemon = Daemon::start("--max-memory 512MiB");
    let (mut producer, cloud) = stream_of(&daemon, "cam", 20_000);
    let mut client = daemon.client();
    follow(&mut client, 1, "cam", view(0));
    client.write(&changes());
    // All of it was sent before these commits, and none of them waits for all of it.
    let begun = std::time::Instant::now();
    for frame in 2..=20 {
        assert_eq!(producer.frame(&cloud[..10]), frame);
    }
    assert!(begun.elapsed() < Duration::from_secs(20), "19 commits took {:?}", begun.elapsed());
    // The last view that was asked for is the one that is followed in the end.
    let wanted = view(CHANGES - 1);
    loop {
        if let Message::Snapshot(snapshot) = client.receive_on(1)
            && snapshot.frame.view == wanted
        {
            break;
        }
    }
    assert_ends_well(daemon, Some(LIMIT));
}

#[test]
fn the_page_floods_no_better() {
    let folder = tempfile::tempdir().unwrap();
    let socket = folder.path().join("socket");
    let mut running = hopes("serve --max-memory 512MiB --view 127.0.0.1:0 --listen")
        .with(format!("unix:{}", socket.display()))
        .start();
    let log = running.until_log("the page is at http://");
    let place = log.rsplit_once("http://").unwrap().1.trim().trim_end_matches('/').to_owned();
    let daemon = Daemon { running, address: format!("unix:{}", socket.display()), folder };
    let (producer, _) = stream_of(&daemon, "cam", 20_000);
    assert_beside_is_served(&daemon, |is_over| flood(&mut Client::with_hello(&format!("ws:{place}")), is_over));
    drop(producer);
    assert_ends_well(daemon, Some(LIMIT));
}

#[test]
fn questions_without_end_are_answered_at_the_pace_of_their_reader() {
    let daemon = Daemon::start("--max-memory 64MiB");
    // Long answers: a list of many streams.
    let _producers: Vec<Producer> = (0..40).map(|number| daemon.producer(&format!("stream {number:0>80}"))).collect();
    let ask: Vec<u8> = (0..2000).flat_map(|_| bytes(1, StatusWanted {})).collect();
    let mut attackers: Vec<Client> = (0..8).map(|_| daemon.client()).collect();
    for client in &mut attackers {
        client.try_write_for(&ask, Duration::from_millis(200));
    }
    let mut asking = daemon.client();
    let held = |client: &mut Client| match client.ask(9, GetMemory {}) {
        Message::Memory(memory) => memory.peers,
        other => panic!("{other:?}"),
    };
    // A soft limit of a megabyte each.
    let most = 10 * (1 << 20) + 20 * (1 << 17);
    assert!(held(&mut asking) < most, "{} bytes are held for peers", held(&mut asking));
    // Who reads gets everything after all.
    let mut answers = 0;
    while answers < 100 {
        answers += usize::from(matches!(attackers[0].receive(), Some((1, Message::Status(_)))));
    }
    assert_ends_well(daemon, Some(64 << 20));
}

#[test]
fn views_are_bounded() {
    let daemon = Daemon::start("--max-views 20 --max-peer-views 16");
    let (mut producer, _) = stream_of(&daemon, "cam", 100);
    let mut first = daemon.client();
    for channel in 1..=16 {
        follow(&mut first, channel, "cam", view(channel));
    }
    assert_eq!(
        first.is_refused(
            17,
            Subscribe { pattern: "cam".to_owned(), view: view(17), dots: DotsWanted::No, resume: None }
        ),
        ErrorCode::TooManyViews as u16
    );
    let mut snapshots = 0;
    while snapshots < 16 {
        snapshots += usize::from(matches!(first.receive(), Some((_, Message::Snapshot(_)))));
    }
    // Another peer may follow four more, and those that the first one follows.
    let mut second = daemon.client();
    for channel in 1..=5 {
        follow(&mut second, channel, "cam", view(100 + channel));
    }
    let refused = eventually("the fifth is refused", || match second.receive() {
        Some((5, Message::Error(report))) => Some(report),
        _ => None,
    });
    assert_eq!((refused.code, refused.answers), (ErrorCode::TooManyViews as u16, 0x0201));
    assert!(matches!(second.receive_on(5), Message::StreamClosed(_)));
    follow(&mut second, 6, "cam", view(3));
    eventually("a view that is there is followed", || {
        matches!(second.receive(), Some((6, Message::Snapshot(_)))).then_some(())
    });
    // A view that is left makes room for another one.
    second.write(&bytes(4, ChangeView { view: view(200), dots: DotsWanted::No }));
    eventually("the view is changed", || match second.receive() {
        Some((4, Message::Snapshot(snapshot))) => (snapshot.frame.view == view(200)).then_some(()),
        _ => None,
    });
    producer.frame(&points(&mut Random::new(1), 10));
    assert_ends_well(daemon, None);
}
