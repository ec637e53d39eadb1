//! Rigs and objects to messages and back.

use crate::messages::config::{
    CameraConfig, LensConfig, ObjectConfig, ObjectTagConfig, PoseConfig, RigConfig,
};
use sextant_estimator::{
    Camera, CameraId, ObjectError, ObjectModel, ObjectTag, Rig, RigError, TagId,
};
use sextant_geometry::{Intrinsics, Lens, LensError, LensModel, Pose};

/// A message whose cameras make no rig.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum RigConfigError {
    /// A lens that projects nothing sensible.
    #[error("camera {camera}: {source}")]
    Lens {
        /// The camera.
        camera: CameraId,
        /// What is wrong with it.
        source: LensError,
    },
    /// Cameras that contradict each other.
    #[error(transparent)]
    Rig(#[from] RigError),
}

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
    type Error = RigConfigError;

    fn try_from(message: &RigConfig) -> Result<Self, RigConfigError> {
        let cameras: Result<_, _> = message.cameras.iter().map(camera).collect();
        Ok(Self::new(cameras?)?)
    }
}

fn camera(message: &CameraConfig) -> Result<Camera, RigConfigError> {
    let lens = Lens::try_from(&message.lens).map_err(|source| RigConfigError::Lens {
        camera: message.id.clone(),
        source,
    })?;
    Ok(Camera {
        id: message.id.clone(),
        resolution: message.resolution,
        lens,
        world_from_camera: message.world_from_camera.as_ref().map(Pose::from),
    })
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
            message.tags.iter().map(ObjectTag::from).collect(),
        )
    }
}

impl From<&ObjectTagConfig> for ObjectTag {
    fn from(message: &ObjectTagConfig) -> Self {
        Self {
            tag: TagId {
                family: message.family,
                id: message.id,
            },
            size_m: message.size_m,
            object_from_tag: message.object_from_tag.as_ref().map(Pose::from),
        }
    }
}

impl From<&Lens> for LensConfig {
    fn from(lens: &Lens) -> Self {
        let Intrinsics { fx, fy, cx, cy } = lens.intrinsics();
        match (lens.model(), lens.distortion()) {
            (LensModel::BrownConrady, &[k1, k2, p1, p2, k3]) => Self::BrownConrady {
                fx,
                fy,
                cx,
                cy,
                distortion: [k1, k2, p1, p2, k3],
            },
            (LensModel::KannalaBrandt, &[k1, k2, k3, k4]) => Self::KannalaBrandt {
                fx,
                fy,
                cx,
                cy,
                distortion: [k1, k2, k3, k4],
            },
            _ => Self::Pinhole { fx, fy, cx, cy },
        }
    }
}

impl TryFrom<&LensConfig> for Lens {
    type Error = LensError;

    fn try_from(message: &LensConfig) -> Result<Self, LensError> {
        match *message {
            LensConfig::Pinhole { fx, fy, cx, cy } => Self::pinhole(Intrinsics { fx, fy, cx, cy }),
            LensConfig::BrownConrady {
                fx,
                fy,
                cx,
                cy,
                distortion,
            } => Self::brown_conrady(Intrinsics { fx, fy, cx, cy }, distortion),
            LensConfig::KannalaBrandt {
                fx,
                fy,
                cx,
                cy,
                distortion,
            } => Self::kannala_brandt(Intrinsics { fx, fy, cx, cy }, distortion),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const INTRINSICS: Intrinsics = Intrinsics {
        fx: 600.0,
        fy: 601.0,
        cx: 319.5,
        cy: 239.5,
    };

    #[test]
    fn every_lens_survives_the_way_there_and_back() {
        for lens in [
            Lens::pinhole(INTRINSICS).unwrap(),
            Lens::brown_conrady(INTRINSICS, [-0.2, 0.05, 1e-3, -1e-3, 0.01]).unwrap(),
            Lens::kannala_brandt(INTRINSICS, [0.01, -0.02, 0.003, 0.0]).unwrap(),
        ] {
            assert_eq!(Lens::try_from(&LensConfig::from(&lens)), Ok(lens));
        }
    }

    #[test]
    fn a_lens_that_is_none_makes_no_rig() {
        let camera = CameraConfig {
            id: CameraId::new("north").unwrap(),
            resolution: [640, 480],
            lens: LensConfig::Pinhole {
                fx: -1.0,
                fy: 600.0,
                cx: 0.0,
                cy: 0.0,
            },
            world_from_camera: None,
        };
        let rig = Rig::try_from(&RigConfig {
            cameras: vec![camera],
        });
        assert!(matches!(rig, Err(RigConfigError::Lens { .. })));
    }
}
