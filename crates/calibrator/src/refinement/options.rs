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

impl RefinementOptions {
    /// Whether every number is in its range.
    ///
    /// # Errors
    /// The first that is not, in words.
    pub fn check(&self) -> Result<(), String> {
        let numbers = [
            ("largest_move_m", self.largest_move_m, 0.0..=1.0),
            ("largest_turn_rad", self.largest_turn_rad, 0.0..=0.5),
            ("significance", self.significance, 2.0..=100.0),
            ("least_gain", self.least_gain, 0.0..=1.0),
            ("memory_s", self.memory_s, 60.0..=1e7),
            ("fastest_px_s", self.fastest_px_s, 1.0..=1e5),
        ];
        for (name, value, range) in numbers {
            if !range.contains(&value) {
                let (from, to) = range.into_inner();
                return Err(format!("{name} must lie between {from} and {to}"));
            }
        }
        for (name, value) in [
            ("most_used", self.most_used),
            ("most_held_back", self.most_held_back),
        ] {
            if !(20..=1000).contains(&value) {
                return Err(format!("{name} must lie between 20 and 1000"));
            }
        }
        Ok(())
    }
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
