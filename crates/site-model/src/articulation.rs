//! Links and joints of an articulated object: a tree whose root is the base.
//!
//! `parent_from_child = parent_from_joint * motion(value)`: a revolute joint rotates the child by its value (rad) about
//! the axis through the joint's origin, a prismatic one translates it by its value (m) along the axis, a fixed one does
//! nothing. The axis is in the joint's frame, and at value zero the child's frame is the joint's (as in ROS's URDF).

use std::collections::BTreeSet;

use nalgebra::Vector3;
use serde::{Deserialize, Serialize};
use sextant_geometry::Pose;
use thiserror::Error;

use crate::rig::is_finite;
use crate::{JointId, LinkId};

/// Most moving joints of an object.
pub const MOST_JOINTS: usize = 8;
/// Most links of an object.
pub const MOST_LINKS: usize = 32;
/// Largest deviation of an axis from unit length; within it, the axis is normalised.
const AXIS_TOLERANCE: f64 = 1e-3;
/// Deviation from unit length up to which an axis is not normalised, so that it keeps every digit.
const ROUNDING: f64 = 1e-14;

/// Motion of a joint.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum JointKind {
    /// Rotation about the axis, radians.
    Revolute,
    /// Translation along the axis, metres.
    Prismatic,
    /// None.
    Fixed,
}

/// A joint between two links.
#[derive(Debug, Clone, PartialEq)]
pub struct Joint {
    /// Its name.
    pub id: JointId,
    /// Its motion.
    pub kind: JointKind,
    /// The parent link.
    pub parent: LinkId,
    /// The child link.
    pub child: LinkId,
    /// Unit vector in the joint's frame; ignored if it is fixed.
    pub axis: Vector3<f64>,
    /// Maps points of the joint's frame into the parent link.
    pub parent_from_joint: Pose,
    /// Smallest and largest value in rad or m; `None` if unlimited.
    pub limits: Option<[f64; 2]>,
    /// Highest speed in rad/s or m/s; `None` if unknown.
    pub max_speed: Option<f64>,
}

/// Links and the joints between them: a tree.
#[derive(Debug, Clone, PartialEq)]
pub struct Articulation {
    links: Vec<LinkId>,
    joints: Vec<Joint>,
}

/// Invalid links or joints.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum ArticulationError {
    /// No link, or too many.
    #[error("it has {0} links; 1 to {MOST_LINKS} are possible")]
    Links(usize),
    /// Too many moving joints.
    #[error("it has {0} joints that move; at most {MOST_JOINTS} are possible")]
    Joints(usize),
    /// A duplicate link.
    #[error("link {0} is there twice")]
    DuplicateLink(LinkId),
    /// A duplicate joint.
    #[error("joint {0} is there twice")]
    DuplicateJoint(JointId),
    /// A joint that refers to a missing link.
    #[error("joint {joint} joins link {link}, which is not there")]
    UnknownLink {
        /// The joint.
        joint: JointId,
        /// The missing link.
        link: LinkId,
    },
    /// A link with two joints as its parent.
    #[error("joint {joint} moves link {link}, which another joint moves already")]
    TwoParents {
        /// The second joint.
        joint: JointId,
        /// The link.
        link: LinkId,
    },
    /// A joint that closes a cycle of links.
    #[error("joint {0} closes a ring of links; they must make a tree")]
    Ring(JointId),
    /// A link other than the base without a joint.
    #[error("link {link} hangs on no joint, and the base is {base} already")]
    Loose {
        /// The link.
        link: LinkId,
        /// The base.
        base: LinkId,
    },
    /// An axis without a direction.
    #[error("the axis of joint {joint} has length {length}, not 1")]
    Axis {
        /// The joint.
        joint: JointId,
        /// Length of its axis.
        length: f64,
    },
    /// An origin that is not finite.
    #[error("the origin of joint {0} is not finite")]
    Origin(JointId),
    /// Invalid limits.
    #[error("the limits of joint {joint} are {lowest} to {highest}, not from less to more")]
    Limits {
        /// The joint.
        joint: JointId,
        /// The given lower limit.
        lowest: f64,
        /// The given upper limit.
        highest: f64,
    },
    /// An invalid speed.
    #[error("the highest speed of joint {joint} is {speed}; it must lie above 0")]
    Speed {
        /// The joint.
        joint: JointId,
        /// The given value.
        speed: f64,
    },
}

impl ArticulationError {
    /// The joint concerned, if any.
    pub fn joint(&self) -> Option<&JointId> {
        match self {
            Self::DuplicateJoint(joint)
            | Self::Ring(joint)
            | Self::Origin(joint)
            | Self::UnknownLink { joint, .. }
            | Self::TwoParents { joint, .. }
            | Self::Axis { joint, .. }
            | Self::Limits { joint, .. }
            | Self::Speed { joint, .. } => Some(joint),
            _ => None,
        }
    }
}

