//! The rig and the objects that a site works with, as its fusion node last read them.

use crate::check::{self, OutOfRange, holds};
use crate::envelope::{Kind, Message};
use crate::limits::{MAX_CAMERAS, MAX_OBJECT_TAGS};
use crate::wire;
use serde::{Deserialize, Serialize};
use sextant_estimator::{CameraId, ObjectId};
use sextant_tag_families::Family;

/// The cameras of a site.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct RigConfig {
    /// In the order of the rig's file; ids are unique.
    #[serde(deserialize_with = "wire::list::at_most::<_, _, MAX_CAMERAS>")]
    pub cameras: Vec<CameraConfig>,
}

/// One camera of a site.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct CameraConfig {
    /// Its id.
    pub id: CameraId,
    /// Width and height of its images, pixels.
    pub resolution: [u32; 2],
    /// Its lens.
    pub lens: LensConfig,
    /// `world_from_camera`; none until calibrated.
    pub world_from_camera: Option<PoseConfig>,
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

/// A rigid motion `a_from_b`.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct PoseConfig {
    /// b's origin in a, metres.
    pub position: [f64; 3],
    /// b's axes in a, x, y, z, w.
    pub orientation: [f64; 4],
}

/// One object and its tags.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ObjectConfig {
    /// Its id.
    pub id: ObjectId,
    /// Its tags, in the order of its file.
    #[serde(deserialize_with = "wire::list::at_most::<_, _, MAX_OBJECT_TAGS>")]
    pub tags: Vec<ObjectTagConfig>,
}

/// One tag of an object.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ObjectTagConfig {
    /// Its family, on the wire the name.
    pub family: Family,
    /// Its number within the family.
    pub id: u32,
    /// Edge of its black square, metres.
    pub size_m: f64,
    /// `object_from_tag`; none until learned.
    pub object_from_tag: Option<PoseConfig>,
}

impl Message for RigConfig {
    const KIND: Kind = Kind::RigConfig;

    fn check(&self) -> Result<(), OutOfRange> {
        holds(self.cameras.len() <= MAX_CAMERAS, "cameras")?;
        self.cameras.iter().try_for_each(CameraConfig::check)
    }
}

impl Message for ObjectConfig {
    const KIND: Kind = Kind::ObjectConfig;

    fn check(&self) -> Result<(), OutOfRange> {
        holds(self.tags.len() <= MAX_OBJECT_TAGS, "tags")?;
        self.tags.iter().try_for_each(ObjectTagConfig::check)
    }
}

impl CameraConfig {
    pub(crate) fn check(&self) -> Result<(), OutOfRange> {
        holds(!self.resolution.contains(&0), "cameras[].resolution")?;
        check::finite(&self.lens.numbers(), "cameras[].lens")?;
        PoseConfig::check(self.world_from_camera, "cameras[].world_from_camera")
    }
}

impl ObjectTagConfig {
    pub(crate) fn check(&self) -> Result<(), OutOfRange> {
        holds(
            self.size_m.is_finite() && self.size_m > 0.0,
            "tags[].size_m",
        )?;
        PoseConfig::check(self.object_from_tag, "tags[].object_from_tag")
    }
}

impl PoseConfig {
    pub(crate) fn check(pose: Option<Self>, field: &'static str) -> Result<(), OutOfRange> {
        let Some(pose) = pose else { return Ok(()) };
        check::placement(pose.position, field)?;
        check::orientation(pose.orientation, field)
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
