//! Types that messages share (SPEC.md, section 4).
//!
//! Invariants: a released type never changes, and the cases of an enum keep their order: the order is the format.
//!
//! Must not know: bytes.

use serde::{Deserialize, Serialize};

/// The longest name of a stream, in bytes.
pub const LONGEST_NAME: usize = 200;

/// Whether a stream may have this name: 1 to 200 bytes, no control character, no `*`.
pub fn is_name(name: &str) -> bool {
    is_pattern(name) && !name.contains('*')
}

/// Whether this is a valid pattern of names: a name in which `*` stands for any run of characters.
pub fn is_pattern(pattern: &str) -> bool {
    (1..=LONGEST_NAME).contains(&pattern.len()) && !pattern.contains(|character: char| character.is_control())
}

/// Which points of a stream are kept.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum Window {
    /// All points.
    All,
    /// The newest points, up to this number.
    Points(u64),
    /// The points of this number of newest frames.
    Frames(u64),
    /// The points of this span of newest event time.
    Time(f64),
}

/// A part of the skeleton. Scales are radii.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum Cut {
    /// HoPeS(C).
    Full,
    /// HoPeS(C; alpha).
    Reduced(f64),
    /// HoPeS_{k,l}(C).
    Derived(u32, u32),
}

/// How the part is simplified.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum Simplify {
    /// Not at all.
    No,
    /// Edges shorter than the cut's own scale are collapsed. That is alpha, or vs.
    AtScale,
    /// Edges of half-length below this are collapsed.
    Below(f64),
}

/// What a consumer sees of the skeleton.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct View {
    /// The part.
    pub cut: Cut,
    /// How it is simplified.
    pub simplify: Simplify,
}

/// How many dots of the persistence diagram a consumer sees.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum DotsWanted {
    /// None.
    No,
    /// The most persistent ones, up to this number.
    Top(u32),
    /// All.
    All,
}

/// A distinct position: id, x, y.
pub type Vertex = (u64, f64, f64);

/// An edge by the ids of its ends, the smaller first.
pub type Edge = (u64, u64);

/// A critical edge: its ends, birth, death.
pub type Critical = (u64, u64, f64, f64);

/// What a snapshot or diff says about a frame as a whole.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct FrameInfo {
    /// Counts the stream's commits from 1.
    pub number: u64,
    /// The time of the commit. Without one, the newest event time.
    pub time: Option<f64>,
    /// Points in the window.
    pub points: u64,
    /// Distinct positions.
    pub vertices: u64,
    /// Points refused since the previous frame.
    pub rejected: u64,
    /// The view that is sent.
    pub view: View,
    /// Smallest persistence selected; none if infinite, or if the view is not derived.
    pub ds: Option<f64>,
    /// Largest birth selected; none if infinite, or if the view is not derived.
    pub vs: Option<f64>,
    /// Connected components of the view.
    pub components: u64,
    /// Independent cycles of the view.
    pub cycles: u64,
}

/// A dot of the persistence diagram, with its hole.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Dot {
    /// Its critical edge.
    pub edge: Edge,
    /// Half the length of the critical edge.
    pub birth: f64,
    /// The scale at which the hole is filled.
    pub death: f64,
    /// Where the hole is filled.
    pub center: (f64, f64),
    /// The distance from there to the nearest points.
    pub radius: f64,
}
