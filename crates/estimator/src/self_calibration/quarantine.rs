//! Keyframes that wait until diagnosis has judged the images around them: evidence that may show a fault is not learned
//! as an error of the files.

use std::collections::VecDeque;

use crate::self_calibration::keyframes::Keyframe;

/// Most keyframes: those of ten objects at a usual rate.
const MOST: usize = 1024;

/// Keyframes in order of arrival.
#[derive(Debug, Default)]
pub(crate) struct Quarantine(VecDeque<Keyframe>);

impl Quarantine {
    /// Takes a keyframe in; at the bound it is dropped.
    pub fn hold(&mut self, keyframe: Keyframe) {
        if self.0.len() < MOST {
            self.0.push_back(keyframe);
        }
    }

    /// The next keyframe that was taken up to a time.
    pub fn release(&mut self, until_ns: u64) -> Option<Keyframe> {
        let first = self.0.front()?;
        (first.time_ns <= until_ns).then(|| self.0.pop_front())?
    }
}
