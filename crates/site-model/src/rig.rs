//! The cameras of a site: lens, resolution and pose in the world.

use std::collections::BTreeMap;

use nalgebra::Vector6;
use sextant_geometry::{Lens, Pose};
use thiserror::Error;

use crate::CameraId;

mod exposure;

pub use exposure::{Exposure, Stamp};

/// One camera: a map from points of the world to pixels.
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

/// Standard deviation of the pose of a camera or tag, per axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PoseSigma {
    /// Of the position, m.
    pub position_m: f64,
    /// Of the orientation, rad.
    pub orientation_rad: f64,
}

impl PoseSigma {
    /// Zero: exact.
    pub const NONE: Self = Self {
        position_m: 0.0,
        orientation_rad: 0.0,
    };
    /// Default for a camera that was placed by hand.
    pub const OF_CAMERA: Self = Self {
        position_m: 0.01,
        orientation_rad: 0.01,
    };
    /// Default for a tag that was glued on by hand.
    pub const OF_TAG: Self = Self {
        position_m: 0.001,
        orientation_rad: 0.017,
    };

    /// Scaled by a factor.
    pub fn times(self, factor: f64) -> Self {
        Self {
            position_m: self.position_m * factor,
            orientation_rad: self.orientation_rad * factor,
        }
    }

    /// Whether it is not zero.
    pub fn is_some(&self) -> bool {
        self.position_m > 0.0 || self.orientation_rad > 0.0
    }

    /// Variances of (dt, dr), m² and rad².
    pub fn variance(self) -> Vector6<f64> {
        let (t, r) = (self.position_m.powi(2), self.orientation_rad.powi(2));
        Vector6::new(t, t, t, r, r, r)
    }

    /// Whether both are between 0 and 1.
    pub fn is_sound(&self) -> bool {
        let both = [self.position_m, self.orientation_rad];
        both.iter().all(|sigma| (0.0..=1.0).contains(sigma))
    }
}

/// Standard deviations of a camera's lens, apart from what a rotation of the whole camera compensates.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LensSigma {
    /// Of the focal length along both axes together, px.
    pub focal_px: f64,
    /// Of the distortion: displacement of the image's corners outwards or inwards, px; elsewhere it grows with the cube
    /// of the distance from the centre.
    pub distortion_px: f64,
}

impl LensSigma {
    /// Zero: exact.
    pub const NONE: Self = Self {
        focal_px: 0.0,
        distortion_px: 0.0,
    };

    /// Default for a lens that was calibrated on another day: 0.3 % of the focal length, half a pixel in the corners of the image.
    pub fn usual(lens: &Lens) -> Self {
        let is_bending = !lens.distortion().is_empty();
        Self {
            focal_px: 0.003 * lens.intrinsics().fx,
            distortion_px: if is_bending { 0.5 } else { 0.0 },
        }
    }

    /// Scaled by a factor.
    pub fn times(self, factor: f64) -> Self {
        Self {
            focal_px: self.focal_px * factor,
            distortion_px: self.distortion_px * factor,
        }
    }

    /// Variances of focal length and distortion, px²; other elements are zero.
    pub fn variance(self) -> Vector6<f64> {
        let (focal, distortion) = (self.focal_px.powi(2), self.distortion_px.powi(2));
        Vector6::new(focal, distortion, 0.0, 0.0, 0.0, 0.0)
    }

    /// Whether it is not zero.
    pub fn is_some(&self) -> bool {
        self.focal_px > 0.0 || self.distortion_px > 0.0
    }
}

/// All cameras of a site, in the given order; the first is the reference for clocks.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Rig {
    cameras: Vec<Camera>,
    pose_sigmas: BTreeMap<CameraId, PoseSigma>,
    lens_sigmas: BTreeMap<CameraId, LensSigma>,
    line_delays_s: BTreeMap<CameraId, f64>,
    exposures: BTreeMap<CameraId, Exposure>,
}

/// Largest valid standard deviation of a lens, px.
pub const MOST_LENS_SIGMA_PX: f64 = 100.0;

/// Longest readout of a rolling shutter, s: the twist of an object is assumed to be constant for this time.
const LONGEST_READOUT_S: f64 = 0.1;

