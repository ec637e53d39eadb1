//! Publishers as rmw_zenoh has them: each message with an attachment; and, where late subscribers get the last one,
//! with a history that zenoh-ext's AdvancedSubscriber finds.
//!
//! An AdvancedSubscriber asks `<key>/@adv/**` once, and every publisher whose token appears below `<key>/@adv/pub/**`.
//! The last chunks of the token are `uhlc/_`: samples differ by their timestamps. Source: zenoh-ext 1.10,
//! `advanced_publisher.rs`.

use std::sync::{Arc, Mutex, PoisonError};

use zenoh::Wait;
use zenoh::bytes::ZBytes;
use zenoh::time::Timestamp;

use crate::{AliveToken, Bus, BusError, Qos};

/// Who gets a message.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Audience {
    /// Those who subscribe now.
    Present,
    /// Those who subscribe later too, if it is the last.
    PresentAndLate,
}

/// Puts bytes with an attachment on one key.
#[derive(Debug)]
pub struct AttachedPublisher {
    publisher: zenoh::pubsub::Publisher<'static>,
    history: Option<History>,
}

#[derive(Debug)]
struct History {
    session: zenoh::Session,
    last: Arc<Mutex<Option<Entry>>>,
    _queryable: zenoh::query::Queryable<()>,
    _token: AliveToken,
}

/// A message as late subscribers get it.
#[derive(Debug, Clone)]
struct Entry {
    payload: ZBytes,
    attachment: ZBytes,
    timestamp: Timestamp,
}

impl Bus {
    /// A publisher of bytes with attachments.
    pub fn attached_publisher(
        &self,
        key: &str,
        qos: Qos,
        audience: Audience,
    ) -> Result<AttachedPublisher, BusError> {
        let publisher = self.raw_publisher(key, qos)?.publisher;
        let history = match audience {
            Audience::Present => None,
            Audience::PresentAndLate => Some(self.history(key)?),
        };
        Ok(AttachedPublisher { publisher, history })
    }

    fn history(&self, key: &str) -> Result<History, BusError> {
        let session = self.session()?.clone();
        let last = Arc::new(Mutex::new(None));
        let place = format!("{key}/@adv/pub/{}/uhlc/_", session.zid());
        let queryable = {
            let (last, key) = (Arc::clone(&last), key.to_owned());
            session
                .declare_queryable(place.clone())
                .callback(move |query| answer(&query, &key, &last))
        };
        Ok(History {
            last,
            _queryable: queryable
                .wait()
                .map_err(|cause| BusError::of_key(key, &cause))?,
            _token: self.alive(&place)?,
            session,
        })
    }
}

impl AttachedPublisher {
    /// Puts one message. What the class of the stream allows to drop is dropped silently when the network is congested.
    pub fn put(&self, payload: Vec<u8>, attachment: &[u8]) -> Result<(), BusError> {
        let (payload, attachment) = (ZBytes::from(payload), ZBytes::from(attachment));
        let put = match &self.history {
            None => self.publisher.put(payload).attachment(attachment).wait(),
            Some(history) => {
                let entry = Entry {
                    payload,
                    attachment,
                    timestamp: history.session.new_timestamp(),
                };
                *lock(&history.last) = Some(entry.clone());
                self.publisher
                    .put(entry.payload)
                    .attachment(entry.attachment)
                    .timestamp(entry.timestamp)
                    .wait()
            }
        };
        put.map_err(|cause| BusError::Session(cause.to_string()))
    }
}

/// Answers a query with the last message, on the key of the messages.
fn answer(query: &zenoh::query::Query, key: &str, last: &Mutex<Option<Entry>>) {
    let Some(entry) = lock(last).clone() else {
        return;
    };
    let reply = query
        .reply(key, entry.payload)
        .attachment(entry.attachment)
        .timestamp(entry.timestamp);
    if let Err(cause) = reply.wait() {
        tracing::debug!(key, %cause, "a late subscriber went away before its answer");
    }
}

fn lock(last: &Mutex<Option<Entry>>) -> std::sync::MutexGuard<'_, Option<Entry>> {
    last.lock().unwrap_or_else(PoisonError::into_inner)
}
