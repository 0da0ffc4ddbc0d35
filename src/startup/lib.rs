//! Which standard streams were closed when the program started.
//!
//! In: nothing.
//! Out: yes or no.
//! Invariants: asked before the standard library starts. It opens /dev/null in the place of each standard stream that
//! is closed, and from then on nobody can tell that from a /dev/null that was meant: other programs hand on one that
//! looks the same. Only system calls are made, since nothing of the standard library may be relied on that early.
//! Must not know: what becomes of it.

#![no_std]

use core::sync::atomic::{AtomicBool, Ordering::Relaxed};

static IS_STDIN_CLOSED: AtomicBool = AtomicBool::new(false);
static IS_STDOUT_CLOSED: AtomicBool = AtomicBool::new(false);

/// Whether there was no stdin.
pub fn is_stdin_closed() -> bool {
    IS_STDIN_CLOSED.load(Relaxed)
}

/// Whether there was no stdout.
pub fn is_stdout_closed() -> bool {
    IS_STDOUT_CLOSED.load(Relaxed)
}

ctor::declarative::ctor! {
    #[ctor(unsafe)]
    fn note_closed() {
        let is_closed = |stream| rustix::io::fcntl_getfd(stream) == Err(rustix::io::Errno::BADF);
        IS_STDIN_CLOSED.store(is_closed(rustix::stdio::stdin()), Relaxed);
        IS_STDOUT_CLOSED.store(is_closed(rustix::stdio::stdout()), Relaxed);
    }
}
