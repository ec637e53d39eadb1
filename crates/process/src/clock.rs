//! The host's clocks: wire time (ns since the Unix epoch), the monotonic clock of drivers, and the kernel's estimate of
//! the error of wire time. Only reads clocks.

use std::time::{SystemTime, UNIX_EPOCH};

/// Current wire time: ns since the Unix epoch; 0 for a clock set before it, saturated after the year 2554.
pub fn now_ns() -> u64 {
    SystemTime::now()
        .duration_since(UNIX_EPOCH)
        .map_or(0, |since| {
            u64::try_from(since.as_nanos()).unwrap_or(u64::MAX)
        })
}

/// The monotonic clock (`CLOCK_MONOTONIC`) in ns, which V4L2 drivers use for timestamps.
pub fn monotonic_ns() -> u64 {
    let mut time = libc::timespec {
        tv_sec: 0,
        tv_nsec: 0,
    };
    // SAFETY: `time` is a valid, writable timespec for the whole call.
    if unsafe { libc::clock_gettime(libc::CLOCK_MONOTONIC, &raw mut time) } != 0 {
        return 0;
    }
    u64::try_from(time.tv_sec).unwrap_or(0) * 1_000_000_000
        + u64::try_from(time.tv_nsec).unwrap_or(0)
}

/// Both clocks at the same moment.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Reading {
    /// Wire time, ns.
    pub wall_ns: u64,
    /// `CLOCK_MONOTONIC`, ns.
    pub monotonic_ns: u64,
}

impl Reading {
    /// Reads the monotonic clock before and after the wall clock, so that a preemption in between causes half its
    /// length as error, and repeats if that took long.
    pub fn take() -> Self {
        let take = || {
            let before = monotonic_ns();
            let wall_ns = now_ns();
            let spent_ns = monotonic_ns().saturating_sub(before);
            let monotonic_ns = before + spent_ns / 2;
            (
                spent_ns,
                Self {
                    wall_ns,
                    monotonic_ns,
                },
            )
        };
        let (mut spent_ns, mut best) = take();
        for _ in 0..MOST_READS {
            if spent_ns < QUICK_NS {
                break;
            }
            let next = take();
            if next.0 < spent_ns {
                (spent_ns, best) = next;
            }
        }
        best
    }

    /// Wire time of an instant of the monotonic clock, by the current offset of the two clocks.
    fn wall_at_ns(&self, monotonic_ns: u64) -> u64 {
        let age = i128::from(self.monotonic_ns) - i128::from(monotonic_ns);
        u64::try_from(i128::from(self.wall_ns) - age).unwrap_or(0)
    }
}

/// Longest reading of both clocks that is exact enough, ns; and how often a longer one is repeated.
const QUICK_NS: u64 = 1_000_000;
const MOST_READS: usize = 8;

/// Wire time of an instant of the monotonic clock, by the current offset of the two clocks.
pub fn wall_from_monotonic_ns(instant_ns: u64) -> u64 {
    Reading::take().wall_at_ns(instant_ns)
}

/// Wire time that follows the monotonic clock between queries for steps of the wall clock. The kernel slews both clocks
/// alike: their difference changes only when the wall clock is set or the machine is suspended.
#[derive(Debug, Clone)]
pub struct SteadyClock {
    read: fn() -> Reading,
    since: Reading,
}

impl SteadyClock {
    /// Largest step that is followed without a report, ns; readings have smaller errors.
    pub const LEAST_STEP_NS: u64 = 10_000_000;

    /// A clock based on such readings ([`Reading::take`]).
    pub fn new(read: fn() -> Reading) -> Self {
        Self {
            read,
            since: read(),
        }
    }

    /// The monotonic clock, ns, for timers.
    pub fn monotonic_ns(&self) -> u64 {
        (self.read)().monotonic_ns
    }

    /// Wire time as of the last [`Self::take_step`], ns.
    pub fn now_ns(&self) -> u64 {
        self.since.wall_at_ns(self.monotonic_ns())
    }

    /// Step of the wall clock since the last call in ns, negative backwards; `None` without a step. From then on
    /// [`Self::now_ns`] follows the new time.
    pub fn take_step(&mut self) -> Option<i64> {
        let now = (self.read)();
        let by = i128::from(now.wall_ns) - i128::from(self.since.wall_at_ns(now.monotonic_ns));
        self.since = now;
        let is_step = by.unsigned_abs() >= u128::from(Self::LEAST_STEP_NS);
        is_step.then(|| by.clamp(i64::MIN.into(), i64::MAX.into()) as i64)
    }
}

/// Error of the wall clock.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct ClockQuality {
    /// Whether something (chrony, ntpd, ptp4l with phc2sys, timesyncd) disciplines this clock now.
    pub synchronised: bool,
    /// Estimated error in ns, one standard deviation, as reported by the discipline; 5 ms if it reports none; for an
    /// undisciplined clock the kernel's bound, up to 16 s.
    pub error_ns: u64,
}

