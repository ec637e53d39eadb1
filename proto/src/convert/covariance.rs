//! Covariances as they are published: symmetric and positive semi-definite, whatever rounding has made of them.

use nalgebra::Matrix6;

/// The nearest symmetric positive semi-definite matrix (in the Frobenius norm, Higham 1988, "Computing a nearest
/// symmetric positive semidefinite matrix", theorem 2.1): of the symmetric part, eigenvalues below zero become zero.
/// Row-major; what is not finite stays as it is, for the message's check.
pub(crate) fn published(covariance: &Matrix6<f64>) -> [f64; 36] {
    let rows = |matrix: &Matrix6<f64>| std::array::from_fn(|k| matrix[(k / 6, k % 6)]);
    if !covariance.iter().all(|x| x.is_finite()) {
        return rows(covariance);
    }
    let symmetric = (covariance + covariance.transpose()) * 0.5;
    if symmetric.cholesky().is_some() {
        return rows(&symmetric);
    }
    let mut eigen = symmetric.symmetric_eigen();
    eigen.eigenvalues.apply(|value| *value = value.max(0.0));
    let projected = eigen.recompose();
    rows(&((projected + projected.transpose()) * 0.5))
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{Matrix6, Vector6};

    fn matrix(rows: &[f64; 36]) -> Matrix6<f64> {
        Matrix6::from_row_slice(rows)
    }

    #[test]
    fn what_is_a_covariance_stays_as_it_is() {
        let sound = Matrix6::from_element(1e-7) + Matrix6::identity() * 2e-6;
        assert_eq!(matrix(&published(&sound)), sound);
        assert_eq!(published(&Matrix6::zeros()), [0.0; 36]);
    }

    #[test]
    fn negative_variances_become_zero_and_the_others_stay() {
        let mut covariance =
            Matrix6::from_diagonal(&Vector6::new(1e-6, 1e-6, -1e-12, 1.0, 1.0, 2.0));
        covariance[(3, 4)] = 1.5;
        covariance[(4, 3)] = 1.5;
        covariance[(0, 5)] = 1e-9;
        let found = matrix(&published(&covariance));
        assert_eq!(found, found.transpose());
        assert!(found.diagonal().iter().all(|variance| *variance >= 0.0));
        let least = found.symmetric_eigenvalues().min();
        assert!(least > -1e-15, "{least}");
        // Of [[1, 1.5], [1.5, 1]] the direction with -0.5 goes.
        assert!((found[(3, 3)] - 1.25).abs() < 1e-12 && (found[(3, 4)] - 1.25).abs() < 1e-12);
        assert!((found[(0, 0)] - 1e-6).abs() < 1e-14 && (found[(5, 5)] - 2.0).abs() < 1e-12);
    }

    #[test]
    fn numbers_that_are_none_are_left_to_the_check() {
        let mut covariance = Matrix6::identity();
        covariance[(2, 2)] = f64::NAN;
        assert!(published(&covariance).iter().any(|x| x.is_nan()));
    }
}
