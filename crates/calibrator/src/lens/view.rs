//! What one image shows of the board, and what is left out of it from the start.

use super::board::Board;
use super::refusal::LensRefusal;
use nalgebra::Point2;
use sextant_estimator::{ImageObservation, TagCorners, TagId};
use std::collections::BTreeMap;

/// The corners' noise where nobody states it, pixels.
const USUAL_SIGMA_PX: f64 = 0.1;
/// Stated noise is believed between these.
const SIGMA_PX: std::ops::RangeInclusive<f64> = 0.03..=2.0;
/// Corners may lie this far outside of the picture: half a pixel of its edge and some noise.
const OUTSIDE_PX: f64 = 2.0;

/// A tag of the board in an image.
#[derive(Clone, Debug)]
pub(super) struct ViewTag {
    /// Index into the board's tags.
    pub tag: usize,
    pub corners: [Point2<f64>; 4],
    pub sigma_px: f64,
}

/// An image of the board.
#[derive(Clone, Debug)]
pub(super) struct View {
    pub tags: Vec<ViewTag>,
}

/// An image sorted out: the board's tags, those that appear twice, and those that are no part of the board.
pub(super) struct Sorted {
    pub view: View,
    pub twice: Vec<TagId>,
    pub foreign: Vec<TagId>,
}

impl Sorted {
    /// # Errors
    /// Corners outside of the picture: it has another resolution.
    pub(super) fn of(
        board: &Board,
        resolution: [u32; 2],
        image: &ImageObservation,
    ) -> Result<Self, LensRefusal> {
        let mut count = BTreeMap::new();
        for tag in &image.tags {
            check_inside(resolution, tag)?;
            *count.entry(tag.tag).or_insert(0_u32) += 1;
        }
        let mut sorted = Self {
            view: View { tags: Vec::new() },
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
                Some(tag) => sorted.view.tags.push(ViewTag {
                    tag,
                    corners: seen.corners,
                    sigma_px: sigma_of(seen),
                }),
                None => sorted.foreign.push(seen.tag),
            }
        }
        sorted.view.tags.sort_by_key(|tag| tag.tag);
        Ok(sorted)
    }
}

fn check_inside([width, height]: [u32; 2], tag: &TagCorners) -> Result<(), LensRefusal> {
    let inside = |x: f64, end: u32| (-OUTSIDE_PX..=f64::from(end) + OUTSIDE_PX).contains(&x);
    let outside = tag
        .corners
        .iter()
        .find(|corner| !inside(corner.x, width) || !inside(corner.y, height));
    match outside {
        Some(corner) => Err(LensRefusal::Resolution {
            x: corner.x,
            y: corner.y,
            width,
            height,
        }),
        None => Ok(()),
    }
}

fn sigma_of(tag: &TagCorners) -> f64 {
    let variance = tag.corner_covariance.iter().map(|c| c.trace()).sum::<f64>() / 8.0;
    if variance > 0.0 {
        variance.sqrt().clamp(*SIGMA_PX.start(), *SIGMA_PX.end())
    } else {
        USUAL_SIGMA_PX
    }
}

impl View {
    pub(super) fn corners(&self) -> impl Iterator<Item = &Point2<f64>> {
        self.tags.iter().flat_map(|tag| &tag.corners)
    }

    /// Centroid and spread (root mean square distance from it) of the corners, pixels.
    pub(super) fn extent(&self) -> (Point2<f64>, f64) {
        let n = (4 * self.tags.len()).max(1) as f64;
        let centre = self
            .corners()
            .map(|p| p.coords)
            .sum::<nalgebra::Vector2<f64>>()
            / n;
        let square = self.corners().map(|p| (p.coords - centre).norm_squared());
        (centre.into(), (square.sum::<f64>() / n).sqrt())
    }
}
