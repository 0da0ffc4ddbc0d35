//! The pace of a peer's control messages: all but points, retractions and commits.
//!
//! In: each such message. Out: whether the peer has to rest before the next bytes are read.
//!
//! Invariants: a peer may send many at once, and then so many a second. What all peers send beyond that comes out of
//! one pool: a single flood is taken at a good pace, and a hundred together take no more than it. What is not taken
//! stays in the peer's own socket.
//!
//! Must not know: what messages ask for.

use std::time::{Duration, Instant};

use crate::daemon::locks::{Level, Lock};

/// Messages of a peer at once.
const BURST: f64 = 1024.0;

/// Messages of a peer a second after that.
const RATE: f64 = 64.0;

/// Messages of all peers beyond their own, at once and a second.
const POOL: f64 = 4096.0;

/// How many others a message counts for that is answered by a snapshot.
pub const SNAPSHOT: f64 = 2.0;

/// How long a peer waits that is ahead, so that waiting itself costs little.
pub const REST: Duration = Duration::from_millis(100);

/// Messages that may come, and more as time goes by.
#[derive(Debug)]
struct Bucket {
    left: f64,
    most: f64,
    rate: f64,
    counted: Instant,
}

impl Bucket {
    fn full(most: f64, rate: f64, now: Instant) -> Self {
        Self { left: most, most, rate, counted: now }
    }

    /// Takes so many out, if any are left.
    fn takes(&mut self, messages: f64, now: Instant) -> bool {
        let earned = self.rate * now.saturating_duration_since(self.counted).as_secs_f64();
        (self.left, self.counted) = (self.most.min(self.left + earned), now);
        let is_any_left = self.left > 0.0;
        if is_any_left {
            self.left -= messages;
        }
        is_any_left
    }
}

/// Messages of all peers beyond their own.
#[derive(Debug)]
pub struct ControlPool(Lock<Bucket>);

impl ControlPool {
    /// No message has come yet.
    pub fn new(now: Instant) -> Self {
        Self(Lock::new(Level::Leaf, Bucket::full(POOL, POOL, now)))
    }
}

/// Counts a peer's control messages.
#[derive(Debug)]
pub struct ControlPace(Bucket);

impl ControlPace {
    /// No message has come yet.
    pub fn new(now: Instant) -> Self {
        Self(Bucket::full(BURST, RATE, now))
    }

    /// Whether a message may be taken that counts for so many. If not, the peer has to rest before it.
    pub fn takes(&mut self, messages: f64, pool: &ControlPool, now: Instant) -> bool {
        self.0.takes(messages, now) || pool.0.lock().takes(messages, now)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Messages that so many peers may send in so many seconds, as many as they can.
    fn taken(peers: usize, seconds: u32) -> f64 {
        let begun = Instant::now();
        let pool = ControlPool::new(begun);
        let mut paces: Vec<ControlPace> = (0..peers).map(|_| ControlPace::new(begun)).collect();
        let (mut now, mut taken) = (begun, 0);
        while now < begun + Duration::from_secs(seconds.into()) {
            for pace in &mut paces {
                while pace.takes(1.0, &pool, now) {
                    taken += 1;
                }
            }
            now += REST;
        }
        f64::from(taken)
    }

    #[test]
    fn floods_have_their_own_messages_and_those_of_the_pool() {
        for (peers, seconds) in [(1, 10), (3, 5), (100, 20)] {
            let most = peers as f64 * (BURST + RATE * f64::from(seconds)) + POOL * f64::from(1 + seconds);
            let taken = taken(peers, seconds);
            assert!(taken <= most && taken >= 0.9 * most, "{peers} peers: {taken} of {most}");
        }
    }

    #[test]
    fn a_peer_beside_floods_is_taken_at_once() {
        let now = Instant::now();
        let (pool, mut flooding, mut other) = (ControlPool::new(now), ControlPace::new(now), ControlPace::new(now));
        while flooding.takes(1.0, &pool, now) {}
        assert!((0..500).all(|_| other.takes(SNAPSHOT, &pool, now)));
    }

    #[test]
    fn a_peer_that_rests_may_send_many_again() {
        let begun = Instant::now();
        let (pool, mut pace) = (ControlPool::new(begun), ControlPace::new(begun));
        while pace.takes(1.0, &pool, begun) {}
        assert!((0..1000).all(|_| pace.takes(1.0, &pool, begun + Duration::from_secs(60))));
    }
}
