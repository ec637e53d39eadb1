//! Clock offsets as part of the state: how far the timestamps of a camera lie after the reference clock.
//!
//! An image stamped s by a camera whose clock is ahead by o shows the object at s - o, which is the pose at s moved by
//! -o times the twist: motion makes the offset observable (Furgale, Rehder, Siegwart 2013, Unified temporal and spatial
//! calibration; here linear over the few milliseconds that clocks differ).

use nalgebra::SVector;

use crate::filter::covariance::{ClockSensitivity, Cross, MOST_CLOCKS, Own, symmetric};

/// Offsets of some clocks and their correlation with the motion.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct ClockStates {
    /// Index of the camera of each slot.
    pub(crate) cameras: Vec<usize>,
    pub(crate) offset: SVector<f64, MOST_CLOCKS>,
    /// Covariance of (dt, dr, dv, dw) with the offsets.
    pub cross: Cross,
    /// Covariance of the offsets.
    pub own: Own,
    /// Ones at the places of the cameras that took part since a camera whose clock is right last did.
    pub(crate) since_right: SVector<f64, MOST_CLOCKS>,
    /// Ones at the places of the cameras of which the present update tells differences only.
    pub(crate) adrift: SVector<f64, MOST_CLOCKS>,
}

impl Default for ClockStates {
    fn default() -> Self {
        Self {
            cameras: Vec::new(),
            offset: SVector::zeros(),
            cross: Cross::zeros(),
            own: Own::zeros(),
            since_right: SVector::zeros(),
            adrift: SVector::zeros(),
        }
    }
}

impl ClockStates {
    /// Lets the offsets wander for `dt` seconds: clocks drift.
    pub fn wander(&mut self, dt: f64, wander: f64) {
        for slot in 0..self.cameras.len() {
            self.own[(slot, slot)] += wander * dt.abs();
        }
    }

    /// Notes the camera of the next update. A camera whose clock is right makes the offset of each other observable
    /// once; updates without it show only differences, since all offsets and the time of the pose may change together.
    /// A filter would believe to observe that, too, since it is linearised about one twist now and about another later
    /// (Huang, Mourikis, Roumeliotis 2010, Observability-based rules for designing consistent EKF SLAM, sec. 3).
    pub fn record(&mut self, camera_index: usize) {
        self.adrift.fill(0.0);
        match self.slot(camera_index) {
            None => self.since_right.fill(0.0),
            Some(slot) if self.since_right[slot] == 0.0 => self.since_right[slot] = 1.0,
            Some(_) => self.adrift = self.since_right,
        }
    }

    /// The mean over the cameras adrift.
    pub(crate) fn in_common(&self, of: &SVector<f64, MOST_CLOCKS>) -> f64 {
        self.adrift.dot(of) / self.adrift.sum().max(1.0)
    }

    pub fn shift(&mut self, by: &SVector<f64, MOST_CLOCKS>) {
        self.offset += by - self.adrift * self.in_common(by);
    }

    /// What changes of the offsets, column by column, are less what the cameras adrift have in common.
    pub fn differences_only(&self, by: &ClockSensitivity) -> ClockSensitivity {
        by - self.adrift * (self.adrift.tr_mul(by) / self.adrift.sum().max(1.0))
    }

    /// Reduces the covariance by an update. With the gain K less the share in common M it is P - K S Kᵀ + M K S Kᵀ Mᵀ;
    /// the covariance with the state does not change.
    pub fn update_covariance(&mut self, reduction: &Own) {
        let in_common = self.in_common(&(reduction * self.adrift)) / self.adrift.sum().max(1.0);
        let kept = self.adrift * self.adrift.transpose() * in_common;
        self.own = symmetric(&(self.own - reduction + kept));
    }

    /// The clock of a camera may have jumped, by a standard deviation of `sigma_s`.
    pub fn doubt(&mut self, camera_index: usize, sigma_s: f64) {
        if let Some(slot) = self.slot(camera_index) {
            self.own[(slot, slot)] += sigma_s.powi(2);
        }
    }

    /// Subtracts a part of an offset that is subtracted from the timestamps instead.
    pub fn take_off(&mut self, camera_index: usize, by_s: f64) {
        if let Some(slot) = self.slot(camera_index) {
            self.offset[slot] -= by_s;
        }
    }

    /// The cameras whose offsets are estimated.
    pub fn cameras(&self) -> impl Iterator<Item = usize> {
        self.cameras.iter().copied()
    }

    /// The place of a camera's offset, if it is estimated.
    pub fn slot(&self, camera_index: usize) -> Option<usize> {
        self.cameras
            .iter()
            .position(|camera| *camera == camera_index)
    }

    /// A camera's offset in seconds, by its place.
    pub fn offset_s(&self, slot: usize) -> f64 {
        self.offset[slot]
    }

    pub(crate) fn is_finite(&self) -> bool {
        let offsets = self.offset.iter();
        offsets
            .chain(self.cross.iter())
            .chain(self.own.iter())
            .all(|x| x.is_finite())
    }
}
