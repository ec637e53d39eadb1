//! Joints on a path: how a link of an articulated object moves with respect to the link before it.
//!
//! `parent_from_child = parent_from_joint * motion(value)`, the value being a wave of the path's period: a turn about
//! the axis (rad) or a shift along it (m).

use super::{Wave, about_axis};
use crate::pose_format;
use nalgebra::{Isometry3, Translation3, Vector3, Vector6};
use serde::{Deserialize, Serialize};

/// A joint that moves.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PathJoint {
    /// Letters a-z, digits, - and _; at most 32.
    pub id: String,
    /// How it moves.
    pub kind: PathJointKind,
    /// Unit vector in the joint's frame.
    pub axis: [f64; 3],
    /// Where it sits on the link before it.
    #[serde(with = "pose_format")]
    pub parent_from_joint: Isometry3<f64>,
    /// Lowest and highest value that an object file states, rad or m; the wave should stay within.
    pub limits: [f64; 2],
    /// Its value over a period, rad or m.
    pub value: Wave,
}

/// How a joint moves.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum PathJointKind {
    /// It turns.
    Revolute,
    /// It slides.
    Prismatic,
}

impl PathJoint {
    /// The child's pose and twist from its parent's, at the fundamental's angle; `rate` is that angle's per second.
    pub(super) fn child(
        &self,
        world_from_parent: &Isometry3<f64>,
        twist: &Vector6<f64>,
        angle: f64,
        rate: f64,
    ) -> (Isometry3<f64>, Vector6<f64>) {
        let (value, speed) = (self.value.value(angle), self.value.slope(angle) * rate);
        let axis = Vector3::from(self.axis);
        let world_from_joint = world_from_parent * self.parent_from_joint;
        let motion = match self.kind {
            PathJointKind::Revolute => {
                Isometry3::from_parts(Translation3::identity(), about_axis(&axis, value))
            }
            PathJointKind::Prismatic => {
                Isometry3::translation(axis.x * value, axis.y * value, axis.z * value)
            }
        };
        let world_from_child = world_from_joint * motion;
        let along = world_from_joint.rotation * axis * speed;
        let (v, w) = (
            twist.fixed_rows::<3>(0),
            twist.fixed_rows::<3>(3).into_owned(),
        );
        let arm = world_from_child.translation.vector - world_from_parent.translation.vector;
        let carried = v + w.cross(&arm);
        // A revolute joint turns the child about the child's own origin, which lies on its axis.
        let (v, w) = match self.kind {
            PathJointKind::Revolute => (carried, w + along),
            PathJointKind::Prismatic => (carried + along, w),
        };
        (world_from_child, Vector6::new(v.x, v.y, v.z, w.x, w.y, w.z))
    }

    /// All numbers of it, for validation.
    pub(super) fn numbers(&self) -> impl Iterator<Item = f64> + '_ {
        let place = self.parent_from_joint.translation.vector;
        let numbers = self.axis.into_iter().chain(self.limits);
        let numbers = numbers.chain([place.x, place.y, place.z]);
        numbers.chain(self.value.numbers())
    }
}
