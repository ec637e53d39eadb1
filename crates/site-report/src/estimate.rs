//! What is known about an object at a capture time.

use nalgebra::{Matrix6, Vector6};
use serde::{Deserialize, Serialize};
use sextant_geometry::Pose;

use sextant_site_model::{JointId, LinkId, ObjectId, is_finite};

/// How far a pose can be trusted. On the wire the number of the variant, from 0, in this order.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum State {
    /// More than one attitude explains the images, or the one is known too vaguely.
    /// The covariance spans all that is possible.
    Initialising,
    /// One attitude explains the images, and the image of this time took part.
    Tracking,
    /// Predicted: the images of this time add nothing, older ones do.
    Coasting,
    /// Unseen for too long; said once, with the last prediction.
    Lost,
}

/// Pose of an object at a capture time.
#[derive(Debug, Clone, PartialEq)]
pub struct ObjectEstimate {
    /// Which object.
    pub object: ObjectId,
    /// The time for which the pose holds, in ns since the Unix epoch (reference clock).
    pub capture_ns: u64,
    /// Maps points of the object into the world.
    pub world_from_object: Pose,
    /// Over (x, y, z, rx, ry, rz) in m and rad, world axes, R_estimate = exp(r) R_true.
    pub covariance: Matrix6<f64>,
    /// Velocity of the object's origin (m/s) and angular velocity (rad/s), world axes.
    pub twist: Vector6<f64>,
    /// How far to trust it.
    pub state: State,
    /// Cameras that took part at this capture time.
    pub cameras: u32,
    /// Tag views that took part at this capture time.
    pub tags: u32,
    /// Root mean square of the corner residuals in pixels (over both axes), 0 when nothing took part.
    pub rms_px: f64,
    /// Links and joints; `None` where the object is rigid.
    pub articulated: Option<Box<ArticulatedEstimate>>,
}

/// Where the links of an object are, and its joints.
#[derive(Debug, Clone, PartialEq)]
pub struct ArticulatedEstimate {
    /// Every link, the base among them, in the order of the model.
    pub links: Vec<LinkEstimate>,
    /// Every joint that moves, in the order of the model.
    pub joints: Vec<JointEstimate>,
}

/// Pose of a link.
#[derive(Debug, Clone, PartialEq)]
pub struct LinkEstimate {
    /// Which link.
    pub link: LinkId,
    /// Maps points of the link into the world.
    pub world_from_link: Pose,
    /// As the object's, about the link's origin.
    pub covariance: Matrix6<f64>,
}

/// Value of a joint; rad or m.
#[derive(Debug, Clone, PartialEq)]
pub struct JointEstimate {
    /// Which joint.
    pub joint: JointId,
    /// Within its limits.
    pub value: f64,
    /// Of the value.
    pub variance: f64,
    /// Per second.
    pub velocity: f64,
    /// Of the velocity.
    pub velocity_variance: f64,
}

impl ArticulatedEstimate {
    fn is_finite(&self) -> bool {
        let link = |one: &LinkEstimate| {
            is_finite(&one.world_from_link) && one.covariance.iter().all(|x| x.is_finite())
        };
        let joint = |one: &JointEstimate| {
            let numbers = [one.value, one.variance, one.velocity, one.velocity_variance];
            numbers.iter().all(|x| x.is_finite())
        };
        self.links.iter().all(link) && self.joints.iter().all(joint)
    }
}

/// How far a camera's clock is off.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ClockOffset {
    /// Seconds that the camera's stamps lie after the reference clock.
    pub offset_s: f64,
    /// One sigma in seconds.
    pub sigma_s: f64,
}

impl ObjectEstimate {
    /// Whether every number of it is finite.
    #[must_use]
    pub fn is_finite(&self) -> bool {
        is_finite(&self.world_from_object)
            && self
                .covariance
                .iter()
                .chain(self.twist.iter())
                .chain([&self.rms_px])
                .all(|x| x.is_finite())
            && self.articulated.as_ref().is_none_or(|one| one.is_finite())
    }
}
