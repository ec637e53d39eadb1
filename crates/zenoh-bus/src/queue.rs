//! The bounded queue between a zenoh thread and the consumer: never blocks the former, drops by a given rule, and
//! counts what it drops.

use std::collections::VecDeque;
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

/// Which item a full queue drops.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum DropRule {
    /// The oldest: for streams, where the newest is the most useful.
    Oldest,
    /// The newest: for events, where the first shows the cause.
    Newest,
}

/// Counts since the queue was created.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct QueueCounts {
    /// Items that arrived, those dropped included.
    pub received: u64,
    /// Items that were dropped because the queue was full.
    pub dropped: u64,
}

/// Bounds of a queue of a stream whose items lose value with time.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct StreamBounds {
    /// Largest number of items.
    pub items: usize,
    /// Largest total size in bytes; the oldest items are dropped.
    pub bytes: usize,
    /// Longest wait. A reader is overloaded once the oldest item has waited longer, or once all that it has read in a quarter of this time had waited
    /// for more than an eighth of it. Until it has read all items, those that have waited for more than an eighth are dropped, so that what it
    /// reads is recent as long as the overload lasts.
    pub wait: Duration,
}

/// Share of the longest wait that an overloaded reader keeps.
const LEFT: u32 = 8;
/// Share of the longest wait after which a reader that stays behind is overloaded. A reader that catches up sooner has had a burst.
const BEHIND: u32 = 4;

/// A bounded queue of `T`.
#[derive(Debug)]
pub(crate) struct Queue<T> {
    bounds: StreamBounds,
    rule: DropRule,
    state: Mutex<State<T>>,
    arrival: Condvar,
}

#[derive(Debug)]
struct State<T> {
    items: VecDeque<QueuedItem<T>>,
    bytes: usize,
    counts: QueueCounts,
    /// Since when each item that was read had waited too long for an overloaded reader.
    behind_since: Option<Instant>,
    is_overloaded: bool,
}

#[derive(Debug)]
struct QueuedItem<T> {
    item: T,
    bytes: usize,
    since: Instant,
}

impl<T> State<T> {
    fn pop(&mut self) -> Option<QueuedItem<T>> {
        let first = self.items.pop_front()?;
        self.bytes -= first.bytes;
        Some(first)
    }

    fn drop_oldest(&mut self) {
        self.pop();
        self.counts.dropped += 1;
    }

    /// The oldest item at `now`, after dropping those that waited too long; the newest always stays.
    fn next(&mut self, longest: Duration, now: Instant) -> Option<T> {
        let has_waited = |one: Option<&QueuedItem<T>>, limit: Duration| {
            one.is_some_and(|one| now.saturating_duration_since(one.since) > limit)
        };
        let recent = longest / LEFT;
        self.behind_since = match has_waited(self.items.front(), recent) {
            true => self.behind_since.or(Some(now)),
            false => None,
        };
        let stays_behind = |since: Instant| now.saturating_duration_since(since) > longest / BEHIND;
        self.is_overloaded |=
            has_waited(self.items.front(), longest) || self.behind_since.is_some_and(stays_behind);
        let limit = if self.is_overloaded { recent } else { longest };
        while self.items.len() > 1 && has_waited(self.items.front(), limit) {
            self.drop_oldest();
        }
        let next = self.pop()?;
        self.is_overloaded &= !self.items.is_empty();
        Some(next.item)
    }
}

impl<T> Queue<T> {
    /// A queue of at most `capacity` items (at least one).
    pub(crate) fn new(capacity: usize, rule: DropRule) -> Self {
        let bounds = StreamBounds {
            items: capacity,
            bytes: usize::MAX,
            wait: Duration::MAX,
        };
        Self::bounded(bounds, rule)
    }

    /// A queue of a stream.
    pub(crate) fn stream(bounds: StreamBounds) -> Self {
        Self::bounded(bounds, DropRule::Oldest)
    }

