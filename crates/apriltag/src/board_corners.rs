//! Corners of tags on calibration boards: saddle points between black and white squares.
//!
//! Input: an image and a tag with corners from its pattern or its edges. Output: the corners that its family defines,
//! from saddle points where these are visible, otherwise extrapolated from the tag with a larger covariance.

use crate::Image;
use crate::detection::Detection;
use crate::homography::{Homography, POINTS, Points};
use crate::kernels::sample;
use crate::quad::{Point, Quad, distance, mean_edge, widths};
use crate::reading::Reading;
use crate::saddle::{self, Guess, RADIUS_PX, Saddle};
use sextant_tag_families::Board;

/// Standard deviation of a corner without a visible saddle point, in pixels and as a share of the edge: spreading ink
/// and glare move the edges of a tag, and lens distortion adds to the extrapolation.
const UNSEEN_PX: f32 = 0.2;
const UNSEEN_SHARE: f32 = 0.01;

/// A white square with fewer saddle points than this may be one of a board whose black squares do not touch, as print,
/// glare or sharpening leave them.
const LEAST_TOUCHING: usize = 2;
/// Distances of black squares from the edges of such a board, as shares of a square's edge.
const GAPS: [f32; 5] = [0.01, 0.02, 0.03, 0.042, 0.055];

/// Corners of different squares closer than this are the same corner, in pixels.
const ONE_PX: f32 = 1.0;

/// How the corners of a tag became those that its family defines.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum BoardFit {
    /// They are its own, or saddle points.
    Found,
    /// A marker of a ChArUco board in a white square, with as many saddle points at its corners; half the edge of the
    /// square in half edges of the marker.
    Square { reach: f32, n_saddles: usize },
    /// A marker of a ChArUco board without a white square around it.
    Marker,
    /// It is no tag of the family.
    None,
}

/// Replaces the corners of a tag by those that its family defines, as far as the picture shows them.
pub(crate) fn refine(image: &Image<'_>, reading: &Reading, tag: &mut Detection) -> BoardFit {
    match tag.family.data().board {
        // Squares of a plain chessboard have no code, so that no detection is one.
        None | Some(Board::Chessboard) => BoardFit::Found,
        Some(Board::Aprilgrid) => {
            let module = 2.0 / f32::from(tag.family.data().border_width);
            // A border of two modules lies within a corner, a square of two and more beyond it. What hides a corner
            // spoils the edges' fit, too, which wrong bits tell.
            match take_saddles(image, reading, tag, 1.0, 1.6 * module) {
                0..4 if tag.hamming > 0 => BoardFit::None,
                _ => BoardFit::Found,
            }
        }
        Some(Board::Charuco) => match square_around(image, reading, &tag.corners) {
            Some(reach) => BoardFit::Square {
                reach,
                n_saddles: take_saddles(image, reading, tag, reach, reach - 1.0),
            },
            None => BoardFit::Marker,
        },
    }
}

/// Makes the corners of a marker without saddle points those of its white square, from the marker alone.
pub(crate) fn extrapolate(tag: &mut Detection, reach: f32) {
    if let Some(map) = Homography::square_to_quad(&tag.corners) {
        let expected = corners_at(&map, reach);
        move_corners(tag, &expected, &[None; 4], reach);
    }
}

/// Half the edge of the squares of a board, in half edges of a marker, as most of those around its markers have it.
pub(crate) fn common_reach(fits: impl Iterator<Item = BoardFit> + Clone) -> Option<f32> {
    const MOST_APART: f32 = 0.05;
    let reaches = fits.filter_map(|fit| match fit {
        BoardFit::Square { reach, .. } => Some(reach),
        _ => None,
    });
    let agreeing = |reach: f32| {
        let near = move |other: &f32| (other - reach).abs() < MOST_APART * reach;
        reaches.clone().filter(near)
    };
    let most = reaches
        .clone()
        .max_by_key(|reach| agreeing(*reach).count())?;
    let (n, sum) = agreeing(most).fold((0, 0.0), |(n, sum), reach| (n + 1, sum + reach));
    Some(sum / n as f32)
}

