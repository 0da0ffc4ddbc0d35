//! Where the daemon is if no address is given: what the variable says, else a socket of the user's own.
//!
//! In: an address of the command line, if there is one; the environment.
//! Out: an address.
//! Invariants: the socket's folder belongs to the user alone, so that nobody else can stand in for the daemon; it is
//! made if it is not there.
//! Must not know: sockets.

use std::fs::{self, DirBuilder};
use std::io;
use std::os::unix::fs::{DirBuilderExt, MetadataExt};
use std::path::{Path, PathBuf};
use std::str::FromStr;

use crate::cli::Failure;
use crate::daemon::{Address, AddressError};

/// The variable that has the address of the daemon.
const VARIABLE: &str = "HOPES_ADDRESS";

/// The word that stands for the usual address where an option has none.
pub const USUAL: &str = "default";

const SOCKET: &str = "hopes.sock";

/// An address, or the usual one.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Place(Option<Address>);

impl FromStr for Place {
    type Err = AddressError;

    fn from_str(word: &str) -> Result<Self, AddressError> {
        if word == USUAL { Ok(Self(None)) } else { word.parse().map(|address| Self(Some(address))) }
    }
}

impl Place {
    /// The address that it stands for.
    pub fn address(&self) -> Result<Address, Failure> {
        address(self.0.as_ref())
    }
}

/// The address that is given, else that of the variable, else the user's own socket.
pub fn address(given: Option<&Address>) -> Result<Address, Failure> {
    if let Some(address) = given {
        return Ok(address.clone());
    }
    match std::env::var(VARIABLE) {
        Ok(word) if !word.is_empty() => {
            word.parse().map_err(|error: AddressError| Failure::usage(format!("{VARIABLE}: {error}")))
        }
        Err(std::env::VarError::NotUnicode(_)) => {
            Err(Failure::usage(format!("{VARIABLE} is no UTF-8: write unix:PATH or tcp:HOST:PORT")))
        }
        _ => Ok(Address::Unix(own_folder()?.join(SOCKET))),
    }
}

/// The folder of the user's sockets: that of the session, else one in the folder for temporary files.
fn own_folder() -> Result<PathBuf, Failure> {
    let session = std::env::var_os("XDG_RUNTIME_DIR").map(PathBuf::from);
    let folder = session.filter(|folder| folder.is_absolute() && folder.is_dir()).unwrap_or_else(|| {
        let user = rustix::process::geteuid().as_raw();
        std::env::temp_dir().join(format!("hopes-{user}"))
    });
    let wrong = |reason: String| {
        Failure::usage(format!(
            "the usual place of the daemon's socket, {}, {reason}: give an address, or set {VARIABLE} to one",
            folder.display()
        ))
    };
    let made = DirBuilder::new().mode(0o700).create(&folder);
    match made {
        Err(error) if error.kind() != io::ErrorKind::AlreadyExists => {
            return Err(wrong(format!("cannot be made ({error})")));
        }
        _ => {}
    }
    if is_own(&folder).map_err(|error| wrong(format!("cannot be looked at ({error})")))? {
        Ok(folder)
    } else {
        Err(wrong("is not a folder that you alone may write to".to_owned()))
    }
}

/// Whether it is a folder of this user into which nobody else writes.
fn is_own(folder: &Path) -> io::Result<bool> {
    let data = fs::symlink_metadata(folder)?;
    let user = rustix::process::geteuid().as_raw();
    // The folder of a session may be a link that the system has made.
    let data = if data.is_symlink() && data.uid() == 0 { fs::metadata(folder)? } else { data };
    Ok(data.is_dir() && data.uid() == user && data.mode() & 0o022 == 0)
}

#[cfg(test)]
mod tests {
    use std::fs::Permissions;
    use std::os::unix::fs::{PermissionsExt, symlink};

    use super::*;

    #[test]
    fn a_folder_is_ones_own_if_nobody_else_writes_there() {
        let place = tempfile::tempdir().unwrap();
        let folder = place.path().join("own");
        DirBuilder::new().mode(0o700).create(&folder).unwrap();
        assert!(is_own(&folder).unwrap());
        for mode in [0o770, 0o702, 0o777] {
            fs::set_permissions(&folder, Permissions::from_mode(mode)).unwrap();
            assert!(!is_own(&folder).unwrap(), "{mode:o}");
        }
        fs::write(place.path().join("file"), "").unwrap();
        assert!(!is_own(&place.path().join("file")).unwrap());
        assert!(is_own(&place.path().join("none")).is_err());
        fs::set_permissions(&folder, Permissions::from_mode(0o755)).unwrap();
        symlink(&folder, place.path().join("link")).unwrap();
        let is_root = rustix::process::geteuid().is_root();
        assert_eq!(is_own(&place.path().join("link")).unwrap(), is_root, "a link of another than root leads elsewhere");
    }

    #[test]
    fn a_word_stands_for_the_usual_place() {
        assert_eq!(USUAL.parse(), Ok(Place(None)));
        assert_eq!("tcp:127.0.0.1:1".parse(), Ok(Place(Some(Address::Tcp("127.0.0.1:1".to_owned())))));
        assert!("here".parse::<Place>().is_err());
    }
}
