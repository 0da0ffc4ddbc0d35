//! The clock of an engine: how long the stages of a frame take.
//!
//! In: the begin of each stage, from the stream's pipeline. Out: the time spent in each since it was asked last.
//!
//! Invariants: time between a frame's last stage and the next frame's first belongs to no stage.
//!
//! Must not know: what happens in a stage.

use std::time::{Duration, Instant};

use hopes::topology::Stage;

use crate::daemon::locks::{Level, Lock};

/// Time spent in each stage.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct StageTimes {
    /// Updating the triangulation.
    pub triangulation: Duration,
    /// Reducing the filtration to the skeleton.
    pub reduction: Duration,
}

/// Measures the stages of a pipeline.
#[derive(Debug)]
pub struct StageClock(Lock<State>);

impl Default for StageClock {
    fn default() -> Self {
        Self(Lock::new(Level::Leaf, State::default()))
    }
}

#[derive(Debug, Default)]
struct State {
    /// The stage under way, and since when.
    current: Option<(Stage, Instant)>,
    times: StageTimes,
}

impl StageClock {
    /// A stage begins, and the one before it ends.
    pub fn begin(&self, stage: Stage) {
        let now = Instant::now();
        let mut state = self.0.lock();
        if let Some((before, since)) = state.current {
            let took = now - since;
            match before {
                Stage::Triangulation => state.times.triangulation += took,
                Stage::Reduction => state.times.reduction += took,
                Stage::Done => {}
            }
        }
        state.current = (stage != Stage::Done).then_some((stage, now));
    }

    /// The time spent in each stage since this was asked last.
    pub fn take(&self) -> StageTimes {
        std::mem::take(&mut self.0.lock().times)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stages_are_measured_apart_and_once() {
        let clock = StageClock::default();
        for stage in [Stage::Triangulation, Stage::Reduction, Stage::Done] {
            clock.begin(stage);
            std::thread::sleep(Duration::from_millis(2));
        }
        let times = clock.take();
        assert!(times.triangulation >= Duration::from_millis(2) && times.reduction >= Duration::from_millis(2));
        assert_eq!(clock.take(), StageTimes::default());
    }
}
