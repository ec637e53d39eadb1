//! Where an object is: closed paths as analytic, periodic functions of true time.
//!
//! Every coordinate is a sum of harmonics of one period, so a path has no beginning: processes that start at different
//! moments agree on it, and its twist is a formula, not a difference. Attitude is R = Rz(yaw) Ry(pitch) Rx(roll).
//! A link of an articulated object goes with its base, with the joints from there to it on top.
//! Input: true time in ns. Output: `world_from_object` and the twist (v, w) in world axes, metres and radians (per
//! second).

mod event;
mod joint;

pub use event::PathEvent;
pub use joint::{PathJoint, PathJointKind};

use nalgebra::{Isometry3, Quaternion, Translation3, UnitQuaternion, Vector3, Vector6};
use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;

/// A closed path in the world.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Path {
    /// Duration of one round in s; above 0. The object is at the same place a period later.
    pub period_s: f64,
    /// Whole turns of yaw in one period; negative turns the other way round.
    #[serde(default)]
    pub turns: i32,
    /// x, y, z of the object's origin in the world, m.
    pub position: [Wave; 3],
    /// Yaw in addition to the turns, about the world's z axis, rad.
    #[serde(default)]
    pub yaw: Wave,
    /// Pitch, about the y axis after yaw, rad.
    #[serde(default)]
    pub pitch: Wave,
    /// Roll, about the x axis after yaw and pitch, rad.
    #[serde(default)]
    pub roll: Wave,
    /// Joints from there to this object, in order; none for a body of its own.
    #[serde(rename = "joint", default, skip_serializing_if = "Vec::is_empty")]
    pub joints: Vec<PathJoint>,
    /// Hits and throws in each period, at most 16; none cuts the period's end.
    #[serde(rename = "event", default, skip_serializing_if = "Vec::is_empty")]
    pub events: Vec<PathEvent>,
}

/// A periodic function: `mean + sum of amplitude * sin(order * TAU * t / period + phase)`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Wave {
    /// The constant part.
    pub mean: f64,
    /// The moving part; may be empty.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub harmonics: Vec<Harmonic>,
}

/// One sine of a [`Wave`].
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Harmonic {
    /// How many times it swings in a period.
    pub order: u32,
    /// In the unit of the wave.
    pub amplitude: f64,
    /// Radians at time 0.
    pub phase: f64,
}

impl Path {
    /// A path that stays where `world_from_object` is.
    pub fn at_rest(world_from_object: &Isometry3<f64>) -> Self {
        let (roll, pitch, yaw) = world_from_object.rotation.euler_angles();
        let position = world_from_object.translation.vector;
        Self {
            period_s: 1.0,
            turns: 0,
            position: [
                Wave::still(position.x),
                Wave::still(position.y),
                Wave::still(position.z),
            ],
            yaw: Wave::still(yaw),
            pitch: Wave::still(pitch),
            roll: Wave::still(roll),
            joints: Vec::new(),
            events: Vec::new(),
        }
    }

    /// Pose at a true time in ns.
    pub fn world_from_object(&self, true_ns: u64) -> Isometry3<f64> {
        self.pose_and_twist(true_ns).0
    }

    /// Twist at a true time in ns: linear then angular velocity, both in world axes (m/s, rad/s).
    pub fn twist(&self, true_ns: u64) -> Vector6<f64> {
        self.pose_and_twist(true_ns).1
    }

    /// The joints' values at a true time in ns, rad or m.
    pub fn joint_values(&self, true_ns: u64) -> Vec<f64> {
        let angle = self.angle(true_ns);
        let values = self.joints.iter().map(|joint| joint.value.value(angle));
        values.collect()
    }

    fn pose_and_twist(&self, true_ns: u64) -> (Isometry3<f64>, Vector6<f64>) {
        let (angle, rate) = (self.angle(true_ns), TAU / self.period_s);
        let (mut pose, mut twist) = (self.pose_of_base(angle), self.twist_of_base(angle));
        let time_s = angle / rate;
        for event in self.events.iter().filter_map(|event| event.at(time_s)) {
            let carried = event.rotation * twist.fixed_rows::<3>(3);
            let linear = twist.fixed_rows::<3>(0) + event.velocity;
            let angular = carried + event.angular_velocity;
            pose.translation.vector += event.offset;
            pose.rotation = event.rotation * pose.rotation;
            twist.fixed_rows_mut::<3>(0).copy_from(&linear);
            twist.fixed_rows_mut::<3>(3).copy_from(&angular);
        }
        for joint in &self.joints {
            (pose, twist) = joint.child(&pose, &twist, angle, rate);
        }
        (pose, twist)
    }

    fn pose_of_base(&self, angle: f64) -> Isometry3<f64> {
        let position = Vector3::from_fn(|axis, _| self.position[axis].value(angle));
        let (yaw, pitch, roll) = self.attitude(angle);
        let rotation = about(2, yaw) * about(1, pitch) * about(0, roll);
        Isometry3::from_parts(Translation3::from(position), rotation)
    }

