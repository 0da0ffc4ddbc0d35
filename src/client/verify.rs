//! Verification of a frame: the cloud of a mirror is computed from scratch, and compared with what the mirror
//! shows.
//!
//! In: a mirror.
//! Out: the first difference, if there is one.
//! Invariants: nothing of the daemon is trusted but the positions of the vertices. Only for views that are not
//! simplified, since those keep all vertices of the cloud.
//! Must not know: where the mirror comes from.

use std::collections::{BTreeMap, BTreeSet};

use hopes::topology::spaces::MAX_VERTICES;
use hopes::topology::{Follower, Options, Pipeline, SpaceOptions, SpacePipeline, Step, VertexId, ViewSpec};
use hopes_protocol::{AnyMirror, Edge, FrameInfo, Mirror, Position, Simplify, SpaceMirror};
use thiserror::Error;

use crate::daemon;

/// How a frame differs from what its cloud gives.
#[derive(Debug, Error)]
pub enum Differs {
    /// A view that cannot be.
    #[error("frame {frame} shows a view that cannot be: {reason}")]
    View {
        /// The frame.
        frame: u64,
        /// Why.
        reason: &'static str,
    },
    /// A view that hides vertices.
    #[error(
        "frame {frame} is simplified, which cannot be recomputed from what is shown: leave out --check or --simplify"
    )]
    Simplified {
        /// The frame.
        frame: u64,
    },
    /// A space that cannot be.
    #[error("frame {frame} is of a space that cannot be: {reason}")]
    Space {
        /// The frame.
        frame: u64,
        /// Why.
        reason: String,
    },
    /// A point that cannot be.
    #[error("frame {frame} has vertex {vertex} where no vertex can be: {reason}")]
    Vertex {
        /// The frame.
        frame: u64,
        /// Its id.
        vertex: u64,
        /// Why.
        reason: String,
    },
    /// Other edges, labels or counts.
    #[error("frame {frame} has other {what} than its {vertices} vertices give")]
    Other {
        /// The frame.
        frame: u64,
        /// What differs.
        what: &'static str,
        /// How many vertices there are.
        vertices: usize,
    },
}

/// Computes the frame of a mirror from its vertices, and compares.
///
/// # Errors
/// [`Differs`].
pub fn verify(mirror: &AnyMirror, shown: &FrameInfo) -> Result<(), Differs> {
    let frame = shown.number;
    if shown.view.simplify != Simplify::No {
        return Err(Differs::Simplified { frame });
    }
    let spec = daemon::spec(shown.view.cut).map_err(|reason| Differs::View { frame, reason })?;
    match mirror {
        AnyMirror::Plane(mirror) => {
            let step = planar_step(mirror, spec, frame)?;
            compare(mirror, shown, step.as_ref())
        }
        AnyMirror::Space(mirror) => {
            let step = space_step(mirror, spec, frame)?;
            compare(mirror, shown, step.as_ref())
        }
    }
}

fn planar_step(mirror: &Mirror, spec: ViewSpec, frame: u64) -> Result<Option<Step>, Differs> {
    let mut pipeline = Pipeline::new(Options::default());
    for (&vertex, &(x, y)) in mirror.vertices() {
        let fed = pipeline.feed_point(x, y, None);
        fed.map_err(|refusal| Differs::Vertex { frame, vertex, reason: refusal.to_string() })?;
    }
    pipeline.commit(None);
    Ok(pipeline.poll_step(&mut Follower::new(spec)))
}

fn space_step(mirror: &SpaceMirror, spec: ViewSpec, frame: u64) -> Result<Option<Step>, Differs> {
    let metric = mirror.place().metric.map(daemon::metric).unwrap_or_default();
    let options = SpaceOptions { metric, max_vertices: MAX_VERTICES, ..SpaceOptions::default() };
    let mut pipeline =
        SpacePipeline::new(options).map_err(|error| Differs::Space { frame, reason: error.to_string() })?;
    for (&vertex, point) in mirror.vertices() {
        let fed = pipeline.feed_point(point, None);
        fed.map_err(|refusal| Differs::Vertex { frame, vertex, reason: refusal.to_string() })?;
    }
    pipeline.commit(None);
    Ok(pipeline.poll_step(&mut Follower::new(spec)))
}

fn compare<P: Position>(mirror: &Mirror<P>, shown: &FrameInfo, step: Option<&Step>) -> Result<(), Differs> {
    let other = |what| Differs::Other { frame: shown.number, what, vertices: mirror.vertices().len() };
    let step = step.ok_or_else(|| other("frames"))?;
    // Its ids count from 0, in the order of the mirror's.
    let ids: Vec<u64> = mirror.vertices().keys().copied().collect();
    if step.diff.vertices_added.len() != ids.len() {
        return Err(other("positions"));
    }
    let edge = |[a, b]: [VertexId; 2]| Some((*ids.get(a.0 as usize)?, *ids.get(b.0 as usize)?));
    let tree: Option<BTreeSet<Edge>> = step.diff.tree_added.iter().map(|&ends| edge(ends)).collect();
    if tree.as_ref() != Some(mirror.edges()) {
        return Err(other("tree edges"));
    }
    let critical = step.diff.critical_set.iter().map(|set| Some((edge(set.edge)?, (set.birth, set.death))));
    if critical.collect::<Option<BTreeMap<_, _>>>().as_ref() != Some(mirror.critical()) {
        return Err(other("critical edges"));
    }
    if (step.components as u64, step.cycles as u64) != (shown.components, shown.cycles) {
        return Err(other("numbers of components and cycles"));
    }
    Ok(())
}
