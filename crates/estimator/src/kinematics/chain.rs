//! Where the links of an object are: its configuration (pose of a link, its root, and values of the joints) and how
//! links move with it.
//!
//! world_from_link = world_from_root * product over the joints on the way of parent_from_joint * motion(value),
//! inverted where the way leads from child to parent. A step (dt, dr) of the root and dq of a joint whose axis lies
//! along a through c (world) moves a link at p by dp = dt + dr x (p - p_root) + sum of a x (p - c) dq (revolute) or a
//! dq (prismatic), and turns it by dr + sum of a dq (revolute): the geometric Jacobian (Siciliano et al. 2009,
//! Robotics, eqs. 3.26-3.30), with the other sign on the way from child to parent.

use std::sync::Arc;

use nalgebra::{Matrix6, SMatrix, Vector3, Vector6};
use sextant_geometry::Pose;

use crate::kinematics::configuration::{Configuration, Rates};
use sextant_site_model::{Articulation, Joint, JointKind, MOST_JOINTS};

/// A joint on the way to a link.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Step {
    /// Index of the joint in the model.
    joint: usize,
    /// Its place among the values; `None` where it is fixed.
    slot: Option<usize>,
    direction: Direction,
}

/// Which way a joint is passed.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Direction {
    ToChild,
    ToParent,
}

/// The links of an object, and the ways between them.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct KinematicChain {
    pub articulation: Articulation,
    /// From link to link.
    ways: Vec<Vec<Vec<Step>>>,
}

/// One link of an object.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct ChainLink {
    pub chain: Arc<KinematicChain>,
    pub link: usize,
}

impl KinematicChain {
    pub fn new(articulation: &Articulation) -> Self {
        let links = articulation.links().len();
        let out: Vec<Vec<Step>> = (0..links)
            .map(|link| outwards(articulation, link))
            .collect();
        let way = |from: usize, to: usize| between(&out[from], &out[to]);
        Self {
            ways: (0..links)
                .map(|from| (0..links).map(|to| way(from, to)).collect())
                .collect(),
            articulation: articulation.clone(),
        }
    }

    /// The joints that move, in the order of the values.
    pub fn moving(&self) -> impl Iterator<Item = &Joint> {
        self.articulation.joints().iter().filter(|one| one.moves())
    }

    pub fn world_from_link(&self, at: &Configuration, link: usize) -> Pose {
        let mut pose = at.pose;
        for step in &self.ways[at.root][link] {
            pose *= self.motion(step, at);
        }
        pose
    }

    /// The same links about another root.
    pub fn rooted(&self, at: &Configuration, root: usize) -> Configuration {
        Configuration {
            root,
            pose: self.world_from_link(at, root),
            joints: at.joints,
            rates: Rates {
                twist: self.twist(at, root),
                ..at.rates
            },
        }
    }

    /// The twist of a link.
    pub fn twist(&self, at: &Configuration, link: usize) -> Vector6<f64> {
        let jacobian = self.jacobian::<{ 6 + MOST_JOINTS }>(at, link);
        jacobian.fixed_columns::<6>(0) * at.rates.twist
            + jacobian.fixed_columns::<MOST_JOINTS>(6) * at.rates.speeds
    }

    /// Derivative of a link's pose by the configuration.
    pub fn jacobian<const D: usize>(&self, at: &Configuration, link: usize) -> SMatrix<f64, 6, D> {
        let place = self.world_from_link(at, link).translation.vector;
        let mut jacobian = SMatrix::<f64, 6, D>::zeros();
        jacobian.fixed_view_mut::<6, 6>(0, 0).fill_with_identity();
        let arm = place - at.pose.translation.vector;
        for axis in 0..3 {
            let moved = Vector3::ith(axis, 1.0).cross(&arm);
            let mut column = jacobian.fixed_view_mut::<3, 1>(0, 3 + axis);
            column.copy_from(&moved);
        }
        let mut pose = at.pose;
        for step in &self.ways[at.root][link] {
            let next = pose * self.motion(step, at);
            if let Some(slot) = step.slot {
                let column = self.column(step, &pose, &next, &place);
                jacobian
                    .fixed_view_mut::<6, 1>(0, 6 + slot)
                    .copy_from(&column);
            }
            pose = next;
        }
        jacobian
    }

