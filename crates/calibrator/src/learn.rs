//! Learning a constellation: the tag poses of a rigid object from images while it is turned.
//!
//! A [`LearnSession`] handles images one by one, reports progress and instructions at any time, and solves on request.
//! Recorded and live images are treated alike.

pub(crate) mod framing;
pub(crate) mod gauge;
mod places;
mod progress;
mod replacing;
mod report;
mod sketch;
mod solved;
mod solving;

pub use gauge::Gauge;
pub use progress::{LearnProgress, TagProgress};
pub(crate) use report::root_mean_square;
pub use report::{LearnReport, LearnedTag};
pub use sketch::SketchedTag;

use crate::image_store::TagSpec;
use crate::session_images::SessionImages;
use crate::verdict::listed;
use progress::Coverage;
use sextant_site_model::{
    CameraId, ImageObservation, ObjectError, ObjectId, ObjectModel, Rig, TagId,
};
use thiserror::Error;

/// Input of a learning session.
#[derive(Clone, Debug)]
pub struct LearnPlan {
    /// The object's name.
    pub object: ObjectId,
    /// The tags to place, with the edge of the black square in metres.
    pub tags: Vec<(TagId, f64)>,
    /// Cameras to use; empty for all of the rig.
    pub cameras: Vec<CameraId>,
    /// The frame of the result. Ignored with [`LearnPlan::from`], whose frame stays.
    pub gauge: Gauge,
    /// A known object: its tags keep their poses unless they are among [`LearnPlan::tags`].
    pub from: Option<ObjectModel>,
}

/// Result of learning: an object with the poses of its tags, and how good they are.
#[derive(Clone, Debug)]
pub struct LearnedObject {
    /// The object with its tag poses.
    pub object: ObjectModel,
    /// Accuracy and verdict.
    pub report: LearnReport,
}

