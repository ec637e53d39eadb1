//! Putting messages out: a publisher of a stream, and one of a latest value that answers late joiners.

use std::sync::{Arc, Mutex, PoisonError};

use zenoh::Wait;
use zenoh::bytes::ZBytes;

use crate::BusError;

/// Puts bytes on one key.
#[derive(Debug)]
pub struct RawPublisher {
    pub(crate) publisher: zenoh::pubsub::Publisher<'static>,
}

impl RawPublisher {
    /// The key.
    pub fn key(&self) -> &str {
        self.publisher.key_expr().as_str()
    }

    /// Puts one message. What the class of the stream allows to drop is dropped silently when the network is congested.
    pub fn put(&self, bytes: &[u8]) -> Result<(), BusError> {
        self.put_shared(ZBytes::from(bytes.to_vec()))
    }

    pub(crate) fn put_shared(&self, bytes: ZBytes) -> Result<(), BusError> {
        self.publisher
            .put(bytes)
            .wait()
            .map_err(|cause| BusError::Session(cause.to_string()))
    }

    /// Whether anyone subscribes now: what is costly to make need not be made for nobody.
    pub fn has_subscribers(&self) -> bool {
        self.publisher
            .matching_status()
            .wait()
            .is_ok_and(|status| status.matching())
    }
}

/// Puts bytes on one key and keeps the last, which it gives to everyone who asks by [`crate::Bus::latest`].
#[derive(Debug)]
pub struct RawLatest {
    pub(crate) publisher: RawPublisher,
    pub(crate) last: LastValue,
    pub(crate) _queryable: zenoh::query::Queryable<()>,
}

/// The last value, shared with the answering callback.
pub(crate) type LastValue = Arc<Mutex<Option<ZBytes>>>;

impl RawLatest {
    /// The key.
    pub fn key(&self) -> &str {
        self.publisher.key()
    }

    /// Puts one message and keeps it for those who ask later.
    pub fn put(&self, bytes: &[u8]) -> Result<(), BusError> {
        let bytes = ZBytes::from(bytes.to_vec());
        *self.last.lock().unwrap_or_else(PoisonError::into_inner) = Some(bytes.clone());
        self.publisher.put_shared(bytes)
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
