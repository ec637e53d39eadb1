//! Offset and drift between a browser's clock and this host's, by round trips.
//!
//! Of a round trip, t1 is when the host sent, t2 when the browser received, t3 when it answered and t4 when the host
//! received the answer. With equal delays on both ways the browser's clock is ahead by ((t2 - t1) + (t3 - t4)) / 2, and
//! the error is at most half of the delay (t4 - t1) - (t3 - t2) (D. Mills, RFC 5905, section 8). Delays have a least
//! value and a long tail, so the round trip of least delay in each [`SLOT_NS`] is kept (minimum filter), and a weighted
//! line through them gives the drift.

use std::collections::VecDeque;

/// One round trip is kept of each span of time.
const SLOT_NS: u64 = 2_000_000_000;
/// Round trips that are kept: the last minute.
const MAX_SLOTS: usize = 30;
/// Standard deviation of the drift of a device's crystal before it is compared, as a share.
const UNKNOWN_DRIFT: f64 = 50e-6;
/// Standard deviation of what a drift may change by within a minute.
const DRIFT_CHANGE: f64 = 1e-6;
/// Resolution of browsers' clocks, ns: 0.1 ms, 1 ms in some.
const RESOLUTION_NS: f64 = 1e5;
/// Beyond every error of round trips, ns: the browser's clock stood still while it slept, or this host's was set.
const STEP_NS: f64 = 5e6;

/// One round trip, ns by the clocks of host (1 and 4) and browser (2 and 3).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct RoundTrip {
    pub(super) sent_ns: u64,
    pub(super) received_there_ns: u64,
    pub(super) sent_there_ns: u64,
    pub(super) received_ns: u64,
}

impl RoundTrip {
    fn delay_ns(&self) -> Option<u64> {
        let whole = self.received_ns.checked_sub(self.sent_ns)?;
        whole.checked_sub(self.sent_there_ns.checked_sub(self.received_there_ns)?)
    }

    fn offset_ns(&self) -> i64 {
        let there = self.received_there_ns.midpoint(self.sent_there_ns);
        let here = self.sent_ns.midpoint(self.received_ns);
        i128::from(there)
            .saturating_sub(i128::from(here))
            .clamp(i64::MIN.into(), i64::MAX.into()) as i64
    }
}

#[derive(Debug, Clone, Copy)]
struct Sample {
    /// By the browser's clock.
    at_ns: u64,
    offset_ns: i64,
    delay_ns: u64,
}

/// The browser's clock, compared with this host's.
#[derive(Debug, Default)]
pub(super) struct ClockComparison {
    /// The best of each slot, oldest first.
    samples: VecDeque<Sample>,
    line: Option<Line>,
}

/// How much the browser's clock is ahead: `offset_ns + drift * (t - at_ns)`.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Line {
    at_ns: u64,
    offset_ns: i64,
    drift: f64,
    /// Standard deviations of the offset, ns, and of the drift.
    sigma_ns: f64,
    drift_sigma: f64,
}

/// A time by this host's clock, with the standard deviation of the conversion.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct HostTime {
    pub(super) at_ns: u64,
    pub(super) error_ns: u64,
}

impl ClockComparison {
    /// Adds a round trip; ignores impossible times.
    pub(super) fn handle(&mut self, trip: &RoundTrip) {
        let Some(delay_ns) = trip.delay_ns() else {
            return;
        };
        let sample = Sample {
            at_ns: trip.sent_there_ns,
            offset_ns: trip.offset_ns(),
            delay_ns,
        };
        if self.is_step(&sample) {
            self.samples.clear();
        }
        match self.samples.back_mut() {
            Some(last) if last.at_ns / SLOT_NS == sample.at_ns / SLOT_NS => {
                if delay_ns < last.delay_ns {
                    *last = sample;
                }
            }
            _ => {
                if self.samples.len() == MAX_SLOTS {
                    self.samples.pop_front();
                }
                self.samples.push_back(sample);
            }
        }
        self.line = self.fit();
    }

