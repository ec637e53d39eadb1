//! Clock offsets as part of the state: how far a camera's capture times lie from the reference clock.
//!
//! An image stamped s by a camera whose clock is ahead by o shows the object as it was at s - o. The state at s sees it as
//! the pose moved by -o times the twist, so that motion tells the offset (Furgale, Rehder, Siegwart 2013, Unified temporal
//! and spatial calibration; here linear over the few milliseconds that clocks differ).

use nalgebra::{Matrix6, SMatrix, SVector};
use sextant_geometry::{Pose, se3};

use crate::ClockOffset;

use super::kinematics::{Covariance, Kinematics, symmetric, white_acceleration};

/// Most offsets estimated along with one object; further cameras are taken at their word.
pub(crate) const MOST_CLOCKS: usize = 8;

pub(crate) type Cross = SMatrix<f64, 12, MOST_CLOCKS>;
pub(crate) type Own = SMatrix<f64, MOST_CLOCKS, MOST_CLOCKS>;

/// The offsets of some cameras, and how they hang together with the motion.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Clocks {
    /// Index of the camera of each slot.
    cameras: Vec<usize>,
    offset: SVector<f64, MOST_CLOCKS>,
    /// Covariance of (dt, dr, dv, dw) with the offsets.
    pub cross: Cross,
    /// Covariance of the offsets.
    pub own: Own,
}

impl Default for Clocks {
    fn default() -> Self {
        Self {
            cameras: Vec::new(),
            offset: SVector::zeros(),
            cross: Cross::zeros(),
            own: Own::zeros(),
        }
    }
}

/// The pose that a camera sees, as a linear function of the state.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Observed {
    /// World from object when the image was taken.
    pub pose: Pose,
    pub covariance: Matrix6<f64>,
    /// Covariance of the seen pose with (dt, dr, dv, dw).
    pub with_motion: SMatrix<f64, 6, 12>,
    /// Covariance of the seen pose with the offsets.
    pub with_clocks: SMatrix<f64, 6, MOST_CLOCKS>,
}

impl Clocks {
    /// Lets the offsets wander for `dt` seconds: clocks drift.
    pub fn wander(&mut self, dt: f64, wander: f64) {
        for slot in 0..self.cameras.len() {
            self.own[(slot, slot)] += wander * dt.abs();
        }
    }

    pub fn shift(&mut self, by: &SVector<f64, MOST_CLOCKS>) {
        self.offset += by;
    }

    /// Offset and its sigma of each camera, in seconds.
    pub fn offsets(&self) -> impl Iterator<Item = (usize, ClockOffset)> {
        let one = |slot: usize| ClockOffset {
            offset_s: self.offset[slot],
            sigma_s: self.own[(slot, slot)].max(0.0).sqrt(),
        };
        self.cameras
            .iter()
            .enumerate()
            .map(move |(slot, camera)| (*camera, one(slot)))
    }

    fn slot(&self, camera_index: usize) -> Option<usize> {
        self.cameras
            .iter()
            .position(|camera| *camera == camera_index)
    }

    fn is_finite(&self) -> bool {
        let offsets = self.offset.iter();
        offsets
            .chain(self.cross.iter())
            .chain(self.own.iter())
            .all(|x| x.is_finite())
    }
}

impl Kinematics {
    /// Makes the camera's offset a part of the state, if there is room and it is not one already.
    pub fn know_clock(&mut self, camera_index: usize, prior: ClockOffset) {
        let clocks = self.clocks.get_or_insert_default();
        let slot = clocks.cameras.len();
        if clocks.slot(camera_index).is_none() && slot < MOST_CLOCKS {
            clocks.cameras.push(camera_index);
            clocks.offset[slot] = prior.offset_s;
            clocks.own[(slot, slot)] = prior.sigma_s.powi(2);
        }
    }

    /// The pose as the camera saw it; its clock is right unless it is part of the state.
    pub fn observed(&self, camera_index: usize) -> Observed {
        let clocked = self.clocks.as_deref();
        let slot = clocked.and_then(|clocks| Some((clocks, clocks.slot(camera_index)?)));
        match slot {
            Some((clocks, slot)) => self.observed_at_offset(clocks, slot),
            None => self.observed_now(clocked),
        }
    }

    fn observed_now(&self, clocks: Option<&Clocks>) -> Observed {
        let with_clocks = clocks.map(|clocks| clocks.cross.fixed_rows::<6>(0).into_owned());
        Observed {
            pose: self.pose,
            covariance: self.covariance.fixed_view::<6, 6>(0, 0).into_owned(),
            with_motion: self.covariance.fixed_rows::<6>(0).into_owned(),
            with_clocks: with_clocks.unwrap_or_default(),
        }
    }

    /// With the offset o and the twist x the camera sees pose - o x: the state times B = [I, -o I, -x].
    ///
    /// Besides B P Bᵀ the seen pose is uncertain by the product of the errors of offset and twist, and by what the body may
    /// have done between.
    fn observed_at_offset(&self, clocks: &Clocks, slot: usize) -> Observed {
        let (offset, twist) = (clocks.offset[slot], self.twist);
        let motion = |rows: &Covariance| rows.fixed_rows::<6>(0) - rows.fixed_rows::<6>(6) * offset;
        let with_motion = motion(&self.covariance) - twist * clocks.cross.column(slot).transpose();
        let cross = clocks.cross.fixed_rows::<6>(0) - clocks.cross.fixed_rows::<6>(6) * offset;
        let with_clocks = cross - twist * clocks.own.row(slot);
        let linear = with_motion.fixed_columns::<6>(0)
            - with_motion.fixed_columns::<6>(6) * offset
            - with_clocks.column(slot) * twist.transpose();
        let product = self.covariance.fixed_view::<6, 6>(6, 6) * clocks.own[(slot, slot)];
        let between = white_acceleration(offset, self.motion.restlessness());
        Observed {
            pose: se3::perturb(&self.pose, &(-offset * twist)),
            covariance: symmetric(&(linear + product + between.fixed_view::<6, 6>(0, 0))),
            with_motion,
            with_clocks,
        }
    }

    /// Whether every number of the offsets is finite.
    pub(super) fn clocks_are_finite(&self) -> bool {
        self.clocks.as_ref().is_none_or(|clocks| clocks.is_finite())
    }
}
