//! The wire contract: messages, keys, versions and limits. No transport lives here.
//!
//! **Payload.** Every payload is a four-byte header (magic `0x53`, version `1`, [`MessageKind`], flags `0`) followed by
//! the message in [postcard](https://postcard.jamesmunns.com/wire-format): fields in order, integers as varints, floats
//! as little-endian IEEE 754, strings and lists with a length in front, an enum as the index of its variant. Postcard
//! has no schema evolution, so a changed message is a new [`MessageKind`]; the files in `golden/` hold one payload of
//! each kind beside its JSON form, and a test compares them byte for byte. `CONTRACT.md` describes the contract for
//! clients in other languages.
//!
//! **Trust.** [`decode`] takes any bytes: it never panics, never allocates more than [`limits::MAX_DECODED_BYTES`], and
//! hands out only messages whose floats are finite and whose values lie in the ranges that their docs state. [`encode`]
//! holds the sender to the same ranges. Every way to be wrong has its own [`DecodeError`], so that a receiver can count
//! and report it.
//!
//! **Conventions.** Metres, radians, seconds; `u64` nanoseconds since the Unix epoch, capture time being the middle of
//! the exposure; pixels with (0, 0) at the centre of the top-left one; tag corners from the top left clockwise as seen;
//! quaternions x, y, z, w; `a_from_b` maps points of b into a.
//!
//! Keys are made and read by [`Keys`]. Conversions between messages and the types of `sextant_site_model` and
//! `sextant_site_report` live here as well, because the nodes and the replay both need them.

mod any;
mod check;
mod convert;
mod envelope;
mod epoch_filter;
mod health;
mod ids;
mod keys;
pub mod limits;
mod messages;
mod wire;

pub use any::AnyMessage;
pub use check::OutOfRange;
pub use convert::RigConfigError;
pub use envelope::{
    DecodeError, EncodeError, HEADER_BYTES, MAGIC, Message, MessageKind, VERSION, decode, encode,
    encode_into,
};
pub use epoch_filter::EpochFilter;
pub use health::{HealthLevel, NodeHealth};
pub use ids::{IdError, NodeId, SiteId};
pub use keys::{ANNOUNCED, KeyRef, Keys, NodeKind};
pub use messages::camera_notice::CameraNotice;
pub use messages::camera_settings::{CameraControls, CameraSettings, Control, SettingsOutcome};
pub use messages::camera_status::{CameraStatus, ClockQuality, ClockSource};
pub use messages::clock_report::{CameraClock, ClockReport};
pub use messages::config_answer::{ChangeOutcome, ConfigAnswer, fingerprint, models_fingerprint};
pub use messages::detection_report::{
    DetectionReport, RejectedCandidate, RejectionCause, RejectionCounts, StageTimes,
};
pub use messages::fusion_inputs::{FusionInput, FusionInputs, InputSource};
pub use messages::fusion_status::{CameraIntake, FusionStatus, ObjectHealth, Rejections};
pub use messages::heartbeat::{
    HeardBeat, Heartbeat, ModelsState, ModelsVersion, Part, Share, Sharing,
};
pub use messages::notice::{MAX_SLOW_CAMERAS, Notice};
pub use messages::object_config::{JointConfig, ObjectConfig, ObjectTagConfig};
pub use messages::object_links::{JointState, LinkPose, ObjectLinks};
pub use messages::object_pose::{ObjectPose, ObjectTruth};
pub use messages::observations::{Observations, TagObservation, TagPose, Timing};
pub use messages::pose_config::{PoseConfig, SigmaConfig};
pub use messages::preview::Preview;
pub use messages::proposal::{ModelPayload, Proposal};
pub use messages::refusal::Refusal;
pub use messages::rig_config::{
    CameraConfig, ExposureConfig, LensConfig, LensSigmaConfig, MountConfig, RigConfig,
};
pub use sextant_site_report::{Severity, State};
