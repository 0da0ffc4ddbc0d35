//! The points that leave a cloud because its window moves on.
//!
//! In: event times, frame numbers, counts of points.
//! Out: points that leave their places.
//! Invariants: a retracted point leaves once. The queue of arrivals is bounded by the points in the window.
//! Must not know: how vertices are found by position.

use super::refusal::Refusal;
use super::site::Site;
use super::staging::Staging;
use super::store::Cloud;
use super::window::{Arrival, Window};

impl<S: Site> Cloud<S> {
    /// Moves event time forward without a point.
    ///
    /// # Errors [`Refusal::TimeNotFinite`].
    pub fn advance_time(&mut self, time: f64) -> Result<(), Refusal> {
        self.note_time(time)?;
        self.expire();
        Ok(())
    }

    pub(super) fn key(&mut self, time: Option<f64>) -> Result<f64, Refusal> {
        if let Some(time) = time {
            // A time that is too late leaves the newest time as it is.
            self.note_time(time)?;
            let oldest = self.window_start(self.newest_time.unwrap_or(time));
            if time < oldest {
                return Err(Refusal::TooLate { time, oldest });
            }
        }
        Ok(match self.window {
            Window::Time(_) => time.or(self.newest_time).ok_or(Refusal::NoTime)?,
            Window::All | Window::Points(_) | Window::Frames(_) => self.frame as f64,
        })
    }

    /// Whether a point may wait with this time.
    pub(super) fn check_time(&self, staging: &mut Staging<S>, time: Option<f64>) -> Result<(), Refusal> {
        let Some(time) = time else { return Ok(()) };
        if !time.is_finite() {
            return Err(Refusal::TimeNotFinite(time));
        }
        match self.window {
            Window::Time(_) => self.clocks.say(&mut staging.clock, self.now(), time, staging.waiting.len()),
            _ => Ok(()),
        }
    }

    pub(super) fn note_time(&mut self, time: f64) -> Result<(), Refusal> {
        if !time.is_finite() {
            return Err(Refusal::TimeNotFinite(time));
        }
        self.newest_time = Some(self.newest_time.map_or(time, |newest| newest.max(time)));
        Ok(())
    }

    pub(super) fn window_start(&self, newest: f64) -> f64 {
        match self.window {
            Window::Time(length) => newest - length,
            _ => f64::NEG_INFINITY,
        }
    }

    /// Whether a point with this key leaves before points that arrived earlier.
    pub(super) fn is_late(&self, key: f64) -> bool {
        matches!(self.window, Window::Time(_)) && self.newest_time.is_some_and(|newest| key < newest)
    }

    /// Removes the points that have left the window.
    pub(super) fn expire(&mut self) {
        match self.window {
            Window::Points(limit) => {
                while self.points > limit.get() {
                    let Some(arrival) = self.queue.pop() else { return };
                    self.forget(arrival);
                }
            }
            Window::Time(_) => {
                if let Some(newest) = self.newest_time {
                    self.expire_below(self.window_start(newest));
                }
            }
            Window::All | Window::Frames(_) => {}
        }
    }

    pub(super) fn expire_below(&mut self, limit: f64) {
        while let Some(arrival) = self.queue.pop_below(limit) {
            self.forget(arrival);
        }
    }

    /// Removes the point of an arrival that has left the window, unless it was retracted before.
    pub(super) fn forget(&mut self, arrival: Arrival) {
        let place = &mut self.places[arrival.slot as usize];
        if place.vertex.id != arrival.vertex {
            return;
        }
        if place.retracted > 0 {
            place.retracted -= 1;
        } else {
            self.leave(arrival.slot);
        }
    }

    /// Drops the arrivals of retracted points once they are most of the queue, so that the queue stays bounded by the
    /// window.
    pub(super) fn sweep_queue(&mut self) {
        if (self.queue.len() as u64) >= 2 * self.points + 1024 {
            self.drop_retracted();
        }
    }

    pub(super) fn drop_retracted(&mut self) {
        let places = &mut self.places;
        self.queue.retain(|arrival| {
            let place = &mut places[arrival.slot as usize];
            if place.vertex.id != arrival.vertex {
                return false;
            }
            let retracted = place.retracted > 0;
            place.retracted -= u32::from(retracted);
            !retracted
        });
    }
}
