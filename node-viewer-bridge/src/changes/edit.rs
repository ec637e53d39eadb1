//! Edits of a camera or an object on the page: the change of the site that a request asks for, made from what is in
//! force.
//!
//! Input: a request of `POST /api/models` and the site as heard. Output: the message that `sextant config set` would
//! publish, or a refusal that names the field. Knows no network and no clock.

mod camera;
mod object;
mod requests;
mod version;

pub(crate) use requests::{EditRequest, MAX_BYTES as MAX_EDIT_BYTES};
pub(crate) use version::{version_of, version_of_camera};

use crate::changes::Outgoing;
use crate::refusal::Refusal;
use sextant_proto::{NodeKind, PoseConfig};
use sextant_site_mirror::SiteMirror;
use std::fmt::Display;
use std::str::FromStr;

/// Largest coordinate of a place, m: that of a message.
const MAX_PLACEMENT_M: f64 = sextant_proto::limits::MAX_PLACEMENT_M;
/// Largest deviation of a quaternion's length from 1.
const QUATERNION_TOLERANCE: f64 = sextant_proto::limits::QUATERNION_TOLERANCE;

/// The change that a request asks for.
pub(crate) fn change(request: &EditRequest, site: &SiteMirror) -> Result<Outgoing, Refusal> {
    if site.alive(NodeKind::Fusion).next().is_none() {
        return Err(Refusal::not_now(
            "no fusion node runs that could apply it: start one (`sextant fusion`) and try again",
        ));
    }
    match request {
        EditRequest::EditCamera(edit) => camera::edit(edit, site),
        EditRequest::RemoveCamera(removal) => camera::remove(removal, site),
        EditRequest::EditObject(edit) => object::edit(edit, site),
        EditRequest::RemoveObject(removal) => object::remove(removal, site),
    }
}

/// Whether a pose may be published; complaints name the fields `position` and `orientation`.
fn check_pose(pose: &PoseConfig, what: &str) -> Result<(), Refusal> {
    if !pose.position.iter().all(|m| m.abs() <= MAX_PLACEMENT_M) {
        let cause = format!("{what}: coordinates are numbers up to {MAX_PLACEMENT_M} m");
        return Err(Refusal::wrong("position", cause));
    }
    let length = pose.orientation.iter().map(|v| v * v).sum::<f64>().sqrt();
    if (length - 1.0).abs() <= QUATERNION_TOLERANCE {
        return Ok(());
    }
    let cause = format!(
        "{what}: the quaternion x, y, z, w has the length {length:.4}; divide its parts by it"
    );
    Err(Refusal::wrong("orientation", cause))
}

fn parse<T: FromStr>(field: &'static str, text: &str) -> Result<T, Refusal>
where
    T::Err: Display,
{
    let parsed = text.trim().parse();
    parsed.map_err(|error| Refusal::wrong(field, error))
}

#[cfg(test)]
mod tests;
