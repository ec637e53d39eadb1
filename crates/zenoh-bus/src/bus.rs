//! The session: waits for its router, closes within a time limit, and creates publishers, subscriptions and tokens.

use std::net::{SocketAddr, TcpListener, ToSocketAddrs, UdpSocket};
use std::sync::Arc;
use std::sync::mpsc::{self, RecvTimeoutError};
use std::time::{Duration, Instant};

use sextant_proto::Message;
use sextant_queue::{DropRule, Queue, StreamBounds};
use zenoh::Wait;
use zenoh::sample::Locality;

use crate::config::zenoh_config;
use crate::liveliness::{AliveToken, AliveWatch, Presence};
use crate::publisher::{LastValue, Latest, Publisher, RawLatest, RawPublisher, answer};
use crate::query::Question;
use crate::shelf::Shelf;
use crate::subscription::{CallbackSubscription, Item, Subscription};
use crate::{BusError, BusOptions, Mode, Profile, Qos, Security, query, runtime, why_no_router};

/// Time limit of closing.
const CLOSE_TIMEOUT: Duration = Duration::from_secs(2);
/// Period of the log message of a client that waits for its router.
const COMPLAINT_PERIOD: Duration = Duration::from_secs(10);
/// Capacity of a watch's queue: more changes at one time mean a network in flux, whose last state counts.
const PRESENCES: StreamBounds = StreamBounds::new(1024, usize::MAX);

/// A session on the site's network.
#[derive(Debug)]
pub struct Bus {
    session: Option<zenoh::Session>,
    mode: Mode,
    lease: Duration,
    endpoints: Vec<String>,
}

impl Bus {
    /// Opens a session without protection, which listens on this machine only. A client waits for its router without
    /// time limit.
    pub fn open(options: &BusOptions) -> Result<Self, BusError> {
        Self::open_unless(options, &Security::none(Profile::Demo), &|| false)
    }

    /// Opens the session. A client waits for its router until `stop`, polled ten times a second, returns true.
    pub fn open_unless(
        options: &BusOptions,
        security: &Security,
        stop: &dyn Fn() -> bool,
    ) -> Result<Self, BusError> {
        runtime::ask_for_few_threads();
        let endpoints = options
            .listen
            .iter()
            .map(|endpoint| resolve_port(endpoint))
            .collect::<Result<Vec<_>, _>>()?;
        let config = zenoh_config(options, security, &endpoints)?;
        let session = open_session(config, options, security, stop)?;
        Ok(Self {
            session: Some(session),
            mode: options.mode,
            lease: Duration::from_millis(options.lease_ms.into()),
            endpoints,
        })
    }

    /// The endpoints that this session listens on, with their actual ports.
    pub fn endpoints(&self) -> &[String] {
        &self.endpoints
    }

    /// The session's identifier, as zenoh prints it.
    pub fn session_id(&self) -> Result<String, BusError> {
        Ok(self.session()?.zid().to_string())
    }

    /// Whether a client is connected to its router; always true for a peer or router.
    pub fn is_connected(&self) -> bool {
        self.mode != Mode::Client
            || self
                .session
                .as_ref()
                .is_some_and(|session| session.info().routers_zid().wait().next().is_some())
    }

    /// A publisher of messages of one kind.
    pub fn publisher<M: Message>(&self, key: &str, qos: Qos) -> Result<Publisher<M>, BusError> {
        Ok(Publisher::new(self.raw_publisher(key, qos)?))
    }

    /// A publisher of messages of one kind that sends its last message to late joiners.
    pub fn latest_publisher<M: Message>(&self, key: &str, qos: Qos) -> Result<Latest<M>, BusError> {
        Ok(Latest::new(self.raw_latest(key, qos)?))
    }

    /// A publisher of bytes.
    pub fn raw_publisher(&self, key: &str, qos: Qos) -> Result<RawPublisher, BusError> {
        let publisher = self
            .session()?
            .declare_publisher(key.to_owned())
            .priority(qos.priority())
            .congestion_control(qos.congestion())
            .express(qos.is_express())
            .wait()
            .map_err(|cause| BusError::of_key(key, &cause))?;
        Ok(RawPublisher {
            publisher,
            signature: None,
        })
    }

    /// A publisher of bytes that sends its last value to late joiners.
    pub fn raw_latest(&self, key: &str, qos: Qos) -> Result<RawLatest, BusError> {
        let last = LastValue::default();
        let queryable = {
            let (last, key) = (Arc::clone(&last), key.to_owned());
            self.session()?
                .declare_queryable(key.clone())
                .callback(move |query| answer(&query, &key, &last))
        };
        let queryable = queryable
            .wait()
            .map_err(|cause| BusError::of_key(key, &cause))?;
        Ok(RawLatest {
            publisher: self.raw_publisher(key, qos)?,
            last,
            _queryable: queryable,
        })
    }

    /// Messages on `key_expr` in a queue of `capacity`; those over `max_bytes` are reported, not copied.
    pub fn subscribe(
        &self,
        key_expr: &str,
        capacity: usize,
        rule: DropRule,
        max_bytes: usize,
    ) -> Result<Subscription, BusError> {
        self.subscribe_by(
            key_expr,
            max_bytes,
            Queue::new(StreamBounds::new(capacity, usize::MAX), rule),
            |_| {},
        )
    }

