//! The daemon's metrics for Prometheus, in the text format of OpenMetrics 1.0.
//!
//! In: the daemon's status; what is measured of streams beyond it.
//! Out: the text of one scrape.
//! Invariants: the names are documented and stay. Names of streams, which any producer chooses, are escaped.
//! Must not know: how the numbers come about, HTTP.

#[cfg(target_os = "linux")]
mod process;

use std::fmt;

use hopes_protocol::{Peer, Status, StreamStatus};
use prometheus_client::collector::Collector;
use prometheus_client::encoding::{DescriptorEncoder, EncodeGaugeValue, EncodeMetric, text};
use prometheus_client::metrics::counter::ConstCounter;
use prometheus_client::metrics::gauge::ConstGauge;
use prometheus_client::metrics::histogram::Histogram;
use prometheus_client::metrics::{MetricType, TypedMetric};
use prometheus_client::registry::{Registry, Unit};

use crate::daemon::{FrameTimes, Measured};

/// The media type of the text.
pub const MEDIA_TYPE: &str = "application/openmetrics-text; version=1.0.0; charset=utf-8";

/// The metrics of one scrape, as text.
///
/// # Errors
/// Of the encoder, which has none to expect.
pub fn write(status: Status, peers: Peers, measured: Vec<Measured>) -> Result<String, fmt::Error> {
    let mut registry = Registry::default();
    registry.register_collector(Box::new(Scrape { status, peers, measured }));
    let mut out = String::new();
    text::encode(&mut out, &registry)?;
    Ok(out)
}

/// What is known of peers.
#[derive(Debug, Default)]
pub struct Peers {
    /// Those that are connected.
    pub list: Vec<Peer>,
    /// How many were cut off so far.
    pub cut_off: u64,
}

/// What is encoded in one scrape.
#[derive(Debug)]
struct Scrape {
    status: Status,
    peers: Peers,
    measured: Vec<Measured>,
}

/// A metric of every stream or every peer: a counter or a gauge, named without its unit and without `_total`.
struct Metric<T> {
    name: &'static str,
    help: &'static str,
    unit: Option<Unit>,
    kind: MetricType,
    value: fn(&T) -> u64,
}

const fn counter<T>(name: &'static str, help: &'static str, value: fn(&T) -> u64) -> Metric<T> {
    Metric { name, help, unit: None, kind: MetricType::Counter, value }
}

const fn gauge<T>(name: &'static str, help: &'static str, value: fn(&T) -> u64) -> Metric<T> {
    Metric { name, help, unit: None, kind: MetricType::Gauge, value }
}

const fn bytes<T>(kind: MetricType, name: &'static str, help: &'static str, value: fn(&T) -> u64) -> Metric<T> {
    Metric { name, help, unit: Some(Unit::Bytes), kind, value }
}

const STREAM_METRICS: [Metric<StreamStatus>; 12] = [
    counter("hopes_stream_frames", "Frames closed.", |stream| stream.info.frame),
    gauge("hopes_stream_points", "Points in the window.", |stream| stream.info.points),
    gauge("hopes_stream_vertices", "Distinct positions in the window.", |stream| stream.info.vertices),
    gauge("hopes_stream_producers", "Channels that produce points.", |stream| stream.info.producers as u64),
    gauge("hopes_stream_consumers", "Channels that consume frames.", |stream| stream.info.consumers as u64),
    counter("hopes_stream_computed", "Skeletons computed.", |stream| stream.computed),
    counter("hopes_stream_accepted_points", "Points accepted.", |stream| stream.accepted),
    counter("hopes_stream_refused_points", "Points refused.", |stream| stream.refused),
    counter("hopes_stream_dropped_points", "Points dropped by overload.", |stream| stream.dropped),
    gauge("hopes_stream_waiting_points", "Points that wait for the engine.", |stream| stream.waiting),
    counter("hopes_stream_lagged_frames", "Frames that lagging consumers did not get singly.", |stream| stream.lagged),
    bytes(MetricType::Gauge, "hopes_stream_memory", "Estimate of the memory held.", |stream| stream.memory),
];

