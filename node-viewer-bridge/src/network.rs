//! The bridge's network session: subscribes to the site, queries kept messages, watches which nodes are alive. Previews
//! and detection reports are subscribed to only while a client is connected, because cameras make them only for
//! subscribers.

use crate::camera_network;
use crate::changes::Outgoing;
use crate::forwarder::Forwarder;
use crate::shared::Shared;
use anyhow::anyhow;
use sextant_process::{Exit, Shutdown, WithExit, fail_point, monotonic_ns};
use sextant_proto::{Keys, Message, NodeKind, limits};
use sextant_zenoh_bus::{
    AliveWatch, Bus, BusError, CallbackSubscription, ControlProbe, Qos, RawPublisher,
};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::{Duration, Instant};

/// How long to wait for those who answer for the site's configuration; shutdown waits no longer than this.
const QUERY_TIMEOUT: Duration = Duration::from_millis(800);
/// Longest sleep: bounds the delay of a shutdown.
const LONGEST_WAIT: Duration = Duration::from_millis(100);
/// How long pictures keep coming after the last client left: a page that is loaded anew finds them running.
const PICTURES_KEPT: Duration = Duration::from_secs(10);
/// Between two checks of the connection.
const CHECK_PERIOD: Duration = Duration::from_secs(1);

/// Fills the hub from the network until `shutdown`. A client waits for its router for as long as it takes. A session in
/// which nothing is answered any more is replaced by a new one; clients of the page notice nothing of it.
pub(crate) fn run(shared: &Arc<Shared>, shutdown: &Shutdown) -> anyhow::Result<()> {
    while let Err(error) = run_session(shared, shutdown) {
        match error.downcast_ref::<BusError>() {
            Some(silent @ BusError::Silent { .. }) => tracing::error!("{silent}: opening one"),
            _ => return Err(error),
        }
        shared.connected.store(false, Ordering::Relaxed);
    }
    Ok(())
}

fn run_session(shared: &Arc<Shared>, shutdown: &Shutdown) -> anyhow::Result<()> {
    let stop = || {
        shared.note_network_turn();
        shutdown.is_requested()
    };
    let bus = match Bus::open_unless(&shared.config.network, &shared.protection.network, &stop) {
        Err(BusError::Abandoned { .. }) => return Ok(()),
        opened => opened.exit_with(Exit::Unavailable)?,
    };
    let keys = Keys::for_site(shared.config.site.clone());
    let forwarder = Arc::new(Forwarder::new(keys.clone(), Arc::clone(shared)));
    let streams = [
        keys.all_config(),
        keys.all_camera_statuses(),
        keys.all_fusion_statuses(),
        keys.all_config_answers(),
        keys.all_proposals(),
        keys.all_formers(),
        keys.all_clocks(),
        keys.all_inputs(),
        keys.all_links(),
        keys.all_observations(),
        keys.all_poses(),
        keys.all_truths(),
    ];
    let streams = streams.map(|stream| subscribe(&bus, &stream, &forwarder));
    let streams: Vec<_> = streams.into_iter().collect::<Result<_, _>>()?;
    let watch = bus.watch_alive(&keys.all_alive())?;
    let alive = bus.alive(&keys.alive(NodeKind::Viewer, &shared.config.node))?;
    let mut session = NetworkSession {
        bus: &bus,
        keys,
        forwarder,
        shared,
        pictures: None,
        watched_at: Instant::now(),
    };
    let ended = with_web_cameras(shared, &bus, shutdown, |is_over| {
        session.keep(&watch, is_over)
    });
    drop(session);
    drop((alive, watch, streams));
    bus.close();
    ended
}

/// Runs `keep` beside the thread of browsers' cameras; either ends the other.
fn with_web_cameras(
    shared: &Shared,
    bus: &Bus,
    shutdown: &Shutdown,
    keep: impl FnOnce(&dyn Fn() -> bool) -> anyhow::Result<()>,
) -> anyhow::Result<()> {
    let over = AtomicBool::new(false);
    let is_over = || shutdown.is_requested() || over.load(Ordering::Relaxed);
    thread::scope(|scope| {
        let cameras = thread::Builder::new()
            .name("web cameras".into())
            .spawn_scoped(scope, || {
                let _ends = SetOnDrop(&over);
                camera_network::run(shared, bus, &is_over)
            })?;
        let ends = SetOnDrop(&over);
        let kept = keep(&is_over);
        drop(ends);
        let published = cameras
            .join()
            .map_err(|_| anyhow!("the thread of browsers' cameras panicked"))?;
        kept.and(published.map_err(anyhow::Error::from))
    })
}