/// Whether two squares touch with opposite corners, as white ones of a board do. White ends around other markers, too,
/// but these squares would overlap.
pub(crate) fn touch(a: &Quad, b: &Quad) -> bool {
    const APART_PX: f32 = 1.5;
    const APART_SHARE: f32 = 0.05;
    let apart = APART_PX.max(APART_SHARE * mean_edge(a));
    (0..4).any(|corner| distance(a[corner], b[(corner + 2) % 4]) < apart)
}

/// Half the edge of the white square around a marker, in half edges of the marker: where white ends on most sides.
fn square_around(image: &Image<'_>, reading: &Reading, marker: &Quad) -> Option<f32> {
    /// Shares of a marker's half edge at which a white square may end.
    const NEAREST: f32 = 1.05;
    const FARTHEST: f32 = 2.4;
    const STEP: f32 = 0.05;
    const STEPS: usize = ((FARTHEST - NEAREST) / STEP) as usize;
    /// Two places on each side: how far along it, as a share of its half.
    const ASIDE: f32 = 0.3;
    const MOST_APART: f32 = 0.06;
    let map = Homography::square_to_quad(marker)?;
    let aside: Points = std::array::from_fn(|i| if i % 2 == 0 { ASIDE } else { -ASIDE });
    let places: [[Points; 2]; STEPS] = std::array::from_fn(|step| {
        let away = NEAREST + step as f32 * STEP;
        let at = |i: usize| match i / 2 {
            0 => [aside[i], -away],
            1 => [away, aside[i]],
            2 => [aside[i], away],
            _ => [-away, aside[i]],
        };
        [0, 1].map(|axis| std::array::from_fn(|i| at(i)[axis]))
    });
    let mut greys = [[0.0; POINTS]; STEPS];
    sample(image, &map, &places, greys.as_flattened_mut());
    let middle = (reading.black + reading.white) / 2.0;
    let end = |i: usize| {
        let white = (0..STEPS).find(|&step| greys[step][i] > middle)?;
        let step = (white..STEPS).find(|&step| greys[step][i] <= middle)?;
        let (last, first) = (greys[step - 1][i], greys[step][i]);
        let share = (last - middle) / (last - first);
        share
            .is_finite()
            .then_some(NEAREST + STEP * (step as f32 - 1.0 + share))
    };
    let ends: [Option<f32>; POINTS] = std::array::from_fn(end);
    let agreeing = |end: f32| {
        let near = move |other: &f32| (other - end).abs() <= MOST_APART * end;
        ends.into_iter().flatten().filter(near)
    };
    let most = ends
        .into_iter()
        .flatten()
        .max_by_key(|&end| agreeing(end).count())?;
    let n = agreeing(most).count();
    (n >= 2).then(|| agreeing(most).sum::<f32>() / n as f32)
}

/// Moves each corner to this many half edges from the centre of the tag and then to the saddle point there, if nothing
/// else is visible around it. Returns the number of saddle points; without any, all corners stay.
fn take_saddles(
    image: &Image<'_>,
    reading: &Reading,
    tag: &mut Detection,
    reach: f32,
    clear: f32,
) -> usize {
    let Some(map) = Homography::square_to_quad(&tag.corners) else {
        return 0;
    };
    let [least, most] = RADIUS_PX;
    let [width, height] = widths(&tag.corners);
    let radius_px = (clear * width.min(height) / 2.0).clamp(least, most);
    let step = reading.white - reading.black;
    let is_white = reach > 1.0;
    let expected = corners_at(&map, reach);
    let guesses = expected.map(|(place, along)| Guess {
        place,
        edges: along.map(|[x, y]| [x - place[0], y - place[1]]),
        step: if is_white { step } else { -step },
        radius_px,
        gap_px: 0.0,
    });
    let mut saddles = guesses.map(|guess| saddle::find(image, &guess));
    if is_white && saddles.iter().flatten().count() < LEAST_TOUCHING {
        let edge_px = reach * mean_edge(&tag.corners);
        for (saddle, guess) in saddles.iter_mut().zip(guesses) {
            *saddle = saddle.or_else(|| find_gapped(image, &guess, edge_px));
        }
    }
    let n = saddles.iter().flatten().count();
    if n > 0 {
        move_corners(tag, &expected, &saddles, reach);
    }
    n
}

