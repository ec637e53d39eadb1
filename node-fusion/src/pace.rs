//! Limits how often changes of the site are applied, so that a flood of them does not delay images. Times are ns by the
//! monotonic clock.

/// Least pause between two changes.
const LEAST_NS: u64 = 50_000_000;
/// Pause after a change in multiples of its duration: changes take at most a tenth of the time.
const REST: u64 = 9;

/// When the next change is due.
#[derive(Debug, Default)]
pub struct Pace {
    due_ns: u64,
}

impl Pace {
    /// Whether a change may be applied.
    pub fn is_due(&self, now_ns: u64) -> bool {
        now_ns >= self.due_ns
    }

    /// A change has been handled.
    pub fn rest(&mut self, begun_ns: u64, ended_ns: u64) {
        let took_ns = ended_ns.saturating_sub(begun_ns);
        self.due_ns = ended_ns + took_ns.saturating_mul(REST).max(LEAST_NS);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_slow_change_is_followed_by_a_long_rest() {
        let mut pace = Pace::default();
        assert!(pace.is_due(0));
        pace.rest(0, 0);
        assert!(!pace.is_due(LEAST_NS / 2));
        assert!(pace.is_due(LEAST_NS));
        let ended_ns = 2 * LEAST_NS;
        pace.rest(0, ended_ns);
        assert!(!pace.is_due(ended_ns + 17 * LEAST_NS));
        assert!(pace.is_due(ended_ns + 18 * LEAST_NS));
    }
}