    /// Whether a round trip contradicts those before it, whatever its delays were.
    fn is_step(&self, sample: &Sample) -> bool {
        let Some(last) = self.samples.back() else {
            return false;
        };
        let Some(expected) = self.line.map(|line| line.offset_at(sample.at_ns)) else {
            return false;
        };
        let far = (sample.offset_ns as f64 - expected).abs();
        sample.at_ns < last.at_ns || far > sample.delay_ns as f64 / 2.0 + STEP_NS
    }

    /// Converts a time of the browser's clock; none before the first round trip.
    pub(super) fn host_time(&self, there_ns: u64) -> Option<HostTime> {
        let line = self.line?;
        let at_ns = there_ns as f64 - line.at_ns as f64;
        let offset_ns = line.offset_ns.saturating_add((line.drift * at_ns) as i64);
        Some(HostTime {
            at_ns: there_ns.saturating_add_signed(offset_ns.saturating_neg()),
            error_ns: line.sigma_ns.hypot(line.drift_sigma * at_ns) as u64,
        })
    }

    /// Weighted least-squares line through the offsets; each weight follows from the delay in excess of the minimum,
    /// with a zero-mean prior on the drift. An asymmetry of the minimum delay is unobservable and not part of the
    /// errors of the fit.
    fn fit(&self) -> Option<Line> {
        let best = self.samples.iter().min_by_key(|sample| sample.delay_ns)?;
        let points: Vec<Point> = self
            .samples
            .iter()
            .map(|sample| Point::relative_to(best, sample))
            .collect();
        let weight: f64 = points.iter().map(|point| point.weight).sum();
        let mean = |of: &dyn Fn(&Point) -> f64| {
            points
                .iter()
                .map(|point| point.weight * of(point))
                .sum::<f64>()
                / weight
        };
        let (at, offset) = (mean(&|point| point.at), mean(&|point| point.offset));
        let moment = mean(&|point| (point.at - at).powi(2));
        let product = mean(&|point| (point.at - at) * (point.offset - offset));
        let information = weight * moment + UNKNOWN_DRIFT.powi(-2);
        let drift = weight * product / information;
        let residual = |point: &Point| (point.offset - offset - drift * (point.at - at)).powi(2);
        // Where clocks tick coarsely, residuals are larger than their weights say.
        let excess = (weight * mean(&residual) / points.len() as f64).max(1.0);
        let asymmetry_ns = best.delay_ns as f64 / 2.0 / 3_f64.sqrt();
        Some(Line {
            at_ns: best.at_ns.saturating_add_signed(at as i64),
            offset_ns: best.offset_ns.saturating_add(offset as i64),
            drift,
            sigma_ns: (excess / weight).sqrt().hypot(asymmetry_ns),
            drift_sigma: (excess / information).sqrt().hypot(DRIFT_CHANGE),
        })
    }
}

/// A round trip relative to another one, ns, with the inverse variance of its offset.
struct Point {
    at: f64,
    offset: f64,
    weight: f64,
}

impl Point {
    fn relative_to(base: &Sample, sample: &Sample) -> Self {
        let spare_ns = (sample.delay_ns - base.delay_ns) as f64 / 2.0 / 3_f64.sqrt();
        Self {
            at: sample.at_ns as f64 - base.at_ns as f64,
            offset: sample.offset_ns as f64 - base.offset_ns as f64,
            weight: RESOLUTION_NS.hypot(spare_ns).powi(-2),
        }
    }
}

