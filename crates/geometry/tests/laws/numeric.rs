//! Derivatives by differences, the twin of every analytic one.

use nalgebra::{SMatrix, SVector};

/// The derivative of `f` at zero by central differences.
pub fn jacobian_at_zero<const M: usize, const N: usize>(
    f: impl Fn(&SVector<f64, N>) -> SVector<f64, M>,
) -> SMatrix<f64, M, N> {
    const STEP: f64 = 1e-6;
    let column = |i: usize| {
        let mut step = SVector::<f64, N>::zeros();
        step[i] = STEP;
        (f(&step) - f(&-step)) / (2.0 * STEP)
    };
    let columns: Vec<_> = (0..N).map(column).collect();
    SMatrix::from_columns(&columns)
}

/// The largest difference of two matrices, relative to one plus the larger's largest entry.
pub fn relative_difference<const M: usize, const N: usize>(
    a: &SMatrix<f64, M, N>,
    b: &SMatrix<f64, M, N>,
) -> f64 {
    (a - b).amax() / (1.0 + a.amax().max(b.amax()))
}
