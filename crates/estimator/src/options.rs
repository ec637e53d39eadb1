//! The tunables of fusion, each with unit, default, range and reason.

use serde::{Deserialize, Serialize};
use thiserror::Error;

/// Tunables of fusion.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct FusionOptions {
    /// Seconds of images kept for late ones to be inserted. Default 0.5, range 0 to 5: longer than the slowest way to the
    /// fusion node, short enough that a late image costs little.
    pub window_s: f64,
}

impl Default for FusionOptions {
    fn default() -> Self {
        Self { window_s: 0.5 }
    }
}

/// A tunable outside of its range.
#[derive(Debug, Clone, PartialEq, Error)]
#[error("{field} = {value} is outside of {lowest} to {highest}")]
pub struct OptionsError {
    /// Name of the field.
    pub field: &'static str,
    /// What it was given.
    pub value: f64,
    /// Lowest value allowed.
    pub lowest: f64,
    /// Highest value allowed.
    pub highest: f64,
}

impl FusionOptions {
    /// Whether each field lies in its range.
    ///
    /// # Errors
    /// For the first field that does not.
    pub fn validate(&self) -> Result<(), OptionsError> {
        within("window_s", self.window_s, 0.0, 5.0)
    }
}

fn within(field: &'static str, value: f64, lowest: f64, highest: f64) -> Result<(), OptionsError> {
    if (lowest..=highest).contains(&value) {
        Ok(())
    } else {
        Err(OptionsError {
            field,
            value,
            lowest,
            highest,
        })
    }
}
