//! A solved constellation, before the report.

use crate::adjustment::AdjustmentResult;
use crate::image_store::ImageView;
use nalgebra::DMatrix;
use sextant_geometry::Pose;

/// The adjusted tags in the frame of the result.
pub(super) struct SolvedConstellation {
    pub views: Vec<ImageView>,
    pub adjusted: AdjustmentResult,
    /// Covariance of the session's free tags, six columns each, in the frame of the result.
    pub covariance: DMatrix<f64>,
    /// `object_from_tag` in the frame of the result.
    pub poses: Vec<Pose>,
    /// Whether each tag was free.
    pub sought: Vec<bool>,
}

/// Image counts of one tag.
#[derive(Clone, Copy, Default)]
pub(super) struct Counts {
    pub seen: usize,
    pub fits: usize,
    /// Images that place it elsewhere on the object.
    pub elsewhere: usize,
}

/// Image counts of every tag.
pub(super) fn fitting(n: usize, views: &[ImageView], adjusted: &AdjustmentResult) -> Vec<Counts> {
    let mut counts = vec![Counts::default(); n];
    for tag in views.iter().flat_map(|view| &view.tags) {
        counts[tag.tag].seen += 1;
    }
    let fits = adjusted.solution.bundle.images.iter();
    for seen in fits.flat_map(|image| &image.tags) {
        counts[seen.tag].fits += 1;
    }
    let mut blurred = vec![0; n];
    for misfit in adjusted.misfits.iter().filter(|m| !m.is_elsewhere()) {
        blurred[views[misfit.view].tags[misfit.seen].tag] += 1;
    }
    for (count, blurred) in counts.iter_mut().zip(blurred) {
        count.elsewhere = count.seen.saturating_sub(count.fits + blurred);
    }
    counts
}
