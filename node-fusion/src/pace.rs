//! Limits how often changes of the site are applied, so that a flood of them does not delay images.

use std::time::{Duration, Instant};

/// Least pause between two changes.
const LEAST: Duration = Duration::from_millis(50);
/// Pause after a change in multiples of its duration, files included: changes take at most a tenth of the time.
const REST: u32 = 9;

/// When the next change is due.
#[derive(Debug, Default)]
pub struct Pace {
    due: Option<Instant>,
}

impl Pace {
    /// Whether a change may be applied.
    pub fn is_due(&self, now: Instant) -> bool {
        self.due.is_none_or(|due| now >= due)
    }

    /// A change has been handled from `begun` to `ended`.
    pub fn rest(&mut self, begun: Instant, ended: Instant) {
        let took = ended.saturating_duration_since(begun);
        self.due = Some(ended + took.saturating_mul(REST).max(LEAST));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_slow_change_is_followed_by_a_long_rest() {
        let (mut pace, start) = (Pace::default(), Instant::now());
        assert!(pace.is_due(start));
        pace.rest(start, start);
        assert!(!pace.is_due(start + LEAST / 2));
        assert!(pace.is_due(start + LEAST));
        let ended = start + 2 * LEAST;
        pace.rest(start, ended);
        assert!(!pace.is_due(ended + 17 * LEAST));
        assert!(pace.is_due(ended + 18 * LEAST));
    }
}
