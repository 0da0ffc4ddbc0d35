//! What is said while no stream of the wanted name is there.
//!
//! In: a pattern, the streams of a daemon.
//! Out: a line for people.
//! Invariants: what a daemon sends is printable, and few names are listed.
//! Must not know: how the daemon is asked.

use crate::daemon::Address;

/// Names that are listed, at most.
const NAMED: usize = 10;

/// That no stream matches, and which there are.
pub fn absent(address: &Address, pattern: &str, names: &[&str]) -> String {
    let what = if pattern.contains('*') { "no stream matches" } else { "there is no stream" };
    let others = match names.len() {
        0 => "it has none yet".to_owned(),
        number => {
            let listed: Vec<String> = names.iter().take(NAMED).map(|name| printable(name)).collect();
            let rest = if number > NAMED { format!(" and {} more", number - NAMED) } else { String::new() };
            format!("it has {}{rest}", listed.join(", "))
        }
    };
    format!("the daemon at {address}: {what} {}, {others}; waiting for it (Ctrl-C ends)", printable(pattern))
}

/// Without what could play tricks with a terminal.
fn printable(name: &str) -> String {
    name.chars().map(|character| if character.is_control() { '\u{fffd}' } else { character }).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn others_are_named() {
        let address = Address::Tcp("h:1".to_owned());
        let said = |pattern, names: &[&str]| absent(&address, pattern, names);
        assert_eq!(
            said("cam", &["default", "scan\n"]),
            "the daemon at tcp:h:1: there is no stream cam, it has default, scan\u{fffd}; waiting for it (Ctrl-C ends)"
        );
        assert!(said("c*", &[]).contains("no stream matches c*, it has none yet"));
        assert!(said("x", &["a"; 12]).contains("a, a and 2 more;"));
    }
}
