//! Ranges that hold for every message that enters or leaves: finite floats, unit quaternions, bounded lists.

use crate::limits::{
    MAX_DETAIL_BYTES, MAX_DISTANCE_M, MAX_NAME_BYTES, MAX_PLACEMENT_M, MAX_TIME_NS,
    QUATERNION_TOLERANCE,
};

/// A value outside its documented range.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("`{0}` is out of range")]
pub struct OutOfRange(
    /// The field, as a path inside the message.
    pub &'static str,
);

pub(crate) type Checked = Result<(), OutOfRange>;

pub(crate) fn holds(condition: bool, field: &'static str) -> Checked {
    if condition {
        Ok(())
    } else {
        Err(OutOfRange(field))
    }
}

pub(crate) fn finite(values: &[f64], field: &'static str) -> Checked {
    holds(values.iter().all(|v| v.is_finite()), field)
}

/// Finite and not below zero.
pub(crate) fn amount(value: f64, field: &'static str) -> Checked {
    holds(value.is_finite() && value >= 0.0, field)
}

pub(crate) fn time(ns: u64, field: &'static str) -> Checked {
    holds(ns <= MAX_TIME_NS, field)
}

pub(crate) fn position(metres: [f64; 3], field: &'static str) -> Checked {
    holds(metres.iter().all(|v| v.abs() <= MAX_DISTANCE_M), field)
}

/// As [`position`], of what is written in a rig or an object.
pub(crate) fn placement(metres: [f64; 3], field: &'static str) -> Checked {
    holds(metres.iter().all(|v| v.abs() <= MAX_PLACEMENT_M), field)
}

pub(crate) fn orientation(xyzw: [f64; 4], field: &'static str) -> Checked {
    let length = xyzw.iter().map(|v| v * v).sum::<f64>().sqrt();
    holds((length - 1.0).abs() <= QUATERNION_TOLERANCE, field)
}

/// A 2x2 covariance as xx, xy, yy: finite and without negative directions (up to rounding in f32).
pub(crate) fn covariance_2x2([xx, xy, yy]: [f32; 3], field: &'static str) -> Checked {
    let (xx, xy, yy) = (f64::from(xx), f64::from(xy), f64::from(yy));
    finite(&[xx, xy, yy], field)?;
    holds(
        xx >= 0.0 && yy >= 0.0 && xy * xy <= xx * yy * (1.0 + 1e-5) + f64::from(f32::MIN_POSITIVE),
        field,
    )
}

pub(crate) fn widened<const N: usize>(values: [f32; N]) -> [f64; N] {
    values.map(f64::from)
}

pub(crate) fn name(text: &str, field: &'static str) -> Checked {
    holds(text.len() <= MAX_NAME_BYTES, field)
}

/// A text for people, or a key.
pub(crate) fn detail(text: &str, field: &'static str) -> Checked {
    holds(text.len() <= MAX_DETAIL_BYTES, field)
}
