//! The page behind a reverse proxy that shows it below a path, and strips that path before it asks the daemon.

use std::io::{Read, Write};
use std::net::{Shutdown, TcpListener, TcpStream};
use std::thread;

use hopes_protocol::*;
use tungstenite::ClientRequestBuilder;

use super::event_client::Events;
use super::page::{HttpClient, Page, Reply};
use crate::common::random::Random;

/// Below which the proxy shows the page.
const PREFIX: &str = "/hopes";

/// Where browsers find the proxy.
const ORIGIN: &str = "https://example.org";

/// What a proxy does with the host that it was asked for.
#[derive(Clone, Copy, Debug)]
enum Host {
    /// It passes it on.
    Kept,
    /// It asks for the daemon's own address.
    Replaced,
}

/// A proxy, until the process ends. Returns its address.
fn proxy(page: &Page, host: Host) -> String {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let address = listener.local_addr().unwrap().to_string();
    let daemon = page.host.clone();
    thread::spawn(move || {
        for client in listener.incoming().map_while(Result::ok) {
            let daemon = daemon.clone();
            thread::spawn(move || pass_on(client, &daemon, host));
        }
    });
    address
}

/// Passes a request on to the daemon, then all bytes in both directions.
fn pass_on(mut client: TcpStream, daemon: &str, host: Host) {
    let mut head = Vec::new();
    while !head.ends_with(b"\r\n\r\n") {
        let mut byte = [0];
        if client.read_exact(&mut byte).is_err() {
            return;
        }
        head.extend(byte);
    }
    let head = String::from_utf8(head).unwrap();
    let Some(below) = head.strip_prefix(&format!("GET {PREFIX}/")) else {
        client.write_all(b"HTTP/1.1 404 Not Found\r\nContent-Length: 0\r\n\r\n").unwrap();
        return;
    };
    let head = format!("GET /{below}");
    let head = match host {
        Host::Kept => head,
        Host::Replaced => head.replace("Host: example.org", &format!("Host: {daemon}")),
    };
    let mut server = TcpStream::connect(daemon).unwrap();
    server.write_all(head.as_bytes()).unwrap();
    let (mut from_client, mut to_server) = (client.try_clone().unwrap(), server.try_clone().unwrap());
    thread::spawn(move || {
        // Either side may end first.
        let _ = std::io::copy(&mut from_client, &mut to_server);
        let _ = to_server.shutdown(Shutdown::Write);
    });
    let _ = std::io::copy(&mut server, &mut client);
    let _ = client.shutdown(Shutdown::Both);
}

fn get(proxy: &str, path: &str) -> Reply {
    let mut client = HttpClient::at(proxy);
    client.send(format!("GET {path} HTTP/1.1\r\nHost: example.org\r\n\r\n").as_bytes());
    client.reply().unwrap()
}

/// Each with the option that lets it through.
const HOSTS: [(Host, &str); 3] = [
    (Host::Kept, "--view-host example.org"),
    (Host::Kept, "--view-origin https://example.org"),
    (Host::Replaced, "--view-origin https://example.org"),
];

#[test]
fn every_file_of_the_page_is_found_below_the_path() {
    for (host, option) in HOSTS {
        let page = Page::start(option);
        let proxy = proxy(&page, host);
        assert_eq!(get(&proxy, "/").status, 404, "the proxy has only the path");
        let mut files = vec![format!("{PREFIX}/")];
        let mut at = 0;
        while let Some(file) = files.get(at).cloned() {
            let text = String::from_utf8(get(&proxy, &file).ok()).unwrap();
            for named in super::answers::named_files(&file, &text) {
                if !files.contains(&named) {
                    files.push(named);
                }
            }
            at += 1;
        }
        assert!(files.len() > 20, "{files:?}");
        assert!(files.iter().all(|file| file.starts_with(&format!("{PREFIX}/"))), "{files:?}");
        page.daemon.stop();
    }
}

#[test]
fn the_api_is_there_below_the_path() {
    for (host, option) in HOSTS {
        let page = Page::start(option);
        let proxy = proxy(&page, host);
        page.daemon.producer("cam").frame(&[(0.0, 0.0), (1.0, 0.0)]);
        assert_eq!(get(&proxy, "/hopes/api/streams").json()["streams"][0]["info"]["points"], 2);
        assert_eq!(get(&proxy, "/hopes/api/streams/cam/snapshot").json()["points"], 2);
        get(&proxy, "/hopes/metrics").ok();
        assert_eq!(get(&proxy, "/hopes/healthz").ok(), b"ok\n");
        page.daemon.stop();
    }
}

#[test]
fn the_websocket_is_there_below_the_path() {
    for (host, option) in HOSTS {
        let page = Page::start(option);
        let proxy = proxy(&page, host);
        let mut producer = page.daemon.producer("cam");
        producer.frame(&crate::common::peers::points(&mut Random::new(3), 300));
        let connect = |origin: &str| {
            let request = ClientRequestBuilder::new("ws://example.org/hopes/ws".parse().unwrap())
                .with_header("Origin", origin)
                .with_sub_protocol("hopes");
            tungstenite::client(request, TcpStream::connect(&proxy).unwrap()).map_err(|error| error.to_string())
        };
        let (mut socket, answer) = connect(ORIGIN).unwrap();
        assert_eq!(answer.headers()["sec-websocket-protocol"], "hopes");
        let say = |channel, message: Message| encode(1, channel, &message).unwrap();
        let hello = Hello { software: "test".to_owned(), capabilities: vec![] }.into();
        let follow = crate::common::peers::subscribe("cam", crate::common::peers::FULL).into();
        let said = [&Banner { lowest: 1, highest: 1 }.encode()[..], &say(0, hello), &say(1, follow)].concat();
        socket.send(said.into()).unwrap();
        let (mut decoder, mut has_banner) = (Decoder::new(LARGEST_FRAME), false);
        let snapshot = 'received: loop {
            decoder.push(&socket.read().unwrap().into_data());
            has_banner = has_banner || decoder.banner().unwrap().is_some();
            while let Some(frame) = decoder.frame().unwrap() {
                if let Message::Snapshot(snapshot) = frame.message().unwrap() {
                    break 'received snapshot;
                }
            }
        };
        assert_eq!(snapshot.vertices.len(), 300);
        assert!(connect("https://evil.example").unwrap_err().contains("403"), "another origin");
        page.daemon.stop();
    }
}

#[test]
fn frames_come_as_events_below_the_path() {
    for (host, option) in HOSTS {
        let page = Page::start(option);
        let proxy = proxy(&page, host);
        let mut producer = page.daemon.producer("cam");
        producer.frame(&[(0.0, 0.0), (1.0, 0.0)]);
        let fields = format!("Origin: {ORIGIN}\r\n");
        let mut events = Events::at(&proxy, "example.org", "/hopes/api/streams/cam/frames", &fields);
        assert_eq!(events.due().frames(), (0, 1));
        producer.frame(&[(0.0, 1.0)]);
        assert_eq!(events.due().frames(), (0, 2));
        page.daemon.stop();
    }
}
