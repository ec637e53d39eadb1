//! Calibrating a site from nothing: lenses, camera poses, objects and clocks from one recording in which tagged things
//! are carried about.
//!
//! Only the sizes of tags and images are known. The stages: a focal length of each camera from its single tags
//! ([`focal_length`]); tags by what they move with; lenses and constellations from each image by itself
//! ([`constellations`]); camera poses from what cameras see at the same time; one adjustment of everything with the
//! clocks ([`solving`]); the world frame and the scale ([`world`]). A [`SiteSession`] takes images one by one and
//! solves when asked to, as the other sessions do.

mod constellations;
mod focal_length;
mod judgement;
mod members;
mod report;
mod scales;
mod solution;
mod solving;
mod world;

pub use report::{SiteCameraReport, SiteObjectReport, SiteReport};

use crate::image_store::ImageStore;
use crate::rig::RigError;
use sextant_site_model::{CameraId, ImageObservation, ObjectModel, Rig, TagId};
use sextant_tag_families::Family;
use thiserror::Error;

/// What is known of a site before its calibration.
#[derive(Clone, Debug)]
pub struct SitePlan {
    /// The cameras with the sizes of their images, width and height in pixels; the first one that can be placed is the
    /// reference of deviations and clocks.
    pub cameras: Vec<(CameraId, [u32; 2])>,
    /// The families of tags that count.
    pub families: Vec<Family>,
    /// Edge of the black square that most tags have, metres.
    pub size_m: f64,
    /// Sizes of the other tags, metres.
    pub sizes: Vec<(TagId, f64)>,
    /// The static tag whose frame is the world. `None`: the static tag that most cameras see or, without any, the first
    /// camera.
    pub world: Option<TagId>,
    /// Measured distances, which determine the scale.
    pub distances: Vec<MeasuredDistance>,
}

/// A measured distance between the centres of two tags that do not move relative to each other.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MeasuredDistance {
    /// The tags.
    pub tags: [TagId; 2],
    /// Metres.
    pub distance_m: f64,
    /// Standard deviation of the measurement, metres.
    pub sigma_m: f64,
}

/// Result of a calibration from nothing but sizes of tags, with its accuracy.
#[derive(Clone, Debug)]
pub struct CalibratedSite {
    /// Every camera with its lens, and its pose if it could be placed.
    pub rig: Rig,
    /// The objects that were carried and, where there are static tags, the room.
    pub objects: Vec<ObjectModel>,
    /// Accuracy and verdict.
    pub report: SiteReport,
}

/// Why a site could not be calibrated.
#[derive(Clone, Debug, Error)]
pub enum SiteError {
    /// No camera.
    #[error("there is no camera")]
    NoCamera,
    /// No tag in any image.
    #[error("{0} images, and none shows a tag: check light, focus, distance and family")]
    NothingSeen(usize),
    /// No tag moved.
    #[error("{0} were seen, but none of them moved: carry tagged things about before the cameras")]
    NothingMoves(String),
    /// The tags of no object could be placed.
    #[error(
        "no object could be learned: {0}; turn each object so that neighbouring tags are seen together"
    )]
    NoObject(String),
    /// No two cameras share views.
    #[error(
        "no two cameras see an object at the same time: carry one where the views of cameras overlap"
    )]
    NotConnected,
    /// The requested world frame is not usable.
    #[error("{0} is to be the world, but {1}")]
    World(TagId, &'static str),
    /// A measured distance that the images cannot use.
    #[error("the distance between {0} and {1}: {2}")]
    Distance(TagId, TagId, &'static str),
    /// Of the camera poses and clocks.
    #[error(transparent)]
    Rig(#[from] RigError),
    /// The adjustment has no start.
    #[error("the site could not be adjusted: {0}")]
    Adjustment(#[from] sextant_adjustment::BundleError),
    /// The result is not a valid rig or object.
    #[error("the result is not valid: {0}")]
    Result(String),
}

/// Most stored images.
const MOST_IMAGES: usize = 8000;

/// Calibrates a site from successive images.
#[derive(Clone, Debug)]
pub struct SiteSession {
    plan: SitePlan,
    images: ImageStore,
}

impl SiteSession {
    /// Starts a session without images.
    ///
    /// # Errors
    /// A plan without cameras.
    pub fn new(plan: SitePlan) -> Result<Self, SiteError> {
        if plan.cameras.is_empty() {
            return Err(SiteError::NoCamera);
        }
        Ok(Self {
            images: ImageStore::at_most(MOST_IMAGES),
            plan,
        })
    }

    /// Handles an image. Images of unknown cameras, and of another size, are ignored.
    pub fn handle(&mut self, image: &ImageObservation) {
        let is_known = |(id, size): &(CameraId, [u32; 2])| {
            *id == image.camera && image.resolution.is_none_or(|of_image| of_image == *size)
        };
        if self.plan.cameras.iter().any(is_known) {
            self.images.push(image);
        }
    }
}
