//! Findings of a calibration, as data, and the table of their sentences.

use super::listed;
use serde::{Serialize, Serializer};
use sextant_site_model::{CameraId, ObjectId, TagId};
use sextant_site_report::sentences;

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
    /// Images that had no part in the solution fit worse than with it.
    HeldOutWorse {
        /// Their residual, root mean square, pixels.
        rms_px: f64,
        /// The same where they had a part, pixels.
        used_rms_px: f64,
    },
    /// Two objects whose given sizes contradict each other by the distances of cameras.
    SizesContradict {
        /// The one whose sizes were corrected.
        object: String,
        /// The one by whose sizes all lengths are.
        by: String,
        /// Factor on the given sizes of the first.
        ratio: f64,
    },
    /// Cameras that have exchanged their former poses: each one has that of the next, the last that of the first.
    ExchangedNames(Vec<CameraId>),
    /// A carried object of another size than its file says, by the former places of the cameras, which was corrected.
    PrintedAtScale {
        /// The object.
        object: ObjectId,
        /// Its true lengths by those of its file.
        ratio: f64,
        /// Standard deviation of the logarithm of the ratio.
        sigma: f64,
    },
    /// A rig of another size than before, where it is open which of two objects is at fault.
    RigScaled {
        /// The carried object.
        object: ObjectId,
        /// Former lengths by those of now.
        ratio: f64,
    },
    /// A rig of which all cameras but the reference have kept their places.
    RigTurned {
        /// The camera that keeps its former pose.
        reference: CameraId,
        /// By how much the others turned about it, degrees.
        deg: f64,
    },
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

