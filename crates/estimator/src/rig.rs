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

/// All cameras of a site, in the order given; the first is the reference for clocks.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Rig {
    cameras: Vec<Camera>,
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
        Ok(Self { cameras })
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
