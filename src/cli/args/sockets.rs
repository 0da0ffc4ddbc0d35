//! Options of a daemon that others connect to.
//!
//! In: words of the command line.
//! Out: the daemon's limits, policies and streams.
//! Must not know: sockets.

use std::num::NonZeroUsize;
use std::time::Duration;

use clap::{Args, ValueEnum};
use hopes::topology::spaces::{MAX_DIMENSION, MAX_VERTICES, Metric};
use hopes_protocol::Policy;

use super::metric::MetricWord;
use super::place::{Place, USUAL};
use super::values::{bytes, duration, how_many, many, resolution, whole, window, within};
use crate::daemon::{Limits, Overload, SpaceRule, StreamSettings};

/// The options that open a way in; one of them must be given for others to make sense.
pub const PLACES: &str = "places";

/// How others connect, and how much they may do.
#[derive(Debug, Args)]
#[command(next_help_heading = "Sockets")]
pub struct SocketArgs {
    /// Let producers and consumers connect at unix:PATH or tcp:HOST:PORT [without an address: at $HOPES_ADDRESS, else
    /// at your own socket]. May be repeated.
    ///
    /// Your own socket is hopes.sock in $XDG_RUNTIME_DIR, else in hopes-UID in the folder for temporary files. Clients
    /// that are given no address connect there.
    ///
    /// Unix sockets are made with mode 0600; one that a dead daemon has left is replaced. TCP is for this machine only,
    /// unless --allow-remote is given. With --listen, stdin is read and stdout is written only if --input or --output
    /// is given, for the stream "default", and the daemon runs until a signal comes.
    #[arg(long, value_name = "ADDRESS", num_args = 0..=1, default_missing_value = USUAL, group = PLACES)]
    pub listen: Vec<Place>,
    /// Let peers and browsers come from other machines too: there is no password.
    #[arg(long, requires = PLACES)]
    pub allow_remote: bool,
    /// Make a stream at the start. May be repeated; producers make others.
    ///
    /// NAME, or NAME:OPTION=VALUE,... of window, resolution, frame-points, frame-every, and for points of R^d metric
    /// (euclidean, manhattan, chebyshev, angular, haversine) and dimension.
    #[arg(long, value_name = "NAME[:OPTIONS]", value_parser = stream, requires = PLACES)]
    stream: Vec<(String, StreamSettings)>,
    /// What happens when a producer is faster than its stream.
    #[arg(long, value_enum, default_value_t)]
    pub overload: OverloadArg,
    /// Connections at one time; visitors of the page are at most a quarter of them (at least 16).
    #[arg(long, value_name = "N", default_value_t = Limits::default().connections, value_parser = how_many)]
    max_connections: usize,
    /// Streams at one time.
    #[arg(long, value_name = "N", default_value_t = Limits::default().streams, value_parser = how_many)]
    max_streams: usize,
    /// Of them, those that one connection has made.
    #[arg(long, value_name = "N", default_value_t = Limits::default().peer_streams, value_parser = how_many)]
    max_peer_streams: usize,
    /// End a stream that a producer has made once nobody has fed or followed it for so long [default: never].
    ///
    /// Streams given by --stream stay.
    #[arg(long, value_name = "DURATION", value_parser = duration)]
    stream_ttl: Option<Duration>,
    /// Different views of one stream; a consumer that wants another one is refused, with the reason.
    #[arg(long, value_name = "N", default_value_t = Limits::default().views, value_parser = many)]
    max_views: NonZeroUsize,
    /// Different views that one connection follows.
    #[arg(long, value_name = "N", default_value_t = Limits::default().peer_views, value_parser = many)]
    max_peer_views: NonZeroUsize,
    /// Points in the window of a stream; more are refused, with the reason.
    #[arg(long, value_name = "N", default_value_t = Limits::default().points, value_parser = whole)]
    max_points: u64,
    /// Distinct positions in a stream; more are refused, with the reason [default: 20000000; 4096 with a metric].
    ///
    /// With a metric, a frame costs time and memory by their square, and there may be 65536.
    #[arg(long, value_name = "N", value_parser = whole)]
    pub max_vertices: Option<u64>,
    /// Points in one message; a message has at most 4 MiB.
    #[arg(
        long,
        value_name = "N",
        default_value_t = Limits::default().largest_batch,
        value_parser = within::<1, 100_000>
    )]
    max_batch: u32,
    /// Memory of all streams and peers, such as 512MiB or 4GiB [default: no limit].
    ///
    /// At the limit the changes kept (--history) go first, then consumers that do not read, then streams that nobody
    /// uses; new consumers are refused. Batches are refused only when points alone take all of it. It is an estimate:
    /// see `hopes status --memory`.
    #[arg(long, value_name = "BYTES", value_parser = bytes)]
    max_memory: Option<u64>,
    /// How far a consumer may be behind before frames are merged for it.
    ///
    /// Then they become one diff, or a snapshot where that is smaller, and the consumer is sent "lagged".
    #[arg(long, value_name = "BYTES", value_parser = bytes, default_value = "1MiB")]
    consumer_queue: u64,
    /// Changes kept of each view, for consumers that are behind or come back.
    ///
    /// A view that no consumer follows is kept for a minute.
    #[arg(long, value_name = "BYTES", value_parser = bytes, default_value = "16MiB")]
    history: u64,
    /// Send a heartbeat to a consumer to which nothing was sent for so long.
    #[arg(long, value_name = "DURATION", value_parser = duration, default_value = "5s")]
    heartbeat: Duration,
    /// Disconnect a peer that sends nothing for so long, or takes so long for one message.
    ///
    /// After half of it, a silent peer is pinged.
    #[arg(long, value_name = "DURATION", value_parser = duration, default_value = "60s")]
    timeout: Duration,
}