impl Line {
    fn offset_at(&self, there_ns: u64) -> f64 {
        self.offset_ns as f64 + self.drift * (there_ns as f64 - self.at_ns as f64)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const START_NS: u64 = 1_800_000_000_000_000_000;
    const AHEAD_NS: i64 = 37_000_000_000;

    /// A browser whose clock is ahead and gains a share, on a network of these delays.
    struct World {
        gain: f64,
    }

    impl World {
        fn there(&self, here_ns: u64) -> u64 {
            let gained = self.gain * (here_ns - START_NS) as f64;
            here_ns.saturating_add_signed(AHEAD_NS + gained as i64)
        }

        fn trip(&self, at_ns: u64, out_ns: u64, back_ns: u64) -> RoundTrip {
            let [arrived, answered] = [at_ns + out_ns, at_ns + out_ns + 200_000];
            RoundTrip {
                sent_ns: at_ns,
                received_there_ns: self.there(arrived),
                sent_there_ns: self.there(answered),
                received_ns: answered + back_ns,
            }
        }

        /// Error of converting a time, and the error that is reported.
        fn error(&self, clock: &ClockComparison, here_ns: u64) -> (f64, f64) {
            let host = clock.host_time(self.there(here_ns)).unwrap();
            let error = host.at_ns as f64 - here_ns as f64;
            (error.abs(), host.error_ns as f64)
        }
    }

    /// Delays with a tail: 2 ms, and up to 60 ms more on either way.
    fn jittered(i: u64) -> [u64; 2] {
        [i * 7919, i * 104_729].map(|x| 2_000_000 + (x % 61).pow(2) * 16_000)
    }

    #[test]
    fn nothing_is_known_before_the_first_round_trip() {
        assert_eq!(ClockComparison::default().host_time(START_NS), None);
    }

    #[test]
    fn an_offset_is_found_within_half_of_the_delay() {
        let (world, mut clock) = (World { gain: 0.0 }, ClockComparison::default());
        clock.handle(&world.trip(START_NS, 9_000_000, 1_000_000));
        let (error, stated) = world.error(&clock, START_NS);
        assert!(
            error <= 5_000_000.0 && stated > 2_000_000.0,
            "{error} {stated}"
        );
        clock.handle(&world.trip(START_NS + 100_000_000, 1_000_000, 1_000_000));
        assert!(world.error(&clock, START_NS + 100_000_000).0 < 100_000.0);
    }

    #[test]
    fn drift_is_learnt_and_errors_stay_within_what_is_stated() {
        for gain in [-80e-6, 0.0, 40e-6] {
            let (world, mut clock) = (World { gain }, ClockComparison::default());
            for i in 0..180 {
                let at_ns = START_NS + i * 1_000_000_000;
                let [out, back] = jittered(i);
                clock.handle(&world.trip(at_ns, out, back));
                let (error, stated) = world.error(&clock, at_ns + 500_000_000);
                assert!(error < 3.0 * stated, "{gain} {i}: {error} {stated}");
                assert!(i < 30 || stated < 3_000_000.0, "{gain} {i}: {stated}");
            }
            let drift = clock.line.unwrap().drift;
            assert!((drift - gain).abs() < 20e-6, "{drift} {gain}");
        }
    }

    #[test]
    fn a_clock_that_stood_still_is_compared_anew() {
        let (before, mut clock) = (World { gain: 0.0 }, ClockComparison::default());
        for i in 0..20 {
            clock.handle(&before.trip(START_NS + i * 1_000_000_000, 1_000_000, 1_000_000));
        }
        let mut trip = before.trip(START_NS + 80_000_000_000, 1_000_000, 1_000_000);
        trip.received_there_ns -= 40_000_000_000;
        trip.sent_there_ns -= 40_000_000_000;
        clock.handle(&trip);
        let host = clock.host_time(trip.sent_there_ns).unwrap();
        assert!(host.at_ns.abs_diff(START_NS + 80_000_000_000) < 3_000_000);
    }

    #[test]
    fn impossible_times_are_passed_over_and_extremes_do_no_harm() {
        let mut clock = ClockComparison::default();
        let numbers = [0, 1, START_NS, u64::MAX];
        for i in 0..256_usize {
            let [a, b, c, d] = [0, 2, 4, 6].map(|shift| numbers[i >> shift & 3]);
            clock.handle(&RoundTrip {
                sent_ns: a,
                received_there_ns: b,
                sent_there_ns: c,
                received_ns: d,
            });
            for at in numbers {
                let _ = clock.host_time(at);
            }
            assert!(clock.samples.len() <= MAX_SLOTS);
        }
    }
}
