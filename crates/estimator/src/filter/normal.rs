//! What a view's corners say of the pose of its link: a robust quadratic model.

use nalgebra::{Matrix6, Vector6};

use super::edges::Vector8;
use super::shutter::{Matrix8x6, Rolling};

/// Who states the noise of a view's corners.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum NoiseSource {
    Detector,
    /// It is the usual one.
    Nobody,
}

impl NoiseSource {
    /// Degrees of freedom of the noise's scale from view to view. What blur, light and contrast do to it a detector knows but
    /// for a rest; where nobody states anything, it is a factor of three.
    fn freedom(self) -> f64 {
        match self {
            Self::Detector => 12.0,
            Self::Nobody => 5.0,
        }
    }
}

/// The quadratic model of the robust cost of some views about a pose.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Normal {
    /// J^T W J over (dt, dr).
    pub information: Matrix6<f64>,
    /// The part of it that the directions of the edges give.
    pub of_turns: Matrix6<f64>,
    /// J^T W r.
    pub gradient: Vector6<f64>,
    /// Twice the robust cost: chi-square where nothing is an outlier.
    pub chi2: f64,
    /// The part of the twist, where the shutter rolls.
    pub rolling: Option<Box<Rolling>>,
    /// Sum of squared residuals in px², no weight.
    pub square_px: f64,
    /// Sums of squared whitened residuals of the edges' places and directions, each view's by its weight.
    pub scale: [f64; 2],
}

impl Normal {
    /// Of whitened residuals, first those of the edges' places, then of their directions.
    #[inline]
    pub(super) fn of(
        residuals: &Vector8,
        jacobian: &Matrix8x6,
        by_twist: Option<&Matrix8x6>,
    ) -> Self {
        let (shifts, turns) = (jacobian.fixed_rows::<4>(0), jacobian.fixed_rows::<4>(4));
        let of_turns = turns.transpose() * turns;
        let square = |first: usize| residuals.fixed_rows::<4>(first).norm_squared();
        Self {
            information: shifts.transpose() * shifts + of_turns,
            of_turns,
            gradient: jacobian.transpose() * residuals,
            chi2: residuals.norm_squared(),
            rolling: by_twist.map(|by_twist| Box::new(Rolling::of(residuals, jacobian, by_twist))),
            square_px: 0.0,
            scale: [square(0), square(4)],
        }
    }

    /// Where the noise differs from view to view: with a variance of inverse gamma distribution about the usual one the
    /// residuals of a view are distributed as Student's t (Lange, Little, Taylor 1989, eq. 2), and a view off by much counts
    /// little.
    #[inline]
    pub(super) fn of_unknown_scale(mut self, source: NoiseSource) -> Self {
        let freedom = source.freedom();
        let weight = (freedom + 8.0) / (freedom + self.chi2);
        // Where the scale is all but unknown, Fisher's information on the place is smaller by this (ibid., eq. 10); a
        // detector's is meant as it is stated, and the weights only guard against its tails.
        let certain = match source {
            NoiseSource::Detector => 1.0,
            NoiseSource::Nobody => (freedom + 8.0) / (freedom + 10.0),
        };
        self.information *= weight * certain;
        self.of_turns *= weight * certain;
        self.gradient *= weight;
        if let Some(rolling) = &mut self.rolling {
            **rolling = rolling.weighed(weight, certain);
        }
        self.chi2 = (freedom + 8.0) * (1.0 + self.chi2 / freedom).ln();
        self.scale = self.scale.map(|scale| scale * weight);
        self
    }
}

/// Squared Mahalanobis length beyond which a corner loses weight: 98.9 % of the corners of a Gaussian lie within.
pub(crate) const ROBUST_LIMIT: f64 = 9.0;

/// Weight and twice the cost of a corner at the squared Mahalanobis length `d2`: quadratic within the limit, logarithmic
/// beyond (Gaussian core with Cauchy tails), so that one wrong corner pulls ever less.
pub(super) fn robust(d2: f64) -> (f64, f64) {
    if d2 <= ROBUST_LIMIT {
        (1.0, d2)
    } else {
        (
            ROBUST_LIMIT / d2,
            ROBUST_LIMIT * (1.0 + (d2 / ROBUST_LIMIT).ln()),
        )
    }
}
