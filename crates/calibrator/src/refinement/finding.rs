//! What the moments say of the calibration, and the change that they ask for.

use super::Refinement;
use super::adjusting::{Moved, Relaxed};
use super::held_back::HeldBack;
use super::reservoir::Use;
use super::site::Place;
use sextant_estimator::{
    CameraId, ObjectError, ObjectId, ObjectModel, PoseSigma, Rig, RigError, TagId,
};
use sextant_geometry::{Pose, se3};
use std::fmt;

/// Fewer moments say nothing.
const LEAST_USED: usize = 20;
/// A place whose move lowers the sum of squares by less stays: one in 20000 by chance.
const LEAST_GAIN: f64 = 30.0;
/// The squared length of a move in its own deviations (six degrees of freedom) must be more.
const LEAST_DEVIATIONS: f64 = 30.0;
/// Places that are tried, most promising first.
const TRIED: usize = 3;

/// What is moved.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Part {
    /// A camera in the world.
    Camera(CameraId),
    /// A tag on its object.
    Tag {
        /// The object.
        object: ObjectId,
        /// The tag.
        tag: TagId,
    },
}

/// A proposed change.
#[derive(Clone, Debug, PartialEq)]
pub struct Change {
    /// What moves.
    pub part: Part,
    /// `world_from_camera` or `object_from_tag` as in force.
    pub before: Pose,
    /// As found.
    pub after: Pose,
    /// One deviation an axis of what was found, the others being where they are.
    pub sigma: PoseSigma,
    /// What the moments held back say.
    pub held_back: HeldBack,
}

/// What a refinement has found.
#[derive(Clone, Debug, PartialEq)]
pub enum Finding {
    /// There is not enough to go by yet.
    TooLittle,
    /// The calibration explains what was seen.
    Fine,
    /// Something could be moved, but what was held back is not foretold better by it.
    NotBetter {
        /// What.
        part: Part,
    },
    /// Something is further from where it was calibrated than is corrected without asking.
    TooFar {
        /// What.
        part: Part,
        /// By so many metres.
        distance_m: f64,
        /// And so many radians.
        angle_rad: f64,
    },
    /// A change that makes things better.
    Better(Change),
}

/// Tries the most promising places.
pub(super) fn find(refinement: &Refinement) -> Finding {
    let (site, reservoir) = (&refinement.site, &refinement.reservoir);
    if reservoir.moments(Use::Used).count() < LEAST_USED {
        return Finding::TooLittle;
    }
    let Some(relaxed) = Relaxed::of(site, reservoir.moments(Use::Used)) else {
        return Finding::TooLittle;
    };
    let gains = relaxed.gains(&refinement.calibrated);
    let promising = gains.iter().filter(|(_, gain)| *gain > LEAST_GAIN);
    let mut first = None;
    for (place, _) in promising.take(TRIED) {
        match judge(refinement, &relaxed, *place) {
            Some(found @ (Finding::Better(_) | Finding::TooFar { .. })) => return found,
            other => first = first.or(other),
        }
    }
    first.unwrap_or(Finding::Fine)
}

/// `None` where the move is too small to be certain of.
fn judge(refinement: &Refinement, relaxed: &Relaxed, place: Place) -> Option<Finding> {
    let (site, options) = (&refinement.site, &refinement.options);
    let moved = relaxed.moved(&refinement.calibrated, place)?;
    if moved.deviations(&site.pose(place)) < LEAST_DEVIATIONS {
        return None;
    }
    let part = site.part(place);
    let moments = refinement.reservoir.moments(Use::HeldBack);
    let held_back = HeldBack::ask(site, relaxed, &moved, moments);
    let Some(held_back) = held_back.filter(|held_back| held_back.is_better(options)) else {
        return Some(Finding::NotBetter { part });
    };
    let step = se3::difference(&moved.pose, &refinement.calibrated.pose(place));
    let (distance_m, angle_rad) = (
        step.fixed_rows::<3>(0).norm(),
        step.fixed_rows::<3>(3).norm(),
    );
    if distance_m > options.largest_move_m || angle_rad > options.largest_turn_rad {
        return Some(Finding::TooFar {
            part,
            distance_m,
            angle_rad,
        });
    }
    Some(Finding::Better(change(
        site.pose(place),
        part,
        &moved,
        held_back,
    )))
}

