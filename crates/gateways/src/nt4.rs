//! Poses as values of NetworkTables 4, published at the server of a robot: `struct:Pose3d`, with the capture time as
//! the server's time.

use crate::pose_feed::{FeedCounts, Next, PoseReceiver, RateLimit};
use crate::relay::{self, HostAndPort, Relay};
use crate::report::Reporter;
use serde::Serialize;
use sextant_pose_streams::{
    NT4_PORT, NT4_PROTOCOL, NT4_SCHEMAS, nt4_pose, nt4_publish, nt4_raw, nt4_time_answer,
    nt4_time_request,
};
use sextant_process::now_ns;
use sextant_proto::ObjectPose;
use sextant_site_report::State;
use sextant_zenoh_bus::BusError;
use std::collections::BTreeMap;
use std::io::{self, ErrorKind};
use std::net::TcpStream;
use std::time::{Duration, Instant};
use tokio_tungstenite::tungstenite::client::IntoClientRequest;
use tokio_tungstenite::tungstenite::http::HeaderValue;
use tokio_tungstenite::tungstenite::http::header::SEC_WEBSOCKET_PROTOCOL;
use tokio_tungstenite::tungstenite::protocol::WebSocketConfig;
use tokio_tungstenite::tungstenite::{self, Message, WebSocket, client::client_with_config};

/// Interval of requests for the server's time.
const TIME_SYNC_PERIOD: Duration = Duration::from_secs(2);
/// The longest message that is read.
const MAX_READ_BYTES: usize = 64 << 10;

/// Publishes the poses of objects that are tracked.
#[derive(Debug)]
pub struct TablePublisher {
    prefix: String,
    relay: Relay<TableValue>,
    limit: RateLimit,
}

/// A pose for a topic.
#[derive(Debug)]
pub struct TableValue {
    topic: String,
    capture_ns: u64,
    pose: Vec<u8>,
}

/// Counts of a publisher.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize)]
pub struct TableCounts {
    /// Poses of the site.
    #[serde(flatten)]
    pub feed: FeedCounts,
    /// Poses handed to the server.
    pub sent: u64,
    /// Poses that gave way to newer ones while the server was slow or gone.
    pub unsent: u64,
    /// Poses held back by the rate limit.
    pub skipped: u64,
}

/// Why nothing can be published.
#[derive(Debug, thiserror::Error)]
pub enum TableError {
    /// What is no address of a server.
    #[error("write HOST or HOST:PORT, such as 10.12.34.2 or roborio-1234-frc.local")]
    Address,
    /// No connection, or its end; or the system gives no thread.
    #[error("{0}")]
    Connection(#[from] io::Error),
    /// Another protocol.
    #[error("it is no server of NetworkTables 4: {0}; look at the port")]
    Protocol(String),
    /// It does not answer.
    #[error("it does not answer")]
    Silent,
}

impl TablePublisher {
    /// Connects to a server, and publishes at most `rate_hz` poses a second of each object below `prefix`.
    ///
    /// # Errors
    /// See [`TableError`].
    pub fn start(
        server: &str,
        prefix: String,
        rate_hz: f64,
        reporter: Reporter,
    ) -> Result<Self, TableError> {
        let server = HostAndPort::parse(server, NT4_PORT).ok_or(TableError::Address)?;
        let name = format!("the server of NetworkTables at {server}");
        let open = move || TableConnection::open(&server);
        Ok(Self {
            prefix,
            relay: Relay::start(open()?, open, name, reporter)?,
            limit: RateLimit::new(rate_hz),
        })
    }

    /// Sends what waits, and counts.
    pub fn finish(self, feed: FeedCounts) -> TableCounts {
        let relayed = self.relay.finish();
        TableCounts {
            feed,
            sent: relayed.sent,
            unsent: relayed.unsent,
            skipped: self.limit.skipped,
        }
    }
}

impl PoseReceiver for TablePublisher {
    type Error = BusError;

