//! The table of tracks, for people, as CSV and as JSON.
//!
//! In: lives.
//! Out: a line, or an object, a track; by stream, then by id.
//! Invariants: CSV and JSON have all columns always, the table for people only those that are not empty. A value
//! that is not known is `-`, empty or null. Only the present line is kept.
//! Must not know: how lives were read.

use std::io::{self, Write};

use serde::{Serialize, Serializer};

use super::frame::Moment;
use super::lives::{Began, Ended, Life, Lives, Stream};
use crate::formats::aligned::{self, Column, numbers, words};
use crate::formats::short::Short;

/// How the table is written.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum TableFormat {
    /// Columns, for people.
    #[default]
    Table,
    /// With a header line.
    Csv,
    /// One object on one line.
    Json,
}

impl TableFormat {
    /// Writes all tracks; `rejected` lines were not understood.
    pub fn write(self, lives: &Lives, rejected: u64, out: &mut impl Write) -> io::Result<()> {
        match self {
            Self::Table => write_table(lives, out),
            Self::Csv => write_csv(lives, out),
            Self::Json => {
                serde_json::to_writer(&mut *out, &Whole { streams: Streams(lives), rejected, tracks: Tracks(lives) })?;
                out.write_all(b"\n")
            }
        }?;
        out.flush()
    }
}

// ---- for people

fn write_table(lives: &Lives, out: &mut impl Write) -> io::Result<()> {
    let (has_streams, has_times) = (lives.streams.len() > 1, lives.have_any_time());
    let mut columns: Vec<Column> = Vec::new();
    if has_streams {
        columns.push(words("stream"));
    }
    columns.extend([numbers("id"), numbers("from"), numbers("to")]);
    if has_times {
        columns.extend([numbers("from time"), numbers("to time")]);
    }
    columns.extend([words("began"), words("ended"), numbers("persistence")]);
    let axes = axes(lives);
    columns.extend(axes.iter().copied().map(numbers));
    columns.push(numbers("radius"));
    let rows = lives.all().map(|(name, stream, life)| {
        let mut row: Vec<String> = Vec::with_capacity(columns.len());
        if has_streams {
            row.push(name.to_owned());
        }
        let (from, to) = (life.from, stream.to(life));
        row.extend([life.id, from.frame, to.frame].map(|number| number.to_string()));
        if has_times {
            row.extend([from, to].map(|moment| moment.time.map_or(UNKNOWN.to_owned(), time)));
        }
        row.extend([began(life.began), ended(life.ended)]);
        row.push(short(life.sight.persistence()));
        row.extend(coordinates(life, axes).map(short));
        row.push(short(life.sight.radius));
        row
    });
    aligned::write(out, &columns, rows)
}

const UNKNOWN: &str = "-";

fn short(value: Option<f64>) -> String {
    value.map_or(UNKNOWN.to_owned(), |value| Short(value).to_string())
}

/// Great times differ in their last digits: those before the point are all shown.
fn time(time: f64) -> String {
    let text = time.to_string();
    match time.abs() {
        _ if text.len() <= 8 => text,
        1e-2..1e15 => format!("{time:.4}"),
        _ => format!("{time:.8e}"),
    }
}

fn began(began: Began) -> String {
    match began {
        Began::Born => "born".to_owned(),
        Began::Split { from } => format!("split from {from}"),
        Began::Before => "before".to_owned(),
    }
}

fn ended(ended: Ended) -> String {
    match ended {
        Ended::Died => "died".to_owned(),
        Ended::Merged { into } => format!("merged into {into}"),
        Ended::Alive => "alive".to_owned(),
    }
}

/// The axes that columns have: of centres with more coordinates than z, the first three.
fn axes(lives: &Lives) -> &'static [&'static str] {
    const AXES: [&str; 3] = ["x", "y", "z"];
    let has_third = |life: &Life| life.sight.center.as_ref().is_some_and(|center| center.len() > 2);
    if lives.all().any(|(_, _, life)| has_third(life)) { &AXES } else { &AXES[..2] }
}

fn coordinates(life: &Life, axes: &'static [&'static str]) -> impl Iterator<Item = Option<f64>> {
    (0..axes.len()).map(|axis| life.sight.center.as_ref()?.get(axis).copied())
}

// ---- CSV

const HEADER: &str = "stream,id,from_frame,to_frame,from_time,to_time,began,split_from,ended,merged_into,\
                      peak_frame,peak_time,persistence,birth,death";

