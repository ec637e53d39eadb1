//! How much older than usual an observation is on arrival, as after a stall of the network or an overload.
//!
//! An age is the difference of two clocks, the camera's and this host's. Where both are disciplined the age itself is
//! judged. Elsewhere a clock may be off by any amount, and an age is judged against the smallest recent age of the same
//! camera.

/// Ages are compared within this time and the one before it, ns: stalls are shorter, and a clock that jumps is accepted
/// after it.
const SPAN_NS: u64 = 2_000_000_000;

/// The ages of one camera's observations, ns.
#[derive(Debug, Default, Clone, PartialEq)]
pub struct Ages {
    since_ns: u64,
    least_ns: Option<i64>,
    least_before_ns: Option<i64>,
}

impl Ages {
    /// By how many ns an observation of this age is too old if none may be older than the usual one. `monotonic_ns` is
    /// when it is read; `clocks_ns` is by how much the two clocks may differ at most, where that is known.
    pub fn excess_ns(&mut self, age_ns: i64, monotonic_ns: u64, clocks_ns: Option<u64>) -> i64 {
        if monotonic_ns.saturating_sub(self.since_ns) >= SPAN_NS {
            self.since_ns = monotonic_ns;
            self.least_before_ns = self.least_ns.take();
        }
        let least_ns = self
            .least_ns
            .map_or(age_ns, |least_ns| least_ns.min(age_ns));
        self.least_ns = Some(least_ns);
        let usual_ns = [
            self.least_before_ns,
            clocks_ns.map(|ns| i64::try_from(ns).unwrap_or(i64::MAX)),
        ];
        let usual_ns = usual_ns.into_iter().flatten().fold(least_ns, i64::min);
        age_ns.saturating_sub(usual_ns)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SECOND: u64 = 1_000_000_000;
    const PERIOD_NS: u64 = 33_333_333;

    /// The excesses of the images of some seconds whose ages are as given by the time at which they are read.
    fn excesses(
        ages: &mut Ages,
        from_s: u64,
        to_s: u64,
        age_ns: impl Fn(u64) -> i64,
        clocks_ns: Option<u64>,
    ) -> Vec<i64> {
        let times = (from_s * SECOND..to_s * SECOND).step_by(PERIOD_NS as usize);
        times
            .map(|at_ns| ages.excess_ns(age_ns(at_ns), at_ns, clocks_ns))
            .collect()
    }

    #[test]
    fn what_was_held_up_is_too_old_however_wrong_the_clock() {
        for offset_ns in [0, 7_000 * SECOND as i64, -(7_000 * SECOND as i64)] {
            let mut ages = Ages::default();
            let usual = |_: u64| offset_ns + 20_000_000;
            let before = excesses(&mut ages, 100, 110, usual, None);
            assert!(before.iter().all(|excess_ns| *excess_ns == 0));
            // Nothing for three seconds, then all at once.
            let held = (0..90).map(|image| (90 - image) * PERIOD_NS as i64);
            for age_ns in held {
                let excess_ns = ages.excess_ns(usual(0) + age_ns, 113 * SECOND, None);
                assert_eq!(excess_ns, age_ns);
            }
            let after = excesses(&mut ages, 113, 120, usual, None);
            assert!(after.iter().all(|excess_ns| *excess_ns == 0));
        }
    }

    #[test]
    fn a_clock_that_was_set_is_accepted_after_some_seconds_unless_both_are_verified() {
        let jumps = |at_ns: u64| {
            if at_ns < 105 * SECOND {
                0
            } else {
                3 * SECOND as i64
            }
        };
        let mut ages = Ages::default();
        let all = excesses(&mut ages, 100, 115, jumps, None);
        let too_old = all.iter().filter(|excess_ns| **excess_ns > 0).count() as u64;
        assert!(
            (1..=4 * SECOND / PERIOD_NS + 2).contains(&too_old),
            "{too_old}"
        );
        assert_eq!(all.last(), Some(&0));
        let mut ages = Ages::default();
        let all = excesses(&mut ages, 100, 115, jumps, Some(1_000_000));
        assert_eq!(all.last(), Some(&(3 * SECOND as i64 - 1_000_000)));
    }
}
