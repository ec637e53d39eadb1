//! Versions of what can be edited: a text that differs where the content does, so that no edit overwrites what its
//! author has not seen.

use crate::refusal::Refusal;
use sextant_proto::{CameraConfig, Message, RigConfig, encode, fingerprint};

/// The version of a model; empty where it fits into no message, which nobody can announce.
pub(crate) fn version_of<M: Message>(model: &M) -> String {
    let payload = encode(model).unwrap_or_default();
    format!("{:016x}", fingerprint(&payload))
}

/// The version of a camera: that of a rig of this camera alone, since other cameras may change.
pub(crate) fn version_of_camera(camera: &CameraConfig) -> String {
    version_of(&RigConfig {
        cameras: vec![camera.clone()],
        scale_sigma: None,
    })
}

/// Refuses an edit of another version than that in force.
pub(super) fn check(begun: &str, in_force: &str, what: &str) -> Result<(), Refusal> {
    if begun == in_force {
        return Ok(());
    }
    Err(Refusal::not_now(format!(
        "a newer version of {what} is in force than the one that was edited: load it again, then repeat the edit"
    )))
}