    /// A prediction is no measurement: only tracked poses are published.
    fn take(&mut self, pose: &ObjectPose) -> Result<Next, BusError> {
        if pose.state == State::Tracking && self.limit.admits(&pose.object, Instant::now()) {
            let value = TableValue {
                topic: format!("{}/{}/pose", self.prefix, pose.object),
                capture_ns: pose.capture_ns,
                pose: nt4_pose(pose),
            };
            let length = value.topic.len() + value.pose.len();
            self.relay.put(value.topic.clone(), value, length);
        }
        Ok(Next::More)
    }
}

struct TableConnection {
    socket: WebSocket<TcpStream>,
    /// The server's clock minus ours.
    offset_us: i64,
    /// Numbers of topics that are announced.
    topics: BTreeMap<String, u32>,
    heard: Instant,
    look_due: Instant,
    ask_due: Instant,
}

impl TableConnection {
    fn open(server: &HostAndPort) -> Result<Self, TableError> {
        let tcp = server.dial()?;
        tcp.set_nodelay(true)?;
        tcp.set_read_timeout(Some(relay::CONNECT_TIMEOUT))?;
        tcp.set_write_timeout(Some(relay::CONNECT_TIMEOUT))?;
        let request = format!("ws://{server}/nt/sextant").into_client_request();
        let mut request = request.map_err(|_| TableError::Address)?;
        let protocol = HeaderValue::from_static(NT4_PROTOCOL);
        request
            .headers_mut()
            .insert(SEC_WEBSOCKET_PROTOCOL, protocol);
        let config = WebSocketConfig::default()
            .max_message_size(Some(MAX_READ_BYTES))
            .max_frame_size(Some(MAX_READ_BYTES));
        let (socket, _) = client_with_config(request, tcp, Some(config))
            .map_err(|cause| TableError::Protocol(cause.to_string()))?;
        let now = Instant::now();
        let mut connection = Self {
            socket,
            offset_us: 0,
            topics: BTreeMap::new(),
            heard: now,
            look_due: now + relay::POLL_PERIOD,
            ask_due: now + TIME_SYNC_PERIOD,
        };
        connection.learn_time()?;
        connection
            .socket
            .get_ref()
            .set_read_timeout(Some(relay::READ_TIMEOUT))?;
        for (name, fields) in NT4_SCHEMAS {
            let topic = format!("/.schema/struct:{name}");
            let number = connection.number(&topic, "structschema")?;
            let value = nt4_raw(number, connection.server_us(now_ns()), fields.as_bytes());
            connection.write(Message::binary(value))?;
        }
        Ok(connection)
    }

    /// Asks for the server's time until it has said it: no value has a time before.
    fn learn_time(&mut self) -> Result<(), TableError> {
        self.write(Message::binary(nt4_time_request(micros(now_ns()))))?;
        let end = Instant::now() + relay::CONNECT_TIMEOUT;
        while Instant::now() < end {
            if self.read()? {
                return Ok(());
            }
        }
        Err(TableError::Silent)
    }

    /// The number of a topic, which is announced if it is new.
    fn number(&mut self, topic: &str, kind: &str) -> Result<u32, TableError> {
        if let Some(number) = self.topics.get(topic) {
            return Ok(*number);
        }
        // The rate limit knows no more objects than a site may have.
        let number = self.topics.len() as u32 + 1;
        self.write(Message::text(nt4_publish(topic, kind, number)))?;
        self.topics.insert(topic.to_owned(), number);
        Ok(number)
    }

    fn server_us(&self, time_ns: u64) -> i64 {
        micros(time_ns).saturating_add(self.offset_us)
    }

    fn write(&mut self, message: Message) -> Result<(), TableError> {
        self.socket.send(message).map_err(ended)
    }

    /// Takes a message that has arrived; returns whether it was the server's time.
    fn read(&mut self) -> Result<bool, TableError> {
        let message = match self.socket.read() {
            Ok(message) => message,
            Err(tungstenite::Error::Io(cause)) if relay::is_later(&cause) => return Ok(false),
            Err(cause) => return Err(ended(cause)),
        };
        self.heard = Instant::now();
        let Message::Binary(bytes) = message else {
            return Ok(false);
        };
        let Some((server_us, asked_us)) = nt4_time_answer(&bytes) else {
            return Ok(false);
        };
        // The server has read its clock in the middle of the way there and back.
        let middle_us = asked_us.saturating_add(micros(now_ns()).saturating_sub(asked_us) / 2);
        self.offset_us = server_us.saturating_sub(middle_us);
        Ok(true)
    }
}

impl relay::Connection for TableConnection {
    type Message = TableValue;
    type Error = TableError;

    fn send(&mut self, value: &TableValue) -> Result<(), TableError> {
        let number = self.number(&value.topic, "struct:Pose3d")?;
        let message = nt4_raw(number, self.server_us(value.capture_ns), &value.pose);
        self.write(Message::binary(message))
    }

    fn turn(&mut self) -> Result<(), TableError> {
        let now = Instant::now();
        if now >= self.ask_due {
            self.ask_due = now + TIME_SYNC_PERIOD;
            self.write(Message::binary(nt4_time_request(micros(now_ns()))))?;
        }
        if now >= self.look_due {
            self.look_due = now + relay::POLL_PERIOD;
            // A few at a look: a server says little to a client that subscribes to nothing.
            for _ in 0..16 {
                let before = self.heard;
                self.read()?;
                if self.heard == before {
                    break;
                }
            }
        }
        match self.heard.elapsed() < relay::SERVER_SILENCE {
            true => Ok(()),
            false => Err(TableError::Silent),
        }
    }

    fn end(mut self) -> Result<(), TableError> {
        self.socket.close(None).map_err(ended)?;
        let _ = self.socket.flush();
        Ok(())
    }
}

fn ended(cause: tungstenite::Error) -> TableError {
    match cause {
        tungstenite::Error::Io(cause) => TableError::Connection(cause),
        tungstenite::Error::ConnectionClosed | tungstenite::Error::AlreadyClosed => {
            TableError::Connection(ErrorKind::ConnectionReset.into())
        }
        cause => TableError::Protocol(cause.to_string()),
    }
}

fn micros(ns: u64) -> i64 {
    // Nanoseconds in 64 bits are fewer microseconds than fit 63.
    (ns / 1000) as i64
}
