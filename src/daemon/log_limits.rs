//! Limits for log lines that peers can cause.
//!
//! In: the kind of a line, and whom it is about. Out: whether it is written, and how many like it were left out.
//!
//! Invariants: of a kind and a peer, some lines are written in a span of time; those left out are counted, and the next
//! line that is written tells their number. Memory is bounded: above so many kinds and peers, they share one limit.
//!
//! Must not know: what lines say.

use std::collections::HashMap;
use std::fmt;
use std::time::{Duration, Instant};

use super::locks::{Level, Lock};

/// Lines of a kind and a peer in one span.
const MOST: u32 = 10;

/// The span.
const SPAN: Duration = Duration::from_secs(10);

/// Kinds and peers that have a limit of their own.
const MOST_KEYS: usize = 1024;

/// Counts log lines.
#[derive(Debug)]
pub struct LogLimits(Lock<HashMap<(&'static str, String), Written>>);

#[derive(Debug)]
struct Written {
    since: Instant,
    lines: u32,
    left_out: u64,
}

/// What a line says at its end of those like it that were left out.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LeftOut(u64);

impl fmt::Display for LeftOut {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.0 {
            0 => Ok(()),
            1 => f.write_str(" (1 line like this was left out before)"),
            count => write!(f, " ({count} lines like this were left out before)"),
        }
    }
}

impl Default for LogLimits {
    fn default() -> Self {
        Self(Lock::new(Level::Leaf, HashMap::new()))
    }
}

impl LogLimits {
    /// Whether a line of this kind about this peer is written, and what it says of those that were left out.
    pub fn admits(&self, kind: &'static str, peer: &str) -> Option<LeftOut> {
        self.admits_at(kind, peer, Instant::now())
    }

    fn admits_at(&self, kind: &'static str, peer: &str, now: Instant) -> Option<LeftOut> {
        let mut written = self.0.lock();
        let is_over = |written: &Written| now.saturating_duration_since(written.since) >= SPAN;
        let mut key = (kind, peer.to_owned());
        if written.len() >= MOST_KEYS && !written.contains_key(&key) {
            written.retain(|_, written| !is_over(written) || written.left_out > 0);
            if written.len() >= MOST_KEYS {
                key = ("all others", String::new());
            }
        }
        let of_key = written.entry(key).or_insert(Written { since: now, lines: 0, left_out: 0 });
        if is_over(of_key) {
            (of_key.since, of_key.lines) = (now, 0);
        }
        if of_key.lines >= MOST {
            of_key.left_out += 1;
            return None;
        }
        of_key.lines += 1;
        Some(LeftOut(std::mem::take(&mut of_key.left_out)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_flood_of_one_kind_is_counted_and_leaves_others_their_lines() {
        let (limits, begun) = (LogLimits::default(), Instant::now());
        let written = (0..1000).filter_map(|_| limits.admits_at("a", "one", begun)).count();
        assert_eq!(written, 10);
        assert_eq!(limits.admits_at("b", "one", begun), Some(LeftOut(0)));
        assert_eq!(limits.admits_at("a", "other", begun), Some(LeftOut(0)));
        let later = limits.admits_at("a", "one", begun + SPAN).unwrap();
        assert_eq!(later.to_string(), " (990 lines like this were left out before)");
        assert_eq!(limits.admits_at("a", "one", begun + SPAN), Some(LeftOut(0)));
    }

    #[test]
    fn many_peers_share_one_limit() {
        let (limits, begun) = (LogLimits::default(), Instant::now());
        let written = (0..100_000).filter(|peer| limits.admits_at("a", &peer.to_string(), begun).is_some()).count();
        assert_eq!(written, MOST_KEYS + MOST as usize);
        assert!(limits.0.lock().len() <= MOST_KEYS + 1);
    }
}
