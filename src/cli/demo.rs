//! `hopes demo`: all of it at once, for somebody who has just come by.
//!
//! In: what is to be shown. Out: the address of a page, then a line for each thing that happens to a track. Three roles, a thread each, which meet on a
//! real socket:
//!
//! ```text
//! producer ──(socket)─▶ daemon ──(socket)─▶ teller ─▶ stdout
//!                          └──────────────▶ page
//! ```
//!
//! Invariants: what to open is said before anything is computed; whoever ends first ends all, in this order: the producer has its answers, the daemon sends its last frames
//! and says goodbye, the teller has told them. Must not know: what the programme is made of, how frames are followed.

mod cast;
mod programme;

use std::io::{self, Write};
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::thread::{self, Scope};
use std::time::Duration;

use anyhow::Context;
use clap::Args;
use hopes::scene::Kind;
use hopes::topology::{Options, TrackOptions, TrackRule};
use hopes_protocol::{Cut, DotsWanted, Simplify, TracksWanted, View};
use indicatif::ProgressBar;

use super::Failure;
use super::args::rate;
use super::scene::kind;
use super::serve::host_and_port;
use crate::client::delivery::Delivery;
use crate::client::follow::{SOFTWARE, Subscription, follow_until};
use crate::client::{Client, Timeouts};
use crate::daemon::{
    self, Address, HttpAccess, Limits, ListenError, Overload, Settings, StartHttp, Stop, StreamSettings,
};
use crate::formats::messages::{Output, Show};
use crate::view::{Page, Place};
use cast::{Cast, Role};
use programme::Programme;

/// Show what this is: points that move, their skeleton on a live page, and what happens to its holes in the terminal.
///
/// Starts a daemon with a page, feeds it a scene (rings that drift, split, fuse, open, appear and vanish) or the edges of a film, and says what to open in a
/// browser. Ctrl-C ends all.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  hopes demo
  hopes demo --scene pinch
  hopes demo --video --view 127.0.0.1:9000
  hopes demo --frames 300                      ends by itself")]
pub struct Demo {
    /// The scene to play; hopes scene --list lists all [default: mixed].
    #[arg(long, value_name = "NAME", value_parser = kind)]
    scene: Option<Kind>,
    /// Play the edges of a film instead.
    #[arg(long, conflicts_with = "scene")]
    video: bool,
    /// End after so many frames [default: go on until Ctrl-C].
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..))]
    frames: Option<u64>,
    /// So many frames a second [default: 30, of the film 5].
    #[arg(long, value_name = "FPS", value_parser = rate)]
    rate: Option<f64>,
    /// Where the page is [default: 127.0.0.1:8080, or any port if somebody has that one].
    #[arg(long = "view", value_name = "HOST:PORT", value_parser = host_and_port)]
    address: Option<String>,
    /// Let browsers on other machines open the page: there is no password.
    #[arg(long, requires = "address")]
    allow_remote: bool,
}

/// Where the page is, if nothing else is asked for.
const USUAL: &str = "127.0.0.1:8080";
/// Where it is, if somebody is there.
const ANYWHERE: &str = "127.0.0.1:0";

/// The name of the stream.
const STREAM: &str = "demo";

/// How long anything is waited for before it is seen whether a signal has come.
const MOMENT: Duration = Duration::from_millis(50);

/// How long what takes no time is waited for.
const SOON: Duration = Duration::from_millis(1);

/// What everybody is told at an end that nobody has asked for.
const OVER: &str = "the demo is over";

impl Demo {
    pub fn run(self) -> Result<(), Failure> {
        let signals = Stop::listen().context("cannot listen to signals")?;
        let programme = if self.video { Programme::Film } else { Programme::Scene(self.scene.unwrap_or(Kind::Mixed)) };
        let page = self.page()?;
        let rate = self.rate.unwrap_or(programme.rate());
        announce(&page, programme, rate).context("cannot write to stdout")?;
        let folder = tempfile::Builder::new().prefix("hopes-demo-").tempdir();
        let folder = folder.context("cannot make a folder for the socket")?;
        let stage =
            Stage { address: Address::Unix(folder.path().join("socket")), programme, frames: self.frames, rate };
        let reason = stage.perform(page, signals)?;
        writeln!(io::stdout(), "{reason}").context("cannot write to stdout")?;
        Ok(())
    }

    fn page(&self) -> Result<Page, ListenError> {
        let bind = |address: &str| {
            let (address, allow_remote) = (address.to_owned(), self.allow_remote);
            Page::bind(Place { address, names: Vec::new(), allow_remote })
        };
        match &self.address {
            Some(address) => bind(address),
            None => bind(USUAL).or_else(|_| bind(ANYWHERE)),
        }
    }
}

