//! The command line: one file a subcommand, and what they share.
//!
//! In: parsed arguments.
//! Out: a subcommand run.
//! Invariants: every option that takes a scale takes a radius; every help text has an example.
//! Must not know: how frames are computed.

#![allow(rustdoc::broken_intra_doc_links, reason = "help texts show points as [x,y]")]

mod admin;
mod args;
mod compute;
mod demo;
mod edges;
mod failure;
mod feed;
mod files;
mod following;
mod manual;
mod progress;
mod record;
mod replay;
mod scene;
mod serve;
mod tracks;
mod watch;

use std::io::{IsTerminal, Write};

use anyhow::Context;
use clap::{CommandFactory, FromArgMatches, Parser, Subcommand};
use tracing::Level;

pub use failure::Failure;

/// Live homologically persistent skeletons of 2D points.
///
/// Points come in. The skeleton of their cloud (HoPeS: minimum spanning tree and persistent cycles) goes out, frame by
/// frame, as it changes. There is no scale to choose: the widest gaps of the persistence diagram choose the cycles.
#[derive(Debug, Parser)]
#[command(
    version,
    max_term_width = 100,
    after_help = "Examples:
  hopes demo --frames 60
  hopes compute points.csv -o points.svg

Exit codes: 0 done (also after a closed pipe or a first Ctrl-C), 1 failed, 2 wrong usage, 3 refused
under --strict. Stdout carries data, stderr carries logs.

Where no address is given, clients connect to $HOPES_ADDRESS (unix:PATH or tcp:HOST:PORT), else to
your own socket, where serve --listen without an address listens."
)]
pub struct Cli {
    /// Log more; twice: everything.
    #[arg(short, long, action = clap::ArgAction::Count, global = true, help_heading = "Logging")]
    verbose: u8,
    /// Log errors only.
    #[arg(short, long, global = true, help_heading = "Logging")]
    quiet: bool,
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    Demo(demo::Demo),
    Compute(compute::Compute),
    Serve(Box<serve::Serve>),
    Feed(feed::Feed),
    Watch(watch::Watch),
    Status(admin::status::Status),
    StopStream(admin::stop_stream::StopStream),
    Disconnect(admin::disconnect::Disconnect),
    Record(record::Record),
    Replay(replay::Replay),
    Tracks(tracks::Tracks),
    Scene(scene::Play),
    Edges(edges::Edges),
    Completions(manual::completions::Completions),
    #[command(name = "man")]
    Manual(manual::man::Manual),
}

/// Names of values that are numbers, perhaps with an exponent or a unit: what begins with a minus is one all the same.
const NUMBERS: [&str; 17] = [
    "K", "L", "N", "S", "D", "E", "C", "X", "ALPHA", "BYTES", "DELTA", "DURATION", "FPS", "HIGH", "LOW", "SIGMA",
    "STEP",
];

/// All commands, with their options.
fn command() -> clap::Command {
    // A value that begins with a minus is a value, so that the option can say what it may be.
    let with_negative = |arg: clap::Arg| {
        let takes_value = arg.get_action().takes_values() && !arg.is_positional();
        let is_number =
            arg.get_value_names().is_some_and(|names| names.iter().any(|name| NUMBERS.contains(&name.as_str())));
        arg.allow_negative_numbers(takes_value).allow_hyphen_values(takes_value && is_number)
    };
    Cli::command().mut_subcommands(|command| command.mut_args(with_negative))
}

/// Parses the command line.
pub fn parse() -> Result<Cli, clap::Error> {
    let mut command = command();
    let mut matches = command.try_get_matches_from_mut(std::env::args_os())?;
    Cli::from_arg_matches_mut(&mut matches).map_err(|error| error.format(&mut command))
}

/// Writes what was asked of the arguments themselves: help, or the version.
pub fn show_answer(answer: &clap::Error) -> Result<(), Failure> {
    let stdout = files::stdout()?;
    let written = if stdout.is_terminal() {
        // Only there it has colours.
        answer.print()
    } else {
        (&stdout).write_all(answer.render().to_string().as_bytes())
    };
    Ok(written.context(files::CANNOT_WRITE_TO_STDOUT)?)
}

impl Cli {
    /// How much is logged. A demo writes events to stdout, and logs only what goes wrong.
    pub fn log_level(&self) -> Level {
        match (self.quiet, self.verbose, &self.command) {
            (true, ..) => Level::ERROR,
            (false, 0, Command::Demo(_)) => Level::WARN,
            (false, 0, _) => Level::INFO,
            (false, 1, _) => Level::DEBUG,
            (false, ..) => Level::TRACE,
        }
    }

    /// Runs the subcommand.
    pub fn run(self) -> Result<(), Failure> {
        match self.command {
            Command::Demo(demo) => demo.run(),
            Command::Compute(compute) => compute.run(),
            Command::Serve(serve) => serve.run(),
            Command::Feed(feed) => feed.run(),
            Command::Watch(watch) => watch.run(),
            Command::Status(status) => status.run(),
            Command::StopStream(stop) => stop.run(),
            Command::Disconnect(disconnect) => disconnect.run(),
            Command::Record(record) => record.run(),
            Command::Replay(replay) => replay.run(),
            Command::Tracks(tracks) => tracks.run(),
            Command::Scene(play) => play.run(),
            Command::Edges(edges) => edges.run(),
            Command::Completions(completions) => completions.run(command()),
            Command::Manual(manual) => manual.run(command()),
        }
    }
}
