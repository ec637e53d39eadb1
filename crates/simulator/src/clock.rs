//! A camera's clock and its schedule: true time and camera time, and when the next image falls due.
//!
//! True time is the simulator's own, in ns. A camera's clock shows `true + offset + drift * (true - start)`.

use serde::{Deserialize, Serialize};

/// How a camera's clock goes wrong, and what the camera believes of it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct ClockFaults {
    /// How far the clock is ahead of true time at the scenario's start, ns.
    pub offset_ns: i64,
    /// How much faster than true time it runs, parts per million; within +-1000.
    pub drift_ppm: f64,
    /// The error that the camera states with its images, ns.
    pub error_ns: u64,
}

/// The clock of a camera: its offset, drift and steps.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Clock {
    faults: ClockFaults,
    start_ns: u64,
}

impl Clock {
    /// A clock with these faults; its drift counts from `start_ns` in true time.
    pub fn new(faults: ClockFaults, start_ns: u64) -> Self {
        Self { faults, start_ns }
    }

    /// What the clock shows at a true time.
    pub fn camera_ns(&self, true_ns: u64) -> u64 {
        let elapsed = i128::from(true_ns) - i128::from(self.start_ns);
        let drift = (elapsed as f64 * self.faults.drift_ppm * 1e-6).round() as i128;
        bounded(i128::from(true_ns) + i128::from(self.faults.offset_ns) + drift)
    }

    /// The true time at which the clock shows `camera_ns`, to 1 ns.
    pub fn true_ns(&self, camera_ns: u64) -> u64 {
        let shown =
            i128::from(camera_ns) - i128::from(self.faults.offset_ns) - i128::from(self.start_ns);
        let drift = self.faults.drift_ppm * 1e-6;
        let share = (shown as f64 * (drift / (1.0 + drift))).round() as i128;
        bounded(i128::from(self.start_ns) + shown - share)
    }
}

fn bounded(ns: i128) -> u64 {
    ns.clamp(0, i128::from(u64::MAX)) as u64
}

/// When a camera takes its images: at `(n + phase) * period` of true time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Schedule {
    period_ns: u64,
    phase_ns: u64,
}

impl Schedule {
    /// Images at `rate_hz`, shifted by `phase` of a period (0 to 1) against the whole multiples of the period.
    pub fn new(rate_hz: f64, phase: f64) -> Self {
        let period_ns = ((1e9 / rate_hz).round() as u64).max(1);
        let phase_ns = (phase.clamp(0.0, 1.0) * period_ns as f64) as u64 % period_ns;
        Self {
            period_ns,
            phase_ns,
        }
    }

    /// The first capture time (middle of the exposure) at or after `true_ns`.
    pub fn next_at_or_after(&self, true_ns: u64) -> u64 {
        let late = (true_ns % self.period_ns + self.period_ns - self.phase_ns) % self.period_ns;
        if late == 0 {
            true_ns
        } else {
            true_ns.saturating_add(self.period_ns - late)
        }
    }

    /// Time between two images in ns.
    pub fn period_ns(&self) -> u64 {
        self.period_ns
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const NOW: u64 = 1_780_000_000_000_000_000;

    #[test]
    fn drift_counts_from_the_start() {
        let faults = ClockFaults {
            offset_ns: -2_000_000,
            drift_ppm: 50.0,
            error_ns: 0,
        };
        let clock = Clock::new(faults, NOW);
        assert_eq!(clock.camera_ns(NOW), NOW - 2_000_000);
        assert_eq!(
            clock.camera_ns(NOW + 10_000_000_000),
            NOW + 10_000_000_000 - 1_500_000
        );
    }

    proptest! {
        #[test]
        fn true_time_comes_back_from_camera_time(
            offset_ns in -1_000_000_000i64..1_000_000_000,
            drift_ppm in -1000.0..1000.0,
            elapsed in 0u64..100_000_000_000_000,
        ) {
            let clock = Clock::new(ClockFaults { offset_ns, drift_ppm, error_ns: 0 }, NOW);
            let back = clock.true_ns(clock.camera_ns(NOW + elapsed));
            prop_assert!(back.abs_diff(NOW + elapsed) <= 1);
        }

        #[test]
        fn images_come_a_period_apart(rate_hz in 1.0..240.0, phase in 0.0..1.0, offset in 0u64..1_000_000_000) {
            let schedule = Schedule::new(rate_hz, phase);
            let first = schedule.next_at_or_after(NOW + offset);
            prop_assert!(first >= NOW + offset && first < NOW + offset + schedule.period_ns());
            prop_assert_eq!(schedule.next_at_or_after(first), first);
            prop_assert_eq!(schedule.next_at_or_after(first + 1), first + schedule.period_ns());
        }
    }
}
