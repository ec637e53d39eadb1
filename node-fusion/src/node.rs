//! The loop: messages in, poses and statuses out, until asked to stop.

use crate::config::FusionConfig;
use crate::intake::Intake;
use crate::outlet::Outlet;
use crate::status::StatusBook;
use anyhow::Context;
use sextant_estimator::{Fusion, FusionOptions, Input, ObjectModel, Output, Rig};
use sextant_process::{Exit, Shutdown, WithExit, memory, now_ns};
use sextant_proto::{Keys, NodeKind, limits};
use sextant_site_files::{read_object, read_rig, read_toml};
use sextant_zenoh_bus::{Bus, BusError, DropRule, Item, Payload, Subscription};
use std::path::Path;
use std::time::Duration;

/// Observations that wait while the machine works: two seconds of 64 cameras at 30 images a second; the oldest gives way.
const QUEUE: usize = 4096;
/// Between two statuses.
const STATUS_PERIOD_NS: u64 = 1_000_000_000;
/// The longest sleep: how late a wish to stop is heard.
const LONGEST_WAIT: Duration = Duration::from_millis(100);

/// Runs a fusion node until `shutdown`.
///
/// # Errors
/// [`Exit::Input`] for a wrong file, [`Exit::Unavailable`] when the network can't be had.
pub fn run(config_file: &Path, shutdown: &Shutdown) -> anyhow::Result<()> {
    memory::keep_heap_small();
    let config: FusionConfig = read_toml(config_file).exit_with(Exit::Input)?;
    let (rig, objects) = read_models(config_file, &config)?;
    let machine = Fusion::new(rig.clone(), objects.clone(), FusionOptions::default())
        .with_context(|| format!("{}: objects", config_file.display()))
        .exit_with(Exit::Input)?;
    let bus = match Bus::open_unless(&config.network, &|| shutdown.is_requested()) {
        Err(BusError::Abandoned { .. }) => return Ok(()),
        opened => opened.exit_with(Exit::Unavailable)?,
    };
    let mut node = FusionNode::open(&config, &bus, machine, &rig, &objects)?;
    let subscription = bus.subscribe(
        &node.keys.all_observations(),
        QUEUE,
        DropRule::Oldest,
        limits::MAX_PAYLOAD_BYTES,
    )?;
    let alive = bus.alive(&node.keys.alive(NodeKind::Fusion, &config.node))?;
    tracing::info!(
        cameras = rig.cameras().len(),
        objects = objects.len(),
        "fusing"
    );
    node.work(&subscription, shutdown)?;
    drop(alive);
    drop(subscription);
    drop(node);
    bus.close();
    Ok(())
}

fn read_models(
    config_file: &Path,
    config: &FusionConfig,
) -> anyhow::Result<(Rig, Vec<ObjectModel>)> {
    let folder = config_file.parent().unwrap_or(Path::new("."));
    let rig = read_rig(&folder.join(&config.rig)).exit_with(Exit::Input)?;
    let objects = config
        .objects
        .iter()
        .map(|file| read_object(&folder.join(file)).exit_with(Exit::Input));
    Ok((rig, objects.collect::<Result<_, _>>()?))
}

struct FusionNode {
    keys: Keys,
    machine: Fusion,
    intake: Intake,
    outlet: Outlet,
    status: StatusBook,
    status_due_ns: u64,
}

impl FusionNode {
    fn open(
        config: &FusionConfig,
        bus: &Bus,
        machine: Fusion,
        rig: &Rig,
        objects: &[ObjectModel],
    ) -> anyhow::Result<Self> {
        let keys = Keys::of(config.site.clone());
        let now = now_ns();
        Ok(Self {
            intake: Intake::new(
                keys.clone(),
                rig.cameras().iter().map(|camera| camera.id.clone()),
            ),
            outlet: Outlet::open(bus, &keys, &config.node, rig, objects)?,
            status: StatusBook::new(config.node.clone(), objects, now),
            status_due_ns: now,
            keys,
            machine,
        })
    }

    fn work(&mut self, subscription: &Subscription, shutdown: &Shutdown) -> anyhow::Result<()> {
        while !shutdown.is_requested() {
            if let Some(item) = subscription.recv_timeout(self.wait_at_most(now_ns())) {
                self.take(&item);
            }
            let now = now_ns();
            if self.machine.poll_timeout().is_some_and(|due| due <= now) {
                self.machine.handle(now, Input::Tick);
            }
            self.publish_poses()?;
            if now >= self.status_due_ns {
                self.status_due_ns = now + STATUS_PERIOD_NS;
                let status = self.status.status(&mut self.intake, &self.machine, now);
                self.outlet.status(&status)?;
            }
        }
        Ok(())
    }

    fn take(&mut self, item: &Item) {
        match &item.payload {
            Payload::Bytes(bytes) => {
                if let Some(image) = self.intake.take(&item.key, bytes) {
                    self.machine.handle(now_ns(), Input::Image(image));
                }
            }
            Payload::TooLong(_) => self.intake.count_too_long(&item.key),
        }
    }

    fn publish_poses(&mut self) -> anyhow::Result<()> {
        while let Some(output) = self.machine.poll_output() {
            match output {
                Output::Pose(estimate) => {
                    self.outlet.pose(&estimate, now_ns())?;
                    self.status.count(&estimate);
                }
                other => tracing::warn!(?other, "the estimator says"),
            }
        }
        Ok(())
    }

    fn wait_at_most(&self, now: u64) -> Duration {
        let due = self
            .machine
            .poll_timeout()
            .unwrap_or(u64::MAX)
            .min(self.status_due_ns);
        Duration::from_nanos(due.saturating_sub(now)).min(LONGEST_WAIT)
    }
}
