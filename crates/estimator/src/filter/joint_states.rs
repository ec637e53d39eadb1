//! Joints as part of the state: value and speed of each, correlated with the motion and the clocks.
//!
//! Prediction with constant speed and white acceleration, as for the base. The variance of a value is at most that of a
//! uniform distribution between its limits (over the circle, where a hinge has none), so that a joint without views
//! does not wander off.

use std::sync::Arc;

use crate::FusionOptions;
use crate::filter::covariance::{JointClocks, JointCross, JointOwn, WIDTH, symmetric};
use crate::filter::process_noise::{PsdEstimate, ScalarInnovation};
use crate::kinematics::chain::KinematicChain;
use crate::kinematics::configuration::{Configuration, Values};
use sextant_site_model::{Joint, JointKind, MOST_JOINTS};

/// Metres, one sigma: nothing is known about a slide without limits.
const ANYWHERE: f64 = 3.0;

/// The joints of an object that move.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct JointStates {
    pub chain: Arc<KinematicChain>,
    /// Index of the link whose pose and twist the state has.
    pub root: usize,
    /// Number of joints that move.
    pub moving: usize,
    pub values: Values,
    pub speeds: Values,
    /// Covariance of (dt, dr, dv, dw) with values and speeds.
    pub cross: JointCross,
    /// Covariance of values and speeds.
    pub own: JointOwn,
    /// Covariance of values and speeds with the clocks' offsets.
    pub with_clocks: JointClocks,
    /// Power density of each joint's white acceleration to begin with, rad²/s³ or m²/s³.
    pub(crate) process_noise_psd: Values,
    pub(crate) learned: [PsdEstimate; MOST_JOINTS],
    /// One sigma of values and speeds of which nothing is known.
    pub(crate) unknown: [f64; WIDTH],
}

impl JointStates {
    /// Joints of which only the start for the search is known.
    pub fn unknown(
        chain: &Arc<KinematicChain>,
        seed: &Configuration,
        options: &FusionOptions,
    ) -> Self {
        let mut joints = Self {
            chain: chain.clone(),
            root: seed.root,
            moving: chain.moving().count(),
            values: seed.joints,
            speeds: Values::zeros(),
            cross: JointCross::zeros(),
            own: JointOwn::zeros(),
            with_clocks: JointClocks::zeros(),
            process_noise_psd: Values::zeros(),
            learned: [PsdEstimate::default(); MOST_JOINTS],
            unknown: [0.0; WIDTH],
        };
        for (slot, joint) in chain.moving().enumerate() {
            let (density, speed) = match joint.kind {
                JointKind::Prismatic => (options.linear_acceleration_psd, options.start_speed),
                _ => (
                    options.angular_acceleration_psd,
                    options.start_angular_speed,
                ),
            };
            joints.process_noise_psd[slot] = density;
            joints.unknown[slot] = unknown_value(joint);
            joints.unknown[MOST_JOINTS + slot] = speed.min(joint.max_speed.unwrap_or(speed));
        }
        for place in 0..WIDTH {
            joints.own[(place, place)] = joints.unknown[place].powi(2);
        }
        joints
    }

    /// One sigma of a value.
    pub fn sigma(&self, slot: usize) -> f64 {
        self.own[(slot, slot)].max(0.0).sqrt()
    }

    /// Updates the noise of a joint by an innovation of its value, as [`PsdEstimate::learn_one`]; `spread` is
    /// [`crate::filter::process_noise::ProcessNoise::spread`].
    pub fn learn(&mut self, slot: usize, innovation: ScalarInnovation, spread: f64) {
        let noise = self.density(slot) * spread;
        self.learned[slot].learn_one(innovation, noise);
    }

    pub(crate) fn density(&self, slot: usize) -> f64 {
        self.process_noise_psd[slot] * self.learned[slot].factor()
    }

    /// Values and speeds shifted by a step.
    pub fn shift(&mut self, step: &nalgebra::SVector<f64, WIDTH>) {
        self.values += step.fixed_rows::<MOST_JOINTS>(0);
        self.speeds += step.fixed_rows::<MOST_JOINTS>(MOST_JOINTS);
    }

