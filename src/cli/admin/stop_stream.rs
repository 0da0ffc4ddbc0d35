//! `hopes stop-stream`: ends a stream of a daemon.
//!
//! In: its name, an address.
//! Out: the stream's last frame.
//! Must not know: how the daemon is asked.

use clap::Args;

use super::show;
use crate::cli::args::{Connect, name};
use crate::cli::{Failure, files};
use crate::client::admin::Admin;

/// End a stream of a daemon, for all that feed or follow it.
///
/// What its producers have sent until then is taken; its consumers get what is still to come. Memory that it held is
/// free. A producer may make a stream of that name again.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  hopes stop-stream scan --connect unix:/tmp/hopes.sock
  hopes stop-stream 'hall 2' --connect tcp:127.0.0.1:7878 --json | jq .frame")]
pub struct StopStream {
    /// Name of the stream.
    #[arg(value_name = "NAME", value_parser = name)]
    name: String,
    #[command(flatten)]
    daemon: Connect,
    /// As one line of JSON, with the names of protocol/SPEC.md.
    #[arg(long)]
    json: bool,
}

impl StopStream {
    pub fn run(self) -> Result<(), Failure> {
        let out = files::stdout()?;
        let mut admin = Admin::connect(&self.daemon.address()?)?;
        let stopped = admin.stop_stream(&self.name)?;
        admin.end();
        // The name is the one that was given: it has no control character.
        let words = format!("stream {} has ended after frame {}", self.name, stopped.frame);
        show(out, self.json, &stopped, &words)
    }
}
