//! A mirror: a consumer's verified copy of one view of a stream. It applies snapshots and diffs.
//!
//! In: [`Snapshot`]s and [`Diff`]s. Out: vertices, tree edges and critical edges of the newest frame.
//!
//! The contract: after a diff was applied, the mirror equals the original.
//!
//! Invariants: the content was verified by its checksum. After an error the content is not valid: the mirror reports
//! this and accepts only a snapshot.
//!
//! Must not know: where messages come from.

use std::collections::{BTreeMap, BTreeSet};

use thiserror::Error;

use crate::checksum::Checksum;
use crate::consumer::{Diff, Snapshot};
use crate::types::{Critical, Edge, FrameInfo, Vertex};

/// Why a message does not fit the content of a mirror. Only a snapshot helps.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
pub enum MirrorError {
    /// The diff starts from another frame, or does not lead to a later one.
    #[error("frame {to} starts from frame {from}, but the mirror holds frame {holds}: subscribe again")]
    Gap {
        /// The frame that the mirror holds. 0: none.
        holds: u64,
        /// The frame that the diff starts from.
        from: u64,
        /// The frame that the diff leads to.
        to: u64,
    },
    /// An element to remove is not in the mirror.
    #[error("frame {frame} removes {what}, which is not there: subscribe again")]
    Missing {
        /// The frame.
        frame: u64,
        /// The element.
        what: ElementId,
    },
    /// An element to add is in the mirror already.
    #[error("frame {frame} adds {what}, which is there already: subscribe again")]
    AlreadyThere {
        /// The frame.
        frame: u64,
        /// The element.
        what: ElementId,
    },
    /// The result has another checksum than the message says.
    #[error("frame {frame} has checksum {sent:016x}, but what the mirror holds has {held:016x}: subscribe again")]
    Checksum {
        /// The frame.
        frame: u64,
        /// The checksum in the message.
        sent: u64,
        /// The checksum of the mirror.
        held: u64,
    },
    /// An earlier message could not be applied.
    #[error("the mirror has lost its place and needs a snapshot: subscribe again")]
    Lost,
}

/// An element of a skeleton, by its ids.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ElementId {
    /// A vertex.
    Vertex(u64),
    /// A tree edge.
    Edge(u64, u64),
    /// A critical edge.
    Critical(u64, u64),
}

impl std::fmt::Display for ElementId {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Vertex(id) => write!(f, "vertex {id}"),
            Self::Edge(a, b) => write!(f, "edge {a}-{b}"),
            Self::Critical(a, b) => write!(f, "critical edge {a}-{b}"),
        }
    }
}

/// A consumer's copy of a view.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Mirror {
    frame: Option<FrameInfo>,
    vertices: BTreeMap<u64, (f64, f64)>,
    edges: BTreeSet<Edge>,
    critical: BTreeMap<Edge, (f64, f64)>,
    checksum: Checksum,
    is_lost: bool,
}

impl Mirror {
    /// An empty mirror. It accepts a snapshot, or a diff from frame 0.
    pub fn new() -> Self {
        Self::default()
    }

    /// The newest verified frame, if there is one.
    pub fn frame(&self) -> Option<&FrameInfo> {
        self.frame.as_ref()
    }

    /// The number of the newest verified frame. 0: none.
    pub fn number(&self) -> u64 {
        self.frame.as_ref().map_or(0, |frame| frame.number)
    }

    /// Whether the mirror accepts nothing but a snapshot.
    pub fn needs_snapshot(&self) -> bool {
        self.is_lost
    }

    /// Positions by id.
    pub fn vertices(&self) -> &BTreeMap<u64, (f64, f64)> {
        &self.vertices
    }

    /// Tree edges.
    pub fn edges(&self) -> &BTreeSet<Edge> {
        &self.edges
    }

    /// Birth and death by critical edge.
    pub fn critical(&self) -> &BTreeMap<Edge, (f64, f64)> {
        &self.critical
    }

    /// The checksum of the content.
    pub fn checksum(&self) -> u64 {
        self.checksum.0
    }