sentences! { Finding {
    Self::UncertainLens { mean_px, worst_px } =>
        "the lens is uncertain by {mean_px:.2} px on average over the image and by {worst_px:.1} px in the worst part",
        "; add images";
    Self::NoRays { share } =>
        "the lens model does not cover {percent:.0} % of the image",
        "; add images there or try kannala-brandt",
        percent = 100.0 * share;
    Self::Uncovered { covered } =>
        "the board covered only {percent:.0} % of the image",
        "; show it near the edges, too",
        percent = 100.0 * covered;
    Self::SystematicResiduals { px } =>
        "corners are off by {px:.2} px in parts of the image",
        ": the board is not flat, or the lens needs another model";
    Self::BoardOutliers { share } =>
        "{percent:.0} % of the tags were not where the board file says and were left out",
        "",
        percent = 100.0 * share;
    Self::WeakCamera { camera, motion: WeakMotion::Clock } =>
        "the clock of {camera} is not observable",
        ": move the object faster and in changing directions";
    Self::WeakCamera { camera, motion: WeakMotion::Roll } =>
        "the rotation of {camera} about its optical axis is not observable",
        ": carry the object off that axis";
    Self::WeakCamera { camera, motion: WeakMotion::Tilt } =>
        "the tilt of {camera} is not observable",
        ": show it the object in more parts of its image";
    Self::WeakCamera { camera, motion: WeakMotion::Along } =>
        "the position of {camera} along its optical axis is not observable",
        ": bring the object nearer, and tilt it";
    Self::WeakCamera { camera, motion: WeakMotion::Across } =>
        "the position of {camera} across its optical axis is not observable",
        ": show it the object in more places, tilted";
    Self::WeakTag { tag, part: PosePart::Position } =>
        "the position of {tag} is hardly determined",
        ": show it nearer, tilted and with its neighbours";
    Self::WeakTag { tag, part: PosePart::Attitude } =>
        "the attitude of {tag} is hardly determined",
        ": show it nearer, tilted and with its neighbours";
    Self::UncertainCameras { cameras, mm, deg } =>
        "{names} known to no better than {mm:.0} mm or {deg:.2} degrees",
        ": carry the object longer and nearer through the views shared with other cameras",
        names = listed(cameras);
    Self::UncertainTags { tags, mm, deg } =>
        "{names} known to no better than {mm:.1} mm or {deg:.1} degrees",
        ": show the object nearer and from more sides",
        names = listed(tags);
    Self::ClockOffset { camera, ms, sigma_ms } =>
        "the clock of {camera} is {off_ms:.1} ms (one sigma {sigma_ms:.1}) {side} those of the others, which was \
         corrected",
        "",
        off_ms = ms.abs(),
        side = if *ms > 0.0 { "ahead of" } else { "behind" };
    Self::RarelyFits { tag, fits, seen } =>
        "{tag} fits in only {fits} of {seen} images",
        ": it has moved, is bent, or exists twice";
    Self::FewImages { tag, fits } =>
        "only {fits} images of {tag} fit",
        "";
    Self::Elsewhere { tag, elsewhere, seen } =>
        "{elsewhere} of {seen} images place {tag} elsewhere",
        ": is it loose, or does it exist twice?";
    Self::Duplicated { tag, images } =>
        "{images} images show {tag} twice and were not used for it",
        "";
    Self::SizesDiffer { tags, ratio, scale } =>
        "{names} {are} {percent:.1} % {how} than given, according to {source}, which was corrected",
        ": measure the black squares{others}",
        names = listed(tags),
        are = if tags.len() == 1 { "is" } else { "are" },
        percent = 100.0 * (ratio - 1.0).abs(),
        how = if *ratio > 1.0 { "larger" } else { "smaller" },
        source = scale.words(),
        others = if *scale == ScaleSource::Spacing { " and the spacing" } else { "" };
    Self::HeldOutWorse { rms_px, used_rms_px } =>
        "images that had no part in the solution are off by {rms_px:.2} px, and by {used_rms_px:.2} px where they had",
        ": record longer, with the object all over the images";
    Self::SizesContradict { object, by, ratio } =>
        "the given sizes of {object} and {by} contradict each other: by the distances of the cameras that {by} gives, \
         the tags of {object} are {percent:.1} % {how} than given; all lengths were taken from {by}",
        ": measure a black square of each, and calibrate again with the right sizes (`--size ID:METRES`)",
        percent = 100.0 * (ratio - 1.0).abs(),
        how = if *ratio > 1.0 { "larger" } else { "smaller" };
    Self::ExchangedNames(cameras) if cameras.len() == 2 =>
        "{a} is where {b} was before, and the other way round: their names are exchanged",
        "; exchange their ids in the cameras' own files (camera.toml) and calibrate again, or keep the rig as written",
        a = &cameras[0],
        b = &cameras[1];
    Self::ExchangedNames(cameras) =>
        "{names} are each where the next of them was before: their names are exchanged",
        "; correct their ids in the cameras' own files (camera.toml) and calibrate again, or keep the rig as written",
        names = listed(cameras);
    Self::PrintedAtScale { object, ratio, sigma } =>
        "by the former places of the cameras {object} is printed at {percent:.1} % (one sigma {sigma_percent:.1}) of \
         the scale of its file; the rig was written with the former scale",
        ": measure a black square, and correct the sizes and places of its tags",
        percent = 100.0 * ratio,
        sigma_percent = 100.0 * sigma;
    Self::RigScaled { object, ratio } =>
        "the rig is {percent:.1} % {how} than before: {object} is printed at another scale, or what the former rig was \
         calibrated with",
        "; measure a black square of each, correct the file, and calibrate again",
        percent = 100.0 * (1.0 / ratio - 1.0).abs(),
        how = if *ratio > 1.0 { "smaller" } else { "larger" };
    Self::RigTurned { reference, deg } =>
        "the cameras have kept their places but for {reference}, which turned by {deg:.1} degrees, and the world with \
         it",
        ": keep the world by another camera (`--origin camera:ID`)";
    Self::ContradictingCameras =>
        "cameras that saw the object at the same time contradict each other, so their images were not combined",
        ": one has moved since the rig was calibrated, its clock is off, or names are swapped";
    Self::LooseTags(tags) =>
        "{names} moved too, but no image shows them with the object",
        ": if they are part of it, show them together with its other tags",
        names = listed(tags);
    Self::UnassignedTags(tags) =>
        "{names} moved, but no image shows them with another tag that moves as they do",
        ": show them together with the other tags of their object",
        names = listed(tags);
    Self::UnsharedObject(object) =>
        "no two cameras saw {object} at the same time, so that it does not help to place them",
        ": carry it where their views overlap";
    Self::FewSightings { camera, images } =>
        "{camera} saw objects in only {images} images",
        ": carry them longer before it";
    Self::UncertainFocal { camera, percent } =>
        "the focal length of {camera} is known to no better than {percent:.1} %",
        ": show it objects nearer and tilted";
    Self::UncoveredCorners { camera, missing } =>
        "no tag reached {missing} of the 4 corners of the image of {camera}, so that its distortion is uncertain there",
        ": carry objects along the edge of its view";
    Self::Unplaced(cause) =>
        "{cause}",
        "";
    Self::Thinned { stored, received } =>
        "{stored} of {received} images were used, in stretches of half a second spread over the whole time",
        ": more only cost time";
    Self::OtherSize {
        camera,
        images,
        size: [width, height],
        expected: [expected_width, expected_height],
    } =>
        "{images} images of {camera} were left out, since they have {width} x {height} pixels and not \
         {expected_width} x {expected_height}",
        ": set the camera back, or calibrate its lens for images of that size";
    Self::ImagesNotStored { stored, not_stored } =>
        "the last {not_stored} images were left out, since {stored} are the most",
        ": record less often or for a shorter time";
    Self::UncertainRobot =>
        "base and hand are uncertain",
        ": add poses, with the object near and all over the image, the hand turned by 30 degrees or more about each \
         axis";
    Self::FewRobotPoses(poses) =>
        "only {poses} poses of the robot",
        "; use 15 or more";
    Self::RobotOutliers(images) if images.len() == 1 =>
        "the pose of the robot at image {numbers} contradicts the others",
        ": did the hand stand still, and is each pose that of its image?",
        numbers = listed(images);
    Self::RobotOutliers(images) =>
        "the poses of the robot at image {numbers} contradict the others",
        ": did the hand stand still, and is each pose that of its image?",
        numbers = listed(images);
    Self::RobotDisagrees { mm, deg } =>
        "robot and images disagree by {mm:.1} mm and {deg:.2} degrees",
        ": check the tool that the robot's poses are of, its own calibration, the lens and the size of the tags";
    Self::RobotClock { ms, sigma_ms } =>
        "the clock of the robot is {off_ms:.1} ms (one sigma {sigma_ms:.1}) {side} that of the images, which was \
         corrected",
        "",
        off_ms = ms.abs(),
        side = if *ms > 0.0 { "ahead of" } else { "behind" };
    Self::LensDiffers { camera, percent } =>
        "by the robot's poses the focal length of {camera} is {percent:+.1} % that of the rig file, which was \
         corrected here only",
        ": calibrate its lens (`sextant calibrate lens`)";
}}

impl ScaleSource {
    fn words(self) -> &'static str {
        match self {
            Self::Object => "the carried object",
            Self::OtherTags => "the other tags",
            Self::Spacing => "their spacing",
        }
    }
}

impl Serialize for Finding {
    /// As its sentence.
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}
