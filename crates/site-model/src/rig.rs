//! The cameras of a site: lens, resolution, pose in the world, shutter and exposure, with their priors.

use std::collections::BTreeSet;

use nalgebra::Vector6;
use sextant_geometry::{Lens, Pose};
use thiserror::Error;

use crate::{CameraId, Deviation, ImageObservation, ObjectId, Prior};

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
    /// Maps points of the camera into the world; `None` until calibrated, and where an object carries it.
    pub world_from_camera: Option<Pose>,
    /// What carries it; `None` where it stands still.
    pub mount: Option<Mount>,
    /// Prior of `world_from_camera`, in axes of the world, or of `carrier_from_camera`, in axes of the carrier. Fusion
    /// and calibration default to [`PoseSigma::OF_CAMERA`]; a camera that alone has a pose is exact to fusion, since it
    /// is the frame.
    pub pose_prior: Prior<PoseSigma>,
    /// Prior of `lens`. Fusion and calibration default to [`LensSigma::usual`].
    pub lens_prior: Prior<LensSigma>,
    /// Rolling shutter: seconds from a row to the next, negative if the lowest row is read first. The capture time is
    /// then that of the middle row. `None` with a global shutter.
    pub line_delay_s: Option<f64>,
    /// Exposure and reference of timestamps; `None` if the timestamps are capture times.
    pub exposure: Option<Exposure>,
}

/// A camera's place on the object that carries it.
#[derive(Debug, Clone, PartialEq)]
pub struct Mount {
    /// The object.
    pub carrier: ObjectId,
    /// Maps points of the camera into the object.
    pub carrier_from_camera: Pose,
}

impl Camera {
    /// Whether an image has the size of the lens, as far as it is known: of another size the lens tells nothing.
    pub fn fits(&self, image: &ImageObservation) -> bool {
        image.resolution.is_none_or(|size| size == self.resolution)
    }

    /// Whether it has a place, in the world or on a carrier.
    pub fn is_placed(&self) -> bool {
        self.world_from_camera.is_some() || self.mount.is_some()
    }

    /// A camera with default priors and a global shutter, whose timestamps are capture times.
    pub fn new(
        id: CameraId,
        resolution: [u32; 2],
        lens: Lens,
        world_from_camera: Option<Pose>,
    ) -> Self {
        Self {
            id,
            resolution,
            lens,
            world_from_camera,
            mount: None,
            pose_prior: Prior::Default,
            lens_prior: Prior::Default,
            line_delay_s: None,
            exposure: None,
        }
    }
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
    pub(crate) fn is_sound(&self) -> bool {
        let both = [self.position_m, self.orientation_rad];
        both.iter().all(|sigma| (0.0..=1.0).contains(sigma))
    }
}

impl Deviation for PoseSigma {
    const ZERO: Self = Self::NONE;
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

    fn is_sound(&self) -> bool {
        let both = [self.focal_px, self.distortion_px];
        both.iter()
            .all(|sigma| (0.0..=MOST_LENS_SIGMA_PX).contains(sigma))
    }
}

impl Deviation for LensSigma {
    const ZERO: Self = Self::NONE;
}

/// All cameras of a site, in the given order; the first is the reference for clocks.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Rig {
    cameras: Vec<Camera>,
    scale_sigma: Option<f64>,
}

/// Largest valid standard deviation of a lens, px.
pub const MOST_LENS_SIGMA_PX: f64 = 100.0;

/// Longest readout of a rolling shutter, s: the twist of an object is assumed to be constant for this time.
const LONGEST_READOUT_S: f64 = 0.1;

/// What is invalid in a rig.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum RigError {
    /// Two cameras with one name.
    #[error("camera {0} is there twice")]
    DuplicateCamera(CameraId),
    /// Width or height outside 2..=65535.
    #[error(
        "camera {camera}: the resolution {width} x {height} is not between 2 x 2 and 65535 x 65535"
    )]
    Resolution {
        /// The camera.
        camera: CameraId,
        /// Its width in pixels.
        width: u32,
        /// Its height in pixels.
        height: u32,
    },
    /// An invalid sigma of a camera pose.
    #[error("camera {0}: the sigmas of its pose must lie between 0 and 1 (m, rad)")]
    PoseSigma(CameraId),
    /// An invalid sigma of a lens.
    #[error("camera {0}: the sigmas of its lens must lie between 0 and 100 px")]
    LensSigma(CameraId),
    /// An invalid sigma of the common scale.
    #[error("the sigma of the rig's scale must lie between 0 and 1")]
    ScaleSigma,
    /// An invalid line delay.
    #[error("camera {0}: the line delay must be seconds, all rows within 0.1 s")]
    LineDelay(CameraId),
    /// An invalid exposure.
    #[error("camera {0}: the exposure must lie between 0 and 1 s")]
    Exposure(CameraId),
    /// A position or orientation that is not finite.
    #[error("camera {0}: world_from_camera is not finite")]
    Pose(CameraId),
    /// A position or orientation on its carrier that is not finite.
    #[error("camera {0}: carrier_from_camera is not finite")]
    Mount(CameraId),
    /// A camera that stands still and is carried.
    #[error("camera {0} has a pose in the world and a carrier")]
    TwoPlaces(CameraId),
}

