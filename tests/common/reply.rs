//! The JSON output of `hopes compute`, and the same in `hopes serve`.

use std::collections::{BTreeMap, BTreeSet};

use serde::Deserialize;

/// The output of `compute`. An unknown key is an error.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Reply {
    pub points: usize,
    pub duplicates: u64,
    pub rejected: u64,
    pub vertices: Vec<[f64; 2]>,
    pub dots: Vec<Dot>,
    pub mst: Tree,
    pub view: View,
    pub simplified: Option<Simplified>,
}

#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Dot {
    pub birth: f64,
    pub death: f64,
    pub edge: [usize; 2],
    pub hole: Hole,
}

#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Hole {
    pub center: [f64; 2],
    pub radius: f64,
}

#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Tree {
    pub edges: Vec<[usize; 2]>,
    pub length: f64,
}

#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct View {
    pub kind: String,
    pub k: Option<u32>,
    pub l: Option<u32>,
    pub alpha: Option<f64>,
    pub ds: Option<f64>,
    pub vs: Option<f64>,
    pub margins: Option<Margins>,
    pub edges: Vec<[usize; 2]>,
    pub critical: Vec<[usize; 2]>,
    pub components: usize,
    pub cycles: usize,
    pub length: f64,
}

#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Margins {
    pub diagonal: Option<f64>,
    pub vertical: Option<f64>,
}

#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Simplified {
    pub threshold: Option<f64>,
    pub vertices: Vec<[f64; 2]>,
    pub edges: Vec<[usize; 2]>,
}

impl Reply {
    pub fn of(json: impl AsRef<[u8]>) -> Self {
        serde_json::from_slice(json.as_ref()).expect("compute writes one answer")
    }

    pub fn position(&self, vertex: usize) -> [f64; 2] {
        self.vertices[vertex]
    }

    /// Half the length of an edge. This is the scale at which it enters the filtration.
    pub fn half_length(&self, edge: [usize; 2]) -> f64 {
        half_length(edge.map(|end| self.position(end)))
    }

    /// The dot of a critical edge.
    pub fn dot(&self, edge: [usize; 2]) -> &Dot {
        self.dots.iter().find(|dot| dot.edge == edge).expect("a critical edge has a dot")
    }

    /// The view without ids.
    pub fn picture(&self) -> Picture {
        let labels: BTreeMap<[usize; 2], [f64; 2]> =
            self.dots.iter().map(|dot| (dot.edge, [dot.birth, dot.death])).collect();
        let segment = |edge: [usize; 2]| segment(edge.map(|vertex| self.position(vertex)));
        Picture {
            vertices: self.vertices.iter().copied().map(place).collect(),
            edges: self.view.edges.iter().map(|&edge| segment(edge)).collect(),
            critical: self.view.critical.iter().map(|&edge| (segment(edge), place(labels[&edge]))).collect(),
        }
    }
}

/// Half the length of a segment.
pub fn half_length([[ax, ay], [bx, by]]: [[f64; 2]; 2]) -> f64 {
    (ax - bx).hypot(ay - by) / 2.0
}

/// A view by positions instead of ids, compared bit for bit.
#[derive(Debug, PartialEq)]
pub struct Picture {
    pub vertices: BTreeSet<Place>,
    pub edges: BTreeSet<Segment>,
    pub critical: BTreeMap<Segment, [u64; 2]>,
}

pub type Place = [u64; 2];
pub type Segment = [Place; 2];

pub fn place(point: [f64; 2]) -> Place {
    point.map(f64::to_bits)
}

pub fn segment(ends: [[f64; 2]; 2]) -> Segment {
    let mut ends = ends.map(place);
    ends.sort_unstable();
    ends
}
