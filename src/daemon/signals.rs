//! Ctrl-C and SIGTERM as events.
//!
//! In: signals of the process. Out: a channel with the signal's name.
//! Invariants: the first signal requests an end in
//! good order. A second one, of either kind, ends the process at once, with the usual exit code 128 + number. Must not
//! know: what an end in good order is.

use std::io;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use crossbeam_channel::{Receiver, bounded};
use signal_hook::consts::{SIGINT, SIGTERM};
use signal_hook::flag;
use signal_hook::iterator::Signals;

/// A channel that receives the name of the first signal.
pub fn channel() -> io::Result<Receiver<&'static str>> {
    let was_asked = Arc::new(AtomicBool::new(false));
    for (signal, code) in [(SIGINT, 130), (SIGTERM, 143)] {
        // The order matters: the first signal must not end the process that it arms for the second.
        flag::register_conditional_shutdown(signal, code, Arc::clone(&was_asked))?;
        flag::register(signal, Arc::clone(&was_asked))?;
    }
    let mut signals = Signals::new([SIGINT, SIGTERM])?;
    let (sender, receiver) = bounded(1);
    std::thread::Builder::new().name("signals".to_owned()).spawn(move || {
        for signal in signals.forever() {
            let name = if signal == SIGINT { "SIGINT" } else { "SIGTERM" };
            if sender.send(name).is_err() {
                return;
            }
        }
    })?;
    Ok(receiver)
}
