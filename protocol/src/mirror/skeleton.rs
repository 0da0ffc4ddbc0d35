//! A mirror: a consumer's verified copy of one view of a stream. It applies snapshots and diffs.
//!
//! In: [`Snapshot`]s and [`Diff`]s, or those of a space. Out: vertices, tree edges and critical edges of the newest
//! frame.
//!
//! The contract: after a diff was applied, the mirror equals the original.
//!
//! Invariants: the content was verified by its checksum. After an error the content is not valid: the mirror reports
//! this and accepts only a snapshot.
//!
//! Must not know: where messages come from.

use std::collections::{BTreeMap, BTreeSet};

use thiserror::Error;

use super::checksum::Checksum;
use super::position::{Coordinates, Place, Position};
use crate::consumer::{Diff, Snapshot};
use crate::space::{SpaceDiff, SpaceSnapshot};
use crate::types::{Critical, Edge, FrameInfo};

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
    /// The vertices have another number of coordinates than those in the mirror.
    #[error("frame {frame} has vertices of {found} coordinates, but the mirror holds {held}: subscribe again")]
    Dimension {
        /// The frame.
        frame: u64,
        /// The number of coordinates in the message.
        found: u32,
        /// The number of coordinates in the mirror.
        held: u32,
    },
    /// The coordinates are not those of the vertices: too few or too many.
    #[error("frame {frame} has {coordinates} coordinates for {vertices} vertices of {dimension} each: subscribe again")]
    Coordinates {
        /// The frame.
        frame: u64,
        /// The number of coordinates in the message.
        coordinates: usize,
        /// The number of vertices in the message.
        vertices: usize,
        /// The number of coordinates of a vertex.
        dimension: u32,
    },
    /// A coordinate is infinite or no number.
    #[error("frame {frame} has a coordinate of vertex {vertex} that is not finite: subscribe again")]
    NotFinite {
        /// The frame.
        frame: u64,
        /// The vertex.
        vertex: u64,
    },
    /// The diff is of the plane and the mirror's content in R^d, or the other way round.
    #[error("frame {frame} is of another kind of space than what the mirror holds: subscribe again")]
    OtherSpace {
        /// The frame.
        frame: u64,
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

/// A consumer's copy of a view. Its positions are points of the plane, unless it is a [`SpaceMirror`].
#[derive(Clone, Debug, PartialEq)]
pub struct Mirror<P: Position = (f64, f64)> {
    frame: Option<FrameInfo>,
    vertices: BTreeMap<u64, P>,
    edges: BTreeSet<Edge>,
    critical: BTreeMap<Edge, (f64, f64)>,
    checksum: Checksum,
    is_lost: bool,
    place: P::Place,
}

/// A consumer's copy of a view of a stream in R^d. Each position is a list of `d` coordinates.
pub type SpaceMirror = Mirror<Coordinates>;

impl<P: Position> Default for Mirror<P> {
    fn default() -> Self {
        Self {
            frame: None,
            vertices: BTreeMap::new(),
            edges: BTreeSet::new(),
            critical: BTreeMap::new(),
            checksum: Checksum::default(),
            is_lost: false,
            place: P::Place::default(),
        }
    }
}

impl Mirror {
    /// An empty mirror of the plane. It accepts a snapshot, or a diff from frame 0.
    pub fn new() -> Self {
        Self::default()
    }

    /// Replaces the content by a snapshot.
    ///
    /// # Errors
    /// [`MirrorError::Checksum`], or [`MirrorError::AlreadyThere`] where an element is listed twice.
    pub fn apply_snapshot(&mut self, snapshot: &Snapshot) -> Result<(), MirrorError> {
        let Snapshot { frame, vertices, edges, critical, .. } = snapshot;
        self.restart(frame, snapshot.checksum, |mirror| {
            mirror.add_vertices(vertices.iter().map(|&(id, x, y)| (id, (x, y))))?;
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
        self.follow(diff.from, &diff.frame, diff.checksum, |mirror| {
            mirror.remove_vertices(&diff.vertices_removed)?;
            mirror.add_vertices(diff.vertices_added.iter().map(|&(id, x, y)| (id, (x, y))))?;
            mirror.change_edges(&diff.edges_removed, &diff.edges_added)?;
            mirror.change_critical(&diff.critical_removed, &diff.critical_set)
        })
    }
}

impl SpaceMirror {
    /// The metric and the number of coordinates. None before the first message; the metric is none without a snapshot.
    pub fn place(&self) -> Place {
        self.place
    }

    /// Replaces the content by a snapshot, whatever its space is.
    ///
    /// # Errors
    /// [`MirrorError::Checksum`], [`MirrorError::AlreadyThere`] where an element is listed twice,
    /// [`MirrorError::Coordinates`] or [`MirrorError::NotFinite`].
    pub fn apply_space_snapshot(&mut self, snapshot: &SpaceSnapshot) -> Result<(), MirrorError> {
        let SpaceSnapshot { frame, ids, coordinates, edges, critical, .. } = snapshot;
        self.restart(frame, snapshot.checksum, |mirror| {
            mirror.place = Place { metric: Some(snapshot.metric), dimension: snapshot.dimension };
            mirror.add_points(ids, coordinates, snapshot.dimension)?;
            mirror.add_edges(edges)?;
            mirror.set_critical(critical);
            Ok(())
        })
    }

    /// Applies a diff.
    ///
    /// # Errors
    /// [`MirrorError`]: the diff does not fit the content.
    pub fn apply_space_diff(&mut self, diff: &SpaceDiff) -> Result<(), MirrorError> {
        self.follow(diff.from, &diff.frame, diff.checksum, |mirror| {
            mirror.settle_dimension(diff.dimension)?;
            mirror.remove_vertices(&diff.vertices_removed)?;
            mirror.add_points(&diff.ids_added, &diff.coordinates_added, diff.dimension)?;
            mirror.change_edges(&diff.edges_removed, &diff.edges_added)?;
            mirror.change_critical(&diff.critical_removed, &diff.critical_set)
        })
    }

    /// The first point of a stream fixes its dimension, which is 0 before that.
    fn settle_dimension(&mut self, found: u32) -> Result<(), Misfit> {
        match self.place.dimension {
            0 => self.place.dimension = found,
            held if held != found => return Err(Misfit::Dimension { found, held }),
            _ => {}
        }
        Ok(())
    }

    fn add_points(&mut self, ids: &[u64], coordinates: &[f64], dimension: u32) -> Result<(), Misfit> {
        let width = dimension as usize;
        // In dimension 0 there is no vertex: one without coordinates is none.
        let is_whole = ids.len().checked_mul(width) == Some(coordinates.len()) && (width > 0 || ids.is_empty());
        if !is_whole {
            return Err(Misfit::Coordinates { coordinates: coordinates.len(), vertices: ids.len(), dimension });
        }
        let points = || ids.iter().copied().zip(coordinates.chunks_exact(width.max(1)));
        if let Some((vertex, _)) = points().find(|(_, point)| !point.iter().all(|number| number.is_finite())) {
            return Err(Misfit::NotFinite { vertex });
        }
        self.add_vertices(points().map(|(id, point)| (id, Coordinates::from(point))))
    }
}

impl<P: Position> Mirror<P> {
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
    pub fn vertices(&self) -> &BTreeMap<u64, P> {
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

    /// Replaces the content.
    fn restart(
        &mut self,
        frame: &FrameInfo,
        sent: u64,
        fill: impl FnOnce(&mut Self) -> Result<(), Misfit>,
    ) -> Result<(), MirrorError> {
        *self = Self::default();
        self.attempt(frame, sent, fill)
    }

    /// Changes the content, which must be that of the frame `from`.
    fn follow(
        &mut self,
        from: u64,
        frame: &FrameInfo,
        sent: u64,
        change: impl FnOnce(&mut Self) -> Result<(), Misfit>,
    ) -> Result<(), MirrorError> {
        if self.is_lost {
            return Err(MirrorError::Lost);
        }
        if from != self.number() || frame.number <= from {
            self.is_lost = true;
            return Err(MirrorError::Gap { holds: self.number(), from, to: frame.number });
        }
        self.attempt(frame, sent, change)
    }

    fn attempt(
        &mut self,
        frame: &FrameInfo,
        sent: u64,
        change: impl FnOnce(&mut Self) -> Result<(), Misfit>,
    ) -> Result<(), MirrorError> {
        let number = frame.number;
        let changed = change(self).map_err(|misfit| misfit.in_frame(number));
        let held = self.checksum.0;
        let differs = (held != sent).then_some(MirrorError::Checksum { frame: number, sent, held });
        let proved = changed.and(differs.map_or(Ok(()), Err));
        self.is_lost = proved.is_err();
        if proved.is_ok() {
            self.frame = Some(frame.clone());
        }
        proved
    }

    fn remove_vertices(&mut self, ids: &[u64]) -> Result<(), Misfit> {
        for &id in ids {
            let position = self.vertices.remove(&id).ok_or(Misfit::Missing(ElementId::Vertex(id)))?;
            self.checksum.remove(position.element(id));
        }
        Ok(())
    }

    fn add_vertices(&mut self, vertices: impl Iterator<Item = (u64, P)>) -> Result<(), Misfit> {
        for (id, position) in vertices {
            let element = position.element(id);
            if self.vertices.insert(id, position).is_some() {
                return Err(Misfit::AlreadyThere(ElementId::Vertex(id)));
            }
            self.checksum.add(element);
        }
        Ok(())
    }

    fn change_edges(&mut self, removed: &[Edge], added: &[Edge]) -> Result<(), Misfit> {
        self.remove_edges(removed)?;
        self.add_edges(added)
    }

    fn remove_edges(&mut self, edges: &[Edge]) -> Result<(), Misfit> {
        for &edge in edges {
            if !self.edges.remove(&edge) {
                return Err(Misfit::Missing(ElementId::Edge(edge.0, edge.1)));
            }
            self.checksum.remove(edge);
        }
        Ok(())
    }

    fn add_edges(&mut self, edges: &[Edge]) -> Result<(), Misfit> {
        for &edge in edges {
            if !self.edges.insert(edge) {
                return Err(Misfit::AlreadyThere(ElementId::Edge(edge.0, edge.1)));
            }
            self.checksum.add(edge);
        }
        Ok(())
    }

    fn change_critical(&mut self, removed: &[Edge], set: &[Critical]) -> Result<(), Misfit> {
        self.remove_critical(removed)?;
        self.set_critical(set);
        Ok(())
    }

    fn remove_critical(&mut self, edges: &[Edge]) -> Result<(), Misfit> {
        for &(a, b) in edges {
            let (birth, death) = self.critical.remove(&(a, b)).ok_or(Misfit::Missing(ElementId::Critical(a, b)))?;
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

/// Why a list does not fit the content, in a frame that is not named yet.
enum Misfit {
    Missing(ElementId),
    AlreadyThere(ElementId),
    Dimension { found: u32, held: u32 },
    Coordinates { coordinates: usize, vertices: usize, dimension: u32 },
    NotFinite { vertex: u64 },
}

impl Misfit {
    fn in_frame(self, frame: u64) -> MirrorError {
        match self {
            Self::Missing(what) => MirrorError::Missing { frame, what },
            Self::AlreadyThere(what) => MirrorError::AlreadyThere { frame, what },
            Self::Dimension { found, held } => MirrorError::Dimension { frame, found, held },
            Self::Coordinates { coordinates, vertices, dimension } => {
                MirrorError::Coordinates { frame, coordinates, vertices, dimension }
            }
            Self::NotFinite { vertex } => MirrorError::NotFinite { frame, vertex },
        }
    }
}
