//! Takes the time of each stage of a detection.

use sextant_apriltag::{Observer, Stage};
use std::time::{Duration, Instant};

/// How long each stage took, all its passes together.
#[derive(Debug)]
pub struct StageClock {
    times: [Duration; Stage::ALL.len()],
    last: Instant,
}

impl StageClock {
    /// To be made just before a detection.
    pub fn start() -> Self {
        Self {
            times: Default::default(),
            last: Instant::now(),
        }
    }

    /// Time of a stage.
    pub fn time(&self, stage: Stage) -> Duration {
        self.times[stage as usize]
    }
}

impl Observer for StageClock {
    fn stage_ended(&mut self, stage: Stage) {
        let now = Instant::now();
        self.times[stage as usize] += now - self.last;
        self.last = now;
    }
}