    fn twist_of_base(&self, angle: f64) -> Vector6<f64> {
        let rate = TAU / self.period_s;
        let (yaw, pitch, _) = self.attitude(angle);
        let linear = Vector3::from_fn(|axis, _| self.position[axis].slope(angle)) * rate;
        let yaw_rate = (f64::from(self.turns) + self.yaw.slope(angle)) * rate;
        let pitch_rate = self.pitch.slope(angle) * rate;
        let roll_rate = self.roll.slope(angle) * rate;
        let angular = Vector3::z() * yaw_rate
            + about(2, yaw)
                * (Vector3::y() * pitch_rate + about(1, pitch) * Vector3::x() * roll_rate);
        Vector6::new(
            linear.x, linear.y, linear.z, angular.x, angular.y, angular.z,
        )
    }

    /// The angle of the fundamental, from 0 to TAU. The whole periods are taken off in integers: 2026 in ns needs 61
    /// bits.
    fn angle(&self, true_ns: u64) -> f64 {
        let period_ns = ((self.period_s * 1e9).round() as u64).max(1);
        (true_ns % period_ns) as f64 / period_ns as f64 * TAU
    }

    fn attitude(&self, angle: f64) -> (f64, f64, f64) {
        let yaw = f64::from(self.turns) * angle + self.yaw.value(angle);
        (yaw, self.pitch.value(angle), self.roll.value(angle))
    }

    /// All numbers of the path, for validation.
    pub(crate) fn numbers(&self) -> impl Iterator<Item = f64> + '_ {
        let waves = self
            .position
            .iter()
            .chain([&self.yaw, &self.pitch, &self.roll]);
        let joints = self.joints.iter().flat_map(PathJoint::numbers);
        let events = self.events.iter().flat_map(PathEvent::numbers);
        waves.flat_map(Wave::numbers).chain(joints).chain(events)
    }
}

impl Wave {
    /// A wave that doesn't move.
    pub fn still(mean: f64) -> Self {
        Self {
            mean,
            harmonics: Vec::new(),
        }
    }

    /// The same wave with one more sine.
    pub fn and(mut self, order: u32, amplitude: f64, phase: f64) -> Self {
        self.harmonics.push(Harmonic {
            order,
            amplitude,
            phase,
        });
        self
    }

    fn numbers(&self) -> impl Iterator<Item = f64> + '_ {
        let harmonics = self.harmonics.iter().flat_map(|h| [h.amplitude, h.phase]);
        std::iter::once(self.mean).chain(harmonics)
    }

    fn value(&self, angle: f64) -> f64 {
        let moving = |h: &Harmonic| h.amplitude * libm::sin(f64::from(h.order) * angle + h.phase);
        self.mean + self.harmonics.iter().map(moving).sum::<f64>()
    }

    /// Derivative by the fundamental's angle.
    fn slope(&self, angle: f64) -> f64 {
        let slope = |h: &Harmonic| {
            let order = f64::from(h.order);
            h.amplitude * order * libm::cos(order * angle + h.phase)
        };
        self.harmonics.iter().map(slope).sum()
    }
}

/// Rotation about a coordinate axis, with the same bits on every platform.
pub(crate) fn about(axis: usize, angle: f64) -> UnitQuaternion<f64> {
    about_axis(&Vector3::ith(axis, 1.0), angle)
}

