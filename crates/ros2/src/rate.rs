//! Which messages of a stream are published: each newer than the last, and at most so many a second.

/// A time so far before the last is not late: its clock was set back.
const SET_BACK_NS: u64 = 1_000_000_000;

/// A stream of messages by their capture time.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Stream {
    last_ns: u64,
    due_ns: u64,
}

/// What becomes of a message.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Passage {
    /// It is published.
    Passes,
    /// A newer one was, or one of the same time.
    Superseded,
    /// The rate is reached.
    OverRate,
}

impl Stream {
    /// Decides on a message. The rate is kept on average: a message may be early by a tenth of the period.
    pub(crate) fn passage(&mut self, capture_ns: u64, period_ns: u64) -> Passage {
        if capture_ns.saturating_add(SET_BACK_NS) < self.last_ns {
            *self = Self::default();
        }
        if capture_ns <= self.last_ns {
            return Passage::Superseded;
        }
        if capture_ns.saturating_add(period_ns / 10) < self.due_ns {
            return Passage::OverRate;
        }
        let is_in_step = capture_ns < self.due_ns.saturating_add(period_ns);
        let from = if is_in_step { self.due_ns } else { capture_ns };
        *self = Self {
            last_ns: capture_ns,
            due_ns: from.saturating_add(period_ns),
        };
        Passage::Passes
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SECOND: u64 = 1_000_000_000;

    fn passed(rate_hz: f64, image_hz: f64) -> usize {
        let mut stream = Stream::default();
        let images = 0..(image_hz * 10.0) as u32;
        let times = images.map(|k| 1000 * SECOND + (f64::from(k) / image_hz * 1e9) as u64);
        times
            .filter(|&t| stream.passage(t, (1e9 / rate_hz) as u64) == Passage::Passes)
            .count()
    }

    #[test]
    fn a_stream_keeps_to_the_rate() {
        for (rate, images, expected) in [
            (10.0, 30.0, 100),
            (20.0, 30.0, 200),
            (30.0, 30.0, 300),
            (50.0, 30.0, 300),
        ] {
            let passed = passed(rate, images);
            assert!(
                passed.abs_diff(expected) <= 1,
                "{rate} of {images}: {passed}"
            );
        }
    }

    #[test]
    fn late_and_repeated_messages_are_superseded() {
        let mut stream = Stream::default();
        let passages =
            [20 * SECOND, 20 * SECOND, 20 * SECOND - 5, 21 * SECOND].map(|t| stream.passage(t, 0));
        assert_eq!(
            passages,
            [
                Passage::Passes,
                Passage::Superseded,
                Passage::Superseded,
                Passage::Passes
            ]
        );
    }

    #[test]
    fn a_clock_that_was_set_back_stops_nothing() {
        let mut stream = Stream::default();
        assert_eq!(stream.passage(1000 * SECOND, SECOND), Passage::Passes);
        assert_eq!(stream.passage(5 * SECOND, SECOND), Passage::Passes);
        assert_eq!(stream.passage(5 * SECOND + 1, SECOND), Passage::OverRate);
    }
}
