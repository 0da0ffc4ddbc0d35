//! `hopes status`: how a daemon is, its streams, and on request its peers, what its memory is used for, and its spaces.
//!
//! In: an address.
//! Out: tables, or JSON.
//! Invariants: nothing is written before all answers are there.
//! Must not know: how the daemon is asked, how it comes to its numbers.

use std::io::{self, Write};

use anyhow::Context;
use clap::Args;
use hopes_protocol::{Memory, Peers, Spaces, Status as Numbers};

use super::tables::{write_memory, write_peers, write_spaces, write_streams};
use super::{write_line, write_out};
use crate::cli::args::Connect;
use crate::cli::{Failure, files};
use crate::client::admin::Admin;

/// Show a daemon's streams: who feeds and follows them, points, memory, what was refused, dropped or merged.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  hopes status
  hopes status --connect unix:/tmp/hopes.sock
  hopes status --connect unix:/tmp/hopes.sock --peers --memory
  hopes status --connect tcp:127.0.0.1:7878 --json | jq '.streams[].info.name'")]
pub struct Status {
    #[command(flatten)]
    daemon: Connect,
    /// Also its peers: where they came to, how long ago, what is held for them, what they have sent and received.
    #[arg(long)]
    peers: bool,
    /// Also what its memory is used for: peers, and the points, views and queue of each stream.
    #[arg(long)]
    memory: bool,
    /// Also the metric and the dimension of streams of points in R^d.
    #[arg(long)]
    spaces: bool,
    /// As one line of JSON for each of them, with the names of protocol/SPEC.md.
    #[arg(long)]
    json: bool,
}

/// The answers, each if it is wanted.
struct Answers {
    status: Numbers,
    peers: Option<Peers>,
    memory: Option<Memory>,
    spaces: Option<Spaces>,
}

impl Status {
    pub fn run(self) -> Result<(), Failure> {
        let out = files::stdout()?;
        let answers = self.ask()?;
        let mut text = Vec::new();
        if self.json {
            answers.write_lines(&mut text)?;
        } else {
            answers.write_tables(&mut text).context("cannot write the table")?;
        }
        write_out(out, &text)
    }

    fn ask(&self) -> Result<Answers, Failure> {
        let mut admin = Admin::connect(&self.daemon.address()?)?;
        let status = admin.status()?;
        let peers = if self.peers { Some(admin.peers()?) } else { None };
        let memory = if self.memory { Some(admin.memory()?) } else { None };
        let spaces = if self.spaces { Some(admin.spaces()?) } else { None };
        admin.end();
        Ok(Answers { status, peers, memory, spaces })
    }
}

impl Answers {
    fn write_lines(&self, out: &mut Vec<u8>) -> Result<(), Failure> {
        write_line(out, &self.status)?;
        self.peers.as_ref().map_or(Ok(()), |peers| write_line(out, peers))?;
        self.memory.as_ref().map_or(Ok(()), |memory| write_line(out, memory))?;
        self.spaces.as_ref().map_or(Ok(()), |spaces| write_line(out, spaces))
    }

    fn write_tables(&self, out: &mut impl Write) -> io::Result<()> {
        write_streams(out, &self.status)?;
        if let Some(peers) = &self.peers {
            writeln!(out)?;
            write_peers(out, peers)?;
        }
        if let Some(memory) = &self.memory {
            writeln!(out)?;
            write_memory(out, memory)?;
        }
        if let Some(spaces) = &self.spaces {
            writeln!(out)?;
            write_spaces(out, spaces, &self.status)?;
        }
        Ok(())
    }
}