/// Also set when its thread panics.
struct SetOnDrop<'a>(&'a AtomicBool);

impl Drop for SetOnDrop<'_> {
    fn drop(&mut self) {
        self.0.store(true, Ordering::Relaxed);
    }
}

fn subscribe(
    bus: &Bus,
    stream: &str,
    forwarder: &Arc<Forwarder>,
) -> Result<CallbackSubscription, BusError> {
    let forwarder = Arc::clone(forwarder);
    bus.subscribe_with(stream, limits::MAX_PAYLOAD_BYTES, move |item| {
        forwarder.receive(item);
    })
}

struct NetworkSession<'a> {
    bus: &'a Bus,
    keys: Keys,
    forwarder: Arc<Forwarder>,
    shared: &'a Shared,
    pictures: Option<[CallbackSubscription; 2]>,
    /// When a client was last connected.
    watched_at: Instant,
}

impl NetworkSession<'_> {
    fn keep(&mut self, watch: &AliveWatch, is_over: &dyn Fn() -> bool) -> anyhow::Result<()> {
        let events = self.keys.events(&self.shared.config.node);
        let events = self.bus.raw_publisher(&events, Qos::Config)?;
        let mut check_due = Instant::now();
        let mut probe = ControlProbe::new(&self.keys.all_alive(), check_due);
        while !is_over() {
            fail_point!("network");
            self.shared.note_network_turn();
            if let Some(presence) = watch.recv_timeout(LONGEST_WAIT) {
                self.forwarder.presence(&presence);
            }
            let is_due = self.forwarder.renewal().take_due(monotonic_ns());
            if is_due {
                self.ask_for_latest()?;
            }
            self.ask_for_pictures()?;
            self.publish_change()?;
            self.publish_events(&events)?;
            let now = Instant::now();
            probe.check(self.bus, now)?;
            if now >= check_due {
                self.check_connection();
                check_due = now + CHECK_PERIOD;
            }
        }
        Ok(())
    }

    /// What a person keeps of a wizard's result, or takes of a fusion node's offer, under the name of this bridge.
    fn publish_change(&self) -> anyhow::Result<()> {
        while let Some(outgoing) = self.shared.wizard.next_outgoing() {
            match outgoing {
                Outgoing::Rig(rig) => self.publish(&self.keys.config_rig(), &rig)?,
                Outgoing::Object(object) => {
                    self.publish(&self.keys.config_object(&object.id), &object)?;
                }
                Outgoing::Camera(settings) => {
                    self.publish(&self.keys.config_camera(&settings.camera), &settings)?;
                }
                Outgoing::Models(proposal) => {
                    self.publish(&self.keys.config_models(), &proposal)?;
                }
            }
            self.shared.wizard.note_published();
        }
        Ok(())
    }

    /// What happened in the zones, as JSON on the network and to the webhook.
    fn publish_events(&self, publisher: &RawPublisher) -> anyhow::Result<()> {
        while let Some(event) = self.shared.zones.take_event() {
            publisher.put(&serde_json::to_vec(&event)?)?;
            if let Some(webhook) = &self.shared.webhook {
                webhook.offer(event);
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
                let subscribed = |stream: String| subscribe(self.bus, &stream, &self.forwarder);
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

    fn check_connection(&self) {
        let now = self.bus.is_connected();
        self.forwarder.renewal().link(now);
        let before = self.shared.connected.swap(now, Ordering::Relaxed);
        if before && !now {
            tracing::warn!("the connection to the site's network is lost; waiting for it");
        }
    }

    fn ask_for_latest(&self) -> anyhow::Result<()> {
        let everything = self.keys.everything();
        let longest = limits::MAX_PAYLOAD_BYTES;
        let items = self.bus.latest(&everything, longest, QUERY_TIMEOUT);
        self.forwarder
            .answered(items.as_deref().unwrap_or_default());
        items?;
        Ok(())
    }
}
