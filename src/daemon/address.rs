//! Where a daemon listens and where its peers find it: `unix:PATH` or `tcp:HOST:PORT`.
//!
//! In: words of the command line. Out: an [`Address`].
//!
//! Invariants: what is written is read as the same address.
//!
//! Must not know: sockets.

use std::fmt;
use std::path::PathBuf;
use std::str::FromStr;

use thiserror::Error;

/// An address to listen at, or to connect to.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Address {
    /// A Unix socket.
    Unix(PathBuf),
    /// Host and port.
    Tcp(String),
}

/// A word that is no address.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[error("{0:?} is no address: write unix:PATH or tcp:HOST:PORT, such as unix:/tmp/hopes.sock or tcp:127.0.0.1:7878")]
pub struct AddressError(String);

impl FromStr for Address {
    type Err = AddressError;

    fn from_str(word: &str) -> Result<Self, AddressError> {
        let has_port = |host: &str| host.rsplit_once(':').is_some_and(|(_, port)| port.parse::<u16>().is_ok());
        match word.split_once(':') {
            Some(("unix", path)) if !path.is_empty() => Ok(Self::Unix(path.into())),
            Some(("tcp", host)) if has_port(host) => Ok(Self::Tcp(host.to_owned())),
            _ => Err(AddressError(word.to_owned())),
        }
    }
}

impl fmt::Display for Address {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Unix(path) => write!(f, "unix:{}", path.display()),
            Self::Tcp(host) => write!(f, "tcp:{host}"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn addresses_are_read_and_written() {
        for word in ["unix:/tmp/h.sock", "unix:relative:odd", "tcp:127.0.0.1:7878", "tcp:[::1]:80", "tcp:localhost:1"] {
            assert_eq!(word.parse::<Address>().unwrap().to_string(), word);
        }
    }

    #[test]
    fn what_is_no_address_says_what_is() {
        for word in ["", "unix:", "tcp:7878", "tcp:host", "tcp:host:port", "/tmp/h.sock", "http://x"] {
            assert!(word.parse::<Address>().unwrap_err().to_string().contains("write unix:PATH or tcp:HOST:PORT"));
        }
    }
}
