//! The host's clock: wire time (ns since the Unix epoch), the monotonic clock of drivers, and what the kernel knows of
//! the error of the former. Reads clocks; never sets one.

use std::time::{SystemTime, UNIX_EPOCH};

/// Wire time now: ns since the Unix epoch; 0 for a clock set before it, the largest value after the year 2554.
pub fn now_ns() -> u64 {
    SystemTime::now()
        .duration_since(UNIX_EPOCH)
        .map_or(0, |since| {
            u64::try_from(since.as_nanos()).unwrap_or(u64::MAX)
        })
}

/// The monotonic clock (`CLOCK_MONOTONIC`) in ns, in which V4L2 drivers stamp their buffers.
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

/// Wire time of an instant of the monotonic clock, by the offset of the two clocks at this moment (the monotonic clock is
/// read on both sides of the wall clock, so a preemption between the reads costs half its length, not all of it).
pub fn wall_from_monotonic_ns(instant_ns: u64) -> u64 {
    let before = monotonic_ns();
    let wall = now_ns();
    let after = monotonic_ns();
    let age = (before + (after - before) / 2) as i128 - i128::from(instant_ns);
    u64::try_from(i128::from(wall) - age).unwrap_or(0)
}

/// How far the wall clock may be off.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ClockQuality {
    /// Whether something (chrony, ntpd, ptp4l with phc2sys, timesyncd) disciplines this clock now.
    pub synchronised: bool,
    /// Estimated error in ns, one standard deviation, as the discipline states it; 5 ms where it states none; for an
    /// undisciplined clock the kernel's bound, up to 16 s: nobody knows.
    pub error_ns: u64,
}

impl ClockQuality {
    /// The kernel's opinion, by `adjtimex` in read-only mode; unsynchronised with the largest error if it has none.
    pub fn read() -> Self {
        // SAFETY: all-zero bytes are a valid timex (plain integers); `modes` 0 asks to read only.
        let mut timex: libc::timex = unsafe { std::mem::zeroed() };
        // SAFETY: `timex` is valid and writable for the whole call.
        let state = unsafe { libc::adjtimex(&raw mut timex) };
        if state == -1 {
            return Self::of(false, 0, MAX_ERROR_US);
        }
        let synchronised = state != libc::TIME_ERROR && timex.status & libc::STA_UNSYNC == 0;
        #[allow(
            clippy::useless_conversion,
            reason = "C longs, of 32 bits on 32-bit boards"
        )]
        Self::of(synchronised, timex.esterror.into(), timex.maxerror.into())
    }

    fn of(synchronised: bool, estimate_us: i64, bound_us: i64) -> Self {
        let error_us = match (synchronised, estimate_us) {
            (false, _) => bound_us,
            // timesyncd states nothing and lets the bound grow by 500 ppm until the next answer of its server.
            (true, ..=0) => bound_us.min(UNSTATED_ERROR_US),
            (true, stated) => stated,
        };
        Self {
            synchronised,
            error_ns: error_us.clamp(0, MAX_ERROR_US).unsigned_abs() * 1000,
        }
    }
}

/// Where the kernel's bound stops growing (`NTP_PHASE_LIMIT`).
const MAX_ERROR_US: i64 = 16_000_000;
/// What NTP without a statement is taken to keep, on a local network.
const UNSTATED_ERROR_US: i64 = 5_000;

#[cfg(test)]
mod tests {
    use super::*;

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

    #[test]
    fn a_disciplined_clock_errs_by_what_its_discipline_states() {
        assert_eq!(ClockQuality::of(true, 120, 900_000).error_ns, 120_000);
        assert_eq!(ClockQuality::of(true, 0, 900_000).error_ns, 5_000_000);
        assert_eq!(ClockQuality::of(true, 0, 300).error_ns, 300_000);
        assert_eq!(
            ClockQuality::of(false, 120, 16_000_000).error_ns,
            16_000_000_000
        );
    }

    #[test]
    fn the_error_of_the_clock_has_a_bound() {
        assert!(ClockQuality::read().error_ns <= 16_000_000_000);
    }
}
