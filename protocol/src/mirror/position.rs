//! What a mirror holds of a vertex: a point of the plane, or coordinates in R^d.
//!
//! In: an id and a position. Out: the hash of the vertex.
//!
//! Invariants: a position of two coordinates has the same hash whichever way it is held. Only the two kinds of
//! positions below exist.
//!
//! Must not know: messages, mirrors.

use std::fmt::Debug;

use super::checksum::Element;
use crate::space::Metric;

/// The coordinates of a point of R^d.
pub type Coordinates = Box<[f64]>;

/// The position of a vertex, as a mirror holds it.
pub trait Position: Clone + Debug + PartialEq + sealed::Sealed {
    /// What all positions of a mirror have in common.
    type Place: Clone + Debug + Default + PartialEq;

    /// The element that the checksum counts for a vertex here.
    fn element(&self, id: u64) -> Element;
}

/// The space in which positions lie.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Place {
    /// How distances are measured. None: no snapshot has said it.
    pub metric: Option<Metric>,
    /// The number of coordinates of a position. 0: not known yet.
    pub dimension: u32,
}

impl Position for (f64, f64) {
    type Place = ();

    fn element(&self, id: u64) -> Element {
        (id, self.0, self.1).into()
    }
}

impl Position for Coordinates {
    type Place = Place;

    fn element(&self, id: u64) -> Element {
        (id, &self[..]).into()
    }
}

mod sealed {
    /// Keeps the list of positions closed.
    pub trait Sealed {}

    impl Sealed for (f64, f64) {}

    impl Sealed for super::Coordinates {}
}
