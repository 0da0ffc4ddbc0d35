//! Points of R^d among the inputs of a stream, line by line.
//!
//! In: a source, and which columns are coordinates.
//! Out: points, retractions and commits, to a batcher.
//! Invariants: those of [`PointSource`]. Of a series, each delay vector stands at the line of its last sample.
//! Must not know: where inputs go.

use super::{Batcher, Closed, PointSource, PointsError};
use crate::daemon::{Point, Positions};
use crate::formats::input::space::{PointReader, PointRecord, PointSettings};

/// Reads all points of a source.
pub(super) fn read_lines(
    source: &PointSource,
    settings: &PointSettings,
    batcher: &mut Batcher<'_>,
    progress: &dyn Fn(u64),
) -> Result<Result<(), Closed>, PointsError> {
    let mut reader = PointReader::new(source.path(), source.open()?, settings).map_err(PointsError::Space)?;
    batcher.place = reader.unit();
    let mut held = Vec::new();
    loop {
        let sent = match reader.next_record().map_err(PointsError::Space)? {
            None => return Ok(Ok(())),
            Some(PointRecord::Points { coordinates, time }) => {
                held.clear();
                held.extend_from_slice(coordinates);
                let (line, width) = (reader.number(), reader.dimension().unwrap_or(1));
                held.chunks_exact(width).try_for_each(|point| batcher.add(Point::Space(point), time, line))
            }
            Some(PointRecord::Retract { coordinates }) => {
                let coordinates = coordinates.to_vec();
                let dimension = reader.dimension().unwrap_or(1);
                batcher.retract(Positions::Space { dimension, coordinates }, reader.number())
            }
            Some(PointRecord::Commit { time }) => batcher.commit(time),
            Some(PointRecord::Blank) => batcher.commit(None),
            Some(PointRecord::Nothing) => Ok(()),
            Some(PointRecord::Refused(reason)) => batcher.report_error(reason),
        };
        if let Some(choice) = reader.take_choice() {
            tracing::info!("{}: {}", source.name(), choice.text);
        }
        // Nothing waits here while the source has no further bytes.
        let flushed = if reader.is_ready() { Ok(()) } else { batcher.flush() };
        if sent.and(flushed).is_err() {
            return Ok(Err(Closed));
        }
        if reader.number() % 1024 == 0 {
            progress(reader.bytes_read());
        }
    }
}
