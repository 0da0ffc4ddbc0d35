//! `hopes completions`: a script that completes commands and options in a shell.
//!
//! In: a shell's name.
//! Out: the script, on stdout.
//! Must not know: what commands do.

use std::io::Write;

use anyhow::Context;
use clap::{Args, Command};
use clap_complete::{Shell, generate};

use crate::cli::{Failure, files};

/// Write a script that completes commands and options in a shell.
///
/// Load it where your shell looks for such scripts; the examples name the usual places.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  hopes completions bash > hopes.bash      then: source hopes.bash
  hopes completions zsh > _hopes           into a folder of $fpath
  hopes completions fish > hopes.fish      into ~/.config/fish/completions")]
pub struct Completions {
    /// The shell.
    #[arg(value_name = "SHELL")]
    shell: Shell,
}

impl Completions {
    pub fn run(self, mut command: Command) -> Result<(), Failure> {
        let mut stdout = files::stdout()?;
        let mut script = Vec::new();
        generate(self.shell, &mut command, "hopes", &mut script);
        Ok(stdout.write_all(&script).context(files::CANNOT_WRITE_TO_STDOUT)?)
    }
}
