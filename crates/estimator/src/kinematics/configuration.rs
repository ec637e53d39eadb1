//! Configuration: pose of the reference link, joint values and their rates.
//!
//! Matrices over a configuration have the size D: 6 for the pose and a place for each joint. Unused places have
//! variance one and are uncorrelated. Where shutters roll, the rates follow in as many places again: 12 for a rigid
//! object, 28 for one with joints.

use nalgebra::{SVector, Vector6};
use sextant_geometry::{Pose, se3};

use sextant_site_model::MOST_JOINTS;

/// Values of the joints that move, in the order of the model; zero beyond them.
pub(crate) type Values = SVector<f64, MOST_JOINTS>;

/// Where an object and its joints are, and how fast they move.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Configuration {
    /// Index of the link whose pose it has; 0 for a rigid object.
    pub root: usize,
    /// World from that link.
    pub pose: Pose,
    /// rad or m.
    pub joints: Values,
    pub rates: Rates,
}

/// How fast a root and joints move.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct Rates {
    /// Of the root: m/s and rad/s, world axes.
    pub twist: Vector6<f64>,
    /// Of the joints: rad/s or m/s.
    pub speeds: Values,
}

/// Where the rates begin among `size` places; `None` where they have none.
pub(crate) const fn rates_at(size: usize) -> Option<usize> {
    match size {
        12 | 28 => Some(size / 2),
        _ => None,
    }
}

/// How many of `size` places are values of joints.
pub(crate) const fn joint_places(size: usize) -> usize {
    match rates_at(size) {
        Some(rates) => rates - 6,
        None => size - 6,
    }
}

impl Configuration {
    /// Of a rigid object.
    pub fn rigid(pose: &Pose) -> Self {
        Self {
            root: 0,
            pose: *pose,
            joints: Values::zeros(),
            rates: Rates::default(),
        }
    }

    /// After a small step of root and joints, and of their rates where these have places.
    pub fn perturbed<const D: usize>(&self, step: &SVector<f64, D>) -> Self {
        let (mut joints, mut rates) = (self.joints, self.rates);
        for slot in 0..joint_places(D) {
            joints[slot] += step[6 + slot];
        }
        if let Some(first) = rates_at(D) {
            rates.twist += step.fixed_rows::<6>(first);
            (0..joint_places(D)).for_each(|slot| rates.speeds[slot] += step[first + 6 + slot]);
        }
        Self {
            root: self.root,
            pose: se3::perturb(&self.pose, &step.fixed_rows::<6>(0).into_owned()),
            joints,
            rates,
        }
    }

    /// The step that leads from `other`, of the same root, to this one.
    pub fn difference<const D: usize>(&self, other: &Self) -> SVector<f64, D> {
        let mut off = SVector::<f64, D>::zeros();
        off.fixed_rows_mut::<6>(0)
            .copy_from(&se3::difference(&self.pose, &other.pose));
        for slot in 0..joint_places(D) {
            off[6 + slot] = self.joints[slot] - other.joints[slot];
        }
        if let Some(first) = rates_at(D) {
            let (ours, others) = (&self.rates, &other.rates);
            off.fixed_rows_mut::<6>(first)
                .copy_from(&(ours.twist - others.twist));
            let speed = |slot: usize| ours.speeds[slot] - others.speeds[slot];
            (0..joint_places(D)).for_each(|slot| off[first + 6 + slot] = speed(slot));
        }
        off
    }
}
