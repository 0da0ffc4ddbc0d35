//! A reference model of windows: the points that `hopes serve` should have, in a plain list.

use std::collections::VecDeque;

/// The kinds of windows.
#[derive(Clone, Copy)]
pub enum Keep {
    All,
    Points(usize),
    Frames(u64),
    Time(f64),
}

/// A window with its points.
pub struct Window {
    keep: Keep,
    /// Points with their frame and event time, in order of arrival.
    points: VecDeque<([f64; 2], u64, f64)>,
    frame: u64,
    now: f64,
}

impl Window {
    pub fn new(keep: Keep) -> Self {
        Self { keep, points: VecDeque::new(), frame: 1, now: f64::NEG_INFINITY }
    }

    /// Inserts a point. Returns whether it is accepted.
    pub fn insert(&mut self, point: [f64; 2], time: f64) -> bool {
        if matches!(self.keep, Keep::Time(length) if time < self.now - length) {
            return false;
        }
        self.points.push_back((point, self.frame, time));
        self.advance(time);
        true
    }

    pub fn advance(&mut self, time: f64) {
        self.now = self.now.max(time);
        match self.keep {
            Keep::Points(count) => drop(self.points.drain(..self.points.len().saturating_sub(count))),
            Keep::Time(length) => self.points.retain(|&(_, _, time)| time >= self.now - length),
            Keep::All | Keep::Frames(_) => {}
        }
    }

    /// Removes the oldest point at a position: by time in a time window, else by arrival. Returns whether there was
    /// one.
    pub fn retract(&mut self, point: [f64; 2]) -> bool {
        let there = self.points.iter().enumerate().filter(|(_, (other, ..))| *other == point);
        let oldest = match self.keep {
            Keep::Time(_) => there.min_by(|a, b| a.1.2.total_cmp(&b.1.2)),
            _ => there.min_by_key(|&(index, _)| index),
        };
        oldest.map(|(index, _)| index).is_some_and(|index| self.points.remove(index).is_some())
    }

    pub fn commit(&mut self, time: f64) {
        self.advance(time);
        if let Keep::Frames(count) = self.keep {
            self.points.retain(|&(_, frame, _)| frame + count > self.frame);
        }
        self.frame += 1;
    }

    pub fn as_csv(&self) -> String {
        self.points.iter().map(|([x, y], ..)| format!("{x},{y}\n")).collect()
    }
}
