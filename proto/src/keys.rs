//! Keys: where each message lives. `sextant/v1/<site>/...`, no wildcard character and no `@` in any of them.

use crate::envelope::MessageKind;
use crate::ids::{IdError, NodeId, SiteId};
use sextant_site_model::{CameraId, ObjectId};

/// How the sender of what a fusion node announces under `config/` begins; its name follows. Other senders ask for
/// changes.
pub const ANNOUNCED: &str = "fusion/";

/// The keys of one site.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Keys {
    site: SiteId,
    root: String,
}

/// Kinds of process with a liveliness token.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum NodeKind {
    /// A camera node; its id is the camera's.
    Camera,
    /// A fusion node.
    Fusion,
    /// A viewer bridge.
    Viewer,
}

impl NodeKind {
    /// Every kind.
    pub const ALL: [Self; 3] = [Self::Camera, Self::Fusion, Self::Viewer];

    /// Its name in a key.
    #[must_use]
    pub const fn as_str(self) -> &'static str {
        match self {
            Self::Camera => "camera",
            Self::Fusion => "fusion",
            Self::Viewer => "viewer",
        }
    }
}

/// What a key stands for.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
#[allow(missing_docs, reason = "each variant is the key of its name")]
pub enum KeyRef {
    Observations(CameraId),
    Preview(CameraId),
    DetectionReport(CameraId),
    CameraStatus(CameraId),
    Pose(ObjectId),
    Truth(ObjectId),
    FusionStatus(NodeId),
    Clocks(NodeId),
    Inputs(NodeId),
    Heartbeat(NodeId),
    ConfigAnswer(NodeId),
    Proposal(NodeId),
    Former(NodeId),
    FormerRig(NodeId),
    FormerObject(NodeId, ObjectId),
    ConfigRig,
    ConfigObject(ObjectId),
    ConfigCamera(CameraId),
    ConfigModels,
    Links(ObjectId),
    Alive(NodeKind, NodeId),
}

impl KeyRef {
    /// Whether the key is one under which changes of the site are asked for.
    #[must_use]
    pub fn is_config(&self) -> bool {
        matches!(
            self,
            Self::ConfigRig | Self::ConfigObject(_) | Self::ConfigCamera(_) | Self::ConfigModels
        )
    }

    /// The kind of message under such a key; none for liveliness, which has no payload.
    #[must_use]
    pub fn kind(&self) -> Option<MessageKind> {
        Some(match self {
            Self::Observations(_) => MessageKind::Observations,
            Self::Preview(_) => MessageKind::Preview,
            Self::DetectionReport(_) => MessageKind::DetectionReport,
            Self::CameraStatus(_) => MessageKind::CameraStatus,
            Self::Pose(_) => MessageKind::ObjectPose,
            Self::Truth(_) => MessageKind::ObjectTruth,
            Self::FusionStatus(_) => MessageKind::FusionStatus,
            Self::Clocks(_) => MessageKind::ClockReport,
            Self::Inputs(_) => MessageKind::FusionInputs,
            Self::Heartbeat(_) => MessageKind::Heartbeat,
            Self::ConfigAnswer(_) => MessageKind::ConfigAnswer,
            Self::Proposal(_) | Self::Former(_) | Self::ConfigModels => MessageKind::Proposal,
            Self::FormerRig(_) => MessageKind::RigConfig,
            Self::FormerObject(..) => MessageKind::ObjectConfig,
            Self::ConfigRig => MessageKind::RigConfig,
            Self::ConfigObject(_) => MessageKind::ObjectConfig,
            Self::ConfigCamera(_) => MessageKind::CameraSettings,
            Self::Links(_) => MessageKind::ObjectLinks,
            Self::Alive(..) => return None,
        })
    }
}

impl Keys {
    /// The keys of a site.
    ///
    /// # Errors
    /// A site's name is an id.
    pub fn new(site: &str) -> Result<Self, IdError> {
        Ok(Self::for_site(SiteId::new(site)?))
    }

