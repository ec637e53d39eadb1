//! The bounded queue between a zenoh thread and the thread that works: never blocks the former, drops by a stated rule,
//! counts what it drops.

use std::collections::VecDeque;
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

/// Which item gives way when a queue is full.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum DropRule {
    /// The oldest: for streams, where the newest says most.
    Oldest,
    /// The arriving one: for events, where the first tells the cause.
    Newest,
}

/// What a queue has seen since it was made.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct QueueCounts {
    /// Items that arrived, those dropped included.
    pub received: u64,
    /// Items that were dropped because the queue was full.
    pub dropped: u64,
}

/// A bounded queue of `T`.
#[derive(Debug)]
pub(crate) struct Queue<T> {
    capacity: usize,
    rule: DropRule,
    state: Mutex<State<T>>,
    arrival: Condvar,
}

#[derive(Debug)]
struct State<T> {
    items: VecDeque<T>,
    counts: QueueCounts,
}

impl<T> Queue<T> {
    /// A queue of at most `capacity` items (at least one).
    pub(crate) fn new(capacity: usize, rule: DropRule) -> Self {
        let state = State {
            items: VecDeque::new(),
            counts: QueueCounts::default(),
        };
        Self {
            capacity: capacity.max(1),
            rule,
            state: Mutex::new(state),
            arrival: Condvar::new(),
        }
    }

    /// Takes an item in, at the cost of another one where the queue is full.
    pub(crate) fn push(&self, item: T) {
        let mut state = self.lock();
        state.counts.received += 1;
        if state.items.len() == self.capacity {
            state.counts.dropped += 1;
            if self.rule == DropRule::Newest {
                return;
            }
            state.items.pop_front();
        }
        state.items.push_back(item);
        drop(state);
        self.arrival.notify_one();
    }

    /// The oldest item, if there is one.
    pub(crate) fn try_pop(&self) -> Option<T> {
        self.lock().items.pop_front()
    }

    /// The oldest item, waiting for one for at most `timeout`.
    pub(crate) fn pop_timeout(&self, timeout: Duration) -> Option<T> {
        let deadline = Instant::now().checked_add(timeout);
        let mut state = self.lock();
        loop {
            if let Some(item) = state.items.pop_front() {
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
        // No code of a caller runs under the lock, so a poisoned state is a whole one.
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
