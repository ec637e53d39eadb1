//! Consensus of clocks: those that differ from most are wrong.

use std::cmp::Reverse;

use sextant_site_report::ClockOffset;

/// Largest difference of clocks that agree, s: where both are verified, and otherwise, where a filter estimates the
/// rest.
const TOGETHER_S: (f64, f64) = (0.003, 0.03);

/// Offset of a camera's clock against that of a common other camera.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct ClockReading {
    pub camera_index: usize,
    pub off: ClockOffset,
    /// Whether the camera reports a small clock error.
    pub verified: bool,
}

impl ClockReading {
    fn is_together_with(&self, other: &Self) -> bool {
        let within_s = if self.verified && other.verified {
            TOGETHER_S.0
        } else {
            TOGETHER_S.1
        };
        (self.off.offset_s - other.off.offset_s).abs() <= within_s
    }
}

/// The clocks that are wrong, against one that most agree with: of equals the first verified one whose images arrive
/// when most others, and this host, expect them.
pub(crate) fn wrong(
    readings: &[ClockReading],
    is_timely: impl Fn(usize) -> bool,
) -> Vec<(usize, ClockOffset)> {
    let company = |one: &ClockReading| {
        let together = readings.iter().filter(|other| one.is_together_with(other));
        together.count()
    };
    let rank = |one: &&ClockReading| {
        let camera = one.camera_index;
        (
            company(one),
            is_timely(camera),
            one.verified,
            Reverse(camera),
        )
    };
    let Some(right) = readings.iter().max_by_key(rank) else {
        return Vec::new();
    };
    let wrong = readings.iter().filter(|one| !one.is_together_with(right));
    let against_right = |one: &ClockReading| ClockOffset {
        offset_s: one.off.offset_s - right.off.offset_s,
        sigma_s: one.off.sigma_s.hypot(right.off.sigma_s),
    };
    wrong
        .map(|one| (one.camera_index, against_right(one)))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn wrong_of(offsets_s: &[f64], verified: bool) -> Vec<(usize, f64)> {
        let reading = |(camera_index, offset_s): (usize, &f64)| ClockReading {
            camera_index,
            off: ClockOffset {
                offset_s: *offset_s,
                sigma_s: 0.001,
            },
            verified: verified || camera_index == 0,
        };
        let readings: Vec<ClockReading> = offsets_s.iter().enumerate().map(reading).collect();
        let wrong = wrong(&readings, |_| true).into_iter();
        wrong.map(|(camera, off)| (camera, off.offset_s)).collect()
    }

    #[test]
    fn the_odd_one_is_wrong_whoever_is_compared_with() {
        assert_eq!(wrong_of(&[0.0, 0.4, 0.001], true), [(1, 0.4)]);
        assert_eq!(wrong_of(&[0.0, 0.5, 0.5], true), [(0, -0.5)]);
    }

    #[test]
    fn of_two_the_first_is_right() {
        assert_eq!(wrong_of(&[0.0, -2.0], true), [(1, -2.0)]);
        assert_eq!(wrong_of(&[0.0, -2.0], false), [(1, -2.0)]);
    }

    #[test]
    fn what_a_filter_sees_to_is_not_wrong_unless_somebody_vouches_for_it() {
        assert_eq!(wrong_of(&[0.0, 0.01, 0.0], false), []);
        assert_eq!(wrong_of(&[0.0, 0.01, 0.0], true), [(1, 0.01)]);
    }
}
