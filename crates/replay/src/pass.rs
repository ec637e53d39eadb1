//! Inputs through the estimator, and which of its poses are final.

use crate::ledger::Ledger;
use sextant_estimator::{Fusion, Input, Output};
use sextant_site_report::ObjectEstimate;

/// Follows the inputs and final poses of a replay.
pub trait ReplayObserver {
    /// What ends the replay.
    type Error;

    /// Called before an input that was processed or recorded at `now_ns`; may wait, to keep the recorded pace.
    ///
    /// # Errors
    /// What ends the replay.
    fn before(&mut self, now_ns: u64) -> Result<(), Self::Error>;

    /// Takes poses that have become final, ordered by object.
    ///
    /// # Errors
    /// What ends the replay.
    fn take(&mut self, poses: &[ObjectEstimate]) -> Result<(), Self::Error>;
}

/// One pass of a recording through the estimator.
pub struct Pass {
    /// The estimator; replaced where the recorded node was restarted.
    pub fusion: Fusion,
    ledger: Ledger,
    poses: Vec<ObjectEstimate>,
}

impl Pass {
    /// A pass of images of these capture times.
    pub fn new(fusion: Fusion, capture_times_ns: impl Iterator<Item = u64>) -> Self {
        Self {
            fusion,
            ledger: Ledger::new(capture_times_ns),
            poses: Vec::new(),
        }
    }

    /// Handles an input; returns every pose that the estimator gives after it, final or not.
    ///
    /// # Errors
    /// Of the observer.
    pub fn handle<O: ReplayObserver>(
        &mut self,
        now_ns: u64,
        input: Input,
        observer: &mut O,
    ) -> Result<Vec<ObjectEstimate>, O::Error> {
        observer.before(now_ns)?;
        let capture_ns = match &input {
            Input::Image(image) => Some(image.capture_ns),
            _ => None,
        };
        self.fusion.handle(now_ns, input);
        let outputs = std::iter::from_fn(|| self.fusion.poll_output());
        let estimates: Vec<_> = outputs.filter_map(pose_of).collect();
        if let Some(capture_ns) = capture_ns {
            let finals = self.ledger.took(capture_ns, estimates.iter().cloned());
            observer.take(&finals)?;
            self.poses.extend(finals);
        }
        Ok(estimates)
    }

    /// The final poses, sorted by time and object, and the estimator.
    pub fn finish(mut self) -> (Vec<ObjectEstimate>, Fusion) {
        self.poses
            .sort_by(|a, b| (a.capture_ns, &a.object).cmp(&(b.capture_ns, &b.object)));
        (self.poses, self.fusion)
    }
}

fn pose_of(output: Output) -> Option<ObjectEstimate> {
    match output {
        Output::Pose(estimate) => Some(estimate),
        Output::Refused(_) | Output::ClockStep { .. } => None,
    }
}
