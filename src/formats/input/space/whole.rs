//! All points of a source, as a space.
//!
//! In: a source, how its points are read, and the most of them.
//! Out: a [`Space`] of points, and how many lines and points were left out.
//! Invariants: no more is held than is allowed; one point beyond ends the reading.
//! Must not know: how a point is read.

use std::io::Read;
use std::path::Path;

use super::points::{PointReader, PointRecord, PointSettings};
use super::{Notice, Space, SpaceError};

/// The most coordinates of all points together: 2 GiB of them.
const MOST_IN_ALL: usize = 1 << 28;

/// What was read of a source of points.
#[derive(Clone, Debug, PartialEq)]
pub struct PointsRead {
    /// The points, in the order of the source.
    pub space: Space,
    /// Lines and points that cannot be used.
    pub rejected: u64,
    /// How often a series was interrupted.
    pub gaps: u64,
}

/// Reads all points, which are at most so many.
///
/// # Errors
/// [`SpaceError`].
pub fn read_points(
    path: Option<&Path>,
    source: impl Read,
    settings: &PointSettings,
    most: usize,
    notice: &mut dyn FnMut(Notice),
) -> Result<PointsRead, SpaceError> {
    let mut reader = PointReader::new(path, source, settings)?;
    let (mut all, mut rejected) = (Vec::new(), 0);
    loop {
        let refused = match reader.next_record()? {
            None => break,
            Some(PointRecord::Points { coordinates, .. }) => {
                all.extend_from_slice(coordinates);
                None
            }
            Some(PointRecord::Retract { .. }) => {
                Some(format!("{}: points are not taken back here: leave them out", reader.place()))
            }
            Some(PointRecord::Refused(reason)) => Some(reason),
            Some(PointRecord::Commit { .. } | PointRecord::Blank | PointRecord::Nothing) => None,
        };
        let dimension = reader.dimension().unwrap_or(0);
        if all.len() > most.saturating_mul(dimension) {
            return Err(SpaceError::Points { place: reader.place(), most });
        }
        if all.len() > MOST_IN_ALL {
            return Err(SpaceError::Coordinates { place: reader.place(), most: MOST_IN_ALL });
        }
        if let Some(reason) = refused {
            rejected += 1;
            notice(Notice::Refused(reason));
        }
        if let Some(choice) = reader.take_choice() {
            notice(Notice::Taken(choice.text));
        }
    }
    let space =
        Space::Points { dimension: reader.dimension().filter(|_| !all.is_empty()).unwrap_or(0), coordinates: all };
    Ok(PointsRead { space, rejected, gaps: reader.gaps() })
}
