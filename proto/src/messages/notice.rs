//! What happened to a fusion node itself and to the messages that it takes in: neither a fault of the site nor an
//! imperfection of its files.

use crate::check::{self, OutOfRange, holds};
use crate::ids::NodeId;
use crate::limits::MAX_DETAIL_BYTES;
use crate::messages::refusal::Refusal;
use crate::wire;
use serde::{Deserialize, Serialize};
use sextant_site_model::CameraId;
use sextant_site_report::Severity;

/// Most cameras that a notice names.
pub const MAX_SLOW_CAMERAS: usize = 16;

/// Something that a person should know, and for how long it is shown.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Notice {
    /// A camera that used to send is silent while others send; shown until it sends.
    CameraSilent {
        /// The camera.
        camera: CameraId,
        /// For how long, s.
        silent_s: f64,
    },
    /// Observations of a camera were dropped because they arrived too late; shown for ten seconds after the last.
    LateObservations {
        /// The camera.
        camera: CameraId,
        /// Observations dropped since the node started.
        total: u64,
    },
    /// Observations were dropped, or poses not published, because the machine of the node is too slow or stood still;
    /// shown for ten seconds after the last.
    Overload {
        /// Observations and poses dropped since the last status.
        dropped: u64,
        /// Observations and poses dropped since the node started.
        total: u64,
    },
    /// Messages were not published because a value was out of range; shown for ten seconds after the last.
    Unpublished {
        /// Messages since the node started.
        total: u64,
        /// Cause of the last one, English text.
        detail: String,
    },
    /// The clock of the node's machine was set, and tracking began anew; shown for ten seconds.
    ClockStepped {
        /// By how much, s; negative where it was set back.
        by_s: f64,
    },
    /// A change of the configuration was refused; shown for a minute, or until one of the same key is accepted.
    ChangeRefused {
        /// The key below the site.
        key: String,
        /// Who asked for the change, where the publication says.
        sender: Option<String>,
        /// Why.
        refusal: Refusal,
    },
    /// Another fusion node of the same name runs; shown while it does.
    NameTaken {
        /// The machine that it runs on.
        host: String,
    },
    /// A refined calibration explains the images better; shown while it is proposed.
    RefinementProposed {
        /// Images held back from the refinement, which judge it.
        n_images: u32,
        /// Rms reprojection error of these by the models in force, px.
        before_px: f64,
        /// Rms reprojection error of these by the models proposed, px.
        after_px: f64,
    },
    /// A fusion node works from older models than another one; shown until it has taken them over. Where it should
    /// publish, it publishes all objects as lost meanwhile.
    OldModels {
        /// The node whose models are old.
        node: NodeId,
        /// The node that has newer ones.
        newer: NodeId,
    },
    /// The models in force are not in the node's files; shown until they are.
    NotKept {
        /// Why, English text.
        detail: String,
    },
    /// Changes that were made at a fusion node while the network was divided are not in force, as those of another node
    /// were more, or later; shown until the models in question are changed again.
    SetAside {
        /// The node at which they were made.
        node: NodeId,
        /// The node whose models are in force.
        by: NodeId,
        /// When the last of them was made, ns since the Unix epoch.
        t_ns: u64,
        /// What differs from what is in force, English text.
        detail: String,
    },
    /// Observations of cameras were dropped as too old because they left the camera's machine late; shown for ten
    /// seconds after the last.
    CamerasSlow {
        /// The cameras, at most 16.
        #[serde(deserialize_with = "wire::list::at_most::<_, _, MAX_SLOW_CAMERAS>")]
        cameras: Vec<CameraId>,
        /// Longest time from the capture to the publication, s.
        behind_s: f64,
    },
}

