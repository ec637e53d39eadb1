//! The JSON messages of `PROTOCOL.md`, as they are written. Knows no network and no client.

use serde::Serialize;
use sextant_process::now_ns;
use sextant_proto::{
    CameraStatus, ClockReport, DetectionReport, FusionStatus, NodeId, PoseConfig, SiteId,
};
use sextant_site_mirror::{Rejections, limits};
use sextant_site_model::{CameraId, JointId, ObjectId};
use sextant_site_report::State;
use sextant_tag_families::Family;

use crate::access::PageRole;
use crate::models::{ObjectTag, RigCamera};
use crate::webhook::WebhookCounts;

/// Counted up when a field changes its meaning or goes.
const PROTOCOL: u32 = 1;

/// A message to clients; borrows what it can. Those of zones and wizards are written where those are.
#[derive(Debug, Serialize)]
#[serde(tag = "type", rename_all = "snake_case")]
pub(crate) enum Message<'a> {
    Hello {
        site: &'a SiteId,
        version: &'static str,
        protocol: u32,
        now_ns: u64,
        silence: Silence,
        /// What the client may do.
        role: PageRole,
    },
    Rig {
        cameras: Vec<RigCamera<'a>>,
    },
    Object {
        id: &'a str,
        tags: Vec<ObjectTag>,
        #[serde(skip_serializing_if = "Option::is_none")]
        world_from_object: Option<PoseConfig>,
        version: String,
    },
    /// There is no such object any more.
    ObjectGone {
        id: &'a str,
    },
    Pose(Pose<'a>),
    Joints {
        object: &'a ObjectId,
        t_ns: u64,
        joints: Vec<Joint<'a>>,
    },
    Truth {
        object: &'a ObjectId,
        t_ns: u64,
        position: [f64; 3],
        orientation: [f64; 4],
        error_mm: f64,
        error_deg: f64,
    },
    Observations {
        camera: &'a CameraId,
        sequence: u64,
        t_ns: u64,
        received_ms: Option<f32>,
        detected_ms: Option<f32>,
        latency_ms: f32,
        resolution: [u16; 2],
        tags: Vec<TagOutline>,
    },
    CameraStatus(&'a CameraStatus),
    DetectionReport(&'a DetectionReport),
    FusionStatus(&'a FusionStatus),
    Clocks(&'a ClockReport),
    /// A refined calibration that may be put in force.
    Proposal(OfferedModels<'a>),
    /// What was in force before the last change.
    Former(OfferedModels<'a>),
    Alive {
        kind: &'a str,
        id: &'a NodeId,
        up: bool,
    },
    BridgeStatus {
        now_ns: u64,
        uptime_s: u64,
        network: bool,
        clients: usize,
        replaced: u64,
        rejected: Rejections,
        /// None without a webhook.
        webhook: Option<WebhookCounts>,
    },
}

impl<'a> Message<'a> {
    /// The first message of every connection.
    pub(crate) fn hello(site: &'a SiteId, role: PageRole) -> Self {
        Self::Hello {
            site,
            version: env!("CARGO_PKG_VERSION"),
            protocol: PROTOCOL,
            now_ns: now_ns(),
            silence: Silence {
                seconds: limits::SILENCE_NS as f64 * 1e-9,
                messages: limits::MISSED,
            },
            role,
        }
    }
}

/// When something is silent, for clients too.
#[derive(Debug, Serialize)]
pub(crate) struct Silence {
    /// Since it was last heard.
    pub(crate) seconds: f64,
    /// That many messages have to be missed where that takes longer.
    pub(crate) messages: u64,
}

/// Models that may be put in force; none of both where there is nothing.
#[derive(Debug, Serialize)]
pub(crate) struct OfferedModels<'a> {
    pub(crate) node: &'a NodeId,
    pub(crate) t_ns: u64,
    /// Whether the rig is among them.
    pub(crate) rig: bool,
    pub(crate) objects: Vec<ObjectId>,
    pub(crate) n_images: u32,
    pub(crate) before_px: f64,
    pub(crate) after_px: f64,
}

/// Where an object is.
#[derive(Debug, Serialize)]
pub(crate) struct Pose<'a> {
    pub(crate) object: &'a str,
    pub(crate) sequence: u64,
    pub(crate) t_ns: u64,
    pub(crate) position: [f64; 3],
    pub(crate) orientation: [f64; 4],
    pub(crate) covariance: &'a [f64],
    pub(crate) twist: [f64; 6],
    pub(crate) state: State,
    pub(crate) cameras: u16,
    pub(crate) tags: u16,
    pub(crate) rms_px: f32,
    pub(crate) latency_ms: f32,
}

/// A joint's value, rad or m.
#[derive(Debug, Serialize)]
pub(crate) struct Joint<'a> {
    pub(crate) joint: &'a JointId,
    pub(crate) value: f64,
    pub(crate) sigma: f64,
    pub(crate) velocity: f64,
}

/// A tag in an image.
#[derive(Debug, Serialize)]
pub(crate) struct TagOutline {
    pub(crate) family: Family,
    pub(crate) id: u32,
    pub(crate) hamming: u8,
    pub(crate) margin: f32,
    pub(crate) corners: [[f32; 2]; 4],
}
