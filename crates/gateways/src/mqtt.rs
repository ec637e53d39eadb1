//! Poses and events of zones as messages of MQTT 5, and what Home Assistant needs to find the objects.
//!
//! What the broker keeps is sent again on each connection. Of what waits for one, a newer pose of an object replaces
//! the older one.

mod broker;
mod home_assistant;

pub use broker::{Broker, BrokerError, Tls};

use crate::pose_feed::{FeedCounts, Next, PoseReceiver, RateLimit};
use crate::relay::{Connection as _, Relay};
use crate::report::Reporter;
use crate::site::SiteSession;
use serde::Serialize;
use serde_json::Value;
use sextant_pose_streams::{MqttGreeting, Retention, mqtt_publish};
use sextant_process::now_ns;
use sextant_proto::{ObjectPose, limits};
use sextant_recordings::pose_json;
use sextant_site_model::{ObjectId, ObjectModel};
use sextant_site_report::State;
use sextant_zenoh_bus::{BusError, DropRule, Subscription};
use std::io;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Instant;

/// Events of the site that wait.
const EVENTS: usize = 256;
/// The broker takes this program for gone after one and a half of this time without a packet.
const KEEP_ALIVE_S: u16 = 10;

/// What is published, and where.
#[derive(Debug, Clone)]
pub struct MqttOptions {
    /// What all topics begin with.
    pub prefix: String,
    /// Name of the site.
    pub site: String,
    /// The topics of Home Assistant's discovery begin with this; `None` without it.
    pub home_assistant: Option<String>,
    /// Objects that are published; all when empty.
    pub objects: Vec<ObjectId>,
    /// Most poses a second of each object.
    pub rate_hz: f64,
}

/// Messages with their topics.
type Retained = Vec<(String, Vec<u8>)>;

/// Publishes at a broker.
#[derive(Debug)]
pub struct MqttPublisher {
    options: MqttOptions,
    relay: Relay<Vec<u8>>,
    /// Messages of which the broker keeps the last; sent again on each connection.
    retained: Arc<Mutex<Retained>>,
    events: Subscription,
    limit: RateLimit,
    counts: MqttCounts,
}

/// Counts of a publisher.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize)]
pub struct MqttCounts {
    /// Poses of the site.
    #[serde(flatten)]
    pub feed: FeedCounts,
    /// Events of the site.
    pub events: u64,
    /// Invalid events.
    pub refused_events: u64,
    /// Messages handed to the broker.
    pub sent: u64,
    /// Messages that gave way to newer ones while the broker was slow or gone.
    pub unsent: u64,
    /// Poses held back by the rate limit.
    pub skipped: u64,
}

