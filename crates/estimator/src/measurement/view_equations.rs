//! Normal equations of a view about the pose of its link: a robust quadratic model.

use nalgebra::{Matrix6, Vector6};

use crate::measurement::rolling_shutter::TwistEquations;
use crate::measurement::whitening::{PoseRows, Rows};

const RESIDUAL: usize = 6;

/// Source of the noise of the corners of a view.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum NoiseSource {
    Detector,
    /// It is the usual one.
    Nobody,
}

/// Degrees of freedom of the scale of a reported noise.
const STATED: f64 = 12.0;
/// The covariance of a fit to such views by Fisher's information (Lange, Little, Taylor 1989, eq. 10), against the
/// inverse of the cost's curvature: at a fit weights are larger than they should be on average, as the residuals of few
/// corners are small there.
pub(crate) const OF_FISHER: f64 = (STATED + 10.0) / (STATED + 8.0);

impl NoiseSource {
    /// Degrees of freedom of the scale of the noise from view to view. A detector knows the effects of blur, light and
    /// contrast but for a rest; without a reported noise the scale varies by a factor of three.
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

    /// Factor on the information for an unknown scale. Fisher's information is smaller from the beginning where no
    /// noise is reported; where it is, [`OF_FISHER`] accounts for it when covariances are published.
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
    /// Sum of the squared whitened residuals by the view's weight.
    pub weighted_square: f64,
}

impl ViewEquations {
    /// The equations of whitened rows.
    ///
    /// Where the noise differs from view to view: with a variance of inverse gamma distribution about the usual one the
    /// residuals of a view are distributed as Student's t (Lange, Little, Taylor 1989, eq. 2), and a view off by much
    /// counts little.
    #[inline(always)]
    pub(crate) fn from_rows(
        rows: &PoseRows,
        by_twist: Option<&Rows<6>>,
        source: NoiseSource,
    ) -> Self {
        let products = products(rows);
        let plain = products[RESIDUAL][RESIDUAL];
        let weight = source.weight(plain);
        let certain = weight * source.certain();
        let mut normal = Self {
            information: Matrix6::zeros(),
            gradient: Vector6::zeros(),
            chi2: source.chi2(plain),
            rolling: by_twist.map(|by_twist| {
                Box::new(
                    TwistEquations::from_rows(rows, by_twist).weighed(weight, source.certain()),
                )
            }),
            square_px: 0.0,
            square: plain,
            weighted_square: plain * weight,
        };
        for (column, products) in products[..RESIDUAL].iter().enumerate() {
            for (row, product) in products[..RESIDUAL].iter().enumerate() {
                normal.information[(row, column)] = product * certain;
            }
            normal.gradient[column] = products[RESIDUAL] * weight;
        }
        normal
    }

    /// Sum of squared whitened residuals, no weight.
    pub fn square(&self) -> f64 {
        self.square
    }

    /// The weight that the view will have after a small step of its pose and its twist, against its weight here: as far
    /// as residuals are linear.
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

/// Sums over the rows of the products of any two columns.
#[inline(always)]
fn products(rows: &PoseRows) -> [[f64; 8]; 7] {
    let mut sums = [[0.0; 8]; 7];
    for column in 0..7 {
        let mut sum = [0.0; 8];
        for row in rows {
            (0..8).for_each(|other| sum[other] += row[column] * row[other]);
        }
        sums[column] = sum;
    }
    sums
}
