//! Initial lens: the focal lengths from homographies or the best of a fixed list, for ordinary and fisheye lenses.

use super::adjust::{Adjustment, Parameters, Start, adjust};
use super::board::Board;
use super::poses::board_pose;
use super::view::BoardView;
use super::{homographies, refusal::LensRefusal};
use sextant_geometry::{Intrinsics, Lens};

/// Images that evaluate a candidate.
const JUDGES: usize = 12;
/// Listed focal lengths, as shares of the image width: horizontal fields of view from 106 to 14 degrees.
const LADDER: [f64; 9] = [0.38, 0.5, 0.65, 0.85, 1.1, 1.45, 1.9, 2.6, 4.0];
/// Largest error of a tag with an approximate lens, as a share of the image width.
const TOLERANCE: f64 = 0.03;
/// Standard deviation of the errors of a candidate, pixels.
const SIGMA_PX: f64 = 1.0;

/// The candidate that explains the views best.
pub(super) fn start(
    board: &Board,
    views: &[BoardView],
    resolution: [u32; 2],
) -> Result<Start, LensRefusal> {
    let size = resolution.map(f64::from);
    let mut order: Vec<usize> = (0..views.len()).collect();
    order.sort_by_key(|&at| (std::cmp::Reverse(views[at].tags.len()), at));
    let judges: Vec<BoardView> = order
        .iter()
        .take(JUDGES)
        .map(|&at| views[at].clone())
        .collect();
    let zhang = homographies::focal_lengths(board, &judges, size);
    let ladder = LADDER.map(|part| [part * size[0]; 2]);
    let candidates = zhang
        .into_iter()
        .chain(ladder)
        .flat_map(|[fx, fy]| lenses(fx, fy, size));
    let judged = candidates.filter_map(|lens| {
        let adjusted = judge(board, &judges, lens, size[0])?;
        Some((adjusted.cost, adjusted.lens))
    });
    let best = judged.min_by(|a, b| a.0.total_cmp(&b.0));
    let (_, lens) = best.ok_or(LensRefusal::Unexplained {
        wrong_percent: 100.0,
    })?;
    let poses = views
        .iter()
        .map(|view| board_pose(board, view, &lens, TOLERANCE * size[0]));
    Ok(Start {
        lens,
        places: board.places(),
        poses: poses.collect(),
    })
}

fn lenses(fx: f64, fy: f64, [width, height]: [f64; 2]) -> impl Iterator<Item = Lens> {
    let numbers = Intrinsics {
        fx,
        fy,
        cx: (width - 1.0) / 2.0,
        cy: (height - 1.0) / 2.0,
    };
    let plain = Lens::brown_conrady(numbers, [0.0; 5]);
    let fisheye = Lens::kannala_brandt(numbers, [0.0; 4]);
    plain.into_iter().chain(fisheye)
}

/// Adjusts the focal lengths and the first distortion coefficient of a candidate in a few steps. A view that it does
/// not explain costs as much as one whose tags are all wrong.
fn judge(board: &Board, judges: &[BoardView], lens: Lens, width: f64) -> Option<Adjustment> {
    let poses: Vec<_> = judges
        .iter()
        .map(|view| board_pose(board, view, &lens, TOLERANCE * width))
        .collect();
    let explained = poses
        .iter()
        .flatten()
        .map(|(_, tags)| tags.len())
        .sum::<usize>();
    let all = judges.iter().map(|view| view.tags.len()).sum::<usize>();
    let mut adjusted = adjust(
        board,
        judges,
        &Start {
            lens,
            places: board.places(),
            poses,
        },
        &Parameters::judging(SIGMA_PX),
    )?;
    let wrong = (all - explained) as f64;
    adjusted.cost += wrong * WRONG_TAG;
    Some(adjusted)
}

/// Cost of an unexplained tag: four corners at the edge of the tolerance under the kernel of [`Parameters::judging`].
const WRONG_TAG: f64 = 4.0 * 40.0;
