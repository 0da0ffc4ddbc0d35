//! Locks that are taken in one order, and never held by a thread that waits.
//!
//! In: a value and its [`Level`]. Out: guards; a panic, in debug builds, for a thread that breaks a rule.
//!
//! Invariants:
//! * A thread takes locks in the order of their levels, never two of one level. So no two threads wait for each other.
//! * A thread that waits for a queue, a socket or another thread holds no lock: whoever may wait calls
//!   [`before_waiting`] first. The one exception is a condition, which gives back its own lock while it waits.
//! * A panic of another thread does no harm: the guarded values are whole between any two statements, so a poisoned
//!   lock guards whole data.
//!
//! Must not know: what is guarded.

use std::ops::{Deref, DerefMut};
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError, TryLockError};
use std::thread;
use std::time::{Duration, Instant};

/// The places of locks in the order in which one thread may take them: from the first to the last.
///
/// `daemon/mod.rs` tells what each guards, and which are held together.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Level {
    /// The directory's watchers and engines.
    Directory,
    /// The connections of a registry.
    Members,
    /// Streams by name.
    Roster,
    /// The producers of a stream.
    Producers,
    /// What waits for an engine.
    Queue,
    /// The cursors of a connection.
    Cursors,
    /// What a subscription wants of streams that come later.
    Wanted,
    /// The requests of consumers to an engine.
    Requests,
    /// A consumer's position.
    Cursor,
    /// What a stream has published: the log of a view or of tracks, dots.
    Published,
    /// Answers to a peer.
    Outbox,
    /// The state of a transport within another protocol.
    Transport,
    /// Values that are read and written in one statement: times, labels, counts.
    Leaf,
}

/// A value that one thread at a time may use.
#[derive(Debug)]
pub struct Lock<T> {
    level: Level,
    value: Mutex<T>,
}

/// The use of a locked value, until this is dropped.
#[derive(Debug)]
pub struct Guard<'a, T> {
    /// Dropped before `held`: fields are dropped in order.
    guard: MutexGuard<'a, T>,
    held: held::Held,
}

impl<T> Lock<T> {
    /// A value at its place in the order.
    pub const fn new(level: Level, value: T) -> Self {
        Self { level, value: Mutex::new(value) }
    }

    /// Waits until no other thread uses the value.
    pub fn lock(&self) -> Guard<'_, T> {
        // Before the wait: a thread that would wait for itself is told so.
        let held = held::Held::new(self.level);
        Guard { guard: self.value.lock().unwrap_or_else(PoisonError::into_inner), held }
    }

    /// As [`lock`](Self::lock), but gives up after `patience`.
    pub fn lock_within(&self, patience: Duration) -> Option<Guard<'_, T>> {
        const STEP: Duration = Duration::from_millis(1);
        let held = held::Held::new(self.level);
        let deadline = Instant::now() + patience;
        loop {
            match self.value.try_lock() {
                Ok(guard) => return Some(Guard { guard, held }),
                Err(TryLockError::Poisoned(error)) => return Some(Guard { guard: error.into_inner(), held }),
                Err(TryLockError::WouldBlock) if Instant::now() < deadline => thread::sleep(STEP),
                Err(TryLockError::WouldBlock) => return None,
            }
        }
    }
}

impl<T> Guard<'_, T> {
    /// Waits for a condition. The value may be used by others meanwhile. No other lock may be held.
    pub fn wait(self, condition: &Condvar) -> Self {
        let Self { guard, held } = self;
        held.check_is_only();
        Self { guard: condition.wait(guard).unwrap_or_else(PoisonError::into_inner), held }
    }
}

impl<T> Deref for Guard<'_, T> {
    type Target = T;

    fn deref(&self) -> &T {
        &self.guard
    }
}

impl<T> DerefMut for Guard<'_, T> {
    fn deref_mut(&mut self) -> &mut T {
        &mut self.guard
    }
}

/// A thread is about to wait for something that another one does.
///
/// # Panics
/// In debug builds, if it holds a lock.
pub fn before_waiting(what: &str) {
    held::check_none(what);
}

/// What this thread holds, in debug builds.
#[cfg(debug_assertions)]
mod held {
    use std::cell::RefCell;

    use super::Level;

    thread_local! {
        static LEVELS: RefCell<Vec<Level>> = const { RefCell::new(Vec::new()) };
    }

