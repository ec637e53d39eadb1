//! Parameters and observations of an adjustment: cameras, tags, instants, and the detected corners; and how each of
//! them steps.

use crate::anchor::Anchor;
use crate::arm::Arm;
use crate::shutter::LaterPose;
use nalgebra::{Matrix2, Point2, SVector, Vector6};
use sextant_geometry::lens::MAX_PARAMETERS;
use sextant_geometry::{Lens, Pose, se3};
use thiserror::Error;

/// Whether a parameter is sought.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Freedom {
    /// Fixed at its value.
    Fixed,
    /// Sought.
    #[default]
    Free,
}

/// Which of a lens's parameters are sought, in the order of [`Lens::parameters`]; entries beyond the lens's own are
/// ignored.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FreeLens(pub [Freedom; MAX_PARAMETERS]);

impl FreeLens {
    /// The lens is known.
    pub const FIXED: Self = Self([Freedom::Fixed; MAX_PARAMETERS]);
    /// Every parameter is sought.
    pub const ALL: Self = Self([Freedom::Free; MAX_PARAMETERS]);
}

/// A camera: where it starts and what of it is sought.
#[derive(Clone, Debug, PartialEq)]
pub struct BundleCamera {
    /// Camera frame to pixels.
    pub lens: Lens,
    /// Which of its parameters are sought.
    pub free_lens: FreeLens,
    /// Maps points of the camera into the world.
    pub world_from_camera: Pose,
    /// Whether that is sought.
    pub pose: Freedom,
    /// By how much the camera's clock is ahead, seconds: subtracted from its capture times to get the world's.
    pub clock_offset_s: f64,
    /// Whether that is sought; without [`Bundle::motion`] it cannot be.
    pub clock: Freedom,
    /// Standard deviation of the error of each capture time beside the offset, seconds, which is sought image by image;
    /// zero if there is none, and without [`Bundle::motion`].
    pub stamp_sigma_s: f64,
    /// Rolling shutter: seconds from a row to the next, which displace corners as the object moves; without effect
    /// without [`Bundle::motion`].
    pub line_delay_s: f64,
    /// Whether that is sought; without [`Bundle::motion`] it cannot be.
    pub line_delay: Freedom,
    /// The row whose time is the capture time.
    pub middle_row: f64,
}

/// A tag of the object.
#[derive(Clone, Debug, PartialEq)]
pub struct BundleTag {
    /// Maps points of the tag into the object.
    pub object_from_tag: Pose,
    /// Edge of the black square, metres.
    pub size_m: f64,
    /// Whether the pose is sought.
    pub pose: Freedom,
    /// Whether the size is sought: tags that move together tell the ratio of their sizes.
    pub size: Freedom,
    /// The scale that it shares with other tags, as an index into [`Bundle::scales`].
    pub scale: Option<usize>,
}

/// A common scale of tags, of one object or one printed sheet: their places on the object and their sizes are larger
/// than theirs by it.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
pub struct ObjectScale {
    /// Logarithm of the factor.
    pub log_factor: f64,
    /// Whether it is sought.
    pub freedom: Freedom,
}

/// A body: only instants of one body follow one another and are tied.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum BodyId {
    /// It stands still, so that all of its images are of one instant.
    Still(usize),
    /// It moves.
    Moving(usize),
}

/// A body at one time.
#[derive(Clone, Debug, PartialEq)]
pub struct Instant {
    /// Whose it is.
    pub body: BodyId,
    /// Seconds since any start; ascending through the instants of a body when motion is modelled.
    pub seconds: f64,
    /// Maps points of the object into the world. Always sought.
    pub world_from_object: Pose,
    /// Velocity of the object's origin, m/s, and angular velocity, rad/s, in world axes. Sought where the motion is
    /// modelled, else without meaning.
    pub twist: Vector6<f64>,
}

/// One tag in one image.
#[derive(Clone, Debug, PartialEq)]
pub struct TagObservation {
    /// Index into [`Bundle::tags`].
    pub tag: usize,
    /// Top left, top right, bottom right, bottom left, pixels.
    pub corners: [Point2<f64>; 4],
    /// `W` of each corner with `W' W` the inverse of its covariance, 1/pixel; zero for a corner that does not count.
    pub whitening: [Matrix2<f64>; 4],
}

