//! Counts that fade.

/// Seconds after which a view counts 1/e.
const MEMORY_S: f64 = 0.6;

/// The part of a count of then that still counts now.
pub(crate) fn kept(then_ns: u64, now_ns: u64) -> f64 {
    let age_s = now_ns.saturating_sub(then_ns) as f64 * 1e-9;
    (-age_s / MEMORY_S).exp()
}

/// Counts that fade.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct FadingCounter {
    at_ns: u64,
    pub views: f64,
    pub refused: f64,
}

impl FadingCounter {
    pub fn faded(&self, now_ns: u64) -> Self {
        let keep = kept(self.at_ns, now_ns);
        Self {
            at_ns: now_ns.max(self.at_ns),
            views: self.views * keep,
            refused: self.refused * keep,
        }
    }

    pub fn add(&mut self, now_ns: u64, agreed: bool) {
        *self = self.faded(now_ns);
        self.views += 1.0;
        self.refused += if agreed { 0.0 } else { 1.0 };
    }

    pub fn share(&self) -> f64 {
        self.refused / self.views.max(f64::MIN_POSITIVE)
    }
}
