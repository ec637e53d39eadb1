//! What has been learned of errors that last, beyond what is stated of them.

use nalgebra::{DMatrix, DVector, Matrix6, SVector, Vector6};

use super::clocks::{MOST_CLOCKS, Own};
use super::consider::{OfClocks, Source};

/// The errors of some sources, as far as they are known.
#[derive(Debug, Clone, PartialEq, Default)]
pub(crate) struct Learned {
    /// With the variances that are stated.
    pub sources: Vec<(Source, Vector6<f64>)>,
    pub mean: DVector<f64>,
    pub covariance: DMatrix<f64>,
}

impl Learned {
    /// The first place of a source's errors; `None` where nothing is learned about it.
    pub fn place(&self, of: Source) -> Option<usize> {
        let index = self.sources.iter().position(|one| one.0 == of)?;
        Some(6 * index)
    }

    /// What errors that act so on the clocks' offsets have done to these: mean and covariance. Of those that nothing is learned
    /// about, the variances are given.
    pub fn of_clocks<'a>(
        &self,
        acting: impl Iterator<Item = (Source, &'a Vector6<f64>, &'a OfClocks)>,
    ) -> (SVector<f64, MOST_CLOCKS>, Own) {
        let mut stated = Own::zeros();
        let mut by = DMatrix::zeros(MOST_CLOCKS, self.mean.len());
        for (source, variance, one) in acting {
            match self.place(source) {
                Some(first) => by.fixed_columns_mut::<6>(first).copy_from(one),
                None => stated += one * Matrix6::from_diagonal(variance) * one.transpose(),
            }
        }
        let off = &by * &self.mean;
        let learned = &by * &self.covariance * by.transpose();
        (
            SVector::from_column_slice(off.as_slice()),
            stated + Own::from_column_slice(learned.as_slice()),
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_learned_of_an_error_counts_instead_of_what_is_stated() {
        let (camera, other) = (Source::Camera(0), Source::Camera(1));
        let learned = Learned {
            sources: vec![(camera, Vector6::repeat(1.0))],
            mean: DVector::from_element(6, 0.5),
            covariance: DMatrix::identity(6, 6) * 0.01,
        };
        let (variance, mut by) = (Vector6::repeat(1.0), OfClocks::zeros());
        by[(2, 0)] = 2.0;
        let (off, covariance) = learned.of_clocks([(camera, &variance, &by)].into_iter());
        assert!((off[2] - 1.0).abs() < 1e-12 && (covariance[(2, 2)] - 0.04).abs() < 1e-12);
        let (off, covariance) = learned.of_clocks([(other, &variance, &by)].into_iter());
        assert!(off[2] == 0.0 && (covariance[(2, 2)] - 4.0).abs() < 1e-12);
    }
}
