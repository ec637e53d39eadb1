//! Names of coordinate frames. An object's frame bears the object's id; the others are made of ids.

use sextant_proto::{ObjectConfig, ObjectTagConfig};
use sextant_site_model::{CameraId, LinkId, ObjectId};

/// The optical frame of a camera (REP 103): `north_optical`.
#[must_use]
pub fn optical_frame(camera: &CameraId) -> String {
    format!("{camera}_optical")
}

/// The frame of a link: `arm/forearm`.
#[must_use]
pub fn link_frame(object: &ObjectId, link: &LinkId) -> String {
    format!("{object}/{link}")
}

/// The frame of an object's tag: `cube/tag36h11:3`.
#[must_use]
pub fn tag_frame(object: &ObjectId, tag: &ObjectTagConfig) -> String {
    format!("{object}/{}:{}", tag.family, tag.id)
}

/// The frame that a tag is fixed to: that of its link, or of its rigid object.
pub(super) fn carrier_frame(object: &ObjectConfig, tag: &ObjectTagConfig) -> String {
    let link = tag
        .link
        .and_then(|link| object.links.get(usize::from(link)));
    link.map_or_else(
        || object.id.to_string(),
        |link| link_frame(&object.id, link),
    )
}
