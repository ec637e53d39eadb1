//! Which cameras the site sees, as their statuses arrive.

use sextant_gateways::site::SiteSession;
use sextant_process::Shutdown;
use sextant_process::shutdown::SHUTDOWN_POLL;
use sextant_proto::{CameraStatus, limits};
use sextant_site_model::CameraId;
use sextant_zenoh_bus::{BusError, DropRule};
use std::collections::{BTreeMap, BTreeSet};
use std::sync::{Mutex, PoisonError};
use std::time::Instant;

/// Statuses that may wait.
const QUEUE: usize = 256;

/// The last status of each camera of the fleet.
pub struct Health {
    cameras: BTreeSet<CameraId>,
    last: Mutex<BTreeMap<CameraId, (Instant, CameraStatus)>>,
}

impl Health {
    /// For these cameras, none of which has a status yet.
    pub fn new(cameras: BTreeSet<CameraId>) -> Self {
        Self {
            cameras,
            last: Mutex::default(),
        }
    }

    /// Collects statuses until `done`.
    ///
    /// # Errors
    /// When the network session has ended.
    pub fn collect(&self, site: &SiteSession, done: &Shutdown) -> Result<(), BusError> {
        let key = site.keys.all_camera_statuses();
        let statuses =
            site.bus
                .subscribe(&key, QUEUE, DropRule::Oldest, limits::MAX_PAYLOAD_BYTES)?;
        while !done.is_requested() {
            let Some(item) = statuses.recv_timeout(SHUTDOWN_POLL) else {
                continue;
            };
            if let Ok(status) = item.decode::<CameraStatus>()
                && self.cameras.contains(&status.camera)
            {
                let mut last = self.last.lock().unwrap_or_else(PoisonError::into_inner);
                last.insert(status.camera.clone(), (Instant::now(), status));
            }
        }
        Ok(())
    }

    /// The last status of a camera that came after `since`.
    pub fn after(&self, camera: &CameraId, since: Instant) -> Option<CameraStatus> {
        let last = self.last.lock().unwrap_or_else(PoisonError::into_inner);
        let (at, status) = last.get(camera)?;
        (*at > since).then(|| status.clone())
    }
}
