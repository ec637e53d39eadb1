//! Messages on their way to a server that may go away: a thread owns the connection, and opens another one when it ends.
//!
//! What waits meanwhile is bounded; a newer message under a key replaces the older one.

use crate::report::{Notice, Reporter};
use sextant_queue::{DropRule, Queue, StreamBounds};
use std::fmt::Display;
use std::io;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::thread::{Builder, JoinHandle};
use std::time::{Duration, Instant};

/// Messages that wait for the server.
const MOST_MESSAGES: usize = 2048;
const MOST_BYTES: usize = 8 << 20;
/// Between two tries to connect.
const RETRY: Duration = Duration::from_secs(1);
/// Between two looks at the queue.
const PERIOD: Duration = Duration::from_millis(100);

/// A connection to a server, which never waits for long.
pub trait Connection: Sized + Send + 'static {
    /// What is sent.
    type Message: Send + 'static;
    /// Why it ends.
    type Error: Display;

    /// Sends a message.
    ///
    /// # Errors
    /// The end of the connection.
    fn send(&mut self, message: &Self::Message) -> Result<(), Self::Error>;

    /// Gives signs of life and looks for those of the server; called several times a second.
    ///
    /// # Errors
    /// The end of the connection.
    fn turn(&mut self) -> Result<(), Self::Error>;

    /// Ends it in order.
    ///
    /// # Errors
    /// The end of the connection.
    fn end(self) -> Result<(), Self::Error>;
}

/// Hands messages to the thread.
#[derive(Debug)]
pub struct Relay<M> {
    outbox: Arc<Outbox<M>>,
    thread: Option<JoinHandle<()>>,
}

#[derive(Debug)]
struct Outbox<M> {
    messages: Queue<M, String>,
    sent: AtomicU64,
    stop: AtomicBool,
}

/// Messages since the start.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct RelayCounts {
    /// Handed to the server.
    pub sent: u64,
    /// Those that gave way to newer ones while the server was slow or gone.
    pub unsent: u64,
}

impl<M: Send + 'static> Relay<M> {
    /// Sends by a connection, and by those that `open` gives after its end. `server` is its name for people.
    ///
    /// # Errors
    /// The system gives no thread.
    pub fn start<C: Connection<Message = M>>(
        connection: C,
        open: impl Fn() -> Result<C, C::Error> + Send + 'static,
        server: String,
        reporter: Reporter,
    ) -> io::Result<Self> {
        let outbox = Arc::new(Outbox {
            messages: Queue::new(
                StreamBounds::new(MOST_MESSAGES, MOST_BYTES),
                DropRule::Oldest,
            ),
            sent: AtomicU64::new(0),
            stop: AtomicBool::new(false),
        });
        let ours = Arc::clone(&outbox);
        let thread = Builder::new().name("relay".into());
        let thread = thread.spawn(move || ours.run(connection, open, &server, &reporter))?;
        Ok(Self {
            outbox,
            thread: Some(thread),
        })
    }

    /// Sends a message of this many bytes.
    pub fn push(&self, message: M, bytes: usize) {
        self.outbox.messages.push(message, bytes);
    }

    /// As [`Self::push`], in place of the one that waits under the same key.
    pub fn put(&self, key: String, message: M, bytes: usize) {
        self.outbox.messages.put(key, message, bytes);
    }

    /// Sends what waits, ends the connection in order, and counts.
    pub fn finish(mut self) -> RelayCounts {
        self.outbox.stop.store(true, Ordering::Relaxed);
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
        let counts = self.outbox.messages.counts();
        RelayCounts {
            sent: self.outbox.sent.load(Ordering::Relaxed),
            unsent: counts.dropped + counts.replaced,
        }
    }
}

impl<M> Drop for Relay<M> {
    fn drop(&mut self) {
        self.outbox.stop.store(true, Ordering::Relaxed);
    }
}

impl<M> Outbox<M> {
    fn run<C: Connection<Message = M>>(
        &self,
        connection: C,
        open: impl Fn() -> Result<C, C::Error>,
        server: &str,
        reporter: &Reporter,
    ) {
        let mut result = self.send_by(connection);
        while let Err(error) = result {
            let server = server.to_owned();
            reporter.report(&Notice::ServerGone {
                server: server.clone(),
                cause: error.to_string(),
            });
            let Some(connection) = self.reopened(&open) else {
                return;
            };
            reporter.report(&Notice::ServerBack { server });
            result = self.send_by(connection);
        }
    }

    /// The next connection; none after a request to stop.
    fn reopened<C: Connection>(&self, open: impl Fn() -> Result<C, C::Error>) -> Option<C> {
        loop {
            let end = Instant::now() + RETRY;
            while Instant::now() < end {
                if self.stop.load(Ordering::Relaxed) {
                    return None;
                }
                std::thread::sleep(PERIOD);
            }
            if let Ok(connection) = open() {
                return Some(connection);
            }
        }
    }

    /// Sends until the connection ends, or until a request to stop.
    fn send_by<C: Connection<Message = M>>(&self, mut connection: C) -> Result<(), C::Error> {
        loop {
            let is_last = self.stop.load(Ordering::Relaxed);
            let wait = if is_last { Duration::ZERO } else { PERIOD };
            while let Some(message) = self.messages.pop_timeout(wait) {
                connection.send(&message)?;
                self.sent.fetch_add(1, Ordering::Relaxed);
                connection.turn()?;
            }
            if is_last {
                return connection.end();
            }
            connection.turn()?;
        }
    }
}