    /// How a link at `place` moves with a joint on the way to it, between two links at these poses.
    fn column(&self, step: &Step, from: &Pose, to: &Pose, place: &Vector3<f64>) -> Vector6<f64> {
        let joint = &self.articulation.joints()[step.joint];
        let (world_from_parent, sign) = match step.direction {
            Direction::ToChild => (from, 1.0),
            Direction::ToParent => (to, -1.0),
        };
        let world_from_joint = world_from_parent * joint.parent_from_joint;
        let axis = world_from_joint.rotation * joint.axis * sign;
        let (moved, turned) = match joint.kind {
            JointKind::Revolute => (
                axis.cross(&(place - world_from_joint.translation.vector)),
                axis,
            ),
            _ => (axis, Vector3::zeros()),
        };
        Vector6::new(moved.x, moved.y, moved.z, turned.x, turned.y, turned.z)
    }

    fn motion(&self, step: &Step, at: &Configuration) -> Pose {
        let value = step.slot.map_or(0.0, |slot| at.joints[slot]);
        let parent_from_child = self.articulation.joints()[step.joint].parent_from_child(value);
        match step.direction {
            Direction::ToChild => parent_from_child,
            Direction::ToParent => parent_from_child.inverse(),
        }
    }

    /// The values that change where one link is with respect to another, in order from the first.
    pub fn between(&self, from: usize, to: usize) -> Vec<usize> {
        let way = self.ways[from][to].iter();
        way.filter_map(|step| step.slot).collect()
    }

    /// Index of the links that a value's joint connects: parent and child.
    pub fn ends(&self, slot: usize) -> Option<(usize, usize)> {
        let joint = self.moving().nth(slot)?;
        let link = |id| self.articulation.link(id);
        Some((link(&joint.parent)?, link(&joint.child)?))
    }

    /// Whether a link hangs on the joint of a value, next to it or farther out.
    pub fn hangs_on(&self, link: usize, slot: usize) -> bool {
        let base = self.articulation.base();
        let mut way = self.ways[base][link].iter();
        way.any(|step| step.slot == Some(slot))
    }
}

impl ChainLink {
    pub fn world_from_link(&self, at: &Configuration) -> Pose {
        self.chain.world_from_link(at, self.link)
    }

    pub fn twist(&self, at: &Configuration) -> Vector6<f64> {
        self.chain.twist(at, self.link)
    }

    pub fn jacobian<const D: usize>(&self, at: &Configuration) -> SMatrix<f64, 6, D> {
        self.chain.jacobian(at, self.link)
    }

    /// The covariance of the link's pose from that of the configuration.
    pub fn covariance<const D: usize>(
        &self,
        at: &Configuration,
        covariance: &SMatrix<f64, D, D>,
    ) -> Matrix6<f64> {
        let jacobian = self.jacobian::<D>(at);
        jacobian * covariance * jacobian.transpose()
    }
}

/// From the base to a link.
fn outwards(articulation: &Articulation, link: usize) -> Vec<Step> {
    let mut way = Vec::new();
    let mut next = articulation.joint_of(link);
    while let Some(joint) = next {
        let joints = articulation.joints();
        let moving_before = joints[..joint].iter().filter(|one| one.moves()).count();
        way.push(Step {
            joint,
            slot: joints[joint].moves().then_some(moving_before),
            direction: Direction::ToChild,
        });
        next = articulation
            .parent_of(joint)
            .and_then(|parent| articulation.joint_of(parent));
    }
    way.reverse();
    way
}

