//! The JSON answer of `compute`; its keys stand in `hopes compute --help`.
//!
//! In: an [`Answer`].
//! Out: one JSON object on one line.
//! Invariants: lists are written piece by piece, never held as a whole; their pieces are made on all cores. The
//! bytes do not depend on the number of cores. Numbers that are not finite are null. A vertex is the list of its
//! coordinates; in a space without coordinates it is its label. Its threads end with the call.
//! Must not know: files.

use std::collections::VecDeque;
use std::io::{self, Write};
use std::num::NonZero;
use std::ops::Range;
use std::thread;

use hopes::topology::{Decluttered, Dot, Edge, Filtration, Killer, Margins, Positions, Simplified, ViewSpec};
use serde::Serialize;

use super::{Answer, Outliers};

/// Elements that are made into text at a time.
const PIECE: usize = 4096;

/// Writes the answer and a line end.
pub fn write(answer: &Answer, out: &mut impl Write) -> io::Result<()> {
    let skeleton = answer.skeleton;
    let points = skeleton.vertices().len();
    write!(out, "{{\"points\":{points},\"duplicates\":{},\"rejected\":{},", answer.duplicates, answer.rejected)?;
    if let Some(outliers) = answer.outliers {
        write_outliers(outliers, out)?;
    }
    if skeleton.filtration() == Filtration::Rips {
        write!(out, "\"filtration\":\"rips\",\"dimension\":{},", skeleton.vertices().dimension())?;
    }
    if let Some(landmarks) = answer.landmarks {
        let radius = number(landmarks.covering_radius);
        write!(out, "\"landmarks\":{},\"covering_radius\":{radius},", landmarks.vertices.len())?;
    }
    if let Some(projection) = answer.projection {
        let [longitude, latitude] = projection.origin().map(number);
        write!(out, "\"origin\":[{longitude},{latitude}],")?;
    }
    out.write_all(b"\"vertices\":")?;
    write_vertices(answer, out)?;
    out.write_all(b",\"dots\":")?;
    write_list(out, skeleton.dots().len(), |place| labelled(answer, &skeleton.dots()[place]))?;
    out.write_all(b",\"mst\":{\"edges\":")?;
    write_list(out, skeleton.tree().len(), |place| skeleton.tree()[place])?;
    write!(out, ",\"length\":{}}},\"view\":{{", number(skeleton.tree_length()))?;
    write_view(answer, out)?;
    if let Some((threshold, simplified)) = answer.simplified {
        write!(out, ",\"simplified\":{{\"threshold\":{},\"vertices\":", number(threshold))?;
        write_simplified_vertices(answer, simplified, out)?;
        out.write_all(b",\"edges\":")?;
        write_list(out, simplified.edges.len(), |place| simplified.edges[place])?;
        out.write_all(b"}")?;
    }
    out.write_all(b"}\n")
}

fn write_outliers(Outliers { report, positions }: Outliers<'_>, out: &mut impl Write) -> io::Result<()> {
    let Decluttered { filtered, neighbours, radius, rho, expected, is_certified } = report;
    let [radius, rho, expected] = [radius, rho, expected].map(number);
    write!(out, "\"filtered\":{filtered},\"declutter\":{{\"k\":{neighbours},\"radius\":{radius},\"rho\":{rho},")?;
    write!(out, "\"expected\":{expected},\"certified\":{is_certified},\"outliers\":")?;
    write_list(out, positions.len(), |place| positions[place])?;
    out.write_all(b"},")
}

fn write_vertices(answer: &Answer, out: &mut impl Write) -> io::Result<()> {
    let vertices = answer.skeleton.vertices();
    match vertices.dimension() {
        0 => write_list(out, vertices.len(), |place| vertices.ids()[place].0),
        _ => write_list(out, vertices.len(), |place| vertices.coordinates(place as u32)),
    }
}

fn write_simplified_vertices(answer: &Answer, simplified: &Simplified, out: &mut impl Write) -> io::Result<()> {
    let positions = &simplified.positions;
    match positions {
        Positions::Labels(labels) => {
            write_list(out, labels.len(), |place| answer.skeleton.vertices().id(labels[place]).0)
        }
        Positions::Coordinates { .. } => write_list(out, positions.len(), |place| positions.coordinates(place as u32)),
    }
}

fn write_view(answer: &Answer, out: &mut impl Write) -> io::Result<()> {
    let view = answer.view;
    write_kind(answer, out)?;
    out.write_all(b",\"edges\":")?;
    write_list(out, view.tree.len(), |place| view.tree[place])?;
    out.write_all(b",\"critical\":")?;
    let dots = answer.skeleton.dots();
    write_list(out, view.critical.len(), |place| dots[view.critical[place] as usize].edge)?;
    let length = number(view.length(answer.skeleton));
    write!(out, ",\"components\":{},\"cycles\":{},\"length\":{length}}}", view.components, view.cycles)
}