impl Articulation {
    /// Checks links and joints; axes are normalised.
    ///
    /// # Errors
    /// For the first link or joint that does not fit a tree with one root, and for the first joint with invalid
    /// numbers.
    pub fn new(links: Vec<LinkId>, mut joints: Vec<Joint>) -> Result<Self, ArticulationError> {
        check_links(&links)?;
        let moving = joints.iter().filter(|joint| joint.moves()).count();
        if moving > MOST_JOINTS {
            return Err(ArticulationError::Joints(moving));
        }
        let mut names = BTreeSet::new();
        for joint in &mut joints {
            if !names.insert(joint.id.clone()) {
                return Err(ArticulationError::DuplicateJoint(joint.id.clone()));
            }
            check_numbers(joint)?;
            if joint.moves() && (joint.axis.norm() - 1.0).abs() > ROUNDING {
                joint.axis.normalize_mut();
            }
        }
        check_tree(&links, &joints)?;
        Ok(Self { links, joints })
    }

    /// The links in the given order.
    pub fn links(&self) -> &[LinkId] {
        &self.links
    }

    /// The joints in the given order.
    pub fn joints(&self) -> &[Joint] {
        &self.joints
    }

    /// Index of the link of that name.
    pub fn link(&self, id: &LinkId) -> Option<usize> {
        self.links.iter().position(|link| link == id)
    }

    /// Index of the joint that moves a link; `None` for the base.
    pub fn joint_of(&self, link: usize) -> Option<usize> {
        let link = self.links.get(link)?;
        self.joints.iter().position(|joint| joint.child == *link)
    }

    /// Index of the link without a parent: the object's pose is its pose.
    pub fn base(&self) -> usize {
        let base = (0..self.links.len()).find(|link| self.joint_of(*link).is_none());
        base.unwrap_or(0)
    }

    /// Index of the parent link of a joint.
    pub fn parent_of(&self, joint: usize) -> Option<usize> {
        self.link(&self.joints.get(joint)?.parent)
    }
}

impl Joint {
    /// Whether the joint moves.
    pub fn moves(&self) -> bool {
        self.kind != JointKind::Fixed
    }

    /// Maps points of the child into the parent, for a value of the joint.
    pub fn parent_from_child(&self, value: f64) -> Pose {
        self.parent_from_joint * self.motion(value)
    }

    /// Motion of the joint at a value, in its own frame.
    pub fn motion(&self, value: f64) -> Pose {
        match self.kind {
            JointKind::Revolute => Pose::rotation(self.axis * value),
            JointKind::Prismatic => {
                Pose::from_parts((self.axis * value).into(), Default::default())
            }
            JointKind::Fixed => Pose::identity(),
        }
    }
}

fn check_links(links: &[LinkId]) -> Result<(), ArticulationError> {
    if !(1..=MOST_LINKS).contains(&links.len()) {
        return Err(ArticulationError::Links(links.len()));
    }
    let mut names = BTreeSet::new();
    match links.iter().find(|link| !names.insert(*link)) {
        Some(link) => Err(ArticulationError::DuplicateLink(link.clone())),
        None => Ok(()),
    }
}

fn check_numbers(joint: &Joint) -> Result<(), ArticulationError> {
    let id = || joint.id.clone();
    let length = joint.axis.norm();
    // The comparison also refuses NaN.
    let is_unit = (length - 1.0).abs() <= AXIS_TOLERANCE;
    if joint.moves() && !is_unit {
        return Err(ArticulationError::Axis {
            joint: id(),
            length,
        });
    }
    if !is_finite(&joint.parent_from_joint) {
        return Err(ArticulationError::Origin(id()));
    }
    if let Some([lowest, highest]) = joint.limits {
        let ordered = lowest.is_finite() && highest.is_finite() && lowest < highest;
        if !ordered {
            return Err(ArticulationError::Limits {
                joint: id(),
                lowest,
                highest,
            });
        }
    }
    match joint.max_speed {
        Some(speed) if !(speed.is_finite() && speed > 0.0) => {
            Err(ArticulationError::Speed { joint: id(), speed })
        }
        _ => Ok(()),
    }
}

fn check_tree(links: &[LinkId], joints: &[Joint]) -> Result<(), ArticulationError> {
    let mut moved = BTreeSet::new();
    for joint in joints {
        let unknown = [&joint.parent, &joint.child]
            .into_iter()
            .find(|link| !links.contains(link));
        if let Some(link) = unknown {
            return Err(ArticulationError::UnknownLink {
                joint: joint.id.clone(),
                link: link.clone(),
            });
        }
        if !moved.insert(&joint.child) {
            return Err(ArticulationError::TwoParents {
                joint: joint.id.clone(),
                link: joint.child.clone(),
            });
        }
    }
    if let Some(joint) = joints.iter().find(|joint| is_in_ring(joint, joints)) {
        return Err(ArticulationError::Ring(joint.id.clone()));
    }
    let mut roots = links.iter().filter(|link| !moved.contains(link));
    match (roots.next(), roots.next()) {
        (Some(base), Some(link)) => Err(ArticulationError::Loose {
            link: link.clone(),
            base: base.clone(),
        }),
        _ => Ok(()),
    }
}

/// Whether the path from the joint's parent to the base contains the joint's child.
fn is_in_ring(joint: &Joint, joints: &[Joint]) -> bool {
    let mut link = &joint.parent;
    for _ in 0..=joints.len() {
        if *link == joint.child {
            return true;
        }
        match joints.iter().find(|above| above.child == *link) {
            Some(above) => link = &above.parent,
            None => return false,
        }
    }
    false
}

#[cfg(test)]
mod tests;
