//! Messages that tests publish.

use sextant_proto::ObjectPose;
use sextant_site_model::ObjectId;
use sextant_site_report::State;

/// A pose of an object that is tracked.
pub fn pose(object: &ObjectId, sequence: u64) -> ObjectPose {
    ObjectPose {
        object: object.clone(),
        epoch: 1,
        sequence,
        capture_ns: 1,
        published_ns: 2,
        state: State::Tracking,
        position: [1.0, 2.0, 3.0],
        orientation: [0.0, 0.0, 0.0, 1.0],
        covariance: [0.0; 36],
        twist: [0.0; 6],
        cameras: 1,
        tags: 1,
        rms_px: 0.1,
    }
}
