//! A site's poses, detections, lenses and pictures as ROS 2 topics, by the protocol of rmw_zenoh.
//!
//! Two sessions: one on the site's router, as every tool has, and one on the router of ROS, of which this program is a
//! client, since that router does not forward between peers. What becomes which message is `sextant-ros2`'s.

mod publishers;

use crate::report::{Notice, Reporter};
use crate::site::{ModelWatch, RouterWatch, SiteSession};
use publishers::Publishers;
use serde::Serialize;
use sextant_process::shutdown::SHUTDOWN_POLL;
use sextant_process::{Shutdown, now_ns};
use sextant_proto::limits;
use sextant_ros2::{Bridge, BridgeOptions, Graph, Topic};
use sextant_zenoh_bus::{
    Bus, BusError, BusOptions, Item, Profile, Security, StreamBounds, why_no_router,
};
use std::cell::Cell;
use std::io;
use std::time::{Duration, Instant};

/// Messages of the site that wait while the router of ROS is slow; the oldest give way.
const WAITING: StreamBounds = StreamBounds {
    items: 4096,
    bytes: 16 << 20,
    wait: Duration::from_millis(500),
};
/// Period of `/diagnostics`.
const DIAGNOSTICS: Duration = Duration::from_secs(1);
/// Time without a router of ROS before it is reported.
const HICCUP: Duration = Duration::from_secs(1);

/// Opens a session on the router of ROS at `endpoint`; waits for it, and reports that.
///
/// # Errors
/// [`BusError::Abandoned`] after a request to stop; an endpoint that is none.
pub fn connect(endpoint: &str, shutdown: &Shutdown, reporter: &Reporter) -> Result<Bus, BusError> {
    let options = BusOptions::client_of(endpoint);
    let security = Security::none(Profile::Open);
    let (start, is_reported) = (Instant::now(), Cell::new(false));
    let wait = || {
        if start.elapsed() >= HICCUP && !is_reported.replace(true) {
            reporter.report(&Notice::NoRosRouter {
                endpoint: endpoint.to_owned(),
                cause: why_no_router(&options, &security),
            });
        }
        shutdown.is_requested()
    };
    Bus::open_unless(&options, &security, &wait)
}

/// Who learns of each topic when it is declared; an error ends the gateway.
pub type OnTopic<'a> = &'a mut dyn FnMut(&Topic) -> io::Result<()>;

/// Why a gateway to ROS ends.
#[derive(Debug, thiserror::Error)]
pub enum Ros2Error {
    /// One of the sessions is closed, or refuses a declaration.
    #[error(transparent)]
    Bus(#[from] BusError),
    /// The listener for topics failed.
    #[error("the topic cannot be announced")]
    Announcement(#[source] io::Error),
}

/// Counts of a gateway to ROS.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize)]
pub struct Ros2Counts {
    /// Messages handed to the network.
    pub published: u64,
    /// Messages refused by it.
    pub failed: u64,
    /// Messages of the site that were dropped unread.
    pub dropped: u64,
    /// Messages of the site that are invalid.
    pub invalid: u64,
    /// Messages beyond the rate limit.
    pub over_rate: u64,
    /// Messages of a fusion node that another one has replaced.
    pub superseded: u64,
    /// Messages whose topic is that of another object or camera.
    pub name_taken: u64,
}

/// Publishes what the site publishes, as the node `graph` on the router of ROS, until a request to stop. Closes both
/// sessions unless it fails.
///
/// # Errors
/// See [`Ros2Error`].
pub fn run(
    site: SiteSession,
    ros: Bus,
    graph: Graph,
    options: BridgeOptions,
    on_topic: OnTopic<'_>,
    reporter: &Reporter,
) -> Result<Ros2Counts, Ros2Error> {
    let mut relay = Relay {
        bridge: Bridge::new(options),
        publishers: Publishers::new(ros, graph, on_topic)?,
        reporter,
    };
    let dropped = relay.run(&site)?;
    let counts = relay.counts(dropped);
    relay.publishers.close();
    site.bus.close();
    Ok(counts)
}

/// Messages of the site on their way.
struct Relay<'a> {
    bridge: Bridge,
    publishers: Publishers<'a>,
    reporter: &'a Reporter,
}

impl Relay<'_> {
    /// Relays until a signal; returns how many messages of the site were dropped unread.
    fn run(&mut self, site: &SiteSession) -> Result<u64, Ros2Error> {
        let everything = site.keys.everything();
        let messages =
            site.bus
                .subscribe_stream(&everything, WAITING, limits::MAX_PAYLOAD_BYTES)?;
        let models = ModelWatch::open(site, site.keys.all_config())?;
        let mut router = RouterWatch::default();
        let mut diagnostics_due = Instant::now();
        while !site.shutdown.is_requested() {
            models.poll(site, |item| self.take(site, item))?;
            let message = messages.recv_timeout(SHUTDOWN_POLL);
            if let Some(item) = message.and_then(|item| models.admit(&site.keys, item)) {
                self.take(site, &item)?;
            }
            if Instant::now() >= diagnostics_due {
                diagnostics_due = Instant::now() + DIAGNOSTICS;
                self.publish_diagnostics(messages.counts().dropped)?;
                let notices = [router.notice(&site.bus), self.publishers.router_notice()];
                notices
                    .iter()
                    .flatten()
                    .for_each(|notice| self.reporter.report(notice));
            }
        }
        Ok(messages.counts().dropped)
    }

    fn take(&mut self, site: &SiteSession, item: &Item) -> Result<(), Ros2Error> {
        let (Some(key), now) = (site.keys.parse(&item.key), now_ns()) else {
            return Ok(());
        };
        let sender = item.sender.as_deref();
        let outgoing = self.bridge.handle(now, &key, sender, item.try_bytes());
        outgoing
            .into_iter()
            .try_for_each(|message| self.publishers.put(now, message))
    }

    fn publish_diagnostics(&mut self, dropped: u64) -> Result<(), Ros2Error> {
        let now = now_ns();
        let counts = self.publishers.counts();
        let own = [
            ("messages published", counts.published),
            ("messages not published", counts.failed),
            ("messages of the site dropped", dropped),
        ];
        let message = self.bridge.diagnostics(now, &own);
        self.publishers.put(now, message)
    }

    fn counts(&self, dropped: u64) -> Ros2Counts {
        let (ours, counts) = (self.publishers.counts(), self.bridge.counts());
        Ros2Counts {
            published: ours.published,
            failed: ours.failed,
            dropped,
            invalid: counts.invalid,
            over_rate: counts.over_rate,
            superseded: counts.superseded,
            name_taken: counts.name_taken,
        }
    }
}
