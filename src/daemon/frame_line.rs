//! A frame as a JSON line; its keys stand in the README.
//!
//! In: a step from one frame to the next. Out: a value that serializes. Invariants: its size is that of the diff;
//! numbers that are not finite are null. Must not know: channels.

use hopes::topology::{Checksum, Critical, EdgeId, Step, Vertex, ViewSpec};
use serde::{Serialize, Serializer};

/// One line of `serve`'s output.
#[derive(Debug, Serialize)]
pub struct FrameLine {
    stream: &'static str,
    frame: u64,
    from: u64,
    time: Option<f64>,
    points: usize,
    rejected: u64,
    view: ViewLine,
    vertices: Vertices,
    edges: Edges,
    critical: CriticalEdges,
    #[serde(serialize_with = "as_text")]
    checksum: Checksum,
}

#[derive(Debug, Serialize)]
struct ViewLine {
    #[serde(flatten)]
    kind: Kind,
    components: usize,
    cycles: usize,
}

#[derive(Debug, Serialize)]
#[serde(tag = "kind", rename_all = "lowercase")]
enum Kind {
    Full,
    Reduced { alpha: f64 },
    Derived { k: u32, l: u32, ds: Option<f64>, vs: Option<f64> },
}

#[derive(Debug, Serialize)]
struct Vertices {
    add: Vec<(u64, f64, f64)>,
    del: Vec<u64>,
}

#[derive(Debug, Serialize)]
struct Edges {
    add: Vec<[u64; 2]>,
    del: Vec<[u64; 2]>,
}

#[derive(Debug, Serialize)]
struct CriticalEdges {
    set: Vec<(u64, u64, f64, f64)>,
    del: Vec<[u64; 2]>,
}

impl FrameLine {
    /// The line of a step; so many points were rejected since the one before.
    pub fn new(step: &Step, rejected: u64) -> Self {
        let diff = &step.diff;
        Self {
            stream: "default",
            frame: step.number,
            from: step.from,
            time: step.time,
            points: step.vertices,
            rejected,
            view: ViewLine { kind: kind(step), components: step.components, cycles: step.cycles },
            vertices: Vertices {
                add: diff.vertices_added.iter().map(vertex).collect(),
                del: diff.vertices_removed.iter().map(|id| id.0).collect(),
            },
            edges: Edges { add: ends(&diff.tree_added), del: ends(&diff.tree_removed) },
            critical: CriticalEdges {
                set: diff.critical_set.iter().map(labelled).collect(),
                del: ends(&diff.critical_removed),
            },
            checksum: step.checksum,
        }
    }
}

fn kind(step: &Step) -> Kind {
    match step.spec {
        ViewSpec::Full => Kind::Full,
        ViewSpec::Reduced { alpha } => Kind::Reduced { alpha },
        ViewSpec::Derived { k, l } => {
            let selection = step.selection.as_ref();
            Kind::Derived {
                k: k.get(),
                l: l.get(),
                ds: selection.and_then(|selection| selection.ds),
                vs: selection.map(|selection| selection.vs),
            }
        }
    }
}

fn vertex(vertex: &Vertex) -> (u64, f64, f64) {
    let [x, y] = vertex.position.xy();
    (vertex.id.0, x, y)
}

fn ends(edges: &[EdgeId]) -> Vec<[u64; 2]> {
    edges.iter().map(|edge| edge.map(|id| id.0)).collect()
}

fn labelled(critical: &Critical) -> (u64, u64, f64, f64) {
    let [a, b] = critical.edge;
    (a.0, b.0, critical.birth, critical.death)
}

fn as_text<S: Serializer>(checksum: &Checksum, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.collect_str(checksum)
}
