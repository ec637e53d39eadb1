//! What waits to be written: bounded in number and bytes; when it is full, what arrives is dropped and counted.

use sextant_recordings::compressed_image::RecordedImage;
use std::collections::VecDeque;
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

/// Most that waits: seconds of several cameras on a slow disk.
const MOST_ENTRIES: usize = 65_536;
const MOST_BYTES: usize = 128 << 20;

/// Something to be written, with its arrival in ns since the Unix epoch.
#[derive(Debug)]
pub struct Entry {
    /// Arrival.
    pub arrival_ns: u64,
    /// What arrived.
    pub content: Content,
}

/// What arrived.
#[derive(Debug)]
pub enum Content {
    /// A payload.
    Payload {
        /// The key it was put on.
        key: String,
        /// Its bytes.
        bytes: Vec<u8>,
    },
    /// An image from shared memory.
    Image(RecordedImage),
}

/// The queue between those who receive and the one who writes.
#[derive(Debug, Default)]
pub struct Inbox {
    state: Mutex<State>,
    arrival: Condvar,
}

#[derive(Debug, Default)]
struct State {
    entries: VecDeque<Entry>,
    bytes: usize,
    dropped: u64,
}

impl Entry {
    fn bytes(&self) -> usize {
        match &self.content {
            Content::Payload { key, bytes } => key.len() + bytes.len(),
            Content::Image(image) => image.png.len(),
        }
    }
}

impl Inbox {
    /// Adds an entry, if there is room.
    pub fn push(&self, entry: Entry) {
        let mut state = self.lock();
        let bytes = state.bytes + entry.bytes();
        if state.entries.len() >= MOST_ENTRIES || bytes > MOST_BYTES {
            state.dropped += 1;
            return;
        }
        state.bytes = bytes;
        state.entries.push_back(entry);
        self.arrival.notify_one();
    }

    /// The oldest entry, waiting for one for at most `timeout`.
    pub fn pop(&self, timeout: Duration) -> Option<Entry> {
        let deadline = Instant::now() + timeout;
        let mut state = self.lock();
        loop {
            if let Some(entry) = state.entries.pop_front() {
                state.bytes -= entry.bytes();
                return Some(entry);
            }
            let left = deadline.saturating_duration_since(Instant::now());
            if left.is_zero() {
                return None;
            }
            let waited = self.arrival.wait_timeout(state, left);
            state = waited.unwrap_or_else(PoisonError::into_inner).0;
        }
    }

    /// Entries that found no room.
    pub fn dropped(&self) -> u64 {
        self.lock().dropped
    }

    fn lock(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn payload(n_bytes: usize) -> Entry {
        Entry {
            arrival_ns: 0,
            content: Content::Payload {
                key: String::new(),
                bytes: vec![0; n_bytes],
            },
        }
    }

    #[test]
    fn a_flood_is_dropped_at_the_bound_and_counted() {
        let inbox = Inbox::default();
        for _ in 0..MOST_ENTRIES + 10 {
            inbox.push(payload(0));
        }
        assert_eq!(inbox.dropped(), 10);
        let inbox = Inbox::default();
        for _ in 0..5 {
            inbox.push(payload(MOST_BYTES / 4));
        }
        assert_eq!(inbox.dropped(), 1);
        assert!(inbox.pop(Duration::ZERO).is_some());
        inbox.push(payload(MOST_BYTES / 4));
        assert_eq!(inbox.dropped(), 1);
    }
}
