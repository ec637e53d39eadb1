//! A check of a solution by images that had no part in it: the site is solved without a quarter of the instants, in
//! stretches from all over the recording, and these are then fitted with the site held fixed, only the poses of the
//! objects free. The residual is compared with that of the same images by the whole solution, fitted alike.

use crate::adjustment::{Adjustment, AdjustmentResult};
use crate::image_store::ImageView;
use crate::verdict::{Finding, Grade, Verdict};
use serde::Serialize;
use sextant_adjustment::{BodyId, BundleOptions, FreeLens, Freedom, solve};

/// Residuals of images that had no part in a solution.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct HeldOutImages {
    /// Number of these images.
    pub images: usize,
    /// Root mean square of their corners by a site that was solved without them, pixels.
    pub rms_px: f64,
    /// The same by the site that was solved with them, pixels.
    pub used_rms_px: f64,
}

/// Stretches of the instants, of which every fourth is left out.
const STRETCHES: usize = 16;
/// Fewer instants cannot spare any.
const LEAST_INSTANTS: usize = 2 * STRETCHES;
/// A residual by this factor larger without the images limits the use of a result, and by the second makes it poor.
const WORSE: [f64; 2] = [1.5, 3.0];

impl AdjustmentResult {
    /// Residuals of held-out images; `None` where there are too few or the rest gives no site.
    pub(crate) fn held_out(&self, views: &[ImageView]) -> Option<HeldOutImages> {
        let whole = &self.adjustment;
        let moving = |at: &usize| matches!(whole.instants[*at].body, BodyId::Moving(_));
        let moving: Vec<usize> = (0..whole.instants.len()).filter(moving).collect();
        if moving.len() < LEAST_INSTANTS {
            return None;
        }
        let is_out = |instant: usize| {
            let place = moving.binary_search(&instant);
            place.is_ok_and(|place| place * STRETCHES / moving.len() % 4 == 1)
        };
        let options = BundleOptions {
            by_clusters: false,
            ..BundleOptions::default()
        };
        let mut rest = whole.of_instants(|instant| !is_out(instant));
        rest.take(&solve(rest.bundle(views), &options).ok()?.bundle);
        let out = whole.of_instants(is_out);
        let rms_px = |site: &Adjustment| {
            let fitted = solve(out.before(site).bundle(views), &options).ok()?;
            Some(fitted.rms_px)
        };
        Some(HeldOutImages {
            images: out.images.len(),
            rms_px: rms_px(&rest)?,
            used_rms_px: rms_px(whole)?,
        })
    }
}

impl Adjustment {
    /// Its images before the cameras and with the tags of another adjustment, all of which are fixed.
    fn before(&self, site: &Self) -> Self {
        let mut fitted = self.clone();
        fitted.cameras.clone_from(&site.cameras);
        fitted.tags.clone_from(&site.tags);
        for camera in &mut fitted.cameras {
            (camera.pose, camera.free_lens) = (Freedom::Fixed, FreeLens::FIXED);
            (camera.clock, camera.line_delay) = (Freedom::Fixed, Freedom::Fixed);
        }
        for tag in &mut fitted.tags {
            (tag.pose, tag.size) = (Freedom::Fixed, Freedom::Fixed);
        }
        fitted
    }
}

/// Judges a result by its held-out images.
pub(crate) fn judge(held_out: Option<&HeldOutImages>, verdict: &mut Verdict) {
    let Some(HeldOutImages {
        rms_px,
        used_rms_px,
        ..
    }) = held_out.copied()
    else {
        return;
    };
    let grade = match rms_px / used_rms_px {
        ratio if ratio > WORSE[1] => Grade::Poor,
        ratio if ratio > WORSE[0] => Grade::Usable,
        _ => return,
    };
    verdict.add(
        grade,
        Finding::HeldOutWorse {
            rms_px,
            used_rms_px,
        },
    );
}
