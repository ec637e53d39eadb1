//! What can be set of a refinement.

use serde::{Deserialize, Serialize};

/// Tunables.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct RefinementOptions {
    /// How far a camera or tag may be moved from where it was calibrated, metres. Default 0.005: what is further off was bumped.
    pub largest_move_m: f64,
    /// How far it may be turned, radians. Default 0.01.
    pub largest_turn_rad: f64,
    /// Least value of Student's t over the moments held back, each its cost before less its cost after. Default 4.3: one of
    /// a thousand by chance with ten moments, fewer with more.
    pub significance: f64,
    /// Least part by which the cost of the moments held back must fall. Default 0.01: less is not worth a change.
    pub least_gain: f64,
    /// Moments that changes are made from at most. Default 60.
    pub most_used: usize,
    /// Moments held back at most. Default 30.
    pub most_held_back: usize,
    /// Moments older than this are forgotten, seconds of capture time. Default 7200: warmth moves cameras within hours.
    pub memory_s: f64,
    /// Images in which a corner goes faster say too much of shutters and clocks, pixels a second. Default 150.
    pub fastest_px_s: f64,
}

impl Default for RefinementOptions {
    fn default() -> Self {
        Self {
            largest_move_m: 0.005,
            largest_turn_rad: 0.01,
            significance: 4.3,
            least_gain: 0.01,
            most_used: 60,
            most_held_back: 30,
            memory_s: 7200.0,
            fastest_px_s: 150.0,
        }
    }
}
