//! Subscriptions, bounded in number, bytes and waiting time by the queue, and in size by the caller's limit.

use std::sync::Arc;
use std::time::Duration;

use sextant_proto::{DecodeError, Message, decode};
use sextant_queue::{Queue, QueueCounts};
use zenoh::bytes::ZBytes;
use zenoh::sample::{Sample, SampleKind};

/// The bytes of a message.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Payload {
    /// All bytes.
    Bytes(Vec<u8>),
    /// The message was longer than the limit: its length in bytes; nothing was copied.
    TooLong(usize),
}

/// A message that arrived.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Item {
    /// The key on which it was published.
    pub key: String,
    /// Its bytes.
    pub payload: Payload,
    /// The sender, where it signed the message: the attachment, if it is a short text.
    pub sender: Option<String>,
}

/// Longest signature in bytes; longer ones are ignored.
const MAX_SENDER_BYTES: usize = 64;

impl Item {
    /// The bytes, unless the message was too long.
    pub fn bytes(&self) -> Option<&[u8]> {
        self.try_bytes().ok()
    }

    /// The bytes.
    ///
    /// # Errors
    /// [`DecodeError::TooLong`] for a message that was too long.
    pub fn try_bytes(&self) -> Result<&[u8], DecodeError> {
        match &self.payload {
            Payload::Bytes(bytes) => Ok(bytes),
            Payload::TooLong(length) => Err(DecodeError::TooLong(*length)),
        }
    }

    /// Memory of the item in bytes.
    pub(crate) fn held_bytes(&self) -> usize {
        let payload = self.bytes().map_or(0, <[u8]>::len);
        size_of::<Self>() + self.key.len() + payload + self.sender.as_ref().map_or(0, String::len)
    }

    /// The decoded message, if it is of this kind and valid.
    pub fn decode<M: Message>(&self) -> Result<M, DecodeError> {
        decode(self.try_bytes()?)
    }

    /// The item of a sample; `None` for a deletion, which has no meaning on our keys.
    pub(crate) fn from_sample(sample: &Sample, max_bytes: usize) -> Option<Self> {
        let key = sample.key_expr().as_str().to_owned();
        (sample.kind() == SampleKind::Put).then(|| Self {
            key,
            payload: bounded(sample.payload(), max_bytes),
            sender: sample.attachment().and_then(sender),
        })
    }
}

fn sender(attachment: &ZBytes) -> Option<String> {
    let text = (attachment.len() <= MAX_SENDER_BYTES).then(|| attachment.try_to_string())?;
    text.ok().map(|text| text.into_owned())
}

fn bounded(bytes: &ZBytes, max_bytes: usize) -> Payload {
    let length = bytes.len();
    if length > max_bytes {
        Payload::TooLong(length)
    } else {
        Payload::Bytes(bytes.to_bytes().into_owned())
    }
}

/// Messages on a key expression, in a bounded queue. Dropping it ends the subscription.
#[derive(Debug)]
pub struct Subscription {
    pub(crate) queue: Arc<Queue<Item>>,
    pub(crate) _subscriber: zenoh::pubsub::Subscriber<()>,
}

impl Subscription {
    /// The next message; waits for it for at most `timeout`.
    pub fn recv_timeout(&self, timeout: Duration) -> Option<Item> {
        self.queue.pop_timeout(timeout)
    }

    /// The next message, if there is one.
    pub fn try_recv(&self) -> Option<Item> {
        self.queue.try_pop()
    }

    /// Counts of received and dropped messages.
    pub fn counts(&self) -> QueueCounts {
        self.queue.counts()
    }
}

/// Messages on a key expression, passed to a callback. Dropping it ends the subscription.
#[derive(Debug)]
pub struct CallbackSubscription {
    pub(crate) _subscriber: zenoh::pubsub::Subscriber<()>,
}
