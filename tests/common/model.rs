//! A reference model of the cloud and its window: a plain list of points, searched from end to end.

use std::num::NonZeroU64;

use hopes::topology::Window;

use super::clouds::Point;

/// A window whose debug output is the code that makes it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Kept {
    All,
    Points(u64),
    Frames(u64),
    Time(f64),
}

impl Kept {
    pub fn window(self) -> Window {
        let positive = |n| NonZeroU64::new(n).expect("windows are not empty");
        match self {
            Kept::All => Window::All,
            Kept::Points(n) => Window::Points(positive(n)),
            Kept::Frames(n) => Window::Frames(positive(n)),
            Kept::Time(length) => Window::Time(length),
        }
    }
}

/// A point and its arrival.
#[derive(Clone, Copy, Debug)]
struct Entry {
    at: Point,
    frame: u64,
    /// The event time. Only time windows use it.
    time: f64,
}

/// The lifetime of a vertex, from its first point until no point is left. A lifetime that a commit has seen ends at a
/// commit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lifetime {
    pub at: Point,
    /// Lifetimes are numbered in order of first appearance.
    pub number: usize,
    committed: bool,
}

/// A cloud under a window.
#[derive(Clone, Debug)]
pub struct Model {
    kept: Kept,
    resolution: Option<f64>,
    /// In order of arrival.
    entries: Vec<Entry>,
    lifetimes: Vec<Lifetime>,
    lives_begun: usize,
    newest: Option<f64>,
    frame: u64,
    committed: Vec<Lifetime>,
    committed_points: usize,
}

impl Model {
    pub fn new(kept: Kept, resolution: Option<f64>) -> Self {
        Self {
            kept,
            resolution,
            entries: Vec::new(),
            lifetimes: Vec::new(),
            lives_begun: 0,
            newest: None,
            frame: 1,
            committed: Vec::new(),
            committed_points: 0,
        }
    }

    /// Inserts a point. Returns whether it was accepted.
    pub fn insert(&mut self, point: Point, time: Option<f64>) -> bool {
        let Some(at) = self.place(point) else { return false };
        let time = match (self.kept, time.or(self.newest)) {
            (Kept::Time(length), Some(time)) if time >= self.newest.unwrap_or(time) - length => time,
            (Kept::Time(_), _) => return false,
            _ => 0.0,
        };
        self.newest = Some(self.newest.map_or(time, |newest| newest.max(time)));
        self.entries.push(Entry { at, frame: self.frame, time });
        if !self.lifetimes.iter().any(|life| life.at == at) {
            self.lifetimes.push(Lifetime { at, number: self.lives_begun, committed: false });
            self.lives_begun += 1;
        }
        self.expire();
        true
    }

    /// Retracts the oldest point at a position. Returns whether there was one.
    pub fn retract(&mut self, point: Point) -> bool {
        let Some(at) = self.place(point) else { return false };
        let here = (0..self.entries.len()).filter(|&index| self.entries[index].at == at);
        let Some(oldest) = here.min_by(|&a, &b| self.entries[a].time.total_cmp(&self.entries[b].time)) else {
            return false;
        };
        self.entries.remove(oldest);
        self.end_lifetimes();
        true
    }

    pub fn advance_time(&mut self, time: f64) {
        self.newest = Some(self.newest.map_or(time, |newest| newest.max(time)));
        self.expire();
    }

    pub fn commit(&mut self) {
        if let Kept::Frames(frames) = self.kept {
            self.entries.retain(|entry| entry.frame + frames > self.frame);
        }
        self.frame += 1;
        for life in &mut self.lifetimes {
            life.committed = false;
        }
        self.end_lifetimes();
        for life in &mut self.lifetimes {
            life.committed = true;
        }
        self.committed = self.lifetimes.clone();
        self.committed_points = self.entries.len();
    }

    /// Number of commits.
    pub fn commits(&self) -> u64 {
        self.frame - 1
    }

    /// Points at the last commit.
    pub fn committed_points(&self) -> usize {
        self.committed_points
    }

    /// The vertices at the last commit, in order of first appearance.
    pub fn committed(&self) -> &[Lifetime] {
        &self.committed
    }

    /// The current points, in order of arrival.
    pub fn points(&self) -> Vec<Point> {
        self.entries.iter().map(|entry| entry.at).collect()
    }

    /// The newest event time.
    pub fn newest(&self) -> Option<f64> {
        self.newest
    }

    fn place(&self, point: Point) -> Option<Point> {
        let snap = |v: f64| match self.resolution {
            Some(step) => (v / step).round() * step,
            None => v,
        };
        // Adding 0.0 turns a negative zero into a positive one.
        point.iter().all(|v| v.is_finite()).then(|| point.map(|v| snap(v) + 0.0))
    }

    fn expire(&mut self) {
        match self.kept {
            Kept::Points(limit) => {
                let too_many = self.entries.len().saturating_sub(limit as usize);
                self.entries.drain(..too_many);
            }
            Kept::Time(length) => {
                let newest = self.newest.unwrap_or(f64::NEG_INFINITY);
                self.entries.retain(|entry| entry.time >= newest - length);
            }
            Kept::All | Kept::Frames(_) => return,
        }
        self.end_lifetimes();
    }

    /// Ends lifetimes without a point, unless a commit has seen them.
    fn end_lifetimes(&mut self) {
        let entries = &self.entries;
        self.lifetimes.retain(|life| life.committed || entries.iter().any(|entry| entry.at == life.at));
    }
}
