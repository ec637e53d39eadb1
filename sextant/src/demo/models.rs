//! What a site would have calibrated and learned: the rig and the constellations, taken from the scenario.

use sextant_estimator::{
    Camera, CameraId, IdError, ObjectError, ObjectId, ObjectModel, ObjectTag, Rig, TagId,
};
use sextant_simulator::{SceneCamera, SceneObject};

/// The cameras as a rig file has them.
pub fn rig(cameras: &[SceneCamera]) -> anyhow::Result<Rig> {
    let known: Vec<Camera> = cameras.iter().map(camera).collect::<Result<_, _>>()?;
    let ids = known.iter().map(|camera| camera.id.clone());
    let delays: Vec<(CameraId, f64)> = ids
        .zip(cameras.iter().map(|camera| camera.line_delay_s))
        .collect();
    Ok(Rig::new(known)?.with_line_delays(delays)?)
}

fn camera(camera: &SceneCamera) -> Result<Camera, IdError> {
    Ok(Camera {
        id: CameraId::new(&camera.id)?,
        resolution: camera.resolution,
        lens: camera.lens,
        world_from_camera: Some(camera.world_from_camera),
    })
}

/// The object as an object file has it.
pub fn object(object: &SceneObject) -> anyhow::Result<ObjectModel> {
    let tags = object.tags.iter().map(|tag| ObjectTag {
        tag: TagId {
            family: tag.family,
            id: tag.id,
        },
        size_m: tag.size,
        object_from_tag: Some(tag.object_from_tag),
    });
    Ok(ObjectModel::new(ObjectId::new(&object.id)?, tags.collect())
        .map_err(|cause: ObjectError| cause)?)
}
