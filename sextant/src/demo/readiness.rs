//! Waits until every node of the demo is announced on the network and each camera has published an image.

use crate::demo::processes::Processes;
use anyhow::bail;
use sextant_process::Shutdown;
use sextant_process::shutdown::SHUTDOWN_POLL;
use sextant_proto::{KeyRef, Keys, NodeKind, limits};
use sextant_site_model::CameraId;
use sextant_zenoh_bus::{Bus, DropRule, Presence};
use std::collections::BTreeSet;
use std::time::{Duration, Instant};

/// Longer than a start takes on a busy machine.
const PATIENCE: Duration = Duration::from_secs(60);

/// Returns when all nodes are ready or a stop is requested.
///
/// # Errors
/// When a child ends, or after a minute.
pub fn wait(
    bus: &Bus,
    keys: &Keys,
    cameras: &[CameraId],
    processes: &mut Processes,
    shutdown: &Shutdown,
) -> anyhow::Result<()> {
    let alive = bus.watch_alive(&keys.all_alive())?;
    let observations = bus.subscribe(
        &keys.all_observations(),
        256,
        DropRule::Oldest,
        limits::MAX_PAYLOAD_BYTES,
    )?;
    let mut missing = MissingParts::new(cameras);
    let deadline = Instant::now() + PATIENCE;
    while !missing.is_empty() && !shutdown.is_requested() {
        processes.check()?;
        if Instant::now() > deadline {
            bail!(
                "not ready after {} s: {}",
                PATIENCE.as_secs(),
                missing.names()
            );
        }
        if let Some(item) = observations.recv_timeout(SHUTDOWN_POLL) {
            missing.saw_image(keys, &item.key);
        }
        while let Some(Presence::Joined(key)) = alive.try_recv() {
            missing.saw_node(keys, &key);
        }
    }
    Ok(())
}

/// Names of the nodes that are still missing.
struct MissingParts {
    nodes: BTreeSet<NodeKind>,
    cameras: BTreeSet<CameraId>,
}

impl MissingParts {
    fn new(cameras: &[CameraId]) -> Self {
        Self {
            nodes: [NodeKind::Fusion, NodeKind::Viewer].into(),
            cameras: cameras.iter().cloned().collect(),
        }
    }

    fn saw_node(&mut self, keys: &Keys, key: &str) {
        if let Some(KeyRef::Alive(kind, _)) = keys.parse(key) {
            self.nodes.remove(&kind);
        }
    }

    fn saw_image(&mut self, keys: &Keys, key: &str) {
        if let Some(KeyRef::Observations(camera)) = keys.parse(key) {
            self.cameras.remove(&camera);
        }
    }

    fn is_empty(&self) -> bool {
        self.nodes.is_empty() && self.cameras.is_empty()
    }

    fn names(&self) -> String {
        let nodes = self.nodes.iter().map(|kind| kind.as_str().to_owned());
        let cameras = self
            .cameras
            .iter()
            .map(|camera| format!("images of camera {camera}"));
        nodes.chain(cameras).collect::<Vec<_>>().join(", ")
    }
}
