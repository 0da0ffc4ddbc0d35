//! Requests of HTTP: the head, its host and origin, the query of a snapshot, the encoding of names. A refusal is a
//! response that cannot be taken for two.
//!
//! The input: two bytes for the length of the part that arrives first, then the request.
#![no_main]

use hopes_fuzz::view::http::{MAX_HEAD, Refusal, Request, Response};
use hopes_fuzz::view::names::Names;
use hopes_fuzz::view::query::decoded;
use hopes_fuzz::view::snapshot::{Format, SnapshotRequest};
use hopes_protocol::Cut;
use libfuzzer_sys::fuzz_target;

/// The address to which clients have connected, and its other names.
const HOSTS: [&str; 3] = ["127.0.0.1:8080", "localhost:8080", "[::1]:8080"];

fuzz_target!(|data: &[u8]| {
    let Some((cut, bytes)) = data.split_first_chunk() else { return };
    let whole = Request::parse(bytes);
    let first = Request::parse(&bytes[..bytes.len().min(u16::from_le_bytes(*cut).into())]);
    match (&first, &whole) {
        (Ok(None), _) | (Err(_), Err(_)) => {}
        (Ok(Some(first)), Ok(Some(whole))) => assert_eq!(format!("{first:?}"), format!("{whole:?}")),
        _ => panic!("what came later changes {first:?} to {whole:?}"),
    }
    match whole {
        Ok(Some((request, length))) => {
            assert!(length <= bytes.len().min(MAX_HEAD) && request.path.starts_with('/'));
            check_origin(&request);
            check_query(request.query.as_deref().unwrap_or_default());
            let _ = decoded(&request.path);
        }
        Ok(None) => assert!(bytes.len() < MAX_HEAD),
        Err(refusal) => check_refusal(refusal),
    }
    if let Ok(text) = str::from_utf8(bytes) {
        check_query(text);
        let encoded: String = text.bytes().map(|byte| format!("%{byte:02x}")).collect();
        assert_eq!(decoded(&encoded).as_deref(), Ok(text));
    }
});

fn check_origin(request: &Request) {
    let (names, local) = (Names::new(&[], &[]), HOSTS[0].parse().expect("this is an address"));
    let [lenient, strict] =
        [false, true].map(|needs_origin| names.check(request, local, needs_origin).map_err(check_refusal));
    assert!(strict.is_err() || lenient.is_ok(), "an origin does no harm");
    if lenient.is_ok() {
        let host = request.header("host").unwrap_or_default().to_ascii_lowercase();
        assert!(HOSTS.contains(&host.as_str()), "{request:?}");
        let origin = request.header("origin").map(str::to_ascii_lowercase);
        let is_own = origin
            .as_ref()
            .is_some_and(|origin| [format!("http://{host}"), format!("https://{host}")].contains(origin));
        assert!(is_own || strict.is_err() && origin.is_none() && !request.has("origin"), "{request:?}");
    }
}

/// What a query asks for can be asked for in so many words.
fn check_query(query: &str) {
    let Ok(request) = SnapshotRequest::parse(query) else { return };
    let view = match request.view.cut {
        Cut::Full => "full".to_owned(),
        Cut::Reduced(alpha) => format!("alpha={alpha:?}"),
        Cut::Derived(k, l) => format!("k={k}&l={l}"),
    };
    let format = match request.format {
        Format::Json => "json",
        Format::GeoJson => "geojson",
        Format::Svg => "svg",
    };
    assert_eq!(SnapshotRequest::parse(&format!("{view}&format={format}")), Ok(request));
}

/// One head of plain fields, and a body of the length that it says.
fn check_refusal(refusal: Refusal) {
    let (head, body) = Response::from(refusal).encode(false);
    let head = str::from_utf8(&head).expect("a head is text");
    assert!(head.starts_with("HTTP/1.1 4") && head.is_ascii(), "{head}");
    assert_eq!(head.find("\r\n\r\n"), Some(head.len() - 4), "{head}");
    let length = head.lines().find_map(|line| line.strip_prefix("Content-Length: ")).expect("it has a length");
    assert_eq!(length.parse(), Ok(body.len()), "{head}");
}