/// Corners of a square with this half edge, in half edges of the tag, and a point beside each along either side.
fn corners_at(map: &Homography, reach: f32) -> [(Point, [Point; 2]); 4] {
    [[-1, -1], [1, -1], [1, 1], [-1, 1]].map(|corner| {
        let [u, v] = corner.map(|sign: i8| reach * f32::from(sign));
        (
            map.apply(u, v),
            [map.apply(0.9 * u, v), map.apply(u, 0.9 * v)],
        )
    })
}

/// Moves the corners of a tag to saddle points, and without these to where they are expected.
fn move_corners(
    tag: &mut Detection,
    expected: &[(Point, [Point; 2]); 4],
    saddles: &[Option<Saddle>; 4],
    reach: f32,
) {
    let unseen = (UNSEEN_PX + UNSEEN_SHARE * mean_edge(&tag.corners)).powi(2);
    for (corner, saddle) in saddles.iter().enumerate() {
        let covariance = &mut tag.corner_covariance[corner];
        (tag.corners[corner], *covariance) = match saddle {
            Some(saddle) => (saddle.place, saddle.covariance),
            None => {
                let [xx, xy, yy] = covariance.map(|own| own * reach * reach);
                (expected[corner].0, [xx + unseen, xy, yy + unseen])
            }
        };
    }
    tag.corner_cross_covariance = Default::default();
}

/// The saddle point where black squares do not touch: that of the gap which explains the image best.
fn find_gapped(image: &Image<'_>, guess: &Guess, edge_px: f32) -> Option<Saddle> {
    let found = GAPS.into_iter().filter_map(|gap| {
        let gap_px = gap * edge_px;
        saddle::find(image, &Guess { gap_px, ..*guess })
    });
    let variance = |saddle: &Saddle| saddle.covariance[0] + saddle.covariance[2];
    found.min_by(|a, b| variance(a).total_cmp(&variance(b)))
}

/// A chessboard corner belongs to two white squares. Each reports it with half of the information, so that it counts
/// once.
pub(crate) fn share_corners(tags: &mut [Detection]) {
    let is_square = |tag: &Detection| tag.family.data().board == Some(Board::Charuco);
    for i in 0..tags.len() {
        for corner in 0..4 {
            let here = tags[i].corners[corner];
            let others = tags[..i].iter().chain(&tags[i + 1..]);
            let squares = others.filter(|tag| is_square(tag));
            let same = squares.flat_map(|tag| tag.corners);
            let n = same.filter(|other| distance(*other, here) < ONE_PX).count();
            if is_square(&tags[i]) && n > 0 {
                let times = (n + 1) as f32;
                tags[i].corner_covariance[corner] =
                    tags[i].corner_covariance[corner].map(|value| times * value);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Refinement;
    use sextant_tag_families::Family;

    fn square(family: Family, x: f32) -> Detection {
        Detection {
            family,
            id: 5,
            hamming: 0,
            margin: 50.0,
            corners: [[x, 20.0], [x + 20.0, 20.0], [x + 20.0, 40.0], [x, 40.0]],
            corner_covariance: [[1e-4, 2e-5, 3e-4]; 4],
            corner_cross_covariance: [[0.0; 4]; 6],
            refinement: Refinement::Photometric,
        }
    }

    #[test]
    fn what_two_squares_say_of_their_corner_is_said_once() {
        let mut tags = [
            square(Family::Charuco4x4With50, 20.0),
            square(Family::Charuco4x4With50, 40.3),
            square(Family::Tag36h11, 40.0),
        ];
        tags[1].corners[3] = [40.2, 60.0];
        share_corners(&mut tags);
        let is_shared = |tag: usize, corner: usize| {
            let times = tags[tag].corner_covariance[corner][0] / 1e-4;
            (times - 1.0).abs() > 1e-3
        };
        let shared = [0, 1, 2].map(|tag| [0, 1, 2, 3].map(|corner| is_shared(tag, corner)));
        let expected = [
            [false, true, false, false],
            [true, false, false, false],
            [false; 4],
        ];
        assert_eq!(shared, expected);
        assert_eq!(tags[0].corner_covariance[1], [2e-4, 4e-5, 6e-4]);
    }
}
