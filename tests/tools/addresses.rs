//! Commands without an address: the variable, the user's own socket, and who may write there.

use std::fs::Permissions;
use std::os::unix::fs::{MetadataExt, PermissionsExt};
use std::path::Path;

use rustix::process::Signal;

use crate::common::process::{Hopes, Running, hopes};

/// A command in an environment whose folders are all in one.
fn at_home(arguments: &str, home: &Path) -> Hopes {
    hopes(arguments).set("XDG_RUNTIME_DIR", "").set("TMPDIR", home).set("HOPES_ADDRESS", "")
}

fn listening(serve: &Hopes, address: &str) -> Running {
    let mut daemon = serve.start();
    daemon.until_log(&format!("listening at {address}"));
    daemon
}

fn end(daemon: Running) {
    daemon.signal(Signal::TERM);
    assert_eq!(daemon.finish().code, Some(0));
}

/// A square, to the stream `cam`.
fn feeds(feed: Hopes) {
    let fed = feed.reads("0,0\n2,0\n2,2\n0,2\n");
    assert!(fed.err.contains("stream cam: 4 points accepted"), "{}", fed.err);
    fed.out();
}

#[test]
fn all_clients_find_the_daemon_of_the_variable() {
    let home = tempfile::tempdir().unwrap();
    let address = format!("unix:{}", home.path().join("named.sock").display());
    let client = |arguments: &str| at_home(arguments, home.path()).set("HOPES_ADDRESS", &address);
    let daemon = listening(&client("serve --listen"), &address);
    feeds(client("feed - --stream cam"));
    assert!(client("status").runs().text().contains("cam"));
    let watched = client("watch --stream cam --frames 1").runs().text();
    assert!(watched.starts_with("cam  frame 1 "), "{watched}");
    assert!(client("record --stream cam --frames 1 -o -").runs().out().len() > 100);
    client("disconnect 99999").runs().fails(1, &["99999"]);
    let picture = client("edges tests/data/edges/text.png --stream pictures --to").runs();
    assert!(picture.err.contains("stream pictures: "), "{}", picture.err);
    assert!(client("stop-stream cam").runs().text().contains("stream cam has ended after frame 1"));
    // What is given comes before the variable.
    client("status --connect unix:/none/x").runs().fails(1, &["unix:/none/x"]);
    end(daemon);
}

#[test]
fn without_a_variable_there_is_a_socket_of_ones_own() {
    let home = tempfile::tempdir().unwrap();
    let user = std::fs::metadata(home.path()).unwrap().uid();
    let session = tempfile::tempdir().unwrap();
    let of_session = |arguments: &str| at_home(arguments, home.path()).set("XDG_RUNTIME_DIR", session.path());
    let in_temporary = |arguments: &str| at_home(arguments, home.path());
    let folder = home.path().join(format!("hopes-{user}"));
    let clients: [&dyn Fn(&str) -> Hopes; 2] = [&of_session, &in_temporary];
    for (client, folder) in clients.into_iter().zip([session.path(), &folder]) {
        let socket = folder.join("hopes.sock");
        let daemon = listening(&client("serve --listen"), &format!("unix:{}", socket.display()));
        assert_eq!(std::fs::metadata(&socket).unwrap().mode() & 0o777, 0o600);
        feeds(client("feed - --stream cam"));
        assert!(client("watch --stream cam --frames 1").runs().text().starts_with("cam  frame 1 "));
        end(daemon);
        client("status").runs().fails(1, &["cannot connect to", "hopes.sock", "hopes serve --listen"]);
    }
    assert_eq!(std::fs::metadata(&folder).unwrap().mode() & 0o777, 0o700, "nobody else may come near the socket");
}

#[test]
fn a_folder_that_others_can_write_to_is_refused() {
    let home = tempfile::tempdir().unwrap();
    let user = std::fs::metadata(home.path()).unwrap().uid();
    let folder = home.path().join(format!("hopes-{user}"));
    std::fs::create_dir(&folder).unwrap();
    std::fs::set_permissions(&folder, Permissions::from_mode(0o777)).unwrap();
    for command in ["watch", "status", "feed -", "record -o -", "serve --listen", "stop-stream cam"] {
        let words = [folder.to_str().unwrap(), "you alone may write to", "HOPES_ADDRESS"];
        at_home(command, home.path()).runs().fails(2, &words);
    }
}

#[test]
fn a_variable_that_is_no_address_is_named() {
    let home = tempfile::tempdir().unwrap();
    for word in ["nowhere", "unix:", "http://x"] {
        let status = at_home("status", home.path()).set("HOPES_ADDRESS", word);
        status.runs().fails(2, &["HOPES_ADDRESS: ", word, "write unix:PATH or tcp:HOST:PORT"]);
    }
}

#[test]
fn watch_names_the_streams_that_are_there() {
    let home = tempfile::tempdir().unwrap();
    let client = |arguments: &str| at_home(arguments, home.path()).set("XDG_RUNTIME_DIR", home.path());
    let daemon = listening(&client("serve --listen"), "unix:");
    feeds(client("feed - --stream cam"));
    for (wanted, says) in [("came", "there is no stream came, it has"), ("scan*", "no stream matches scan*, it has")] {
        let mut watch = client("watch --stream").with(wanted).start();
        let line = watch.until_log(says);
        assert!(line.contains("cam") && line.contains("waiting for it"), "{line}");
        watch.signal(Signal::INT);
        assert_eq!(watch.finish().code, Some(0));
    }
    // It comes after all.
    let mut watch = client("watch --stream late --frames 1").start();
    watch.until_log("there is no stream late");
    let late = client("feed - --stream late").reads("0,0\n1,0\n");
    assert_eq!(late.code, Some(0), "{}", late.err);
    assert!(watch.finish().text().starts_with("late  frame 1 "));
    end(daemon);
}
