//! Where an object is: the estimate that the system exists for, and the simulator's truth beside it.

use crate::check::{self, OutOfRange, holds};
use crate::envelope::{Message, MessageKind};
use crate::wire;
use serde::{Deserialize, Serialize};
use sextant_site_model::ObjectId;
use sextant_site_report::State;

/// `world_from_object` at one capture time, with covariance and motion.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ObjectPose {
    /// The object; the same as in the key.
    pub object: ObjectId,
    /// Of the fusion node that published it, greater than those of all before it: [`crate::EpochFilter`].
    pub epoch: u64,
    /// Number of this pose since the fusion node started, per object; gaps within an epoch are messages that the
    /// network lost.
    pub sequence: u64,
    /// The instant that the pose is for: middle of the exposure, ns since the Unix epoch.
    pub capture_ns: u64,
    /// When the fusion node handed it to the network, ns since the Unix epoch by the fusion node's clock.
    pub published_ns: u64,
    /// How sure the estimator is that this is the object; on the wire the number of the variant, from 0.
    pub state: State,
    /// The object's origin in the world, metres.
    pub position: [f64; 3],
    /// The object's axes in the world, x, y, z, w.
    pub orientation: [f64; 4],
    /// 6x6 row-major over (x, y, z, rx, ry, rz) in world axes, left perturbation about the object's origin; m, rad.
    #[serde(with = "wire::array")]
    pub covariance: [f64; 36],
    /// Velocity of the object's origin and angular velocity, world axes; m/s, rad/s.
    pub twist: [f64; 6],
    /// Cameras that saw the object at or shortly before this instant.
    pub cameras: u16,
    /// Tags that entered the estimate.
    pub tags: u16,
    /// Root mean square reprojection error of the corners that entered, pixels.
    pub rms_px: f32,
}

impl Message for ObjectPose {
    const KIND: MessageKind = MessageKind::ObjectPose;

    fn check(&self) -> Result<(), OutOfRange> {
        check::time(self.capture_ns, "capture_ns")?;
        check::time(self.published_ns, "published_ns")?;
        check::position(self.position, "position")?;
        check::orientation(self.orientation, "orientation")?;
        check::finite(&self.covariance, "covariance")?;
        let variances = self.covariance.iter().step_by(7);
        holds(variances.into_iter().all(|v| *v >= 0.0), "covariance")?;
        check::finite(&self.twist, "twist")?;
        check::amount(f64::from(self.rms_px), "rms_px")
    }
}

/// Where a simulated object truly was, and how far the published pose of that instant was off.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ObjectTruth {
    /// The object; the same as in the key.
    pub object: ObjectId,
    /// The instant, ns since the Unix epoch.
    pub capture_ns: u64,
    /// The object's origin in the world, metres.
    pub position: [f64; 3],
    /// The object's axes in the world, x, y, z, w.
    pub orientation: [f64; 4],
    /// Distance between the estimated and the true origin, metres.
    pub position_error_m: f64,
    /// Angle between the estimated and the true attitude, radians.
    pub attitude_error_rad: f64,
}

impl Message for ObjectTruth {
    const KIND: MessageKind = MessageKind::ObjectTruth;

    fn check(&self) -> Result<(), OutOfRange> {
        check::time(self.capture_ns, "capture_ns")?;
        check::position(self.position, "position")?;
        check::orientation(self.orientation, "orientation")?;
        check::amount(self.position_error_m, "position_error_m")?;
        check::amount(self.attitude_error_rad, "attitude_error_rad")
    }
}
