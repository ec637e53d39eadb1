//! Counts of what came in and what became of it.

use std::collections::BTreeMap;

use sextant_site_model::CameraId;

/// Counts of one camera since the start.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct CameraStatistics {
    /// Images taken in.
    pub images: u64,
    /// Images that came a second time, or within 2 ms of another one.
    pub duplicates: u64,
    /// Images older than the window, or than what is known already.
    pub late: u64,
    /// Images whose capture time lies ahead of the present.
    pub ahead: u64,
    /// Images of another size than the rig says.
    pub other_size: u64,
    /// Tags that belong to no object.
    pub unknown_tags: u64,
    /// Tags with a corner that is not finite, or far outside of the image.
    pub damaged_tags: u64,
    /// Tags that contradict the track and took no part.
    pub gated_tags: u64,
    /// Tag views that took part.
    pub used_tags: u64,
    /// Capture time of the newest image in ns.
    pub last_capture_ns: u64,
}

/// Counts since the start.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Statistics {
    /// Of each camera of the rig.
    pub cameras: BTreeMap<CameraId, CameraStatistics>,
    /// Images of cameras that the rig lacks.
    pub unknown_cameras: u64,
    /// Images of cameras whose pose is not known yet.
    pub uncalibrated_cameras: u64,
}
