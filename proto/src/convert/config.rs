//! Rigs and objects to messages and back.

use crate::messages::config::{
    CameraConfig, LensConfig, ObjectConfig, ObjectTagConfig, PoseConfig, RigConfig,
};
use sextant_estimator::{Camera, ObjectError, ObjectModel, ObjectTag, Rig, RigError, TagId};
use sextant_geometry::{BrownConrady, KannalaBrandt, Lens, Pinhole, Pose};

impl From<&Rig> for RigConfig {
    fn from(rig: &Rig) -> Self {
        let cameras = rig.cameras().iter().map(CameraConfig::from).collect();
        Self { cameras }
    }
}

impl From<&Camera> for CameraConfig {
    fn from(camera: &Camera) -> Self {
        Self {
            id: camera.id.clone(),
            resolution: camera.resolution,
            lens: LensConfig::from(&camera.lens),
            world_from_camera: camera.world_from_camera.as_ref().map(PoseConfig::from),
        }
    }
}

impl TryFrom<&RigConfig> for Rig {
    type Error = RigError;

    fn try_from(message: &RigConfig) -> Result<Self, RigError> {
        Self::new(message.cameras.iter().map(camera).collect())
    }
}

fn camera(message: &CameraConfig) -> Camera {
    Camera {
        id: message.id.clone(),
        resolution: message.resolution,
        lens: Lens::from(&message.lens),
        world_from_camera: message.world_from_camera.as_ref().map(Pose::from),
    }
}

impl From<&ObjectModel> for ObjectConfig {
    fn from(object: &ObjectModel) -> Self {
        Self {
            id: object.id().clone(),
            tags: object.tags().iter().map(ObjectTagConfig::from).collect(),
        }
    }
}

impl From<&ObjectTag> for ObjectTagConfig {
    fn from(tag: &ObjectTag) -> Self {
        Self {
            family: tag.tag.family,
            id: tag.tag.id,
            size_m: tag.size_m,
            object_from_tag: tag.object_from_tag.as_ref().map(PoseConfig::from),
        }
    }
}

impl TryFrom<&ObjectConfig> for ObjectModel {
    type Error = ObjectError;

    fn try_from(message: &ObjectConfig) -> Result<Self, ObjectError> {
        Self::new(
            message.id.clone(),
            message.tags.iter().map(object_tag).collect(),
        )
    }
}

fn object_tag(message: &ObjectTagConfig) -> ObjectTag {
    ObjectTag {
        tag: TagId {
            family: message.family,
            id: message.id,
        },
        size_m: message.size_m,
        object_from_tag: message.object_from_tag.as_ref().map(Pose::from),
    }
}

impl From<&Lens> for LensConfig {
    fn from(lens: &Lens) -> Self {
        match *lens {
            Lens::Pinhole(Pinhole { fx, fy, cx, cy }) => Self::Pinhole { fx, fy, cx, cy },
            Lens::BrownConrady(BrownConrady {
                fx,
                fy,
                cx,
                cy,
                distortion,
            }) => Self::BrownConrady {
                fx,
                fy,
                cx,
                cy,
                distortion,
            },
            Lens::KannalaBrandt(KannalaBrandt {
                fx,
                fy,
                cx,
                cy,
                distortion,
            }) => Self::KannalaBrandt {
                fx,
                fy,
                cx,
                cy,
                distortion,
            },
        }
    }
}

impl From<&LensConfig> for Lens {
    fn from(message: &LensConfig) -> Self {
        match *message {
            LensConfig::Pinhole { fx, fy, cx, cy } => Self::Pinhole(Pinhole { fx, fy, cx, cy }),
            LensConfig::BrownConrady {
                fx,
                fy,
                cx,
                cy,
                distortion,
            } => Self::BrownConrady(BrownConrady {
                fx,
                fy,
                cx,
                cy,
                distortion,
            }),
            LensConfig::KannalaBrandt {
                fx,
                fy,
                cx,
                cy,
                distortion,
            } => Self::KannalaBrandt(KannalaBrandt {
                fx,
                fy,
                cx,
                cy,
                distortion,
            }),
        }
    }
}
