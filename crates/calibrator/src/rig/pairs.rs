//! Relative poses of pairs of cameras by consensus, and the tree that connects all cameras.
//!
//! At each common time of two cameras, each pair of possible poses of the object proposes a relative pose of the
//! cameras. The right one recurs while the object moves; mirrored poses and wrong tags propose something else every
//! time.

use super::trajectory::{Moments, Trajectory};
use crate::graph::PoseGraph;
use sextant_geometry::{Pose, so3};

/// Possible poses of the object in two cameras at one time.
struct CommonView {
    first: Vec<Pose>,
    second: Vec<Pose>,
}

/// Most common views of a pair.
const MOST_MEETINGS: usize = 150;
/// Most common views that propose a relative pose.
const MOST_PROPOSERS: usize = 50;
/// A relative pose agrees within this share of the distance to the object (and metres), and within these radians.
const NEAR: (f64, f64) = (0.06, 0.02);
const NEAR_RAD: f64 = 0.12;
/// Least number of agreeing common views that connects two cameras.
const LEAST: f64 = 1.5;
/// Least share of agreeing common views that is significant.
const LEAST_PART: f64 = 0.1;

/// Graph of cameras with relative poses of pairs; strength is the number of agreeing common views. `bodies` has the
/// trajectory of each rigid body in each camera.
pub(crate) fn joined_cameras(bodies: &[Vec<Trajectory>], moments: Moments) -> PoseGraph {
    let n = bodies.first().map_or(0, Vec::len);
    let mut joined = PoseGraph::new(n);
    for a in 0..n {
        for b in a + 1..n {
            let of_bodies = bodies.iter().map(|of| meetings(&of[a], &of[b], moments));
            let meetings = thinned(of_bodies.flatten().collect(), MOST_MEETINGS);
            if let Some((strength, pose)) = consensus(&meetings) {
                joined.join([a, b], strength, pose);
            }
        }
    }
    joined
}

fn meetings(first: &Trajectory, second: &Trajectory, moments: Moments) -> Vec<CommonView> {
    let met = second.sightings().filter_map(|(time_ns, poses)| {
        let there = first.at(time_ns, moments);
        (!there.is_empty()).then(|| CommonView {
            first: there,
            second: poses.to_vec(),
        })
    });
    met.collect()
}

fn thinned<T>(all: Vec<T>, most: usize) -> Vec<T> {
    let n = all.len();
    let keep = |at: usize| n <= most || (at * most) / n != ((at + 1) * most) / n;
    let kept = all.into_iter().enumerate().filter(|(at, _)| keep(*at));
    kept.map(|(_, item)| item).collect()
}

fn consensus(meetings: &[CommonView]) -> Option<(f64, Pose)> {
    let mut best: Option<(f64, Pose)> = None;
    let stride = meetings.len().div_ceil(MOST_PROPOSERS).max(1);
    for meeting in meetings.iter().step_by(stride) {
        for candidate in meeting.proposals() {
            let votes: f64 = meetings.iter().map(|m| m.vote(&candidate)).sum();
            if best.as_ref().is_none_or(|(most, _)| votes > *most) {
                best = Some((votes, candidate));
            }
        }
    }
    let least = LEAST.min(0.6 * meetings.len() as f64);
    best.filter(|(votes, _)| *votes >= least && *votes >= LEAST_PART * meetings.len() as f64)
}

impl CommonView {
    fn proposals(&self) -> impl Iterator<Item = Pose> {
        let first = self.first.iter();
        first.flat_map(|first| {
            self.second
                .iter()
                .map(move |second| first * second.inverse())
        })
    }

    /// Agreement of the best proposal of a common view, from 0 to 1.
    fn vote(&self, candidate: &Pose) -> f64 {
        let first = self.first.iter();
        let votes = first.flat_map(|first| {
            self.second.iter().map(move |second| {
                // Compared at the object, since both cameras look there.
                let apart = first.inverse() * (candidate * second);
                let depth = first.translation.vector.norm() + second.translation.vector.norm();
                let far = apart.translation.vector.norm() / (NEAR.0 * 0.5 * depth + NEAR.1);
                let turned = so3::log(&apart.rotation).norm() / NEAR_RAD;
                (1.0 - far.max(turned)).max(0.0)
            })
        });
        votes.fold(0.0, f64::max)
    }
}
