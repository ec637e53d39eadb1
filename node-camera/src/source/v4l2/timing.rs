//! What a buffer's time stamp and number mean.

use super::device::Buffer;

const FLAG_TIMESTAMP_MASK: u32 = 0x0000_e000;
const FLAG_TIMESTAMP_MONOTONIC: u32 = 0x0000_2000;
const FLAG_SOURCE_MASK: u32 = 0x0007_0000;
const FLAG_SOURCE_START_OF_EXPOSURE: u32 = 0x0001_0000;

/// An instant of the monotonic clock that a driver noted, ns.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Stamp {
    /// The exposure of the first row began then.
    StartOfExposure(u64),
    /// The image was all there then.
    EndOfFrame(u64),
    /// Another clock, or none.
    None,
}

impl Stamp {
    pub(super) fn from_buffer(buffer: &Buffer) -> Self {
        if buffer.flags & FLAG_TIMESTAMP_MASK != FLAG_TIMESTAMP_MONOTONIC {
            return Self::None;
        }
        let [seconds, microseconds] = buffer
            .timestamp
            .map(|number| u64::try_from(number).unwrap_or(0));
        let ns = seconds
            .saturating_mul(1_000_000_000)
            .saturating_add(microseconds.saturating_mul(1000));
        match buffer.flags & FLAG_SOURCE_MASK {
            FLAG_SOURCE_START_OF_EXPOSURE => Self::StartOfExposure(ns),
            _ => Self::EndOfFrame(ns),
        }
    }

    /// Middle of the exposure of the middle row, ns of the monotonic clock. That row is exposed half the readout after
    /// the first and before the last. `now_ns` stands for a stamp that is missing: the image was all there by then.
    pub(super) fn middle_of_exposure_ns(
        self,
        exposure_ns: u32,
        readout_ns: u32,
        now_ns: u64,
    ) -> u64 {
        let half = (u64::from(exposure_ns) + u64::from(readout_ns)) / 2;
        match self {
            Self::StartOfExposure(start_ns) => start_ns.saturating_add(half),
            Self::EndOfFrame(end_ns) => end_ns.saturating_sub(half),
            Self::None => now_ns.saturating_sub(half),
        }
    }
}

/// Counts a driver's images, those that it dropped included, over its number's 32 bits.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct SequenceCounter {
    last: Option<u32>,
    counted: u64,
}

impl SequenceCounter {
    /// The image's number from 0. A driver that never counts, or that counts backwards, gets one on.
    pub(super) fn count(&mut self, sequence: u32) -> u64 {
        let step = match self.last.map(|last| sequence.wrapping_sub(last)) {
            Some(step @ 1..=0x7fff_ffff) => step,
            Some(_) => 1,
            None => 0,
        };
        self.last = Some(sequence);
        self.counted += u64::from(step);
        self.counted
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn stamped(flags: u32) -> Stamp {
        Stamp::from_buffer(&Buffer {
            index: 0,
            flags,
            timestamp: [2, 5],
            sequence: 0,
            image: [0, 0],
        })
    }

    #[test]
    fn only_the_monotonic_clock_is_accepted() {
        assert_eq!(stamped(0), Stamp::None);
        assert_eq!(stamped(0x4000), Stamp::None);
        assert_eq!(stamped(0x2000), Stamp::EndOfFrame(2_000_005_000));
        assert_eq!(
            stamped(0x2000 | 0x10000),
            Stamp::StartOfExposure(2_000_005_000)
        );
    }

    #[test]
    fn the_middle_of_the_exposure_lies_on_the_right_side_of_the_stamp() {
        let middle = |stamp: Stamp| stamp.middle_of_exposure_ns(4_000, 6_000, 90_000);
        assert_eq!(middle(Stamp::StartOfExposure(50_000)), 55_000);
        assert_eq!(middle(Stamp::EndOfFrame(50_000)), 45_000);
        assert_eq!(middle(Stamp::None), 85_000);
    }

    fn counted(numbers: &[u32]) -> Vec<u64> {
        let mut counter = SequenceCounter::default();
        numbers
            .iter()
            .map(|number| counter.count(*number))
            .collect()
    }

    #[test]
    fn lost_images_leave_gaps() {
        assert_eq!(counted(&[7, 8, 11]), [0, 1, 4]);
        assert_eq!(counted(&[u32::MAX - 1, u32::MAX, 1]), [0, 1, 3]);
    }

    #[test]
    fn a_driver_that_does_not_count_gets_no_gaps() {
        assert_eq!(counted(&[0, 0, 0]), [0, 1, 2]);
        assert_eq!(counted(&[900, 901, 0, 1]), [0, 1, 2, 3]);
    }
}