/// An invalid rig.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum RigError {
    /// Two cameras with one name.
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
    /// An invalid sigma of a camera pose, or one of a missing camera.
    #[error("camera {0}: the sigmas of its pose must lie between 0 and 1 (m, rad)")]
    PoseSigma(CameraId),
    /// An invalid sigma of a lens, or one of a missing camera.
    #[error("camera {0}: the sigmas of its lens must lie between 0 and 100 px")]
    LensSigma(CameraId),
    /// An invalid line delay, or one of a missing camera.
    #[error("camera {0}: the line delay must be seconds, all rows within 0.1 s")]
    LineDelay(CameraId),
    /// An invalid exposure, or one of a missing camera.
    #[error("camera {0}: the exposure must lie between 0 and 1 s")]
    Exposure(CameraId),
    /// A position or orientation that is not finite.
    #[error("camera {0}: world_from_camera is not finite")]
    Pose(CameraId),
}

impl RigError {
    /// The camera concerned.
    pub fn camera(&self) -> &CameraId {
        match self {
            Self::DuplicateCamera(camera)
            | Self::Resolution { camera, .. }
            | Self::PoseSigma(camera)
            | Self::LensSigma(camera)
            | Self::LineDelay(camera)
            | Self::Exposure(camera)
            | Self::Pose(camera) => camera,
        }
    }
}

