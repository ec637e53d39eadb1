//! What a view's corners say of the pose of its link: a robust quadratic model.

use nalgebra::{Matrix6, Vector6};

use crate::measurement::edge_modes::{PoseRows, Rows};
use crate::measurement::rolling_shutter::TwistEquations;

const RESIDUAL: usize = 6;

/// Who states the noise of a view's corners.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum NoiseSource {
    Detector,
    /// It is the usual one.
    Nobody,
}

/// Degrees of freedom of the scale of a noise that a detector states.
const STATED: f64 = 12.0;
/// The covariance of a fit to such views by Fisher's information (Lange, Little, Taylor 1989, eq. 10), against the inverse of the
/// cost's curvature: at a fit weights are larger than they should be on average, as the residuals of few corners are small there.
pub(crate) const OF_FISHER: f64 = (STATED + 10.0) / (STATED + 8.0);

impl NoiseSource {
    /// Degrees of freedom of the noise's scale from view to view. What blur, light and contrast do to it a detector knows but
    /// for a rest; where nobody states anything, it is a factor of three.
    fn freedom(self) -> f64 {
        match self {
            Self::Detector => STATED,
            Self::Nobody => 5.0,
        }
    }

    /// The weight of a view by its squared whitened residuals.
    pub fn weight(self, square: f64) -> f64 {
        let freedom = self.freedom();
        (freedom + 8.0) / (freedom + square)
    }

    /// Twice the cost of a view, by the same.
    pub fn chi2(self, square: f64) -> f64 {
        let freedom = self.freedom();
        (freedom + 8.0) * (1.0 + square / freedom).ln()
    }

    /// Where the scale is all but unknown, Fisher's information is that much smaller from the beginning; what a detector states is
    /// compared as it is meant, and [`OF_FISHER`] counts when poses are told.
    fn certain(self) -> f64 {
        let freedom = self.freedom();
        match self {
            Self::Detector => 1.0,
            Self::Nobody => (freedom + 8.0) / (freedom + 10.0),
        }
    }
}

/// The quadratic model of the robust cost of some views about a pose.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct ViewEquations {
    /// J^T W J over (dt, dr).
    pub information: Matrix6<f64>,
    /// The part of it that the directions of the edges give.
    pub of_turns: Matrix6<f64>,
    /// J^T W r.
    pub gradient: Vector6<f64>,
    /// Twice the robust cost: chi-square where nothing is an outlier.
    pub chi2: f64,
    /// The part of the twist, where the shutter rolls.
    pub rolling: Option<Box<TwistEquations>>,
    /// Sum of squared residuals in px², no weight.
    pub square_px: f64,
    /// The squared whitened residuals, no weight.
    square: f64,
    /// Sums of squared whitened residuals of the edges' places and directions, each view's by its weight.
    pub scale: [f64; 2],
}

impl ViewEquations {
    /// Of whitened rows, first those of the edges' places, then of their directions.
    ///
    /// Where the noise differs from view to view: with a variance of inverse gamma distribution about the usual one the
    /// residuals of a view are distributed as Student's t (Lange, Little, Taylor 1989, eq. 2), and a view off by much counts
    /// little.
    #[inline(always)]
    pub(crate) fn of(rows: &PoseRows, by_twist: Option<&Rows<6>>, source: NoiseSource) -> Self {
        let [shifts, turns] = [products(rows, 0), products(rows, 4)];
        let scale = [shifts[RESIDUAL][RESIDUAL], turns[RESIDUAL][RESIDUAL]];
        let plain = scale[0] + scale[1];
        let weight = source.weight(plain);
        let certain = weight * source.certain();
        let mut normal = Self {
            information: Matrix6::zeros(),
            of_turns: Matrix6::zeros(),
            gradient: Vector6::zeros(),
            chi2: source.chi2(plain),
            rolling: by_twist.map(|by_twist| {
                Box::new(TwistEquations::of(rows, by_twist).weighed(weight, source.certain()))
            }),
            square_px: 0.0,
            square: plain,
            scale: scale.map(|scale| scale * weight),
        };
        for column in 0..6 {
            for row in 0..6 {
                let turns = turns[column][row] * certain;
                normal.of_turns[(row, column)] = turns;
                normal.information[(row, column)] = shifts[column][row] * certain + turns;
            }
            normal.gradient[column] = (shifts[column][RESIDUAL] + turns[column][RESIDUAL]) * weight;
        }
        normal
    }

    /// Sum of squared whitened residuals, no weight.
    pub fn square(&self) -> f64 {
        self.square
    }

    /// The view's weight.
    pub fn weight(&self) -> f64 {
        self.scale.iter().sum::<f64>() / self.square.max(f64::MIN_POSITIVE)
    }

    /// The weight that the view will have after a small step of its pose and its twist, against its weight here: as far as
    /// residuals are linear.
    pub(crate) fn weight_after(
        &self,
        step: &Vector6<f64>,
        of_twist: Option<Vector6<f64>>,
        source: NoiseSource,
    ) -> f64 {
        let weight = source.weight(self.square);
        let of_information = weight * source.certain();
        let mut slope = self.gradient.dot(step);
        let mut bend = step.dot(&(self.information * step));
        if let Some((rolling, turn)) = self.rolling.as_ref().zip(of_twist) {
            slope += rolling.gradient.dot(&turn);
            bend += 2.0 * step.dot(&(rolling.with_pose * turn));
            bend += turn.dot(&(rolling.information * turn));
        }
        let square = self.square + 2.0 * slope / weight + bend / of_information;
        source.weight(square.max(0.0)) / weight
    }
}

/// Sums over four rows, from the first one given, of the products of any two columns.
#[inline(always)]
fn products(rows: &PoseRows, first: usize) -> [[f64; 8]; 7] {
    let mut sums = [[0.0; 8]; 7];
    for column in 0..7 {
        let mut sum = [0.0; 8];
        for row in &rows[first..first + 4] {
            (0..8).for_each(|other| sum[other] += row[column] * row[other]);
        }
        sums[column] = sum;
    }
    sums
}

/// Squared Mahalanobis length beyond which a corner loses weight: 98.9 % of the corners of a Gaussian lie within.
pub(crate) const ROBUST_LIMIT: f64 = 9.0;

/// Weight and twice the cost of a corner at the squared Mahalanobis length `d2`: quadratic within the limit, logarithmic
/// beyond (Gaussian core with Cauchy tails), so that one wrong corner pulls ever less.
pub(crate) fn robust(d2: f64) -> (f64, f64) {
    if d2 <= ROBUST_LIMIT {
        (1.0, d2)
    } else {
        (
            ROBUST_LIMIT / d2,
            ROBUST_LIMIT * (1.0 + (d2 / ROBUST_LIMIT).ln()),
        )
    }
}
