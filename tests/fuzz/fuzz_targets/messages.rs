//! Bodies of messages: what is read is written again, and a second codec agrees on every body.
//!
//! The input: a byte for the version, a byte for the type (its place in `Message::KINDS`), the body.
#![no_main]

use hopes_fuzz::second;
use hopes_protocol::{BodyError, Message, VERSION, encode_shared};
use libfuzzer_sys::fuzz_target;

fuzz_target!(|data: &[u8]| {
    let [version, kind, body @ ..] = data else { return };
    let (kind, _) = Message::KINDS[usize::from(*kind) % Message::KINDS.len()];
    let version = 1 + u16::from(*version) % VERSION;
    let read = Message::decode(version, kind, body);
    match (read, second::again(kind, body)) {
        (Ok(message), Ok(again)) => check(&message, &again, body),
        (Err(BodyError::UnknownType { .. }), _) => {
            assert!(version < VERSION, "the newest version has all messages")
        }
        (Err(_), Err(_)) => {}
        (read, again) => panic!("one codec reads it and one does not: {read:?}, {again:?}"),
    }
});

/// Numbers may be longer than they have to be in what is read, never in what is written.
fn check(message: &Message, again: &[u8], body: &[u8]) {
    let written = written(message);
    assert_eq!(written, again, "the codecs write {message:?} differently");
    assert!(written.len() < body.len() || written == body, "{message:?} is not read from its shortest form");
    let read = Message::decode(message.since(), message.kind(), &written).expect("what is written is read");
    // Not the messages: NaN differs from itself.
    assert_eq!(self::written(&read), written, "{message:?} changes on its way");
}

fn written(message: &Message) -> Vec<u8> {
    let sealed = encode_shared(message).expect("it is short");
    let (body, crc) = sealed.bytes.split_at(sealed.length as usize);
    assert_eq!(crc, crc32c::crc32c(body).to_le_bytes());
    body.to_vec()
}
