//! A consumer of the JSON lines of `hopes serve`: it holds only what the lines say.

use std::collections::{BTreeMap, BTreeSet};

use serde::Deserialize;

use super::reply::{Picture, place, segment};

/// A line of `serve`. An unknown key is an error.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FrameLine {
    pub stream: String,
    pub frame: u64,
    pub from: u64,
    pub time: Option<f64>,
    pub points: usize,
    pub rejected: u64,
    pub view: FrameView,
    pub vertices: Vertices,
    pub edges: Edges,
    pub critical: Critical,
    pub checksum: String,
}

#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FrameView {
    pub kind: String,
    pub k: Option<u32>,
    pub l: Option<u32>,
    pub alpha: Option<f64>,
    pub ds: Option<f64>,
    pub vs: Option<f64>,
    pub components: usize,
    pub cycles: usize,
}

#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Vertices {
    pub add: Vec<(u64, f64, f64)>,
    pub del: Vec<u64>,
}

#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Edges {
    pub add: Vec<[u64; 2]>,
    pub del: Vec<[u64; 2]>,
}

#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Critical {
    pub set: Vec<(u64, u64, f64, f64)>,
    pub del: Vec<[u64; 2]>,
}

impl FrameLine {
    pub fn of(line: &str) -> Self {
        serde_json::from_str(line).unwrap_or_else(|error| panic!("{error} in {line}"))
    }

    /// Whether nothing has changed.
    pub fn is_empty(&self) -> bool {
        let points = self.vertices.add.is_empty() && self.vertices.del.is_empty();
        let edges = self.edges.add.is_empty() && self.edges.del.is_empty();
        points && edges && self.critical.set.is_empty() && self.critical.del.is_empty()
    }
}

/// The content of a consumer.
#[derive(Debug, Default)]
pub struct Mirror {
    frame: u64,
    /// The largest id so far.
    newest: Option<u64>,
    vertices: BTreeMap<u64, [f64; 2]>,
    edges: BTreeSet<[u64; 2]>,
    critical: BTreeMap<[u64; 2], [f64; 2]>,
}

impl Mirror {
    /// The consumer of a whole output.
    pub fn of(output: &str) -> Self {
        let mut mirror = Self::default();
        output.lines().for_each(|line| mirror.follow(&FrameLine::of(line)));
        mirror
    }

    /// Applies a line. It must be the next frame, remove only what is there, add only what is not there, and have the
    /// right checksum.
    pub fn follow(&mut self, line: &FrameLine) {
        assert_eq!((line.from, line.frame), (self.frame, self.frame + 1), "frames follow one another");
        self.frame = line.frame;
        self.follow_vertices(&line.vertices);
        self.follow_edges(&line.edges);
        self.follow_critical(&line.critical);
        let known = |edge: &[u64; 2]| edge[0] < edge[1] && edge.iter().all(|end| self.vertices.contains_key(end));
        assert!(self.edges.iter().chain(self.critical.keys()).all(known), "edges join vertices, the older first");
        assert_eq!(line.points, self.vertices.len(), "frame {}", line.frame);
        assert_eq!(line.view.components, self.vertices.len() - self.edges.len(), "frame {}", line.frame);
        assert_eq!(line.view.cycles, self.critical.len(), "frame {}", line.frame);
        assert_eq!(line.checksum, self.checksum(), "frame {}", line.frame);
    }

    fn follow_vertices(&mut self, change: &Vertices) {
        for id in in_order(&change.del) {
            assert!(self.vertices.remove(id).is_some(), "vertex {id} leaves, but is not there");
        }
        for &(id, x, y) in in_order(&change.add) {
            assert!(self.newest.is_none_or(|newest| newest < id), "names rise, and are never given twice: {id}");
            self.newest = Some(id);
            self.vertices.insert(id, [x, y]);
        }
    }

    fn follow_edges(&mut self, change: &Edges) {
        for edge in in_order(&change.del) {
            assert!(self.edges.remove(edge), "tree edge {edge:?} leaves, but is not there");
        }
        for edge in in_order(&change.add) {
            assert!(self.edges.insert(*edge), "tree edge {edge:?} comes, but is there");
            assert!(!change.del.contains(edge), "tree edge {edge:?} leaves and comes");
        }
    }

    fn follow_critical(&mut self, change: &Critical) {
        for edge in in_order(&change.del) {
            assert!(self.critical.remove(edge).is_some(), "critical edge {edge:?} leaves, but is not there");
        }
        for &(a, b, birth, death) in in_order(&change.set) {
            let before = self.critical.insert([a, b], [birth, death]);
            assert_ne!(before, Some([birth, death]), "critical edge {a}-{b} was that before");
            assert!(!change.del.contains(&[a, b]), "critical edge {a}-{b} leaves and comes");
        }
    }

    /// The view without ids.
    pub fn picture(&self) -> Picture {
        let segment = |edge: &[u64; 2]| segment(edge.map(|end| self.vertices[&end]));
        Picture {
            vertices: self.vertices.values().copied().map(place).collect(),
            edges: self.edges.iter().map(segment).collect(),
            critical: self.critical.iter().map(|(edge, &label)| (segment(edge), place(label))).collect(),
        }
    }

    /// The checksum of the content, by its definition.
    pub fn checksum(&self) -> String {
        let vertices = self.vertices.iter().map(|(&id, &[x, y])| hash(&[1, id, x.to_bits(), y.to_bits()]));
        let edges = self.edges.iter().map(|&[a, b]| hash(&[2, a, b]));
        let critical = self.critical.iter();
        let critical = critical.map(|(&[a, b], &[birth, death])| hash(&[3, a, b, birth.to_bits(), death.to_bits()]));
        let sum = vertices.chain(edges).chain(critical).fold(0u128, |sum, hash| sum + u128::from(hash));
        format!("{:016x}", sum % (1 << 64))
    }
}

/// The definition, in numbers so large that nothing overflows.
fn hash(words: &[u64]) -> u64 {
    const MODULUS: u128 = 1 << 64;
    let mut h: u128 = 0;
    for &word in words {
        let mut z = ((h ^ u128::from(word)) + 0x9E37_79B9_7F4A_7C15) % MODULUS;
        z = ((z ^ (z >> 30)) * 0xBF58_476D_1CE4_E5B9) % MODULUS;
        z = ((z ^ (z >> 27)) * 0x94D0_49BB_1331_11EB) % MODULUS;
        h = z ^ (z >> 31);
    }
    h as u64
}

fn in_order<T: PartialOrd>(list: &[T]) -> &[T] {
    assert!(list.is_sorted_by(|a, b| a < b), "a list is out of order, or says a thing twice");
    list
}
