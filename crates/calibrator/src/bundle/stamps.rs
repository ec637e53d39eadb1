//! Errors of single time stamps, where the stamps of a camera jitter: one number an image, eliminated before the
//! instants.
//!
//! An error of `s` seconds displaces an image as the twist of the object times `s` does. Its normal equations with
//! everything else are the column `h`; with its own information `d` and gradient `g` the others become `H - h h' / d`
//! and `b - h g / d`.

use super::image_sums::ImageSums;
use super::layout::Layout;
use super::node::Node;
use super::state::{Bundle, BundleImage};
use nalgebra::{DMatrix, DVector, SVector};

/// The equations of the error of one stamp.
pub(super) struct StampRow<const D: usize> {
    instant: usize,
    by_instant: SVector<f64, D>,
    /// Kept columns of `by_kept`; a tag that is in the image twice has its columns twice.
    columns: Vec<usize>,
    by_kept: Vec<f64>,
    own: f64,
    gradient: f64,
}

impl<const D: usize> StampRow<D> {
    /// `None` where the stamps of the camera have no errors.
    pub(super) fn of(
        bundle: &Bundle,
        layout: &Layout,
        image: &BundleImage,
        sums: &ImageSums<D>,
    ) -> Option<Self> {
        let precision = precision(bundle, image)?;
        let camera = &layout.cameras[image.camera];
        let stamp = sums.whole.column(sums.stamp());
        let mut columns: Vec<usize> = (camera.start()..camera.start() + camera.width()).collect();
        let mut by_kept: Vec<f64> = stamp.rows(0, sums.width).iter().copied().collect();
        for tag in &sums.tags {
            let (first, (start, width)) =
                (layout.tags[tag.tag].first(), layout.tags[tag.tag].span());
            let by_tag = tag.image_by_tag.row(sums.stamp());
            columns.extend(start..start + width);
            by_kept.extend(by_tag.columns(first, width).iter());
        }
        Some(Self {
            instant: image.instant,
            by_instant: stamp.fixed_rows::<D>(sums.width).into_owned(),
            columns,
            by_kept,
            own: stamp[sums.stamp()] + precision,
            gradient: sums.gradient[sums.stamp()] + image.stamp_error_s * precision,
        })
    }

    /// Eliminates the error from the equations of its instant and of the kept parameters, of which only the upper
    /// triangle is filled.
    pub(super) fn eliminate(
        &self,
        node: &mut Node<D>,
        kept: &mut DMatrix<f64>,
        gradient: &mut DVector<f64>,
    ) {
        let share = self.own.recip();
        node.own -= self.by_instant * self.by_instant.transpose() * share;
        node.gradient -= self.by_instant * (self.gradient * share);
        for (&column, by) in self.columns.iter().zip(&self.by_kept) {
            let at = node.local(column);
            let mut coupling = node.coupling.column_mut(at);
            coupling -= self.by_instant * (by * share);
            gradient[column] -= by * self.gradient * share;
            for (&row, other) in self.columns.iter().zip(&self.by_kept) {
                if row <= column {
                    kept[(row, column)] -= by * other * share;
                }
            }
        }
    }

    /// Its step, given those of the others.
    pub(super) fn step(&self, kept: &DVector<f64>, instants: &[SVector<f64, D>]) -> f64 {
        let columns = self.columns.iter().zip(&self.by_kept);
        let by_kept: f64 = columns.map(|(&column, by)| by * kept[column]).sum();
        let by_instant = self.by_instant.dot(&instants[self.instant]);
        -(self.gradient + by_kept + by_instant) / self.own
    }

    /// Logarithm of its information.
    pub(super) fn log_information(&self) -> f64 {
        self.own.ln()
    }
}

/// Precision of the prior of the error of an image's stamp; `None` where there is no error.
fn precision(bundle: &Bundle, image: &BundleImage) -> Option<f64> {
    let sigma_s = bundle.cameras[image.camera].stamp_sigma_s;
    (bundle.motion.is_some() && sigma_s > 0.0).then(|| sigma_s.powi(-2))
}

/// Sum of the squares of all errors by their priors.
pub(super) fn rho(bundle: &Bundle) -> f64 {
    let images = bundle.images.iter();
    let squares = images.filter_map(|image| {
        let precision = precision(bundle, image)?;
        Some(image.stamp_error_s.powi(2) * precision)
    });
    squares.sum()
}

/// Sum of the logarithms of the precisions of all errors' priors.
pub(super) fn log_prior(bundle: &Bundle) -> f64 {
    let images = bundle.images.iter();
    images
        .filter_map(|image| precision(bundle, image))
        .map(f64::ln)
        .sum()
}