fn write_kind(answer: &Answer, out: &mut impl Write) -> io::Result<()> {
    match answer.view.spec {
        ViewSpec::Full => out.write_all(b"\"kind\":\"full\""),
        ViewSpec::Reduced { alpha } => write!(out, "\"kind\":\"reduced\",\"alpha\":{}", number(alpha)),
        ViewSpec::Derived { k, l } => {
            let selection = answer.view.selection.as_ref();
            let ds = selection.and_then(|selection| selection.ds).unwrap_or(f64::INFINITY);
            let vs = selection.map_or(f64::INFINITY, |selection| selection.vs);
            let Margins { diagonal, vertical } = selection.map(|selection| selection.margins).unwrap_or_default();
            let [diagonal, vertical] = [diagonal, vertical].map(|margin| number(margin.unwrap_or(f64::INFINITY)));
            write!(out, "\"kind\":\"derived\",\"k\":{k},\"l\":{l},\"ds\":{},\"vs\":{},", number(ds), number(vs))?;
            write!(out, "\"margins\":{{\"diagonal\":{diagonal},\"vertical\":{vertical}")?;
            if let Some(landmarks) = answer.landmarks {
                write!(out, ",\"covering_radius\":{}", number(landmarks.covering_radius))?;
            }
            out.write_all(b"}")
        }
    }
}

/// A number, or null.
fn number(value: f64) -> serde_json::Value {
    serde_json::Number::from_f64(value).into()
}

/// A dot, and what is known of its end.
#[derive(Serialize)]
#[serde(untagged)]
enum LabelledDot {
    Alpha { birth: f64, death: f64, edge: Edge, hole: Option<Hole> },
    Rips { birth: f64, death: f64, edge: Edge, death_edge: Option<Edge> },
}

#[derive(Serialize)]
struct Hole {
    center: [f64; 2],
    radius: f64,
}

fn labelled(answer: &Answer, dot: &Dot) -> LabelledDot {
    let Dot { birth, death, edge, killer } = *dot;
    match (answer.skeleton.filtration(), killer) {
        (Filtration::Alpha, _) => {
            let hole = answer.skeleton.hole(dot);
            let hole = hole.map(|hole| Hole { center: hole.center, radius: hole.radius });
            LabelledDot::Alpha { birth, death, edge, hole }
        }
        (Filtration::Rips, Killer::Edge(last)) => LabelledDot::Rips { birth, death, edge, death_edge: Some(last) },
        (Filtration::Rips, _) => LabelledDot::Rips { birth, death, edge, death_edge: None },
    }
}

/// Writes a list. Its pieces are made into text on all cores, ahead of the writing by as many pieces as there are
/// cores.
///
/// Threads of its own, since starting the pool of `rayon` for this alone costs a twentieth of a small `compute`.
fn write_list<S: Serialize>(
    out: &mut impl Write,
    length: usize,
    element: impl Fn(usize) -> S + Sync,
) -> io::Result<()> {
    let text = |piece: Range<usize>, mut text: Vec<u8>| {
        // Elements first: their reads, which are all over the memory, then overlap.
        let elements: Vec<S> = piece.map(&element).collect();
        text.clear();
        serde_json::to_writer(&mut text, &elements).map(|()| text)
    };
    if length <= PIECE {
        return out.write_all(&text(0..length, Vec::new())?);
    }
    let ahead = thread::available_parallelism().map_or(1, NonZero::get) + 1;
    thread::scope(|scope| {
        let mut workers = VecDeque::new();
        let mut pieces = (0..length).step_by(PIECE).map(|first| first..length.min(first + PIECE));
        // Memory that was written from is used again: fresh memory costs more than the text does.
        let mut spare: Vec<Vec<u8>> = Vec::new();
        let mut opening = b"[";
        loop {
            while let Some(piece) = (workers.len() < ahead).then(|| pieces.next()).flatten() {
                let memory = spare.pop().unwrap_or_default();
                workers.push_back(scope.spawn(move || text(piece, memory)));
            }
            let Some(worker) = workers.pop_front() else { break };
            let text = worker.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic))?;
            // Each piece is a list of its own: its bracket makes way for a comma, or stays at the very beginning.
            out.write_all(opening)?;
            out.write_all(&text[1..text.len() - 1])?;
            opening = b",";
            spare.push(text);
        }
        out.write_all(b"]")
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_list_of_many_pieces_is_one_list() {
        for length in [0, 1, PIECE - 1, PIECE, PIECE + 1, 5 * PIECE + 7] {
            let items: Vec<usize> = (0..length).collect();
            let mut bytes = Vec::new();
            write_list(&mut bytes, length, |place| items[place]).unwrap();
            assert_eq!(serde_json::from_slice::<Vec<usize>>(&bytes).unwrap(), items);
        }
    }

    #[test]
    fn numbers_that_are_not_finite_are_null() {
        assert_eq!(number(f64::INFINITY).to_string(), "null");
        assert_eq!(number(2.5).to_string(), "2.5");
    }
}
