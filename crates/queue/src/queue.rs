//! The queue.

use std::collections::{BTreeMap, HashMap};
use std::convert::Infallible;
use std::hash::Hash;
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};
use std::task::{Context, Poll, Waker};
use std::time::{Duration, Instant};

/// What gives way in a full queue.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum DropRule {
    /// The oldest item: for streams, where the newest is the most useful.
    Oldest,
    /// The newest item: for events, where the first shows the cause.
    Newest,
    /// Everything, and the queue is closed: for state, of which a reader that has fallen behind for good gets all anew.
    All,
}

/// Counts since the queue was created.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct QueueCounts {
    /// Items that arrived, those dropped included.
    pub received: u64,
    /// Items that were dropped because the queue was full.
    pub dropped: u64,
    /// Items that gave way to newer ones of their key.
    pub replaced: u64,
}

/// Bounds of a queue.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct StreamBounds {
    /// Largest number of items, at least one.
    pub items: usize,
    /// Largest total size in bytes. By [`DropRule::Oldest`] an item that is larger is queued alone.
    pub bytes: usize,
    /// Longest wait. A reader is overloaded once the oldest item has waited longer, or once all that it has read in a
    /// quarter of this time had waited for more than an eighth of it. Until it has read all items, those that have
    /// waited for more than an eighth are dropped, so that what it reads is recent as long as the overload lasts.
    pub wait: Duration,
}

impl StreamBounds {
    /// Bounds of a queue whose items do not lose value with time.
    #[must_use]
    pub const fn new(items: usize, bytes: usize) -> Self {
        let wait = Duration::MAX;
        Self { items, bytes, wait }
    }
}

/// Share of the longest wait that an overloaded reader keeps.
const LEFT: u32 = 8;
/// Share of the longest wait after which a reader that stays behind is overloaded. A reader that catches up sooner has
/// had a burst.
const BEHIND: u32 = 4;

/// A bounded queue of `T`, some of them with a key.
#[derive(Debug)]
pub struct Queue<T, K = Infallible> {
    bounds: StreamBounds,
    rule: DropRule,
    state: Mutex<QueueState<T, K>>,
    arrival: Condvar,
}

#[derive(Debug)]
struct QueueState<T, K> {
    /// By their places, which increase.
    items: BTreeMap<u64, QueuedItem<T, K>>,
    places: HashMap<K, u64>,
    next_place: u64,
    bytes: usize,
    counts: QueueCounts,
    /// Since when each item that was read had waited too long for an overloaded reader.
    behind_since: Option<Instant>,
    is_overloaded: bool,
    is_closed: bool,
    waker: Option<Waker>,
}

#[derive(Debug)]
struct QueuedItem<T, K> {
    item: T,
    key: Option<K>,
    bytes: usize,
    since: Instant,
}

impl<T, K: Eq + Hash> QueueState<T, K> {
    fn pop(&mut self) -> Option<QueuedItem<T, K>> {
        let (_, first) = self.items.pop_first()?;
        self.bytes -= first.bytes;
        if let Some(key) = &first.key {
            self.places.remove(key);
        }
        Some(first)
    }

    fn first(&self) -> Option<&QueuedItem<T, K>> {
        Some(self.items.first_key_value()?.1)
    }

    fn remove(&mut self, key: &K) -> Option<u64> {
        let place = self.places.remove(key)?;
        let before = self.items.remove(&place)?;
        self.bytes -= before.bytes;
        Some(place)
    }

    fn drop_oldest(&mut self) {
        self.pop();
        self.counts.dropped += 1;
    }

    fn insert(&mut self, place: u64, item: QueuedItem<T, K>) {
        self.bytes += item.bytes;
        self.items.insert(place, item);
    }

    /// Whether an item of this size has a place, after others gave way.
    fn make_room(&mut self, bounds: &StreamBounds, rule: DropRule, bytes: usize) -> bool {
        let is_full = |state: &Self| {
            let items = state.items.len() >= bounds.items.max(1);
            items || state.bytes.saturating_add(bytes) > bounds.bytes
        };
        while is_full(self) {
            match rule {
                DropRule::Oldest if self.items.is_empty() => break,
                DropRule::Oldest => self.drop_oldest(),
                DropRule::Newest => {
                    self.counts.dropped += 1;
                    return false;
                }
                DropRule::All => {
                    self.counts.dropped += self.items.len() as u64 + 1;
                    self.items.clear();
                    self.places.clear();
                    self.bytes = 0;
                    self.is_closed = true;
                    return false;
                }
            }
        }
        true
    }

