//! Images that waited for us: those that are there at once after a standstill of this process have no known time of
//! arrival.
//!
//! A source that stamps on arrival looks for data often. When longer than usual passed between two looks (the process
//! was stopped, or had no processor), images may have piled up in the pipe, in the driver and in the program itself.
//! They are dropped until one had to be waited for again, for half the usual distance of images: then nothing is left
//! of the pile.

use std::time::{Duration, Instant};

/// Longest single look for data, so that a standstill within one is noticed.
pub(super) const LOOK: Duration = Duration::from_millis(25);
/// Time between the ends of two looks from which on images may have piled up.
const STANDSTILL: Duration = Duration::from_millis(100);
/// Waiting that ends a pile where the distance of images is not known.
const SHORT_WAIT: Duration = Duration::from_millis(5);
/// After so long a source that never has to be waited for counts as current again: it is slower than its images come.
const PATIENCE: Duration = Duration::from_secs(3);
/// Weight of the newest distance of two images.
const WEIGHT: f64 = 0.2;

/// What is known of a source's pile.
#[derive(Debug, Default)]
pub(super) struct Backlog {
    looked_at: Option<Instant>,
    /// Between the ends of the last two looks.
    gap: Duration,
    /// Time between two looks of a source that counts as current again: its loop is as slow as that.
    usual_gap: Duration,
    /// A standstill ended then, and its pile has not.
    since: Option<Instant>,
    /// Waiting since the last image.
    waited: Duration,
    last_image: Option<Instant>,
    /// Usual time from an image to the next, s.
    distance_s: Option<f64>,
}

impl Backlog {
    /// A look for data from `begun` to `ended`.
    pub(super) fn looked(&mut self, begun: Instant, ended: Instant) {
        let before = self.looked_at.replace(ended).unwrap_or(begun);
        self.gap = ended.duration_since(before);
        if self.gap > STANDSTILL.max(3 * self.usual_gap) {
            // A pile that goes on keeps its beginning, so that a source slower than its images counts as current again.
            self.since.get_or_insert(ended);
            self.waited = Duration::ZERO;
        } else {
            self.waited += ended.duration_since(begun);
        }
    }

    /// Waiting for the rest of an image says nothing.
    pub(super) fn image_ended(&mut self) {
        self.waited = Duration::ZERO;
    }

    /// Whether the first bytes of an image, which are there now, came now.
    pub(super) fn is_time_known(&mut self, now: Instant) -> bool {
        let waited = std::mem::take(&mut self.waited);
        let last = self.last_image.replace(now);
        let Some(since) = self.since else {
            if let Some(last) = last {
                let distance_s = now.duration_since(last).as_secs_f64();
                let usual_s = self.distance_s.unwrap_or(distance_s);
                self.distance_s = Some(usual_s + WEIGHT * (distance_s - usual_s));
            }
            return true;
        };
        let half = self.distance_s.map(|s| Duration::from_secs_f64(s / 2.0));
        let is_over = waited >= half.unwrap_or(SHORT_WAIT);
        let is_patient = now.duration_since(since) > PATIENCE;
        if is_over || is_patient {
            self.since = None;
        }
        if is_patient && !is_over {
            self.usual_gap = self.gap;
        }
        is_over || self.since.is_none()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const PERIOD: Duration = Duration::from_millis(33);

    /// Images as they come, and whether their times are known: each waited for so long.
    struct Source {
        backlog: Backlog,
        now: Instant,
    }

    impl Source {
        fn new() -> Self {
            let (backlog, now) = (Backlog::default(), Instant::now());
            Self { backlog, now }
        }

        fn image(&mut self, waited: Duration) -> bool {
            let mut left = waited;
            loop {
                let look = left.min(LOOK);
                let begun = self.now;
                self.now += look;
                self.backlog.looked(begun, self.now);
                left -= look;
                if left.is_zero() {
                    break;
                }
            }
            let is_known = self.backlog.is_time_known(self.now);
            self.backlog.image_ended();
            is_known
        }
    }

    #[test]
    fn images_that_are_waited_for_have_known_times() {
        let mut source = Source::new();
        assert!((0..100).all(|_| source.image(PERIOD)));
        // A busy machine: some come at once.
        assert!((0..100).all(|k| source.image(if k % 3 == 0 { Duration::ZERO } else { PERIOD })));
    }

    #[test]
    fn what_piled_up_during_a_standstill_is_dropped() {
        let mut source = Source::new();
        (0..30).for_each(|_| assert!(source.image(PERIOD)));
        source.now += Duration::from_secs(5);
        // The program hands over what it kept, each after a moment of its own.
        assert!((0..9).all(|_| !source.image(Duration::from_millis(3))));
        assert!(source.image(PERIOD));
        assert!(source.image(Duration::ZERO));
    }

    #[test]
    fn a_standstill_within_a_look_counts_too() {
        let mut source = Source::new();
        (0..30).for_each(|_| assert!(source.image(PERIOD)));
        let begun = source.now;
        source.now += Duration::from_secs(5);
        source.backlog.looked(begun, source.now);
        assert!(!source.backlog.is_time_known(source.now));
    }

    #[test]
    fn a_loop_slower_than_its_images_counts_as_current() {
        let mut source = Source::new();
        (0..30).for_each(|_| assert!(source.image(PERIOD)));
        let known = (0..200).map(|_| {
            source.now += Duration::from_millis(150);
            source.image(Duration::ZERO)
        });
        let known: Vec<bool> = known.collect();
        assert!(!known[0]);
        assert!(known[30..].iter().all(|is_known| *is_known));
    }

    #[test]
    fn a_source_without_any_wait_comes_back() {
        let mut source = Source::new();
        (0..30).for_each(|_| assert!(source.image(PERIOD)));
        source.now += Duration::from_secs(1);
        let mut dropped = 0;
        while !source.image(Duration::ZERO) {
            source.now += Duration::from_millis(10);
            dropped += 1;
        }
        assert!((200..=301).contains(&dropped), "{dropped}");
        assert!(source.image(Duration::ZERO));
    }
}
