//! The error of a pose, and statistics of many.

use nalgebra::{Matrix6, Vector6};
use serde::Serialize;
use sextant_geometry::{Pose, se3};

/// 95 % quantile of the chi-square distribution with six degrees of freedom.
pub const CHI_SQUARE_6_95: f64 = 12.592;

/// The step from a true pose to its estimate: position in m, attitude in rad, world axes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PoseError(Vector6<f64>);

impl PoseError {
    /// Error of an estimate.
    pub fn between(estimate: &Pose, truth: &Pose) -> Self {
        Self(se3::difference(estimate, truth))
    }

    /// Distance of the origins, m.
    pub fn position_m(&self) -> f64 {
        self.0.fixed_rows::<3>(0).norm()
    }

    /// Angle of the rotation between the attitudes, rad.
    pub fn attitude_rad(&self) -> f64 {
        self.0.fixed_rows::<3>(3).norm()
    }

    /// Normalised estimation error squared, `e^T P^-1 e`; none where the covariance is not positive definite.
    pub fn nees(&self, covariance: &Matrix6<f64>) -> Option<f64> {
        let root = covariance.cholesky()?;
        let nees = self.0.dot(&root.solve(&self.0));
        nees.is_finite().then_some(nees)
    }
}

/// Consistency of covariances with the errors of their poses.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Consistency {
    poses: usize,
    nees: f64,
    within_95: usize,
}

impl Consistency {
    /// Adds the NEES of a pose.
    pub fn add(&mut self, nees: f64) {
        self.poses += 1;
        self.nees += nees;
        self.within_95 += usize::from(nees <= CHI_SQUARE_6_95);
    }

    /// Adds the poses of another.
    pub fn join(&mut self, other: &Self) {
        self.poses += other.poses;
        self.nees += other.nees;
        self.within_95 += other.within_95;
    }

    /// Mean NEES: 6 where covariances are right, more where they are too small; 0 without a pose.
    pub fn mean_nees(&self) -> f64 {
        self.nees / self.poses.max(1) as f64
    }

    /// Share of poses within the 95 % region of their covariance; 0 without a pose.
    pub fn within_95(&self) -> f64 {
        self.within_95 as f64 / self.poses.max(1) as f64
    }
}

/// Statistics of an amount.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Spread {
    /// Root mean square.
    pub rms: f64,
    /// Half of all are below.
    pub median: f64,
    /// 95 % are below.
    pub p95: f64,
    /// The largest.
    pub max: f64,
}

impl Spread {
    /// Statistics of these values; none without any.
    pub fn from_values(values: impl Iterator<Item = f64>) -> Option<Self> {
        let mut sorted: Vec<f64> = values.collect();
        sorted.sort_by(f64::total_cmp);
        let max = *sorted.last()?;
        let squares: f64 = sorted.iter().map(|value| value * value).sum();
        let quantile = |share: f64| sorted[((sorted.len() - 1) as f64 * share).round() as usize];
        Some(Self {
            rms: (squares / sorted.len() as f64).sqrt(),
            median: quantile(0.5),
            p95: quantile(0.95),
            max,
        })
    }
}
