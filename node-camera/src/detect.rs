//! The detection part: borrows images, detects tags, solves their poses, publishes them, and publishes a status once a
//! second.

#[cfg(test)]
mod allocation_tests;
mod finder;
mod inspection;
mod models;
mod observe;
mod outbound;
mod statistics;
mod unread;

use std::thread;
use std::time::{Duration, Instant};

use anyhow::Context;
use sextant_apriltag::Image;
use sextant_iceoryx_images::{ImageHeader, ImageSubscriber, ImagesError, LentImage};
use sextant_process::host::host_name;
use sextant_process::{Exit, Shutdown, WithExit, fail_point, now_ns, watchdog};
use sextant_proto::{CameraStatus, DetectionReport, Keys, NodeId, NodeKind, Observations};
use sextant_zenoh_bus::{Bus, BusError, ControlProbe, HeldName, Latest, Publisher, Qos};

use self::finder::Finder;
use self::inspection::Inspection;
use self::models::SubscribedModels;
use self::observe::Draft;
use self::outbound::Outbound;
use self::statistics::Statistics;
use self::unread::UnreadTags;
use crate::config::CameraNodeConfig;
use crate::preview;
use crate::settings_files::SettingsFiles;

/// The longest sleep: how late a wish to stop is heard.
const LONGEST_WAIT: Duration = Duration::from_millis(100);
/// Between two statuses.
const STATUS_PERIOD: Duration = Duration::from_secs(1);
/// Between two looks for changes of the site's models and settings.
const MODELS_PERIOD: Duration = Duration::from_millis(200);

/// Detects until `shutdown`.
///
/// # Errors
/// A network or shared memory that can't be had.
pub(crate) fn run(config: &CameraNodeConfig, shutdown: &Shutdown) -> anyhow::Result<()> {
    let stop = || {
        watchdog::feed();
        shutdown.is_requested()
    };
    let security = config.protection().exit_with(Exit::Input)?;
    if let Some(words) = security.warning(now_ns() / 1_000_000_000) {
        tracing::warn!("{words}");
    }
    let bus = match Bus::open_unless(&config.network, &security, &stop) {
        Err(BusError::Abandoned { .. }) => return Ok(()),
        opened => opened.exit_with(Exit::Unavailable)?,
    };
    // Before anything is published: another process may have this camera's name.
    let Some(mut name) = hold_name(config, &bus, shutdown)? else {
        return Ok(());
    };
    let result = thread::scope(|scope| {
        let preview = preview::start(scope, config, &bus, shutdown)?;
        let result = detect_all(config, &bus, &mut name, shutdown);
        // Whatever ends detection ends the preview.
        shutdown.request();
        if preview.is_some_and(|thread| thread.join().is_err()) {
            tracing::error!("the preview's thread panicked");
        }
        result
    });
    drop(name);
    bus.close();
    result
}

fn detect_all(
    config: &CameraNodeConfig,
    bus: &Bus,
    name: &mut HeldName,
    shutdown: &Shutdown,
) -> anyhow::Result<()> {
    let stop = || shutdown.is_requested();
    let (place, camera) = (&config.shared_memory, config.camera.as_str());
    let mut images = match ImageSubscriber::open_unless(place, camera, &stop) {
        Err(ImagesError::Abandoned { .. }) => return Ok(()),
        opened => opened.exit_with(Exit::Unavailable)?,
    };
    let mut part = DetectPart::new(config, bus)?;
    let alive = alive_token(config, bus)?;
    let mut probe = ControlProbe::new(&config.holders()?, Instant::now());
    tracing::info!(camera = %config.camera, "detecting");
    while !shutdown.is_requested() {
        fail_point!("detect");
        // Ends this process where the network is half dead: it is started again, and capture keeps the camera
        // meanwhile.
        probe
            .check(bus, Instant::now())
            .exit_with(Exit::Unavailable)?;
        watchdog::feed();
        let wait = part.outbound.wait_at_most(LONGEST_WAIT, now_ns());
        if let Some(image) = images.wait(wait).exit_with(Exit::Unavailable)? {
            part.take(&image)?;
        }
        part.publish_arrived()?;
        part.update_models_if_due(bus);
        part.report_if_due(name)?;
    }
    part.report(name)?;
    drop(alive);
    Ok(())
}

fn alive_token(
    config: &CameraNodeConfig,
    bus: &Bus,
) -> anyhow::Result<sextant_zenoh_bus::AliveToken> {
    let key = Keys::for_site(config.site.clone())
        .alive(NodeKind::Camera, &NodeId::new(config.camera.as_str())?);
    Ok(bus.alive(&key)?)
}

/// The camera's name, of which there is one at a site; none when the process shall end before it is free.
fn hold_name(
    config: &CameraNodeConfig,
    bus: &Bus,
    shutdown: &Shutdown,
) -> anyhow::Result<Option<HeldName>> {
    let id = NodeId::new(config.camera.as_str())?;
    let key = Keys::for_site(config.site.clone()).holder(NodeKind::Camera, &id);
    bus.hold_name(&key, &host_name(), &|| shutdown.is_requested())
        .exit_with(Exit::Unavailable)
}