impl RigError {
    /// The camera concerned, if any.
    pub fn camera(&self) -> Option<&CameraId> {
        match self {
            Self::DuplicateCamera(camera)
            | Self::Resolution { camera, .. }
            | Self::PoseSigma(camera)
            | Self::LensSigma(camera)
            | Self::LineDelay(camera)
            | Self::Exposure(camera)
            | Self::Pose(camera)
            | Self::Mount(camera)
            | Self::TwoPlaces(camera) => Some(camera),
            Self::ScaleSigma => None,
        }
    }
}

impl Rig {
    /// Checks the cameras. Standard deviations of zero become [`Prior::Exact`], line delays of zero `None`.
    ///
    /// # Errors
    /// For the first camera with an invalid resolution, pose, standard deviation, line delay or exposure, and for the
    /// first whose name is in use.
    pub fn new(cameras: Vec<Camera>) -> Result<Self, RigError> {
        let cameras: Result<Vec<Camera>, RigError> = cameras.into_iter().map(checked).collect();
        let rig = Self {
            cameras: cameras?,
            scale_sigma: None,
        };
        let mut seen = BTreeSet::new();
        match rig.cameras.iter().find(|camera| !seen.insert(&camera.id)) {
            Some(twice) => Err(RigError::DuplicateCamera(twice.id.clone())),
            None => Ok(rig),
        }
    }

    /// Makes every default prior exact: for simulations.
    #[must_use]
    pub fn exact(mut self) -> Self {
        for camera in &mut self.cameras {
            camera.pose_prior = camera.pose_prior.or(Prior::Exact);
            camera.lens_prior = camera.lens_prior.or(Prior::Exact);
        }
        self
    }

    /// The rig with a standard deviation of the scale that all its positions share, as a share of it; zero is `None`.
    ///
    /// # Errors
    /// Where it does not lie between 0 and 1.
    pub fn with_scale_sigma(mut self, sigma: Option<f64>) -> Result<Self, RigError> {
        if !sigma.is_none_or(|sigma| (0.0..=1.0).contains(&sigma)) {
            return Err(RigError::ScaleSigma);
        }
        self.scale_sigma = sigma.filter(|sigma| *sigma > 0.0);
        Ok(self)
    }

    /// Standard deviation of the scale that all positions share, as a share of it: the cameras' sigmas are without it,
    /// since it displaces all of them alike. `None` if the file does not state it.
    pub fn scale_sigma(&self) -> Option<f64> {
        self.scale_sigma
    }

    /// The rig with this camera in place of the one with its name; unchanged if it is invalid or has no such camera.
    #[must_use]
    pub fn with_camera(mut self, corrected: Camera) -> Self {
        let mut cameras = self.cameras.iter_mut();
        let known = cameras.find(|camera| camera.id == corrected.id);
        if let Some((known, corrected)) = known.zip(checked(corrected).ok()) {
            *known = corrected;
        }
        self
    }

    /// Takes over what is still valid of a former rig: priors of unchanged poses and lenses, line delays and exposures
    /// of images of the same size, and the sigma of the scale where some pose is unchanged, unless this rig has its
    /// own.
    #[must_use]
    pub fn holding_on_to(mut self, former: &Self) -> Self {
        let mut is_placed_alike = false;
        for camera in &mut self.cameras {
            let Some(before) = former.camera(&camera.id) else {
                continue;
            };
            let on_carrier = |camera: &Camera| Some(camera.mount.as_ref()?.carrier_from_camera);
            if is_same(before.world_from_camera, camera.world_from_camera)
                || is_same(on_carrier(before), on_carrier(camera))
            {
                camera.pose_prior = camera.pose_prior.or(before.pose_prior);
                is_placed_alike = true;
            }
            if before.lens == camera.lens {
                camera.lens_prior = camera.lens_prior.or(before.lens_prior);
            }
            if before.resolution == camera.resolution {
                camera.line_delay_s = camera.line_delay_s.or(before.line_delay_s);
                camera.exposure = camera.exposure.or(before.exposure);
            }
        }
        if is_placed_alike {
            self.scale_sigma = self.scale_sigma.or(former.scale_sigma);
        }
        self
    }

