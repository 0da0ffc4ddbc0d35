//! `hopes serve`: points on stdin and from producers, frames on stdout and to consumers.
//!
//! In: options; text, JSON lines or frames of the protocol on stdin.
//! Out: a running daemon, and its frames as JSON lines or a recording on stdout.
//! Must not know: how points are parsed, what the engine does with them.

use std::fs::File;
use std::io;
use std::num::NonZeroUsize;
use std::time::Duration;

use anyhow::Context;
use clap::{ArgGroup, Args, ValueEnum};
use hopes_protocol::{Simplify, View};

use super::args::{
    PLACES, Place, ProjectArgs, SocketArgs, StreamSpace, StreamSpaceArgs, TrackArgs, ViewArgs, duration, form,
    from_one, host_and_port, host_name, many, origin, resolution, window,
};
use super::{Failure, files};
use crate::daemon::{
    self, BATCH, Feed, Input, OutputFrame, PipelineOptions, Settings, Sink, Source, Stop, StreamSettings,
};
use crate::formats::frame_writer::{FrameForm, FrameWriter};
use crate::formats::input::Format;
use crate::formats::points::{Form, Origin, PointSource};
use crate::view::{Page, PageAddress};

/// Follow streams of points: from stdin to stdout, one JSON line a frame with what changed, or between sockets.
///
/// stdin is a table, JSON lines, a JSON array, GeoJSON, NPY, PLY or PCD, or any of these compressed by gzip.
///
/// A frame is closed by a blank line, {"commit":true,"time":t}, --frame-points, --frame-every or the end of the input.
/// With --listen, any number of producers feed any number of streams, which any number of consumers follow, until a
/// signal comes. With --view, a live page shows all streams.
#[derive(Debug, Args)]
#[command(group = ArgGroup::new(PLACES).multiple(true))]
#[command(after_help = EXAMPLES, after_long_help = format!("{EXAMPLES}\n\n{BEHAVIOUR}\n\n{KEYS}"))]
pub struct Serve {
    /// How points are written on stdin [default: auto]. With --listen, stdin is read only if this is given.
    #[arg(long, value_enum)]
    input: Option<InputFormat>,
    /// Columns of a table, by number from 1 or by name in the header; a third one is the event time [default: what the
    /// header calls x and y, or lon and lat, and with --window time:T also t or time; else 1,2; with --metric all].
    #[arg(long, value_name = "X,Y[,T]")]
    columns: Option<String>,
    #[command(flatten)]
    project: ProjectArgs,
    #[command(flatten)]
    space: StreamSpaceArgs,
    /// Which points stay: all, points:N, frames:N or time:T.
    ///
    /// all: until they are retracted. points:N: the last N. frames:N: those of the last N frames; with N = 1 every
    /// frame replaces the cloud. time:T: those not older than the newest event time by more than T, a number or, where
    /// event times are seconds, such as 30s, 500ms or 2h; one that is too old is refused. A point without a time is of
    /// the time of the commit that closes its frame, else of the newest time known. A clock that jumps ahead by more
    /// than T, or back, is believed once another producer confirms it, or its own producer over a commit and 16 points;
    /// until then its points are refused, and nobody else's. Then the window starts anew.
    #[arg(long, value_name = "WINDOW", default_value = "all", value_parser = window)]
    window: hopes::topology::Window,
    /// Snap positions to a grid of this step.
    #[arg(long, value_name = "STEP", value_parser = resolution)]
    resolution: Option<f64>,
    /// Close a frame after so many points.
    #[arg(long, value_name = "N", value_parser = from_one)]
    frame_points: Option<u64>,
    /// Close a frame every so often, such as 100ms.
    #[arg(long, value_name = "DURATION", value_parser = duration)]
    frame_every: Option<Duration>,
    /// How frames are written on stdout [default: jsonl]. With --listen or --view, only if this is given.
    #[arg(long, value_enum)]
    output: Option<OutputFormat>,
    /// Stop at the first line or point on stdin that cannot be used (exit code 3).
    ///
    /// Without it, all are counted, and the first hundred are reported with their line.
    #[arg(long)]
    strict: bool,
    /// Reduce tiles on so many threads [default: one for each processor].
    ///
    /// The output is the same, byte for byte, on any number of threads.
    #[arg(long, value_name = "N", value_parser = many)]
    threads: Option<NonZeroUsize>,
    /// Recompute every frame from scratch and compare; stop at a difference (exit code 1). Slow.
    #[arg(long)]
    check: bool,
    #[command(flatten)]
    view: ViewArgs,
    #[command(flatten)]
    tracks: TrackArgs,
    /// List all living tracks in every frame on stdout.
    #[arg(long, requires = "track", help_heading = "Tracks")]
    track_list: bool,
    #[command(flatten)]
    sockets: SocketArgs,
    #[command(flatten)]
    page: PageArgs,
}

