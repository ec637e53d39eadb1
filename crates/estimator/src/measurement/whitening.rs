//! Whitening: linear combinations of a view's corner coordinates whose noise is independent with unit variance.

use nalgebra::SMatrix;

/// x and y of each corner, or what follows from them: eight rows, with a number for each of N quantities that they
/// depend on.
pub(crate) type Rows<const N: usize> = [[f64; N]; 8];
/// Derivatives by (dt, dr), then the residual; the last place is free.
pub(crate) type PoseRows = Rows<8>;
pub(crate) type Matrix8 = SMatrix<f64, 8, 8>;

/// Upper triangle U with Uᵀ U the inverse of the corners' covariance.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Whitening(Rows<8>);

impl Whitening {
    /// `covariance` is that of x and y of each corner in turn, px²; `None` where it is not positive definite.
    pub fn new(covariance: &Matrix8) -> Option<Self> {
        // The matrix is symmetric: its columns are its rows.
        let triangle = inverse(&root(&covariance.data.0)?);
        let mut numbers = triangle.iter().flatten();
        let is_finite = numbers.all(|number| number.is_finite());
        is_finite.then_some(Self(triangle))
    }

    /// Rows of corners made independent with unit variance, if their covariance is larger by a factor.
    #[inline(always)]
    pub fn whitened<const N: usize>(&self, corners: &Rows<N>, factor: f64) -> Rows<N> {
        let scale = factor.sqrt().recip();
        let mut whitened = [[0.0; N]; 8];
        for (row, whitened) in whitened.iter_mut().enumerate() {
            let mut sum = [0.0; N];
            for (share, corner) in self.0[row][row..].iter().zip(&corners[row..]) {
                (0..N).for_each(|n| sum[n] += share * corner[n]);
            }
            *whitened = sum.map(|number| number * scale);
        }
        whitened
    }
}

/// Sums over the rows of a number of one times a number of the other.
pub(crate) fn product<const A: usize, const B: usize>(
    ours: &Rows<A>,
    others: &Rows<B>,
) -> SMatrix<f64, A, B> {
    let of = |a: usize, b: usize| {
        let rows = ours.iter().zip(others);
        rows.map(|(one, other)| one[a] * other[b]).sum::<f64>()
    };
    SMatrix::from_fn(of)
}

/// Upper triangle V with V Vᵀ the matrix: Cholesky's factor from the last row on. `None` where it is not positive
/// definite.
fn root(matrix: &Rows<8>) -> Option<Rows<8>> {
    let mut root = [[0.0; 8]; 8];
    for column in (0..8).rev() {
        for row in (0..=column).rev() {
            let known = (column + 1..8).map(|at| root[row][at] * root[column][at]);
            let left = matrix[row][column] - known.sum::<f64>();
            if row < column {
                root[row][column] = left / root[column][column];
            } else if left > 0.0 {
                root[row][column] = left.sqrt();
            } else {
                return None;
            }
        }
    }
    Some(root)
}

/// The inverse of an upper triangle.
fn inverse(triangle: &Rows<8>) -> Rows<8> {
    let mut inverse = [[0.0; 8]; 8];
    for column in 0..8 {
        inverse[column][column] = triangle[column][column].recip();
        for row in (0..column).rev() {
            let known = (row + 1..=column).map(|at| triangle[row][at] * inverse[at][column]);
            inverse[row][column] = -known.sum::<f64>() * inverse[row][row];
        }
    }
    inverse
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn whitened_noise_has_unit_covariance() {
        let factor = |row: usize, column: usize| {
            let own = if row == column {
                0.1 + 0.02 * row as f64
            } else {
                0.0
            };
            own + 0.01 * ((3 * row + 5 * column) % 7) as f64
        };
        let factor = Matrix8::from_fn(factor);
        let covariance = factor * factor.transpose();
        let whitening = Whitening::new(&covariance).unwrap();
        let identity: Rows<8> = Matrix8::identity().into();
        let whitened = whitening.whitened(&identity, 4.0);
        let whitener = Matrix8::from_fn(|row, column| whitened[row][column]);
        let unit = whitener * (covariance * 4.0) * whitener.transpose();
        assert!((unit - Matrix8::identity()).amax() < 1e-9);
        assert_eq!(Whitening::new(&Matrix8::zeros()), None);
    }
}
