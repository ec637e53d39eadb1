//! For how long one may go on to ask who is wrong: where errors are not stated, views contradict for ever.

/// Nanoseconds of contests in vain after which none is held, and how often as many until the next.
const PATIENCE_NS: u64 = 5_000_000_000;
const REST: u64 = 9;

/// For how long contests have been held.
#[derive(Debug, Default)]
pub(crate) struct DutyCycle {
    at_ns: u64,
    spent_ns: u64,
    rests: bool,
}

impl DutyCycle {
    /// Whether a contest may be held now; `is_held` tells whether one has been since.
    pub fn allows(&mut self, now_ns: u64, is_held: bool) -> bool {
        let gone_ns = now_ns.saturating_sub(std::mem::replace(&mut self.at_ns, now_ns));
        self.spent_ns = if is_held {
            self.spent_ns.saturating_add(gone_ns)
        } else {
            self.spent_ns.saturating_sub(gone_ns / REST)
        };
        self.rests = self.spent_ns > PATIENCE_NS || (self.rests && self.spent_ns > 0);
        !self.rests
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SECOND_NS: u64 = 1_000_000_000;

    #[test]
    fn of_what_nobody_explains_one_grows_weary_and_recovers() {
        let mut duty_cycle = DutyCycle::default();
        let mut allowed = Vec::new();
        let mut is_held = false;
        for second in 1..=120 {
            is_held = duty_cycle.allows(second * SECOND_NS, is_held);
            allowed.push(is_held);
        }
        let held = allowed.iter().filter(|held| **held).count();
        assert!(allowed[..6].iter().all(|held| *held));
        assert!((12..=18).contains(&held), "{held}");
        assert!(allowed[60..].contains(&true));
    }
}
