//! The bridge's place on the network: subscribes to the site, asks for what was said before it came, watches who is there.
//! Pictures, and what detectors did with them, are only asked for while somebody looks: cameras don't make them for nobody.

use crate::bridge::Shared;
use crate::intake::Intake;
use crate::wizard::Outgoing;
use sextant_process::{Exit, Shutdown, WithExit, fail_point};
use sextant_proto::{Keys, Message, NodeKind, limits};
use sextant_zenoh_bus::{AliveWatch, Bus, BusError, CallbackSubscription, Qos};
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};

/// How long to wait for those who answer for the site's configuration; shutdown waits no longer than this.
const QUERY_TIMEOUT: Duration = Duration::from_millis(800);
/// The longest sleep: how late a wish to stop is heard.
const LONGEST_WAIT: Duration = Duration::from_millis(100);
/// How long pictures keep coming after the last client left: a page that is loaded anew finds them running.
const PICTURES_KEPT: Duration = Duration::from_secs(10);
/// Between two looks at the connection.
const CHECK_PERIOD: Duration = Duration::from_secs(1);

/// Fills the hub from the network until `shutdown`. A client waits for its router for as long as it takes.
pub(crate) fn run(shared: &Arc<Shared>, shutdown: &Shutdown) -> anyhow::Result<()> {
    let bus = match Bus::open_unless(&shared.config.network, &|| shutdown.is_requested()) {
        Err(BusError::Abandoned { .. }) => return Ok(()),
        opened => opened.exit_with(Exit::Unavailable)?,
    };
    let keys = Keys::of(shared.config.site.clone());
    let intake = Arc::new(Intake::new(keys.clone(), Arc::clone(shared)));
    let streams = [
        keys.all_config(),
        keys.all_camera_statuses(),
        keys.all_fusion_statuses(),
        keys.all_config_answers(),
        keys.all_clocks(),
        keys.all_links(),
        keys.all_observations(),
        keys.all_poses(),
        keys.all_truths(),
    ];
    let streams = streams.map(|stream| subscribe(&bus, &stream, &intake));
    let streams: Vec<_> = streams.into_iter().collect::<Result<_, _>>()?;
    let watch = bus.watch_alive(&keys.all_alive())?;
    let alive = bus.alive(&keys.alive(NodeKind::Viewer, &shared.config.node))?;
    let mut attendance = Attendance {
        bus: &bus,
        keys,
        intake,
        shared,
        pictures: None,
        watched_at: Instant::now(),
    };
    attendance.keep(&watch, shutdown)?;
    drop(attendance);
    drop((alive, watch, streams));
    bus.close();
    Ok(())
}

fn subscribe(
    bus: &Bus,
    stream: &str,
    intake: &Arc<Intake>,
) -> Result<CallbackSubscription, BusError> {
    let intake = Arc::clone(intake);
    bus.subscribe_with(stream, limits::MAX_PAYLOAD_BYTES, move |item| {
        intake.take(&item);
    })
}

struct Attendance<'a> {
    bus: &'a Bus,
    keys: Keys,
    intake: Arc<Intake>,
    shared: &'a Shared,
    pictures: Option<[CallbackSubscription; 2]>,
    /// When somebody last looked at the page.
    watched_at: Instant,
}

impl Attendance<'_> {
    fn keep(&mut self, watch: &AliveWatch, shutdown: &Shutdown) -> anyhow::Result<()> {
        let mut check_due = Instant::now();
        while !shutdown.is_requested() {
            fail_point!("network");
            if let Some(presence) = watch.recv_timeout(LONGEST_WAIT)
                && self.intake.presence(&presence) == Some(NodeKind::Fusion)
            {
                self.ask_for_latest()?;
            }
            self.ask_for_pictures()?;
            self.publish_change()?;
            if Instant::now() >= check_due {
                self.check_connection()?;
                check_due = Instant::now() + CHECK_PERIOD;
            }
        }
        Ok(())
    }

    /// What a person keeps of a wizard's result, or takes of a fusion node's offer, under the name of this bridge.
    fn publish_change(&self) -> anyhow::Result<()> {
        while let Some(outgoing) = self.shared.wizard.take_outgoing() {
            match outgoing {
                Outgoing::Rig(rig) => self.publish(&self.keys.full_rig(), &rig)?,
                Outgoing::Object(object) => {
                    self.publish(&self.keys.full_object(&object.id), &object)?;
                }
            }
        }
        Ok(())
    }

    fn publish<M: Message>(&self, key: &str, message: &M) -> anyhow::Result<()> {
        let signature = format!("viewer/{}", self.shared.config.node);
        let publisher = self.bus.publisher::<M>(key, Qos::Config)?;
        Ok(publisher.signed(&signature).put(message)?)
    }

    fn ask_for_pictures(&mut self) -> anyhow::Result<()> {
        let (n_clients, _) = self.shared.hub.counts();
        if n_clients > 0 {
            self.watched_at = Instant::now();
            if self.pictures.is_none() {
                let subscribed = |stream: String| subscribe(self.bus, &stream, &self.intake);
                self.pictures = Some([
                    subscribed(self.keys.all_previews())?,
                    subscribed(self.keys.all_detection_reports())?,
                ]);
            }
        } else if self.watched_at.elapsed() > PICTURES_KEPT {
            self.pictures = None;
        }
        Ok(())
    }

    /// Back on the network, the bridge may have missed what is said only once.
    fn check_connection(&self) -> anyhow::Result<()> {
        let now = self.bus.is_connected();
        let before = self.shared.connected.swap(now, Ordering::Relaxed);
        if now && !before {
            self.ask_for_latest()?;
        } else if before && !now {
            tracing::warn!("the connection to the site's network is lost; waiting for it");
        }
        Ok(())
    }

    fn ask_for_latest(&self) -> anyhow::Result<()> {
        let everything = self.keys.everything();
        let items = self
            .bus
            .latest(&everything, limits::MAX_PAYLOAD_BYTES, QUERY_TIMEOUT)?;
        items.iter().for_each(|item| self.intake.take(item));
        Ok(())
    }
}
