//! Clock offsets of the cameras as a fusion node estimates them from the motion, about once a second.

use crate::check::{self, OutOfRange, holds};
use crate::envelope::{Message, MessageKind};
use crate::ids::NodeId;
use crate::limits::MAX_CAMERAS;
use crate::wire;
use serde::{Deserialize, Serialize};
use sextant_site_model::CameraId;

/// The cameras whose clock offset is estimated; the clocks of the others are accepted as they are.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ClockReport {
    /// The node; the same as in the key.
    pub node: NodeId,
    /// Ordered by id.
    #[serde(deserialize_with = "wire::list::at_most::<_, _, MAX_CAMERAS>")]
    pub cameras: Vec<CameraClock>,
}

/// One camera's clock against the reference clock.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct CameraClock {
    /// The camera.
    pub camera: CameraId,
    /// Seconds that the camera's stamps lie after the reference clock; already applied to the poses.
    pub offset_s: f64,
    /// One standard deviation, seconds.
    pub sigma_s: f64,
    /// How fast the offset grows, seconds a second (1e-6 is 1 ppm); none until it is known to better than 50 ppm.
    pub drift: Option<f64>,
}

impl Message for ClockReport {
    const KIND: MessageKind = MessageKind::ClockReport;

    fn check(&self) -> Result<(), OutOfRange> {
        holds(self.cameras.len() <= MAX_CAMERAS, "cameras")?;
        self.cameras.iter().try_for_each(CameraClock::check)
    }
}

impl CameraClock {
    fn check(&self) -> Result<(), OutOfRange> {
        check::finite(&[self.offset_s], "cameras[].offset_s")?;
        check::amount(self.sigma_s, "cameras[].sigma_s")?;
        check::finite(self.drift.as_slice(), "cameras[].drift")
    }
}
