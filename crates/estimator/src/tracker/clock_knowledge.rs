//! What an object's images have told about the cameras' clocks.
//!
//! Cameras that say nothing about their clocks are taken to agree, which most do: synchronised by cable, or on one machine.
//! [`crate::tracker::clock_model_selection`] decides whether that holds; where it does not, the offsets of all clocks that nobody vouches for are
//! estimated.

use crate::filter::state::ObjectState;
use crate::site::ClockPrior;
use crate::time::seconds;
use crate::{ClockOffset, FusionOptions};

/// What is held of the clocks.
#[derive(Debug, Clone, PartialEq, Default)]
pub(crate) struct ClockKnowledge {
    /// Whether the clocks that nobody vouches for are estimated.
    pub open: bool,
    /// Whether a camera whose clock is right has seen the object.
    pub has_right_clock: bool,
    /// When it was last settled of which cameras' clocks that they agree, in ns.
    settled: Vec<(usize, u64)>,
    /// Cameras whose clocks are in doubt, whoever vouches for them.
    doubted: Vec<usize>,
    /// By camera index: what an earlier track found out.
    learned: Vec<Option<ClockOffset>>,
}

impl ClockKnowledge {
    /// Notes that the clocks of these cameras agree.
    pub fn settle(&mut self, time_ns: u64, cameras: &[usize]) {
        for camera in cameras {
            self.settled.retain(|(other, _)| other != camera);
            self.settled.push((*camera, time_ns));
            self.doubted.retain(|other| other != camera);
        }
    }

    /// That they agree is in question again, whoever vouches for it.
    pub fn doubt(&mut self, cameras: &[usize]) {
        self.settled.retain(|(camera, _)| !cameras.contains(camera));
        self.doubted.retain(|camera| !cameras.contains(camera));
        self.doubted.extend(cameras);
    }

    /// Cameras whose clocks are in doubt, whoever vouches for them.
    pub fn doubted(&self) -> &[usize] {
        &self.doubted
    }

    /// Whether these are in doubt.
    pub fn are_doubted(&self, cameras: &[usize]) -> bool {
        cameras.iter().all(|camera| self.doubted.contains(camera))
    }

    /// What is said about a camera's clock, as far as that is believed.
    pub fn accepted(&self, camera_index: usize, stated: ClockPrior) -> ClockPrior {
        match stated {
            ClockPrior::Right if self.doubted.contains(&camera_index) => ClockPrior::Unknown,
            _ => stated,
        }
    }

    /// Whether that is known of a camera's clock.
    pub fn is_settled(&self, camera_index: usize, time_ns: u64, options: &FusionOptions) -> bool {
        let mut settled = self.settled.iter();
        settled.any(|(camera, settled_ns)| {
            *camera == camera_index && seconds(*settled_ns, time_ns) < options.clock_recheck_s
        })
    }

    /// What is to be estimated about a clock; `None` where it is taken at its word.
    pub fn clock(
        &self,
        camera_index: usize,
        stated: ClockPrior,
        options: &FusionOptions,
    ) -> Option<ClockOffset> {
        let learned = self.learned.get(camera_index).copied().flatten();
        let within = |sigma_s: f64| {
            let stated = ClockOffset {
                offset_s: 0.0,
                sigma_s,
            };
            Some(learned.unwrap_or(stated))
        };
        match self.accepted(camera_index, stated) {
            ClockPrior::Right => None,
            // The motion tells differences only: without a clock that is right this one is.
            ClockPrior::Reference(sigma_s) if self.has_right_clock => within(sigma_s),
            ClockPrior::Reference(_) => None,
            ClockPrior::Within(sigma_s) => within(sigma_s),
            ClockPrior::Unknown if self.open => within(options.unknown_clock_s),
            ClockPrior::Unknown => None,
        }
    }

    /// So many seconds more are taken off a camera's stamps from now on.
    pub fn shift(&mut self, camera_index: usize, by_s: f64) {
        if let Some(Some(learned)) = self.learned.get_mut(camera_index) {
            learned.offset_s -= by_s;
        }
    }

    /// Keeps what a track that ends has found out about the clocks.
    pub fn learn(&mut self, state: &ObjectState) {
        for (camera_index, prior) in state.clock_offsets() {
            if self.learned.len() <= camera_index {
                self.learned.resize(camera_index + 1, None);
            }
            self.learned[camera_index] = Some(prior);
        }
    }
}
