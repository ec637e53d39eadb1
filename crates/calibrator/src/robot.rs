//! Calibrating a robot: where its base is in the site, and what its hand carries, from its poses and images.
//!
//! The hand carries an object before cameras that stand still, or a camera before an object that lies still; both are
//! the adjustment of corners of every other procedure, with the robot's poses as further observations
//! (`bundle/arm.rs`). Lenses, tags and the poses of all cameras but the first are adjusted by their priors; the first
//! camera holds the world, so that its own deviation is in no covariance. The noise of the robot's poses is estimated
//! from what they and the images disagree by.

mod clock;
mod conventions;
mod degeneracy;
mod held_out;
mod judgement;
mod poses;
mod report;
mod solution;
mod solving;
mod start;

pub use conventions::PoseReading;
pub use poses::RobotPoses;
pub use report::{CalibratedRobot, HeldOut, RobotReport};

use crate::image_store::{ImageView, TagSpec, take_in};
use sextant_adjustment::{BundleError, Mount};
use sextant_site_model::{Camera, CameraId, ImageObservation, ObjectId, ObjectModel, Rig, TagId};
use std::collections::BTreeSet;
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
        "camera {0} has no world_from_camera: calibrate the rig first (`sextant calibrate rig`), \
         or use one camera alone"
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
        "{poses} poses of the robot were matched, and 3 are the least; {matched} of {images} \
         images that show the object have one: {hint}"
    )]
    FewPoses {
        /// Images that show the object.
        images: usize,
        /// Those with a pose of the robot.
        matched: usize,
        /// Their distinct poses.
        poses: usize,
        /// What to do.
        hint: String,
    },
    /// The adjustment has no start.
    #[error("the robot could not be adjusted: {0}")]
    Adjustment(#[from] BundleError),
    /// The poses are written otherwise than they are read.
    #[error(
        "robot and images disagree by {mm_as_given:.1} mm and {deg_as_given:.1} degrees, and by {mm:.2} mm and \
         {deg:.2} degrees where the robot's poses are {reading}"
    )]
    OtherReading {
        /// How they are written.
        reading: PoseReading,
        /// What is left by that, standard deviation per axis, millimetres.
        mm: f64,
        /// The same, degrees.
        deg: f64,
        /// What is left as they are read, millimetres.
        mm_as_given: f64,
        /// The same, degrees.
        deg_as_given: f64,
    },
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
    images: Vec<ImageView>,
    /// Capture times of the images of each camera of the rig, ascending, ns.
    received: Vec<Vec<u64>>,
    /// Usable images that were received when the store was full.
    not_stored: usize,
    foreign: BTreeSet<TagId>,
}

/// Most stored images; later ones are counted only.
const MOST_IMAGES: usize = 20_000;

impl RobotSession {
    /// Starts a session without images. A single camera needs no pose: it is the world then, and always where the hand
    /// carries it.
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
            received: vec![Vec::new(); rig.cameras().len()],
            not_stored: 0,
            wanted: wanted.collect(),
            plan,
            images: Vec::new(),
            foreign: BTreeSet::new(),
        })
    }

    /// Handles an image. Images of cameras that the rig lacks are passed over.
    pub fn handle(&mut self, image: &ImageObservation) {
        let mut cameras = self.rig.cameras().iter();
        let Some(index) = cameras.position(|camera| camera.id == image.camera) else {
            return;
        };
        let earlier = self.number(index, image.capture_ns);
        self.received[index].insert(earlier, image.capture_ns);
        let camera = &self.rig.cameras()[index];
        let (view, ignored) = take_in(index, camera, &self.wanted, image);
        self.foreign.extend(ignored.foreign);
        if view.tags.is_empty() || !camera.fits(image) {
            return;
        }
        match self.images.len() < MOST_IMAGES {
            true => self.images.push(view),
            false => self.not_stored += 1,
        }
    }

    /// Number of an image among those of its camera in the order of capture, from 0.
    fn number(&self, camera: usize, capture_ns: u64) -> usize {
        self.received[camera].partition_point(|earlier_ns| *earlier_ns < capture_ns)
    }

    fn n_received(&self) -> usize {
        self.received.iter().map(Vec::len).sum()
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
