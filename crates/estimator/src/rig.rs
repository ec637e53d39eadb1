//! The cameras of a site: lens, resolution and pose in the world.

use std::collections::BTreeMap;

use sextant_geometry::{Lens, Pose};
use thiserror::Error;

use crate::CameraId;

/// One camera: how it maps points of the world to pixels.
#[derive(Debug, Clone, PartialEq)]
pub struct Camera {
    /// Its name.
    pub id: CameraId,
    /// Width and height in pixels.
    pub resolution: [u32; 2],
    /// Camera frame (x right, y down, z forward) to pixels.
    pub lens: Lens,
    /// Maps points of the camera into the world; `None` until calibrated.
    pub world_from_camera: Option<Pose>,
}

/// How well a camera's pose is known: one sigma an axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PoseSigma {
    /// Of its position in m.
    pub position_m: f64,
    /// Of its orientation in rad.
    pub orientation_rad: f64,
}

/// All cameras of a site, in the order given; the first is the reference for clocks.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Rig {
    cameras: Vec<Camera>,
    pose_sigmas: BTreeMap<CameraId, PoseSigma>,
}

/// Why cameras make no rig.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum RigError {
    /// Two cameras of one name.
    #[error("camera {0} is there twice")]
    DuplicateCamera(CameraId),
    /// Width or height outside 1..=65535.
    #[error(
        "camera {camera}: the resolution {width} x {height} is not between 1 x 1 and 65535 x 65535"
    )]
    Resolution {
        /// The camera.
        camera: CameraId,
        /// Its width in pixels.
        width: u32,
        /// Its height in pixels.
        height: u32,
    },
    /// A sigma that is none, or of a camera that is not there.
    #[error("camera {0}: the sigmas of its pose must lie between 0 and 1 (m, rad)")]
    PoseSigma(CameraId),
    /// A position or orientation that is not finite.
    #[error("camera {0}: world_from_camera is not finite")]
    Pose(CameraId),
}

impl Rig {
    /// Checks the cameras and takes them over.
    ///
    /// # Errors
    /// For the first camera whose name is taken, or whose resolution or pose is unusable.
    pub fn new(cameras: Vec<Camera>) -> Result<Self, RigError> {
        let mut seen = BTreeMap::new();
        for camera in &cameras {
            check(camera)?;
            if seen.insert(camera.id.clone(), ()).is_some() {
                return Err(RigError::DuplicateCamera(camera.id.clone()));
            }
        }
        Ok(Self {
            cameras,
            pose_sigmas: BTreeMap::new(),
        })
    }

    /// The same rig, with what is known of how well its cameras' poses are known. Where nothing is stated they count as exact:
    /// a figure made up here would make every covariance one.
    ///
    /// # Errors
    /// For the first camera that is not there, and the first sigma that is no length or angle.
    pub fn with_pose_sigmas(
        mut self,
        sigmas: impl IntoIterator<Item = (CameraId, PoseSigma)>,
    ) -> Result<Self, RigError> {
        for (camera, sigma) in sigmas {
            let both = [sigma.position_m, sigma.orientation_rad];
            let sound = both.iter().all(|sigma| (0.0..=1.0).contains(sigma));
            if !sound || self.camera(&camera).is_none() {
                return Err(RigError::PoseSigma(camera));
            }
            self.pose_sigmas.insert(camera, sigma);
        }
        Ok(self)
    }

    /// How well the pose of a camera is known, where that is stated.
    pub fn pose_sigma(&self, id: &CameraId) -> Option<PoseSigma> {
        self.pose_sigmas.get(id).copied()
    }

    /// The cameras in the order given.
    pub fn cameras(&self) -> &[Camera] {
        &self.cameras
    }

    /// The camera of that name.
    pub fn camera(&self, id: &CameraId) -> Option<&Camera> {
        self.cameras.iter().find(|camera| camera.id == *id)
    }
}

fn check(camera: &Camera) -> Result<(), RigError> {
    let [width, height] = camera.resolution;
    let fits = |pixels: u32| (1..=65_535).contains(&pixels);
    if !fits(width) || !fits(height) {
        return Err(RigError::Resolution {
            camera: camera.id.clone(),
            width,
            height,
        });
    }
    match &camera.world_from_camera {
        Some(pose) if !is_finite(pose) => Err(RigError::Pose(camera.id.clone())),
        _ => Ok(()),
    }
}

/// Whether position and orientation are all finite.
pub(crate) fn is_finite(pose: &Pose) -> bool {
    pose.translation
        .vector
        .iter()
        .chain(pose.rotation.coords.iter())
        .all(|x| x.is_finite())
}
