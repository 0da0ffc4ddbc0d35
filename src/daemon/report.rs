//! Errors of the protocol, as messages.
//!
//! In: a code, the type of the message that it answers, a text. Out: a [`wire::Report`].
//!
//! Must not know: where it is sent.

use hopes_protocol as wire;

/// An error that answers a message of type `answers`; 0 for none.
pub fn report(code: wire::ErrorCode, answers: u16, text: impl Into<String>) -> wire::Report {
    wire::Report { code: code as u16, answers, text: text.into() }
}