/// The same about a unit vector.
fn about_axis(axis: &Vector3<f64>, angle: f64) -> UnitQuaternion<f64> {
    let imaginary = axis * libm::sin(angle / 2.0);
    UnitQuaternion::new_unchecked(Quaternion::from_parts(libm::cos(angle / 2.0), imaginary))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn wave() -> impl Strategy<Value = Wave> {
        let harmonic = (0u32..4, -0.5..0.5, -3.0..3.0);
        let harmonics = prop::collection::vec(harmonic, 0..3);
        (-1.0..1.0, harmonics).prop_map(|(mean, harmonics)| {
            harmonics
                .into_iter()
                .fold(Wave::still(mean), |wave, (order, amplitude, phase)| {
                    wave.and(order, amplitude, phase)
                })
        })
    }

    fn joint() -> impl Strategy<Value = PathJoint> {
        let kind = prop_oneof![
            Just(PathJointKind::Revolute),
            Just(PathJointKind::Prismatic)
        ];
        (kind, -1.0..1.0, wave()).prop_map(|(kind, turn, value)| PathJoint {
            id: "joint".into(),
            kind,
            axis: [0.0, 0.6, 0.8],
            parent_from_joint: Isometry3::new(
                Vector3::new(0.1, 0.2, -0.1),
                Vector3::new(turn, 0.3, 0.1),
            ),
            limits: [-9.0, 9.0],
            value,
        })
    }

    fn event() -> impl Strategy<Value = PathEvent> {
        let vector = || [-1.0..1.0, -1.0..1.0, -1.0..1.0];
        let hit = (0.0..1.0, 0.1..1.0, vector(), vector());
        let hit = hit.prop_map(|(at_s, duration_s, velocity, spin)| PathEvent::Hit {
            at_s,
            duration_s,
            velocity,
            spin,
        });
        let throw = (0.0..1.0, 0.5..1.0, -1i32..2);
        let throw = throw.prop_map(|(at_s, duration_s, turns)| PathEvent::Throw {
            at_s,
            duration_s,
            turns,
            axis: [0.6, 0.0, 0.8],
        });
        prop_oneof![hit, throw]
    }

    /// Whether a velocity jumps within 0.2 ms of a time.
    fn jumps(path: &Path, t_ns: u64) -> bool {
        let period_ns = (path.period_s * 1e9).round() as u64;
        let time_s = (t_ns % period_ns) as f64 * 1e-9;
        let mut times = path.events.iter().flat_map(|event| {
            let [at_s, duration_s] = event.times_s();
            [0.0, 0.5, 1.0].map(|share| at_s + share * duration_s)
        });
        times.any(|at_s| (time_s - at_s).abs() < 2e-4)
    }

    fn path() -> impl Strategy<Value = Path> {
        let angles = (wave(), wave(), wave());
        let joints = prop::collection::vec(joint(), 0..3);
        let events = prop::collection::vec(event(), 0..3);
        (
            2.0..20.0,
            -2i32..3,
            [wave(), wave(), wave()],
            angles,
            joints,
            events,
        )
            .prop_map(
                |(period_s, turns, position, (yaw, pitch, roll), joints, events)| Path {
                    period_s,
                    turns,
                    position,
                    yaw,
                    pitch,
                    roll,
                    joints,
                    events,
                },
            )
    }

    proptest! {
        #[test]
        fn twist_is_the_derivative_of_the_pose(path in path(), t_ns in 1_000_000_000u64..60_000_000_000) {
            prop_assume!(!jumps(&path, t_ns));
            let step_ns = 100_000;
            let before = path.world_from_object(t_ns - step_ns);
            let after = path.world_from_object(t_ns + step_ns);
            let seconds = 2.0 * step_ns as f64 * 1e-9;
            let linear = (after.translation.vector - before.translation.vector) / seconds;
            let angular = (after.rotation * before.rotation.inverse()).scaled_axis() / seconds;
            let twist = path.twist(t_ns);
            prop_assert!((linear - twist.fixed_rows::<3>(0)).norm() < 1e-5);
            prop_assert!((angular - twist.fixed_rows::<3>(3)).norm() < 1e-5);
        }

        #[test]
        fn path_closes_after_its_period(path in path(), t_ns in 0u64..u64::MAX / 2) {
            let period_ns = (path.period_s * 1e9).round() as u64;
            let now = path.world_from_object(t_ns);
            let later = path.world_from_object(t_ns + period_ns);
            prop_assert_eq!(now, later);
        }
    }

    #[test]
    fn a_throw_is_a_parabola_and_a_hit_rebounds_half_way() {
        let mut path = Path::at_rest(&Isometry3::translation(1.0, 2.0, 0.5));
        let at_s = 0.1;
        let second = |s: f64| (s * 1e9_f64).round() as u64;
        path.events = vec![PathEvent::Throw {
            at_s,
            duration_s: 0.5,
            turns: 1,
            axis: [1.0, 0.0, 0.0],
        }];
        let top = path.world_from_object(second(0.35));
        assert!((top.translation.z - 0.5 - 9.81 / 8.0 * 0.25).abs() < 1e-9);
        assert!((top.rotation.angle() - std::f64::consts::PI).abs() < 1e-6);
        assert!((path.twist(second(0.1))[2] - 9.81 * 0.25).abs() < 1e-6);
        assert_eq!(path.twist(second(0.7)), Vector6::zeros());
        path.events = vec![PathEvent::Hit {
            at_s,
            duration_s: 0.4,
            velocity: [0.0, 2.0, 0.0],
            spin: [0.0, 0.0, 3.0],
        }];
        let far = path.world_from_object(second(0.3));
        assert!((far.translation.y - 2.4).abs() < 1e-9);
        assert!((far.rotation.angle() - 0.6).abs() < 1e-9);
        let (out, back) = (path.twist(second(0.29)), path.twist(second(0.31)));
        assert!((out[1] - 2.0).abs() < 1e-12 && (back[1] + 2.0).abs() < 1e-12);
        assert!((out[5] - 3.0).abs() < 1e-12 && (back[5] + 3.0).abs() < 1e-12);
    }

    #[test]
    fn path_at_rest_keeps_its_pose_and_has_no_twist() {
        let pose = Isometry3::new(Vector3::new(0.1, -0.2, 0.3), Vector3::new(0.4, 0.5, -0.6));
        let path = Path::at_rest(&pose);
        let there = path.world_from_object(123_456_789_012);
        assert!((there.translation.vector - pose.translation.vector).norm() < 1e-15);
        assert!(there.rotation.angle_to(&pose.rotation) < 1e-12);
        assert_eq!(path.twist(5), Vector6::zeros());
    }
}
