//! What the tests of the protocol share: sample messages of every type, with names.
//!
//! In: a version. Out: [`of`], the messages behind its folder of vectors, always the same. Invariants: a sample is never changed or removed once its vector is written; every case of every
//! choice, options both ways, empty and other lists, and numbers on all borders of the encoding are among them; in the first sample of a type all fields differ,
//! so that fields in the wrong order show. Must not know: bytes.
#![allow(dead_code, missing_docs, reason = "each test binary uses a part")]

pub mod bad;
mod bad_tracks;
mod connection;
mod consumers;
pub mod files;
pub mod json;
mod producers;
pub mod random;
mod tracks;

use hopes_protocol::{Checksum, Critical, Edge, Message, Vertex};

/// Versions of the protocol, each with a folder of vectors.
pub const VERSIONS: [u16; 2] = [1, 2];

/// Numbers on both sides of each border of the encoding.
pub const BORDERS: [u64; 9] = [0, 250, 251, 65_535, 65_536, 0xFFFF_FFFF, 0x1_0000_0000, u64::MAX - 1, u64::MAX];

/// Numbers that are easily written or read with a bit too few.
pub const SPECIAL: [f64; 8] =
    [-0.0, 5e-324, -2.225_073_858_507_201e-308, f64::MIN_POSITIVE, f64::MAX, f64::MIN, f64::EPSILON, 0.1 + 0.2];

/// A message with a name of its own.
#[derive(Clone, Debug)]
pub struct Sample {
    /// The version of its frame: the first that has its type, unless said otherwise.
    pub version: u16,
    pub name: &'static str,
    pub channel: u32,
    pub message: Message,
}

/// All of them.
pub fn all() -> Vec<Sample> {
    [connection::samples(), producers::samples(), consumers::samples(), tracks::samples()].concat()
}

/// Those in frames of a version.
pub fn of(version: u16) -> Vec<Sample> {
    all().into_iter().filter(|sample| sample.version == version).collect()
}

fn sample(name: &'static str, channel: u32, body: impl Into<Message>) -> Sample {
    let message = body.into();
    Sample { version: message.since(), name, channel, message }
}

/// What a skeleton proves itself with.
fn checksum(vertices: &[Vertex], edges: &[Edge], critical: &[Critical]) -> u64 {
    let mut checksum = Checksum::default();
    vertices.iter().for_each(|&vertex| checksum.add(vertex));
    edges.iter().for_each(|&edge| checksum.add(edge));
    critical.iter().for_each(|&critical| checksum.add(critical));
    checksum.0
}
