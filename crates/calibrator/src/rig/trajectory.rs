//! Trajectory of the object in one camera: its possible poses in every image, and interpolated between images.

use nalgebra::Vector6;
use sextant_geometry::{Pose, se3};

/// Sightings of one camera by time.
#[derive(Clone, Debug, Default)]
pub(crate) struct Trajectory {
    /// Capture time and `camera_from_object`, best first (one or two), in order of time.
    sightings: Vec<(u64, Vec<Pose>)>,
}

/// Times at which a trajectory has a pose.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Moments {
    /// Only the capture times of images.
    Exact,
    /// Also times between two successive images that are close in time.
    Interpolated,
}

/// Largest difference of simultaneous capture times, ns.
pub(crate) const SAME_TIME_NS: u64 = 500_000;
/// Least share of images with a simultaneous partner for synchronised shutters.
const SYNCHRONISED: f64 = 0.5;
/// Longest interval for interpolation, ns.
const LONGEST_GAP_NS: u64 = 250_000_000;

impl Trajectory {
    /// A trajectory from poses in any order.
    pub(crate) fn from_sightings(mut sightings: Vec<(u64, Vec<Pose>)>) -> Self {
        sightings.retain(|(_, poses)| !poses.is_empty());
        sightings.sort_by_key(|(time, _)| *time);
        Self { sightings }
    }

    pub(crate) fn sightings(&self) -> impl Iterator<Item = (u64, &[Pose])> {
        self.sightings
            .iter()
            .map(|(time, poses)| (*time, poses.as_slice()))
    }

    /// The possible poses at a time: of the image at that time or, if requested, interpolated between adjacent images.
    /// Empty in a gap.
    pub(crate) fn at(&self, time_ns: u64, moments: Moments) -> Vec<Pose> {
        let after = self.sightings.partition_point(|(time, _)| *time < time_ns);
        let near = [after.checked_sub(1), Some(after)];
        let near = near
            .into_iter()
            .flatten()
            .filter_map(|at| self.sightings.get(at));
        let same = near.filter(|(time, _)| time.abs_diff(time_ns) <= SAME_TIME_NS);
        if let Some((_, poses)) = same.min_by_key(|(time, _)| time.abs_diff(time_ns)) {
            return poses.clone();
        }
        let earlier = after.checked_sub(1).and_then(|at| self.sightings.get(at));
        match (earlier, self.sightings.get(after)) {
            (Some(a), Some(b))
                if moments == Moments::Interpolated && b.0 - a.0 <= LONGEST_GAP_NS =>
            {
                let share = (time_ns - a.0) as f64 / (b.0 - a.0).max(1) as f64;
                interpolated(&a.1, &b.1, share)
            }
            _ => Vec::new(),
        }
    }

    /// Share of the poses with a simultaneous pose of another camera.
    pub(crate) fn part_shared(&self, others: &[&Self]) -> f64 {
        let shared = self.sightings.iter().filter(|(time, _)| {
            others.iter().any(|other| {
                let after = other
                    .sightings
                    .partition_point(|(t, _)| t + SAME_TIME_NS < *time);
                let next = other.sightings.get(after);
                next.is_some_and(|(t, _)| t.abs_diff(*time) <= SAME_TIME_NS)
            })
        });
        shared.count() as f64 / self.sightings.len().max(1) as f64
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.sightings.is_empty()
    }
}

/// Every pose of the one image with every one of the other, at a share of the way between them.
fn interpolated(starts: &[Pose], ends: &[Pose], share: f64) -> Vec<Pose> {
    let pairs = starts
        .iter()
        .flat_map(|start| ends.iter().map(move |end| (start, end)));
    pairs
        .map(|(start, end)| start * se3::exp(&(se3::log(&(start.inverse() * end)) * share)))
        .collect()
}

/// Whether shutters are synchronised: most images of a camera have a simultaneous one of another.
pub(crate) fn is_synchronised(trajectories: &[Trajectory]) -> bool {
    let part = |at: usize| {
        let others = trajectories
            .iter()
            .enumerate()
            .filter(|(other, _)| *other != at);
        let others: Vec<&Trajectory> = others.map(|(_, trajectory)| trajectory).collect();
        trajectories[at].part_shared(&others)
    };
    let parts: Vec<f64> = (0..trajectories.len()).map(part).collect();
    parts.iter().sum::<f64>() >= SYNCHRONISED * parts.len() as f64
}

/// The twist that leads from one pose to another in `dt` seconds, in world axes.
pub(crate) fn twist(from: &Pose, to: &Pose, dt: f64) -> Vector6<f64> {
    se3::difference(to, from) / dt
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Vector3;

    fn at(x: f64) -> Vec<Pose> {
        vec![Pose::translation(x, 0.0, 1.0)]
    }

    #[test]
    fn poses_are_interpolated_over_short_gaps_only() {
        let path = Trajectory::from_sightings(vec![
            (0, at(0.0)),
            (100_000_000, at(1.0)),
            (900_000_000, at(2.0)),
        ]);
        let x = |time: u64| {
            path.at(time, Moments::Interpolated)
                .first()
                .map(|pose| pose.translation.x)
        };
        assert!((x(25_000_000).unwrap() - 0.25).abs() < 1e-12);
        assert_eq!(x(100_000_400), Some(1.0));
        assert_eq!(x(500_000_000), None);
        assert_eq!(x(950_000_000), None);
        assert!(path.at(25_000_000, Moments::Exact).is_empty());
    }

    #[test]
    fn a_twist_leads_from_pose_to_pose() {
        let (from, to) = (Pose::identity(), Pose::translation(0.1, 0.0, 0.0));
        let twist = twist(&from, &to, 0.5);
        assert!((twist.fixed_rows::<3>(0) - Vector3::new(0.2, 0.0, 0.0)).norm() < 1e-12);
    }
}
