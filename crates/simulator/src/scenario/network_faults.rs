//! Faults of the network, as plain data: each is off by default.

use serde::{Deserialize, Serialize};

/// What the network does to one camera's messages.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct NetworkFaults {
    /// Probability that a message never arrives.
    pub loss: f64,
    /// Mean delay, ms.
    pub delay_ms: f64,
    /// Standard deviation of the delay, ms; a delay is never below 0.
    pub jitter_ms: f64,
    /// Probability that a message is held back and overtaken by later ones.
    pub reorder: f64,
    /// How long a held message waits in addition, ms.
    pub reorder_ms: f64,
    /// Probability that a message arrives twice.
    pub duplicate: f64,
    /// From when until when the camera is cut off, seconds after its first message: what is sent or would arrive
    /// meanwhile is lost. Nothing is where both are the same.
    pub partition_s: [f64; 2],
}
