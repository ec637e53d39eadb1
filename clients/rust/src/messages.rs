//! Messages as they come: an iterator that blocks, or a stream; behind both one bounded queue that drops the oldest and counts.

use sextant_zenoh_bus::{Bus, CallbackSubscription};
use std::collections::VecDeque;
use std::pin::Pin;
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::task::{Context, Poll, Waker};
use std::time::{Duration, Instant};

/// Messages that wait for a slow reader.
const CAPACITY: usize = 256;

/// What became of the messages of a subscription.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Counts {
    /// Messages that arrived.
    pub received: u64,
    /// Those that gave way to newer ones because the reader was slow; 256 wait at most.
    pub dropped: u64,
    /// Those that break their contract or have another version of it.
    pub refused: u64,
}

/// A subscription as an iterator: `next` waits without a time limit, also while the router is unreachable. Dropping it ends
/// the subscription.
#[derive(Debug)]
pub struct Messages<T> {
    queue: Arc<Queue<T>>,
    _subscription: CallbackSubscription,
    /// Keeps the session open.
    _bus: Arc<Bus>,
}

/// The same as a stream, for asynchronous programs. It never ends.
#[derive(Debug)]
pub struct MessageStream<T>(Messages<T>);

/// A bounded queue with a waker.
#[derive(Debug)]
pub(crate) struct Queue<T> {
    state: Mutex<State<T>>,
    arrival: Condvar,
}

#[derive(Debug)]
struct State<T> {
    items: VecDeque<T>,
    counts: Counts,
    waker: Option<Waker>,
}

impl<T> Queue<T> {
    pub(crate) fn new() -> Arc<Self> {
        let state = State {
            items: VecDeque::new(),
            counts: Counts::default(),
            waker: None,
        };
        Arc::new(Self {
            state: Mutex::new(state),
            arrival: Condvar::new(),
        })
    }

    /// Takes in what a payload held; none where it held no message.
    pub(crate) fn push(&self, item: Option<T>) {
        let mut state = self.lock();
        state.counts.received += 1;
        let Some(item) = item else {
            state.counts.refused += 1;
            return;
        };
        if state.items.len() == CAPACITY {
            state.items.pop_front();
            state.counts.dropped += 1;
        }
        state.items.push_back(item);
        let waker = state.waker.take();
        drop(state);
        self.arrival.notify_one();
        if let Some(waker) = waker {
            waker.wake();
        }
    }

    fn pop_until(&self, deadline: Option<Instant>) -> Option<T> {
        let mut state = self.lock();
        loop {
            if let Some(item) = state.items.pop_front() {
                return Some(item);
            }
            state = match deadline.map(|end| end.saturating_duration_since(Instant::now())) {
                None => self
                    .arrival
                    .wait(state)
                    .unwrap_or_else(PoisonError::into_inner),
                Some(Duration::ZERO) => return None,
                Some(left) => {
                    let waited = self.arrival.wait_timeout(state, left);
                    waited.unwrap_or_else(PoisonError::into_inner).0
                }
            };
        }
    }

    fn poll(&self, context: &Context<'_>) -> Poll<Option<T>> {
        let mut state = self.lock();
        if let Some(item) = state.items.pop_front() {
            return Poll::Ready(Some(item));
        }
        state.waker = Some(context.waker().clone());
        Poll::Pending
    }

    fn lock(&self) -> MutexGuard<'_, State<T>> {
        // No code of a caller runs under the lock, so a poisoned state is a whole one.
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl<T> Messages<T> {
    pub(crate) fn new(
        queue: Arc<Queue<T>>,
        subscription: CallbackSubscription,
        bus: Arc<Bus>,
    ) -> Self {
        Self {
            queue,
            _subscription: subscription,
            _bus: bus,
        }
    }

    /// The next message, waiting for it for at most `timeout`.
    pub fn next_within(&mut self, timeout: Duration) -> Option<T> {
        // A deadline beyond the range of the clock is no deadline.
        self.queue.pop_until(Instant::now().checked_add(timeout))
    }

    /// The next message, if one is there.
    pub fn try_next(&mut self) -> Option<T> {
        self.next_within(Duration::ZERO)
    }

    /// What became of the messages so far.
    #[must_use]
    pub fn counts(&self) -> Counts {
        self.queue.lock().counts
    }

    /// For asynchronous programs.
    #[must_use]
    pub fn into_stream(self) -> MessageStream<T> {
        MessageStream(self)
    }
}

impl<T> Iterator for Messages<T> {
    type Item = T;

    fn next(&mut self) -> Option<T> {
        self.queue.pop_until(None)
    }
}

impl<T> MessageStream<T> {
    /// What became of the messages so far.
    #[must_use]
    pub fn counts(&self) -> Counts {
        self.0.counts()
    }
}

impl<T> futures_core::Stream for MessageStream<T> {
    type Item = T;

    fn poll_next(self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<Option<T>> {
        self.0.queue.poll(context)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_flood_leaves_the_newest_and_is_counted() {
        let queue = Queue::new();
        (0..10 * CAPACITY).for_each(|item| queue.push(Some(item)));
        queue.push(None);
        let soon = Some(Instant::now());
        let left: Vec<_> = std::iter::from_fn(|| queue.pop_until(soon)).collect();
        assert_eq!(left, (9 * CAPACITY..10 * CAPACITY).collect::<Vec<_>>());
        let counts = Counts {
            received: 10 * CAPACITY as u64 + 1,
            dropped: 9 * CAPACITY as u64,
            refused: 1,
        };
        assert_eq!(queue.lock().counts, counts);
    }

    #[test]
    fn an_arrival_ends_the_wait() {
        let queue = Queue::new();
        let waiter = std::thread::spawn({
            let queue = Arc::clone(&queue);
            move || queue.pop_until(None)
        });
        queue.push(Some(7));
        assert_eq!(waiter.join().unwrap(), Some(7));
    }

    #[test]
    fn an_arrival_wakes_the_task() {
        let queue = Queue::new();
        let first = std::future::poll_fn({
            let queue = Arc::clone(&queue);
            move |context| queue.poll(context)
        });
        let pusher = std::thread::spawn({
            let queue = Arc::clone(&queue);
            move || {
                while queue.lock().waker.is_none() {
                    std::thread::yield_now();
                }
                queue.push(Some(7));
            }
        });
        let runtime = tokio::runtime::Builder::new_multi_thread()
            .worker_threads(1)
            .build()
            .unwrap();
        assert_eq!(runtime.block_on(first), Some(7));
        pusher.join().unwrap();
    }
}