/// The tags of one image.
#[derive(Clone, Debug, PartialEq)]
pub struct BundleImage {
    /// Index into [`Bundle::cameras`].
    pub camera: usize,
    /// Index into [`Bundle::instants`].
    pub instant: usize,
    /// Capture time by the camera's own clock less the instant's time, seconds; only read where the motion is modelled.
    pub seconds_after_instant: f64,
    /// By how much the capture time is ahead beside the camera's clock offset, seconds; sought where
    /// [`BundleCamera::stamp_sigma_s`] is not zero.
    pub stamp_error_s: f64,
    /// The observed tags.
    pub tags: Vec<TagObservation>,
}

/// How freely the object moves between instants: a constant twist disturbed by white acceleration, as in the tracker.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Motion {
    /// Spectral density of the acceleration, m/s^2 per square root of Hz.
    pub acceleration: f64,
    /// Of the angular acceleration, rad/s^2 per square root of Hz.
    pub angular_acceleration: f64,
    /// Instants further apart than this are not tied together, seconds.
    pub longest_gap_s: f64,
}

/// A whole adjustment: what is known, what is sought, what was seen.
#[derive(Clone, Debug, PartialEq, Default)]
pub struct Bundle {
    /// The cameras.
    pub cameras: Vec<BundleCamera>,
    /// The object's tags.
    pub tags: Vec<BundleTag>,
    /// Common scales of tags.
    pub scales: Vec<ObjectScale>,
    /// Where the objects were, body by body.
    pub instants: Vec<Instant>,
    /// The images, by instant.
    pub images: Vec<BundleImage>,
    /// With it, instants follow one another in time and clocks can be sought; without, each stands for itself.
    pub motion: Option<Motion>,
    /// Priors of cameras and tags.
    pub anchors: Vec<Anchor>,
    /// The robot that moves the object or the camera, with a pose for each instant.
    pub arm: Option<Arm>,
}

/// Why a bundle cannot be adjusted.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum BundleError {
    /// No image shows a tag.
    #[error("no image shows a tag")]
    Nothing,
    /// An image names a camera, instant or tag that is not there, or images are not sorted by instant.
    #[error("image {0} names what is not there, or comes before an image of an earlier instant")]
    Image(usize),
    /// An anchor refers to a missing parameter or has an invalid deviation.
    #[error("anchor {0} names what is not there, or its deviations are not above zero")]
    Anchor(usize),
    /// A number of the image is not finite.
    #[error("image {0} has a corner or a weight that is not finite")]
    NotFinite(usize),
    /// The robot's poses are not one an instant, or a number of the robot is not finite or no deviation.
    #[error("the robot's poses are not one an instant, or its deviations are not above zero")]
    Arm,
    /// A clock or line delay is sought although no motion is modelled, or instants of a motion do not ascend in time.
    #[error(
        "clocks or line delays are sought but the object's motion is not modelled, or its instants do not ascend in \
         time"
    )]
    Time,
    /// The start fits so badly that no step could be computed.
    #[error("the adjustment has no finite start")]
    BadStart,
}

impl BundleCamera {
    /// A camera whose pose alone is sought.
    pub fn with_known_lens(lens: Lens, world_from_camera: Pose) -> Self {
        Self {
            lens,
            free_lens: FreeLens::FIXED,
            world_from_camera,
            pose: Freedom::Free,
            clock_offset_s: 0.0,
            clock: Freedom::Fixed,
            stamp_sigma_s: 0.0,
            line_delay_s: 0.0,
            line_delay: Freedom::Fixed,
            middle_row: 0.0,
        }
    }
}

impl TagObservation {
    /// Corners with the same noise in every coordinate, one sigma in pixels.
    pub fn with_sigma(tag: usize, corners: [Point2<f64>; 4], sigma_px: f64) -> Self {
        Self {
            tag,
            corners,
            whitening: [Matrix2::from_diagonal_element(1.0 / sigma_px); 4],
        }
    }

    /// As [`Self::with_sigma`], one sigma a corner; an infinite one gives a corner no weight.
    pub fn with_sigmas(tag: usize, corners: [Point2<f64>; 4], sigmas_px: [f64; 4]) -> Self {
        Self {
            tag,
            corners,
            whitening: sigmas_px.map(|sigma| Matrix2::from_diagonal_element(1.0 / sigma)),
        }
    }

