//! Links and joints of an object that is not rigid: a tree whose root is the base.
//!
//! `parent_from_child = parent_from_joint * motion(value)`: a revolute joint turns the child by its value (rad) about the
//! axis through the joint's origin, a prismatic one shifts it by its value (m) along the axis, a fixed one does nothing. The
//! axis is in the joint's frame, and at value zero the child's frame is the joint's (as in ROS's URDF).

use std::collections::BTreeSet;

use nalgebra::Vector3;
use serde::{Deserialize, Serialize};
use sextant_geometry::Pose;
use thiserror::Error;

use crate::rig::is_finite;
use crate::{JointId, LinkId};

/// Most joints of an object that move.
pub const MOST_JOINTS: usize = 8;
/// Most links of an object.
pub const MOST_LINKS: usize = 32;
/// How far an axis may be from unit length; within it, it is normalised.
const AXIS_TOLERANCE: f64 = 1e-3;
/// An axis whose length differs from one by no more than this keeps every digit.
const ROUNDING: f64 = 1e-14;

/// How a joint lets its child move.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum JointKind {
    /// It turns about the axis, radians.
    Revolute,
    /// It slides along the axis, metres.
    Prismatic,
    /// It does not move.
    Fixed,
}

/// A joint between two links.
#[derive(Debug, Clone, PartialEq)]
pub struct Joint {
    /// Its name.
    pub id: JointId,
    /// How it moves.
    pub kind: JointKind,
    /// The link that carries it.
    pub parent: LinkId,
    /// The link that it moves.
    pub child: LinkId,
    /// Unit vector in the joint's frame; without a meaning where it is fixed.
    pub axis: Vector3<f64>,
    /// Maps points of the joint's frame into the parent link.
    pub parent_from_joint: Pose,
    /// Lowest and highest value in rad or m; `None` where nothing stops it.
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

/// Why links and joints make no object.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum ArticulationError {
    /// No link, or more than there is room for.
    #[error("it has {0} links; 1 to {MOST_LINKS} are possible")]
    Links(usize),
    /// More joints that move than there is room for.
    #[error("it has {0} joints that move; at most {MOST_JOINTS} are possible")]
    Joints(usize),
    /// The same link twice.
    #[error("link {0} is there twice")]
    DuplicateLink(LinkId),
    /// The same joint twice.
    #[error("joint {0} is there twice")]
    DuplicateJoint(JointId),
    /// A joint at a link that is not there.
    #[error("joint {joint} joins link {link}, which is not there")]
    UnknownLink {
        /// The joint.
        joint: JointId,
        /// The link that it names.
        link: LinkId,
    },
    /// A link that two joints move.
    #[error("joint {joint} moves link {link}, which another joint moves already")]
    TwoParents {
        /// The second joint.
        joint: JointId,
        /// The link.
        link: LinkId,
    },
    /// A joint that closes a ring of links.
    #[error("joint {0} closes a ring of links; they must make a tree")]
    Ring(JointId),
    /// A link without a joint besides the base.
    #[error("link {link} hangs on no joint, and the base is {base} already")]
    Loose {
        /// The link.
        link: LinkId,
        /// The base.
        base: LinkId,
    },
    /// An axis that is no direction.
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
    /// Limits that are no interval.
    #[error("the limits of joint {joint} are {lowest} to {highest}, not from less to more")]
    Limits {
        /// The joint.
        joint: JointId,
        /// The first.
        lowest: f64,
        /// The second.
        highest: f64,
    },
    /// A speed that is none.
    #[error("the highest speed of joint {joint} is {speed}; it must lie above 0")]
    Speed {
        /// The joint.
        joint: JointId,
        /// The given value.
        speed: f64,
    },
}

impl ArticulationError {
    /// The joint that it is about, where it is about one.
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
    /// Checks links and joints and takes them over; axes are normalised.
    ///
    /// # Errors
    /// For the first link or joint that does not fit a tree with one root, and for the first joint whose numbers are no
    /// direction, place, interval or speed.
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

    /// The links in the order given.
    pub fn links(&self) -> &[LinkId] {
        &self.links
    }

    /// The joints in the order given.
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

    /// Index of the link that hangs on no joint: the object's pose is its pose.
    pub fn base(&self) -> usize {
        let base = (0..self.links.len()).find(|link| self.joint_of(*link).is_none());
        base.unwrap_or(0)
    }

    /// Index of the link that carries a joint.
    pub fn parent_of(&self, joint: usize) -> Option<usize> {
        self.link(&self.joints.get(joint)?.parent)
    }
}

impl Joint {
    /// Whether it has a value.
    pub fn moves(&self) -> bool {
        self.kind != JointKind::Fixed
    }

    /// Maps points of the child into the parent at a value.
    pub fn parent_from_child(&self, value: f64) -> Pose {
        self.parent_from_joint * self.motion(value)
    }

    /// What the joint does at a value, in its own frame.
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
    // Written so that NaN is refused.
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

/// Whether the way from the joint's parent towards the base comes to the joint's child.
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
