//! Counts bytes, and those that stand after the data.
//!
//! In: how many bytes have come, and how many of them belonged to nothing.
//! Out: what is said of those.
//! Must not know: formats.

use super::found::counted;

/// Bytes so far.
#[derive(Debug, Default)]
pub struct Tail {
    all: u64,
    left: u64,
}

impl Tail {
    pub fn add(&mut self, bytes: usize) {
        self.all += bytes as u64;
    }

    /// The last ones of them belong to nothing.
    pub fn leave(&mut self, bytes: usize) {
        self.left += bytes as u64;
    }

    pub fn all(&self) -> u64 {
        self.all
    }

    /// That something stands after the data.
    pub fn report(&self, data: &str) -> Option<String> {
        let from = self.all - self.left;
        let bytes = counted(self.left, "byte");
        (self.left > 0).then(|| format!("{bytes} after the {data}, from byte {from} on, were not read"))
    }
}