fn announce(page: &Page, programme: Programme, rate: f64) -> io::Result<()> {
    let mut stdout = io::stdout().lock();
    writeln!(stdout, "open {} in a browser; Ctrl-C ends the demo", page.url())?;
    writeln!(stdout, "{}, at {rate} frames a second; what happens to holes:", programme.about())?;
    stdout.flush()
}

/// Where the roles meet, and what is played.
struct Stage {
    address: Address,
    programme: Programme,
    frames: Option<u64>,
    rate: f64,
}

impl Stage {
    /// Plays until a signal comes, the programme ends or somebody fails. Why it is over.
    fn perform(&self, page: Page, mut signals: Stop) -> Result<&'static str, Failure> {
        thread::scope(|scope| {
            let (sender, opened) = sync_channel(1);
            let daemon = Role::start(scope, "daemon", move |stop| self.serve(page, sender, &stop))?;
            let mut cast = Cast { daemon, teller: None, producer: None };
            let played = self.play(scope, &mut cast, &opened, &mut signals);
            let reason = *played.as_ref().unwrap_or(&OVER);
            cast.end(reason).and(played)
        })
    }

    fn play<'scope>(
        &'scope self,
        scope: &'scope Scope<'scope, '_>,
        cast: &mut Cast<'scope>,
        opened: &Receiver<HttpAccess>,
        signals: &mut Stop,
    ) -> Result<&'static str, Failure> {
        // A daemon that cannot open says why in the end.
        let Ok(access) = opened.recv() else { return Ok(OVER) };
        cast.teller = Some(Role::start(scope, "teller", |stop| self.tell(stop))?);
        // Whoever is to tell all has to be there from the first frame on.
        while !is_followed(&access) {
            if let Some(reason) = cast.is_over(signals, SOON) {
                return Ok(reason);
            }
        }
        cast.producer = Some(Role::start(scope, "producer", |stop| self.produce(stop))?);
        loop {
            if let Some(reason) = cast.is_over(signals, MOMENT) {
                return Ok(reason);
            }
        }
    }

    fn serve(&self, page: Page, opened: SyncSender<HttpAccess>, stop: &Stop) -> Result<(), Failure> {
        let http: StartHttp = Box::new(move |access| {
            let closing = page.http()(access.clone())?;
            // Whoever waits for this is there.
            let _ = opened.send(access);
            Ok(closing)
        });
        Ok(daemon::run(self.settings(), None, None, Some(http), stop)?)
    }

    fn settings(&self) -> Settings {
        let options = Options { window: self.programme.window(), resolution: None };
        let stream = StreamSettings { options, ..StreamSettings::default() };
        Settings {
            default_stream: StreamSettings::default(),
            view: self.view(),
            tracking: Some(TrackOptions::new(TrackRule::Above(self.programme.above()))),
            strict: false,
            check: false,
            threads: None,
            overload: Overload::Block,
            limits: Limits::default(),
            listen: vec![self.address.clone()],
            allow_remote: false,
            streams: vec![(STREAM.to_owned(), stream)],
        }
    }

    fn view(&self) -> View {
        View { cut: Cut::Derived(1, 1), simplify: Simplify::No }
    }

    fn produce(&self, stop: Stop) -> Result<(), Failure> {
        let delivery = Delivery {
            to: &self.address,
            stream: STREAM,
            window: None,
            window_if_new: None,
            resolution: None,
            strict: false,
            place: "line",
            rate: Some(self.rate),
            whole_frames: true,
        };
        let client = Client::connect(&self.address, SOFTWARE, Timeouts::default())?;
        let (programme, frames) = (self.programme, self.frames);
        delivery.deliver(client, stop, &ProgressBar::hidden(), |batch| programme.play(frames, batch))
    }

    fn tell(&self, stop: Stop) -> Result<(), Failure> {
        let wanted = Subscription {
            from: self.address.clone(),
            pattern: STREAM.to_owned(),
            view: self.view(),
            dots: DotsWanted::No,
            tracks: TracksWanted::Events,
            frames: None,
            check: false,
            reconnect: false,
        };
        let client = Client::connect(&self.address, SOFTWARE, Timeouts::default())?;
        let mut show = Show::new(Output::Events, io::stdout())?;
        follow_until(stop, client, &wanted, &mut show, &ProgressBar::hidden())?;
        Ok(())
    }
}

/// Whether anybody hears of the stream's frames.
fn is_followed(access: &HttpAccess) -> bool {
    access.status().streams.iter().any(|stream| stream.info.consumers > 0)
}