const MEASURED_METRICS: [Metric<Measured>; 2] = [
    counter(
        "hopes_stream_refused_at_commit",
        "Points and retractions that were accepted and then refused at their commit.",
        |stream| stream.refused_late,
    ),
    counter("hopes_stream_window_restarts", "How often the time window has started anew.", |stream| stream.restarts),
];

const PEER_METRICS: [Metric<Peer>; 4] = [
    bytes(MetricType::Counter, "hopes_peer_received", "Received from a peer.", |peer| peer.received),
    bytes(MetricType::Counter, "hopes_peer_sent", "Sent to a peer.", |peer| peer.sent),
    counter("hopes_peer_lagged_frames", "Frames that a peer did not get singly.", |peer| peer.lagged),
    bytes(MetricType::Gauge, "hopes_peer_memory", "Estimate of the memory held for a peer.", |peer| peer.held),
];

/// A histogram of every stream, in seconds.
type FrameTime = (&'static str, &'static str, fn(&FrameTimes) -> &Histogram);

const FRAME_TIMES: [FrameTime; 4] = [
    ("hopes_stream_frame", "Time from the first point of a frame to its publication.", |times| &times.total),
    ("hopes_stream_triangulation", "Time to update the triangulation, of each frame.", |times| &times.triangulation),
    ("hopes_stream_reduction", "Time to reduce the filtration, of each frame.", |times| &times.reduction),
    ("hopes_stream_publishing", "Time to publish the views, of each frame.", |times| &times.publishing),
];

impl Collector for Scrape {
    fn encode(&self, mut encoder: DescriptorEncoder) -> fmt::Result {
        let encoder = &mut encoder;
        let Status { uptime_ms, connections, refused_messages, memory, streams, .. } = &self.status;
        let uptime = *uptime_ms as f64 / 1000.0;
        encode_gauge(encoder, "hopes_uptime", "Time since the start.", Some(&Unit::Seconds), uptime)?;
        encode_gauge(encoder, "hopes_connections", "Peers that are connected.", None, u64::from(*connections))?;
        let help = "Messages that could not be decoded or were not expected.";
        encode_counter(encoder, "hopes_refused_messages", help, None, ConstCounter::new(*refused_messages))?;
        let help = "Estimate of the memory held for all streams and peers.";
        encode_gauge(encoder, "hopes_memory", help, Some(&Unit::Bytes), *memory)?;
        encode_gauge(encoder, "hopes_streams", "Streams.", None, streams.len() as u64)?;
        for metric in &STREAM_METRICS {
            encode_all(encoder, metric, streams, |stream| ("stream", stream.info.name.clone()))?;
        }
        for metric in &MEASURED_METRICS {
            encode_all(encoder, metric, &self.measured, |stream| ("stream", stream.name.clone()))?;
        }
        let help = "Peers that were cut off for what they did not read.";
        encode_counter(encoder, "hopes_cut_off_peers", help, None, ConstCounter::new(self.peers.cut_off))?;
        for metric in &PEER_METRICS {
            encode_all(encoder, metric, &self.peers.list, |peer| ("peer", peer.peer.to_string()))?;
        }
        for metric in &FRAME_TIMES {
            self.encode_frame_times(encoder, metric)?;
        }
        #[cfg(target_os = "linux")]
        process::encode(encoder)?;
        Ok(())
    }
}

impl Scrape {
    fn encode_frame_times(&self, encoder: &mut DescriptorEncoder, metric: &FrameTime) -> fmt::Result {
        let (name, help, histogram) = metric;
        let mut family = encoder.encode_descriptor(name, help, Some(&Unit::Seconds), MetricType::Histogram)?;
        for Measured { name, times, .. } in &self.measured {
            let labels = [("stream", &name[..])];
            histogram(times).encode(family.encode_family(&labels)?)?;
        }
        Ok(())
    }
}

