//! The noise of a tag's corners by what its edges may do: shift and turn.
//!
//! Detectors find edges, and corners where they meet, so that the errors of a tag's four corners hang together: where an
//! edge lies is known better than how it is turned (a line fitted along its length: 1 to 3 in variance, whereas corners
//! found one by one give 1 to 1). How much is learned from the residuals, as a factor on the stated variance for either.

use nalgebra::{Point2, SMatrix, Vector2};

/// x and y of each corner, or what follows from them: eight rows, with a number for each of N quantities that they depend on.
pub(crate) type Rows<const N: usize> = [[f64; N]; 8];
/// Derivatives by (dt, dr), then the residual; the last place is free.
pub(crate) type PoseRows = Rows<8>;
/// Derivatives of x and of y by (dt, dr).
pub(crate) type Slopes = [[f64; 6]; 2];
pub(crate) type Matrix8 = SMatrix<f64, 8, 8>;
type Square = Rows<8>;

/// Variance of the corners' noise against what is stated.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct NoiseFactors {
    /// Of the places of edges.
    pub shift: f64,
    /// Of their directions.
    pub turn: f64,
}

impl NoiseFactors {
    /// Of single corners: half of either.
    pub fn of_corner(self) -> f64 {
        0.5 * (self.shift + self.turn)
    }
}

/// The residuals of a tag's corners as shifts and turns of its edges: how a corner's displacement is both for the two edges
/// that meet there, and how these hang together.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct EdgeModes {
    /// Across each edge, from a corner to the next; the length makes shifts and turns of unit noise have unit noise.
    normals: [Vector2<f64>; 4],
    /// Upper triangle U that makes four shifts and four turns independent with unit variance: Uᵀ U is the inverse of their
    /// covariance as stated.
    triangle: Square,
}

impl EdgeModes {
    /// `covariance` is that of x and y of each corner in turn, as stated; `None` where the corners enclose nothing, or that is none.
    pub fn new(corners: &[Point2<f64>; 4], covariance: &Matrix8) -> Option<Self> {
        let mut normals = [Vector2::zeros(); 4];
        for (edge, normal) in normals.iter_mut().enumerate() {
            let along = (corners[(edge + 1) % 4] - corners[edge]).try_normalize(1e-9)?;
            *normal = Vector2::new(-along.y, along.x) * std::f64::consts::FRAC_1_SQRT_2;
        }
        // The matrix is symmetric: its columns are its rows.
        let of_columns = modes(&normals, &covariance.data.0, [1.0; 2]);
        let of_rows = std::array::from_fn(|row| of_columns.map(|column| column[row]));
        let triangle = inverse(&root(modes(&normals, &of_rows, [1.0; 2]))?);
        let mut numbers = triangle.iter().flatten();
        let is_finite = numbers.all(|number| number.is_finite());
        is_finite.then_some(Self { normals, triangle })
    }

    /// Rows of corners made independent with unit variance, if their noise is as stated times the factors: first those of
    /// shifts, then those of turns.
    #[inline(always)]
    pub fn whitened<const N: usize>(&self, corners: &Rows<N>, noise: NoiseFactors) -> Rows<N> {
        let factors = [noise.shift, noise.turn].map(|factor| factor.sqrt().recip());
        let modes = modes(&self.normals, corners, factors);
        let mut whitened = [[0.0; N]; 8];
        for (row, whitened) in whitened.iter_mut().enumerate() {
            let mut sum = [0.0; N];
            for (share, mode) in self.triangle[row][row..].iter().zip(&modes[row..]) {
                (0..N).for_each(|n| sum[n] += share * mode[n]);
            }
            *whitened = sum;
        }
        whitened
    }
}

/// The rows of corners as rows of shifts of the edges across these normals, then of their turns.
#[inline(always)]
fn modes<const N: usize>(
    normals: &[Vector2<f64>; 4],
    corners: &Rows<N>,
    factors: [f64; 2],
) -> Rows<N> {
    let mut modes = [[0.0; N]; 8];
    for (edge, normal) in normals.iter().enumerate() {
        let (from, to) = (2 * edge, 2 * ((edge + 1) % 4));
        for n in 0..N {
            let before = normal.x * corners[from][n] + normal.y * corners[from + 1][n];
            let after = normal.x * corners[to][n] + normal.y * corners[to + 1][n];
            modes[edge][n] = (after + before) * factors[0];
            modes[edge + 4][n] = (after - before) * factors[1];
        }
    }
    modes
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

/// Upper triangle V with V Vᵀ the matrix: Cholesky's factor from the last row on. `None` where it is not positive definite.
fn root(matrix: Square) -> Option<Square> {
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
fn inverse(triangle: &Square) -> Square {
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

    fn corners() -> [Point2<f64>; 4] {
        [
            (100.0, 100.0),
            (130.0, 104.0),
            (126.0, 140.0),
            (95.0, 131.0),
        ]
        .map(|(x, y)| Point2::new(x, y))
    }

    /// Each corner has its own, and hangs together with the others.
    fn covariance() -> Matrix8 {
        let factor = |row: usize, column: usize| {
            let own = if row == column {
                0.1 + 0.02 * row as f64
            } else {
                0.0
            };
            own + 0.01 * ((3 * row + 5 * column) % 7) as f64
        };
        let factor = Matrix8::from_fn(factor);
        factor * factor.transpose()
    }

    #[test]
    fn with_factors_of_one_the_noise_is_as_stated() {
        let as_stated = NoiseFactors {
            shift: 1.0,
            turn: 1.0,
        };
        let modes = EdgeModes::new(&corners(), &covariance()).unwrap();
        let corners: Rows<8> = Matrix8::identity().transpose().into();
        let whitened = modes.whitened(&corners, as_stated);
        let whitener = Matrix8::from_fn(|row, column| whitened[row][column]);
        let stated = (whitener.transpose() * whitener).try_inverse().unwrap();
        assert!((stated - covariance()).amax() < 1e-9);
    }

    #[test]
    fn a_shifted_edge_is_no_turn() {
        let modes = EdgeModes::new(&corners(), &Matrix8::identity()).unwrap();
        let along = (corners()[1] - corners()[0]).normalize();
        let mut residual = [[0.0]; 8];
        for corner in [0, 1] {
            (residual[2 * corner], residual[2 * corner + 1]) = ([-along.y], [along.x]);
        }
        let seen = crate::measurement::edge_modes::modes(&modes.normals, &residual, [1.0; 2]);
        assert!((seen[0][0] - std::f64::consts::SQRT_2).abs() < 1e-12 && seen[4][0].abs() < 1e-12);
    }
}
