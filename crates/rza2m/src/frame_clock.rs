//! Arrivals of images that are seen by polling: when each arrived, how many there were since, and how long a frame
//! takes.
//!
//! VIN tells which of three buffers it filled last and counts nothing, so that a change by one may stand for one image
//! or for four. The frame period, measured here, decides. It is not computed from the sensor's clock tree either: the
//! documents leave its input clock open.

/// Buffers that are filled in turn.
const BUFFERS: u64 = 3;
/// Intervals of which the median is the first estimate of the period.
const MEASURED: usize = 15;
/// The baseline of the period begins anew after so many images: a sensor's clock drifts with its temperature.
const BASELINE: u64 = 1024;

/// Arrivals of images and the period between them. Times are ns of a monotonic clock.
#[derive(Debug, Clone, Default)]
pub struct FrameClock {
    period_ns: Option<u64>,
    /// The image from which the period is measured.
    base: Option<Arrival>,
    /// The newest image and its buffer.
    newest: Option<(usize, Arrival)>,
    intervals: Vec<u64>,
}

/// An image that arrived.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Arrival {
    /// Its number, from 0; a gap are images that passed unseen.
    pub number: u64,
    /// The middle of the time in which it must have arrived, ns.
    pub at_ns: u64,
    /// Half of that time, ns.
    pub tolerance_ns: u64,
}

impl FrameClock {
    /// A clock whose period is known roughly: by a tenth.
    pub fn with_period(period_ns: u64) -> Self {
        Self {
            period_ns: Some(period_ns.max(1)),
            ..Self::default()
        }
    }

    /// Time from one image to the next, ns; unknown until some have arrived.
    pub fn period_ns(&self) -> Option<u64> {
        self.period_ns
    }

    /// Notes that `buffer` was the newest at `now_ns` and was not at `before_ns`; none if it is the one of the last
    /// arrival.
    pub fn arrive(&mut self, buffer: usize, before_ns: u64, now_ns: u64) -> Option<Arrival> {
        // However long nobody looked, the newest image is no older than a period.
        let oldest_ns = now_ns.saturating_sub(self.period_ns.unwrap_or(now_ns));
        let before_ns = before_ns.clamp(oldest_ns, now_ns);
        let tolerance_ns = (now_ns - before_ns) / 2;
        let mut arrival = Arrival {
            number: 0,
            at_ns: now_ns - tolerance_ns,
            tolerance_ns,
        };
        if let Some((last_buffer, last)) = self.newest {
            if last_buffer == buffer {
                return None;
            }
            let turn = (BUFFERS + buffer as u64 - last_buffer as u64) % BUFFERS;
            let images = self.images_within(arrival.at_ns.saturating_sub(last.at_ns), turn);
            arrival.number = last.number + images;
            // After a pause the images before tell more than the poll does.
            let period_ns = self.period_ns.unwrap_or(0);
            let predicted_ns = last.at_ns.saturating_add(images.saturating_mul(period_ns));
            if last.tolerance_ns < tolerance_ns && (before_ns..=now_ns).contains(&predicted_ns) {
                (arrival.at_ns, arrival.tolerance_ns) = (predicted_ns, last.tolerance_ns);
            }
        }
        self.measure(&arrival);
        self.newest = Some((buffer, arrival));
        Some(arrival)
    }

    /// The number of images closest to what arrives within a time, of those that leave VIN at this turn.
    fn images_within(&self, elapsed_ns: u64, turn: u64) -> u64 {
        let Some(period_ns) = self.period_ns else {
            return turn;
        };
        let images = elapsed_ns / period_ns.max(1)
            + u64::from(elapsed_ns % period_ns.max(1) > period_ns / 2);
        let rounds = (images.saturating_sub(turn) + BUFFERS / 2) / BUFFERS;
        turn + rounds * BUFFERS
    }

