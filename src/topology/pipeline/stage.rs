//! The stages of a frame's computation, and the hook that reports them.
//!
//! In: a listener.
//! Out: a call at the begin of each stage.
//! Invariants: without a listener a stage costs one test of an option. The listener is called on the thread that polls
//! the frame.
//! Must not know: clocks, metrics.

use std::fmt;
use std::sync::Arc;

/// A stage of a frame's computation. Every computed frame goes through all of them, in this order.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Stage {
    /// The change of the cloud is taken, outliers are told apart if that is asked for, and the Delaunay triangulation
    /// is updated. Outside of the plane, the points are gathered.
    Triangulation,
    /// The skeleton is found: filtration, basins and reduction of everything, or of the touched tiles. Outside of the
    /// plane, the sweep over pairs.
    Reduction,
    /// The skeleton is computed. Views, diffs, tracks and whole frames gathered from tiles come after this; they belong
    /// to single consumers.
    Done,
}

/// Calls a listener, if one is set. Clones call the same listener.
#[derive(Clone, Default)]
pub(super) struct StageHook(Option<Arc<dyn Fn(Stage) + Send + Sync>>);

impl StageHook {
    pub fn new(listener: impl Fn(Stage) + Send + Sync + 'static) -> Self {
        Self(Some(Arc::new(listener)))
    }

    /// Reports the begin of a stage.
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
        // The stages are the same whether a small change is followed in tiles or computed in one pass.
        let mut tiled = pipeline.clone().with_leaf(4);
        for engine in [&mut pipeline, &mut tiled] {
            engine.feed_points(&[[1.0, 3.0]], None);
            engine.commit(None);
            engine.poll_step(&mut follower.clone());
            assert_eq!(take(), all);
        }
    }
}
