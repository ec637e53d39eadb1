//! Edits of a camera of the rig.

use super::requests::{CameraEdit, Removal};
use super::{check_pose, parse, version};
use crate::changes::Outgoing;
use crate::refusal::Refusal;
use sextant_proto::{CameraConfig, RigConfig, RigConfigError};
use sextant_site_mirror::SiteMirror;
use sextant_site_model::{CameraId, Rig, RigError};

/// The rig with the edited camera.
pub(super) fn edit(edit: &CameraEdit, site: &SiteMirror) -> Result<Outgoing, Refusal> {
    let mut rig = rig_in_force(site)?;
    let camera = camera_of(&mut rig, &edit.camera, &edit.version)?;
    camera.id = parse("id", &edit.id)?;
    let what = format!("camera {}", camera.id);
    if let Some(pose) = &edit.pose {
        check_pose(pose, &what)?;
    }
    match (&mut camera.mount, edit.pose) {
        (Some(mount), Some(pose)) => mount.carrier_from_camera = pose,
        (Some(mount), None) => {
            let cause = format!(
                "{what} is carried by {}: give its place there",
                mount.carrier
            );
            return Err(Refusal::wrong("position", cause));
        }
        (None, pose) => camera.world_from_camera = pose,
    }
    camera.world_from_camera_sigma = edit.sigma;
    check_rig(&rig)?;
    Ok(Outgoing::Rig(rig))
}

/// The rig without a camera.
pub(super) fn remove(removal: &Removal, site: &SiteMirror) -> Result<Outgoing, Refusal> {
    let mut rig = rig_in_force(site)?;
    let id = camera_of(&mut rig, &removal.id, &removal.version)?
        .id
        .clone();
    rig.cameras.retain(|camera| camera.id != id);
    if rig.cameras.is_empty() {
        return Err(Refusal::not_now(format!(
            "{id} is the only camera of the rig, which needs one"
        )));
    }
    Ok(Outgoing::Rig(rig))
}

fn rig_in_force(site: &SiteMirror) -> Result<RigConfig, Refusal> {
    let rig = site.rig().cloned();
    rig.ok_or_else(|| Refusal::not_now("no fusion node has announced a rig yet; try again"))
}

fn camera_of<'a>(
    rig: &'a mut RigConfig,
    id: &str,
    begun: &str,
) -> Result<&'a mut CameraConfig, Refusal> {
    let id: CameraId = parse("camera", id)?;
    let camera = rig.cameras.iter_mut().find(|camera| camera.id == id);
    let Some(camera) = camera else {
        return Err(Refusal::not_now(format!(
            "the rig has no camera {id} any more"
        )));
    };
    let in_force = version::version_of_camera(camera);
    version::check(begun, &in_force, &format!("camera {id}"))?;
    Ok(camera)
}

fn check_rig(rig: &RigConfig) -> Result<(), Refusal> {
    let Err(error) = Rig::try_from(rig) else {
        return Ok(());
    };
    let field = match &error {
        RigConfigError::Rig(RigError::DuplicateCamera(_)) => "id",
        RigConfigError::Rig(RigError::PoseSigma(_)) => "sigma",
        _ => "position",
    };
    Err(Refusal::wrong(field, error))
}
