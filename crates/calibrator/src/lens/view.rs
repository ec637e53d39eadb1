//! A view of the board: its usable tags in one image.

use super::board::Board;
use super::refusal::LensRefusal;
use nalgebra::{Point2, Vector2};
use sextant_site_model::{ImageObservation, TagCorners, TagId};
use std::collections::BTreeMap;

/// Default corner noise, pixels.
const USUAL_SIGMA_PX: f64 = 0.1;
/// Range of accepted corner noise, pixels.
const SIGMA_PX: std::ops::RangeInclusive<f64> = 0.03..=2.0;
/// Corners may lie this far outside of the picture: half a pixel of its edge and some noise.
const OUTSIDE_PX: f64 = 2.0;

/// A tag of the board in an image.
#[derive(Clone, Debug)]
pub(super) struct ViewTag {
    /// Index into the board's tags.
    pub tag: usize,
    pub corners: [Point2<f64>; 4],
    /// Infinite for corners that the image does not show.
    pub sigmas_px: [f64; 4],
}

/// An image of the board.
#[derive(Clone, Debug)]
pub(super) struct BoardView {
    pub tags: Vec<ViewTag>,
}

/// The tags of an image: those of the board, duplicates, and others.
pub(super) struct SortedView {
    pub view: BoardView,
    pub twice: Vec<TagId>,
    pub foreign: Vec<TagId>,
}

impl SortedView {
    /// # Errors
    /// A tag outside of the picture: it has another resolution.
    pub(super) fn from_image(
        board: &Board,
        resolution: [u32; 2],
        image: &ImageObservation,
    ) -> Result<Self, LensRefusal> {
        let mut count = BTreeMap::new();
        for tag in &image.tags {
            check_centre(resolution, tag)?;
            *count.entry(tag.tag).or_insert(0_u32) += 1;
        }
        let mut sorted = Self {
            view: BoardView { tags: Vec::new() },
            twice: count
                .iter()
                .filter(|(_, n)| **n > 1)
                .map(|(tag, _)| *tag)
                .collect(),
            foreign: Vec::new(),
        };
        for seen in &image.tags {
            match board.position(seen.tag) {
                Some(_) if sorted.twice.contains(&seen.tag) => {}
                // Cut off by the picture's edge: what lies outside was guessed.
                Some(_) if !seen.corners.iter().all(|c| is_inside(resolution, c)) => {}
                Some(tag) => sorted.view.tags.push(ViewTag {
                    tag,
                    corners: seen.corners,
                    sigmas_px: sigmas_of(seen),
                }),
                None => sorted.foreign.push(seen.tag),
            }
        }
        sorted.view.tags.sort_by_key(|tag| tag.tag);
        Ok(sorted)
    }
}

fn is_inside([width, height]: [u32; 2], at: &Point2<f64>) -> bool {
    let inside = |x: f64, end: u32| (-OUTSIDE_PX..=f64::from(end) + OUTSIDE_PX).contains(&x);
    inside(at.x, width) && inside(at.y, height)
}

/// Whether the centre of a tag is inside the image.
fn check_centre(resolution: [u32; 2], tag: &TagCorners) -> Result<(), LensRefusal> {
    let sum = tag
        .corners
        .iter()
        .fold(Vector2::zeros(), |sum, c| sum + c.coords);
    let centre = Point2::from(sum / 4.0);
    if is_inside(resolution, &centre) {
        return Ok(());
    }
    let [width, height] = resolution;
    Err(LensRefusal::Resolution {
        x: centre.x,
        y: centre.y,
        width,
        height,
    })
}

/// The corners that an image shows. A corner of a board's tag that is no saddle point there, at the board's rim or
/// behind something, is extrapolated from the rest of the tag through a lens that is not known yet: it must not count.
fn shown_corners(seen: &TagCorners) -> [bool; 4] {
    /// Variance of a corner in terms of its tag's best one from which it was extrapolated.
    const EXTRAPOLATED: f64 = 25.0;
    let variances = seen.corner_covariance.map(|covariance| covariance.trace());
    let best = variances.iter().copied().fold(f64::INFINITY, f64::min);
    let of_board = seen.tag.family.data().board.is_some();
    variances.map(|variance| !of_board || variance <= EXTRAPOLATED * best)
}

/// One sigma for all corners that show: those of a tag share most of what causes it.
fn sigmas_of(tag: &TagCorners) -> [f64; 4] {
    let shown = shown_corners(tag);
    let of_shown = tag.corner_covariance.iter().zip(shown);
    let sum: f64 = of_shown
        .filter(|(_, shows)| *shows)
        .map(|(covariance, _)| covariance.trace())
        .sum();
    let n = shown.into_iter().filter(|shows| *shows).count();
    let variance = sum / (2 * n.max(1)) as f64;
    let sigma = if variance > 0.0 {
        variance.sqrt().clamp(*SIGMA_PX.start(), *SIGMA_PX.end())
    } else {
        USUAL_SIGMA_PX
    };
    shown.map(|shows| if shows { sigma } else { f64::INFINITY })
}

impl BoardView {
    pub(super) fn corners(&self) -> impl Iterator<Item = &Point2<f64>> {
        self.tags.iter().flat_map(|tag| &tag.corners)
    }

    /// Centroid and spread (root mean square distance from it) of the corners, pixels.
    pub(super) fn extent(&self) -> (Point2<f64>, f64) {
        let n = (4 * self.tags.len()).max(1) as f64;
        let centre = self.corners().map(|p| p.coords).sum::<Vector2<f64>>() / n;
        let square = self.corners().map(|p| (p.coords - centre).norm_squared());
        (centre.into(), (square.sum::<f64>() / n).sqrt())
    }
}