impl ClockQuality {
    /// The kernel's estimate, by `adjtimex` in read-only mode; unsynchronised with the largest error if it has none,
    /// and for a time that is not [plausible](is_plausible).
    pub fn read() -> Self {
        if !is_plausible(now_ns()) {
            return Self::from_kernel(false, 0, MAX_ERROR_US);
        }
        // SAFETY: all-zero bytes are a valid timex (plain integers); `modes` 0 asks to read only.
        let mut timex: libc::timex = unsafe { std::mem::zeroed() };
        // SAFETY: `timex` is valid and writable for the whole call.
        let state = unsafe { libc::adjtimex(&raw mut timex) };
        if state == -1 {
            return Self::from_kernel(false, 0, MAX_ERROR_US);
        }
        let synchronised = state != libc::TIME_ERROR && timex.status & libc::STA_UNSYNC == 0;
        #[allow(
            clippy::useless_conversion,
            reason = "C longs, of 32 bits on 32-bit boards"
        )]
        Self::from_kernel(synchronised, timex.esterror.into(), timex.maxerror.into())
    }

    fn from_kernel(synchronised: bool, estimate_us: i64, bound_us: i64) -> Self {
        let error_us = match (synchronised, estimate_us) {
            (false, _) => bound_us,
            // timesyncd reports nothing and lets the bound grow by 500 ppm until the next answer of its server.
            (true, ..=0) => bound_us.min(UNSTATED_ERROR_US),
            (true, stated) => stated,
        };
        Self {
            synchronised,
            error_ns: error_us.clamp(0, MAX_ERROR_US).unsigned_abs() * 1000,
        }
    }
}

/// Whether a wire time is plausible: boards without a battery start in 1970, 2000 or 2018, before this software was
/// written.
pub fn is_plausible(now_ns: u64) -> bool {
    now_ns >= EARLIEST_NS
}

/// 1 January 2026, ns since the Unix epoch.
const EARLIEST_NS: u64 = 1_767_225_600_000_000_000;
/// Limit of the kernel's bound (`NTP_PHASE_LIMIT`).
const MAX_ERROR_US: i64 = 16_000_000;
/// Assumed error of NTP that reports none, on a local network.
const UNSTATED_ERROR_US: i64 = 5_000;

#[cfg(test)]
mod tests {
    use super::*;
    use std::cell::Cell;

    #[test]
    fn wire_time_is_of_this_century() {
        assert!(now_ns() > 1_700_000_000_000_000_000);
    }

    #[test]
    fn a_monotonic_instant_of_now_is_the_wall_clock_of_now() {
        let (before, instant) = (now_ns(), monotonic_ns());
        let wall = wall_from_monotonic_ns(instant);
        assert!(wall.abs_diff(before) < 1_000_000_000);
    }

    thread_local! {
        static READING: Cell<Reading> = const {
            Cell::new(Reading {
                wall_ns: 1_000_000_000_000,
                monotonic_ns: 5_000_000_000,
            })
        };
    }

    fn pass(wall_ns: i64, monotonic_ns: u64) {
        let Reading {
            wall_ns: wall,
            monotonic_ns: monotonic,
        } = READING.get();
        READING.set(Reading {
            wall_ns: wall.saturating_add_signed(wall_ns),
            monotonic_ns: monotonic + monotonic_ns,
        });
    }

    #[test]
    fn steady_time_goes_on_until_a_step_is_taken_and_then_by_the_new_time() {
        let second = 1_000_000_000;
        let mut clock = SteadyClock::new(|| READING.get());
        let start_ns = clock.now_ns();
        pass(second, second as u64);
        assert_eq!(clock.take_step(), None);
        pass(-30 * second, second as u64);
        assert_eq!(clock.now_ns(), start_ns + 2 * second as u64);
        assert_eq!(clock.take_step(), Some(-31 * second));
        assert_eq!(clock.now_ns(), READING.get().wall_ns);
        assert_eq!(clock.take_step(), None);
    }

    #[test]
    fn small_steps_are_followed_without_a_report() {
        let mut clock = SteadyClock::new(|| READING.get());
        for _ in 0..3 {
            pass(-6_000_000, 0);
            assert_eq!(clock.take_step(), None);
            assert_eq!(clock.now_ns(), READING.get().wall_ns);
        }
    }

    #[test]
    fn the_clocks_of_this_machine_are_not_set_meanwhile() {
        assert_eq!(SteadyClock::new(Reading::take).take_step(), None);
    }

    #[test]
    fn a_disciplined_clock_errs_by_what_its_discipline_states() {
        assert_eq!(
            ClockQuality::from_kernel(true, 120, 900_000).error_ns,
            120_000
        );
        assert_eq!(
            ClockQuality::from_kernel(true, 0, 900_000).error_ns,
            5_000_000
        );
        assert_eq!(ClockQuality::from_kernel(true, 0, 300).error_ns, 300_000);
        assert_eq!(
            ClockQuality::from_kernel(false, 120, 16_000_000).error_ns,
            16_000_000_000
        );
    }

    #[test]
    fn times_before_this_software_are_not_now() {
        assert!(is_plausible(now_ns()));
        assert!(!is_plausible(1_514_764_800_000_000_000) && !is_plausible(0));
    }

    #[test]
    fn the_error_of_the_clock_has_a_bound() {
        assert!(ClockQuality::read().error_ns <= 16_000_000_000);
    }
}
