//! What a track knows of the cameras' clocks.
//!
//! A clock whose error is within the tolerance is right; the offset of every other clock is estimated. Cameras that
//! expose in the very same nanosecond are triggered or stamped by one clock, whatever they report.

use crate::FusionOptions;
use crate::filter::state::ObjectState;
use crate::site::{ClockPrior, ObjectImage};
use sextant_site_report::ClockOffset;

/// What a track knows of the clocks.
#[derive(Debug, Clone, PartialEq, Default)]
pub(crate) struct ClockKnowledge {
    /// Whether a camera whose clock is right has seen the object.
    has_right_clock: bool,
    /// Cameras that expose in the same nanosecond as others.
    synchronous: Vec<usize>,
    /// Cameras whose clocks may be off, whatever they report.
    doubted: Vec<usize>,
    /// Offsets that an earlier track has estimated, by camera index.
    learned: Vec<Option<ClockOffset>>,
}

impl ClockKnowledge {
    /// Whether the images of an instant change this.
    pub fn is_changed_by(&self, images: &[&ObjectImage]) -> bool {
        let is_new = |image: &&ObjectImage| match self.accepted(image) {
            ClockPrior::Right => !self.has_right_clock,
            ClockPrior::Unknown => images.len() > 1,
            _ => false,
        };
        images.iter().any(is_new)
    }

    /// Takes in the images of an instant.
    pub fn observe(&mut self, images: &[&ObjectImage]) {
        for image in images {
            match self.accepted(image) {
                ClockPrior::Right => self.has_right_clock = true,
                ClockPrior::Unknown if images.len() > 1 => {
                    self.synchronous.push(image.camera_index);
                    self.doubted.retain(|camera| *camera != image.camera_index);
                }
                _ => {}
            }
        }
    }

    /// These clocks may be off, whatever their cameras report.
    pub fn doubt(&mut self, cameras: &[usize]) {
        self.synchronous.retain(|camera| !cameras.contains(camera));
        self.doubted.retain(|camera| !cameras.contains(camera));
        self.doubted.extend(cameras);
    }

    fn accepted(&self, image: &ObjectImage) -> ClockPrior {
        match image.clock {
            ClockPrior::Right if self.doubted.contains(&image.camera_index) => ClockPrior::Unknown,
            ClockPrior::Unknown if self.synchronous.contains(&image.camera_index) => {
                ClockPrior::Right
            }
            given => given,
        }
    }

    /// Prior of the offset of an image's clock; `None` where the clock is right.
    pub fn clock(&self, image: &ObjectImage, options: &FusionOptions) -> Option<ClockOffset> {
        let sigma_s = match self.accepted(image) {
            ClockPrior::Right => return None,
            // The motion tells differences only: without a clock that is right this one is.
            ClockPrior::Reference(_) if !self.has_right_clock => return None,
            ClockPrior::Reference(sigma_s) | ClockPrior::Within(sigma_s) => sigma_s,
            ClockPrior::Unknown => options.unknown_clock_s,
        };
        let learned = self.learned.get(image.camera_index).copied().flatten();
        let given = ClockOffset {
            offset_s: 0.0,
            sigma_s,
        };
        Some(learned.unwrap_or(given))
    }

    /// From now on `by_s` seconds more are subtracted from the timestamps of a camera.
    pub fn shift(&mut self, camera_index: usize, by_s: f64) {
        if let Some(Some(learned)) = self.learned.get_mut(camera_index) {
            learned.offset_s -= by_s;
        }
    }

    /// Keeps the offsets that a track which ends has estimated.
    pub fn learn(&mut self, state: &ObjectState) {
        for (camera_index, prior) in state.clock_offsets() {
            if self.learned.len() <= camera_index {
                self.learned.resize(camera_index + 1, None);
            }
            self.learned[camera_index] = Some(prior);
        }
    }
}
