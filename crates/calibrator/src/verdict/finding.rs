//! Findings of a calibration, as data; `Display` makes the sentence with the remedy.

use super::listed;
use serde::{Serialize, Serializer};
use sextant_site_model::{CameraId, TagId};
use std::fmt;

/// What limits a result, or was allowed for.
#[derive(Clone, Debug, PartialEq)]
pub enum Finding {
    /// The lens is uncertain.
    UncertainLens {
        /// Mean standard deviation over the image, pixels.
        mean_px: f64,
        /// Largest standard deviation, pixels.
        worst_px: f64,
    },
    /// The lens model has no rays in a part of the image.
    NoRays {
        /// That share of the image.
        share: f64,
    },
    /// The board covered too little of the image.
    Uncovered {
        /// The covered share.
        covered: f64,
    },
    /// Residuals of neighbouring corners are correlated.
    SystematicResiduals {
        /// Their size, pixels.
        px: f64,
    },
    /// Tags of the board were outliers.
    BoardOutliers {
        /// Their share.
        share: f64,
    },
    /// A motion of a camera that the images hardly determine.
    WeakCamera {
        /// The camera.
        camera: CameraId,
        /// The motion.
        motion: WeakMotion,
    },
    /// A pose coordinate of a tag that the images hardly determine.
    WeakTag {
        /// The tag.
        tag: TagId,
        /// Position or attitude.
        part: PosePart,
    },
    /// Cameras whose poses are uncertain.
    UncertainCameras {
        /// The cameras.
        cameras: Vec<String>,
        /// Lower bound of their standard deviations in position, millimetres.
        mm: f64,
        /// Lower bound of their standard deviations in attitude, degrees.
        deg: f64,
    },
    /// Tags whose poses are uncertain.
    UncertainTags {
        /// The tags.
        tags: Vec<String>,
        /// Lower bound of their standard deviations in position, millimetres.
        mm: f64,
        /// Lower bound of their standard deviations in attitude, degrees.
        deg: f64,
    },
    /// A clock that is off, which was corrected.
    ClockOffset {
        /// The camera.
        camera: String,
        /// Its clock minus those of the others, milliseconds.
        ms: f64,
        /// Standard deviation of the same.
        sigma_ms: f64,
    },
    /// A tag that fits only some of its images.
    RarelyFits {
        /// The tag.
        tag: String,
        /// Images that it fits.
        fits: usize,
        /// Images that show it.
        seen: usize,
    },
    /// A tag with few images.
    FewImages {
        /// The tag.
        tag: String,
        /// Images that it fits.
        fits: usize,
    },
    /// A tag that many images place differently.
    Elsewhere {
        /// The tag.
        tag: String,
        /// Images that place it differently.
        elsewhere: usize,
        /// Images that show it.
        seen: usize,
    },
    /// A tag that images show twice.
    Duplicated {
        /// The tag.
        tag: TagId,
        /// The number of these images.
        images: usize,
    },
    /// Tags of other sizes than given, which was corrected.
    SizesDiffer {
        /// The tags.
        tags: Vec<String>,
        /// Actual size as a ratio of the given one.
        ratio: f64,
        /// Source of the scale.
        scale: ScaleSource,
    },
    /// Two cameras have exchanged their former poses.
    SwappedNames([CameraId; 2]),
    /// Cameras contradict each other, so that their images were not combined.
    ContradictingCameras,
    /// Tags that moved, but that no image connects with the object.
    LooseTags(Vec<String>),
    /// Tags that move, but of which it is not known what they belong to.
    UnassignedTags(Vec<String>),
    /// An object that no two cameras saw at the same time.
    UnsharedObject(String),
    /// A camera that saw objects in few images.
    FewSightings {
        /// The camera.
        camera: String,
        /// The number of these images.
        images: usize,
    },
    /// A camera whose focal length is uncertain.
    UncertainFocal {
        /// The camera.
        camera: String,
        /// Standard deviation, per cent.
        percent: f64,
    },
    /// A camera with corners of its image that no tag reached.
    UncoveredCorners {
        /// The camera.
        camera: String,
        /// How many of the four.
        missing: usize,
    },
    /// Cameras or tags that could not be placed, with cause and remedy.
    Unplaced(String),
    /// More images than are used: whole stretches of time were left out.
    Thinned {
        /// The number of images used.
        stored: usize,
        /// The number of images received.
        received: usize,
    },
    /// Images of another size than the lens is for, which were left out.
    OtherSize {
        /// The camera.
        camera: CameraId,
        /// The number of these images.
        images: usize,
        /// Width and height of the last one, px.
        size: [u32; 2],
        /// Those of the images that are used, px.
        expected: [u32; 2],
    },
    /// Images beyond the most that are stored, which were left out.
    ImagesNotStored {
        /// The number of images stored.
        stored: usize,
        /// The number of images left out.
        not_stored: usize,
    },
    /// A robot whose base or hand is uncertain.
    UncertainRobot,
    /// Few poses of a robot.
    FewRobotPoses(usize),
    /// Poses of a robot that contradict the others, by the numbers of their images.
    RobotOutliers(Vec<usize>),
    /// Images and a robot that disagree by more than noise.
    RobotDisagrees {
        /// Standard deviation per axis, millimetres.
        mm: f64,
        /// Standard deviation per axis, degrees.
        deg: f64,
    },
    /// A robot's clock that is off, which was corrected.
    RobotClock {
        /// The robot's clock minus that of the images, milliseconds.
        ms: f64,
        /// Its standard deviation, milliseconds.
        sigma_ms: f64,
    },
    /// A lens whose focal length is not that of the rig file, which was corrected.
    LensDiffers {
        /// The camera.
        camera: CameraId,
        /// Change of the focal length, per cent.
        percent: f64,
    },
}

