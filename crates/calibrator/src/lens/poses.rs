//! Pose of the board in an image with an approximate lens: the consensus of its tags.

use super::board::Board;
use super::view::BoardView;
use sextant_geometry::planar_pose::solve_square;
use sextant_geometry::{Lens, Pose};

/// Most tags that propose a pose; the largest are used.
const PROPOSERS: usize = 8;

/// `camera_from_board` with which most tags agree, and the indices of these tags in the view.
pub(super) fn board_pose(
    board: &Board,
    view: &BoardView,
    lens: &Lens,
    tolerance_px: f64,
) -> Option<(Pose, Vec<usize>)> {
    let mut proposers: Vec<usize> = (0..view.tags.len()).collect();
    let area = |at: &usize| {
        let c = &view.tags[*at].corners;
        (c[2] - c[0]).perp(&(c[3] - c[1])).abs()
    };
    proposers.sort_by(|a, b| area(b).total_cmp(&area(a)).then(a.cmp(b)));
    let proposals = proposers.iter().take(PROPOSERS).flat_map(|&at| {
        let seen = &view.tags[at];
        let tag = &board.tags[seen.tag];
        let poses = solve_square(lens, &seen.corners, tag.size_m).ok();
        let tag_from_board = tag.board_from_tag.inverse();
        let both = poses.into_iter().flat_map(|poses| {
            let both: Vec<Pose> = poses.iter().map(|pose| pose.camera_from_tag).collect();
            both
        });
        both.map(move |camera_from_tag| camera_from_tag * tag_from_board)
    });
    let judged = proposals.map(|pose| {
        let (cost, agreeing) = agreement(board, view, lens, &pose, tolerance_px);
        (cost, pose, agreeing)
    });
    let best = judged.min_by(|a, b| a.0.total_cmp(&b.0))?;
    (!best.2.is_empty()).then_some((best.1, best.2))
}

/// Sum of the tags' errors, each bounded by one, and the tags whose error is within the tolerance.
fn agreement(
    board: &Board,
    view: &BoardView,
    lens: &Lens,
    camera_from_board: &Pose,
    tolerance_px: f64,
) -> (f64, Vec<usize>) {
    let (mut cost, mut agreeing) = (0.0, Vec::new());
    for (at, seen) in view.tags.iter().enumerate() {
        let corners = board.tags[seen.tag].corners.iter().zip(&seen.corners);
        let error = corners
            .map(|(on_board, in_image)| {
                let projected = lens.project(&(camera_from_board * on_board));
                projected.map_or(f64::INFINITY, |p| (p - in_image).norm_squared())
            })
            .sum::<f64>()
            / (4.0 * tolerance_px * tolerance_px);
        cost += error.min(1.0);
        if error < 1.0 {
            agreeing.push(at);
        }
    }
    (cost, agreeing)
}
