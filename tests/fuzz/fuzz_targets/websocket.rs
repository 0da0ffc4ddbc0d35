//! Frames of a WebSocket's client: however they are cut, the same payload, requests and errors come out; and what a
//! client has put into frames comes out.
//!
//! The input: a byte for options, four lengths of pieces, then frames or a payload.
#![no_main]

use hopes_fuzz::pieces::Pieces;
use hopes_fuzz::view::framing::{ControlRequests, FrameDecoder, FramingError};
use libfuzzer_sys::fuzz_target;
use tungstenite::protocol::frame::FrameHeader;
use tungstenite::protocol::frame::coding::{Control, Data, OpCode};

type Found = (Vec<u8>, ControlRequests, Option<FramingError>);

fuzz_target!(|data: &[u8]| {
    let Some((options, data)) = data.split_first() else { return };
    let Some((pieces, bytes)) = Pieces::of(data) else { return };
    if options & 1 == 0 {
        any_bytes(pieces, bytes);
    } else {
        a_payload(pieces, bytes, options >> 1);
    }
});

fn any_bytes(pieces: Pieces<'_>, bytes: &[u8]) {
    // Byte by byte, nothing that precedes an error is lost with it.
    let (payload, requests, error) = decode(bytes.chunks(1));
    for (found, its_requests, its_error) in [decode(pieces), decode([bytes].into_iter())] {
        assert!(payload.starts_with(&found) && (error.is_some() || found == payload), "{found:?} of {payload:?}");
        assert_eq!((its_requests, its_error), (requests.clone(), error));
    }
}

/// A message in fragments, with a ping behind each but the last.
fn a_payload(pieces: Pieces<'_>, payload: &[u8], first: u8) {
    let (one, other) = payload.split_at(payload.len().min(first.into()));
    let sent = [
        frame(OpCode::Data(Data::Binary), false, one),
        frame(OpCode::Control(Control::Ping), true, &one[..one.len().min(125)]),
        frame(OpCode::Data(Data::Continue), true, other),
    ];
    let (found, requests, error) = decode(pieces.over(&sent.concat()));
    assert_eq!((&found[..], error), (payload, None));
    assert_eq!(requests, ControlRequests { ping: Some(one[..one.len().min(125)].to_vec()), is_closed: false });
}

fn frame(opcode: OpCode, is_final: bool, payload: &[u8]) -> Vec<u8> {
    let mask = [0x5a, payload.len() as u8, 0xff, 1];
    let header = FrameHeader { is_final, opcode, mask: Some(mask), ..FrameHeader::default() };
    let mut bytes = Vec::new();
    header.format(payload.len() as u64, &mut bytes).expect("memory takes it");
    bytes.extend(payload.iter().zip(mask.iter().cycle()).map(|(byte, mask)| byte ^ mask));
    bytes
}

fn decode<'a>(pieces: impl Iterator<Item = &'a [u8]>) -> Found {
    let (mut decoder, mut requests, mut all) = (FrameDecoder::default(), ControlRequests::default(), Vec::new());
    for piece in pieces {
        let mut bytes = piece.to_vec();
        match decoder.decode(&mut bytes, &mut requests) {
            Ok(length) => all.extend_from_slice(&bytes[..length]),
            Err(error) => return (all, requests, Some(error)),
        }
    }
    (all, requests, None)
}
