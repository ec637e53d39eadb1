//! What a site would have calibrated and learned: the rig and the constellations, taken from the scenario.

use sextant_estimator::{
    Camera, CameraId, IdError, ObjectError, ObjectId, ObjectModel, ObjectTag, TagId,
};
use sextant_simulator::{SceneCamera, SceneObject};

/// The camera as a rig file has it.
pub fn camera(camera: &SceneCamera) -> Result<Camera, IdError> {
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
