//! `sextant foxglove`: a running site for Foxglove and Lichtblick, over a WebSocket. What becomes which message is
//! [`sextant_recordings::foxglove`]'s, as in recordings.

mod hub;
mod server;

use crate::listening::listen;
use crate::output::{Format, print_line};
use crate::site::{RouterWatch, Site, SiteArguments, is_request};
use clap::Args;
use hub::{Hub, Lifetime};
use sextant_process::now_ns;
use sextant_proto::{AnyMessage, Keys, limits};
use sextant_recordings::foxglove::layout::layout;
use sextant_site_mirror::{Rejection, SiteMirror};
use sextant_zenoh_bus::{CallbackSubscription, Item};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

/// Where viewers look for a server.
const PORT: u16 = 8765;
/// Longest delay until Ctrl-C has an effect.
const GLANCE: Duration = Duration::from_millis(100);
/// Timeout of the query for rig and objects.
const ANSWER: Duration = Duration::from_secs(1);
/// Previews are subscribed to for so long after the last client has left.
const PREVIEWS_KEPT: Duration = Duration::from_secs(5);

/// Arguments of `sextant foxglove`.
#[derive(Args, Debug)]
#[command(
    after_help = "In Foxglove or Lichtblick: Open connection, Foxglove WebSocket, ws://127.0.0.1:8765. A layout for this site:
  sextant foxglove --print-layout > sextant.json
and import it there. Topics are those of recordings; docs/foxglove.md lists them. The protocol knows no passwords: whoever reaches the address
can watch the site. With --json, one line at the end: {\"clients\",\"sent\",\"dropped\",\"invalid\",\"turned_away\"}. Stop with Ctrl-C."
)]
pub struct FoxgloveArguments {
    /// Address of the server.
    #[arg(long, value_name = "HOST:PORT", default_value = "127.0.0.1:8765")]
    listen: String,
    /// Print a layout with the site's cameras and objects, and end.
    #[arg(long)]
    print_layout: bool,
    #[command(flatten)]
    site: SiteArguments,
}

/// Runs `sextant foxglove`.
///
/// # Errors
/// An address that is none or in use, no router.
pub fn run(arguments: &FoxgloveArguments, format: Format) -> anyhow::Result<()> {
    if arguments.print_layout {
        return print_layout(arguments.site.open()?);
    }
    let listener = listen(&arguments.listen, PORT)?;
    let address = listener.local_addr()?;
    let site = arguments.site.open()?;
    let hub = Arc::new(Hub::new(site.keys.site()));
    let runtime = server::start(listener, Arc::clone(&hub))?;
    eprintln!("serving ws://{address} for Foxglove and Lichtblick; Ctrl-C ends it");
    let intake = Intake {
        keys: site.keys.clone(),
        hub: Arc::clone(&hub),
        mirror: Mutex::default(),
    };
    let relayed = Relay::start(&site, Arc::new(intake))?.run();
    runtime.shutdown_background();
    site.bus.close();
    relayed?;
    let counts = hub.counts();
    match format {
        Format::Json => print_line(&serde_json::to_string(&counts)?)?,
        Format::Text => eprintln!("{counts}"),
    }
    Ok(())
}

fn print_layout(site: Site) -> anyhow::Result<()> {
    let keys = [site.keys.config_rig(), site.keys.all_config_objects()];
    let mirror = site.mirror(&keys)?;
    let cameras = mirror.rig().into_iter().flat_map(|rig| &rig.cameras);
    let cameras: Vec<_> = cameras.map(|camera| camera.id.clone()).collect();
    let objects: Vec<_> = mirror.configs().map(|object| object.id.clone()).collect();
    print_line(&serde_json::to_string_pretty(&layout(&cameras, &objects))?)?;
    site.bus.close();
    Ok(())
}

/// Messages of the site into the hub, on the network's threads.
struct Relay<'a> {
    site: &'a Site,
    intake: Arc<Intake>,
    _streams: Vec<CallbackSubscription>,
    /// Pictures take most of the bandwidth; they are fetched while a client is connected.
    previews: Option<CallbackSubscription>,
    watched_at: Instant,
}

impl<'a> Relay<'a> {
    fn start(site: &'a Site, intake: Arc<Intake>) -> anyhow::Result<Self> {
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
            _streams: streams.collect::<anyhow::Result<_>>()?,
            intake,
            previews: None,
            watched_at: Instant::now(),
        })
    }

    /// Until a signal.
    fn run(mut self) -> anyhow::Result<()> {
        let (mut router, mut was_connected) = (RouterWatch::default(), false);
        while !self.site.shutdown.wait(GLANCE) {
            let is_connected = self.site.bus.is_connected();
            if is_connected && !was_connected {
                self.take_models()?;
            }
            was_connected = is_connected;
            self.fetch_previews()?;
            router.say(&self.site.bus);
        }
        Ok(())
    }

    /// Rig and objects as the fusion nodes have them.
    fn take_models(&self) -> anyhow::Result<()> {
        let all = self.site.keys.all_config();
        let items = self
            .site
            .bus
            .latest(&all, limits::MAX_PAYLOAD_BYTES, ANSWER)?;
        items.iter().for_each(|item| self.intake.take(item));
        Ok(())
    }

    fn fetch_previews(&mut self) -> anyhow::Result<()> {
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

fn subscribe(site: &Site, intake: &Arc<Intake>, key: &str) -> anyhow::Result<CallbackSubscription> {
    let intake = Arc::clone(intake);
    let take = move |item: Item| {
        if !is_request(&intake.keys, &item) {
            intake.take(&item);
        }
    };
    Ok(site
        .bus
        .subscribe_with(key, limits::MAX_PAYLOAD_BYTES, take)?)
}

/// What is done with each message of the site, in any thread.
struct Intake {
    keys: Keys,
    hub: Arc<Hub>,
    mirror: Mutex<SiteMirror>,
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