    /// The cameras in the given order.
    pub fn cameras(&self) -> &[Camera] {
        &self.cameras
    }

    /// The objects that carry cameras.
    pub fn carriers(&self) -> BTreeSet<&ObjectId> {
        let mounts = self
            .cameras
            .iter()
            .filter_map(|camera| camera.mount.as_ref());
        mounts.map(|mount| &mount.carrier).collect()
    }

    /// The camera of that name.
    pub fn camera(&self, id: &CameraId) -> Option<&Camera> {
        self.cameras.iter().find(|camera| camera.id == *id)
    }
}

/// The camera with exact priors and a global shutter where its numbers are zero.
fn checked(mut camera: Camera) -> Result<Camera, RigError> {
    let [width, height] = camera.resolution;
    let fits = |pixels: u32| (2..=65_535).contains(&pixels);
    let id = || camera.id.clone();
    if !fits(width) || !fits(height) {
        return Err(RigError::Resolution {
            camera: id(),
            width,
            height,
        });
    }
    if !camera.world_from_camera.as_ref().is_none_or(is_finite) {
        return Err(RigError::Pose(id()));
    }
    if let Some(mount) = &camera.mount {
        if camera.world_from_camera.is_some() {
            return Err(RigError::TwoPlaces(id()));
        }
        if !is_finite(&mount.carrier_from_camera) {
            return Err(RigError::Mount(id()));
        }
    }
    let (pose_sigma, lens_sigma) = (camera.pose_prior.given(), camera.lens_prior.given());
    if !pose_sigma.is_none_or(|sigma| sigma.is_sound()) {
        return Err(RigError::PoseSigma(id()));
    }
    if !lens_sigma.is_none_or(|sigma| sigma.is_sound()) {
        return Err(RigError::LensSigma(id()));
    }
    let readout_s = camera.line_delay_s.unwrap_or(0.0).abs() * f64::from(height);
    if !(0.0..=LONGEST_READOUT_S).contains(&readout_s) {
        return Err(RigError::LineDelay(id()));
    }
    if !camera.exposure.is_none_or(|exposure| exposure.is_sound()) {
        return Err(RigError::Exposure(id()));
    }
    camera.pose_prior = pose_sigma.into();
    camera.lens_prior = lens_sigma.into();
    camera.line_delay_s = camera.line_delay_s.filter(|delay_s| *delay_s != 0.0);
    Ok(camera)
}

/// Largest difference, in m and as quaternions, of poses that count as equal, since a transmitted pose may change in
/// its last digits.
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

#[cfg(test)]
mod tests {
    use super::*;
    use sextant_geometry::Intrinsics;

    fn camera() -> Camera {
        let lens = Lens::pinhole(Intrinsics {
            fx: 600.0,
            fy: 600.0,
            cx: 319.5,
            cy: 239.5,
        });
        let id = CameraId::new("north").unwrap();
        Camera::new(id, [640, 480], lens.unwrap(), Some(Pose::identity()))
    }

    fn checked(change: impl Fn(&mut Camera)) -> Result<Camera, RigError> {
        let mut camera = camera();
        change(&mut camera);
        Ok(Rig::new(vec![camera])?.cameras()[0].clone())
    }

    #[test]
    fn a_sigma_of_zero_is_exact_and_a_line_delay_of_zero_is_a_global_shutter() {
        let zero = checked(|camera| {
            camera.pose_prior = Prior::Sigma(PoseSigma::NONE);
            camera.line_delay_s = Some(0.0);
        });
        let exact = checked(|camera| camera.pose_prior = Prior::Exact);
        assert_eq!(zero, exact);
    }

    #[test]
    fn invalid_numbers_are_refused_and_corrections_with_them_ignored() {
        let much = PoseSigma::OF_CAMERA.times(1e3);
        let refused = checked(|camera| camera.pose_prior = Prior::Sigma(much));
        assert_eq!(refused, Err(RigError::PoseSigma(camera().id)));
        let refused = checked(|camera| {
            camera.lens_prior = Prior::Sigma(LensSigma::NONE.times(f64::NAN));
        });
        assert_eq!(refused, Err(RigError::LensSigma(camera().id)));
        for line_delay_s in [0.1, f64::NAN] {
            let refused = checked(|camera| camera.line_delay_s = Some(line_delay_s));
            assert_eq!(refused, Err(RigError::LineDelay(camera().id)));
        }
        let rig = Rig::new(vec![camera()]).unwrap();
        let corrected = rig.clone().with_camera(Camera {
            pose_prior: Prior::Sigma(much),
            ..camera()
        });
        assert_eq!(corrected, rig);
    }
}