    /// Messages of a stream on `key_expr` in a queue within `bounds`; those over `max_bytes` are reported, not copied.
    pub fn subscribe_stream(
        &self,
        key_expr: &str,
        bounds: StreamBounds,
        max_bytes: usize,
    ) -> Result<Subscription, BusError> {
        self.subscribe_stream_heard(key_expr, bounds, max_bytes, |_| {})
    }

    /// As [`Self::subscribe_stream`]. `hear` gets the key of every message as it arrives, also of those that are
    /// dropped unread; it is called on a zenoh thread and must not block.
    pub fn subscribe_stream_heard(
        &self,
        key_expr: &str,
        bounds: StreamBounds,
        max_bytes: usize,
        hear: impl Fn(&str) + Send + Sync + 'static,
    ) -> Result<Subscription, BusError> {
        let queue = Queue::new(bounds, DropRule::Oldest);
        self.subscribe_by(key_expr, max_bytes, queue, hear)
    }

    fn subscribe_by(
        &self,
        key_expr: &str,
        max_bytes: usize,
        queue: Queue<Item>,
        hear: impl Fn(&str) + Send + Sync + 'static,
    ) -> Result<Subscription, BusError> {
        let queue = Arc::new(queue);
        let intake = Arc::clone(&queue);
        let subscriber = self.subscriber(key_expr, max_bytes, move |item| {
            hear(&item.key);
            let bytes = item.held_bytes();
            intake.push(item, bytes);
        })?;
        Ok(Subscription {
            queue,
            _subscriber: subscriber,
        })
    }

    /// Messages on `key_expr`, each passed to `callback` on a zenoh thread: it must not block or use this bus.
    pub fn subscribe_with(
        &self,
        key_expr: &str,
        max_bytes: usize,
        callback: impl Fn(Item) + Send + Sync + 'static,
    ) -> Result<CallbackSubscription, BusError> {
        Ok(CallbackSubscription {
            _subscriber: self.subscriber(key_expr, max_bytes, callback)?,
        })
    }

    /// Latest values on `key_expr`, one per key, sorted by key, from all publishers that answer within `timeout`.
    /// Values in zenoh's storages are left out.
    pub fn latest(
        &self,
        key_expr: &str,
        max_bytes: usize,
        timeout: Duration,
    ) -> Result<Vec<Item>, BusError> {
        query::latest(self.session()?, key_expr, max_bytes, timeout)
    }

    /// As [`Self::latest`], without what this session answers itself and without waiting for it.
    pub fn ask_others(
        &self,
        key_expr: &str,
        max_bytes: usize,
        timeout: Duration,
    ) -> Result<Question, BusError> {
        let session = self.session()?;
        query::ask(session, key_expr, max_bytes, timeout, Locality::Remote)
    }

    /// Answers queries for keys below `root` from values that are replaced together.
    pub fn shelf(&self, root: &str) -> Result<Shelf, BusError> {
        Shelf::declare(self.session()?, root)
    }

    /// Keeps `key` alive until the token is dropped.
    pub fn alive(&self, key: &str) -> Result<AliveToken, BusError> {
        let token = self
            .session()?
            .liveliness()
            .declare_token(key.to_owned())
            .wait();
        Ok(AliveToken {
            _token: token.map_err(|cause| BusError::of_key(key, &cause))?,
        })
    }

    /// The keys on `key_expr` that are alive now, sorted. Waits for a second at most.
    pub fn alive_keys(&self, key_expr: &str) -> Result<Vec<String>, BusError> {
        query::alive_keys(self.session()?, key_expr)
    }

    /// Waits until the router has received what this session has written to its link, for a second at most; whether it
    /// has. Asks who is alive on `key_expr`: the question follows on the link. Messages of lower priority that zenoh
    /// still holds back are not waited for.
    pub fn await_delivery(&self, key_expr: &str) -> Result<bool, BusError> {
        let begun = Instant::now();
        query::alive_keys(self.session()?, key_expr)?;
        Ok(begun.elapsed() < query::TOKENS)
    }

    /// Subscribes to liveliness changes on `key_expr`, starting with the keys that are alive already.
    pub fn watch_alive(&self, key_expr: &str) -> Result<AliveWatch, BusError> {
        let queue = Arc::new(Queue::new(PRESENCES, DropRule::Oldest));
        let intake = Arc::clone(&queue);
        let subscriber = self
            .session()?
            .liveliness()
            .declare_subscriber(key_expr.to_owned())
            .history(true)
            .callback(move |sample| {
                intake.push(presence(&sample), 0);
            })
            .wait()
            .map_err(|cause| BusError::of_key(key_expr, &cause))?;
        Ok(AliveWatch {
            queue,
            _subscriber: subscriber,
        })
    }

    /// Closes the session; gives up after two seconds.
    pub fn close(mut self) {
        self.close_bounded();
    }