    /// The keys of a site whose name was read already.
    #[must_use]
    pub fn for_site(site: SiteId) -> Self {
        let root = format!("sextant/v1/{site}");
        Self { site, root }
    }

    /// The site that the keys are of.
    #[must_use]
    pub fn site(&self) -> &SiteId {
        &self.site
    }

    /// [`crate::Observations`] of a camera.
    #[must_use]
    pub fn observations(&self, camera: &CameraId) -> String {
        self.under(format_args!("camera/{camera}/observations"))
    }

    /// [`crate::Preview`] of a camera.
    #[must_use]
    pub fn preview(&self, camera: &CameraId) -> String {
        self.under(format_args!("camera/{camera}/preview"))
    }

    /// [`crate::DetectionReport`]s of a camera.
    #[must_use]
    pub fn detection_report(&self, camera: &CameraId) -> String {
        self.under(format_args!("camera/{camera}/detection"))
    }

    /// [`crate::CameraStatus`] of a camera.
    #[must_use]
    pub fn camera_status(&self, camera: &CameraId) -> String {
        self.under(format_args!("camera/{camera}/status"))
    }

    /// [`crate::ObjectPose`] of an object.
    #[must_use]
    pub fn pose(&self, object: &ObjectId) -> String {
        self.under(format_args!("object/{object}/pose"))
    }

    /// [`crate::ObjectTruth`] of a simulated object.
    #[must_use]
    pub fn truth(&self, object: &ObjectId) -> String {
        self.under(format_args!("object/{object}/truth"))
    }

    /// [`crate::FusionStatus`] of a node.
    #[must_use]
    pub fn fusion_status(&self, node: &NodeId) -> String {
        self.under(format_args!("fusion/{node}/status"))
    }

    /// [`crate::ClockReport`] of a node.
    #[must_use]
    pub fn clocks(&self, node: &NodeId) -> String {
        self.under(format_args!("fusion/{node}/clocks"))
    }

    /// [`crate::FusionInputs`] of a node.
    #[must_use]
    pub fn inputs(&self, node: &NodeId) -> String {
        self.under(format_args!("fusion/{node}/inputs"))
    }

    /// [`crate::Heartbeat`]s of a node.
    #[must_use]
    pub fn heartbeat(&self, node: &NodeId) -> String {
        self.under(format_args!("fusion/{node}/heartbeat"))
    }

    /// [`crate::ConfigAnswer`]s of a node.
    #[must_use]
    pub fn config_answer(&self, node: &NodeId) -> String {
        self.under(format_args!("fusion/{node}/answer"))
    }

    /// [`crate::Proposal`] of a refined calibration by a node.
    #[must_use]
    pub fn proposal(&self, node: &NodeId) -> String {
        self.under(format_args!("fusion/{node}/proposal"))
    }

    /// [`crate::Proposal`] of what a node worked from before the last change.
    #[must_use]
    pub fn former(&self, node: &NodeId) -> String {
        self.under(format_args!("fusion/{node}/former"))
    }

    /// [`crate::RigConfig`] before the last change of the rig.
    #[must_use]
    pub fn former_rig(&self, node: &NodeId) -> String {
        self.under(format_args!("fusion/{node}/former/rig"))
    }

    /// [`crate::ObjectConfig`] before the last change of the object.
    #[must_use]
    pub fn former_object(&self, node: &NodeId, object: &ObjectId) -> String {
        self.under(format_args!("fusion/{node}/former/object/{object}"))
    }

    /// Key of the [`crate::RigConfig`].
    #[must_use]
    pub fn config_rig(&self) -> String {
        self.under(format_args!("config/rig"))
    }

    /// [`crate::ObjectConfig`] of an object.
    #[must_use]
    pub fn config_object(&self, object: &ObjectId) -> String {
        self.under(format_args!("config/object/{object}"))
    }

    /// [`crate::CameraSettings`] of a camera.
    #[must_use]
    pub fn config_camera(&self, camera: &CameraId) -> String {
        self.under(format_args!("config/camera/{camera}"))
    }

    /// [`crate::Proposal`] that is to be put in force: the rig and objects together.
    #[must_use]
    pub fn config_models(&self) -> String {
        self.under(format_args!("config/models"))
    }

