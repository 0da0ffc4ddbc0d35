//! `hopes disconnect`: ends the connection of a peer of a daemon.
//!
//! In: the peer's number, an address.
//! Out: a word that it is done.
//! Must not know: how the daemon is asked.

use clap::Args;

use super::show;
use crate::cli::args::{Connect, whole};
use crate::cli::{Failure, files};
use crate::client::admin::Admin;

/// End the connection of a peer of a daemon.
///
/// Numbers of peers are shown by: hopes status --peers. A number is never given twice while the daemon runs. The peer
/// may connect again.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  hopes status --connect unix:/tmp/hopes.sock --peers      the numbers of all peers
  hopes disconnect 7 --connect unix:/tmp/hopes.sock")]
pub struct Disconnect {
    /// Number of the peer.
    #[arg(value_name = "PEER", value_parser = whole)]
    peer: u64,
    #[command(flatten)]
    daemon: Connect,
    /// As one line of JSON, with the names of protocol/SPEC.md.
    #[arg(long)]
    json: bool,
}

impl Disconnect {
    pub fn run(self) -> Result<(), Failure> {
        let out = files::stdout()?;
        let mut admin = Admin::connect(&self.daemon.address()?)?;
        let disconnected = admin.disconnect(self.peer)?;
        admin.end();
        show(out, self.json, &disconnected, &format!("peer {} is disconnected", disconnected.peer))
    }
}