/// From one link to another, by their ways from the base: inwards to where these part, then outwards.
fn between(from: &[Step], to: &[Step]) -> Vec<Step> {
    let shared = from.iter().zip(to).take_while(|(a, b)| a == b).count();
    let inwards = from[shared..].iter().rev().map(|step| Step {
        direction: Direction::ToParent,
        ..*step
    });
    inwards.chain(to[shared..].iter().copied()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kinematics::configuration::Values;
    use nalgebra::SVector;
    use sextant_geometry::se3;
    use sextant_site_model::{JointId, LinkId};

    fn joint(name: &str, kind: JointKind, parent: &str, child: &str) -> Joint {
        Joint {
            id: JointId::new(name).unwrap(),
            kind,
            parent: LinkId::new(parent).unwrap(),
            child: LinkId::new(child).unwrap(),
            axis: Vector3::new(0.6, 0.0, 0.8),
            parent_from_joint: Pose::new(
                Vector3::new(0.1, 0.02, 0.03),
                Vector3::new(0.3, 0.1, 0.2),
            ),
            limits: None,
            max_speed: None,
        }
    }

    /// a - b (revolute) - c (fixed) - d (prismatic), and e on a (revolute).
    fn tree() -> KinematicChain {
        let links = ["a", "b", "c", "d", "e"].map(|name| LinkId::new(name).unwrap());
        let joints = vec![
            joint("slide", JointKind::Prismatic, "c", "d"),
            joint("weld", JointKind::Fixed, "b", "c"),
            joint("turn", JointKind::Revolute, "a", "b"),
            joint("other", JointKind::Revolute, "a", "e"),
        ];
        KinematicChain::new(&Articulation::new(links.to_vec(), joints).unwrap())
    }

    fn somewhere() -> Configuration {
        let mut joints = Values::zeros();
        joints[0] = 0.07;
        joints[1] = -0.8;
        joints[2] = 0.4;
        Configuration {
            root: 0,
            pose: Pose::new(Vector3::new(0.2, -0.1, 0.3), Vector3::new(0.5, -0.4, 0.9)),
            joints,
            rates: Rates {
                twist: Vector6::new(0.2, -0.4, 0.1, 1.0, 0.5, -2.0),
                speeds: joints * 3.0,
            },
        }
    }

    #[test]
    fn a_link_moves_by_its_twist() {
        let chain = tree();
        for (root, link) in (0..25).map(|pair| (pair / 5, pair % 5)) {
            let at = chain.rooted(&somewhere(), root);
            let mut rates = SVector::<f64, 14>::zeros();
            rates.fixed_rows_mut::<6>(0).copy_from(&at.rates.twist);
            rates.fixed_rows_mut::<8>(6).copy_from(&at.rates.speeds);
            let ahead = chain.world_from_link(&at.perturbed(&(rates * 1e-6)), link);
            let behind = chain.world_from_link(&at.perturbed(&(rates * -1e-6)), link);
            let slope = se3::difference(&ahead, &behind) / 2e-6;
            let off = (slope - chain.twist(&at, link)).amax();
            assert!(off < 1e-7, "link {link} from {root}: {off}");
        }
    }

    #[test]
    fn the_jacobian_of_every_link_about_every_root_is_the_numeric_one() {
        let chain = tree();
        for (root, link) in (0..25).map(|pair| (pair / 5, pair % 5)) {
            let at = chain.rooted(&somewhere(), root);
            let jacobian = chain.jacobian::<14>(&at, link);
            for column in 0..14 {
                let step = SVector::<f64, 14>::ith(column, 1e-6);
                let ahead = chain.world_from_link(&at.perturbed(&step), link);
                let behind = chain.world_from_link(&at.perturbed(&-step), link);
                let slope = se3::difference(&ahead, &behind) / 2e-6;
                let off = (slope - jacobian.column(column)).amax();
                assert!(off < 1e-8, "link {link} from {root}, {column}: {off}");
            }
        }
    }

    #[test]
    fn a_step_and_its_difference_are_inverse() {
        let at = somewhere();
        let step = SVector::<f64, 14>::from_fn(|row, _| 0.01 * (row as f64 - 5.0));
        assert!((at.perturbed(&step).difference::<14>(&at) - step).amax() < 1e-12);
        let with_rates = SVector::<f64, 28>::from_fn(|row, _| 0.01 * (row as f64 - 5.0));
        let back = at.perturbed(&with_rates).difference::<28>(&at);
        assert!((back - with_rates).amax() < 1e-12);
    }

    #[test]
    fn links_are_where_they_are_whatever_the_root() {
        let (chain, at) = (tree(), somewhere());
        for (root, link) in (0..25).map(|pair| (pair / 5, pair % 5)) {
            let again = chain.world_from_link(&chain.rooted(&at, root), link);
            let off = se3::difference(&again, &chain.world_from_link(&at, link));
            assert!(off.amax() < 1e-12, "{link} from {root}");
        }
    }

    #[test]
    fn the_values_between_two_links_run_from_the_first_to_the_second() {
        let chain = tree();
        // Values in the order of the model: slide, turn, other.
        assert_eq!(chain.between(0, 3), [1, 0]);
        assert_eq!(chain.between(3, 4), [0, 1, 2]);
        assert_eq!(chain.between(1, 2), []);
        assert!(chain.hangs_on(3, 1) && !chain.hangs_on(4, 1));
        assert_eq!(chain.ends(0), Some((2, 3)));
    }
}
