//! What the fuzz targets share, and the private modules that they test.
//!
//! In: the source files of the program and of the second codec. Out: the same as modules of this crate.
//!
//! Invariants: nothing is public in the program for the sake of fuzzing. A module that is not named here is not
//! compiled. No target allocates more than [`MEMORY`] at a time: an allocation above it ends the process, and libFuzzer
//! keeps the input.
//!
//! Must not know: what the targets demand.
#![allow(dead_code, reason = "targets use a part of each module")]

pub mod pieces;
pub mod wire;

/// Bytes in use at one time at the most. Inputs have some KiB, buffers of readers 64 KiB, the trace of a panic 20 MiB.
pub const MEMORY: usize = 64 << 20;

#[global_allocator]
static ALLOCATOR: cap::Cap<std::alloc::System> = cap::Cap::new(std::alloc::System, MEMORY);

#[path = "../../../src/formats"]
pub mod formats {
    pub mod degrees;
    pub mod frame_line;
    pub mod input;
    pub mod messages;
    pub mod points;
    pub mod recording;
    pub mod short;

    pub mod tracks {
        pub mod frame;
        pub mod reader;
    }
}

/// What points are read into, and what counts memory.
#[path = "../../../src/daemon"]
pub mod daemon {
    mod memory;
    mod streams {
        pub mod input;
    }

    pub use memory::Charged;
    pub use streams::input::{Batch, Input, Point, Positions};
}

#[path = "../../../src/view"]
pub mod view {
    pub mod framing;
    pub mod http;
    pub mod names;
    pub mod query;
    pub mod snapshot;
}

#[path = "../../../protocol/tests/second/mod.rs"]
pub mod second;
