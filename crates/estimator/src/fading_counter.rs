//! Counts that fade exponentially.

/// Time after which an observation counts 1/e, s.
const MEMORY_S: f64 = 0.6;

/// Observations and those of them that were rejected, fading.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct FadingCounter {
    at_ns: u64,
    pub total: f64,
    pub rejected: f64,
}

impl FadingCounter {
    /// The counts at a later time.
    pub fn faded(&self, now_ns: u64) -> Self {
        let age_s = now_ns.saturating_sub(self.at_ns) as f64 * 1e-9;
        let keep = (-age_s / MEMORY_S).exp();
        Self {
            at_ns: now_ns.max(self.at_ns),
            total: self.total * keep,
            rejected: self.rejected * keep,
        }
    }

    pub fn add(&mut self, now_ns: u64, is_rejected: bool) {
        *self = self.faded(now_ns);
        self.total += 1.0;
        self.rejected += f64::from(u8::from(is_rejected));
    }

    /// Share of the rejected observations.
    pub fn share(&self) -> f64 {
        self.rejected / self.total.max(f64::MIN_POSITIVE)
    }
}