    /// The oldest item at `now`, after dropping those that waited too long; the newest always stays.
    fn next(&mut self, longest: Duration, now: Instant) -> Option<T> {
        let has_waited = |one: Option<&QueuedItem<T, K>>, limit: Duration| {
            one.is_some_and(|one| now.saturating_duration_since(one.since) > limit)
        };
        let recent = longest / LEFT;
        self.behind_since = match has_waited(self.first(), recent) {
            true => self.behind_since.or(Some(now)),
            false => None,
        };
        let stays_behind = |since: Instant| now.saturating_duration_since(since) > longest / BEHIND;
        self.is_overloaded |=
            has_waited(self.first(), longest) || self.behind_since.is_some_and(stays_behind);
        let limit = if self.is_overloaded { recent } else { longest };
        while self.items.len() > 1 && has_waited(self.first(), limit) {
            self.drop_oldest();
        }
        let next = self.pop()?;
        self.is_overloaded &= !self.items.is_empty();
        Some(next.item)
    }
}

impl<T, K: Eq + Hash + Clone> Queue<T, K> {
    /// An empty queue with these bounds and this drop rule.
    #[must_use]
    pub fn new(bounds: StreamBounds, rule: DropRule) -> Self {
        let state = QueueState {
            items: BTreeMap::new(),
            places: HashMap::new(),
            next_place: 0,
            bytes: 0,
            counts: QueueCounts::default(),
            behind_since: None,
            is_overloaded: false,
            is_closed: false,
            waker: None,
        };
        Self {
            bounds,
            rule,
            state: Mutex::new(state),
            arrival: Condvar::new(),
        }
    }

    /// Adds an item of this many bytes that arrives now, at the expense of others where the queue is full. Returns how
    /// many gave way, this one included.
    pub fn push(&self, item: T, bytes: usize) -> u64 {
        self.push_at(item, None, bytes, Instant::now())
    }

    /// As [`Self::push`], in the place of the unread item of the same key.
    pub fn put(&self, key: K, item: T, bytes: usize) -> u64 {
        self.push_at(item, Some(key), bytes, Instant::now())
    }

    fn push_at(&self, item: T, key: Option<K>, bytes: usize, now: Instant) -> u64 {
        let mut state = self.lock();
        let before = state.counts.dropped;
        state.counts.received += 1;
        let replaced = key.as_ref().and_then(|key| state.remove(key));
        state.counts.replaced += u64::from(replaced.is_some());
        if state.is_closed {
            state.counts.dropped += 1;
        }
        if state.is_closed || !state.make_room(&self.bounds, self.rule, bytes) {
            return state.counts.dropped - before;
        }
        let place = replaced.unwrap_or(state.next_place);
        state.next_place += 1;
        if let Some(key) = &key {
            state.places.insert(key.clone(), place);
        }
        let since = now;
        state.insert(
            place,
            QueuedItem {
                item,
                key,
                bytes,
                since,
            },
        );
        let (dropped, waker) = (state.counts.dropped - before, state.waker.take());
        drop(state);
        self.arrival.notify_one();
        if let Some(waker) = waker {
            waker.wake();
        }
        dropped
    }

    /// Takes an unread item back.
    pub fn withdraw(&self, key: &K) {
        self.lock().remove(key);
    }

    /// The oldest item, if there is one.
    pub fn try_pop(&self) -> Option<T> {
        self.pop_at(Instant::now())
    }

    fn pop_at(&self, now: Instant) -> Option<T> {
        self.lock().next(self.bounds.wait, now)
    }

