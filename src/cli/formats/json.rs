//! The JSON answer of `compute`; its keys stand in the README.
//!
//! In: an [`Answer`]. Out: one JSON object on one line. Invariants: lists are streamed, never built; numbers that are not finite are
//! null. Must not know: files.

use std::io::{self, Write};

use hopes::topology::{Dot, Edge, Margins, ViewSpec};
use serde::{Serialize, Serializer};

use super::Answer;

/// Writes the answer and a line end.
pub fn write(answer: &Answer, out: &mut impl Write) -> io::Result<()> {
    serde_json::to_writer(&mut *out, &Root::of(answer))?;
    out.write_all(b"\n")
}

/// A list that is made while it is written.
struct Each<I>(I);

impl<I: Iterator<Item: Serialize> + Clone> Serialize for Each<I> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_seq(self.0.clone())
    }
}

#[derive(Serialize)]
struct Root<V, D, T> {
    points: usize,
    duplicates: u64,
    rejected: u64,
    vertices: V,
    dots: D,
    mst: Tree<T>,
    view: Shown<T>,
    #[serde(skip_serializing_if = "Option::is_none")]
    simplified: Option<SimplifiedView<T>>,
}

#[derive(Serialize)]
struct Tree<T> {
    edges: T,
    length: f64,
}

#[derive(Serialize)]
struct LabelledDot {
    birth: f64,
    death: f64,
    edge: Edge,
    hole: Hole,
}

#[derive(Serialize)]
struct Hole {
    center: [f64; 2],
    radius: f64,
}

#[derive(Serialize)]
struct Shown<T> {
    #[serde(flatten)]
    kind: Kind,
    edges: T,
    critical: Vec<Edge>,
    components: usize,
    cycles: usize,
    length: f64,
}

#[derive(Serialize)]
#[serde(tag = "kind", rename_all = "lowercase")]
enum Kind {
    Full,
    Reduced { alpha: f64 },
    Derived { k: u32, l: u32, ds: Option<f64>, vs: f64, margins: MarginValues },
}

#[derive(Serialize)]
struct MarginValues {
    diagonal: Option<f64>,
    vertical: Option<f64>,
}

#[derive(Serialize)]
struct SimplifiedView<T> {
    threshold: f64,
    vertices: Vec<[f64; 2]>,
    edges: T,
}

type Edges<'a> = Each<std::iter::Copied<std::slice::Iter<'a, Edge>>>;

impl<'a> Root<(), (), Edges<'a>> {
    fn of(answer: &'a Answer<'a>) -> impl Serialize + 'a {
        let skeleton = answer.skeleton;
        let view = answer.view;
        Root {
            points: skeleton.vertices().len(),
            duplicates: answer.duplicates,
            rejected: answer.rejected,
            vertices: Each(skeleton.vertices().iter().map(|vertex| vertex.position.xy())),
            dots: Each(skeleton.dots().iter().map(|dot| labelled(answer, dot))),
            mst: Tree { edges: edges(skeleton.tree()), length: skeleton.tree_length() },
            view: Shown {
                kind: kind(answer),
                edges: edges(&view.tree),
                critical: view.critical_edges(skeleton).collect(),
                components: view.components,
                cycles: view.cycles,
                length: view.length(skeleton),
            },
            simplified: answer.simplified.map(|(threshold, simplified)| SimplifiedView {
                threshold,
                vertices: simplified.positions.clone(),
                edges: edges(&simplified.edges),
            }),
        }
    }
}

fn edges(edges: &[Edge]) -> Edges<'_> {
    Each(edges.iter().copied())
}

fn labelled(answer: &Answer, dot: &Dot) -> LabelledDot {
    let hole = answer.skeleton.hole(dot);
    let hole = Hole { center: hole.center, radius: hole.radius };
    LabelledDot { birth: dot.birth, death: dot.death, edge: dot.edge, hole }
}

fn kind(answer: &Answer) -> Kind {
    match answer.view.spec {
        ViewSpec::Full => Kind::Full,
        ViewSpec::Reduced { alpha } => Kind::Reduced { alpha },
        ViewSpec::Derived { k, l } => {
            let selection = answer.view.selection.as_ref();
            let Margins { diagonal, vertical } = selection.map(|selection| selection.margins).unwrap_or_default();
            Kind::Derived {
                k: k.get(),
                l: l.get(),
                ds: selection.and_then(|selection| selection.ds),
                vs: selection.map_or(f64::INFINITY, |selection| selection.vs),
                margins: MarginValues { diagonal, vertical },
            }
        }
    }
}