    /// F = [I dt; 0 I] on the values, and the white acceleration, whose densities are the usual ones times
    /// `persistence`; the motion's part of `cross` is carried before.
    pub fn advance(&mut self, dt: f64, persistence: f64) {
        self.values += self.speeds * dt;
        let ahead = |matrix: &mut JointOwn| {
            let rows = matrix.fixed_rows::<MOST_JOINTS>(MOST_JOINTS) * dt;
            let mut values = matrix.fixed_rows_mut::<MOST_JOINTS>(0);
            values += rows;
        };
        ahead(&mut self.own);
        self.own.transpose_mut();
        ahead(&mut self.own);
        let columns = self.cross.fixed_columns::<MOST_JOINTS>(MOST_JOINTS) * dt;
        let mut values = self.cross.fixed_columns_mut::<MOST_JOINTS>(0);
        values += columns;
        let rows = self.with_clocks.fixed_rows::<MOST_JOINTS>(MOST_JOINTS) * dt;
        let mut values = self.with_clocks.fixed_rows_mut::<MOST_JOINTS>(0);
        values += rows;
        self.own = symmetric(&(self.own + self.white_acceleration(dt, persistence)));
        self.bound();
    }

    /// What the joints may have done of themselves in `dt` seconds, over values and speeds.
    pub fn white_acceleration(&self, dt: f64, persistence: f64) -> JointOwn {
        let dt = dt.abs();
        let mut noise = JointOwn::zeros();
        for slot in 0..self.moving {
            let density = self.density(slot) * persistence;
            let speed = MOST_JOINTS + slot;
            noise[(slot, slot)] = density * dt.powi(3) / 3.0;
            noise[(slot, speed)] = density * dt.powi(2) / 2.0;
            noise[(speed, slot)] = noise[(slot, speed)];
            noise[(speed, speed)] = density * dt;
        }
        noise
    }

    /// Against all expectation: a blow between two images `dt` seconds apart, that counts as if it had lasted for
    /// `acting_s`.
    pub fn jolt(&mut self, dt: f64, acting_s: f64, options: &FusionOptions) {
        for slot in 0..self.moving {
            let acceleration = match self.chain.moving().nth(slot).map(|joint| joint.kind) {
                Some(JointKind::Prismatic) => options.linear_jolt,
                _ => options.angular_jolt,
            };
            let rate = acceleration * acting_s;
            let way = 0.5 * rate * dt;
            let speed = MOST_JOINTS + slot;
            self.own[(slot, slot)] += way * way;
            self.own[(slot, speed)] += way * rate;
            self.own[(speed, slot)] += way * rate;
            // As for the base: definite.
            self.own[(speed, speed)] += rate * rate * 1.1;
        }
    }

    /// Brings values and speeds within the limits of the joints. For what is published: the filter would count the
    /// limits anew with each image.
    pub fn keep_within_limits(&mut self) {
        for (slot, joint) in self.chain.moving().enumerate() {
            if let Some([lowest, highest]) = joint.limits {
                self.values[slot] = self.values[slot].clamp(lowest, highest);
            }
            if let Some(speed) = joint.max_speed {
                self.speeds[slot] = self.speeds[slot].clamp(-speed, speed);
            }
        }
    }

    /// Bounds the variances by those of unknown values.
    pub(crate) fn bound(&mut self) {
        for place in 0..WIDTH {
            let sigma = self.own[(place, place)].max(0.0).sqrt();
            if sigma <= self.unknown[place] {
                continue;
            }
            let share = self.unknown[place] / sigma;
            self.own.row_mut(place).scale_mut(share);
            self.own.column_mut(place).scale_mut(share);
            self.cross.column_mut(place).scale_mut(share);
            self.with_clocks.row_mut(place).scale_mut(share);
            let limits = self
                .chain
                .moving()
                .nth(place)
                .and_then(|joint| joint.limits);
            if let Some([lowest, highest]) = limits {
                self.values[place] = self.values[place].clamp(lowest, highest);
            }
        }
    }

    /// Whether every number of it is finite.
    pub fn is_finite(&self) -> bool {
        let numbers = self.values.iter().chain(self.speeds.iter());
        let numbers = numbers.chain(self.cross.iter()).chain(self.own.iter());
        numbers
            .chain(self.with_clocks.iter())
            .all(|number| number.is_finite())
    }
}

/// One sigma of a value that lies anywhere.
fn unknown_value(joint: &Joint) -> f64 {
    let range = match (joint.limits, joint.kind) {
        (Some([lowest, highest]), _) => highest - lowest,
        (None, JointKind::Prismatic) => return ANYWHERE,
        (None, _) => std::f64::consts::TAU,
    };
    range / 12f64.sqrt()
}
