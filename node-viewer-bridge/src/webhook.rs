//! Events to a program that speaks HTTP: each is POSTed as JSON to one address, in order.
//!
//! Drop rule: [`WAITING`] events wait at most, newer ones are dropped; one that is not taken in [`TRIES`] tries is
//! given up. Both are counted.

use crate::config::WebhookOptions;
use crate::http_client;
use crate::zones::Event;
use anyhow::{Context, bail};
use axum::body::Body;
use axum::http::{Request, StatusCode, Uri, header};
use serde::Serialize;
use sextant_proto::SiteId;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Mutex, PoisonError};
use std::time::Duration;
use tokio::sync::mpsc::{Receiver, Sender, channel};
use tokio::time::{sleep, timeout};

/// Events that wait at most.
const WAITING: usize = 64;
/// Tries for each event.
const TRIES: u32 = 5;
/// The pause after the first try; it doubles from try to try.
const FIRST_PAUSE: Duration = Duration::from_secs(1);
/// Longest duration of a try.
const PATIENCE: Duration = Duration::from_secs(5);

/// What became of events since the bridge started.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub(crate) struct WebhookCounts {
    pub(crate) delivered: u64,
    /// Given up after all tries.
    pub(crate) failed: u64,
    /// Not tried for want of room.
    pub(crate) dropped: u64,
}

/// The queue of one address.
pub(crate) struct Webhook {
    url: Uri,
    site: SiteId,
    first_pause: Duration,
    sender: Sender<Event>,
    receiver: Mutex<Option<Receiver<Event>>>,
    delivered: AtomicU64,
    failed: AtomicU64,
    dropped: AtomicU64,
}

/// What is POSTed.
#[derive(Serialize)]
struct Posted<'a> {
    site: &'a SiteId,
    #[serde(flatten)]
    event: &'a Event,
}

impl Webhook {
    pub(crate) fn new(options: &WebhookOptions, site: SiteId) -> Self {
        let (sender, receiver) = channel(WAITING);
        Self {
            url: options.url.uri().clone(),
            site,
            first_pause: FIRST_PAUSE,
            sender,
            receiver: Mutex::new(Some(receiver)),
            delivered: AtomicU64::new(0),
            failed: AtomicU64::new(0),
            dropped: AtomicU64::new(0),
        }
    }

    /// Queues an event; never waits.
    pub(crate) fn offer(&self, event: Event) {
        if self.sender.try_send(event).is_err() {
            self.dropped.fetch_add(1, Ordering::Relaxed);
        }
    }

    pub(crate) fn counts(&self) -> WebhookCounts {
        WebhookCounts {
            delivered: self.delivered.load(Ordering::Relaxed),
            failed: self.failed.load(Ordering::Relaxed),
            dropped: self.dropped.load(Ordering::Relaxed),
        }
    }

    /// Sends what is queued, for as long as the bridge runs. Runs once.
    pub(crate) async fn run(&self) {
        let receiver = self
            .receiver
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
            .take();
        let Some(mut receiver) = receiver else { return };
        while let Some(event) = receiver.recv().await {
            let count = match self.deliver(&event).await {
                Ok(()) => &self.delivered,
                Err(error) => {
                    tracing::warn!("event {} is not delivered: {error:#}", event.sequence);
                    &self.failed
                }
            };
            count.fetch_add(1, Ordering::Relaxed);
        }
    }

    async fn deliver(&self, event: &Event) -> anyhow::Result<()> {
        let site = &self.site;
        let json = serde_json::to_string(&Posted { site, event })?;
        let mut pause = self.first_pause;
        for _ in 1..TRIES {
            if self.post(&json).await.is_ok() {
                return Ok(());
            }
            sleep(pause).await;
            pause *= 2;
        }
        self.post(&json).await
    }

    async fn post(&self, json: &str) -> anyhow::Result<()> {
        timeout(PATIENCE, post(&self.url, json))
            .await
            .with_context(|| format!("{} does not answer", self.url))?
            .with_context(|| self.url.to_string())
    }
}

/// One try.
async fn post(url: &Uri, json: &str) -> anyhow::Result<()> {
    let path = url.path_and_query().map_or("/", |path| path.as_str());
    let request = Request::post(path).header(header::CONTENT_TYPE, "application/json");
    let answer = http_client::send(url, request, Body::from(json.to_owned())).await?;
    let status: StatusCode = answer.status();
    if status.is_success() {
        return Ok(());
    }
    bail!("answered {status}")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::zones::EventKind;
    use sextant_site_model::ObjectId;
    use std::io::{Read, Write};
    use std::net::TcpListener;

    fn event(sequence: u64) -> Event {
        Event {
            sequence,
            t_ns: 1,
            object: ObjectId::new("cube").unwrap(),
            kind: EventKind::Entered {
                zone: "dock".to_owned(),
            },
            position: [0.0; 3],
        }
    }

    fn webhook(address: std::net::SocketAddr) -> Webhook {
        let url = format!("http://{address}/hook?key=1").try_into().unwrap();
        let site = SiteId::new("demo").unwrap();
        Webhook {
            first_pause: Duration::ZERO,
            ..Webhook::new(&WebhookOptions { url }, site)
        }
    }

    /// Answers one request with a status and returns it; the whole of it is there once its JSON ends.
    fn answer(listener: &TcpListener, status: &str) -> String {
        let (mut stream, _) = listener.accept().unwrap();
        let mut request = Vec::new();
        let mut byte = [0];
        while !request.ends_with(b"]}") {
            stream.read_exact(&mut byte).unwrap();
            request.push(byte[0]);
        }
        let head = format!("HTTP/1.1 {status}\r\nContent-Length: 0\r\n\r\n");
        stream.write_all(head.as_bytes()).unwrap();
        String::from_utf8(request).unwrap()
    }

    #[test]
    fn an_event_is_posted_again_until_it_is_taken() {
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let hook = webhook(listener.local_addr().unwrap());
        let server = std::thread::spawn(move || {
            ["503 Busy", "204 No Content"].map(|status| answer(&listener, status))
        });
        let runtime = tokio::runtime::Builder::new_current_thread()
            .enable_all()
            .build()
            .unwrap();
        runtime.block_on(hook.deliver(&event(7))).unwrap();
        let [first, second] = server.join().unwrap();
        assert_eq!(first, second);
        assert!(
            first.starts_with("POST /hook?key=1 HTTP/1.1\r\n"),
            "{first}"
        );
        let (_, body) = first.split_once("\r\n\r\n").unwrap();
        let json: serde_json::Value = serde_json::from_str(body).unwrap();
        assert_eq!(json["site"], "demo");
        assert_eq!(
            (&json["event"], &json["zone"]),
            (&"entered".into(), &"dock".into())
        );
    }

    #[test]
    fn events_beyond_the_bound_are_dropped_and_counted() {
        let hook = webhook(([127, 0, 0, 1], 1).into());
        for sequence in 0..2 * WAITING as u64 {
            hook.offer(event(sequence));
        }
        assert_eq!(hook.counts().dropped, WAITING as u64);
    }
}
