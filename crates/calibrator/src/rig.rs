//! Calibrating a rig: where every camera is, from an object carried through what they see.
//!
//! The object's tags may be known or not, cameras may never see it at the same time as the reference as long as others
//! join them, shutters need not be synchronised, clocks may be off. A [`RigSession`] takes images one by one, tells at
//! any time how far things are and what to do next, and solves when asked to; recorded and live images are the same to
//! it.

pub(crate) mod clocks;
pub(crate) mod comparison;
mod former;
pub(crate) mod instants;
mod judgement;
mod origin;
pub(crate) mod pairs;
mod progress;
mod report;
pub(crate) mod sightings;
mod solving;
mod stillness;
pub(crate) mod trajectory;
mod unknown_object;

pub use origin::{Origin, Up};
pub use progress::{CameraProgress, RigProgress};
pub use report::{CalibratedCamera, RigReport};

use crate::image_store::TagSpec;
use crate::session_images::SessionImages;
use progress::Coverage;
use sextant_site_model::{CameraId, ImageObservation, ObjectId, ObjectModel, Rig, TagId};
use thiserror::Error;

/// What is to be calibrated.
#[derive(Clone, Debug)]
pub struct RigPlan {
    /// What is carried; tags without `object_from_tag` are placed on the way.
    pub object: ObjectModel,
    /// The frame of the result.
    pub origin: Origin,
}

/// Result of a calibration of camera poses, with its accuracy.
#[derive(Clone, Debug)]
pub struct CalibratedRig {
    /// Every camera with its pose and, save the reference, how well that is known relative to the reference.
    pub rig: Rig,
    /// Accuracy and verdict.
    pub report: RigReport,
}

/// Why a rig could not be calibrated.
#[derive(Clone, Debug, Error)]
pub enum RigError {
    /// The object has links.
    #[error("object {0} has links: carry a rigid one")]
    Articulated(ObjectId),
    /// The origin's camera or tag is unknown.
    #[error("the origin, {0}, is not there")]
    UnknownOrigin(String),
    /// Nothing of use in any image.
    #[error("{images} images, and none shows a tag of object {object}{seen}")]
    NothingSeen {
        /// Number of images.
        images: usize,
        /// The object's name.
        object: ObjectId,
        /// Tags that they show, in words.
        seen: String,
    },
    /// The images of a camera have another resolution than the rig.
    #[error(
        "camera {camera}: {part} % of the tags lie outside of its {width} x {height} pixels: the \
         rig states another resolution than these images have"
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
    /// A tag that is there twice.
    #[error(
        "tag {tag} is in {images} images twice at once: take one of the two away, or print another number"
    )]
    Doubled {
        /// The tag.
        tag: TagId,
        /// How often.
        images: usize,
    },
    /// Cameras that cannot be joined with the rest.
    #[error("{cameras}: {hint}")]
    NotConnected {
        /// Who.
        apart: Vec<CameraId>,
        /// The same, in words.
        cameras: String,
        /// What to do.
        hint: String,
    },
    /// Cameras whose tags are not arranged as on the object.
    #[error(
        "{cameras} did not see {object}: the tags there are arranged otherwise; show it the \
         object's face, not its back through the paper, and take away what has the same tags"
    )]
    Stranger {
        /// Who.
        apart: Vec<CameraId>,
        /// The same, in words.
        cameras: String,
        /// The object's name.
        object: ObjectId,
    },
    /// The object's tags could not be placed.
    #[error("the object's tags are not known and cannot be learned from these images: {0}")]
    Object(#[from] crate::learn::LearnError),
    /// A camera that was moved while images were taken.
    #[error(
        "camera {camera} moved by about {mm:.0} mm and {deg:.1} degrees while the images were \
         taken: fix it and record again"
    )]
    Moved {
        /// The camera.
        camera: CameraId,
        /// How far.
        mm: f64,
        /// How much it turned.
        deg: f64,
    },
    /// Two cameras' images fit the other's lens.
    #[error(
        "the images of {first} fit the lens of {second} and the other way round: their names are swapped"
    )]
    Swapped {
        /// The one.
        first: CameraId,
        /// The other.
        second: CameraId,
    },
    /// Something that the images leave open.
    #[error("not determined by these images: {0}")]
    Undetermined(String),
    /// The adjustment has no start.
    #[error("the cameras could not be adjusted: {0}")]
    Adjustment(#[from] sextant_adjustment::BundleError),
}

/// Calibrates from images as they come.
#[derive(Clone, Debug)]
pub struct RigSession {
    plan: RigPlan,
    images: SessionImages,
    coverage: Coverage,
}

/// Most stored images.
const MOST_IMAGES: usize = 60_000;

impl RigSession {
    /// Starts a session without images.
    ///
    /// # Errors
    /// A plan that no images can satisfy.
    pub fn new(rig: Rig, plan: RigPlan) -> Result<Self, RigError> {
        if plan.object.articulation().is_some() {
            return Err(RigError::Articulated(plan.object.id().clone()));
        }
        plan.origin.check(&rig)?;
        let mut wanted: Vec<TagSpec> = plan
            .object
            .tags()
            .iter()
            .map(|tag| TagSpec {
                tag: tag.tag,
                size_m: tag.size_m,
            })
            .collect();
        plan.origin.add_floor_tags(&mut wanted);
        Ok(Self {
            coverage: Coverage::new(&rig, &plan.object),
            images: SessionImages::new(rig, wanted, MOST_IMAGES),
            plan,
        })
    }

    /// Handles an image. Images of cameras that the rig lacks are passed over.
    pub fn handle(&mut self, image: &ImageObservation) {
        if let Some(view) = self.images.push(image) {
            self.coverage.add(&view, &self.images);
        }
    }

    /// Progress so far and what to do next.
    pub fn progress(&self) -> RigProgress {
        self.coverage.progress(&self.images)
    }

    /// How many of the wanted tags belong to the carried object; the others lie on the floor.
    fn n_carried(&self) -> usize {
        self.plan.object.tags().len()
    }
}