sextant_site_report::sentences! { Notice {
    Self::CameraSilent { camera, silent_s } =>
        "camera {camera} has sent nothing for {silent_s:.0} s",
        ": check its power and its network";
    Self::LateObservations { camera, total } =>
        "observations of camera {camera} arrive too late ({total} dropped since the start)",
        ": check its network and its clock";
    Self::Overload { dropped, total } =>
        "the fusion node's machine is too slow, or stood still: {dropped} observations dropped ({total} since the \
         start)",
        ": use fewer images a second, fewer cameras or a faster machine";
    Self::Unpublished { total, detail } =>
        "{total} messages not published since the start; last: {detail}",
        "";
    Self::ClockStepped { by_s } =>
        "the clock of this machine was set {way} by {seconds:.3} s: tracking begins anew",
        "",
        way = if *by_s < 0.0 { "back" } else { "forward" },
        seconds = by_s.abs();
    Self::ChangeRefused { key, sender: Some(sender), refusal } =>
        "change of {key} by {sender} refused: {refusal}",
        "";
    Self::ChangeRefused { key, sender: None, refusal } =>
        "change of {key} refused: {refusal}",
        "";
    Self::NameTaken { host } =>
        "another fusion node of this name runs on {host}",
        ": stop one of them";
    Self::RefinementProposed { n_images, before_px, after_px } =>
        "a refined calibration explains the images better ({before_px:.2} px to {after_px:.2} px on {n_images} \
         held-back images)",
        ": run `sextant config apply-refinement`";
    Self::OldModels { node, newer } =>
        "fusion node {node} has an older rig or objects than {newer} and publishes all objects as lost until it has \
         taken these over",
        ": check the network between the two; where {newer} is gone for good, set the rig again, the present one too \
         (`sextant config set rig RIG.toml`)";
    Self::NotKept { detail } =>
        "the rig and the objects in force are not in this node's files, which it would start from: {detail}",
        "";
    Self::SetAside { node, by, detail, .. } =>
        "a change that was made at fusion node {node} while the network was divided is set aside, those of {by} are in \
         force: {detail}",
        ": bring rig and objects back by `sextant config revert --to {node}`";
    Self::CamerasSlow { cameras, behind_s } =>
        "{noun} {names}: images leave the camera's machine up to {behind_s:.1} s after they were taken, too late",
        ": use fewer images a second, smaller ones or a faster machine",
        noun = if cameras.len() == 1 { "camera" } else { "cameras" },
        names = cameras.iter().map(CameraId::as_str).collect::<Vec<_>>().join(", ");
}}

impl Notice {
    /// Whether it calls for action.
    #[must_use]
    pub fn severity(&self) -> Severity {
        match self {
            Self::RefinementProposed { .. } | Self::ClockStepped { .. } => Severity::Information,
            Self::CameraSilent { .. }
            | Self::LateObservations { .. }
            | Self::Overload { .. }
            | Self::Unpublished { .. }
            | Self::ChangeRefused { .. }
            | Self::NameTaken { .. }
            | Self::OldModels { .. }
            | Self::NotKept { .. }
            | Self::SetAside { .. }
            | Self::CamerasSlow { .. } => Severity::Fault,
        }
    }

    pub(crate) fn check(&self) -> Result<(), OutOfRange> {
        const FIELD: &str = "notices[]";
        match self {
            Self::CameraSilent { silent_s, .. } => check::amount(*silent_s, FIELD),
            Self::LateObservations { .. } | Self::Overload { .. } => Ok(()),
            Self::Unpublished { detail, .. } => check::detail(detail, FIELD),
            Self::ClockStepped { by_s } => check::finite(&[*by_s], FIELD),
            Self::ChangeRefused {
                key,
                sender,
                refusal,
            } => {
                check::detail(key, FIELD)?;
                let sender = sender.as_ref().map_or(0, String::len);
                holds(sender <= MAX_DETAIL_BYTES, FIELD)?;
                refusal.check(FIELD)
            }
            Self::NameTaken { host } => check::name(host, FIELD),
            Self::RefinementProposed {
                before_px,
                after_px,
                ..
            } => {
                check::amount(*before_px, FIELD)?;
                check::amount(*after_px, FIELD)
            }
            Self::OldModels { .. } => Ok(()),
            Self::NotKept { detail } => check::detail(detail, FIELD),
            Self::CamerasSlow { cameras, behind_s } => {
                holds(cameras.len() <= MAX_SLOW_CAMERAS, FIELD)?;
                check::amount(*behind_s, FIELD)
            }
            Self::SetAside { t_ns, detail, .. } => {
                check::time(*t_ns, FIELD)?;
                check::detail(detail, FIELD)
            }
        }
    }
}