impl Rig {
    /// Checks the cameras.
    ///
    /// # Errors
    /// For the first camera whose name is in use, or whose resolution or pose is invalid.
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
            ..Self::default()
        })
    }

    /// The rig with standard deviations of its camera poses. Cameras without one count as exact.
    ///
    /// # Errors
    /// For the first missing camera, and the first invalid sigma.
    pub fn with_pose_sigmas(
        mut self,
        sigmas: impl IntoIterator<Item = (CameraId, PoseSigma)>,
    ) -> Result<Self, RigError> {
        for (camera, sigma) in sigmas {
            if !sigma.is_sound() || self.camera(&camera).is_none() {
                return Err(RigError::PoseSigma(camera));
            }
            self.pose_sigmas.insert(camera, sigma);
        }
        Ok(self)
    }

    /// The rig with standard deviations of its lenses; lenses without one count as exact.
    ///
    /// # Errors
    /// For the first missing camera, and the first invalid sigma.
    pub fn with_lens_sigmas(
        mut self,
        sigmas: impl IntoIterator<Item = (CameraId, LensSigma)>,
    ) -> Result<Self, RigError> {
        for (camera, sigma) in sigmas {
            let both = [sigma.focal_px, sigma.distortion_px];
            let sound = both
                .iter()
                .all(|sigma| (0.0..=MOST_LENS_SIGMA_PX).contains(sigma));
            if !sound || self.camera(&camera).is_none() {
                return Err(RigError::LensSigma(camera));
            }
            self.lens_sigmas.insert(camera, sigma);
        }
        Ok(self)
    }

    /// Declares every number without a sigma exact: for simulations.
    #[must_use]
    pub fn exact(mut self) -> Self {
        let nothing = LensSigma {
            focal_px: 0.0,
            distortion_px: 0.0,
        };
        for camera in &self.cameras {
            let id = &camera.id;
            self.pose_sigmas
                .entry(id.clone())
                .or_insert(PoseSigma::NONE);
            self.lens_sigmas.entry(id.clone()).or_insert(nothing);
        }
        self
    }

    /// The rig with another pose and lens of a camera, and their sigmas; unchanged if they are invalid.
    #[must_use]
    pub fn with_camera(
        mut self,
        corrected: Camera,
        sigma: PoseSigma,
        lens_sigma: Option<LensSigma>,
    ) -> Self {
        let mut cameras = self.cameras.iter_mut();
        let known = cameras.find(|camera| camera.id == corrected.id);
        if let Some(camera) = known.filter(|_| check(&corrected).is_ok()) {
            let id = corrected.id.clone();
            *camera = corrected;
            self.pose_sigmas.insert(id.clone(), sigma);
            if let Some(lens_sigma) = lens_sigma {
                self.lens_sigmas.insert(id, lens_sigma);
            }
        }
        self
    }

    /// Standard deviation of the lens of a camera, if given.
    pub fn lens_sigma(&self, id: &CameraId) -> Option<LensSigma> {
        self.lens_sigmas.get(id).copied()
    }

    /// Cameras with a given standard deviation of their lens.
    pub fn lens_sigmas(&self) -> impl Iterator<Item = (CameraId, LensSigma)> {
        let sigmas = self.lens_sigmas.iter();
        sigmas.map(|(camera, sigma)| (camera.clone(), *sigma))
    }

    /// The rig with rolling shutters: seconds from a row of the camera's images to the next, negative if the lowest row
    /// is read first. The capture time of such an image is that of its middle row. Without it, or with 0, all rows have one time.
    ///
    /// # Errors
    /// For the first missing camera, and the first delay by which an image takes more than 0.1 s.
    pub fn with_line_delays(
        mut self,
        delays_s: impl IntoIterator<Item = (CameraId, f64)>,
    ) -> Result<Self, RigError> {
        for (camera, delay_s) in delays_s {
            let rows = self.camera(&camera).map(|camera| camera.resolution[1]);
            let readout_s = delay_s.abs() * rows.map_or(f64::INFINITY, f64::from);
            if !(0.0..=LONGEST_READOUT_S).contains(&readout_s) {
                return Err(RigError::LineDelay(camera));
            }
            if delay_s != 0.0 {
                self.line_delays_s.insert(camera, delay_s);
            }
        }
        Ok(self)
    }

    /// Takes over what is still valid of a former rig: sigmas of unchanged poses and lenses, and
    /// line delays and exposures of images of the same size, unless this rig has its own.
    #[must_use]
    pub fn holding_on_to(mut self, former: &Self) -> Self {
        for camera in &self.cameras {
            let Some(before) = former.camera(&camera.id) else {
                continue;
            };
            let id = &camera.id;
            if let Some(sigma) = former.pose_sigma(id)
                && is_same(before.world_from_camera, camera.world_from_camera)
            {
                self.pose_sigmas.entry(id.clone()).or_insert(sigma);
            }
            if let Some(sigma) = former.lens_sigma(id)
                && before.lens == camera.lens
            {
                self.lens_sigmas.entry(id.clone()).or_insert(sigma);
            }
            if before.resolution != camera.resolution {
                continue;
            }
            if let Some(delay_s) = former.line_delay_s(id) {
                self.line_delays_s.entry(id.clone()).or_insert(delay_s);
            }
            if let Some(exposure) = former.exposure(id) {
                self.exposures.entry(id.clone()).or_insert(exposure);
            }
        }
        self
    }

    /// Cameras with rolling shutters, with their line delays in seconds.
    pub fn line_delays_s(&self) -> impl Iterator<Item = (CameraId, f64)> {
        let delays = self.line_delays_s.iter();
        delays.map(|(camera, delay_s)| (camera.clone(), *delay_s))
    }

    /// Seconds from a row of a camera's images to the next; `None` with a global shutter.
    pub fn line_delay_s(&self, id: &CameraId) -> Option<f64> {
        self.line_delays_s.get(id).copied()
    }

    /// Standard deviation of the pose of a camera, if given.
    pub fn pose_sigma(&self, id: &CameraId) -> Option<PoseSigma> {
        self.pose_sigmas.get(id).copied()
    }

    /// The cameras in the given order.
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

/// Largest difference, in m and as quaternions, of poses that count as equal, since a transmitted pose may change in its last
/// digits.
const ROUNDING: f64 = 1e-9;

/// Whether both exist and are equal up to rounding.
pub(crate) fn is_same(one: Option<Pose>, other: Option<Pose>) -> bool {
    let Some((one, other)) = one.zip(other) else {
        return false;
    };
    let (a, b) = (one.rotation.coords, other.rotation.coords);
    let apart = (one.translation.vector - other.translation.vector).norm();
    apart <= ROUNDING && (a - b).norm().min((a + b).norm()) <= ROUNDING
}

/// Whether position and orientation are finite.
pub fn is_finite(pose: &Pose) -> bool {
    pose.translation
        .vector
        .iter()
        .chain(pose.rotation.coords.iter())
        .all(|x| x.is_finite())
}