    fn bounded(bounds: StreamBounds, rule: DropRule) -> Self {
        let state = State {
            items: VecDeque::new(),
            bytes: 0,
            counts: QueueCounts::default(),
            behind_since: None,
            is_overloaded: false,
        };
        Self {
            bounds,
            rule,
            state: Mutex::new(state),
            arrival: Condvar::new(),
        }
    }

    /// Adds an item, at the expense of another one where the queue is full.
    pub(crate) fn push(&self, item: T) {
        self.push_sized(item, 0, Instant::now());
    }

    /// Adds an item of this size that arrives `now`. An item larger than the byte limit is queued alone.
    pub(crate) fn push_sized(&self, item: T, bytes: usize, now: Instant) {
        let mut state = self.lock();
        state.counts.received += 1;
        let is_full = state.items.len() >= self.bounds.items.max(1);
        if is_full && self.rule == DropRule::Newest {
            state.counts.dropped += 1;
            return;
        }
        if is_full {
            state.drop_oldest();
        }
        while !state.items.is_empty() && state.bytes.saturating_add(bytes) > self.bounds.bytes {
            state.drop_oldest();
        }
        state.bytes = state.bytes.saturating_add(bytes);
        state.items.push_back(QueuedItem {
            item,
            bytes,
            since: now,
        });
        drop(state);
        self.arrival.notify_one();
    }

    /// The oldest item, if there is one.
    pub(crate) fn try_pop(&self) -> Option<T> {
        self.pop_at(Instant::now())
    }

    fn pop_at(&self, now: Instant) -> Option<T> {
        self.lock().next(self.bounds.wait, now)
    }

    /// The oldest item; waits for one for at most `timeout`.
    pub(crate) fn pop_timeout(&self, timeout: Duration) -> Option<T> {
        let deadline = Instant::now().checked_add(timeout);
        let mut state = self.lock();
        loop {
            if let Some(item) = state.next(self.bounds.wait, Instant::now()) {
                return Some(item);
            }
            let left = deadline.map_or(Duration::MAX, |end| {
                end.saturating_duration_since(Instant::now())
            });
            if left.is_zero() {
                return None;
            }
            state = self
                .arrival
                .wait_timeout(state, left)
                .unwrap_or_else(PoisonError::into_inner)
                .0;
        }
    }

    pub(crate) fn counts(&self) -> QueueCounts {
        self.lock().counts
    }

    fn lock(&self) -> MutexGuard<'_, State<T>> {
        // No caller's code runs under the lock, so a poisoned state is consistent.
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::Arc;

    fn drain(queue: &Queue<u32>) -> Vec<u32> {
        std::iter::from_fn(|| queue.try_pop()).collect()
    }

    #[test]
    fn a_full_queue_drops_the_oldest() {
        let queue = Queue::new(2, DropRule::Oldest);
        (1..=5).for_each(|item| queue.push(item));
        assert_eq!(drain(&queue), [4, 5]);
        assert_eq!(
            queue.counts(),
            QueueCounts {
                received: 5,
                dropped: 3
            }
        );
    }

    #[test]
    fn a_full_queue_refuses_the_newest() {
        let queue = Queue::new(2, DropRule::Newest);
        (1..=5).for_each(|item| queue.push(item));
        assert_eq!(drain(&queue), [1, 2]);
        assert_eq!(queue.counts().dropped, 3);
    }

    const BOUNDS: StreamBounds = StreamBounds {
        items: 100,
        bytes: 1000,
        wait: Duration::from_millis(400),
    };

    #[test]
    fn ten_times_as_many_bytes_as_fit_leave_the_newest() {
        let (queue, now) = (Queue::stream(BOUNDS), Instant::now());
        for item in 0..100 {
            queue.push_sized(item, 100, now);
            assert!(queue.lock().bytes <= 1000);
        }
        queue.push_sized(100, 5000, now);
        assert_eq!(drain(&queue), [100]);
        (101..=120).for_each(|item| queue.push_sized(item, 100, now));
        assert_eq!(drain(&queue), (111..=120).collect::<Vec<_>>());
        assert_eq!(queue.lock().bytes, 0);
        assert_eq!(queue.counts().dropped, 110);
    }

