//! Sample messages of every type, with names. The protocol's tests share them.
//!
//! In: a version. Out: [`of`]: the messages of the version's folder of vectors, always the same.
//!
//! Invariants: a sample does not change and is not removed once its vector is written. The samples include every case
//! of every enum, options with and without a value, empty and filled lists, and numbers at all borders of the encoding.
//! In the first sample of a type all fields differ, so that a wrong order of fields is detected.
//!
//! Must not know: bytes.
#![allow(dead_code, missing_docs, reason = "each test binary uses a part")]

mod admin;
pub mod bad;
mod bad_admin;
mod bad_spaces;
mod bad_tracks;
mod connection;
mod consumers;
pub mod files;
pub mod json;
mod producers;
pub mod random;
mod spaces;
mod tracks;

use hopes_protocol::{Checksum, Critical, Edge, Message, Vertex};

/// The versions of the protocol. Each has a folder of vectors.
pub const VERSIONS: [u16; 4] = [1, 2, 3, 4];

/// Numbers on both sides of each border of the encoding.
pub const BORDERS: [u64; 9] = [0, 250, 251, 65_535, 65_536, 0xFFFF_FFFF, 0x1_0000_0000, u64::MAX - 1, u64::MAX];

/// Numbers that an inexact writer or reader would change.
pub const SPECIAL: [f64; 8] =
    [-0.0, 5e-324, -2.225_073_858_507_201e-308, f64::MIN_POSITIVE, f64::MAX, f64::MIN, f64::EPSILON, 0.1 + 0.2];

/// A message with a name of its own.
#[derive(Clone, Debug)]
pub struct Sample {
    /// The version of its frame: the first version with its type, unless set otherwise.
    pub version: u16,
    pub name: &'static str,
    pub channel: u32,
    pub message: Message,
}

/// All samples.
pub fn all() -> Vec<Sample> {
    let of_version_1 = [connection::samples(), producers::samples(), consumers::samples()].concat();
    [of_version_1, tracks::samples(), admin::samples(), spaces::samples()].concat()
}

/// The samples in frames of a version.
pub fn of(version: u16) -> Vec<Sample> {
    all().into_iter().filter(|sample| sample.version == version).collect()
}

fn sample(name: &'static str, channel: u32, body: impl Into<Message>) -> Sample {
    let message = body.into();
    Sample { version: message.since(), name, channel, message }
}

/// The checksum of a skeleton.
fn checksum(vertices: &[Vertex], edges: &[Edge], critical: &[Critical]) -> u64 {
    let mut checksum = Checksum::default();
    vertices.iter().for_each(|&vertex| checksum.add(vertex));
    edges.iter().for_each(|&edge| checksum.add(edge));
    critical.iter().for_each(|&critical| checksum.add(critical));
    checksum.0
}
