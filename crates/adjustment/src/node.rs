//! The normal equations of one instant: its own block and its coupling to the kept parameters.

use crate::tie::Tie;
use nalgebra::{Const, Dyn, OMatrix, SMatrix, SVector};

/// Coupling of an instant to kept columns.
pub(crate) type Coupling<const D: usize> = OMatrix<f64, Const<D>, Dyn>;

/// One instant.
#[derive(Clone)]
pub(crate) struct Node<const D: usize> {
    pub own: SMatrix<f64, D, D>,
    pub gradient: SVector<f64, D>,
    /// Kept columns of `coupling`, ascending.
    pub columns: Vec<usize>,
    pub coupling: Coupling<D>,
    /// What ties it to the next instant.
    pub next: Option<Tie>,
    /// Information of its ties, as far as Marquardt's damping counts it.
    pub tied: SVector<f64, D>,
}

impl<const D: usize> Node<D> {
    /// Without observations.
    pub(crate) fn new(columns: Vec<usize>) -> Self {
        Self {
            own: SMatrix::zeros(),
            gradient: SVector::zeros(),
            coupling: Coupling::<D>::zeros(columns.len()),
            columns,
            next: None,
            tied: SVector::zeros(),
        }
    }

    /// Place of a kept column in `coupling`.
    pub(crate) fn local(&self, column: usize) -> usize {
        self.columns.partition_point(|&c| c < column)
    }
}
