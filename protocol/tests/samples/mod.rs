//! What the tests of the protocol share: sample messages of every type, with names.
//!
//! In: nothing. Out: [`all`], the messages behind `vectors/v1`, always the same. Invariants: a sample is never changed or removed once its vector is written; every case of every
//! choice, options both ways, empty and other lists, and numbers on all borders of the encoding are among them; in the first sample of a type all fields differ,
//! so that fields in the wrong order show. Must not know: bytes.
#![allow(dead_code, missing_docs, reason = "each test binary uses a part")]

pub mod bad;
mod connection;
mod consumers;
pub mod files;
pub mod json;
mod producers;
pub mod random;

use hopes_protocol::{Checksum, Critical, Edge, Message, Vertex};

/// Numbers on both sides of each border of the encoding.
pub const BORDERS: [u64; 9] = [0, 250, 251, 65_535, 65_536, 0xFFFF_FFFF, 0x1_0000_0000, u64::MAX - 1, u64::MAX];

/// Numbers that are easily written or read with a bit too few.
pub const SPECIAL: [f64; 8] =
    [-0.0, 5e-324, -2.225_073_858_507_201e-308, f64::MIN_POSITIVE, f64::MAX, f64::MIN, f64::EPSILON, 0.1 + 0.2];

/// A message with a name of its own.
#[derive(Clone, Debug)]
pub struct Sample {
    pub name: &'static str,
    pub channel: u32,
    pub message: Message,
}

/// All of them.
pub fn all() -> Vec<Sample> {
    [connection::samples(), producers::samples(), consumers::samples()].concat()
}

fn sample(name: &'static str, channel: u32, body: impl Into<Message>) -> Sample {
    Sample { name, channel, message: body.into() }
}

/// What a skeleton proves itself with.
fn checksum(vertices: &[Vertex], edges: &[Edge], critical: &[Critical]) -> u64 {
    let mut checksum = Checksum::default();
    vertices.iter().for_each(|&vertex| checksum.add(vertex));
    edges.iter().for_each(|&edge| checksum.add(edge));
    critical.iter().for_each(|&critical| checksum.add(critical));
    checksum.0
}
