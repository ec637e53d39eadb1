//! Rigs to messages and back.

use crate::messages::pose_config::{PoseConfig, SigmaConfig};
use crate::messages::rig_config::{
    CameraConfig, ExposureConfig, LensConfig, LensSigmaConfig, MountConfig, RigConfig,
};
use sextant_geometry::{Intrinsics, Lens, LensError, LensModel, Pose};
use sextant_site_model::{Camera, CameraId, Exposure, LensSigma, Mount, PoseSigma, Rig, RigError};

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
    /// Cameras that contradict each other, or a value that no rig file may have.
    #[error(transparent)]
    Rig(#[from] RigError),
}

impl RigConfigError {
    /// The camera that it is about, if any.
    #[must_use]
    pub fn camera(&self) -> Option<&CameraId> {
        match self {
            Self::Lens { camera, .. } => Some(camera),
            Self::Rig(error) => error.camera(),
        }
    }
}

impl From<&Rig> for RigConfig {
    fn from(rig: &Rig) -> Self {
        let cameras = rig.cameras().iter().map(|camera| CameraConfig {
            id: camera.id.clone(),
            resolution: camera.resolution,
            lens: LensConfig::from(&camera.lens),
            lens_sigma: camera.lens_prior.given().map(LensSigmaConfig::from),
            world_from_camera: camera.world_from_camera.as_ref().map(PoseConfig::from),
            mount: camera.mount.as_ref().map(|mount| MountConfig {
                carrier: mount.carrier.clone(),
                carrier_from_camera: PoseConfig::from(&mount.carrier_from_camera),
            }),
            world_from_camera_sigma: camera.pose_prior.given().map(SigmaConfig::from),
            line_delay_s: camera.line_delay_s,
            exposure: camera.exposure.map(ExposureConfig::from),
        });
        Self {
            cameras: cameras.collect(),
            scale_sigma: rig.scale_sigma(),
        }
    }
}

impl TryFrom<&RigConfig> for Rig {
    type Error = RigConfigError;

    fn try_from(message: &RigConfig) -> Result<Self, RigConfigError> {
        let cameras: Result<Vec<Camera>, _> = message.cameras.iter().map(camera).collect();
        Ok(Self::new(cameras?)?.with_scale_sigma(message.scale_sigma)?)
    }
}

fn camera(message: &CameraConfig) -> Result<Camera, RigConfigError> {
    let lens = Lens::try_from(&message.lens).map_err(|source| RigConfigError::Lens {
        camera: message.id.clone(),
        source,
    })?;
    let pose = message.world_from_camera.as_ref().map(Pose::from);
    let mount = message.mount.as_ref().map(|mount| Mount {
        carrier: mount.carrier.clone(),
        carrier_from_camera: Pose::from(&mount.carrier_from_camera),
    });
    Ok(Camera {
        mount,
        pose_prior: message.world_from_camera_sigma.map(PoseSigma::from).into(),
        lens_prior: message.lens_sigma.map(LensSigma::from).into(),
        line_delay_s: message.line_delay_s,
        exposure: message.exposure.map(Exposure::from),
        ..Camera::new(message.id.clone(), message.resolution, lens, pose)
    })
}

impl From<LensSigma> for LensSigmaConfig {
    fn from(sigma: LensSigma) -> Self {
        Self {
            focal_px: sigma.focal_px,
            distortion_px: sigma.distortion_px,
        }
    }
}

impl From<LensSigmaConfig> for LensSigma {
    fn from(message: LensSigmaConfig) -> Self {
        Self {
            focal_px: message.focal_px,
            distortion_px: message.distortion_px,
        }
    }
}

impl From<Exposure> for ExposureConfig {
    fn from(exposure: Exposure) -> Self {
        Self {
            length_s: exposure.length_s,
            stamp: exposure.stamp,
        }
    }
}

impl From<ExposureConfig> for Exposure {
    fn from(message: ExposureConfig) -> Self {
        Self {
            length_s: message.length_s,
            stamp: message.stamp,
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

    fn rig() -> Rig {
        let camera = Camera::new(
            CameraId::new("north").unwrap(),
            [640, 480],
            Lens::pinhole(INTRINSICS).unwrap(),
            None,
        );
        Rig::new(vec![camera]).unwrap()
    }

    #[test]
    fn a_lens_that_is_none_makes_no_rig() {
        let mut message = RigConfig::from(&rig());
        message.cameras[0].lens = LensConfig::Pinhole {
            fx: -1.0,
            fy: 600.0,
            cx: 0.0,
            cy: 0.0,
        };
        let refused = Rig::try_from(&message);
        assert!(matches!(refused, Err(RigConfigError::Lens { .. })));
    }

    #[test]
    fn what_no_file_may_give_no_message_may_either() {
        let mut message = RigConfig::from(&rig());
        message.cameras[0].line_delay_s = Some(1.0);
        let refused = Rig::try_from(&message).unwrap_err().to_string();
        assert!(
            refused.contains("camera north: the line delay"),
            "{refused}"
        );
    }
}
