//! Differences of times that are given in nanoseconds.

/// Seconds from one time to another; negative where the second is earlier.
pub(crate) fn seconds(from_ns: u64, to_ns: u64) -> f64 {
    (i128::from(to_ns) - i128::from(from_ns)) as f64 * 1e-9
}

/// A duration in nanoseconds; 0 where it is negative.
pub(crate) fn nanoseconds(duration_s: f64) -> u64 {
    (duration_s * 1e9) as u64
}
