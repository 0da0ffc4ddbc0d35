//! `hopes man`: pages of the manual, one a command.
//!
//! In: a folder.
//! Out: a file for each page there.
//! Invariants: a page that is there is replaced as a whole. The pages depend on the program alone.
//! Must not know: what commands do.

use std::path::{Path, PathBuf};

use anyhow::Context;
use clap::{Args, Command};
use clap_mangen::Man;

use crate::cli::{Failure, files};

/// Write the pages of the manual into a folder, one a command: hopes.1, hopes-compute.1 and so on.
///
/// The folder is made if it is not there.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  hopes man man1                           then: man ./man1/hopes.1
  hopes man man1 && ls man1                for all users, copy them to /usr/local/share/man/man1")]
pub struct Manual {
    /// The folder.
    #[arg(value_name = "DIR")]
    folder: PathBuf,
}

impl Manual {
    pub fn run(self, mut command: Command) -> Result<(), Failure> {
        // Names of subcommands get that of the program before them.
        command.build();
        let folder = &self.folder;
        std::fs::create_dir_all(folder).with_context(|| format!("cannot make the folder {}", folder.display()))?;
        let pages = pages(folder, &command)?;
        tracing::info!("{pages} pages in {}", folder.display());
        Ok(())
    }
}

/// Writes the page of a command, and those of its subcommands. How many there are.
fn pages(folder: &Path, command: &Command) -> Result<usize, Failure> {
    let man = Man::new(command.clone());
    let path = folder.join(man.get_filename());
    let mut text = Vec::new();
    man.render(&mut text).context("cannot write a page into memory")?;
    let file = files::create(&path)?;
    let written = std::io::Write::write_all(&mut &file, &text).and_then(|()| file.finish());
    written.with_context(|| files::cannot_write(&path))?;
    let commands = command.get_subcommands().filter(|command| !command.is_hide_set() && command.get_name() != "help");
    commands.map(|command| pages(folder, command)).try_fold(1, |sum, pages| Ok(sum + pages?))
}