    /// The oldest item; waits for one for at most `timeout`.
    pub fn pop_timeout(&self, timeout: Duration) -> Option<T> {
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

    /// Ready as soon as something waits, or the queue is closed. One task is woken, the last that asked.
    pub fn poll_ready(&self, context: &Context<'_>) -> Poll<()> {
        let mut state = self.lock();
        if state.is_closed || !state.items.is_empty() {
            return Poll::Ready(());
        }
        state.waker = Some(context.waker().clone());
        Poll::Pending
    }

    /// How many items wait.
    pub fn len(&self) -> usize {
        self.lock().items.len()
    }

    /// Whether no item waits.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Whether too much waited, by [`DropRule::All`]: nothing is taken in any more.
    pub fn is_closed(&self) -> bool {
        self.lock().is_closed
    }

    /// What became of the items.
    pub fn counts(&self) -> QueueCounts {
        self.lock().counts
    }

    fn lock(&self) -> MutexGuard<'_, QueueState<T, K>> {
        // No caller's code runs under the lock, so a poisoned state is consistent.
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::Arc;

    fn push(queue: &Queue<u32>, item: u32, bytes: usize, now: Instant) {
        queue.push_at(item, None, bytes, now);
    }

    fn queue(items: usize, rule: DropRule) -> Queue<u32> {
        Queue::new(StreamBounds::new(items, usize::MAX), rule)
    }

    fn drain(queue: &Queue<u32>) -> Vec<u32> {
        std::iter::from_fn(|| queue.try_pop()).collect()
    }

    #[test]
    fn a_full_queue_drops_the_oldest() {
        let queue = queue(2, DropRule::Oldest);
        (1..=5).for_each(|item| push(&queue, item, 0, Instant::now()));
        assert_eq!(drain(&queue), [4, 5]);
        assert_eq!(
            queue.counts(),
            QueueCounts {
                received: 5,
                dropped: 3,
                replaced: 0
            }
        );
    }

    #[test]
    fn a_full_queue_refuses_the_newest() {
        let queue = queue(2, DropRule::Newest);
        (1..=5).for_each(|item| push(&queue, item, 0, Instant::now()));
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
        let (queue, now) = (Queue::new(BOUNDS, DropRule::Oldest), Instant::now());
        for item in 0..100 {
            push(&queue, item, 100, now);
            assert!(queue.lock().bytes <= 1000);
        }
        queue.push_at(100, None, 5000, now);
        assert_eq!(drain(&queue), [100]);
        (101..=120).for_each(|item| push(&queue, item, 100, now));
        assert_eq!(drain(&queue), (111..=120).collect::<Vec<_>>());
        assert_eq!(queue.lock().bytes, 0);
        assert_eq!(queue.counts().dropped, 110);
    }

    #[test]
    fn who_reads_too_slowly_goes_on_with_the_newest() {
        let (queue, start) = (Queue::new(BOUNDS, DropRule::Oldest), Instant::now());
        let at = |ms: u64| start + Duration::from_millis(ms);
        (0..40).for_each(|item: u32| push(&queue, item, 1, at(10 * u64::from(item))));
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
            queue.push_at(ms, None, 1, at(ms));
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
            let (queue, start) = (Queue::new(bounds, DropRule::Oldest), Instant::now());
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
        let (queue, start) = (Queue::new(BOUNDS, DropRule::Oldest), Instant::now());
        let at = |ms: u64| start + Duration::from_millis(ms);
        (0..60).for_each(|item: u32| push(&queue, item, 1, at(0)));
        let read = (0..60).map(|k| queue.pop_at(at(60 + k)));
        assert!(read.eq((0..60).map(Some)));
        assert_eq!(queue.counts().dropped, 0);
    }

    #[test]
    fn after_a_stall_the_newest_is_left() {
        let (queue, start) = (Queue::new(BOUNDS, DropRule::Oldest), Instant::now());
        (0..5).for_each(|item: u32| push(&queue, item, 1, start));
        assert_eq!(queue.pop_at(start + Duration::from_secs(9)), Some(4));
        assert_eq!(queue.pop_at(start + Duration::from_secs(9)), None);
    }

    #[test]
    fn an_arrival_ends_the_wait() {
        let queue = Arc::new(queue(1, DropRule::Oldest));
        let waiter = std::thread::spawn({
            let queue = Arc::clone(&queue);
            move || queue.pop_timeout(Duration::from_secs(60))
        });
        queue.push(7, 0);
        assert_eq!(waiter.join().unwrap(), Some(7));
    }

    #[test]
    fn an_empty_queue_ends_the_wait_by_itself() {
        assert_eq!(
            queue(1, DropRule::Oldest).pop_timeout(Duration::from_millis(1)),
            None
        );
    }

    #[test]
    fn the_newest_of_a_key_wins_and_keeps_its_place() {
        let queue = Queue::new(StreamBounds::new(3, 100), DropRule::All);
        for (key, item) in [("a", 1), ("b", 2), ("a", 3), ("c", 4)] {
            queue.put(key, item, 30);
        }
        queue.withdraw(&"b");
        assert_eq!((queue.len(), queue.counts().replaced), (2, 1));
        assert_eq!([queue.try_pop(), queue.try_pop()], [Some(3), Some(4)]);
        assert_eq!(queue.lock().bytes, 0);
        assert!(queue.is_empty() && queue.lock().places.is_empty());
    }

    #[test]
    fn a_reader_that_has_fallen_behind_for_good_is_given_up() {
        for (items, bytes) in [(8, 1000), (1000, 8)] {
            let queue = Queue::new(StreamBounds::new(items, bytes), DropRule::All);
            let dropped = (0..20).map(|key| queue.put(key, key, 1)).sum::<u64>();
            assert!(queue.is_closed());
            assert_eq!((queue.try_pop(), dropped), (None, 20));
        }
    }

    #[test]
    fn a_full_queue_refuses_the_newest_by_its_bytes_too() {
        let queue = Queue::<u32>::new(StreamBounds::new(100, 10), DropRule::Newest);
        assert_eq!([1, 2, 3].map(|item| queue.push(item, 4)), [0, 0, 1]);
        assert_eq!(queue.try_pop(), Some(1));
        assert_eq!(queue.push(4, 4), 0);
        assert_eq!(drain(&queue), [2, 4]);
    }

    #[test]
    fn an_arrival_wakes_the_task() {
        struct Flag(std::sync::atomic::AtomicBool);
        impl std::task::Wake for Flag {
            fn wake(self: Arc<Self>) {
                self.0.store(true, std::sync::atomic::Ordering::Relaxed);
            }
        }
        let (queue, flag) = (queue(1, DropRule::Oldest), Arc::new(Flag(false.into())));
        let waker = Waker::from(Arc::clone(&flag));
        let context = Context::from_waker(&waker);
        assert!(queue.poll_ready(&context).is_pending());
        queue.push(7, 0);
        assert!(flag.0.load(std::sync::atomic::Ordering::Relaxed));
        assert!(queue.poll_ready(&context).is_ready());
    }
}