/// Why an object cannot be learned.
#[derive(Clone, Debug, Error)]
pub enum LearnError {
    /// A camera that is not in the rig.
    #[error("the rig has no camera \"{0}\"")]
    UnknownCamera(CameraId),
    /// Nothing to learn.
    #[error("no tag is to be learned: name them with their sizes")]
    NoTag,
    /// The known object has links.
    #[error("object {0} has links: learn each link as an object of its own")]
    Articulated(ObjectId),
    /// No image shows a tag of the object.
    #[error("{images} images, and none shows a tag of the object{seen}")]
    NothingSeen {
        /// Number of images.
        images: usize,
        /// Tags that they show, as text.
        seen: String,
    },
    /// Tags that no image shows.
    #[error(
        "no image shows {}: turn the object so that a camera sees every tag, or leave them out",
        listed(tags)
    )]
    NeverSeen {
        /// The tags.
        tags: Vec<TagId>,
    },
    /// The images of a camera have another resolution than the rig.
    #[error(
        "{part} % of the tags of camera {camera} lie outside of its {width} x {height} pixels: \
         the rig states another resolution than these images have"
    )]
    Resolution {
        /// The camera.
        camera: CameraId,
        /// Per cent of the tags that are outside.
        part: usize,
        /// Resolution in the rig, pixels.
        width: u32,
        /// Resolution in the rig, pixels.
        height: u32,
    },
    /// Groups of tags that no image connects.
    #[error("the tags fall into groups that no image shows together: {groups}. {hint}")]
    NotConnected {
        /// The groups.
        islands: Vec<Vec<TagId>>,
        /// The groups, as text.
        groups: String,
        /// A rotation that would connect them.
        hint: String,
    },
    /// Tags without a consistent pose.
    #[error("{} cannot be placed: {cause}", listed(tags))]
    Inconsistent {
        /// The tags.
        tags: Vec<TagId>,
        /// The probable cause.
        cause: String,
    },
    /// The tag of the frame is not among those that are learned.
    #[error("tag {0} is to be the object's origin, but is not among its tags")]
    UnknownOrigin(TagId),
    /// No tags were given, and none were discovered.
    #[error("which tags the object has was not found: {0}")]
    NotDiscovered(String),
    /// No size of any tag is known.
    #[error(
        "{0}; how large is not to be seen: measure the black square of one and state it, for \
         example with --size NUMBER:METRES"
    )]
    SizeUnknown(String),
    /// The adjustment has no start.
    #[error("the tags could not be adjusted: {0}")]
    Adjustment(#[from] sextant_adjustment::BundleError),
    /// The result is not a valid object.
    #[error(transparent)]
    Object(#[from] ObjectError),
}

/// Learns an object from successive images.
#[derive(Clone, Debug)]
pub struct LearnSession {
    plan: LearnPlan,
    images: SessionImages,
    coverage: Coverage,
}

/// Most stored images.
const MOST_IMAGES: usize = 6000;
/// Least number of tags of a constellation.
const LEAST_TAGS: usize = 2;

impl LearnSession {
    /// Starts a session without images.
    ///
    /// # Errors
    /// A plan that no images can satisfy.
    pub fn new(rig: Rig, plan: LearnPlan) -> Result<Self, LearnError> {
        if let Some(unknown) = plan.cameras.iter().find(|id| rig.camera(id).is_none()) {
            return Err(LearnError::UnknownCamera(unknown.clone()));
        }
        if plan.tags.is_empty() {
            return Err(LearnError::NoTag);
        }
        if let Some(known) = plan.from.as_ref().filter(|o| o.articulation().is_some()) {
            return Err(LearnError::Articulated(known.id().clone()));
        }
        let wanted = wanted(&plan);
        if let Gauge::Tag(origin) = &plan.gauge
            && !wanted.iter().any(|w| w.tag == *origin)
        {
            return Err(LearnError::UnknownOrigin(*origin));
        }
        Ok(Self {
            coverage: Coverage::new(&wanted),
            images: SessionImages::new(rig, wanted, MOST_IMAGES),
            plan,
        })
    }

    /// Handles an image. Images of unused cameras are ignored.
    pub fn handle(&mut self, image: &ImageObservation) {
        let view = Some(image).filter(|image| self.counts(&image.camera));
        if let Some(view) = view.and_then(|image| self.images.push(image)) {
            self.coverage.add(view);
        }
    }

    /// The session without some tags; `None` if too few are left or the gauge tag is not among them.
    fn without(&self, tags: &[TagId]) -> Option<Self> {
        let mut plan = self.plan.clone();
        plan.tags.retain(|(tag, _)| !tags.contains(tag));
        let placed = plan.tags.len() + plan.from.as_ref().map_or(0, |from| from.tags().len());
        if plan.tags.len() == self.plan.tags.len() || placed < LEAST_TAGS {
            return None;
        }
        let mut fewer = Self::new(self.images.rig.clone(), plan).ok()?;
        self.images
            .stored
            .iter()
            .for_each(|image| fewer.handle(image));
        Some(fewer)
    }

    /// Progress so far and what to do next.
    pub fn progress(&self) -> LearnProgress {
        self.coverage.progress(&self.images)
    }

    /// Whether images of a camera are used.
    pub fn counts(&self, camera: &CameraId) -> bool {
        let chosen = self.plan.cameras.is_empty() || self.plan.cameras.contains(camera);
        chosen && self.images.rig.camera(camera).is_some()
    }
}

/// The plan's tags, then those of the known object that stay.
fn wanted(plan: &LearnPlan) -> Vec<TagSpec> {
    let mut wanted: Vec<TagSpec> = Vec::new();
    for &(tag, size_m) in &plan.tags {
        if !wanted.iter().any(|w| w.tag == tag) {
            wanted.push(TagSpec { tag, size_m });
        }
    }
    let known = plan.from.iter().flat_map(|object| object.tags());
    for tag in known.filter(|tag| tag.object_from_tag.is_some()) {
        if !wanted.iter().any(|w| w.tag == tag.tag) {
            wanted.push(TagSpec {
                tag: tag.tag,
                size_m: tag.size_m,
            });
        }
    }
    wanted.sort_by_key(|w| w.tag);
    wanted
}