/// Where the live page is.
#[derive(Clone, Debug, Args)]
#[command(next_help_heading = "Live page")]
struct PageArgs {
    /// Show all streams on a page at this address, for browsers; also /metrics, /healthz and /api/streams.
    ///
    /// For this machine only, unless --allow-remote is given. With it, stdin is read, unless --listen is given too;
    /// stdout is written only if --output is given; and the daemon runs until a signal comes.
    #[arg(long = "view", value_name = "HOST:PORT", group = PLACES, value_parser = host_and_port)]
    address: Option<String>,
    /// A name by which browsers may ask for the page, besides its addresses. May be repeated.
    ///
    /// Requests by any other name are refused. It opens nothing to other machines: that is --allow-remote.
    #[arg(long = "view-host", value_name = "NAME", requires = "address", value_parser = host_name)]
    hosts: Vec<String>,
    /// Where a proxy on this machine shows the page, such as https://example.org. May be repeated.
    ///
    /// The page may then be anywhere below it. Its host is also a --view-host. Requests of pages of any other origin
    /// are refused.
    #[arg(long = "view-origin", value_name = "ORIGIN", requires = "address", value_parser = origin)]
    origins: Vec<String>,
}

const EXAMPLES: &str = "Examples:
  sensor | hopes serve --window points:10000 --frame-points 1000
  camera-edges | hopes serve --input jsonl --window frames:1 | jq -c '[.frame, .view.cycles]'
  lidar3d | hopes serve --metric euclidean --columns x,y,z --window points:2000 --frame-points 100
  microphone | hopes serve --embed 8:5 --window points:800 --frame-points 40
  camera-edges | hopes serve --input jsonl --window frames:1 --track view | jq -c .tracks
  tail -n +1 -f log.csv |
    hopes serve --columns lon,lat,unix --project --window time:60 --frame-every 100ms
  camera-edges | hopes serve --input jsonl --window frames:1 --track view --view 127.0.0.1:8080
  hopes serve --listen --stream cam:window=frames:1        for clients without an address
  hopes serve --listen unix:/tmp/hopes.sock --stream cam:window=frames:1 --track top:20";

const BEHAVIOUR: &str = "\
A frame without a change is still a line. A frame costs what changed: one pass or tiles is chosen
frame by frame. A slow reader of stdout slows the producer: nothing is dropped, and memory stays
bounded. A slow consumer on a socket slows no other. A stream that no consumer follows costs only
taking its points in. A simplified view costs a pass over the skeleton in every frame.

With --metric, each frame is computed anew, in memory that stays: at 1,000 points it takes 7 to 30 ms,
at 2,000 four times as long. Keep windows small: --max-vertices is 4096 unless you say more.

Ctrl-C and SIGTERM finish and send what has come, then end with exit code 0; a second one ends at
once. A closed pipe is not an error.";

const KEYS: &str = "Keys of a JSON line:
  stream    its name
  frame     its number, from 1
  from      the frame that the line is a diff from; 0 is nothing
  time      that of the commit, else the newest event time, else null
  points    how many distinct positions
  rejected  lines and points since the frame before that could not be used
  view      kind, k, l, ds, vs (or alpha), components, cycles
  vertices  add [[id,x,y]], del [id]: all of the cloud; with --metric [id,x1,...,xd]
  edges     add [[a,b]], del [[a,b]]: the view's tree edges, smaller id first
  critical  set [[a,b,birth,death]], del [[a,b]]
  checksum  of all that a consumer then holds, 16 hexadecimal digits (protocol/SPEC.md)
  tracks    with --track: id, event, age, birth, death, center, radius, area, velocity, and of
            some events from (split), into (merged), changed (updated: center, birth, death)
  alive     with --track-list: [[id,x,y,radius,birth,death]]

A vertex is a distinct position. Its id is never used again, and lasts until the last point on it
is gone at the end of a frame. All lists are sorted. What did not change is not mentioned. A number
that is not finite is null.

Events: born, split, updated, unselected, reselected, merged, died. Where a hole divides, the part
with the larger death keeps the id; where two become one, the one with the larger death goes on.";

#[derive(Clone, Copy, Debug, Default, ValueEnum)]
enum InputFormat {
    /// By the file's name, else its first bytes: text or JSON lines.
    #[default]
    Auto,
    /// A table: comma, semicolon, tab or blank separated.
    Text,
    /// JSON lines: [x,y], [x,y,t], {"x":..,"y":..,"t":..}, {"points":[[x,y],...],"t":..}, {"retract":[[x,y],...]},
    /// {"commit":true,"time":t}.
    Jsonl,
    /// Messages of the protocol: Batch, Retract and Commit.
    Bin,
}

