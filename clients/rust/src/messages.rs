//! Messages as they come: an iterator that blocks, or a stream; behind both one bounded queue that drops the oldest and
//! counts.

use sextant_queue::{DropRule, Queue, StreamBounds};
use sextant_zenoh_bus::{Bus, CallbackSubscription};
use std::pin::Pin;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::task::{Context, Poll};
use std::time::Duration;

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

/// A subscription as an iterator: `next` waits without a time limit, also while the router is unreachable. Dropping it
/// ends the subscription.
#[derive(Debug)]
pub struct Messages<T> {
    inbox: Arc<Inbox<T>>,
    _subscription: CallbackSubscription,
    /// Keeps the session open.
    _bus: Arc<Bus>,
}

/// The same as a stream, for asynchronous programs. It never ends.
#[derive(Debug)]
pub struct MessageStream<T>(Messages<T>);

/// What waits, and how many payloads were no message.
#[derive(Debug)]
pub(crate) struct Inbox<T> {
    queue: Queue<T>,
    refused: AtomicU64,
}

impl<T> Inbox<T> {
    pub(crate) fn new() -> Arc<Self> {
        let bounds = StreamBounds::new(CAPACITY, usize::MAX);
        Arc::new(Self {
            queue: Queue::new(bounds, DropRule::Oldest),
            refused: AtomicU64::new(0),
        })
    }

    /// Takes in what a payload held; none where it held no message.
    pub(crate) fn push(&self, item: Option<T>) {
        match item {
            Some(item) => drop(self.queue.push(item, 0)),
            None => drop(self.refused.fetch_add(1, Ordering::Relaxed)),
        }
    }

    fn counts(&self) -> Counts {
        let (counts, refused) = (self.queue.counts(), self.refused.load(Ordering::Relaxed));
        Counts {
            received: counts.received + refused,
            dropped: counts.dropped,
            refused,
        }
    }
}

impl<T> Messages<T> {
    pub(crate) fn new(
        inbox: Arc<Inbox<T>>,
        subscription: CallbackSubscription,
        bus: Arc<Bus>,
    ) -> Self {
        Self {
            inbox,
            _subscription: subscription,
            _bus: bus,
        }
    }

    /// The next message, waiting for it for at most `timeout`.
    pub fn next_within(&mut self, timeout: Duration) -> Option<T> {
        self.inbox.queue.pop_timeout(timeout)
    }

    /// The next message, if one is there.
    pub fn try_next(&mut self) -> Option<T> {
        self.inbox.queue.try_pop()
    }

    /// What became of the messages so far.
    #[must_use]
    pub fn counts(&self) -> Counts {
        self.inbox.counts()
    }

    /// The same messages as a stream, for asynchronous programs.
    #[must_use]
    pub fn into_stream(self) -> MessageStream<T> {
        MessageStream(self)
    }
}

impl<T> Iterator for Messages<T> {
    type Item = T;

    fn next(&mut self) -> Option<T> {
        loop {
            let next = self.inbox.queue.pop_timeout(Duration::MAX);
            if next.is_some() {
                return next;
            }
        }
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
        let queue = &self.0.inbox.queue;
        queue.poll_ready(context).map(|()| queue.try_pop())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_flood_leaves_the_newest_and_is_counted() {
        let inbox = Inbox::new();
        (0..10 * CAPACITY).for_each(|item| inbox.push(Some(item)));
        inbox.push(None);
        let left: Vec<_> = std::iter::from_fn(|| inbox.queue.try_pop()).collect();
        assert_eq!(left, (9 * CAPACITY..10 * CAPACITY).collect::<Vec<_>>());
        let counts = Counts {
            received: 10 * CAPACITY as u64 + 1,
            dropped: 9 * CAPACITY as u64,
            refused: 1,
        };
        assert_eq!(inbox.counts(), counts);
    }
}
