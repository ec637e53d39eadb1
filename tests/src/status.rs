//! Waits for a status of the fusion node.

use sextant_proto::FusionStatus;
use sextant_zenoh_bus::Subscription;
use std::time::{Duration, Instant};

/// A limit that only a broken build reaches.
pub const PATIENCE: Duration = Duration::from_secs(60);

/// The first status that is `wanted`.
///
/// # Errors
/// The last status, when no wanted one arrived in time.
pub(crate) fn first_status(
    statuses: &Subscription,
    wanted: impl Fn(&FusionStatus) -> bool,
) -> Result<FusionStatus, Option<Box<FusionStatus>>> {
    let deadline = Instant::now() + PATIENCE;
    let mut last = None;
    while Instant::now() < deadline {
        let item = statuses.recv_timeout(Duration::from_millis(200));
        let Some(Ok(status)) = item.map(|item| item.decode::<FusionStatus>()) else {
            continue;
        };
        if wanted(&status) {
            return Ok(status);
        }
        last = Some(Box::new(status));
    }
    Err(last)
}
