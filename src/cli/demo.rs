//! `hopes demo`: all of the program at once, for a first look.
//!
//! In: what is to be shown.
//! Out: the address of a page, then a line for each event of a track. Three roles, a thread each:
//!
//! ```text
//! producer ──(socket)─▶ daemon ──(socket)─▶ printer ─▶ stdout
//!                          └──────────────▶ page
//! ```
//!
//! Invariants: the address is written before anything is computed.
//! Must not know: what is played, how the roles work together.

mod roles;
mod source;
mod stage;

use std::fs::File;
use std::io::{self, Write};

use anyhow::Context;
use clap::Args;
use hopes::scene::Kind;

use super::args::{from_one, host_and_port, rate, scene};
use super::{Failure, files};
use crate::daemon::{Address, ListenError, Stop};
use crate::view::{Page, PageAddress};
use source::DemoSource;
use stage::Stage;

/// Show what this is: points that move, their skeleton on a live page, and what happens to its holes in the terminal.
///
/// Starts a daemon with a page, feeds it a scene (rings that drift, split, fuse, open, appear and vanish) or the edges
/// of a film, and writes the address to open in a browser. Ctrl-C ends all.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  hopes demo
  hopes demo --scene pinch
  hopes demo --video --view 127.0.0.1:9000
  hopes demo --frames 60                       ends by itself")]
pub struct Demo {
    /// The scene to play, one in the plane; hopes scene --list lists all [default: mixed].
    #[arg(long, value_name = "NAME", value_parser = scene::<Kind>)]
    scene: Option<Kind>,
    /// Play the edges of a film instead.
    #[arg(long, conflicts_with = "scene")]
    video: bool,
    /// End after so many frames [default: go on until Ctrl-C].
    #[arg(long, value_name = "N", value_parser = from_one)]
    frames: Option<u64>,
    /// So many frames a second [default: 30; of the film 5].
    #[arg(long, value_name = "FPS", value_parser = rate)]
    rate: Option<f64>,
    /// Where the page is [default: 127.0.0.1:8080, or any free port if that one is taken].
    #[arg(long = "view", value_name = "HOST:PORT", value_parser = host_and_port)]
    address: Option<String>,
    /// Let browsers on other machines open the page: there is no password.
    #[arg(long, requires = "address")]
    allow_remote: bool,
}

/// The address of the page by default.
const USUAL: &str = "127.0.0.1:8080";
/// Its address if that one is taken.
const ANYWHERE: &str = "127.0.0.1:0";

impl Demo {
    pub fn run(self) -> Result<(), Failure> {
        let stdout = files::stdout()?;
        let signals = Stop::listen().context("cannot listen to signals")?;
        let source = if self.video { DemoSource::Film } else { DemoSource::Scene(self.scene.unwrap_or(Kind::Mixed)) };
        let page = self.page()?;
        let rate = self.rate.unwrap_or(source.rate());
        announce(&stdout, &page, source, rate).context(files::CANNOT_WRITE_TO_STDOUT)?;
        let folder = tempfile::Builder::new().prefix("hopes-demo-").tempdir();
        let folder = folder.context("cannot make a folder for the socket")?;
        let address = Address::Unix(folder.path().join("socket"));
        let stage = Stage { address, source, frames: self.frames, rate };
        let reason = stage.perform(page, signals)?;
        Ok(writeln!(&stdout, "{reason}").context(files::CANNOT_WRITE_TO_STDOUT)?)
    }

    fn page(&self) -> Result<Page, ListenError> {
        let bind = |address: &str| {
            let (address, allow_remote) = (address.to_owned(), self.allow_remote);
            Page::bind(PageAddress { address, allow_remote, ..PageAddress::default() })
        };
        match &self.address {
            Some(address) => bind(address),
            None => bind(USUAL).or_else(|_| bind(ANYWHERE)),
        }
    }
}

fn announce(mut stdout: &File, page: &Page, source: DemoSource, rate: f64) -> io::Result<()> {
    writeln!(stdout, "open {} in a browser; Ctrl-C ends the demo", page.url())?;
    writeln!(stdout, "{}, at {rate} frames a second; what happens to holes:", source.about())
}