    fn measure(&mut self, arrival: &Arrival) {
        if self.period_ns.is_none() {
            if let Some((_, last)) = self.newest {
                self.intervals
                    .push(arrival.at_ns.saturating_sub(last.at_ns));
            }
            if self.intervals.len() == MEASURED {
                self.intervals.sort_unstable();
                self.period_ns = Some(self.intervals[MEASURED / 2].max(1));
            }
            return;
        }
        let base = *self.base.get_or_insert(*arrival);
        let images = arrival.number.saturating_sub(base.number);
        if images >= MEASURED as u64 {
            self.period_ns = Some((arrival.at_ns.saturating_sub(base.at_ns) / images).max(1));
        }
        if images >= BASELINE {
            self.base = Some(*arrival);
        }
    }

    /// Whether the image of `buffer` that arrived at `at_ns` is still whole: VIN has not begun to fill that buffer
    /// again.
    pub(crate) fn is_whole(&self, buffer: usize, at_ns: u64, newest: usize, now_ns: u64) -> bool {
        let turn = (BUFFERS + newest as u64 - buffer as u64) % BUFFERS;
        let period_ns = self.period_ns.unwrap_or(0);
        // After a whole round the turn is the same again, which the time tells.
        turn < 2 && now_ns.saturating_sub(at_ns) < period_ns * 2
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const MS: u64 = 1_000_000;

    /// Polls a camera of a period whose images `seen` says are looked for; the rest falls into a pause of the poller.
    fn watch(clock: &mut FrameClock, period_ns: u64, images: &[u64]) -> Vec<u64> {
        let arrivals = images.iter().map(|&image| {
            let at_ns = 1000 * MS + image * period_ns;
            let poll_ns = at_ns.next_multiple_of(MS);
            clock.arrive((image % 3) as usize, poll_ns - MS, poll_ns)
        });
        arrivals.flatten().map(|arrival| arrival.number).collect()
    }

    fn settled(period_ns: u64) -> FrameClock {
        let mut clock = FrameClock::default();
        watch(&mut clock, period_ns, &(0..60).collect::<Vec<_>>());
        clock
    }

    #[test]
    fn the_period_is_measured() {
        for period_ns in [13_370_000, 26_700_000, 33_333_333] {
            let measured = settled(period_ns).period_ns().unwrap();
            assert!(
                measured.abs_diff(period_ns) < period_ns / 500,
                "{measured} {period_ns}"
            );
        }
    }

    #[test]
    fn one_pause_does_not_spoil_the_first_measurement() {
        let mut clock = FrameClock::default();
        let images: Vec<u64> = (0..5).chain(9..80).collect();
        watch(&mut clock, 33_333_333, &images);
        assert!(clock.period_ns().unwrap().abs_diff(33_333_333) < 100_000);
    }

    proptest! {
        #[test]
        fn images_that_pass_unseen_are_counted(
            pauses in prop::collection::vec(0_u64..9, 1..60),
            period_ns in 12_000_000_u64..50_000_000,
        ) {
            let mut clock = settled(period_ns);
            // A pause of exactly three, six... images leaves VIN as it was: nothing is seen until the next one.
            let pauses = pauses.into_iter().filter(|pause| (pause + 1) % 3 != 0);
            let images: Vec<u64> = pauses.scan(59, |image, pause| { *image += 1 + pause; Some(*image) }).collect();
            let numbers = watch(&mut clock, period_ns, &images);
            prop_assert_eq!(numbers, images);
        }

        #[test]
        fn no_arrival_overflows(buffers in prop::collection::vec((0_usize..3, any::<u64>(), any::<u64>()), 0..40)) {
            let mut clock = FrameClock::default();
            for (buffer, before, now) in buffers {
                clock.arrive(buffer, before, now);
            }
        }
    }

    #[test]
    fn an_image_is_whole_until_its_buffer_comes_round() {
        let clock = FrameClock::with_period(30 * MS);
        assert!(clock.is_whole(0, 0, 0, MS) && clock.is_whole(0, 0, 1, 40 * MS));
        assert!(!clock.is_whole(0, 0, 2, 59 * MS));
        assert!(!clock.is_whole(0, 0, 0, 90 * MS));
        assert!(!clock.is_whole(2, 0, 0, 65 * MS));
    }
}
