//! Errors of single time stamps, where the stamps of a camera jitter: one number an image, eliminated before the
//! instants.
//!
//! A stamp that is ahead by `s` seconds displaces an image as the twist of the object times `-s` does. Its normal
//! equations with everything else are the column `h`; with its own information `d` and gradient `g` the others become
//! `H - h h' / d` and `b - h g / d`.

use crate::node::Node;
use crate::residuals::corners::{ImageModel, KeptBlock};
use crate::values::{Bundle, BundleImage};
use nalgebra::{DMatrix, DVector, SVector};
use sextant_geometry::least_squares::Kernel;
use std::collections::BTreeMap;

/// The equations of the error of one stamp.
pub(crate) struct StampRow<const D: usize> {
    instant: usize,
    by_instant: SVector<f64, D>,
    /// By the kept columns of its image.
    by_kept: BTreeMap<usize, f64>,
    own: f64,
    gradient: f64,
}

impl<const D: usize> StampRow<D> {
    /// Its prior; `None` where the stamps of the camera have no errors.
    pub(crate) fn new(bundle: &Bundle, image: &BundleImage) -> Option<Self> {
        let precision = precision(bundle, image)?;
        Some(Self {
            instant: image.instant,
            by_instant: SVector::zeros(),
            by_kept: BTreeMap::new(),
            own: precision,
            gradient: image.stamp_error_s * precision,
        })
    }

    /// Adds a tag of its image: `products` and `pull` over the rows' columns, of which the instant's begin at `first`
    /// and the stamp's comes last.
    pub(crate) fn add(
        &mut self,
        blocks: &[KeptBlock],
        products: &DMatrix<f64>,
        pull: &DVector<f64>,
        first: usize,
    ) {
        let stamp = first + D;
        self.own += products[(stamp, stamp)];
        self.gradient += pull[stamp];
        self.by_instant += products.fixed_view::<D, 1>(first, stamp);
        for block in blocks {
            for at in 0..block.width {
                let by = self.by_kept.entry(block.column + at).or_default();
                *by += products[(block.row + at, stamp)];
            }
        }
    }

    /// Eliminates the error from the equations of its instant and of the kept parameters, of which only the upper
    /// triangle is filled.
    pub(crate) fn eliminate(
        &self,
        node: &mut Node<D>,
        kept: &mut DMatrix<f64>,
        gradient: &mut DVector<f64>,
    ) {
        let share = self.own.recip();
        node.own -= self.by_instant * self.by_instant.transpose() * share;
        node.gradient -= self.by_instant * (self.gradient * share);
        for (&column, by) in &self.by_kept {
            let at = node.local(column);
            let mut coupling = node.coupling.column_mut(at);
            coupling -= self.by_instant * (by * share);
            gradient[column] -= by * self.gradient * share;
            for (&row, other) in self.by_kept.range(..=column) {
                kept[(row, column)] -= by * other * share;
            }
        }
    }

    /// Its step, given those of the others.
    pub(crate) fn step(&self, kept: &DVector<f64>, instants: &[SVector<f64, D>]) -> f64 {
        let by_kept: f64 = self
            .by_kept
            .iter()
            .map(|(&column, by)| by * kept[column])
            .sum();
        let by_instant = self.by_instant.dot(&instants[self.instant]);
        -(self.gradient + by_kept + by_instant) / self.own
    }

    /// Logarithm of its information.
    pub(crate) fn log_information(&self) -> f64 {
        self.own.ln()
    }
}

/// Precision of the prior of the error of an image's stamp; `None` where there is no error.
fn precision(bundle: &Bundle, image: &BundleImage) -> Option<f64> {
    let sigma_s = bundle.cameras[image.camera].stamp_sigma_s;
    (bundle.motion.is_some() && sigma_s > 0.0).then(|| sigma_s.powi(-2))
}

/// Seconds over which the displacement of corners by an error is differentiated.
const DIFFERENCE_S: f64 = 1e-6;

/// Moves the errors of all stamps to their best values beside the present values of everything else, to first order
/// (variable projection; G. Golub and V. Pereyra, 1973): errors and twists multiply, so that joint steps would creep
/// along a curved valley.
pub(crate) fn settle(bundle: &mut Bundle, kernel: &Kernel) {
    let steps: Vec<f64> = bundle
        .images
        .iter()
        .map(|image| step(bundle, image, kernel))
        .collect();
    for (image, step) in bundle.images.iter_mut().zip(steps) {
        image.stamp_error_s += step;
    }
}

/// Gauss-Newton step of the error of a stamp alone.
fn step(bundle: &Bundle, image: &BundleImage, kernel: &Kernel) -> f64 {
    let Some(precision) = precision(bundle, image) else {
        return 0.0;
    };
    let later = BundleImage {
        stamp_error_s: image.stamp_error_s + DIFFERENCE_S,
        tags: Vec::new(),
        ..*image
    };
    let [here, there] = [image, &later].map(|image| ImageModel::new(bundle, image));
    let (mut own, mut pull) = (precision, image.stamp_error_s * precision);
    for seen in &image.tags {
        let corners = here.errors_px(seen).into_iter().zip(there.errors_px(seen));
        for ((error, moved), whitening) in corners.zip(&seen.whitening) {
            let (Some(error), Some(moved)) = (error, moved) else {
                continue;
            };
            let by_error = whitening * (moved - error) / DIFFERENCE_S;
            let error = whitening * error;
            let weight = kernel.weight(error.norm_squared());
            own += weight * by_error.norm_squared();
            pull += weight * by_error.dot(&error);
        }
    }
    -pull / own
}

/// Sum of the squares of all errors by their priors.
pub(crate) fn rho(bundle: &Bundle) -> f64 {
    let images = bundle.images.iter();
    let squares = images.filter_map(|image| {
        let precision = precision(bundle, image)?;
        Some(image.stamp_error_s.powi(2) * precision)
    });
    squares.sum()
}

/// Sum of the logarithms of the precisions of all errors' priors.
pub(crate) fn log_prior(bundle: &Bundle) -> f64 {
    let images = bundle.images.iter();
    images
        .filter_map(|image| precision(bundle, image))
        .map(f64::ln)
        .sum()
}
