//! The stages of a frame's computation, and a hook that a caller with a clock can put between them.
//!
//! In: a listener. Out: a call at the begin of each stage. Invariants: without a listener a stage costs one test of an option; the
//! listener is called on the thread that polls the frame. Must not know: clocks, metrics.

use std::fmt;
use std::sync::Arc;

/// A stage of a frame's computation. Each frame that is computed goes through all of them, in this order.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Stage {
    /// The change of the cloud is taken, and the Delaunay triangulation is brought up to date.
    Triangulation,
    /// The skeleton is found: filtration, basins and reduction of everything, or of the tiles that the change has touched.
    Reduction,
    /// The skeleton is there. What follows (views, diffs, tracks) is work for one consumer, not for the frame.
    Done,
}

/// Where the begin of stages is reported; nowhere, by default. Clones report to the same listener.
#[derive(Clone, Default)]
pub(super) struct StageHook(Option<Arc<dyn Fn(Stage) + Send + Sync>>);

impl StageHook {
    pub fn new(listener: impl Fn(Stage) + Send + Sync + 'static) -> Self {
        Self(Some(Arc::new(listener)))
    }

    /// Reports that a stage begins.
    #[inline]
    pub fn begin(&self, stage: Stage) {
        if let Some(listener) = &self.0 {
            listener(stage);
        }
    }
}

impl fmt::Debug for StageHook {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(if self.0.is_some() { "StageHook(set)" } else { "StageHook(unset)" })
    }
}

#[cfg(test)]
mod tests {
    use std::sync::{Arc, Mutex};

    use super::Stage;
    use crate::topology::{Follower, Options, Pipeline, ViewSpec};

    fn is_send<T: Send + Clone + std::fmt::Debug>(_: &T) {}

    #[test]
    fn every_computed_frame_reports_its_stages_once() {
        let seen = Arc::new(Mutex::new(Vec::new()));
        let mut pipeline = Pipeline::new(Options::default());
        is_send(&pipeline);
        let log = Arc::clone(&seen);
        pipeline.set_stage_listener(move |stage| log.lock().unwrap().push(stage));
        let all = [Stage::Triangulation, Stage::Reduction, Stage::Done];
        let take = || std::mem::take(&mut *seen.lock().unwrap());
        pipeline.feed_points(&[[0.0, 0.0], [2.0, 0.0], [2.0, 2.0], [0.0, 2.0]], None);
        pipeline.commit(None);
        assert_eq!(take(), [], "nothing is computed before it is asked for");
        pipeline.poll_frame();
        assert_eq!(take(), all);
        let mut follower = Follower::new(ViewSpec::Full);
        pipeline.poll_step(&mut follower);
        assert_eq!(take(), [], "the frame is there");
        // A small change is followed in tiles, or computed in one pass: the stages are the same.
        let mut tiled = pipeline.clone().with_leaf(4);
        for engine in [&mut pipeline, &mut tiled] {
            engine.feed_points(&[[1.0, 3.0]], None);
            engine.commit(None);
            engine.poll_step(&mut follower.clone());
            assert_eq!(take(), all);
        }
    }
}
