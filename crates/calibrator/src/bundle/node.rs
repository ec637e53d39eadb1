//! The normal equations of one instant: its own block and its coupling to the kept parameters.

use super::image_sums::ImageSums;
use super::layout::Layout;
use nalgebra::{Const, Dyn, OMatrix, SMatrix, SVector};

/// Coupling of an instant to kept columns.
pub(super) type Coupling<const D: usize> = OMatrix<f64, Const<D>, Dyn>;

/// One instant.
#[derive(Clone)]
pub(super) struct Node<const D: usize> {
    pub own: SMatrix<f64, D, D>,
    pub gradient: SVector<f64, D>,
    /// Kept columns of `coupling`, ascending.
    pub columns: Vec<usize>,
    pub coupling: Coupling<D>,
    /// Coupling with the next instant, where the motion model ties them.
    pub next: Option<SMatrix<f64, D, D>>,
}

impl<const D: usize> Node<D> {
    pub(super) fn add(&mut self, layout: &Layout, camera: usize, sums: &ImageSums<D>) {
        let camera = &layout.cameras[camera];
        let width = sums.width;
        self.own += sums.whole.fixed_view::<D, D>(width, width);
        self.gradient += sums.gradient.fixed_rows::<D>(width);
        if camera.width() > 0 {
            let at = self.local(camera.start());
            let mut own = self.coupling.columns_mut(at, camera.width());
            own += sums.whole.view((width, 0), (D, width));
        }
        for tag in &sums.tags {
            let (first, (column, n)) = (layout.tags[tag.tag].first(), layout.tags[tag.tag].span());
            if n > 0 {
                let at = self.local(column);
                let mut own = self.coupling.columns_mut(at, n);
                own += tag.image_by_tag.view((width, first), (D, n));
            }
        }
    }

    /// Place of a kept column in `coupling`.
    pub(super) fn local(&self, column: usize) -> usize {
        self.columns.partition_point(|&c| c < column)
    }
}