    #[test]
    fn who_reads_too_slowly_goes_on_with_the_newest() {
        let (queue, start) = (Queue::stream(BOUNDS), Instant::now());
        let at = |ms: u64| start + Duration::from_millis(ms);
        (0..40).for_each(|item: u32| queue.push_sized(item, 1, at(10 * u64::from(item))));
        assert_eq!(queue.pop_at(at(400)), Some(0));
        assert_eq!(queue.counts().dropped, 0);
        // The second one has waited for 401 ms; what came before 361 ms gives way.
        assert_eq!(queue.pop_at(at(411)), Some(37));
        assert_eq!(queue.counts().dropped, 36);
    }

    /// For five seconds an item each millisecond, of which every n-th is read: their ages when they are read, ms.
    fn ages_ms(queue: &Queue<u32>, start: Instant, n: u32) -> Vec<u32> {
        let at = |ms: u32| start + Duration::from_millis(ms.into());
        let push_and_read = |ms: u32| {
            queue.push_sized(ms, 1, at(ms));
            let is_read = ms % n == n - 1;
            is_read.then(|| ms - queue.pop_at(at(ms)).unwrap())
        };
        (0..5000).filter_map(push_and_read).collect()
    }

    #[test]
    fn in_a_lasting_overload_what_is_read_is_recent() {
        let bounds = StreamBounds {
            items: 10_000,
            bytes: 10_000,
            ..BOUNDS
        };
        // Ten times as many as are read, and a few more than are read.
        for n in [10, 2] {
            let (queue, start) = (Queue::stream(bounds), Instant::now());
            let ages_ms = ages_ms(&queue, start, n);
            let n_old = ages_ms.iter().filter(|age_ms| **age_ms > 50).count();
            assert!(n_old * 20 < ages_ms.len(), "{n_old} of {}", ages_ms.len());
            assert!(queue.lock().is_overloaded);
            drain(&queue);
            assert!(!queue.lock().is_overloaded);
        }
    }

    /// What piled up during a stall of the network is read, as it can still be of use.
    #[test]
    fn a_burst_is_no_overload() {
        let (queue, start) = (Queue::stream(BOUNDS), Instant::now());
        let at = |ms: u64| start + Duration::from_millis(ms);
        (0..60).for_each(|item: u32| queue.push_sized(item, 1, at(0)));
        let read = (0..60).map(|k| queue.pop_at(at(60 + k)));
        assert!(read.eq((0..60).map(Some)));
        assert_eq!(queue.counts().dropped, 0);
    }

    #[test]
    fn after_a_stall_the_newest_is_left() {
        let (queue, start) = (Queue::stream(BOUNDS), Instant::now());
        (0..5).for_each(|item: u32| queue.push_sized(item, 1, start));
        assert_eq!(queue.pop_at(start + Duration::from_secs(9)), Some(4));
        assert_eq!(queue.pop_at(start + Duration::from_secs(9)), None);
    }

    #[test]
    fn an_arrival_ends_the_wait() {
        let queue = Arc::new(Queue::new(1, DropRule::Oldest));
        let waiter = std::thread::spawn({
            let queue = Arc::clone(&queue);
            move || queue.pop_timeout(Duration::from_secs(60))
        });
        queue.push(7);
        assert_eq!(waiter.join().unwrap(), Some(7));
    }

    #[test]
    fn an_empty_queue_ends_the_wait_by_itself() {
        assert_eq!(
            Queue::<u32>::new(1, DropRule::Oldest).pop_timeout(Duration::from_millis(1)),
            None
        );
    }
}