    fn subscriber(
        &self,
        key_expr: &str,
        max_bytes: usize,
        callback: impl Fn(Item) + Send + Sync + 'static,
    ) -> Result<zenoh::pubsub::Subscriber<()>, BusError> {
        self.session()?
            .declare_subscriber(key_expr.to_owned())
            .callback(move |sample| {
                if let Some(item) = Item::from_sample(&sample, max_bytes) {
                    callback(item);
                }
            })
            .wait()
            .map_err(|cause| BusError::of_key(key_expr, &cause))
    }

    /// Silence after which a link counts as dead.
    pub(crate) fn lease(&self) -> Duration {
        self.lease
    }

    pub(crate) fn session(&self) -> Result<&zenoh::Session, BusError> {
        self.session
            .as_ref()
            .ok_or_else(|| BusError::Session("the session is closed".into()))
    }

    fn close_bounded(&mut self) {
        let Some(session) = self.session.take() else {
            return;
        };
        let (done, wait) = mpsc::channel();
        let closer = std::thread::Builder::new()
            .name("bus-close".into())
            .spawn(move || {
                let _ = done.send(session.close().wait().map_err(|cause| cause.to_string()));
            });
        if closer.is_err() {
            return;
        }
        match wait.recv_timeout(CLOSE_TIMEOUT) {
            Ok(Ok(())) => {}
            Ok(Err(cause)) => tracing::debug!(cause, "closing the network session"),
            Err(_) => tracing::warn!("the network session does not close; going on without it"),
        }
    }
}

impl Drop for Bus {
    fn drop(&mut self) {
        self.close_bounded();
    }
}

/// Opens on a thread of its own, since zenoh's wait for a router cannot be interrupted. After `stop` that thread
/// is detached: it ends with the process, or closes the session if it still gets one.
fn open_session(
    config: zenoh::Config,
    options: &BusOptions,
    security: &Security,
    stop: &dyn Fn() -> bool,
) -> Result<zenoh::Session, BusError> {
    let endpoints = options.connect_endpoints(security.profile()).join(", ");
    let (done, wait) = mpsc::channel();
    std::thread::Builder::new()
        .name("bus-open".into())
        .spawn(move || {
            let _ = done.send(zenoh::open(config).wait());
        })
        .map_err(BusError::Thread)?;
    let mut complaint = Instant::now() + Duration::from_secs(1);
    loop {
        match wait.recv_timeout(Duration::from_millis(100)) {
            Ok(opened) => return opened.map_err(|cause| BusError::Open(cause.to_string())),
            Err(RecvTimeoutError::Disconnected) => {
                return Err(BusError::Open("the opening thread ended".into()));
            }
            Err(RecvTimeoutError::Timeout) if stop() => {
                return Err(BusError::Abandoned { endpoints });
            }
            Err(RecvTimeoutError::Timeout) if Instant::now() >= complaint => {
                let cause = why_no_router(options, security);
                let cause = cause
                    .as_deref()
                    .unwrap_or("unknown; the router's log may say more");
                tracing::warn!(
                    cause,
                    "no router answers yet at {endpoints}; waiting for one"
                );
                complaint = Instant::now() + COMPLAINT_PERIOD;
            }
            Err(RecvTimeoutError::Timeout) => {}
        }
    }
}

/// The endpoint with its actual port, once that is known to be free. Another program may take it before zenoh
/// does; then opening fails with zenoh's message.
fn resolve_port(endpoint: &str) -> Result<String, BusError> {
    let Some((protocol @ ("tcp" | "quic"), address)) = endpoint.split_once('/') else {
        return Ok(endpoint.to_owned());
    };
    // Zenoh's own settings of an endpoint follow `?` or `#`.
    let (address, settings) = address.split_at(address.find(['?', '#']).unwrap_or(address.len()));
    let port = listen_any(protocol, address).map_err(|cause| listen_error(endpoint, &cause))?;
    match address.rsplit_once(':') {
        Some((host, "0")) => Ok(format!("{protocol}/{host}:{port}{settings}")),
        _ => Ok(endpoint.to_owned()),
    }
}

/// The port that was bound for a moment.
fn listen_any(protocol: &str, address: &str) -> std::io::Result<u16> {
    let addresses: Vec<SocketAddr> = address.to_socket_addrs()?.collect();
    let bound = if protocol == "quic" {
        UdpSocket::bind(addresses.as_slice())?.local_addr()?
    } else {
        TcpListener::bind(addresses.as_slice())?.local_addr()?
    };
    Ok(bound.port())
}

fn listen_error(endpoint: &str, cause: &std::io::Error) -> BusError {
    let endpoint = endpoint.to_owned();
    match cause.kind() {
        std::io::ErrorKind::AddrInUse => BusError::InUse { endpoint },
        _ => BusError::Listen {
            endpoint,
            cause: cause.to_string(),
        },
    }
}

fn presence(sample: &zenoh::sample::Sample) -> Presence {
    let key = sample.key_expr().as_str().to_owned();
    match sample.kind() {
        zenoh::sample::SampleKind::Put => Presence::Joined(key),
        zenoh::sample::SampleKind::Delete => Presence::Left(key),
    }
}
