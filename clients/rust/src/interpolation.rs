//! The pose between two poses.
//!
//! Position and attitude move evenly from one to the other. What that adds to the covariance is stated, not hidden:
//!
//! - The errors of successive estimates are correlated to an unknown degree. For any correlation, the covariance of
//!   `(1 - s) a + s b` is at most `(1 - s) Cov(a) + s Cov(b)`, since the difference is `s (1 - s) E[(a - b)(a - b)']`.
//! - Even motion leaves out acceleration, of which the velocities at both ends tell: the remainder of linear
//!   interpolation over an interval `T` is `s (1 - s) / 2 * T * (v_b - v_a)`. It enters as an error of that size.

use crate::Pose;
use nalgebra::{Matrix6, Vector6};
use sextant_geometry::so3;
use sextant_proto::State;

/// The pose at `t_ns`, from `before` to `after`.
pub(crate) fn interpolate(before: &Pose, after: &Pose, t_ns: u64) -> Pose {
    if t_ns <= before.t_ns || after.t_ns <= before.t_ns {
        return before.clone();
    }
    if t_ns >= after.t_ns {
        return after.clone();
    }
    let interval_ns = (after.t_ns - before.t_ns) as f64;
    let share = (t_ns - before.t_ns) as f64 / interval_ns;
    let turn = so3::log(&(after.orientation * before.orientation.inverse()));
    let remainder = remainder(before, after) * (share * (1.0 - share) / 2.0 * interval_ns * 1e-9);
    Pose {
        t_ns,
        published_ns: after.published_ns,
        state: worse(before.state, after.state),
        position: before.position.lerp(&after.position, share),
        orientation: so3::exp(&(turn * share)) * before.orientation,
        covariance: mixed(&before.covariance, &after.covariance, share)
            + remainder * remainder.transpose(),
        velocity: before.velocity.lerp(&after.velocity, share),
        angular_velocity: before.angular_velocity.lerp(&after.angular_velocity, share),
        cameras: before.cameras.min(after.cameras),
        tags: before.tags.min(after.tags),
        rms_px: before.rms_px.max(after.rms_px),
        ..before.clone()
    }
}

fn mixed(before: &Matrix6<f64>, after: &Matrix6<f64>, share: f64) -> Matrix6<f64> {
    before * (1.0 - share) + after * share
}

/// The change of the twist.
fn remainder(before: &Pose, after: &Pose) -> Vector6<f64> {
    let linear = after.velocity - before.velocity;
    let angular = after.angular_velocity - before.angular_velocity;
    Vector6::new(
        linear.x, linear.y, linear.z, angular.x, angular.y, angular.z,
    )
}

/// The state that promises less.
pub(crate) fn worse(one: State, other: State) -> State {
    let rank = |state| match state {
        State::Tracking => 0,
        State::Coasting => 1,
        State::Initialising => 2,
        State::Lost => 3,
    };
    if rank(one) >= rank(other) { one } else { other }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use nalgebra::{UnitQuaternion, Vector3};

    const START: u64 = 1_800_000_000_000_000_000;

    /// A pose `seconds` after the start, at rest unless a twist is given.
    pub(crate) fn pose(seconds: f64, position: Vector3<f64>, turn: Vector3<f64>) -> Pose {
        Pose {
            object: "cube".into(),
            epoch: 1,
            sequence: 0,
            t_ns: START + (seconds * 1e9) as u64,
            published_ns: START,
            state: State::Tracking,
            position,
            orientation: UnitQuaternion::from_scaled_axis(turn),
            covariance: Matrix6::identity() * 1e-6,
            velocity: Vector3::zeros(),
            angular_velocity: Vector3::zeros(),
            cameras: 2,
            tags: 3,
            rms_px: 0.1,
        }
    }

    fn ns(seconds: f64) -> u64 {
        START + (seconds * 1e9) as u64
    }

    #[test]
    fn half_way_is_half_the_motion() {
        let before = pose(0.0, Vector3::zeros(), Vector3::zeros());
        let after = pose(
            0.1,
            Vector3::new(0.2, 0.0, -0.4),
            Vector3::new(0.0, 0.0, 1.0),
        );
        let between = interpolate(&before, &after, ns(0.05));
        assert!((between.position - Vector3::new(0.1, 0.0, -0.2)).norm() < 1e-9);
        let turn = between.orientation.scaled_axis();
        assert!((turn - Vector3::new(0.0, 0.0, 0.5)).norm() < 1e-7, "{turn}");
        assert_eq!(interpolate(&before, &after, before.t_ns), before);
        assert_eq!(interpolate(&before, &after, after.t_ns), after);
    }

    #[test]
    fn the_state_is_the_worse_one() {
        let before = pose(0.0, Vector3::zeros(), Vector3::zeros());
        let mut after = pose(0.1, Vector3::zeros(), Vector3::zeros());
        after.state = State::Coasting;
        assert_eq!(
            interpolate(&before, &after, ns(0.01)).state,
            State::Coasting
        );
    }

    /// Free fall for a tenth of a second: half way, even motion is off by g T^2 / 8, which the covariance must cover.
    #[test]
    fn the_covariance_covers_acceleration() {
        let (g, interval) = (9.81, 0.1);
        let mut before = pose(0.0, Vector3::zeros(), Vector3::zeros());
        let mut after = pose(
            interval,
            Vector3::new(0.0, 0.0, -g * interval * interval / 2.0),
            Vector3::zeros(),
        );
        before.covariance.fill(0.0);
        after.covariance.fill(0.0);
        after.velocity.z = -g * interval;
        let between = interpolate(&before, &after, ns(interval / 2.0));
        let truth = -g * (interval / 2.0).powi(2) / 2.0;
        let error = between.position.z - truth;
        assert!((error + g * interval * interval / 8.0).abs() < 1e-9);
        assert!((between.covariance[(2, 2)].sqrt() - error.abs()).abs() < 1e-9);
    }

    /// Wholly correlated and wholly opposed errors are both within the reported covariance.
    #[test]
    fn the_covariance_holds_for_any_correlation() {
        let mut before = pose(0.0, Vector3::zeros(), Vector3::zeros());
        let after = pose(0.1, Vector3::zeros(), Vector3::zeros());
        before.covariance *= 9.0;
        let between = interpolate(&before, &after, ns(0.03));
        for sign in [-1.0, 0.0, 1.0] {
            let (a, b) = (0.7 * 3e-3, 0.3 * 1e-3);
            let true_variance: f64 = a * a + b * b + 2.0 * sign * a * b;
            assert!(between.covariance[(0, 0)] >= true_variance);
        }
    }
}
