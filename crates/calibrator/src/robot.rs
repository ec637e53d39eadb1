//! Calibrating a robot: where its base is in the site, and what its hand carries, from its poses and images.
//!
//! The hand carries an object before cameras that stand still, or a camera before an object that lies still; both are the adjustment of
//! corners of every other procedure, with the robot's poses as further observations (`bundle/arm.rs`). No number counts as exact: lenses and
//! tags are adjusted by their priors, and the noise of the robot's poses is estimated from what they and the images disagree by.

mod clock;
mod degeneracy;
mod held_out;
mod judgement;
mod poses;
mod report;
mod solution;
mod solving;
mod start;

pub use poses::RobotPoses;
pub use report::{CalibratedRobot, HeldOut, RobotReport};

use crate::bundle::{BundleError, Mount};
use crate::image_store::{ImageView, TagSpec, take_in};
use sextant_site_model::{Camera, CameraId, ImageObservation, ObjectId, ObjectModel, Rig, TagId};
use std::collections::{BTreeMap, BTreeSet};
use thiserror::Error;

/// What is to be calibrated.
#[derive(Clone, Debug)]
pub struct RobotPlan {
    /// The object on the hand, or the one that lies still. Its tags have places.
    pub object: ObjectModel,
    /// What the hand carries.
    pub mount: Mount,
}

/// Why a robot could not be calibrated.
#[derive(Clone, Debug, Error)]
pub enum RobotError {
    /// The object has links.
    #[error("object {0} has links: use a rigid one")]
    Articulated(ObjectId),
    /// The object has tags without a place.
    #[error(
        "object {object}: tag {tag} has no object_from_tag; learn the object first (`sextant learn`)"
    )]
    Unlearned {
        /// The object.
        object: ObjectId,
        /// The tag.
        tag: TagId,
    },
    /// A camera without a pose, of several.
    #[error(
        "camera {0} has no world_from_camera: calibrate the rig first (`sextant calibrate rig`), or use one camera alone"
    )]
    UnplacedCamera(CameraId),
    /// Several cameras, where the hand carries one.
    #[error("the hand carries one camera, but there are {0}: choose one")]
    SeveralCameras(usize),
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
    /// Too few images with a pose of the robot.
    #[error(
        "{matched} of {images} images that show the object have a pose of the robot, and 3 are the least: {hint}"
    )]
    FewPoses {
        /// Images that show the object.
        images: usize,
        /// Those with a pose of the robot.
        matched: usize,
        /// What to do.
        hint: String,
    },
    /// The adjustment has no start.
    #[error("the robot could not be adjusted: {0}")]
    Adjustment(#[from] BundleError),
    /// No transforms fit.
    #[error(
        "no place of the base fits the images: is this the robot that moved, and the object of the file?"
    )]
    NoStart,
}

/// Calibrates a robot from images as they come.
#[derive(Clone, Debug)]
pub struct RobotSession {
    rig: Rig,
    plan: RobotPlan,
    wanted: Vec<TagSpec>,
    images: Vec<NumberedView>,
    /// Images received of each camera.
    received: BTreeMap<CameraId, usize>,
    foreign: BTreeSet<TagId>,
}

/// A usable image and its number among those of its camera, from 0.
#[derive(Clone, Debug)]
struct NumberedView {
    number: usize,
    view: ImageView,
}

/// Most stored images; later ones are not used.
const MOST_IMAGES: usize = 20_000;

impl RobotSession {
    /// Starts a session without images. A single camera needs no pose: it is the world then, and always where the hand carries it.
    ///
    /// # Errors
    /// A plan that no images can satisfy.
    pub fn new(rig: &Rig, plan: RobotPlan) -> Result<Self, RobotError> {
        let object = &plan.object;
        if object.articulation().is_some() {
            return Err(RobotError::Articulated(object.id().clone()));
        }
        if let Some(tag) = object
            .tags()
            .iter()
            .find(|tag| tag.object_from_tag.is_none())
        {
            return Err(RobotError::Unlearned {
                object: object.id().clone(),
                tag: tag.tag,
            });
        }
        let wanted = object.tags().iter().map(|tag| TagSpec {
            tag: tag.tag,
            size_m: tag.size_m,
        });
        Ok(Self {
            rig: placed(rig, plan.mount)?,
            wanted: wanted.collect(),
            plan,
            images: Vec::new(),
            received: BTreeMap::new(),
            foreign: BTreeSet::new(),
        })
    }

    /// Handles an image; those of a camera come in the order of time. Images of cameras that the rig lacks are passed over.
    pub fn handle(&mut self, image: &ImageObservation) {
        let mut cameras = self.rig.cameras().iter();
        let Some(index) = cameras.position(|camera| camera.id == image.camera) else {
            return;
        };
        let received = self.received.entry(image.camera.clone()).or_default();
        let number = *received;
        *received += 1;
        let camera = &self.rig.cameras()[index];
        let (view, ignored) = take_in((index, camera), &self.wanted, image);
        self.foreign.extend(ignored.foreign);
        if !view.tags.is_empty() && camera.fits(image) && self.images.len() < MOST_IMAGES {
            self.images.push(NumberedView { number, view });
        }
    }

    fn n_received(&self) -> usize {
        self.received.values().sum()
    }
}

/// The rig with a pose of every camera.
fn placed(rig: &Rig, mount: Mount) -> Result<Rig, RobotError> {
    let n = rig.cameras().len();
    if mount == Mount::Camera && n != 1 {
        return Err(RobotError::SeveralCameras(n));
    }
    let cameras = rig.cameras().iter().map(|camera| {
        let pose = match mount {
            Mount::Camera => Some(Default::default()),
            Mount::Object if n == 1 => Some(camera.world_from_camera.unwrap_or_default()),
            Mount::Object => camera.world_from_camera,
        };
        let pose = pose.ok_or_else(|| RobotError::UnplacedCamera(camera.id.clone()))?;
        Ok(Camera {
            world_from_camera: Some(pose),
            ..camera.clone()
        })
    });
    let cameras: Vec<Camera> = cameras.collect::<Result<_, RobotError>>()?;
    Ok(cameras.into_iter().fold(rig.clone(), Rig::with_camera))
}
