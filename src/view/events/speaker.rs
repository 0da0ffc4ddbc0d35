//! The words of a consumer that speaks for a client of events.
//!
//! In: what the client wants, answers to the daemon. Out: bytes of the protocol, as the daemon's reader takes them.
//! Invariants: the daemon reads banner, `Hello` and `Subscribe` first, and its end only after all that was said.
//! Must not know: the client.

use std::collections::VecDeque;
use std::io::Read;

use hopes_protocol::{Banner, DotsWanted, Hello, Message, Subscribe, encode};

use super::FramesRequest;

/// The channel of the subscription.
const CHANNEL: u32 = 1;

/// What is said to the daemon in answer to its messages.
#[derive(Debug, Default)]
pub struct Answers {
    /// Bytes of the protocol.
    pub bytes: Vec<u8>,
    /// The conversation is over.
    pub is_over: bool,
}

/// What the daemon has not read yet.
#[derive(Debug)]
pub struct Speaker {
    bytes: VecDeque<u8>,
    is_over: bool,
    /// Bytes that the client has sent after its request.
    heard: usize,
}

impl Speaker {
    /// A consumer that begins to speak.
    pub fn new(request: &FramesRequest) -> Self {
        let resume = request.last.filter(|_| request.changes);
        let hello = Hello { software: "server-sent events".to_owned(), capabilities: Vec::new() };
        let subscribe = Subscribe { pattern: request.name.clone(), view: request.view, dots: DotsWanted::No, resume };
        let said = [Banner::OURS.encode().to_vec(), encoded(0, hello.into()), encoded(CHANNEL, subscribe.into())];
        Self { bytes: said.concat().into(), is_over: false, heard: 0 }
    }

    /// Moves what was said to the front of a buffer. Returns its length: 0 at the end, none if nothing is said now.
    pub fn take(&mut self, buffer: &mut [u8]) -> Option<usize> {
        // Reading from memory does not fail.
        let length = self.bytes.read(buffer).unwrap_or(0);
        (length > 0 || self.is_over).then_some(length)
    }

    /// Says more.
    pub fn say(&mut self, answers: Answers) {
        self.bytes.extend(answers.bytes);
        self.is_over |= answers.is_over;
    }

    /// The client has sent so many bytes. Returns how many it has sent by now.
    pub fn hear(&mut self, bytes: usize) -> usize {
        self.heard = self.heard.saturating_add(bytes);
        self.heard
    }
}

/// A message of a version that every daemon speaks. It is small, so it can be encoded.
pub fn encoded(channel: u32, message: Message) -> Vec<u8> {
    encode(Banner::OURS.highest, channel, &message).unwrap_or_default()
}
