//! Messages on their way to a server that may go away: a thread owns the connection, and opens another one when it
//! ends.
//!
//! What waits meanwhile is bounded; a newer message under a key replaces the older one.

use crate::report::{Notice, Reporter};
use sextant_queue::{DropRule, Queue, StreamBounds};
use std::fmt::{self, Display};
use std::io::{self, ErrorKind};
use std::net::{TcpStream, ToSocketAddrs};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::thread::{Builder, JoinHandle};
use std::time::{Duration, Instant};

/// Messages that wait for the server.
const MOST_MESSAGES: usize = 2048;
const MOST_BYTES: usize = 8 << 20;
/// Time limit of a connection and its handshake, and of a server that accepts nothing.
pub const CONNECT_TIMEOUT: Duration = Duration::from_secs(5);
/// Time limit of a read between two messages.
pub const READ_TIMEOUT: Duration = Duration::from_millis(1);
/// Interval of reads while nothing is sent.
pub const POLL_PERIOD: Duration = Duration::from_millis(500);
/// A server that is silent for this long counts as gone.
pub const SERVER_SILENCE: Duration = Duration::from_secs(10);
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

/// Address of a server by name or number, with its port.
#[derive(Debug, Clone)]
pub struct HostAndPort {
    host: String,
    port: u16,
}

impl HostAndPort {
    /// Of `HOST`, `HOST:PORT`, `IPV6`, `[IPV6]` or `[IPV6]:PORT`.
    pub fn parse(text: &str, usual: u16) -> Option<Self> {
        let (host, port) = match text.strip_prefix('[').and_then(|rest| rest.split_once(']')) {
            Some((host, "")) => (host, None),
            Some((host, rest)) => (host, Some(rest.strip_prefix(':')?)),
            None if text.matches(':').count() > 1 => (text, None),
            None => match text.split_once(':') {
                Some((host, port)) => (host, Some(port)),
                None => (text, None),
            },
        };
        let port = match port {
            Some(port) => port.parse().ok().filter(|port| *port != 0)?,
            None => usual,
        };
        let is_host = !host.is_empty() && !host.contains(['/', '@', ' ']);
        let host = host.to_owned();
        is_host.then_some(Self { host, port })
    }

    /// Name or number of the host, without the port.
    pub fn host(&self) -> &str {
        &self.host
    }

    /// A connection to the first address that answers.
    ///
    /// # Errors
    /// A name without an address, or the failure of the last attempt.
    pub fn dial(&self) -> io::Result<TcpStream> {
        let mut last = io::Error::new(ErrorKind::NotFound, "the host has no address");
        for address in (self.host.as_str(), self.port).to_socket_addrs()? {
            match TcpStream::connect_timeout(&address, CONNECT_TIMEOUT) {
                Ok(stream) => return Ok(stream),
                Err(error) => last = error,
            }
        }
        Err(last)
    }
}

impl Display for HostAndPort {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.host.contains(':') {
            true => write!(f, "[{}]:{}", self.host, self.port),
            false => write!(f, "{}:{}", self.host, self.port),
        }
    }
}

/// Whether a socket has no data yet.
pub fn is_later(error: &io::Error) -> bool {
    matches!(
        error.kind(),
        ErrorKind::WouldBlock | ErrorKind::TimedOut | ErrorKind::Interrupted
    )
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
            let mut last = None;
            let mut report = |cause: String| {
                let server = server.clone();
                if last.as_ref() != Some(&cause) {
                    last = Some(cause.clone());
                    reporter.report(&Notice::ServerGone { server, cause });
                }
            };
            report(error.to_string());
            let Some(connection) = self.reopened(&open, &mut report) else {
                return;
            };
            reporter.report(&Notice::ServerBack { server });
            result = self.send_by(connection);
        }
    }

    /// The next connection; none after a request to stop. Reports why attempts fail.
    fn reopened<C: Connection>(
        &self,
        open: impl Fn() -> Result<C, C::Error>,
        report: &mut impl FnMut(String),
    ) -> Option<C> {
        loop {
            let end = Instant::now() + RETRY;
            while Instant::now() < end {
                if self.stop.load(Ordering::Relaxed) {
                    return None;
                }
                std::thread::sleep(PERIOD);
            }
            match open() {
                Ok(connection) => return Some(connection),
                Err(error) => report(error.to_string()),
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_server_without_a_port_has_the_usual_one() {
        for (text, whole) in [
            ("10.12.34.2", Some("10.12.34.2:5810")),
            ("roborio.local:99", Some("roborio.local:99")),
            ("::1", Some("[::1]:5810")),
            ("[::1]", Some("[::1]:5810")),
            ("[::1]:99", Some("[::1]:99")),
            ("", None),
            ("host:port", None),
            ("ws://host", None),
            (":5810", None),
        ] {
            let server = HostAndPort::parse(text, 5810);
            assert_eq!(server.map(|it| it.to_string()).as_deref(), whole, "{text}");
        }
    }
}