#[derive(Clone, Copy, Debug, Default, ValueEnum)]
enum OutputFormat {
    /// A JSON line a frame.
    #[default]
    Jsonl,
    /// A recording in the protocol's bytes, for replay.
    Bin,
}

impl Serve {
    pub fn run(self) -> Result<(), Failure> {
        let alone = self.sockets.listen.is_empty();
        let input = self.input.or(alone.then(InputFormat::default));
        let output = self.output.or((alone && self.page.address.is_none()).then(OutputFormat::default));
        if input.is_some() {
            files::check_stdin()?;
        }
        let space = self.space.space()?;
        let sink = output.map(|output| self.sink(output, space.is_some())).transpose()?;
        let source = input.map(|input| self.source(input, space)).transpose()?;
        let allow_remote = self.sockets.allow_remote;
        let PageArgs { address, hosts, origins } = self.page.clone();
        let page =
            address.map(|address| Page::bind(PageAddress { address, hosts, origins, allow_remote })).transpose()?;
        let stop = Stop::listen().context("cannot listen to signals")?;
        Ok(daemon::run(self.settings(space)?, source, sink, page.map(Page::http), &stop)?)
    }

    fn source(&self, input: InputFormat, space: Option<StreamSpace>) -> Result<Source, Failure> {
        let columns = self.columns.as_deref();
        let form = match input {
            InputFormat::Auto => form(space, None, columns, self.project)?,
            InputFormat::Text => form(space, Some(Format::Text), columns, self.project)?,
            InputFormat::Jsonl => form(space, Some(Format::JsonLines), columns, self.project)?,
            InputFormat::Bin => Form::Binary,
        };
        let form = form.with_times(matches!(self.window, hopes::topology::Window::Time(_)));
        let project = self.project;
        Ok(Box::new(move |feed| read_stdin(form, project, feed)))
    }

    fn sink(&self, output: OutputFormat, is_of_space: bool) -> Result<Box<dyn Sink>, Failure> {
        let (form, stdout) = match output {
            OutputFormat::Jsonl => (FrameForm::Lines, files::stdout()?),
            OutputFormat::Bin => (FrameForm::Binary, files::binary_stdout("a recording", "--output jsonl")?),
        };
        let writer = FrameWriter::new(form, self.track_list, stdout);
        Ok(Box::new(Frames(if is_of_space { writer.of_space() } else { writer })))
    }

    fn settings(self, space: Option<StreamSpace>) -> Result<Settings, Failure> {
        let listen = self.sockets.listen.iter().map(Place::address).collect::<Result<_, _>>()?;
        let space = space.map(|space| space.rule(self.sockets.max_vertices));
        Ok(Settings {
            default_stream: StreamSettings {
                options: PipelineOptions { window: self.window, resolution: self.resolution, space },
                frame_points: self.frame_points,
                frame_every: self.frame_every,
            },
            view: View { cut: daemon::cut(self.view.spec()), simplify: Simplify::No },
            tracking: self.tracks.options(self.view.spec()),
            strict: self.strict,
            check: self.check,
            threads: self.threads,
            overload: self.sockets.overload.into(),
            limits: self.sockets.limits(),
            listen,
            allow_remote: self.sockets.allow_remote,
            streams: self.sockets.streams(),
        })
    }
}

/// The frames on stdout.
struct Frames(FrameWriter<File>);

impl Sink for Frames {
    fn write(&mut self, frame: OutputFrame) -> io::Result<()> {
        self.0.write(frame)
    }

    /// A failure before anything was written leaves nothing.
    fn finish(&mut self, failure: Option<&str>) -> io::Result<()> {
        match failure {
            Some(_) if !self.0.has_begun() => Ok(()),
            Some(failure) => self.0.finish(failure),
            None => self.0.finish("the daemon has ended"),
        }
    }
}

fn read_stdin(form: Form, project: ProjectArgs, feed: &Feed) {
    let origin = Origin::Stdin;
    let is_projected = project.is_on();
    let stdin =
        PointSource { origin, form, frame_points: None, closes_last: false, loops: false, batch: BATCH, is_projected };
    let mut projector = project.projector();
    let mut send = |input| match &mut projector {
        Some(projector) => projector.send(input, &mut |input| feed.send(input)),
        None => feed.send(input),
    };
    if let Err(error) = stdin.read(&mut send, &|_| ()) {
        feed.send(Input::Failed(format!("{:#}", anyhow::Error::from(error))));
    }
}
