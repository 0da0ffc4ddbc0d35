//! A mirror of a stream whose space is not known beforehand: the messages say whether it is of the plane or in R^d.
//!
//! In: any messages. Out: the newest frame, and which mirror holds it.
//!
//! Invariants: those of a [`Mirror`]. A stream never changes its kind, but a snapshot of the other kind begins anew.
//!
//! Must not know: where messages come from.

use super::skeleton::{Mirror, MirrorError, SpaceMirror};
use crate::consumer::{Cause, Snapshot};
use crate::message::Message;
use crate::space::SpaceSnapshot;
use crate::types::FrameInfo;

/// A consumer's verified copy of one view of a stream, in the plane or in R^d.
#[derive(Clone, Debug, PartialEq)]
pub enum AnyMirror {
    /// Of the plane.
    Plane(Mirror),
    /// In R^d.
    Space(SpaceMirror),
}

impl Default for AnyMirror {
    fn default() -> Self {
        Self::Plane(Mirror::default())
    }
}

/// Calls the same of either mirror.
macro_rules! either {
    ($any:expr, $name:ident => $call:expr) => {
        match $any {
            AnyMirror::Plane($name) => $call,
            AnyMirror::Space($name) => $call,
        }
    };
}

impl AnyMirror {
    /// Applies a message if it leads to a frame; whether it does.
    ///
    /// # Errors
    /// [`MirrorError`]: it does not fit the content.
    pub fn apply(&mut self, message: &Message) -> Result<bool, MirrorError> {
        match message {
            Message::Snapshot(snapshot) => self.of_plane().apply_snapshot(snapshot),
            Message::SpaceSnapshot(snapshot) => self.of_space().apply_space_snapshot(snapshot),
            Message::Diff(diff) => match self {
                Self::Space(mirror) if mirror.frame().is_some() => {
                    Err(MirrorError::OtherSpace { frame: diff.frame.number })
                }
                _ => self.of_plane().apply_diff(diff),
            },
            Message::SpaceDiff(diff) => match self {
                Self::Plane(mirror) if mirror.frame().is_some() => {
                    Err(MirrorError::OtherSpace { frame: diff.frame.number })
                }
                _ => self.of_space().apply_space_diff(diff),
            },
            _ => return Ok(false),
        }
        .map(|()| true)
    }

    /// The newest verified frame, if there is one.
    pub fn frame(&self) -> Option<&FrameInfo> {
        either!(self, mirror => mirror.frame())
    }

    /// The number of the newest verified frame. 0: none.
    pub fn number(&self) -> u64 {
        either!(self, mirror => mirror.number())
    }

    /// Whether it accepts nothing but a snapshot.
    pub fn needs_snapshot(&self) -> bool {
        either!(self, mirror => mirror.needs_snapshot())
    }

    /// How many vertices, tree edges and critical edges it holds, and how many coordinates a vertex has.
    pub fn sizes(&self) -> ([usize; 3], usize) {
        let dimension = match self {
            Self::Plane(_) => 2,
            Self::Space(mirror) => mirror.place().dimension as usize,
        };
        let sizes = either!(self, mirror => [mirror.vertices().len(), mirror.edges().len(), mirror.critical().len()]);
        (sizes, dimension)
    }

    /// Its frame as a whole, as a daemon sends it first. None: it has no frame, or no snapshot has said its metric.
    pub fn snapshot(&self, stream: u32) -> Option<Message> {
        let frame = self.frame()?.clone();
        let (edges, critical) = either!(self, mirror => {
            let critical = mirror.critical().iter().map(|(&(a, b), &(birth, death))| (a, b, birth, death));
            (mirror.edges().iter().copied().collect(), critical.collect())
        });
        Some(match self {
            Self::Plane(mirror) => {
                let vertices = mirror.vertices().iter().map(|(&id, &(x, y))| (id, x, y)).collect();
                Snapshot { stream, cause: Cause::Start, frame, vertices, edges, critical, checksum: mirror.checksum() }
                    .into()
            }
            Self::Space(mirror) => SpaceSnapshot {
                stream,
                cause: Cause::Start,
                frame,
                metric: mirror.place().metric?,
                dimension: mirror.place().dimension,
                ids: mirror.vertices().keys().copied().collect(),
                coordinates: mirror.vertices().values().flat_map(|point| point.iter().copied()).collect(),
                edges,
                critical,
                checksum: mirror.checksum(),
            }
            .into(),
        })
    }

    fn of_plane(&mut self) -> &mut Mirror {
        if let Self::Space(_) = self {
            *self = Self::default();
        }
        let Self::Plane(mirror) = self else { unreachable!("it was made so") };
        mirror
    }

    fn of_space(&mut self) -> &mut SpaceMirror {
        if let Self::Plane(_) = self {
            *self = Self::Space(SpaceMirror::default());
        }
        let Self::Space(mirror) = self else { unreachable!("it was made so") };
        mirror
    }
}
