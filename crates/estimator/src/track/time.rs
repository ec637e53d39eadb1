//! What an object's images have told about the cameras' clocks.
//!
//! Cameras that say nothing about their clocks are taken to agree, which most do: synchronised by cable, or on one machine.
//! [`super::rivalry`] decides whether that holds; where it does not, the offsets of all clocks that nobody vouches for are
//! estimated.

use crate::filter::kinematics::Kinematics;
use crate::site::StatedClock;
use crate::{ClockOffset, FusionOptions};

/// What is held of the clocks.
#[derive(Debug, Clone, PartialEq, Default)]
pub(crate) struct Timing {
    /// Whether the clocks that nobody vouches for are estimated.
    pub open: bool,
    /// When the question was last settled, in ns.
    pub settled_ns: Option<u64>,
    /// By camera index: what an earlier track found out.
    learned: Vec<Option<ClockOffset>>,
}

impl Timing {
    /// What is to be estimated about a clock; `None` where it is taken at its word.
    pub fn clock(
        &self,
        camera_index: usize,
        stated: StatedClock,
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
        match stated {
            StatedClock::Right => None,
            StatedClock::Within(sigma_s) => within(sigma_s),
            StatedClock::Unknown if self.open => within(options.unknown_clock_s),
            StatedClock::Unknown => None,
        }
    }

    /// Keeps what a track that ends has found out about the clocks.
    pub fn learn(&mut self, state: &Kinematics) {
        for (camera_index, prior) in state.clocks.iter().flat_map(|clocks| clocks.offsets()) {
            if self.learned.len() <= camera_index {
                self.learned.resize(camera_index + 1, None);
            }
            self.learned[camera_index] = Some(prior);
        }
    }
}
