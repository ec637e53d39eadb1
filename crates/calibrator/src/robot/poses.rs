//! The poses that a robot reports, by time or by the number of an image.

use nalgebra::Vector6;
use sextant_adjustment::Hand;
use sextant_geometry::{Pose, se3};
use std::collections::BTreeMap;

/// Poses further apart than this are not interpolated, ns.
const LONGEST_GAP_NS: u64 = 200_000_000;

/// `base_from_hand`, as the robot reports it.
#[derive(Clone, Debug, PartialEq)]
pub enum RobotPoses {
    /// By time, ns.
    ByTime(BTreeMap<u64, Pose>),
    /// By the number of the image in its camera, from 0; the hand stands still while it is taken.
    ByImage(BTreeMap<u64, Pose>),
}

impl RobotPoses {
    /// The hand at an image, `delay_s` later by the robot's clock: of exactly that time, or between two poses that are
    /// at most 0.2 s apart.
    pub(super) fn hand(&self, number: usize, capture_ns: u64, delay_s: f64) -> Option<Hand> {
        match self {
            Self::ByImage(poses) => poses.get(&(number as u64)).map(standing),
            Self::ByTime(poses) => {
                let at_ns = capture_ns.checked_add_signed((delay_s * 1e9).round() as i64)?;
                at_time(poses, at_ns)
            }
        }
    }

    /// What tells the poses of images apart: images with one key show one pose.
    pub(super) fn key(&self, number: usize, capture_ns: u64) -> u64 {
        match self {
            Self::ByTime(_) => capture_ns,
            Self::ByImage(_) => number as u64,
        }
    }

    /// First and last key: times in ns, or numbers of images.
    pub(super) fn span(&self) -> Option<(u64, u64)> {
        let (Self::ByTime(poses) | Self::ByImage(poses)) = self;
        Some((*poses.first_key_value()?.0, *poses.last_key_value()?.0))
    }
}

fn standing(pose: &Pose) -> Hand {
    Hand {
        base_from_hand: *pose,
        twist: Vector6::zeros(),
    }
}

fn at_time(poses: &BTreeMap<u64, Pose>, at_ns: u64) -> Option<Hand> {
    let (before_ns, before) = poses.range(..=at_ns).next_back()?;
    let after = poses.range(at_ns + 1..).next();
    let near = after.filter(|(after_ns, _)| **after_ns - before_ns <= LONGEST_GAP_NS);
    let Some((after_ns, after)) = near else {
        return (*before_ns == at_ns).then(|| standing(before));
    };
    let seconds = (after_ns - before_ns) as f64 * 1e-9;
    let twist = se3::log(&(before.inverse() * after)) / seconds;
    let since_s = (at_ns - before_ns) as f64 * 1e-9;
    Some(Hand {
        base_from_hand: before * se3::exp(&(twist * since_s)),
        twist,
    })
}