    /// Replaces the content by a snapshot.
    ///
    /// # Errors
    /// [`MirrorError::Checksum`], or [`MirrorError::AlreadyThere`] where an element is listed twice.
    pub fn apply_snapshot(&mut self, snapshot: &Snapshot) -> Result<(), MirrorError> {
        let Snapshot { frame, vertices, edges, critical, .. } = snapshot;
        *self = Self::new();
        self.attempt(frame, snapshot.checksum, |mirror| {
            mirror.add_vertices(vertices)?;
            mirror.add_edges(edges)?;
            mirror.set_critical(critical);
            Ok(())
        })
    }

    /// Applies a diff.
    ///
    /// # Errors
    /// [`MirrorError`]: the diff does not fit the content.
    pub fn apply_diff(&mut self, diff: &Diff) -> Result<(), MirrorError> {
        if self.is_lost {
            return Err(MirrorError::Lost);
        }
        if diff.from != self.number() || diff.frame.number <= diff.from {
            self.is_lost = true;
            return Err(MirrorError::Gap { holds: self.number(), from: diff.from, to: diff.frame.number });
        }
        self.attempt(&diff.frame, diff.checksum, |mirror| {
            mirror.remove_vertices(&diff.vertices_removed)?;
            mirror.add_vertices(&diff.vertices_added)?;
            mirror.remove_edges(&diff.edges_removed)?;
            mirror.add_edges(&diff.edges_added)?;
            mirror.remove_critical(&diff.critical_removed)?;
            mirror.set_critical(&diff.critical_set);
            Ok(())
        })
    }

    fn attempt(
        &mut self,
        frame: &FrameInfo,
        sent: u64,
        change: impl FnOnce(&mut Self) -> Result<(), ElementError>,
    ) -> Result<(), MirrorError> {
        let number = frame.number;
        let changed = change(self).map_err(|misfit| match misfit {
            ElementError::Missing(what) => MirrorError::Missing { frame: number, what },
            ElementError::AlreadyThere(what) => MirrorError::AlreadyThere { frame: number, what },
        });
        let held = self.checksum.0;
        let differs = (held != sent).then_some(MirrorError::Checksum { frame: number, sent, held });
        let proved = changed.and(differs.map_or(Ok(()), Err));
        self.is_lost = proved.is_err();
        if proved.is_ok() {
            self.frame = Some(frame.clone());
        }
        proved
    }

    fn remove_vertices(&mut self, ids: &[u64]) -> Result<(), ElementError> {
        for &id in ids {
            let (x, y) = self.vertices.remove(&id).ok_or(ElementError::Missing(ElementId::Vertex(id)))?;
            self.checksum.remove((id, x, y));
        }
        Ok(())
    }

    fn add_vertices(&mut self, vertices: &[Vertex]) -> Result<(), ElementError> {
        for &(id, x, y) in vertices {
            if self.vertices.insert(id, (x, y)).is_some() {
                return Err(ElementError::AlreadyThere(ElementId::Vertex(id)));
            }
            self.checksum.add((id, x, y));
        }
        Ok(())
    }

    fn remove_edges(&mut self, edges: &[Edge]) -> Result<(), ElementError> {
        for &edge in edges {
            if !self.edges.remove(&edge) {
                return Err(ElementError::Missing(ElementId::Edge(edge.0, edge.1)));
            }
            self.checksum.remove(edge);
        }
        Ok(())
    }

    fn add_edges(&mut self, edges: &[Edge]) -> Result<(), ElementError> {
        for &edge in edges {
            if !self.edges.insert(edge) {
                return Err(ElementError::AlreadyThere(ElementId::Edge(edge.0, edge.1)));
            }
            self.checksum.add(edge);
        }
        Ok(())
    }

    fn remove_critical(&mut self, edges: &[Edge]) -> Result<(), ElementError> {
        for &(a, b) in edges {
            let (birth, death) =
                self.critical.remove(&(a, b)).ok_or(ElementError::Missing(ElementId::Critical(a, b)))?;
            self.checksum.remove((a, b, birth, death));
        }
        Ok(())
    }

    fn set_critical(&mut self, critical: &[Critical]) {
        for &(a, b, birth, death) in critical {
            if let Some((birth, death)) = self.critical.insert((a, b), (birth, death)) {
                self.checksum.remove((a, b, birth, death));
            }
            self.checksum.add((a, b, birth, death));
        }
    }
}

enum ElementError {
    Missing(ElementId),
    AlreadyThere(ElementId),
}