    /// What a fusion node works from, for the other ones: under it the keys of the models, such as `config/rig`.
    #[must_use]
    pub fn models_of(&self, node: &NodeId) -> String {
        self.under(format_args!("fusion/{node}/models"))
    }

    /// [`crate::ObjectLinks`] of an articulated object.
    #[must_use]
    pub fn links(&self, object: &ObjectId) -> String {
        self.under(format_args!("object/{object}/links"))
    }

    /// Events of the zones of a viewer bridge, as JSON.
    #[must_use]
    pub fn events(&self, node: &NodeId) -> String {
        self.under(format_args!("viewer/{node}/events"))
    }

    /// Events of every viewer bridge.
    #[must_use]
    pub fn all_events(&self) -> String {
        self.under(format_args!("viewer/*/events"))
    }

    /// Liveliness of a node.
    #[must_use]
    pub fn alive(&self, kind: NodeKind, id: &NodeId) -> String {
        self.under(format_args!("alive/{}/{id}", kind.as_str()))
    }

    /// Under which the one process that runs a node holds its name: `<key>/<session>/<host>`, a liveliness token.
    #[must_use]
    pub fn holder(&self, kind: NodeKind, id: &NodeId) -> String {
        self.under(format_args!("holder/{}/{id}", kind.as_str()))
    }

    /// Observations of every camera.
    #[must_use]
    pub fn all_observations(&self) -> String {
        self.under(format_args!("camera/*/observations"))
    }

    /// Previews of every camera.
    #[must_use]
    pub fn all_previews(&self) -> String {
        self.under(format_args!("camera/*/preview"))
    }

    /// Detection reports of every camera.
    #[must_use]
    pub fn all_detection_reports(&self) -> String {
        self.under(format_args!("camera/*/detection"))
    }

    /// Status of every camera.
    #[must_use]
    pub fn all_camera_statuses(&self) -> String {
        self.under(format_args!("camera/*/status"))
    }

    /// Poses of every object.
    #[must_use]
    pub fn all_poses(&self) -> String {
        self.under(format_args!("object/*/pose"))
    }

    /// Links of every articulated object.
    #[must_use]
    pub fn all_links(&self) -> String {
        self.under(format_args!("object/*/links"))
    }

    /// Truth of every simulated object.
    #[must_use]
    pub fn all_truths(&self) -> String {
        self.under(format_args!("object/*/truth"))
    }

    /// Status of every fusion node.
    #[must_use]
    pub fn all_fusion_statuses(&self) -> String {
        self.under(format_args!("fusion/*/status"))
    }

    /// Clocks as every fusion node sees them.
    #[must_use]
    pub fn all_clocks(&self) -> String {
        self.under(format_args!("fusion/*/clocks"))
    }

    /// Inputs of the estimator of every fusion node.
    #[must_use]
    pub fn all_inputs(&self) -> String {
        self.under(format_args!("fusion/*/inputs"))
    }

    /// Heartbeats of every fusion node.
    #[must_use]
    pub fn all_heartbeats(&self) -> String {
        self.under(format_args!("fusion/*/heartbeat"))
    }

    /// Answers of every fusion node to changes.
    #[must_use]
    pub fn all_config_answers(&self) -> String {
        self.under(format_args!("fusion/*/answer"))
    }

    /// Proposals of every fusion node.
    #[must_use]
    pub fn all_proposals(&self) -> String {
        self.under(format_args!("fusion/*/proposal"))
    }

    /// What every fusion node worked from before the last change.
    #[must_use]
    pub fn all_formers(&self) -> String {
        self.under(format_args!("fusion/*/former"))
    }

    /// The rig before its last change, by every fusion node.
    #[must_use]
    pub fn all_former_rigs(&self) -> String {
        self.under(format_args!("fusion/*/former/rig"))
    }

    /// An object before its last change, by every fusion node.
    #[must_use]
    pub fn all_former_objects(&self, object: &ObjectId) -> String {
        self.under(format_args!("fusion/*/former/object/{object}"))
    }