/// What happens when a producer is faster than its stream.
#[derive(Clone, Copy, Debug, Default, ValueEnum)]
pub enum OverloadArg {
    /// The producer waits: its points are not read any further.
    #[default]
    Block,
    /// The batches that have waited longest are dropped; each producer is sent which of its own. Commits are kept.
    DropOldest,
    /// The batches that come are dropped; each producer is sent which of its own. Commits are kept.
    DropNewest,
}

impl From<OverloadArg> for Overload {
    fn from(overload: OverloadArg) -> Self {
        match overload {
            OverloadArg::Block => Self::Block,
            OverloadArg::DropOldest => Self::Drop(Policy::DropOldest),
            OverloadArg::DropNewest => Self::Drop(Policy::DropNewest),
        }
    }
}

impl SocketArgs {
    /// The limits that they ask for.
    pub fn limits(&self) -> Limits {
        let usual = Limits::default();
        Limits {
            connections: self.max_connections,
            streams: self.max_streams,
            peer_streams: self.max_peer_streams,
            stream_ttl: self.stream_ttl,
            views: self.max_views,
            peer_views: self.max_peer_views,
            points: self.max_points,
            vertices: self.max_vertices.unwrap_or(usual.vertices),
            space_vertices: self.space_vertices(),
            largest_batch: self.max_batch,
            memory: self.max_memory.unwrap_or(0),
            consumer_queue: self.consumer_queue as usize,
            history: self.history as usize,
            heartbeat: self.heartbeat,
            timeout: self.timeout,
            ..usual
        }
    }

    /// The streams to be made at the start.
    pub fn streams(self) -> Vec<(String, StreamSettings)> {
        let most = self.space_vertices();
        let mut streams = self.stream;
        for space in streams.iter_mut().filter_map(|(_, settings)| settings.options.space.as_mut()) {
            space.max_vertices = most;
        }
        streams
    }

    fn space_vertices(&self) -> usize {
        let most = self.max_vertices.map_or(Limits::default().space_vertices, |most| most as usize);
        most.clamp(1, MAX_VERTICES)
    }
}

/// A stream and its options: `NAME`, or `NAME:window=points:1000,resolution=0.5`.
fn stream(word: &str) -> Result<(String, StreamSettings), String> {
    let (name, options) = word.split_once(':').unwrap_or((word, ""));
    if !hopes_protocol::is_name(name) {
        return Err(format!(
            "{name:?} is no name: it has 1 to {} bytes, no control character and no *",
            hopes_protocol::LONGEST_NAME
        ));
    }
    let mut settings = StreamSettings::default();
    let (mut metric, mut dimension) = (None, None);
    for option in options.split(',').filter(|option| !option.is_empty()) {
        let (key, value) = option.split_once('=').ok_or_else(|| format!("{option:?} is no option: write KEY=VALUE"))?;
        match key {
            "window" => settings.options.window = window(value)?,
            "resolution" => settings.options.resolution = Some(resolution(value)?),
            "frame-points" => {
                let count = value.parse().ok().filter(|count| *count > 0);
                settings.frame_points =
                    Some(count.ok_or_else(|| format!("{value:?} is not a number of points, from 1"))?);
            }
            "frame-every" => settings.frame_every = Some(duration(value)?),
            "metric" => metric = Some(points_metric(value)?),
            "dimension" => dimension = Some(within::<1, { MAX_DIMENSION as u32 }>(value)? as usize),
            _ => {
                return Err(format!(
                    "{key:?} is no option of a stream: there are window, resolution, frame-points, frame-every, metric, \
                     dimension"
                ));
            }
        }
    }
    settings.options.space = space(metric, dimension)?;
    Ok((name.to_owned(), settings))
}

/// The space of points of R^d; none for the plane.
fn space(metric: Option<Metric>, dimension: Option<usize>) -> Result<Option<SpaceRule>, String> {
    let Some(metric) = metric else {
        return match dimension {
            Some(_) => Err("dimension is for points of R^d: give a metric too, such as metric=euclidean".to_owned()),
            None => Ok(None),
        };
    };
    dimension.map_or(Ok(()), |dimension| metric.check_dimension(dimension)).map_err(|error| error.to_string())?;
    Ok(Some(SpaceRule { metric, dimension, max_vertices: Limits::default().space_vertices }))
}

fn points_metric(word: &str) -> Result<Metric, String> {
    let known = MetricWord::from_str(word, false).ok().and_then(MetricWord::of_points);
    known.ok_or_else(|| {
        format!("{word:?} is no metric of points: there are euclidean, manhattan, chebyshev, angular, haversine")
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn streams_have_names_and_options() {
        let (name, settings) = stream("cam:window=frames:1,resolution=0.5,frame-points=100,frame-every=20ms").unwrap();
        assert_eq!((name.as_str(), settings.options.resolution, settings.frame_points), ("cam", Some(0.5), Some(100)));
        assert_eq!(settings.frame_every, Some(Duration::from_millis(20)));
        assert_eq!(settings.options.window, window("frames:1").unwrap());
        assert_eq!(stream("cam").unwrap().0, "cam");
    }

    #[test]
    fn bad_streams_say_what_is_wrong() {
        for (word, says) in [
            ("", "no name"),
            ("a*", "no name"),
            ("a:window", "KEY=VALUE"),
            ("a:window=x", "a window is all"),
            ("a:colour=red", "there are window"),
            ("a:frame-points=0", "from 1"),
        ] {
            let error = stream(word).unwrap_err();
            assert!(error.contains(says), "{word}: {error}");
        }
    }
}
