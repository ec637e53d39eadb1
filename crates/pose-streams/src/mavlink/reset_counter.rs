//! When an autopilot has to take a pose as it is instead of as a motion: after a gap, a new track, a restart of the
//! fusion node, or a jump that no motion explains, such as a change of the rig. `reset_counter` of `ODOMETRY` counts
//! these.

use sextant_proto::ObjectPose;
use sextant_site_report::State;

/// A longer time without a tracked pose is a gap.
const GAP_NS: u64 = 500_000_000;
/// Largest acceleration that counts as a motion, m/s²: a hard kick.
const MOST_ACCELERATION: f64 = 100.0;
/// Largest angular acceleration that counts as a motion, rad/s².
const MOST_ANGULAR_ACCELERATION: f64 = 1000.0;
/// Standard deviations of both poses that count as noise.
const SIGMAS: f64 = 5.0;

/// Counts jumps of one object's poses. It wraps from 255 to 0.
#[derive(Debug, Default)]
pub struct ResetCounter {
    count: u8,
    last: Option<ObjectPose>,
    is_interrupted: bool,
}

impl ResetCounter {
    /// Takes the next published pose; the count to send with it, none unless it is tracked.
    pub fn take(&mut self, pose: &ObjectPose) -> Option<u8> {
        if pose.state != State::Tracking {
            self.is_interrupted |= matches!(pose.state, State::Lost | State::Initialising);
            return None;
        }
        if let Some(last) = &self.last
            && (self.is_interrupted || is_reset(last, pose))
        {
            self.count = self.count.wrapping_add(1);
        }
        self.is_interrupted = false;
        self.last = Some(pose.clone());
        Some(self.count)
    }
}

fn is_reset(last: &ObjectPose, pose: &ObjectPose) -> bool {
    let gap_ns = pose.capture_ns.saturating_sub(last.capture_ns);
    // The fusion node numbers its poses from its start.
    let is_restarted = pose.sequence < last.sequence;
    is_restarted || gap_ns > GAP_NS || is_jump(last, pose, gap_ns as f64 * 1e-9)
}

/// Whether the pose is elsewhere than the last one with its velocity explains.
fn is_jump(last: &ObjectPose, pose: &ObjectPose, seconds: f64) -> bool {
    let (before, now) = (last.world_from_object(), pose.world_from_object());
    let [vx, vy, vz, wx, wy, wz] = last.twist.map(|rate| rate * seconds);
    let moved = now.translation.vector - before.translation.vector;
    let apart_m = (moved - nalgebra::Vector3::new(vx, vy, vz)).norm();
    let turn = nalgebra::UnitQuaternion::new(nalgebra::Vector3::new(wx, wy, wz));
    let apart_rad = now.rotation.angle_to(&(turn * before.rotation));
    let half_square = seconds * seconds / 2.0;
    apart_m > SIGMAS * sigma(last, pose, 0) + MOST_ACCELERATION * half_square
        || apart_rad > SIGMAS * sigma(last, pose, 3) + MOST_ANGULAR_ACCELERATION * half_square
}

/// Standard deviation of both poses together over three axes of their covariances.
fn sigma(last: &ObjectPose, pose: &ObjectPose, from: usize) -> f64 {
    let variances = [last, pose].into_iter();
    let variances = variances.flat_map(|one| (from..from + 3).map(|axis| one.covariance[axis * 7]));
    variances.sum::<f64>().sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use sextant_site_model::ObjectId;

    const PERIOD_NS: u64 = 33_000_000;

    /// The `n`-th image of an object that moves by 1 m/s along x; millimetres and milliradians of noise.
    fn pose(n: u64) -> ObjectPose {
        let mut covariance = [0.0; 36];
        covariance.iter_mut().step_by(7).for_each(|v| *v = 1e-6);
        let capture_ns = 1_800_000_000_000_000_000 + n * PERIOD_NS;
        ObjectPose {
            object: ObjectId::new("cube").unwrap(),
            epoch: 1,
            sequence: n,
            capture_ns,
            published_ns: capture_ns,
            state: State::Tracking,
            position: [n as f64 * PERIOD_NS as f64 * 1e-9, 0.0, 1.0],
            orientation: [0.0, 0.0, 0.0, 1.0],
            covariance,
            twist: [1.0, 0.0, 0.0, 0.0, 0.0, 0.0],
            cameras: 2,
            tags: 3,
            rms_px: 0.1,
        }
    }

    /// The counts of the poses 0, 1, 2 with a change of the last.
    fn last_count(change: impl FnOnce(&mut ObjectPose)) -> Option<u8> {
        let mut counter = ResetCounter::default();
        assert_eq!(
            [counter.take(&pose(0)), counter.take(&pose(1))],
            [Some(0); 2]
        );
        let mut last = pose(2);
        change(&mut last);
        counter.take(&last)
    }

    #[test]
    fn a_steady_motion_is_no_reset() {
        assert_eq!(last_count(|_| {}), Some(0));
        // As much as a kick may do in 33 ms: half of 100 m/s² times the square.
        assert_eq!(last_count(|pose| pose.position[1] = 0.05), Some(0));
    }

    #[test]
    fn jumps_gaps_and_restarts_are_resets() {
        assert_eq!(last_count(|pose| pose.position[1] = 0.10), Some(1));
        let upside_down = [1.0, 0.0, 0.0, 0.0];
        assert_eq!(last_count(|pose| pose.orientation = upside_down), Some(1));
        assert_eq!(last_count(|pose| pose.capture_ns += GAP_NS), Some(1));
        assert_eq!(last_count(|pose| pose.sequence = 0), Some(1));
    }

    #[test]
    fn a_lost_object_is_another_one_when_it_is_back() {
        for (state, expected) in [
            (State::Coasting, 0),
            (State::Lost, 1),
            (State::Initialising, 1),
        ] {
            let mut counter = ResetCounter::default();
            counter.take(&pose(0));
            let mut between = pose(1);
            between.state = state;
            assert_eq!(counter.take(&between), None);
            assert_eq!(counter.take(&pose(2)), Some(expected), "{state:?}");
        }
    }

    #[test]
    fn the_count_wraps() {
        let mut counter = ResetCounter::default();
        let mut count = None;
        for n in 0..=256 {
            let mut next = pose(n);
            next.position[2] = (n % 2) as f64;
            count = counter.take(&next);
        }
        assert_eq!(count, Some(0));
    }
}