fn write_csv(lives: &Lives, out: &mut impl Write) -> io::Result<()> {
    let axes = axes(lives);
    writeln!(out, "{HEADER},{},radius", axes.join(","))?;
    for (name, stream, life) in lives.all() {
        let (from, to, sight) = (life.from, stream.to(life), &life.sight);
        let (begin, end) = (Begin::of(life.began), End::of(life.ended));
        write!(out, "{},{},{},{},", quoted(name), life.id, from.frame, to.frame)?;
        write!(out, "{},{},", cell(from.time), cell(to.time))?;
        write!(out, "{},{},{},{},", begin.began, cell(begin.split_from), end.ended, cell(end.merged_into))?;
        write!(out, "{},{},", life.peak.frame, cell(life.peak.time))?;
        let label = [sight.persistence(), sight.birth, sight.death].into_iter();
        let numbers: Vec<String> = label.chain(coordinates(life, axes)).chain([sight.radius]).map(cell).collect();
        writeln!(out, "{}", numbers.join(","))?;
    }
    Ok(())
}

fn cell<T: ToString>(value: Option<T>) -> String {
    value.map_or_else(String::new, |value| value.to_string())
}

fn quoted(name: &str) -> String {
    if name.contains([',', '"']) { format!("\"{}\"", name.replace('"', "\"\"")) } else { name.to_owned() }
}

// ---- JSON

#[derive(Serialize)]
struct Whole<'a> {
    streams: Streams<'a>,
    rejected: u64,
    tracks: Tracks<'a>,
}

/// A list that is written piece by piece.
struct Streams<'a>(&'a Lives);

impl Serialize for Streams<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_seq(self.0.streams.iter().map(|(name, stream)| {
            let &Stream { first, last, frames, .. } = stream;
            StreamLine { stream: name, frames, from: first.into(), to: last.into() }
        }))
    }
}

/// A list that is written piece by piece.
struct Tracks<'a>(&'a Lives);

impl Serialize for Tracks<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_seq(self.0.all().map(|(name, stream, life)| TrackLine::new(name, stream, life)))
    }
}

#[derive(Serialize)]
struct StreamLine<'a> {
    stream: &'a str,
    frames: u64,
    from: MomentLine,
    to: MomentLine,
}

#[derive(Serialize)]
struct TrackLine<'a> {
    stream: &'a str,
    id: u64,
    from: MomentLine,
    to: MomentLine,
    #[serde(flatten)]
    begin: Begin,
    #[serde(flatten)]
    end: End,
    peak: PeakLine<'a>,
}

impl<'a> TrackLine<'a> {
    fn new(name: &'a str, stream: &Stream, life: &'a Life) -> Self {
        let sight = &life.sight;
        let peak = PeakLine {
            at: life.peak.into(),
            persistence: sight.persistence(),
            birth: sight.birth,
            death: sight.death,
            center: sight.center.as_deref(),
            radius: sight.radius,
        };
        let (from, to) = (life.from.into(), stream.to(life).into());
        Self { stream: name, id: life.id, from, to, begin: Begin::of(life.began), end: End::of(life.ended), peak }
    }
}

#[derive(Serialize)]
struct MomentLine {
    frame: u64,
    time: Option<f64>,
}

impl From<Moment> for MomentLine {
    fn from(moment: Moment) -> Self {
        Self { frame: moment.frame, time: moment.time }
    }
}

#[derive(Serialize)]
struct Begin {
    began: &'static str,
    split_from: Option<u64>,
}

impl Begin {
    fn of(began: Began) -> Self {
        match began {
            Began::Born => Self { began: "born", split_from: None },
            Began::Split { from } => Self { began: "split", split_from: Some(from) },
            Began::Before => Self { began: "before", split_from: None },
        }
    }
}

#[derive(Serialize)]
struct End {
    ended: &'static str,
    merged_into: Option<u64>,
}

impl End {
    fn of(ended: Ended) -> Self {
        match ended {
            Ended::Died => Self { ended: "died", merged_into: None },
            Ended::Merged { into } => Self { ended: "merged", merged_into: Some(into) },
            Ended::Alive => Self { ended: "alive", merged_into: None },
        }
    }
}

#[derive(Serialize)]
struct PeakLine<'a> {
    #[serde(flatten)]
    at: MomentLine,
    persistence: Option<f64>,
    birth: Option<f64>,
    death: Option<f64>,
    center: Option<&'a [f64]>,
    radius: Option<f64>,
}