/// Encodes a metric of all streams, or of all peers, each with its label.
fn encode_all<T>(
    encoder: &mut DescriptorEncoder,
    metric: &Metric<T>,
    all: &[T],
    label: impl Fn(&T) -> (&'static str, String),
) -> fmt::Result {
    let mut family = encoder.encode_descriptor(metric.name, metric.help, metric.unit.as_ref(), metric.kind)?;
    for one in all {
        let labels = [label(one)];
        let (encoder, value) = (family.encode_family(&labels)?, (metric.value)(one));
        match metric.kind {
            MetricType::Counter => ConstCounter::new(value).encode(encoder)?,
            _ => ConstGauge::new(value).encode(encoder)?,
        }
    }
    Ok(())
}

/// Encodes a gauge without labels; its full name ends with its unit.
fn encode_gauge<N>(
    encoder: &mut DescriptorEncoder,
    name: &str,
    help: &str,
    unit: Option<&Unit>,
    value: N,
) -> fmt::Result
where
    N: EncodeGaugeValue,
    ConstGauge<N>: EncodeMetric,
{
    ConstGauge::new(value).encode(encoder.encode_descriptor(name, help, unit, MetricType::Gauge)?)
}

/// Encodes a counter without labels; its full name ends with its unit and `_total`.
fn encode_counter<N>(
    encoder: &mut DescriptorEncoder,
    name: &str,
    help: &str,
    unit: Option<&Unit>,
    counter: ConstCounter<N>,
) -> fmt::Result
where
    ConstCounter<N>: EncodeMetric + TypedMetric,
{
    counter.encode(encoder.encode_descriptor(name, help, unit, MetricType::Counter)?)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn status(streams: Vec<StreamStatus>) -> Status {
        Status {
            software: "test".to_owned(),
            epoch: 1,
            uptime_ms: 1500,
            connections: 2,
            refused_messages: 3,
            memory: u64::MAX,
            memory_limit: 0,
            streams,
        }
    }

    #[test]
    fn labels_are_escaped() {
        let name = "a\"} 1\nb\\";
        let text =
            write(status(vec![]), Peers::default(), vec![Measured { name: name.to_owned(), ..Measured::default() }])
                .unwrap();
        let escaped = "{stream=\"a\\\"} 1\\nb\\\\\"}";
        assert!(text.lines().any(|line| line == format!("hopes_stream_frame_seconds_count{escaped} 0")), "{text}");
        assert!(!text.lines().any(|line| line.starts_with('b')), "{text}");
    }

    #[test]
    fn numbers_keep_all_their_digits() {
        let text = write(status(vec![]), Peers::default(), vec![]).unwrap();
        for line in
            ["hopes_uptime_seconds 1.5", "hopes_refused_messages_total 3", "hopes_memory_bytes 18446744073709551615"]
        {
            assert!(text.lines().any(|found| found == line), "{line}: {text}");
        }
        assert!(text.ends_with("\n# EOF\n"));
    }

    #[test]
    fn observed_times_are_counted() {
        let times = FrameTimes::default();
        times.total.observe(0.003);
        times.total.observe(100.0);
        let measured = Measured { name: "a".to_owned(), refused_late: 7, restarts: 1, times };
        let text = write(status(vec![]), Peers::default(), vec![measured]).unwrap();
        for line in [
            "hopes_stream_frame_seconds_count{stream=\"a\"} 2",
            "hopes_stream_frame_seconds_sum{stream=\"a\"} 100.003",
            "hopes_stream_frame_seconds_bucket{le=\"0.0032\",stream=\"a\"} 1",
            "hopes_stream_frame_seconds_bucket{le=\"+Inf\",stream=\"a\"} 2",
            "hopes_stream_reduction_seconds_count{stream=\"a\"} 0",
            "hopes_stream_refused_at_commit_total{stream=\"a\"} 7",
            "hopes_stream_window_restarts_total{stream=\"a\"} 1",
        ] {
            assert!(text.lines().any(|found| found == line), "{line}: {text}");
        }
    }
}
