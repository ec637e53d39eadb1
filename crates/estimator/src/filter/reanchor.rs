//! Choice of the link whose pose is in the state: one that is known well, the base of the model where that is no worse.
//!
//! The pose of a link that is not seen depends on joints that may have any value. With such a pose in the state the
//! unobservable directions would turn with every new estimate, and views would seem to observe them (Huang, Mourikis,
//! Roumeliotis 2010, Observability-based rules for designing consistent EKF SLAM estimators, sec. 4). With a link that
//! is seen they are the joints themselves, which no estimate turns.

use nalgebra::{Matrix6, SMatrix, Vector6};
use sextant_geometry::Pose;

use crate::filter::covariance::{Covariance, JointCross, WIDTH, symmetric};
use crate::filter::state::ObjectState;
use sextant_site_model::MOST_JOINTS;

/// Size of a configuration.
const SIZE: usize = 6 + MOST_JOINTS;
/// Metres from a link's origin at which its spread is looked at.
const ARM_M: f64 = 0.1;
/// Variance against the best link's up to which the base is preferred, and from which on another root is left.
const PREFERRED: f64 = 2.0;
const LEFT: f64 = 4.0;

impl ObjectState {
    /// The same knowledge about the root that suits the links that are seen.
    pub fn reanchored_to_best(self, seen: impl Iterator<Item = usize>) -> Self {
        let Some(joints) = &self.joints else {
            return self;
        };
        let base = joints.chain.articulation.base();
        let best = seen
            .map(|link| (self.spread(link), link))
            .min_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        let Some((spread, best)) = best else {
            return self;
        };
        let root = if self.spread(base) <= PREFERRED * spread {
            base
        } else if self.spread(joints.root) > LEFT * spread {
            best
        } else {
            joints.root
        };
        self.rooted(root)
    }

    /// Variance in m² of a point of a link.
    fn spread(&self, link: usize) -> f64 {
        let covariance = self.link_covariance(link);
        let sum = |first: usize| {
            (first..first + 3)
                .map(|axis| covariance[(axis, axis)])
                .sum::<f64>()
        };
        sum(0) + ARM_M * ARM_M * sum(3)
    }

    fn link_covariance(&self, link: usize) -> Matrix6<f64> {
        let covariance = self.observed::<SIZE>(usize::MAX).covariance;
        let jacobian = self.link_jacobian(link);
        jacobian * covariance * jacobian.transpose()
    }

    fn link_jacobian(&self, link: usize) -> SMatrix<f64, 6, SIZE> {
        let Some(joints) = &self.joints else {
            return SMatrix::identity();
        };
        joints.chain.jacobian(&self.configuration(), link)
    }

    /// Pose and twist of the object: those of its base.
    pub fn base(&self) -> (Pose, Vector6<f64>) {
        match &self.joints {
            None => (self.pose, self.twist),
            Some(joints) => self.link(joints.chain.articulation.base()),
        }
    }

    fn link(&self, link: usize) -> (Pose, Vector6<f64>) {
        let Some(joints) = &self.joints else {
            return (self.pose, self.twist);
        };
        let pose = joints.chain.world_from_link(&self.configuration(), link);
        (pose, self.link_jacobian(link) * self.rates::<SIZE>())
    }

    /// The same knowledge with another link's pose and twist in the state. To first order, and without what errors of
    /// the configuration change in the twist: they are small where there is a choice.
    fn rooted(mut self, root: usize) -> Self {
        let (pose, twist) = self.link(root);
        let jacobian = self.link_jacobian(root);
        let Some(joints) = self.joints.as_mut().filter(|joints| joints.root != root) else {
            return self;
        };
        let (mut by_motion, mut by_joints) = (Covariance::zeros(), JointCross::zeros());
        for half in 0..2 {
            by_motion
                .fixed_view_mut::<6, 6>(6 * half, 6 * half)
                .copy_from(&jacobian.fixed_columns::<6>(0));
            by_joints
                .fixed_view_mut::<6, MOST_JOINTS>(6 * half, MOST_JOINTS * half)
                .copy_from(&jacobian.fixed_columns::<MOST_JOINTS>(6));
        }
        let cross: SMatrix<f64, 12, WIDTH> = by_motion * joints.cross + by_joints * joints.own;
        let mixed = by_motion * joints.cross * by_joints.transpose();
        self.covariance = symmetric(
            &(by_motion * self.covariance * by_motion.transpose()
                + mixed
                + mixed.transpose()
                + by_joints * joints.own * by_joints.transpose()),
        );
        if let Some(clocks) = &mut self.clocks {
            clocks.cross = by_motion * clocks.cross + by_joints * joints.with_clocks;
        }
        if let Some(considered) = &mut self.considered {
            considered.rooted(&by_motion, &by_joints);
        }
        joints.cross = cross;
        joints.root = root;
        (self.pose, self.twist) = (pose, twist);
        self
    }
}
