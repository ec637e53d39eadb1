//! Publishers: of a stream, and of a latest value that late joiners can query.

use std::marker::PhantomData;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use sextant_proto::{Message, encode};
use zenoh::Wait;
use zenoh::bytes::ZBytes;

use crate::BusError;

/// Publishes bytes on one key.
#[derive(Debug)]
pub struct RawPublisher {
    pub(crate) publisher: zenoh::pubsub::Publisher<'static>,
    pub(crate) signature: Option<String>,
}

impl RawPublisher {
    /// The key that it publishes on.
    pub fn key(&self) -> &str {
        self.publisher.key_expr().as_str()
    }

    /// Publishes one message. A congested network drops it silently if the class of the stream allows that.
    pub fn put(&self, bytes: &[u8]) -> Result<(), BusError> {
        self.put_shared(ZBytes::from(bytes.to_vec()))
    }

    pub(crate) fn put_shared(&self, bytes: ZBytes) -> Result<(), BusError> {
        self.publisher
            .put(bytes)
            .attachment(self.signature.as_deref())
            .wait()
            .map_err(|cause| BusError::Session(cause.to_string()))
    }

    /// A publisher whose messages are signed by their sender ([`crate::Item::sender`]), if one is given.
    #[must_use]
    pub fn signed(mut self, sender: Option<&str>) -> Self {
        self.signature = sender.map(str::to_owned);
        self
    }

    /// Whether there is a subscriber now, for messages that are expensive to produce.
    pub fn has_subscribers(&self) -> bool {
        self.publisher
            .matching_status()
            .wait()
            .is_ok_and(|status| status.matching())
    }
}

/// Publishes bytes on one key and keeps the last value for [`crate::Bus::latest`].
#[derive(Debug)]
pub struct RawLatest {
    pub(crate) publisher: RawPublisher,
    pub(crate) last: LastValue,
    pub(crate) _queryable: zenoh::query::Queryable<()>,
}

/// The last value, shared with the answering callback.
pub(crate) type LastValue = Arc<Mutex<Option<ZBytes>>>;

impl RawLatest {
    /// The key that it publishes on.
    pub fn key(&self) -> &str {
        self.publisher.key()
    }

    /// Publishes a message and keeps it for late joiners.
    pub fn put(&self, bytes: &[u8]) -> Result<(), BusError> {
        self.put_shared(ZBytes::from(bytes.to_vec()))
    }

    /// A publisher whose messages are signed by their sender ([`crate::Item::sender`]), if one is given.
    #[must_use]
    pub fn signed(mut self, sender: Option<&str>) -> Self {
        self.publisher = self.publisher.signed(sender);
        self
    }

    fn put_shared(&self, bytes: ZBytes) -> Result<(), BusError> {
        *self.lock() = Some(bytes.clone());
        self.publisher.put_shared(bytes)
    }

    fn lock(&self) -> MutexGuard<'_, Option<ZBytes>> {
        self.last.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Publishes messages of one kind on one key.
#[derive(Debug)]
pub struct Publisher<M> {
    raw: RawPublisher,
    _message: PhantomData<fn(&M)>,
}

impl<M: Message> Publisher<M> {
    pub(crate) fn new(raw: RawPublisher) -> Self {
        Self {
            raw,
            _message: PhantomData,
        }
    }

    /// The key that it publishes on.
    pub fn key(&self) -> &str {
        self.raw.key()
    }

    /// Publishes a message; refuses one that violates its contract.
    pub fn put(&self, message: &M) -> Result<(), BusError> {
        self.raw.put_shared(encoded(message, self.key())?)
    }

    /// Whether there is a subscriber now, for messages that are expensive to produce.
    pub fn has_subscribers(&self) -> bool {
        self.raw.has_subscribers()
    }
}

/// Publishes messages of one kind on one key and keeps the last for [`crate::Bus::latest`].
#[derive(Debug)]
pub struct Latest<M> {
    raw: RawLatest,
    _message: PhantomData<fn(&M)>,
}

impl<M: Message> Latest<M> {
    pub(crate) fn new(raw: RawLatest) -> Self {
        Self {
            raw,
            _message: PhantomData,
        }
    }

    /// The key that it publishes on.
    pub fn key(&self) -> &str {
        self.raw.key()
    }

    /// Publishes a message and keeps it for late joiners; refuses one that violates its contract.
    pub fn put(&self, message: &M) -> Result<(), BusError> {
        self.raw.put_shared(encoded(message, self.key())?)
    }
}

fn encoded<M: Message>(message: &M, key: &str) -> Result<ZBytes, BusError> {
    let bytes = encode(message).map_err(|cause| BusError::Message {
        key: key.to_owned(),
        cause: cause.to_string(),
    })?;
    Ok(ZBytes::from(bytes))
}

impl<M> Latest<M> {
    /// A publisher whose messages are signed by their sender ([`crate::Item::sender`]).
    #[must_use]
    pub fn signed(mut self, sender: &str) -> Self {
        self.raw.publisher.signature = Some(sender.to_owned());
        self
    }
}

impl<M> Publisher<M> {
    /// A publisher whose messages are signed by their sender ([`crate::Item::sender`]).
    #[must_use]
    pub fn signed(mut self, sender: &str) -> Self {
        self.raw.signature = Some(sender.to_owned());
        self
    }
}

/// Answers a query with the last value, if there is one.
pub(crate) fn answer(query: &zenoh::query::Query, key: &str, last: &LastValue) {
    let value = last.lock().unwrap_or_else(PoisonError::into_inner).clone();
    if let Some(bytes) = value
        && let Err(cause) = query.reply(key, bytes).wait()
    {
        tracing::debug!(key, %cause, "a query went away before its answer");
    }
}
