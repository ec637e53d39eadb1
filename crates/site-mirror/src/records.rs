//! What is kept of a camera, an object and a node.

use crate::limits::{SILENCE_NS, silence_ns};
use sextant_proto::{
    CameraClock, CameraSettings, CameraStatus, FusionStatus, ObjectConfig, ObjectPose, Observations,
};
use sextant_site_model::ObjectId;
use std::collections::BTreeSet;

/// A message and its time of arrival.
#[derive(Debug, Clone, PartialEq)]
pub struct Heard<T> {
    /// The message.
    pub message: T,
    /// When it arrived, ns.
    pub at_ns: u64,
}

/// What was heard of a camera.
#[derive(Debug, Clone, Default)]
pub struct Camera {
    /// Newest status of its node.
    pub status: Option<Heard<CameraStatus>>,
    /// What the site wants of it.
    pub settings: Option<CameraSettings>,
    /// Width and height of its newest image, pixels.
    pub resolution: Option<[u32; 2]>,
    /// Newest capture time of its images, ns since the Unix epoch by its own clock.
    pub last_capture_ns: Option<u64>,
    /// When its last image arrived, ns.
    pub last_image_ns: Option<u64>,
}

impl Camera {
    pub(crate) fn handle_image(&mut self, image: &Observations, now_ns: u64) {
        self.resolution = Some(image.resolution.map(u32::from));
        self.last_capture_ns = self.last_capture_ns.max(Some(image.capture_ns));
        self.last_image_ns = Some(now_ns);
    }

    /// When its last status or image arrived, ns.
    #[must_use]
    pub fn heard_ns(&self) -> Option<u64> {
        self.last_image_ns
            .max(self.status.as_ref().map(|status| status.at_ns))
    }

    /// Whether no image arrived for too long for its rate, counted from `since_ns` before the first.
    #[must_use]
    pub fn lacks_images(&self, since_ns: u64, now_ns: u64) -> bool {
        let status = self.status.as_ref().map(|status| &status.message);
        // The rate in force where it is known: the one measured is 0 between the images of a slow camera.
        let rate_hz = status.map_or(0.0, |status| {
            let in_force = status.controls.rate_hz.value;
            in_force.unwrap_or(status.rate_hz.into())
        });
        let last_ns = self.last_image_ns.unwrap_or(since_ns);
        now_ns.saturating_sub(last_ns) > silence_ns(rate_hz)
    }
}

/// What was heard of an object.
#[derive(Debug, Clone, Default)]
pub struct Object {
    /// Its tags, links and joints; none before they were announced, or once it is gone.
    pub config: Option<ObjectConfig>,
    /// The newest pose.
    pub pose: Option<Heard<ObjectPose>>,
    /// Since when no fusion node has it any more, ns.
    pub gone_ns: Option<u64>,
    /// When its model was announced last, ns.
    pub(crate) announced_ns: Option<u64>,
}

impl Object {
    /// The newest pose, unless none arrived for [`SILENCE_NS`].
    #[must_use]
    pub fn recent_pose(&self, now_ns: u64) -> Option<&ObjectPose> {
        let pose = self.pose.as_ref()?;
        (now_ns.saturating_sub(pose.at_ns) <= SILENCE_NS).then_some(&pose.message)
    }
}

/// What a fusion node reports.
#[derive(Debug, Clone, Default)]
pub struct FusionNode {
    /// Its newest status.
    pub status: Option<Heard<FusionStatus>>,
    /// The clocks of cameras as it estimates them from the motion.
    pub clocks: Vec<CameraClock>,
    /// The objects of its status.
    pub(crate) objects: BTreeSet<ObjectId>,
}

/// Whether a node has a liveliness token.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Liveliness {
    /// None was seen: it is still on its way, or the node's messages are played from a recording.
    #[default]
    Unknown,
    /// It is there, since this time in ns.
    Alive(u64),
    /// It was there.
    Gone,
}

/// A process of the site.
#[derive(Debug, Clone, Copy, Default)]
pub struct Node {
    /// Its token.
    pub liveliness: Liveliness,
    /// When it joined or sent its last status, ns.
    pub heard_ns: Option<u64>,
}

impl Node {
    /// Whether it has been silent for too long. Of a viewer only the token is heard.
    #[must_use]
    pub fn is_silent(&self, now_ns: u64) -> bool {
        let heard_ns = self.heard_ns.unwrap_or(0);
        now_ns.saturating_sub(heard_ns) > SILENCE_NS
    }
}
