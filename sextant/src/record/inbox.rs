//! What waits to be written: bounded in number and bytes; when it is full, what arrives is dropped and counted.

use sextant_queue::{DropRule, Queue, StreamBounds};
use sextant_recordings::compressed_image::RecordedImage;

/// Most that waits: seconds of several cameras on a slow disk.
const BOUNDS: StreamBounds = StreamBounds::new(65_536, 128 << 20);

/// Something to be written, with its arrival in ns since the Unix epoch.
#[derive(Debug)]
pub struct Entry {
    /// Arrival.
    pub arrival_ns: u64,
    /// What arrived.
    pub content: Content,
}

/// What an entry of the inbox consists of.
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
pub type Inbox = Queue<Entry>;

/// An empty inbox, which drops the newest when full.
pub fn inbox() -> Inbox {
    Queue::new(BOUNDS, DropRule::Newest)
}

impl Entry {
    /// Adds it to an inbox, if there is room.
    pub fn push_to(self, inbox: &Inbox) {
        let bytes = match &self.content {
            Content::Payload { key, bytes } => key.len() + bytes.len(),
            Content::Image(image) => image.png.len(),
        };
        inbox.push(self, bytes);
    }
}
