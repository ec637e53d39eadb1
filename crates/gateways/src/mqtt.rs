//! Poses and events of zones as messages of MQTT 5, and what Home Assistant needs to find the objects.
//!
//! A thread owns the connection, and opens another one when it ends. Of what waits meanwhile, a newer pose of an object replaces the older one.

mod broker;
mod home_assistant;

pub use broker::{Broker, BrokerError, Tls};

use crate::pose_feed::{FeedCounts, Next, PoseReceiver, RateLimit};
use crate::report::{Notice, Reporter};
use crate::site::SiteSession;
use broker::Connection;
use serde::Serialize;
use serde_json::Value;
use sextant_pose_formats::{MqttGreeting, Retention, mqtt_publish};
use sextant_process::now_ns;
use sextant_proto::{ObjectPose, limits};
use sextant_queue::{DropRule, Queue, StreamBounds};
use sextant_recordings::pose_json;
use sextant_site_model::{ObjectId, ObjectModel};
use sextant_site_report::State;
use sextant_zenoh_bus::{BusError, Subscription};
use std::io;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::{Builder, JoinHandle};
use std::time::{Duration, Instant};

/// Messages that wait for the broker.
const WAITING: StreamBounds = StreamBounds::new(2048, 8 << 20);
/// Events of the site that wait.
const EVENTS: usize = 256;
/// Between two tries to connect.
const RETRY: Duration = Duration::from_secs(1);
/// Between two looks at the queue.
const PERIOD: Duration = Duration::from_millis(100);
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

/// Publishes at a broker.
#[derive(Debug)]
pub struct MqttPublisher {
    options: MqttOptions,
    outbox: Arc<Outbox>,
    events: Subscription,
    limit: RateLimit,
    counts: MqttCounts,
    thread: Option<JoinHandle<()>>,
}

/// What waits for the broker.
#[derive(Debug)]
struct Outbox {
    messages: Queue<Vec<u8>, String>,
    /// Messages of which the broker keeps the last; sent again on each connection.
    retained: Mutex<Vec<Vec<u8>>>,
    sent: AtomicU64,
    stop: AtomicBool,
}

/// Counts of a publisher.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize)]
pub struct MqttCounts {
    /// Poses of the site.
    #[serde(flatten)]
    pub feed: FeedCounts,
    /// Events of the site.
    pub events: u64,
    /// Events that are none.
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
        let outbox = Arc::new(Outbox {
            messages: Queue::new(WAITING, DropRule::Oldest),
            retained: Mutex::new(vec![mqtt_publish(&status, b"online", Retention::Retained)]),
            sent: AtomicU64::new(0),
            stop: AtomicBool::new(false),
        });
        let connection = broker.connect(&greeting)?;
        let relay = Relay {
            last: mqtt_publish(&status, b"offline", Retention::Retained),
            outbox: Arc::clone(&outbox),
            broker,
            greeting,
            reporter,
        };
        let thread = Builder::new().name("mqtt".into());
        let thread = thread.spawn(move || relay.run(connection));
        let events = site.keys.all_events();
        let most = limits::MAX_PAYLOAD_BYTES;
        Ok(Self {
            events: site
                .bus
                .subscribe(&events, EVENTS, DropRule::Oldest, most)?,
            limit: RateLimit::new(options.rate_hz),
            options,
            outbox,
            counts: MqttCounts::default(),
            thread: Some(thread.map_err(StartError::Thread)?),
        })
    }

    /// Sends what waits, says that nothing follows, and counts.
    pub fn finish(mut self, feed: FeedCounts) -> MqttCounts {
        self.outbox.stop.store(true, Ordering::Relaxed);
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
        MqttCounts {
            feed,
            sent: self.outbox.sent.load(Ordering::Relaxed),
            unsent: self.outbox.messages.counts().dropped + self.outbox.messages.counts().replaced,
            skipped: self.limit.skipped,
            ..self.counts
        }
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
            self.outbox.messages.push(message, length);
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
            self.outbox.messages.put(topic, message, length);
        }
        Ok(Next::More)
    }

    fn describe(&mut self, model: &ObjectModel) {
        let (options, object) = (&self.options, model.id());
        let Some(prefix) = &options.home_assistant else {
            return;
        };
        if options.objects.is_empty() || options.objects.contains(object) {
            let (topic, payload) = home_assistant::device(prefix, options, object);
            self.outbox.retain(&topic, payload.as_bytes());
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

impl Outbox {
    /// Publishes a message that the broker keeps, unless it has it already.
    fn retain(&self, topic: &str, payload: &[u8]) {
        let message = mqtt_publish(topic, payload, Retention::Retained);
        let mut retained = self.retained.lock().unwrap_or_else(PoisonError::into_inner);
        if !retained.contains(&message) && retained.len() <= limits::MAX_OBJECTS {
            retained.push(message.clone());
            let length = message.len();
            self.messages.push(message, length);
        }
    }
}

/// The thread.
struct Relay {
    outbox: Arc<Outbox>,
    broker: Broker,
    greeting: MqttGreeting,
    /// The message that says that nothing follows.
    last: Vec<u8>,
    reporter: Reporter,
}

impl Relay {
    fn run(self, connection: Connection) {
        let mut connection = Some(connection);
        let mut is_reported = false;
        loop {
            let result = match connection.take() {
                Some(connection) => Ok(connection),
                None => self.broker.connect(&self.greeting),
            };
            let result = result.and_then(|connection| {
                if std::mem::take(&mut is_reported) {
                    self.reporter.report(&Notice::BrokerBack);
                }
                self.publish(connection)
            });
            match result {
                Ok(()) => return,
                Err(error) if !is_reported => {
                    is_reported = true;
                    self.reporter.report(&Notice::BrokerGone {
                        broker: self.broker.to_string(),
                        cause: error.to_string(),
                    });
                }
                Err(_) => {}
            }
            let end = Instant::now() + RETRY;
            while Instant::now() < end {
                if self.outbox.stop.load(Ordering::Relaxed) {
                    return;
                }
                std::thread::sleep(PERIOD);
            }
        }
    }

    /// Publishes until the connection ends, or until a request to stop.
    fn publish(&self, mut connection: Connection) -> Result<(), BrokerError> {
        let retained = self.outbox.retained.lock();
        let retained = retained.unwrap_or_else(PoisonError::into_inner).clone();
        retained.iter().try_for_each(|m| connection.send(m))?;
        loop {
            let is_last = self.outbox.stop.load(Ordering::Relaxed);
            while let Some(message) = self.outbox.messages.pop_timeout(match is_last {
                true => Duration::ZERO,
                false => PERIOD,
            }) {
                connection.send(&message)?;
                self.outbox.sent.fetch_add(1, Ordering::Relaxed);
                connection.turn()?;
            }
            if is_last {
                connection.send(&self.last)?;
                return connection.end();
            }
            connection.turn()?;
        }
    }
}
