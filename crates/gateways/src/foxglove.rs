//! A running site for Foxglove and Lichtblick, over a WebSocket. What becomes which message is
//! [`sextant_recordings::foxglove`]'s, as in recordings.

mod hub;
mod server;

pub use hub::HubCounts;

use crate::report::Reporter;
use crate::site::{ModelWatch, RouterWatch, SiteSession};
use hub::{Hub, Lifetime};
use sextant_process::now_ns;
use sextant_process::shutdown::SHUTDOWN_POLL;
use sextant_proto::{AnyMessage, Keys, SiteId, limits};
use sextant_site_mirror::{Rejection, SiteMirror};
use sextant_zenoh_bus::{BusError, CallbackSubscription, Item};
use std::io;
use std::net::TcpListener;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};
use tokio::runtime::Runtime;

/// Where viewers look for a server.
pub const PORT: u16 = 8765;
/// Previews are subscribed to for so long after the last client has left.
const PREVIEWS_KEPT: Duration = Duration::from_secs(5);

/// A WebSocket server for viewers.
#[derive(Debug)]
pub struct FoxgloveServer {
    hub: Arc<Hub>,
    runtime: Runtime,
    reporter: Reporter,
}

impl FoxgloveServer {
    /// Serves at a listener that does not block; `site` names the server. With a token, those who connect have to have
    /// it in the address: `ws://HOST:PORT/?token=TOKEN`. Any web page can have its visitor's browser connect to this
    /// machine.
    ///
    /// # Errors
    /// The system refuses threads or the listener.
    pub fn start(
        listener: TcpListener,
        site: &SiteId,
        token: Option<String>,
        reporter: Reporter,
    ) -> io::Result<Self> {
        let hub = Arc::new(Hub::new(site));
        let runtime = server::start(listener, Arc::clone(&hub), token, reporter.clone())?;
        Ok(Self {
            hub,
            runtime,
            reporter,
        })
    }

    /// Serves what the site publishes until a request to stop; returns what happened. Closes the session.
    ///
    /// # Errors
    /// A failed subscription or query.
    pub fn run(self, site: SiteSession) -> Result<HubCounts, BusError> {
        let relayed = self.relay(&site);
        self.runtime.shutdown_background();
        site.bus.close();
        relayed.map(|()| self.hub.counts())
    }

    fn relay(&self, site: &SiteSession) -> Result<(), BusError> {
        let intake = Intake {
            keys: site.keys.clone(),
            hub: Arc::clone(&self.hub),
            mirror: Mutex::default(),
            models: ModelWatch::open(site, site.keys.all_config())?,
        };
        Relay::start(site, Arc::new(intake))?.run(&self.reporter)
    }
}

/// Messages of the site into the hub, on the network's threads.
struct Relay<'a> {
    site: &'a SiteSession,
    intake: Arc<Intake>,
    _streams: Vec<CallbackSubscription>,
    /// Pictures take most of the bandwidth; they are fetched while a client is connected.
    previews: Option<CallbackSubscription>,
    watched_at: Instant,
}

impl<'a> Relay<'a> {
    fn start(site: &'a SiteSession, intake: Arc<Intake>) -> Result<Self, BusError> {
        let keys = &site.keys;
        let streams = [
            keys.all_config(),
            keys.all_poses(),
            keys.all_links(),
            keys.all_observations(),
            keys.all_camera_statuses(),
            keys.all_fusion_statuses(),
        ];
        let streams = streams.iter().map(|key| subscribe(site, &intake, key));
        Ok(Self {
            site,
            _streams: streams.collect::<Result<_, _>>()?,
            intake,
            previews: None,
            watched_at: Instant::now(),
        })
    }

    /// Until a signal.
    fn run(mut self, reporter: &Reporter) -> Result<(), BusError> {
        let mut router = RouterWatch::default();
        while !self.site.shutdown.wait(SHUTDOWN_POLL) {
            self.intake.models.poll(self.site, |item| {
                self.intake.take(item);
                Ok::<_, BusError>(())
            })?;
            self.fetch_previews()?;
            if let Some(notice) = router.notice(&self.site.bus) {
                reporter.report(&notice);
            }
        }
        Ok(())
    }

    fn fetch_previews(&mut self) -> Result<(), BusError> {
        if self.intake.hub.is_watched() {
            self.watched_at = Instant::now();
            if self.previews.is_none() {
                let key = self.site.keys.all_previews();
                self.previews = Some(subscribe(self.site, &self.intake, &key)?);
            }
        } else if self.watched_at.elapsed() > PREVIEWS_KEPT {
            self.previews = None;
        }
        Ok(())
    }
}

fn subscribe(
    site: &SiteSession,
    intake: &Arc<Intake>,
    key: &str,
) -> Result<CallbackSubscription, BusError> {
    let intake = Arc::clone(intake);
    let take = move |item: Item| {
        if let Some(item) = intake.models.admit(&intake.keys, item) {
            intake.take(&item);
        }
    };
    site.bus
        .subscribe_with(key, limits::MAX_PAYLOAD_BYTES, take)
}

/// What is done with each message of the site, in any thread.
struct Intake {
    keys: Keys,
    hub: Arc<Hub>,
    mirror: Mutex<SiteMirror>,
    models: ModelWatch,
}

impl Intake {
    fn take(&self, item: &Item) {
        let Some(key) = self.keys.parse(&item.key) else {
            return self.hub.count_invalid();
        };
        let (now, sender) = (now_ns(), item.sender.as_deref());
        let mut mirror = self.mirror.lock().unwrap_or_else(PoisonError::into_inner);
        let update = mirror.handle(now, &key, sender, item.try_bytes());
        drop(mirror);
        let message = match update {
            Ok(update) => update.message,
            // Of a fusion node that another has taken over from.
            Err(Rejection::Superseded) => return,
            Err(_) => return self.hub.count_invalid(),
        };
        let lifetime = match message {
            AnyMessage::RigConfig(_) | AnyMessage::ObjectConfig(_) => Lifetime::UntilReplaced,
            _ => Lifetime::Passing,
        };
        if lifetime == Lifetime::UntilReplaced || self.hub.is_watched() {
            for shown in sextant_recordings::foxglove::messages(&message, now) {
                self.hub.publish(&shown, now, lifetime);
            }
        }
    }
}
