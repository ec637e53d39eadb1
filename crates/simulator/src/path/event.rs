//! What happens to an object on its way: hits and throws, whose velocity changes at once.
//!
//! An event lasts from `at_s` to `at_s + duration_s` of each period and leaves the object where it would be without. It
//! moves the origin by an offset and turns the object about it, both in world axes, on top of the path's smooth motion.

use super::about_axis;
use nalgebra::{UnitQuaternion, Vector3};
use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;

/// Gravity, m/s^2.
const GRAVITY: f64 = 9.81;

/// A motion with sudden changes of velocity.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "kebab-case", deny_unknown_fields)]
pub enum PathEvent {
    /// It is struck, flies off, rebounds half way and stops where it would have been: three jumps of velocity.
    Hit {
        /// When in the period, s.
        at_s: f64,
        /// From the hit to the stop, s.
        duration_s: f64,
        /// Jump of velocity, world axes, m/s.
        velocity: [f64; 3],
        /// Jump of angular velocity, world axes, rad/s.
        #[serde(default)]
        spin: [f64; 3],
    },
    /// It is thrown up and caught: a parabola of 9.81 m/s^2.
    Throw {
        /// When in the period, s.
        at_s: f64,
        /// Time in the air, s: half a second reaches 0.31 m.
        duration_s: f64,
        /// Whole turns in the air about `axis`.
        #[serde(default)]
        turns: i32,
        /// Unit vector in world axes.
        #[serde(default = "upwards")]
        axis: [f64; 3],
    },
}

fn upwards() -> [f64; 3] {
    [0.0, 0.0, 1.0]
}

/// What an event adds at an instant.
pub(super) struct Addition {
    pub offset: Vector3<f64>,
    pub velocity: Vector3<f64>,
    /// Applied to the attitude from the left.
    pub rotation: UnitQuaternion<f64>,
    pub angular_velocity: Vector3<f64>,
}

impl PathEvent {
    /// Begin and duration, s.
    pub(crate) fn times_s(&self) -> [f64; 2] {
        match *self {
            Self::Hit {
                at_s, duration_s, ..
            }
            | Self::Throw {
                at_s, duration_s, ..
            } => [at_s, duration_s],
        }
    }

    /// What it adds at a time of the period, while it lasts.
    pub(super) fn at(&self, time_s: f64) -> Option<Addition> {
        let [at_s, duration_s] = self.times_s();
        let after_s = time_s - at_s;
        if !(0.0..duration_s).contains(&after_s) {
            return None;
        }
        Some(match self {
            Self::Hit { velocity, spin, .. } => {
                let (way_s, sense) = if after_s < duration_s / 2.0 {
                    (after_s, 1.0)
                } else {
                    (duration_s - after_s, -1.0)
                };
                let (velocity, spin) = (Vector3::from(*velocity), Vector3::from(*spin));
                Addition {
                    offset: velocity * way_s,
                    velocity: velocity * sense,
                    rotation: about_vector(&(spin * way_s)),
                    angular_velocity: spin * sense,
                }
            }
            Self::Throw { turns, axis, .. } => {
                let rate = f64::from(*turns) * TAU / duration_s;
                let axis = Vector3::from(*axis);
                let height = 0.5 * GRAVITY * after_s * (duration_s - after_s);
                let rise = 0.5 * GRAVITY * (duration_s - 2.0 * after_s);
                Addition {
                    offset: Vector3::z() * height,
                    velocity: Vector3::z() * rise,
                    rotation: about_axis(&axis, rate * after_s),
                    angular_velocity: axis * rate,
                }
            }
        })
    }

    /// All numbers of it, for validation.
    pub(super) fn numbers(&self) -> impl Iterator<Item = f64> + '_ {
        let (a, b) = match self {
            Self::Hit { velocity, spin, .. } => (*velocity, *spin),
            Self::Throw { turns, axis, .. } => (*axis, [f64::from(*turns); 3]),
        };
        self.times_s().into_iter().chain(a).chain(b)
    }
}

fn about_vector(rotation: &Vector3<f64>) -> UnitQuaternion<f64> {
    let angle = rotation.norm();
    if angle == 0.0 {
        return UnitQuaternion::identity();
    }
    about_axis(&(rotation / angle), angle)
}