    #[derive(Debug)]
    pub struct Held(Level);

    impl Held {
        pub fn new(level: Level) -> Self {
            LEVELS.with_borrow_mut(|levels| {
                let last = levels.iter().max();
                let is_in_order = last.is_none_or(|&last| last < level);
                assert!(is_in_order, "a lock of level {level:?} is taken under {levels:?}: see daemon/locks.rs");
                levels.push(level);
            });
            Self(level)
        }

        pub fn check_is_only(&self) {
            LEVELS.with_borrow(|levels| {
                assert!(levels.len() == 1, "a thread waits for a condition and holds {levels:?}: see daemon/locks.rs");
            });
        }
    }

    impl Drop for Held {
        fn drop(&mut self) {
            LEVELS.with_borrow_mut(|levels| {
                if let Some(place) = levels.iter().rposition(|level| *level == self.0) {
                    levels.remove(place);
                }
            });
        }
    }

    pub fn check_none(what: &str) {
        LEVELS.with_borrow(|levels| {
            assert!(levels.is_empty(), "a thread waits for {what} and holds {levels:?}: see daemon/locks.rs");
        });
    }
}

/// Nothing is recorded in release builds.
#[cfg(not(debug_assertions))]
mod held {
    use super::Level;

    #[derive(Debug)]
    pub struct Held;

    impl Held {
        #[inline]
        pub fn new(_: Level) -> Self {
            Self
        }

        #[inline]
        pub fn check_is_only(&self) {}
    }

    #[inline]
    pub fn check_none(_: &str) {}
}

#[cfg(all(test, debug_assertions))]
mod tests {
    use std::panic::{AssertUnwindSafe, catch_unwind};

    use super::*;

    /// What the thread is told that does this.
    fn objection(deed: impl FnOnce()) -> Option<String> {
        let panic = catch_unwind(AssertUnwindSafe(deed)).err()?;
        Some(*panic.downcast::<String>().expect("a panic with a text"))
    }

    #[test]
    fn locks_are_taken_in_order() {
        let (first, second) = (Lock::new(Level::Directory, 1), Lock::new(Level::Cursor, 2));
        assert_eq!(objection(|| assert_eq!(*first.lock() + *second.lock(), 3)), None);
        let planted = objection(|| {
            let _second = second.lock();
            drop(first.lock());
        });
        assert!(planted.unwrap().contains("Directory is taken under [Cursor]"));
    }

    #[test]
    fn two_locks_of_one_level_are_not_held_together() {
        let cursors = [1, 2].map(|value| Lock::new(Level::Cursor, value));
        let planted = objection(|| assert_eq!(*cursors[0].lock() + *cursors[1].lock(), 3));
        assert!(planted.unwrap().contains("Cursor is taken under [Cursor]"));
    }

    #[test]
    fn nobody_waits_who_holds_a_lock() {
        let lock = Lock::new(Level::Cursors, ());
        assert_eq!(objection(|| before_waiting("a queue")), None);
        let planted = objection(|| {
            let _held = lock.lock();
            before_waiting("a queue");
        });
        assert!(planted.unwrap().contains("waits for a queue and holds [Cursors]"));
        // A panic gives back what was held.
        assert_eq!(objection(|| before_waiting("a queue")), None);
    }

    #[test]
    fn a_condition_gives_back_its_own_lock_and_no_other() {
        let (other, lock, condition) = (Lock::new(Level::Directory, ()), Lock::new(Level::Queue, 0), Condvar::new());
        thread::scope(|scope| {
            scope.spawn(|| {
                *lock.lock() = 1;
                condition.notify_all();
            });
            let mut value = lock.lock();
            while *value == 0 {
                value = value.wait(&condition);
            }
        });
        let planted = objection(|| {
            let _other = other.lock();
            drop(lock.lock().wait(&condition));
        });
        assert!(planted.unwrap().contains("waits for a condition and holds [Directory, Queue]"));
    }

    #[test]
    fn a_lock_that_is_not_given_back_is_given_up() {
        let lock = Lock::new(Level::Directory, ());
        thread::scope(|scope| {
            let held = lock.lock();
            let waiting = scope.spawn(|| lock.lock_within(Duration::from_millis(5)).is_some());
            assert!(!waiting.join().unwrap());
            drop(held);
        });
        assert!(lock.lock_within(Duration::ZERO).is_some());
    }
}
