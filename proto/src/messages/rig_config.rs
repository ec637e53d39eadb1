//! The cameras of a site: everything that its rig file can say.

use crate::check::{self, OutOfRange, holds};
use crate::envelope::{Message, MessageKind};
use crate::limits::MAX_CAMERAS;
use crate::messages::pose_config::{PoseConfig, SigmaConfig};
use crate::wire;
use serde::{Deserialize, Serialize};
use sextant_site_model::{CameraId, ObjectId, Stamp};

/// The cameras of a site.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct RigConfig {
    /// In the order of the rig's file; ids are unique.
    #[serde(deserialize_with = "wire::list::at_most::<_, _, MAX_CAMERAS>")]
    pub cameras: Vec<CameraConfig>,
    /// Standard deviation of the scale that all positions share, as a share of it; none where the file gives none.
    pub scale_sigma: Option<f64>,
}

/// One camera of a site; optional fields are none where the file does not give them.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct CameraConfig {
    /// Its id.
    pub id: CameraId,
    /// Width and height of its images, pixels.
    pub resolution: [u32; 2],
    /// Its lens.
    pub lens: LensConfig,
    /// Standard deviations of the lens.
    pub lens_sigma: Option<LensSigmaConfig>,
    /// `world_from_camera`; none until calibrated, and where an object carries the camera.
    pub world_from_camera: Option<PoseConfig>,
    /// Its place on the object that carries it; none where it stands still.
    pub mount: Option<MountConfig>,
    /// Standard deviation of that pose, whichever it is.
    pub world_from_camera_sigma: Option<SigmaConfig>,
    /// Seconds from one row of an image to the next, negative where the bottom row is read first; none for a global
    /// shutter.
    pub line_delay_s: Option<f64>,
    /// How its images are exposed and stamped.
    pub exposure: Option<ExposureConfig>,
}

/// A camera's place on the object that carries it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct MountConfig {
    /// The object.
    pub carrier: ObjectId,
    /// `carrier_from_camera`.
    pub carrier_from_camera: PoseConfig,
}

/// A lens; on the wire the number of the variant, from 0. Focal lengths and centre in pixels.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
#[allow(missing_docs, reason = "the fields are the rig file's, named there")]
pub enum LensConfig {
    /// No distortion.
    Pinhole { fx: f64, fy: f64, cx: f64, cy: f64 },
    /// Distortion k1, k2, p1, p2, k3.
    BrownConrady {
        fx: f64,
        fy: f64,
        cx: f64,
        cy: f64,
        distortion: [f64; 5],
    },
    /// Distortion k1, k2, k3, k4.
    KannalaBrandt {
        fx: f64,
        fy: f64,
        cx: f64,
        cy: f64,
        distortion: [f64; 4],
    },
}

impl LensConfig {
    /// fx, fy, cx, cy.
    pub const fn intrinsics(&self) -> [f64; 4] {
        match *self {
            Self::Pinhole { fx, fy, cx, cy }
            | Self::BrownConrady { fx, fy, cx, cy, .. }
            | Self::KannalaBrandt { fx, fy, cx, cy, .. } => [fx, fy, cx, cy],
        }
    }

    /// Distortion coefficients in the order of the model; empty for a pinhole.
    pub const fn distortion(&self) -> &[f64] {
        match self {
            Self::Pinhole { .. } => &[],
            Self::BrownConrady { distortion, .. } => distortion,
            Self::KannalaBrandt { distortion, .. } => distortion,
        }
    }
}

/// Standard deviations of a lens, pixels; 0 where it is exact.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct LensSigmaConfig {
    /// Of fx and fy together.
    pub focal_px: f64,
    /// Of the distortion, at the image's corners.
    pub distortion_px: f64,
}

/// The exposure of a camera's images.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct ExposureConfig {
    /// How long a row is exposed, seconds; an image that gives its own exposure overrides it.
    pub length_s: f64,
    /// The moment of the exposure that time stamps are of; on the wire the number of the variant, from 0.
    pub stamp: Stamp,
}

impl Message for RigConfig {
    const KIND: MessageKind = MessageKind::RigConfig;

    fn check(&self) -> Result<(), OutOfRange> {
        holds(self.cameras.len() <= MAX_CAMERAS, "cameras")?;
        self.cameras.iter().try_for_each(CameraConfig::check)?;
        check::amount(self.scale_sigma.unwrap_or(0.0), "scale_sigma")
    }
}

impl CameraConfig {
    fn check(&self) -> Result<(), OutOfRange> {
        holds(!self.resolution.contains(&0), "cameras[].resolution")?;
        check::finite(&self.lens.numbers(), "cameras[].lens")?;
        if let Some(sigma) = self.lens_sigma {
            check::amount(sigma.focal_px, "cameras[].lens_sigma")?;
            check::amount(sigma.distortion_px, "cameras[].lens_sigma")?;
        }
        PoseConfig::check(self.world_from_camera, "cameras[].world_from_camera")?;
        let mount = self.mount.as_ref().map(|mount| mount.carrier_from_camera);
        PoseConfig::check(mount, "cameras[].mount.carrier_from_camera")?;
        SigmaConfig::check(
            self.world_from_camera_sigma,
            "cameras[].world_from_camera_sigma",
        )?;
        check::finite(self.line_delay_s.as_slice(), "cameras[].line_delay_s")?;
        let length_s = self.exposure.map_or(0.0, |exposure| exposure.length_s);
        check::amount(length_s, "cameras[].exposure")
    }
}

impl LensConfig {
    /// fx, fy, cx, cy, then the distortion, padded with zeros.
    fn numbers(&self) -> [f64; 9] {
        let mut all = [0.0; 9];
        let (head, tail): ([f64; 4], &[f64]) = match self {
            Self::Pinhole { fx, fy, cx, cy } => ([*fx, *fy, *cx, *cy], &[]),
            Self::BrownConrady {
                fx,
                fy,
                cx,
                cy,
                distortion,
            } => ([*fx, *fy, *cx, *cy], distortion),
            Self::KannalaBrandt {
                fx,
                fy,
                cx,
                cy,
                distortion,
            } => ([*fx, *fy, *cx, *cy], distortion),
        };
        all[..4].copy_from_slice(&head);
        all[4..4 + tail.len()].copy_from_slice(tail);
        all
    }
}
