//! Requests that are refused: of other origins, for other hosts, of other machines, and invalid ones.

use rustix::process::Signal;

use super::page::{HttpClient, Page, Reply, listening_page};
use crate::common::peers::assert_clean_exit;
use crate::common::process::hopes;

fn request(page: &Page, path: &str, fields: &str) -> Reply {
    page.request(&format!("GET {path} HTTP/1.1\r\n{fields}\r\n"))
}

const UPGRADE: &str = "Upgrade: websocket\r\nConnection: keep-alive, Upgrade\r\nSec-WebSocket-Version: 13\r\n\
    Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n";

#[test]
fn only_requests_for_its_own_hosts_are_answered() {
    let page = Page::start("");
    let port = page.port();
    for host in ["localhost", "127.0.0.1", "[::1]", "LocalHost"] {
        request(&page, "/healthz", &format!("Host: {host}:{port}\r\n")).ok();
    }
    let other = if port == "4242" { "4243" } else { "4242" };
    for host in [
        format!("evil.example:{port}"),
        format!("evil.example.localhost:{port}"),
        format!("localhost:{other}"),
        format!("localhost.evil.example:{port}"),
        format!("user@localhost:{port}"),
        format!("192.0.2.1:{port}"),
        "localhost".to_owned(),
        "127.0.0.1".to_owned(),
        String::new(),
    ] {
        for path in ["/", "/healthz", "/metrics", "/api/streams", "/ws", "/nowhere"] {
            let refused = request(&page, path, &format!("Host: {host}\r\n"));
            refused.is_refused(421, "this server is not");
            refused.is_refused(421, "--view-host");
        }
    }
    request(&page, "/healthz", "").is_refused(400, "needs one Host field");
    let twice = format!("Host: localhost:{port}\r\nHost: localhost:{port}\r\n");
    request(&page, "/healthz", &twice).is_refused(400, "needs one Host field");
    page.daemon.stop();
}

#[test]
fn requests_of_other_origins_are_refused() {
    let page = Page::start("");
    let (host, port) = (&page.host, page.port());
    for origin in [
        "http://evil.example",
        "null",
        "http://127.0.0.1",
        "http://127.0.0.1:1",
        &format!("http://localhost:{port}"),
        &format!("http://evil.example:{port}"),
        &format!("http://{host}.evil.example"),
        &format!("ftp://{host}"),
        &format!("http://{host}/"),
    ] {
        for path in ["/", "/api/streams", "/metrics"] {
            let refused = request(&page, path, &format!("Host: {host}\r\nOrigin: {origin}\r\n"));
            refused.is_refused(403, "Origin");
            refused.is_refused(403, "--view-origin");
        }
        request(&page, "/ws", &format!("Host: {host}\r\nOrigin: {origin}\r\n{UPGRADE}")).is_refused(403, "Origin");
    }
    let own = format!("Host: {host}\r\nOrigin: http://{host}\r\n");
    request(&page, "/api/streams", &own).ok();
    request(&page, "/api/streams", &format!("{own}Origin: http://{host}\r\n")).is_refused(403, "Origin");
    // A request without an Origin does not prove that it is from the own page.
    request(&page, "/ws", &format!("Host: {host}\r\n{UPGRADE}")).is_refused(403, "Origin is missing");
    page.daemon.stop();
}

#[test]
fn invalid_requests_for_a_websocket_are_refused() {
    let page = Page::start("");
    let own = format!("Host: {0}\r\nOrigin: http://{0}\r\n", page.host);
    let plain = request(&page, "/ws", &own);
    plain.is_refused(426, "request an upgrade");
    assert_eq!((plain.field("upgrade"), plain.field("sec-websocket-version")), ("websocket", "13"));
    for (instead, of, status, words) in [
        ("Version: 8", "Version: 13", 426, "is 13"),
        ("Upgrade: h2c", "Upgrade: websocket", 426, "request an upgrade"),
        ("Connection: close", "Connection: keep-alive, Upgrade", 426, "request an upgrade"),
        ("c2hvcnQ=", "dGhlIHNhbXBsZSBub25jZQ==", 400, "16 bytes"),
        ("????", "dGhlIHNhbXBsZSBub25jZQ==", 400, "16 bytes"),
        ("Version: 13\r\nSec-WebSocket-Protocol: chat, hope", "Version: 13", 400, "hopes"),
    ] {
        assert!(UPGRADE.contains(of));
        let fields = format!("{own}{}", UPGRADE.replace(of, instead));
        request(&page, "/ws", &fields).is_refused(status, words);
    }
    page.daemon.stop();
}

#[test]
fn nothing_can_be_changed() {
    let page = Page::start("");
    for method in ["POST", "PUT", "DELETE", "PATCH", "OPTIONS", "CONNECT", "TRACE", "get"] {
        let body = "x".repeat(5000);
        let request =
            format!("{method} /api/streams HTTP/1.1\r\nHost: {}\r\nContent-Length: 5000\r\n\r\n{body}", page.host);
        let answer = page.request(&request);
        answer.is_refused(405, "GET and HEAD");
        assert_eq!(answer.field("allow"), "GET, HEAD");
    }
    page.daemon.stop();
}