    /// The rig, every object and the settings of every camera.
    #[must_use]
    pub fn all_config(&self) -> String {
        self.under(format_args!("config/**"))
    }

    /// The configuration of every object.
    #[must_use]
    pub fn all_config_objects(&self) -> String {
        self.under(format_args!("config/object/*"))
    }

    /// Liveliness of every fusion node.
    #[must_use]
    pub fn all_fusion_alive(&self) -> String {
        self.under(format_args!("alive/{}/*", NodeKind::Fusion.as_str()))
    }

    /// Liveliness of every node.
    #[must_use]
    pub fn all_alive(&self) -> String {
        self.under(format_args!("alive/*/*"))
    }

    /// Every key of the site.
    #[must_use]
    pub fn everything(&self) -> String {
        self.under(format_args!("**"))
    }

    /// What a key of this site stands for; none for any other key.
    #[must_use]
    pub fn parse(&self, key: &str) -> Option<KeyRef> {
        Self::parse_below_site(key.strip_prefix(&self.root)?.strip_prefix('/')?)
    }

    /// What the rest of a key below its site stands for.
    #[must_use]
    pub fn parse_below_site(below: &str) -> Option<KeyRef> {
        let chunks: Vec<&str> = below.splitn(5, '/').collect();
        Some(match chunks.as_slice() {
            ["camera", id, "observations"] => KeyRef::Observations(CameraId::new(id).ok()?),
            ["camera", id, "preview"] => KeyRef::Preview(CameraId::new(id).ok()?),
            ["camera", id, "detection"] => KeyRef::DetectionReport(CameraId::new(id).ok()?),
            ["camera", id, "status"] => KeyRef::CameraStatus(CameraId::new(id).ok()?),
            ["object", id, "pose"] => KeyRef::Pose(ObjectId::new(id).ok()?),
            ["object", id, "links"] => KeyRef::Links(ObjectId::new(id).ok()?),
            ["object", id, "truth"] => KeyRef::Truth(ObjectId::new(id).ok()?),
            ["fusion", id, "status"] => KeyRef::FusionStatus(NodeId::new(id).ok()?),
            ["fusion", id, "clocks"] => KeyRef::Clocks(NodeId::new(id).ok()?),
            ["fusion", id, "inputs"] => KeyRef::Inputs(NodeId::new(id).ok()?),
            ["fusion", id, "heartbeat"] => KeyRef::Heartbeat(NodeId::new(id).ok()?),
            ["fusion", id, "answer"] => KeyRef::ConfigAnswer(NodeId::new(id).ok()?),
            ["fusion", id, "proposal"] => KeyRef::Proposal(NodeId::new(id).ok()?),
            ["fusion", id, "former"] => KeyRef::Former(NodeId::new(id).ok()?),
            ["fusion", id, "former", "rig"] => KeyRef::FormerRig(NodeId::new(id).ok()?),
            ["fusion", id, "former", "object", object] => {
                KeyRef::FormerObject(NodeId::new(id).ok()?, ObjectId::new(object).ok()?)
            }
            ["config", "rig"] => KeyRef::ConfigRig,
            ["config", "models"] => KeyRef::ConfigModels,
            ["config", "object", id] => KeyRef::ConfigObject(ObjectId::new(id).ok()?),
            ["config", "camera", id] => KeyRef::ConfigCamera(CameraId::new(id).ok()?),
            ["alive", kind, id] => {
                let kind = NodeKind::ALL.into_iter().find(|k| k.as_str() == *kind)?;
                KeyRef::Alive(kind, NodeId::new(id).ok()?)
            }
            _ => return None,
        })
    }

    /// A key of any site without `sextant/v1/<site>/`: how messages name it.
    #[must_use]
    pub fn below_site(key: &str) -> &str {
        key.splitn(4, '/').nth(3).unwrap_or(key)
    }

    fn under(&self, rest: std::fmt::Arguments<'_>) -> String {
        format!("{}/{rest}", self.root)
    }
}

#[cfg(test)]
mod tests;
