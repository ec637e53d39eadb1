//! Counts of durations in fixed buckets.

/// Upper bounds, s.
pub(super) const BOUNDS_S: [f64; 12] = [
    0.001, 0.002, 0.005, 0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1.0, 2.0, 5.0,
];

/// Durations since the start.
#[derive(Debug, Clone, Default)]
pub(super) struct Histogram {
    buckets: [u64; BOUNDS_S.len()],
    count: u64,
    sum_s: f64,
}

impl Histogram {
    /// Counts the time between two stamps of ns; an end before its start, as with wrong clocks, is not counted; returns
    /// whether it was.
    pub(super) fn take(&mut self, start_ns: u64, end_ns: u64) -> Result<(), BackInTime> {
        let duration_ns = end_ns.checked_sub(start_ns).ok_or(BackInTime)?;
        let seconds = duration_ns as f64 * 1e-9;
        if let Some(bucket) = BOUNDS_S.iter().position(|bound| seconds <= *bound) {
            self.buckets[bucket] += 1;
        }
        self.count += 1;
        self.sum_s += seconds;
        Ok(())
    }

    /// Durations up to each of [`BOUNDS_S`].
    pub(super) fn cumulative(&self) -> [u64; BOUNDS_S.len()] {
        let mut sum = 0;
        self.buckets.map(|count| {
            sum += count;
            sum
        })
    }

    pub(super) fn count(&self) -> u64 {
        self.count
    }

    pub(super) fn sum_s(&self) -> f64 {
        self.sum_s
    }
}

/// An end before its start.
#[derive(Debug)]
pub(super) struct BackInTime;
