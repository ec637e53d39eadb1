//! Cross-validation: the images of some poses are left out, the robot is solved from the others, and its poses predict
//! what these images show.

use super::RobotSession;
use super::report::HeldOut;
use super::solution::RobotSolution;
use crate::adjustment::Adjustment;
use crate::resection::{TagPlacement, resected, tag_error_px};
use sextant_adjustment::{Arm, BundleOptions};
use std::ops::Range;

/// Groups of poses that follow one another, each of which is left out once.
const FOLDS: usize = 10;
/// Fewer poses cannot spare any.
const LEAST_POSES: usize = 5;

impl RobotSession {
    /// Errors of held-out poses; `None` where there are too few.
    pub(super) fn held_out(&self, solution: &RobotSolution) -> Option<HeldOut> {
        let n = solution.adjusted.adjustment.instants.len();
        if n < LEAST_POSES {
            return None;
        }
        let folds = FOLDS.min(n);
        let errors = (0..folds).filter_map(|k| fold(solution, k * n / folds..(k + 1) * n / folds));
        let errors: Vec<[f64; 3]> = errors.flatten().collect();
        HeldOut::from_errors(&errors)
    }
}

/// Distance (m), angle (rad) and corners (px) of each pose of a fold.
fn fold(solution: &RobotSolution, out: Range<usize>) -> Option<Vec<[f64; 3]>> {
    let whole = &solution.adjusted.adjustment;
    let mut rest = whole.clone();
    rest.images.retain(|image| !out.contains(&image.instant));
    let options = BundleOptions {
        by_clusters: false,
        ..BundleOptions::default()
    };
    let found = rest.solve(&solution.views, &options).ok()?;
    let arm = found.adjustment.arm.as_ref()?;
    let tags = found.adjustment.tags.iter();
    let tags: Vec<TagPlacement> = tags
        .map(|tag| Some((tag.object_from_tag, tag.size_m)))
        .collect();
    let errors = out.filter_map(|instant| {
        let hand = whole.arm.as_ref()?.hands[instant]?;
        error(
            solution,
            &found.adjustment,
            arm,
            &tags,
            instant,
            &hand.base_from_hand,
        )
    });
    Some(errors.collect())
}

/// Error of the prediction of what the best image of an instant shows; `None` where no tag of it is used.
fn error(
    solution: &RobotSolution,
    found: &Adjustment,
    arm: &Arm,
    tags: &[TagPlacement],
    instant: usize,
    base_from_hand: &sextant_geometry::Pose,
) -> Option<[f64; 3]> {
    let images = solution.adjusted.adjustment.images.iter();
    let own = images.filter(|image| image.instant == instant);
    let image = own.max_by_key(|image| image.tags.len())?;
    if image.tags.is_empty() {
        return None;
    }
    let (camera, view) = (&found.cameras[image.camera], &solution.views[image.view]);
    let predicted = camera.world_from_camera.inverse() * arm.predicted(base_from_hand);
    let seen = resected(&camera.lens, view, tags, &image.tags, predicted);
    let off = predicted.inverse() * seen;
    let corners_px = image.tags.iter().filter_map(|&at| {
        let (object_from_tag, size_m) = tags[view.tags[at].tag]?;
        let camera_from_tag = predicted * object_from_tag;
        let corners = &view.tags[at].corners.corners;
        tag_error_px(&camera.lens, &camera_from_tag, size_m, corners)
    });
    let squares: Vec<f64> = corners_px.map(|px| px * px).collect();
    let mean = squares.iter().sum::<f64>() / squares.len().max(1) as f64;
    Some([
        off.translation.vector.norm(),
        off.rotation.angle(),
        mean.sqrt(),
    ])
}
