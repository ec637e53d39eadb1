//! Rate limit of log statements, so that events of every image do not fill the disk.

use std::collections::HashMap;
use std::hash::Hash;
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

/// Lines of one log statement that are printed at once.
const BURST: u32 = 10;
/// Interval of further lines.
const PERIOD: Duration = Duration::from_secs(30);

/// A token bucket for each log statement, of which a program has a fixed number.
#[derive(Debug)]
pub(crate) struct RateLimit<K> {
    places: Mutex<HashMap<K, Bucket>>,
}

#[derive(Debug)]
struct Bucket {
    tokens: u32,
    refilled: Instant,
    left_out: u64,
}

impl<K: Eq + Hash> RateLimit<K> {
    pub(crate) fn new() -> Self {
        Self {
            places: Mutex::default(),
        }
    }

    /// Whether `place` may log at `now`: the number of its lines omitted before this one.
    pub(crate) fn admit(&self, place: K, now: Instant) -> Option<u64> {
        let mut places = self.places.lock().unwrap_or_else(PoisonError::into_inner);
        let bucket = places.entry(place).or_insert(Bucket {
            tokens: BURST,
            refilled: now,
            left_out: 0,
        });
        bucket.refill(now);
        let Some(tokens) = bucket.tokens.checked_sub(1) else {
            bucket.left_out += 1;
            return None;
        };
        bucket.tokens = tokens;
        Some(std::mem::take(&mut bucket.left_out))
    }
}

impl Bucket {
    fn refill(&mut self, now: Instant) {
        let periods = now.saturating_duration_since(self.refilled).as_secs() / PERIOD.as_secs();
        let periods = u32::try_from(periods).unwrap_or(u32::MAX);
        self.tokens = self.tokens.saturating_add(periods).min(BURST);
        if self.tokens == BURST {
            self.refilled = now;
        } else {
            self.refilled += PERIOD * periods;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_flood_leaves_a_burst_then_a_line_a_period_with_the_count_of_the_others() {
        let limit = RateLimit::new();
        let start = Instant::now();
        let admitted: Vec<u64> = (0..3000)
            .filter_map(|image| limit.admit("image", start + Duration::from_millis(33) * image))
            .collect();
        // 99 seconds: three intervals after the burst.
        assert_eq!(admitted.len(), BURST as usize + 3);
        assert!(
            admitted[..BURST as usize]
                .iter()
                .all(|left_out| *left_out == 0)
        );
        assert!(
            admitted[BURST as usize..]
                .iter()
                .all(|left_out| (890..=910).contains(left_out))
        );
        assert_eq!(limit.admit("other", start), Some(0));
    }

    #[test]
    fn quiet_fills_the_bucket_again() {
        let limit = RateLimit::new();
        let start = Instant::now();
        let burst = |now| (0..100).filter(|_| limit.admit((), now).is_some()).count();
        assert_eq!(burst(start), BURST as usize);
        assert_eq!(burst(start + PERIOD * 1000), BURST as usize);
        assert_eq!(burst(start), 0, "a clock may not go back");
    }
}