    /// Corners with the covariances that the detector states, px^2, to each of which `floor_px` squared is added for
    /// what the detector cannot know. `None` where that is not positive definite.
    pub fn with_covariance(
        tag: usize,
        corners: [Point2<f64>; 4],
        covariance: &[Matrix2<f64>; 4],
        floor_px: f64,
    ) -> Option<Self> {
        let mut whitening = [Matrix2::identity(); 4];
        for (whitening, covariance) in whitening.iter_mut().zip(covariance) {
            let whole = covariance + Matrix2::from_diagonal_element(floor_px * floor_px);
            *whitening = whole.cholesky()?.l().try_inverse()?;
        }
        Some(Self {
            tag,
            corners,
            whitening,
        })
    }
}

impl Bundle {
    /// Whether every index points somewhere and every number is finite.
    pub(crate) fn check(&self) -> Result<(), BundleError> {
        if self.images.iter().all(|image| image.tags.is_empty()) {
            return Err(BundleError::Nothing);
        }
        let mut earlier = 0;
        for (index, image) in self.images.iter().enumerate() {
            let known = image.camera < self.cameras.len()
                && image.instant < self.instants.len()
                && image.tags.iter().all(|seen| self.knows(seen.tag));
            if !known || image.instant < earlier {
                return Err(BundleError::Image(index));
            }
            if !image.is_finite() {
                return Err(BundleError::NotFinite(index));
            }
            earlier = image.instant;
        }
        let unsound = self.anchors.iter().position(|a| !a.is_sound(self));
        if let Some(index) = unsound {
            return Err(BundleError::Anchor(index));
        }
        if self
            .arm
            .as_ref()
            .is_some_and(|arm| !arm.is_sound(self.instants.len()))
        {
            return Err(BundleError::Arm);
        }
        self.check_time()
    }

    fn knows(&self, tag: usize) -> bool {
        let scale = self.tags.get(tag).map(|tag| tag.scale);
        scale.is_some_and(|scale| scale.is_none_or(|scale| scale < self.scales.len()))
    }

    /// Factor on the places and the size of a tag.
    pub fn scale(&self, tag: &BundleTag) -> f64 {
        tag.scale.map_or(1.0, |at| self.scales[at].log_factor.exp())
    }

    fn check_time(&self) -> Result<(), BundleError> {
        let needs_motion = |c: &BundleCamera| [c.clock, c.line_delay].contains(&Freedom::Free);
        let sought = self.cameras.iter().any(needs_motion);
        let follows = |pair: &[Instant]| {
            let [a, b] = pair else { return true };
            a.body < b.body || (a.body == b.body && a.seconds <= b.seconds)
        };
        let ascending = self.instants.windows(2).all(follows);
        match self.motion {
            None if sought => Err(BundleError::Time),
            Some(_) if !ascending => Err(BundleError::Time),
            _ => Ok(()),
        }
    }
}

impl BundleImage {
    fn is_finite(&self) -> bool {
        self.seconds_after_instant.is_finite()
            && self.tags.iter().all(|seen| {
                let corners = seen.corners.iter().flat_map(|p| p.coords.iter());
                let weights = seen.whitening.iter().flat_map(|w| w.iter());
                corners.chain(weights).all(|x| x.is_finite())
            })
    }
}

impl Instant {
    /// An instant without motion.
    pub fn at_rest(body: BodyId, seconds: f64, world_from_object: Pose) -> Self {
        Self {
            body,
            seconds,
            world_from_object,
            twist: Vector6::zeros(),
        }
    }

    /// The instant `seconds` later by its twist.
    pub fn after(&self, seconds: f64) -> Self {
        Self {
            seconds: self.seconds + seconds,
            world_from_object: LaterPose::new(&self.world_from_object, &self.twist, seconds).pose,
            ..self.clone()
        }
    }

    /// After a step of its pose and, where there are twelve numbers, of its twist.
    pub(crate) fn stepped<const D: usize>(&self, step: &SVector<f64, D>) -> Self {
        let mut stepped = self.clone();
        let pose = step.fixed_rows::<6>(0).into_owned();
        stepped.world_from_object = se3::perturb(&self.world_from_object, &pose);
        for (twist, change) in stepped.twist.iter_mut().zip(step.iter().skip(6)) {
            *twist += change;
        }
        stepped
    }
}