fn change(before: Pose, part: Part, moved: &Moved, held_back: HeldBack) -> Change {
    Change {
        part,
        before,
        after: moved.pose,
        sigma: moved.sigma(),
        held_back,
    }
}

impl Change {
    /// The rig with the camera where it was found; as it is where a tag was moved. What is stated of how well poses are known
    /// stays, and of the camera it becomes what was found.
    ///
    /// # Errors
    /// None that a found pose could cause.
    pub fn rig(&self, rig: &Rig) -> Result<Rig, RigError> {
        let Part::Camera(id) = &self.part else {
            return Ok(rig.clone());
        };
        let mut cameras = rig.cameras().to_vec();
        for camera in cameras.iter_mut().filter(|camera| camera.id == *id) {
            camera.world_from_camera = Some(self.after);
        }
        let stated = rig.pose_sigma(id).map(|_| (id.clone(), self.sigma));
        let found = Rig::new(cameras)?.with_pose_sigmas(stated)?;
        Ok(found.holding_on_to(rig))
    }

    /// The object with the tag where it was found; as it is where a camera or another object's tag was moved.
    ///
    /// # Errors
    /// None that a found pose could cause.
    pub fn object(&self, object: &ObjectModel) -> Result<ObjectModel, ObjectError> {
        let mut tags = object.tags().to_vec();
        match &self.part {
            Part::Tag { object: of, tag }
                if of == object.id() && object.articulation().is_none() =>
            {
                for own in tags.iter_mut().filter(|own| own.tag == *tag) {
                    own.object_from_tag = Some(self.after);
                }
                let stated = object.tag_sigma(tag).map(|_| (*tag, self.sigma));
                let found = ObjectModel::new(of.clone(), tags)?.with_tag_sigmas(stated)?;
                Ok(found.holding_on_to(object))
            }
            _ => Ok(object.clone()),
        }
    }

    /// How far it moves, metres, and turns, radians.
    pub fn extent(&self) -> (f64, f64) {
        let step = se3::difference(&self.after, &self.before);
        (
            step.fixed_rows::<3>(0).norm(),
            step.fixed_rows::<3>(3).norm(),
        )
    }
}

impl fmt::Display for Part {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Camera(id) => write!(f, "camera {id}"),
            Self::Tag { object, tag } => write!(f, "tag {tag} of object {object}"),
        }
    }
}

impl fmt::Display for Finding {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::TooLittle => f.write_str(
                "not enough seen yet: objects must be carried to many places that several cameras see",
            ),
            Self::Fine => f.write_str("the calibration explains what is seen"),
            Self::NotBetter { part } => write!(
                f,
                "{part} could be moved, but what was held back is not foretold better by it: it stays"
            ),
            Self::TooFar {
                part,
                distance_m,
                angle_rad,
            } => write!(
                f,
                "{part} is {:.1} mm and {:.2} degrees from where it was calibrated, more than is corrected without asking: calibrate it again",
                distance_m * 1e3,
                angle_rad.to_degrees()
            ),
            Self::Better(change) => {
                let (distance_m, angle_rad) = change.extent();
                let HeldBack {
                    moments,
                    before_px,
                    after_px,
                    ..
                } = change.held_back;
                write!(
                    f,
                    "{} moves by {:.2} mm and {:.3} degrees: {moments} moments held back go from {before_px:.3} to {after_px:.3} px",
                    change.part,
                    distance_m * 1e3,
                    angle_rad.to_degrees()
                )
            }
        }
    }
}