#[test]
fn invalid_requests_are_refused() {
    let page = Page::start("");
    for request in [
        "hello\r\n\r\n".to_owned(),
        "GET / HTTP/3.0\r\n\r\n".to_owned(),
        "GET http://localhost/ HTTP/1.1\r\n\r\n".to_owned(),
        "GET * HTTP/1.1\r\n\r\n".to_owned(),
        "\u{16}\u{3}\u{1}\u{2}\u{0}\u{1}".to_owned(),
        "HOPES\u{0}\u{1}\u{0}\u{2}\u{0}\r\n\r\n".to_owned(),
    ] {
        assert_eq!(page.request(&request).status, 400, "{request:?}");
    }
    let long = format!("GET /{} HTTP/1.1\r\n\r\n", "a".repeat(17 << 10));
    page.request(&long).is_refused(431, "16384 bytes");
    let endless = format!("GET / HTTP/1.1\r\nX: {}", "a".repeat(17 << 10));
    page.request(&endless).is_refused(431, "16384 bytes");
    let many = format!("GET / HTTP/1.1\r\n{}\r\n", "X: y\r\n".repeat(65));
    page.request(&many).is_refused(431, "64 fields");
    page.daemon.stop();
}

#[test]
fn remote_clients_must_be_allowed() {
    for address in ["0.0.0.0:0", "[::]:0"] {
        let serve = hopes("serve --view").with(address);
        serve.runs().fails(1, &["can be reached from other machines", "--allow-remote", address]);
    }
    let mut running = hopes("serve --view 0.0.0.0:0 --allow-remote --view-host Lab.example --view-host box:99").start();
    let host = listening_page(&mut running);
    let port = host.rsplit_once(':').unwrap().1;
    let ask = |name: &str| {
        let mut client = HttpClient::at(&format!("127.0.0.1:{port}"));
        client.send(format!("GET /healthz HTTP/1.1\r\nHost: {name}\r\nOrigin: https://{name}\r\n\r\n").as_bytes());
        client.reply().unwrap().status
    };
    let found =
        ["lab.example", "LAB.example:PORT", "box:99", "127.0.0.1:PORT", "evil.example:PORT", "box", "0.0.0.0:PORT"]
            .map(|name| ask(&name.replace("PORT", port)));
    assert_eq!(found, [200, 200, 200, 200, 421, 421, 421]);
    running.signal(Signal::TERM);
    assert_clean_exit(running.ends());
}

#[test]
fn a_name_alone_opens_nothing_to_other_machines() {
    let page = Page::start("--view-host lab --view-origin https://Example.org --view-origin http://box:99");
    for (host, origin, status) in [
        ("lab", "http://lab", 200),
        ("example.org", "https://example.org", 200),
        (&page.host[..], "https://example.org", 200),
        (&page.host[..], "http://box:99", 200),
        (&page.host[..], "http://lab", 403),
        (&page.host[..], "http://box", 403),
        ("example.org", "https://evil.example", 403),
        ("evil.example", "https://evil.example", 421),
        ("evil.example", "https://example.org", 421),
    ] {
        let fields = format!("Host: {host}\r\nOrigin: {origin}\r\n");
        assert_eq!(request(&page, "/api/streams", &fields).status, status, "{host} {origin}");
        let upgraded = request(&page, "/ws", &format!("{fields}Upgrade: nothing\r\n"));
        // What is no WebSocket is refused only after its host and origin were found right.
        assert_eq!(upgraded.status, if status == 200 { 426 } else { status }, "{host} {origin}");
    }
    let port = page.port().to_owned();
    page.daemon.stop();
    for address in ["0.0.0.0", "[::]"] {
        let serve = hopes("serve --view-host lab --view-origin https://lab --view").with(format!("{address}:{port}"));
        serve.runs().fails(1, &["can be reached from other machines", "--allow-remote"]);
    }
}

#[test]
fn invalid_options_are_usage_errors() {
    for (arguments, words) in [
        ("serve --view nowhere", "is no HOST:PORT"),
        ("serve --view http://127.0.0.1:8080", "is no HOST:PORT"),
        ("serve --view-host lab", "--view"),
        ("serve --view-origin https://lab", "--view"),
        ("serve --view 127.0.0.1:0 --view-host http://lab", "is no name of a host"),
        ("serve --view 127.0.0.1:0 --view-origin lab", "is no origin: write it as https://example.org"),
        ("serve --view 127.0.0.1:0 --view-origin https://lab/hopes/", "without a path"),
    ] {
        hopes(arguments).runs().fails(2, &[words]);
    }
    let page = Page::start("");
    let again = hopes("serve --view").with(&page.host).runs();
    again.fails(1, &["another daemon is listening", &page.host]);
    page.daemon.stop();
}
