//! Listening addresses: which sockets are replaced, and who may connect.

use std::fs;
use std::os::unix::fs::PermissionsExt;

use hopes_protocol::Cause;
use rustix::process::Signal;

use crate::common::client::Client;
use crate::common::peers::{
    Consumer, Daemon, FULL, Producer, assert_clean_exit, listening, open, serve_at, socket_in, subscribe,
};
use crate::common::process::hopes;

#[test]
fn only_the_owner_may_use_the_socket() {
    let daemon = Daemon::start("");
    assert_eq!(fs::metadata(daemon.socket()).unwrap().permissions().mode() & 0o777, 0o600);
    let beside = fs::read_dir(daemon.folder.path()).unwrap().count();
    assert_eq!(beside, 1, "nothing else is left there");
    daemon.stop();
}

#[test]
fn the_socket_of_a_daemon_that_was_killed_is_replaced() {
    let mut daemon = Daemon::start("");
    daemon.running.signal(Signal::KILL);
    let folder = daemon.folder;
    assert_eq!(daemon.running.ends().code, None);
    assert!(socket_in(&folder).exists(), "it could not remove it");
    daemon.running = serve_at(&socket_in(&folder)).start();
    let address = listening(&mut daemon.running);
    assert_eq!(address, daemon.address);
    Client::with_hello(&address).ping();
    daemon.running.signal(Signal::TERM);
    assert_clean_exit(daemon.running.ends());
    assert!(!socket_in(&folder).exists());
}

#[test]
fn the_socket_of_a_running_daemon_is_not_replaced() {
    let daemon = Daemon::start("");
    let mut client = daemon.client();
    serve_at(&daemon.socket()).runs().fails(1, &["another daemon is listening at", &daemon.address]);
    client.ping();
    daemon.client().ping();
    daemon.stop();
    let daemon = Daemon::over_tcp("");
    hopes("serve --listen").with(&daemon.address).runs().fails(1, &["another daemon is listening at", &daemon.address]);
    daemon.client().ping();
    daemon.stop();
}

#[test]
fn a_file_is_not_replaced_by_a_socket() {
    let folder = tempfile::tempdir().unwrap();
    let path = socket_in(&folder);
    fs::write(&path, "precious").unwrap();
    serve_at(&path).runs().fails(1, &["is there and no socket", path.to_str().unwrap()]);
    assert_eq!(fs::read_to_string(&path).unwrap(), "precious");
    let nowhere = folder.path().join("no/such/folder");
    serve_at(&nowhere).runs().fails(1, &["cannot listen at", "no/such/folder"]);
    // If a second address fails, the socket of the first one is removed.
    let first = folder.path().join("first");
    serve_at(&first).with("--listen").with(format!("unix:{}", path.display())).runs().fails(1, &["no socket"]);
}

#[test]
fn a_socket_that_another_process_has_replaced_is_not_removed() {
    let folder = tempfile::tempdir().unwrap();
    let path = socket_in(&folder);
    let mut first = serve_at(&path).start();
    listening(&mut first);
    fs::rename(&path, folder.path().join("moved")).unwrap();
    let mut second = serve_at(&path).start();
    let address = listening(&mut second);
    first.signal(Signal::TERM);
    assert_clean_exit(first.ends());
    Client::with_hello(&address).ping();
    second.signal(Signal::TERM);
    assert_clean_exit(second.ends());
    assert!(!path.exists());
}

#[test]
fn other_machines_need_permission() {
    for place in ["tcp:0.0.0.0:0", "tcp:[::]:0"] {
        let serve = hopes("serve --listen").with(place);
        serve.runs().fails(1, &["can be reached from other machines", "--allow-remote", place]);
    }
    let mut running = hopes("serve --listen tcp:0.0.0.0:0 --allow-remote").start();
    let address = listening(&mut running);
    let (_, port) = address.rsplit_once(':').unwrap();
    Client::with_hello(&format!("tcp:127.0.0.1:{port}")).ping();
    running.signal(Signal::TERM);
    assert_clean_exit(running.ends());
}

#[test]
fn invalid_arguments_are_wrong_usage() {
    for (arguments, words) in [
        ("serve --listen nowhere", "is no address: write unix:PATH"),
        ("serve --listen tcp:127.0.0.1", "is no address"),
        ("serve --allow-remote", "--listen"),
        ("serve --stream cam", "--listen"),
        ("serve --listen unix:x --stream a*", "is no name"),
        ("serve --listen unix:x --max-memory lots", "is no unit: there are KiB"),
        ("serve --listen unix:x --max-batch 0", "--max-batch"),
        ("serve --listen unix:x --overload panic", "drop-oldest"),
        ("serve --listen unix:x --timeout never", "--timeout"),
    ] {
        hopes(arguments).runs().fails(2, &[words]);
    }
    let twice = hopes("serve --listen tcp:127.0.0.1:0 --stream cam --stream cam").runs();
    twice.fails(1, &["\"cam\" is there already"]);
}

#[test]
fn all_addresses_serve_the_same_streams() {
    let mut daemon = Daemon::start("--listen tcp:127.0.0.1:0 --listen tcp:[::1]:0");
    let mut addresses = vec![daemon.address.clone()];
    addresses.extend((0..2).map(|_| listening(&mut daemon.running)));
    assert_eq!(addresses[1..].iter().filter(|address| address.starts_with("tcp:")).count(), 2, "{addresses:?}");
    let mut producers: Vec<Producer> =
        addresses.iter().map(|address| Producer::open(Client::with_hello(address), open("cam"))).collect();
    let mut consumers: Vec<Consumer> = addresses
        .iter()
        .map(|address| Consumer::subscribe(Client::with_hello(address), subscribe("cam", FULL)))
        .collect();
    for (number, producer) in (1..).zip(&mut producers) {
        assert_eq!(producer.frame(&[(number as f64, 0.0)]), number);
        for consumer in &mut consumers {
            match number {
                1 => assert_eq!(consumer.expect_snapshot(Cause::Start), 1),
                _ => assert_eq!(consumer.expect_diff(number).vertices_added.len(), 1),
            }
        }
    }
    daemon.stop();
}