/// A motion of a camera that images hardly determine.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum WeakMotion {
    /// The offset of its clock.
    Clock,
    /// Rotation about the optical axis.
    Roll,
    /// Rotation about another axis.
    Tilt,
    /// Translation along the optical axis.
    Along,
    /// Translation across the optical axis.
    Across,
}

/// A part of a pose.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PosePart {
    /// The position.
    Position,
    /// The attitude.
    Attitude,
}

/// What determined the scale of a tag.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum ScaleSource {
    /// The carried object.
    Object,
    /// The other tags of the object.
    OtherTags,
    /// The given distances between the tags.
    Spacing,
}

impl fmt::Display for Finding {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::UncertainLens { mean_px, worst_px } => write!(
                f,
                "the lens is uncertain by {mean_px:.2} px on average over the image and by \
                 {worst_px:.1} px in the worst part; add images"
            ),
            Self::NoRays { share } => write!(
                f,
                "the lens model does not cover {:.0} % of the image; add images there or try kannala-brandt",
                100.0 * share
            ),
            Self::Uncovered { covered } => write!(
                f,
                "the board covered only {:.0} % of the image; show it near the edges, too",
                100.0 * covered
            ),
            Self::SystematicResiduals { px } => write!(
                f,
                "corners are off by {px:.2} px in parts of the image: the board is not flat, or \
                 the lens needs another model"
            ),
            Self::BoardOutliers { share } => write!(
                f,
                "{:.0} % of the tags were not where the board file says and were left out",
                100.0 * share
            ),
            Self::WeakCamera { camera, motion } => motion.describe(camera, f),
            Self::WeakTag { tag, part } => write!(
                f,
                "the {} of {tag} is hardly determined: show it nearer, tilted and with its neighbours",
                match part {
                    PosePart::Position => "position",
                    PosePart::Attitude => "attitude",
                }
            ),
            Self::UncertainCameras { cameras, mm, deg } => write!(
                f,
                "{} known to no better than {mm:.0} mm or {deg:.2} degrees: carry the object \
                 longer and nearer through the views shared with other cameras",
                listed(cameras)
            ),
            Self::UncertainTags { tags, mm, deg } => write!(
                f,
                "{} known to no better than {mm:.1} mm or {deg:.1} degrees: show the object nearer and from more sides",
                listed(tags)
            ),
            Self::ClockOffset {
                camera,
                ms,
                sigma_ms,
            } => write!(
                f,
                "the clock of {camera} is {:.1} ms (one sigma {sigma_ms:.1}) {} those of the \
                 others, which was corrected",
                ms.abs(),
                if *ms > 0.0 { "ahead of" } else { "behind" }
            ),
            Self::RarelyFits { tag, fits, seen } => write!(
                f,
                "{tag} fits in only {fits} of {seen} images: it has moved, is bent, or exists twice"
            ),
            Self::FewImages { tag, fits } => write!(f, "only {fits} images of {tag} fit"),
            Self::Elsewhere {
                tag,
                elsewhere,
                seen,
            } => write!(
                f,
                "{elsewhere} of {seen} images place {tag} elsewhere: is it loose, or does it exist twice?"
            ),
            Self::Duplicated { tag, images } => write!(
                f,
                "{images} images show {tag} twice and were not used for it"
            ),
            Self::SizesDiffer { tags, ratio, scale } => write!(
                f,
                "{} {} {:.1} % {} than given, according to {}, which was corrected: measure the black squares{}",
                listed(tags),
                if tags.len() == 1 { "is" } else { "are" },
                100.0 * (ratio - 1.0).abs(),
                if *ratio > 1.0 { "larger" } else { "smaller" },
                match scale {
                    ScaleSource::Object => "the carried object",
                    ScaleSource::OtherTags => "the other tags",
                    ScaleSource::Spacing => "their spacing",
                },
                match scale {
                    ScaleSource::Spacing => " and the spacing",
                    ScaleSource::Object | ScaleSource::OtherTags => "",
                }
            ),
            Self::SwappedNames([a, b]) => write!(
                f,
                "{a} is where {b} was before, and the other way round: are their names swapped?"
            ),
            Self::ContradictingCameras => f.write_str(
                "cameras that saw the object at the same time contradict each other, so their \
                 images were not combined: one has moved since the rig was calibrated, its clock \
                 is off, or names are swapped",
            ),
            Self::LooseTags(tags) => write!(
                f,
                "{} moved too, but no image shows them with the object: if they are part of it, \
                 show them together with its other tags",
                listed(tags)
            ),
            Self::UnassignedTags(tags) => write!(
                f,
                "{} moved, but no image shows them with another tag that moves as they do: show \
                 them together with the other tags of their object",
                listed(tags)
            ),
            Self::UnsharedObject(object) => write!(
                f,
                "no two cameras saw {object} at the same time, so that it does not help to place \
                 them: carry it where their views overlap"
            ),
            Self::FewSightings { camera, images } => write!(
                f,
                "{camera} saw objects in only {images} images: carry them longer before it"
            ),
            Self::UncertainFocal { camera, percent } => write!(
                f,
                "the focal length of {camera} is known to no better than {percent:.1} %: show it \
                 objects nearer and tilted"
            ),
            Self::UncoveredCorners { camera, missing } => write!(
                f,
                "no tag reached {missing} of the 4 corners of the image of {camera}, so that its \
                 distortion is uncertain there: carry objects along the edge of its view"
            ),
            Self::Unplaced(cause) => f.write_str(cause),
            Self::Thinned { stored, received } => write!(
                f,
                "{stored} of {received} images were used, in stretches of half a second spread \
                 over the whole time: more only cost time"
            ),
            Self::OtherSize {
                camera,
                images,
                size: [width, height],
                expected: [expected_width, expected_height],
            } => write!(
                f,
                "{images} images of {camera} were left out, since they have {width} x {height} \
                 pixels and not {expected_width} x {expected_height}: set the camera back, or \
                 calibrate its lens for images of that size"
            ),
            Self::ImagesNotStored { stored, not_stored } => write!(
                f,
                "the last {not_stored} images were left out, since {stored} are the most: record \
                 less often or for a shorter time"
            ),
            Self::UncertainRobot => f.write_str(
                "base and hand are uncertain: add poses, with the object near and all over the \
                 image, the hand turned by 30 degrees or more about each axis",
            ),
            Self::FewRobotPoses(poses) => {
                write!(f, "only {poses} poses of the robot; use 15 or more")
            }
            Self::RobotOutliers(images) => write!(
                f,
                "{} of the robot at image {} contradict{} the others: did the hand stand still, \
                 and is each pose that of its image?",
                if images.len() == 1 {
                    "the pose"
                } else {
                    "the poses"
                },
                listed(images),
                if images.len() == 1 { "s" } else { "" }
            ),
            Self::RobotDisagrees { mm, deg } => write!(
                f,
                "robot and images disagree by {mm:.1} mm and {deg:.2} degrees: check the tool \
                 that the robot's poses are of, its own calibration, the lens and the size of the tags"
            ),
            Self::RobotClock { ms, sigma_ms } => write!(
                f,
                "the clock of the robot is {:.1} ms (one sigma {sigma_ms:.1}) {} that of the \
                 images, which was corrected",
                ms.abs(),
                if *ms > 0.0 { "ahead of" } else { "behind" }
            ),
            Self::LensDiffers { camera, percent } => write!(
                f,
                "by the robot's poses the focal length of {camera} is {percent:+.1} % that of \
                 the rig file, which was corrected here only: calibrate its lens (`sextant calibrate lens`)"
            ),
        }
    }
}

impl WeakMotion {
    fn describe(self, camera: &CameraId, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Clock => write!(
                f,
                "the clock of {camera} is not observable: move the object faster and in changing directions"
            ),
            Self::Roll => write!(
                f,
                "the rotation of {camera} about its optical axis is not observable: carry the object off that axis"
            ),
            Self::Tilt => write!(
                f,
                "the tilt of {camera} is not observable: show it the object in more parts of its image"
            ),
            Self::Along => write!(
                f,
                "the position of {camera} along its optical axis is not observable: bring the \
                 object nearer, and tilt it"
            ),
            Self::Across => write!(
                f,
                "the position of {camera} across its optical axis is not observable: show it the \
                 object in more places, tilted"
            ),
        }
    }
}

impl Serialize for Finding {
    /// As its sentence.
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}
