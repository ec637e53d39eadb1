//! Models that may be put in force: a refined calibration, or what was in force before the last change.

use crate::check::{self, OutOfRange, holds};
use crate::envelope::{DecodeError, EncodeError, Message, MessageKind, decode, encode};
use crate::ids::NodeId;
use crate::limits::{MAX_OBJECTS, MAX_PAYLOAD_BYTES};
use crate::messages::object_config::ObjectConfig;
use crate::messages::rig_config::RigConfig;
use crate::wire;
use serde::{Deserialize, Serialize};

/// The models that differ from those in force, as the payloads that put them in force: each is published as it is,
/// under its `config/` key. Without any there is nothing to be put in force.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Proposal {
    /// The fusion node; the same as in the key.
    pub node: NodeId,
    /// When it was made, ns since the Unix epoch.
    pub t_ns: u64,
    /// Payload of a [`RigConfig`]; none where no camera differs.
    pub rig: Option<ModelPayload>,
    /// Payload of a [`ObjectConfig`] for each object that differs.
    #[serde(deserialize_with = "wire::list::at_most::<_, _, MAX_OBJECTS>")]
    pub objects: Vec<ModelPayload>,
    /// Images that had no part in the refinement and judge it; 0 where it is no refinement.
    pub n_images: u32,
    /// Rms distance between corners as seen and as expected in these images by the models in force, pixels.
    pub before_px: f64,
    /// The same by the models proposed.
    pub after_px: f64,
}

/// A payload of its own, header included.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(transparent)]
pub struct ModelPayload(
    /// Its bytes.
    #[serde(serialize_with = "wire::bytes::serialize")]
    #[serde(deserialize_with = "wire::bytes::at_most::<_, MAX_PAYLOAD_BYTES>")]
    pub Vec<u8>,
);

impl ModelPayload {
    /// The payload of a model.
    ///
    /// # Errors
    /// As [`encode`].
    pub fn encode<M: Message>(model: &M) -> Result<Self, EncodeError> {
        encode(model).map(Self)
    }
}

impl Proposal {
    /// A proposal of nothing.
    #[must_use]
    pub fn none(node: NodeId, t_ns: u64) -> Self {
        Self {
            node,
            t_ns,
            rig: None,
            objects: Vec::new(),
            n_images: 0,
            before_px: 0.0,
            after_px: 0.0,
        }
    }

    /// Whether nothing is proposed.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.rig.is_none() && self.objects.is_empty()
    }

    /// The cameras proposed.
    ///
    /// # Errors
    /// As [`decode`].
    pub fn rig_config(&self) -> Result<Option<RigConfig>, DecodeError> {
        self.rig.as_ref().map(|one| decode(&one.0)).transpose()
    }

    /// The objects proposed.
    ///
    /// # Errors
    /// As [`decode`].
    pub fn object_configs(&self) -> Result<Vec<ObjectConfig>, DecodeError> {
        self.objects.iter().map(|one| decode(&one.0)).collect()
    }
}

impl Message for Proposal {
    const KIND: MessageKind = MessageKind::Proposal;

    fn check(&self) -> Result<(), OutOfRange> {
        check::time(self.t_ns, "t_ns")?;
        holds(self.objects.len() <= MAX_OBJECTS, "objects")?;
        check::amount(self.before_px, "before_px")?;
        check::amount(self.after_px, "after_px")
    }
}
