//! Learning a constellation: where each tag of a rigid object sits, from images of the object being turned.
//!
//! A [`LearnSession`] takes images one by one, tells at any time how far things are and what to do next, and solves when
//! asked to; recorded and live images are the same to it.

mod framing;
mod gauge;
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

use crate::image_store::{ImageStore, TagSpec};
use crate::verdict::listed;
use progress::Coverage;
use sextant_estimator::{
    CameraId, ImageObservation, ObjectError, ObjectId, ObjectModel, Rig, TagId,
};
use thiserror::Error;

/// What is to be learned.
#[derive(Clone, Debug)]
pub struct LearnPlan {
    /// The object's name.
    pub object: ObjectId,
    /// The tags to be placed, with the edge of the black square in metres.
    pub tags: Vec<(TagId, f64)>,
    /// Cameras whose images count; none means all of the rig.
    pub cameras: Vec<CameraId>,
    /// The frame of the result. Ignored with [`LearnPlan::from`], whose frame stays.
    pub gauge: Gauge,
    /// An object that is known already: its tags stay where they are unless they are among [`LearnPlan::tags`].
    pub from: Option<ObjectModel>,
}

/// What was learned.
#[derive(Clone, Debug)]
pub struct LearnedObject {
    /// The object with every tag in its place.
    pub object: ObjectModel,
    /// How well, in numbers and words.
    pub report: LearnReport,
}

/// Why nothing could be learned.
#[derive(Clone, Debug, Error)]
pub enum LearnError {
    /// A camera that the rig lacks.
    #[error("the rig has no camera \"{0}\"")]
    UnknownCamera(CameraId),
    /// Nothing to learn.
    #[error("no tag is to be learned: name them with their sizes")]
    NoTag,
    /// The known object has links.
    #[error("object {0} has links: learn each link as an object of its own")]
    Articulated(ObjectId),
    /// No image shows anything of use.
    #[error("{images} images, and none shows a tag of the object{seen}")]
    NothingSeen {
        /// How many images came.
        images: usize,
        /// What they do show, in words.
        seen: String,
    },
    /// Tags that no image shows.
    #[error(
        "no image shows {}: turn the object so that a camera sees every tag, or leave them out",
        listed(tags)
    )]
    NeverSeen {
        /// Which.
        tags: Vec<TagId>,
    },
    /// A camera's images are not those of the rig's camera.
    #[error(
        "{part} % of the tags of camera {camera} lie outside of its {width} x {height} pixels: the rig states another resolution than these images have"
    )]
    Resolution {
        /// The camera.
        camera: CameraId,
        /// How many of a hundred.
        part: usize,
        /// As the rig states it.
        width: u32,
        /// As the rig states it.
        height: u32,
    },
    /// Groups of tags that no image joins.
    #[error("the tags fall into groups that no image shows together: {groups}. {hint}")]
    NotConnected {
        /// The groups.
        islands: Vec<Vec<TagId>>,
        /// In words.
        groups: String,
        /// Which turn would join them.
        hint: String,
    },
    /// Tags that are in no consistent place.
    #[error("{} cannot be placed: {cause}", listed(tags))]
    Inconsistent {
        /// Which.
        tags: Vec<TagId>,
        /// What is probably wrong.
        cause: String,
    },
    /// The gauge's tag is not among those that are learned.
    #[error("tag {0} is to be the object's origin, but is not among its tags")]
    UnknownOrigin(TagId),
    /// No tags were named, and none were found.
    #[error("which tags the object has was not found: {0}")]
    NotDiscovered(String),
    /// Nobody stated how large any tag is.
    #[error(
        "{0}; how large is not to be seen: measure the black square of one and state it, for example with --size NUMBER:METRES"
    )]
    SizeUnknown(String),
    /// The adjustment has no start.
    #[error("the tags could not be adjusted: {0}")]
    Adjustment(#[from] crate::bundle::BundleError),
    /// The result is no object.
    #[error(transparent)]
    Object(#[from] ObjectError),
}

/// Learns from images as they come.
#[derive(Clone, Debug)]
pub struct LearnSession {
    rig: Rig,
    plan: LearnPlan,
    wanted: Vec<TagSpec>,
    images: ImageStore,
    coverage: Coverage,
}

/// Images kept at most; of more, stretches of time are left out, since more of the same adds little.
const MOST_IMAGES: usize = 6000;
/// Fewer tags make no constellation.
const LEAST_TAGS: usize = 2;

impl LearnSession {
    /// Nothing seen yet.
    ///
    /// # Errors
    /// A plan that cannot be carried out, whatever the images show.
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
            coverage: Coverage::of(&wanted),
            images: ImageStore::at_most(MOST_IMAGES),
            rig,
            plan,
            wanted,
        })
    }

    /// Takes an image in. Images of cameras that do not count are passed over.
    pub fn handle(&mut self, image: &ImageObservation) {
        let Some(index) = self.camera_of(image) else {
            return;
        };
        self.coverage
            .add((index, &self.rig.cameras()[index]), &self.wanted, image);
        self.images.push(image);
    }

    /// The same images with fewer tags to be placed; `None` where too few are left or the frame's is not among them.
    fn without(&self, tags: &[TagId]) -> Option<Self> {
        let mut plan = self.plan.clone();
        plan.tags.retain(|(tag, _)| !tags.contains(tag));
        let placed = plan.tags.len() + plan.from.as_ref().map_or(0, |from| from.tags().len());
        if plan.tags.len() == self.plan.tags.len() || placed < LEAST_TAGS {
            return None;
        }
        let mut fewer = Self::new(self.rig.clone(), plan).ok()?;
        self.images.iter().for_each(|image| fewer.handle(image));
        Some(fewer)
    }

    /// How far things are and what to do next.
    pub fn progress(&self) -> LearnProgress {
        self.coverage.progress(&self.wanted)
    }

    /// Whether a camera's images count.
    pub fn counts(&self, camera: &CameraId) -> bool {
        let chosen = self.plan.cameras.is_empty() || self.plan.cameras.contains(camera);
        chosen && self.rig.camera(camera).is_some()
    }

    fn camera_of(&self, image: &ImageObservation) -> Option<usize> {
        let counts = self.counts(&image.camera);
        let mut cameras = self.rig.cameras().iter();
        cameras.position(|c| counts && c.id == image.camera)
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
