//! Liveliness: a token on a key exists as long as the process (or its link) that declared it.

use std::sync::Arc;
use std::time::Duration;

use sextant_queue::Queue;

/// A liveliness token: while it exists, its key is alive.
#[derive(Debug)]
pub struct AliveToken {
    pub(crate) _token: zenoh::liveliness::LivelinessToken,
}

/// A change of liveliness.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Presence {
    /// A token appeared on this key, or existed when the watch began.
    Joined(String),
    /// The token on this key is gone: its process ended, or its link broke.
    Left(String),
}

/// Watches tokens. Dropping it ends the watch.
#[derive(Debug)]
pub struct AliveWatch {
    pub(crate) queue: Arc<Queue<Presence>>,
    pub(crate) _subscriber: zenoh::pubsub::Subscriber<()>,
}

impl AliveWatch {
    /// The next change; waits for it for at most `timeout`.
    pub fn recv_timeout(&self, timeout: Duration) -> Option<Presence> {
        self.queue.pop_timeout(timeout)
    }

    /// The next change, if there is one.
    pub fn try_recv(&self) -> Option<Presence> {
        self.queue.try_pop()
    }
}
