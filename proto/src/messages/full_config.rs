//! A rig and an object with everything that their files state: the configuration of [`crate::RigConfig`],
//! [`crate::ObjectConfig`] or [`crate::ArticulatedConfig`], and what these leave out: how well cameras, lenses and tags' places
//! are known, when the rows of an image are taken and which moment is stamped.

use crate::check::{self, OutOfRange, holds};
use crate::envelope::{Kind, Message};
use crate::limits::{MAX_CAMERAS, MAX_LINKS, MAX_OBJECT_TAGS};
use crate::messages::articulated_config::JointConfig;
use crate::messages::config::{CameraConfig, ObjectTagConfig};
use crate::wire;
use serde::{Deserialize, Serialize};
use sextant_estimator::{LinkId, ObjectId, Stamp};

/// The cameras of a site.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct FullRig {
    /// In the order of the rig's file; ids are unique.
    #[serde(deserialize_with = "wire::list::at_most::<_, _, MAX_CAMERAS>")]
    pub cameras: Vec<FullCamera>,
}

/// One camera; what is none is not stated.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct FullCamera {
    /// As in [`crate::RigConfig`].
    pub camera: CameraConfig,
    /// How well its pose is known.
    pub pose_sigma: Option<SigmaConfig>,
    /// How well its lens is known.
    pub lens_sigma: Option<LensSigmaConfig>,
    /// Seconds from a row of its images to the next, below zero where the lowest is read first.
    pub line_delay_s: Option<f64>,
    /// How its images are exposed and stamped.
    pub exposure: Option<ExposureConfig>,
}

/// One standard deviation an axis.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct SigmaConfig {
    /// Of a position, metres.
    pub position_m: f64,
    /// Of an orientation, radians.
    pub orientation_rad: f64,
}

/// One standard deviation each, pixels.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct LensSigmaConfig {
    /// Of fx and fy alike.
    pub focal_px: f64,
    /// Of the distortion, at the image's corners.
    pub distortion_px: f64,
}

/// The exposure of a camera's images.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct ExposureConfig {
    /// How long a row is exposed, seconds, unless an image says so itself.
    pub length_s: f64,
    /// Which moment its capture times are of; on the wire the number of the variant, from 0.
    pub stamp: Stamp,
}

/// One object, rigid or of links.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct FullObject {
    /// Its id.
    pub id: ObjectId,
    /// Its links, in the order of its file; none where it is rigid.
    #[serde(deserialize_with = "wire::list::at_most::<_, _, MAX_LINKS>")]
    pub links: Vec<LinkId>,
    /// Its joints, as in [`crate::ArticulatedConfig`].
    #[serde(deserialize_with = "wire::list::at_most::<_, _, MAX_LINKS>")]
    pub joints: Vec<JointConfig>,
    /// Its tags, in the order of its file, at least one.
    #[serde(deserialize_with = "wire::list::at_most::<_, _, MAX_OBJECT_TAGS>")]
    pub tags: Vec<FullTag>,
}

/// One tag of an object.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct FullTag {
    /// Place of its link in the list, from 0; 0 where the object is rigid.
    pub link: u8,
    /// As in [`crate::ObjectConfig`]; on a link its `object_from_tag` is `link_from_tag`.
    pub tag: ObjectTagConfig,
    /// How well its place is known; none where that is not stated.
    pub sigma: Option<SigmaConfig>,
}

impl Message for FullRig {
    const KIND: Kind = Kind::FullRig;

    fn check(&self) -> Result<(), OutOfRange> {
        holds(self.cameras.len() <= MAX_CAMERAS, "cameras")?;
        self.cameras.iter().try_for_each(FullCamera::check)
    }
}

impl Message for FullObject {
    const KIND: Kind = Kind::FullObject;

    fn check(&self) -> Result<(), OutOfRange> {
        holds(self.links.len() <= MAX_LINKS, "links")?;
        holds(self.joints.len() <= MAX_LINKS, "joints")?;
        holds((1..=MAX_OBJECT_TAGS).contains(&self.tags.len()), "tags")?;
        self.joints.iter().try_for_each(JointConfig::check)?;
        let links = self.links.len().max(1);
        self.tags.iter().try_for_each(|one| {
            holds(usize::from(one.link) < links, "tags[].link")?;
            one.tag.check()?;
            SigmaConfig::check(one.sigma, "tags[].sigma")
        })
    }
}

impl FullCamera {
    fn check(&self) -> Result<(), OutOfRange> {
        self.camera.check()?;
        SigmaConfig::check(self.pose_sigma, "cameras[].pose_sigma")?;
        let lens = self
            .lens_sigma
            .map(|lens| [lens.focal_px, lens.distortion_px]);
        amounts(lens, "cameras[].lens_sigma")?;
        check::finite(self.line_delay_s.as_slice(), "cameras[].line_delay_s")?;
        let exposure = self.exposure.map(|exposure| [exposure.length_s; 2]);
        amounts(exposure, "cameras[].exposure")
    }
}

impl SigmaConfig {
    fn check(sigma: Option<Self>, field: &'static str) -> Result<(), OutOfRange> {
        let both = sigma.map(|sigma| [sigma.position_m, sigma.orientation_rad]);
        amounts(both, field)
    }
}

fn amounts(values: Option<[f64; 2]>, field: &'static str) -> Result<(), OutOfRange> {
    let mut values = values.into_iter().flatten();
    values.try_for_each(|value| check::amount(value, field))
}
