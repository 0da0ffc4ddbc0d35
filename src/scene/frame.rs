//! A frame of a scene: its points, the difference from the previous frame, and its truth.
//!
//! In: what is seen of each sample; true holes and their events.
//! Out: frames.
//! Invariants: `gone` and `come` lead from the points of the previous frame to those of this one.
//! Must not know: how points are made, what space they are in.

use super::FRAMES_A_SECOND;
use super::random::Random;
use super::truth::{TrueEvent, TrueHole};

/// A frame of a scene.
#[derive(Clone, Debug, PartialEq)]
pub struct Frame<P = [f64; 2], H = TrueHole> {
    /// Counts frames from 1.
    pub number: u64,
    /// Event time, in seconds.
    pub time: f64,
    /// All points of the frame. Stray points are last, unless the points are shuffled.
    pub points: Vec<P>,
    /// How many of them are stray points.
    pub clutter: usize,
    /// Points of the previous frame that are no longer there.
    pub gone: Vec<P>,
    /// Points that were not in the previous frame.
    pub come: Vec<P>,
    /// The true holes, by id.
    pub holes: Vec<H>,
    /// The events of the true holes.
    pub events: Vec<TrueEvent>,
}

impl<P: Clone + PartialEq, H> Frame<P, H> {
    /// A frame without points.
    pub(super) fn new(number: u64, (holes, events): (Vec<H>, Vec<TrueEvent>)) -> Self {
        let time = number as f64 / FRAMES_A_SECOND;
        Self { number, time, points: Vec::new(), clutter: 0, gone: Vec::new(), come: Vec::new(), holes, events }
    }

    /// Takes what is seen of each sample now. `before` is what was seen of it in the previous frame.
    pub(super) fn show(&mut self, before: &mut Vec<Option<P>>, mut now: Vec<Option<P>>) {
        let slots = before.len().max(now.len());
        before.resize(slots, None);
        now.resize(slots, None);
        for (before, now) in before.iter().zip(&now) {
            self.points.extend(now.clone());
            if before != now {
                self.gone.extend(before.clone());
                self.come.extend(now.clone());
            }
        }
        *before = now;
    }

    /// Gives the points in a random order.
    pub(super) fn shuffle(&mut self, order: &mut Random) {
        for points in [&mut self.points, &mut self.gone, &mut self.come] {
            let count = points.len();
            order.choose(points, count);
        }
    }
}
