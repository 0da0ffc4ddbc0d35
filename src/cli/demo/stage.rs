//! The stage of a demo: a daemon, a producer and a printer that meet on a real socket.
//!
//! In: what is played, and a page that is bound.
//! Out: events of tracks on stdout, the page, and why the demo ended.
//! Invariants: the printer follows the stream before the producer sends its first point. The first role that ends
//! ends all, in this order: the producer has its answers, the daemon sends its last frames and says goodbye, the
//! printer has written them.
//! Must not know: how frames are followed, what the page shows.

use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::thread::{self, Scope};
use std::time::Duration;

use hopes::topology::{TrackOptions, TrackRule};
use hopes_protocol::{Cut, DotsWanted, Simplify, TracksWanted, View};
use indicatif::ProgressBar;

use super::roles::{OVER, Role, Roles};
use super::source::DemoSource;
use crate::cli::Failure;
use crate::cli::files;
use crate::cli::following::Shown;
use crate::client::delivery::Delivery;
use crate::client::follow::{Subscription, follow_until};
use crate::client::{Client, SOFTWARE, Timeouts};
use crate::daemon::{
    self, Address, HttpAccess, Limits, Overload, PipelineOptions, Settings, StartHttp, Stop, StreamSettings,
};
use crate::formats::messages::{MessageForm, MessageWriter};
use crate::view::Page;

/// The name of the stream.
const STREAM: &str = "demo";

/// How long a wait lasts before signals and roles are looked at.
const MOMENT: Duration = Duration::from_millis(50);

/// The same, for what takes almost no time.
const SOON: Duration = Duration::from_millis(1);

/// Where the roles meet, and what is played.
pub struct Stage {
    /// Of the daemon's socket.
    pub address: Address,
    /// What the producer sends.
    pub source: DemoSource,
    /// After so many frames the demo ends.
    pub frames: Option<u64>,
    /// Frames in a second.
    pub rate: f64,
}

impl Stage {
    /// Plays until a signal comes, the source ends or a role fails. Why it ended.
    pub fn perform(&self, page: Page, mut signals: Stop) -> Result<&'static str, Failure> {
        thread::scope(|scope| {
            let (sender, opened) = sync_channel(1);
            let daemon = Role::start(scope, "daemon", move |stop| self.serve(page, sender, &stop))?;
            let mut roles = Roles { daemon, printer: None, producer: None };
            let played = self.play(scope, &mut roles, &opened, &mut signals);
            let reason = *played.as_ref().unwrap_or(&OVER);
            roles.end(reason).and(played)
        })
    }

    fn play<'scope>(
        &'scope self,
        scope: &'scope Scope<'scope, '_>,
        roles: &mut Roles<'scope>,
        opened: &Receiver<HttpAccess>,
        signals: &mut Stop,
    ) -> Result<&'static str, Failure> {
        // A daemon that cannot start reports why when it is joined.
        let Ok(access) = opened.recv() else { return Ok(OVER) };
        roles.printer = Some(Role::start(scope, "printer", |stop| self.print(stop))?);
        // The printer must follow the stream from the first frame on.
        while !is_followed(&access) {
            if let Some(reason) = roles.ended(signals, SOON) {
                return Ok(reason);
            }
        }
        roles.producer = Some(Role::start(scope, "producer", |stop| self.produce(stop))?);
        loop {
            if let Some(reason) = roles.ended(signals, MOMENT) {
                return Ok(reason);
            }
        }
    }

    fn serve(&self, page: Page, opened: SyncSender<HttpAccess>, stop: &Stop) -> Result<(), Failure> {
        let http: StartHttp = Box::new(move |access| {
            let closing = page.http()(access.clone())?;
            // The receiver is there as long as the demo plays.
            let _ = opened.send(access);
            Ok(closing)
        });
        Ok(daemon::run(self.settings(), None, None, Some(http), stop)?)
    }

    fn settings(&self) -> Settings {
        let options = PipelineOptions { window: self.source.window(), ..PipelineOptions::default() };
        let stream = StreamSettings { options, ..StreamSettings::default() };
        Settings {
            default_stream: StreamSettings::default(),
            view: self.view(),
            tracking: Some(TrackOptions::new(TrackRule::Above(self.source.above()))),
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
            rate: Some(self.rate),
            origin: None,
            space: None,
            whole_frames: true,
        };
        let client = Client::connect(&self.address, SOFTWARE, Timeouts::default())?;
        let (source, frames) = (self.source, self.frames);
        Ok(delivery.deliver(client, stop, &|_| (), |terms| source.play(frames, terms.batch))?)
    }

    fn print(&self, stop: Stop) -> Result<(), Failure> {
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
        let writer = MessageWriter::new(MessageForm::Events, files::buffered(files::stdout()?));
        follow_until(stop, client, &wanted, &mut Shown::new(writer, ProgressBar::hidden()))?;
        Ok(())
    }
}

/// Whether a consumer follows the stream.
fn is_followed(access: &HttpAccess) -> bool {
    access.status().streams.iter().any(|stream| stream.info.consumers > 0)
}
