//! Blocks of the state covariance, and matrix functions of the filter.

use crate::filter::process_noise::ProcessNoisePsd;
use nalgebra::{Matrix3, SMatrix, Vector3};
use sextant_site_model::MOST_JOINTS;

/// Covariance over (dt, dr, dv, dw).
pub(crate) type Covariance = SMatrix<f64, 12, 12>;

/// Most clock offsets estimated with one object; further clocks are taken to be right.
pub(crate) const MOST_CLOCKS: usize = 8;

pub(crate) type Cross = SMatrix<f64, 12, MOST_CLOCKS>;
pub(crate) type Own = SMatrix<f64, MOST_CLOCKS, MOST_CLOCKS>;

/// Values, then speeds.
pub(crate) const WIDTH: usize = 2 * MOST_JOINTS;
/// With (dt, dr, dv, dw).
pub(crate) type JointCross = SMatrix<f64, 12, WIDTH>;
pub(crate) type JointOwn = SMatrix<f64, WIDTH, WIDTH>;
pub(crate) type JointClocks = SMatrix<f64, WIDTH, MOST_CLOCKS>;

/// Of the clocks' offsets.
pub(crate) type ClockSensitivity = SMatrix<f64, MOST_CLOCKS, 6>;

/// Covariance of the observed configuration with the parts of the state.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct CrossCovariance<const D: usize> {
    /// With (dt, dr, dv, dw).
    pub motion: SMatrix<f64, D, 12>,
    /// With the joints' values and speeds.
    pub joints: SMatrix<f64, D, WIDTH>,
    /// With the clocks' offsets.
    pub clocks: SMatrix<f64, D, MOST_CLOCKS>,
}

/// F times a matrix, column by column.
pub(crate) fn carry<const N: usize>(
    matrix: &mut SMatrix<f64, 12, N>,
    turn: &Matrix3<f64>,
    gain: &Matrix3<f64>,
    dt: f64,
) {
    let columns: &mut [[f64; 12]; N] = &mut matrix.data.0;
    for column in columns {
        let dr = Vector3::new(column[3], column[4], column[5]);
        let dw = Vector3::new(column[9], column[10], column[11]);
        let turned = turn * dr + gain * dw;
        for axis in 0..3 {
            column[axis] += column[6 + axis] * dt;
            column[3 + axis] = turned[axis];
        }
    }
}

/// Integral of the white acceleration over `dt` (Bar-Shalom, Li, Kirubarajan 2001, eq. 6.2.2-4).
pub(crate) fn white_acceleration(dt: f64, process_noise_psd: ProcessNoisePsd) -> Covariance {
    let dt = dt.abs();
    let mut noise = Covariance::zeros();
    for axis in 0..6 {
        let density = if axis < 3 {
            process_noise_psd.linear
        } else {
            process_noise_psd.angular
        };
        noise[(axis, axis)] = density * dt.powi(3) / 3.0;
        noise[(axis, axis + 6)] = density * dt.powi(2) / 2.0;
        noise[(axis + 6, axis)] = noise[(axis, axis + 6)];
        noise[(axis + 6, axis + 6)] = density * dt;
    }
    noise
}

/// Whether a variance along some axis exceeds a limit. The trace bounds the largest eigenvalue from above and the
/// diagonal from below, so that eigenvalues are hardly ever needed.
pub(crate) fn is_wider_than(covariance: &Matrix3<f64>, limit: f64) -> bool {
    covariance.trace() > limit
        && (covariance.diagonal().max() > limit || covariance.symmetric_eigenvalues().max() > limit)
}

/// The symmetric part, so that rounding can't add up.
pub(crate) fn symmetric<const N: usize>(matrix: &SMatrix<f64, N, N>) -> SMatrix<f64, N, N> {
    let mut symmetric = *matrix;
    for column in 0..N {
        for row in 0..column {
            let mean = (matrix[(row, column)] + matrix[(column, row)]) * 0.5;
            symmetric[(row, column)] = mean;
            symmetric[(column, row)] = mean;
        }
    }
    symmetric
}
