//! Clock offsets as part of the state: how far a camera's capture times lie from the reference clock.
//!
//! An image stamped s by a camera whose clock is ahead by o shows the object as it was at s - o. The state at s sees it as
//! the pose moved by -o times the twist, so that motion tells the offset (Furgale, Rehder, Siegwart 2013, Unified temporal
//! and spatial calibration; here linear over the few milliseconds that clocks differ).

use nalgebra::{Cholesky, SVector};

use crate::filter::covariance::{ClockSensitivity, Cross, MOST_CLOCKS, Own, symmetric};

/// The offsets of some cameras, and how they hang together with the motion.
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

/// Whether clocks agree.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Synchrony {
    /// Logarithm of the odds for it.
    pub odds: f64,
    /// The largest sigma of an offset, in seconds, but for what is wrong for good.
    pub sigma_s: f64,
}

impl ClockStates {
    /// Lets the offsets wander for `dt` seconds: clocks drift.
    pub fn wander(&mut self, dt: f64, wander: f64) {
        for slot in 0..self.cameras.len() {
            self.own[(slot, slot)] += wander * dt.abs();
        }
    }

    /// A camera is about to take part. A camera whose clock is right tells the offset of each other once; what follows without
    /// it tells differences, for all offsets and the time of the pose might change together. A filter would believe to learn
    /// that, too, since it is linear about one twist now and about another later (Huang, Mourikis, Roumeliotis 2010,
    /// Observability-based rules for designing consistent EKF SLAM, sec. 3).
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

    /// Takes off the covariance what an update tells. With the gain K less the share in common M the covariance is
    /// P - K S Kᵀ + M K S Kᵀ Mᵀ; that with the state is the same as ever.
    pub fn update_covariance(&mut self, told: &Own) {
        let in_common = self.in_common(&(told * self.adrift)) / self.adrift.sum().max(1.0);
        let kept = self.adrift * self.adrift.transpose() * in_common;
        self.own = symmetric(&(self.own - told + kept));
    }

    /// A camera's clock may have jumped, by so many seconds (one sigma).
    pub fn doubt(&mut self, camera_index: usize, sigma_s: f64) {
        if let Some(slot) = self.slot(camera_index) {
            self.own[(slot, slot)] += sigma_s.powi(2);
        }
    }

    /// So many seconds of a camera's offset are taken off its stamps instead.
    pub fn take_off(&mut self, camera_index: usize, by_s: f64) {
        if let Some(slot) = self.slot(camera_index) {
            self.offset[slot] -= by_s;
        }
    }

    /// The cameras whose offsets are estimated.
    pub fn cameras(&self) -> impl Iterator<Item = usize> {
        self.cameras.iter().copied()
    }

    /// Logarithm of the odds for offsets of zero against offsets of `prior_s` (one sigma each), and the largest sigma; of the
    /// cameras given. `all` is the covariance of all offsets. By what the estimate says of zero against what was
    /// said of it before (Savage-Dickey ratio; Dickey 1971, The weighted likelihood ratio, sec. 2). `None` without such a camera.
    pub(crate) fn agreement(&self, all: &Own, prior_s: f64, among: &[usize]) -> Option<Synchrony> {
        let (mut own, mut offset) = (Own::identity(), SVector::<f64, MOST_CLOCKS>::zeros());
        let slots: Vec<usize> = among
            .iter()
            .filter_map(|camera| self.slot(*camera))
            .collect();
        let mut sigma_s: f64 = 0.0;
        for (row, of_row) in slots.iter().enumerate() {
            offset[row] = self.offset[*of_row] / prior_s;
            sigma_s = sigma_s.max(self.own[(*of_row, *of_row)].max(0.0).sqrt());
            for (column, of_column) in slots.iter().enumerate() {
                own[(row, column)] = all[(*of_row, *of_column)] / prior_s.powi(2);
            }
        }
        let factor = Cholesky::new(own).filter(|_| !slots.is_empty())?;
        let half_determinant: f64 = factor.l_dirty().diagonal().iter().map(|x| x.ln()).sum();
        let odds = -0.5 * offset.dot(&factor.solve(&offset)) - half_determinant;
        Some(Synchrony { odds, sigma_s })
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