/// Why nothing can be published.
#[derive(Debug, thiserror::Error)]
pub enum StartError {
    /// The broker cannot be reached or refuses.
    #[error(transparent)]
    Broker(#[from] BrokerError),
    /// The session on the site is closed.
    #[error(transparent)]
    Bus(#[from] BusError),
    /// The system gives no thread.
    #[error("no thread")]
    Thread(#[source] io::Error),
}

impl MqttPublisher {
    /// Connects to a broker, as a user or as none.
    ///
    /// # Errors
    /// See [`StartError`].
    pub fn start(
        site: &SiteSession,
        broker: Broker,
        user: Option<(String, String)>,
        options: MqttOptions,
        reporter: Reporter,
    ) -> Result<Self, StartError> {
        let status = format!("{}/status", options.prefix);
        let greeting = MqttGreeting {
            client: format!("sextant{:x}", now_ns()),
            keep_alive_s: KEEP_ALIVE_S,
            will: (status.clone(), "offline".to_owned()),
            user,
        };
        let online = mqtt_publish(&status, b"online", Retention::Retained);
        let retained = Arc::new(Mutex::new(vec![(status, online)]));
        let (server, known) = (format!("the broker {broker}"), Arc::clone(&retained));
        let open = move || {
            let mut connection = broker.connect(&greeting)?;
            let known = known.lock().unwrap_or_else(PoisonError::into_inner).clone();
            let mut messages = known.iter().map(|(_, message)| message);
            messages.try_for_each(|message| connection.send(message))?;
            Ok(connection)
        };
        let relay = Relay::start(open()?, open, server, reporter).map_err(StartError::Thread)?;
        let events = site.keys.all_events();
        let most = limits::MAX_PAYLOAD_BYTES;
        Ok(Self {
            events: site
                .bus
                .subscribe(&events, EVENTS, DropRule::Oldest, most)?,
            limit: RateLimit::new(options.rate_hz),
            options,
            relay,
            retained,
            counts: MqttCounts::default(),
        })
    }

    /// Sends what waits, says that nothing follows, and counts.
    pub fn finish(self, feed: FeedCounts) -> MqttCounts {
        let relayed = self.relay.finish();
        MqttCounts {
            feed,
            sent: relayed.sent,
            unsent: relayed.unsent,
            skipped: self.limit.skipped,
            ..self.counts
        }
    }

    /// Publishes a message that the broker keeps, unless it has it already.
    fn retain(&self, topic: &str, payload: &[u8]) {
        let message = mqtt_publish(topic, payload, Retention::Retained);
        let mut retained = self.retained.lock().unwrap_or_else(PoisonError::into_inner);
        let has_room = retained.len() <= limits::MAX_OBJECTS;
        match retained.iter_mut().find(|(known, _)| known == topic) {
            Some((_, known)) if *known == message => return,
            Some((_, known)) => known.clone_from(&message),
            None if has_room => {
                retained.push((topic.to_owned(), message.clone()));
            }
            None => return,
        }
        let length = message.len();
        self.relay.push(message, length);
    }

    fn topic(&self, object: &ObjectId, what: &str) -> String {
        format!("{}/object/{object}/{what}", self.options.prefix)
    }

    fn publish_event(&mut self, payload: &[u8]) {
        let event = serde_json::from_slice::<Value>(payload).ok();
        let object = event.as_ref().and_then(|event| event["object"].as_str());
        let Some(object) = object.and_then(|object| ObjectId::new(object).ok()) else {
            self.counts.refused_events += 1;
            return;
        };
        let objects = &self.options.objects;
        if objects.is_empty() || objects.contains(&object) {
            self.counts.events += 1;
            let topic = self.topic(&object, "event");
            let message = mqtt_publish(&topic, payload, Retention::Passing);
            let length = message.len();
            self.relay.push(message, length);
        }
    }
}

impl PoseReceiver for MqttPublisher {
    type Error = BusError;
    const WANTS_MODELS: bool = true;

    fn take(&mut self, pose: &ObjectPose) -> Result<Next, BusError> {
        // The news that an object is lost is sent once, and never held back.
        if pose.state == State::Lost || self.limit.admits(&pose.object, Instant::now()) {
            let topic = self.topic(&pose.object, "pose");
            let payload = pose_json(&pose.into());
            let message = mqtt_publish(&topic, payload.as_bytes(), Retention::Passing);
            let length = message.len();
            self.relay.put(topic, message, length);
        }
        Ok(Next::More)
    }

    fn describe(&mut self, model: &ObjectModel) {
        let (options, object) = (&self.options, model.id());
        let Some(prefix) = &options.home_assistant else {
            return;
        };
        let (topic, payload) = home_assistant::device(prefix, options, object);
        self.retain(&topic, payload.as_bytes());
    }

    /// A broker forgets what it keeps under a topic when an empty message comes; Home Assistant then removes the
    /// device.
    fn remove(&mut self, object: &ObjectId) {
        if let Some(prefix) = &self.options.home_assistant {
            let (topic, _) = home_assistant::device(prefix, &self.options, object);
            self.retain(&topic, b"");
        }
    }

    fn tick(&mut self) {
        while let Some(item) = self.events.try_recv() {
            match item.try_bytes() {
                Ok(payload) => self.publish_event(payload),
                Err(_) => self.counts.refused_events += 1,
            }
        }
    }
}