struct DetectPart {
    finder: Finder,
    unread: UnreadTags,
    inspection: Inspection,
    models: SubscribedModels,
    statistics: Statistics,
    draft: Draft,
    outbound: Outbound,
    observations: Publisher<Observations>,
    inspections: Publisher<DetectionReport>,
    status: Latest<CameraStatus>,
    status_due: Instant,
    models_due: Instant,
}

impl DetectPart {
    fn new(config: &CameraNodeConfig, bus: &Bus) -> anyhow::Result<Self> {
        let keys = Keys::for_site(config.site.clone());
        let camera = &config.camera;
        Ok(Self {
            finder: Finder::new(&config.detection)
                .context("detection")
                .exit_with(Exit::Input)?,
            unread: UnreadTags::new(config.detection.options()),
            inspection: Inspection::new(),
            models: SubscribedModels::watch(bus, &keys, config, SettingsFiles::new(config)?)?,
            statistics: Statistics::new(camera.clone()),
            draft: Draft::new(camera.clone()),
            outbound: Outbound::for_source(&config.source, camera).exit_with(Exit::Input)?,
            observations: bus.publisher(&keys.observations(camera), Qos::Observation)?,
            inspections: bus.publisher(&keys.detection_report(camera), Qos::Status)?,
            status: bus.latest_publisher(&keys.camera_status(camera), Qos::Status)?,
            status_due: Instant::now(),
            models_due: Instant::now(),
        })
    }

    /// One image: detect, solve, publish, count.
    fn take(&mut self, lent: &LentImage<'_>) -> anyhow::Result<()> {
        let received_ns = now_ns();
        let header = *lent.header();
        self.statistics.image(&header);
        let (width, height, stride) = (
            header.width.into(),
            header.height.into(),
            header.stride as usize,
        );
        let image = match Image::new(lent.pixels(), width, height, stride) {
            Ok(image) => image,
            Err(cause) => {
                self.statistics.refuse(&cause.to_string());
                return Ok(());
            }
        };
        let is_inspected = self.inspection.is_due() && self.inspections.has_subscribers();
        let detections = if is_inspected {
            self.inspection.begin();
            self.finder.detect(&image, &mut self.inspection)
        } else {
            self.finder.detect(&image, &mut ())
        };
        let detecting_ns = now_ns().saturating_sub(received_ns);
        let n_tags = detections.len();
        let message = self.draft.write(&header, detections, &self.models);
        observe::stamp(message, &header, received_ns);
        self.statistics.detected(&image, detecting_ns);
        if self.outbound.passes(message, now_ns()) {
            publish(&self.observations, message, &mut self.statistics)?;
        }
        if is_inspected {
            self.tell_inspection(&header)?;
        }
        if let Some(words) = self.unread.look(&image, n_tags) {
            tracing::warn!("no tag can be used; {words}");
        }
        Ok(())
    }

    /// Diagnostics of the last detection, published while somebody subscribes.
    fn tell_inspection(&mut self, header: &ImageHeader) -> anyhow::Result<()> {
        let (report, searched) = (self.finder.report(), self.finder.searched());
        let camera = self.models.camera();
        let message = self.inspection.report(camera, header, report, searched);
        match self.inspections.put(&message) {
            Err(BusError::Message { cause, .. }) => self.statistics.refuse(&cause),
            result => result?,
        }
        Ok(())
    }

    /// What has come through a simulated network by now.
    fn publish_arrived(&mut self) -> anyhow::Result<()> {
        while let Some(message) = self.outbound.receive(now_ns()) {
            publish(&self.observations, &message, &mut self.statistics)?;
        }
        Ok(())
    }

    fn update_models_if_due(&mut self, bus: &Bus) {
        if Instant::now() >= self.models_due {
            self.models_due = Instant::now() + MODELS_PERIOD;
            self.models.update(bus);
        }
    }

    fn report_if_due(&mut self, name: &mut HeldName) -> anyhow::Result<()> {
        if Instant::now() < self.status_due {
            return Ok(());
        }
        self.status_due = Instant::now() + STATUS_PERIOD;
        self.report(name)
    }

    fn report(&mut self, name: &mut HeldName) -> anyhow::Result<()> {
        self.statistics.others = name.others().into_iter().map(str::to_owned).collect();
        let status = self.statistics.status(self.models.state());
        self.status.put(&status)?;
        Ok(())
    }
}

fn publish(
    publisher: &Publisher<Observations>,
    message: &Observations,
    statistics: &mut Statistics,
) -> anyhow::Result<()> {
    match publisher.put(message) {
        Ok(()) => statistics.published += 1,
        Err(BusError::Message { cause, .. }) => statistics.refuse(&cause),
        Err(other) => return Err(other.into()),
    }
    Ok(())
}
