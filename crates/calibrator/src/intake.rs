//! From what an image shows to what a procedure can use: tags it looks for, each once, inside the picture, with both poses.

use nalgebra::{Matrix2, Point2};
use sextant_estimator::{Camera, ImageObservation, TagCorners, TagId, tag_poses};
use sextant_geometry::Pose;
use std::collections::BTreeMap;

use crate::bundle::SeenTag;

/// One sigma of a corner whose detector states nothing, pixels. The adjustment measures the noise; this only sets the unit.
pub(crate) const DEFAULT_SIGMA_PX: f64 = 0.1;
/// Added to what the detector states: lens and paper are never better known. Pixels.
pub(crate) const FLOOR_PX: f64 = 0.02;
/// A corner may lie this far outside of the picture (a detector extrapolates edges), pixels.
const BORDER_PX: f64 = 2.0;

/// A tag that a procedure looks for.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Wanted {
    pub tag: TagId,
    pub size_m: f64,
}

/// A tag as an image shows it, with the poses that its four corners allow.
#[derive(Clone, Debug)]
pub(crate) struct TagView {
    /// Index into the wanted tags.
    pub tag: usize,
    /// With covariance.
    pub corners: TagCorners,
    /// `camera_from_tag`, best first; one or two.
    pub branches: Vec<Pose>,
}

/// A usable image.
#[derive(Clone, Debug)]
pub(crate) struct ImageView {
    /// Index into the rig's cameras.
    pub camera: usize,
    /// By the camera's clock.
    pub capture_ns: u64,
    /// At least one.
    pub tags: Vec<TagView>,
}

/// What was passed over in one image.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct PassedOver {
    /// Tags that nobody looks for.
    pub foreign: Vec<TagId>,
    /// Seen more than once in this image.
    pub doubled: Vec<TagId>,
    /// With a corner outside of the picture that the rig states.
    pub outside: Vec<TagId>,
}

/// The usable part of an image.
pub(crate) fn take_in(
    (index, camera): (usize, &Camera),
    wanted: &[Wanted],
    image: &ImageObservation,
) -> (ImageView, PassedOver) {
    let mut over = PassedOver::default();
    let mut count: BTreeMap<TagId, usize> = BTreeMap::new();
    for seen in &image.tags {
        *count.entry(seen.tag).or_default() += 1;
    }
    let mut tags = Vec::new();
    for seen in &image.tags {
        let Some(tag) = wanted.iter().position(|w| w.tag == seen.tag) else {
            over.foreign.push(seen.tag);
            continue;
        };
        if count[&seen.tag] > 1 {
            over.doubled.push(seen.tag);
        } else if !seen.corners.iter().all(|c| is_inside(c, camera.resolution)) {
            over.outside.push(seen.tag);
        } else if let Some(view) = TagView::of(camera, tag, &wanted[tag], seen) {
            tags.push(view);
        }
    }
    over.doubled.dedup();
    tags.sort_by_key(|view| view.tag);
    let view = ImageView {
        camera: index,
        capture_ns: image.capture_ns,
        tags,
    };
    (view, over)
}

fn is_inside(corner: &Point2<f64>, [width, height]: [u32; 2]) -> bool {
    let inside =
        |at: f64, size: u32| (-0.5 - BORDER_PX..=f64::from(size) - 0.5 + BORDER_PX).contains(&at);
    inside(corner.x, width) && inside(corner.y, height)
}

impl TagView {
    fn of(camera: &Camera, tag: usize, wanted: &Wanted, seen: &TagCorners) -> Option<Self> {
        let poses = tag_poses(&camera.lens, &seen.corners, wanted.size_m);
        let branches: Vec<Pose> = poses.iter().map(|p| p.camera_from_tag).collect();
        (!branches.is_empty()).then(|| Self {
            tag,
            corners: seen.clone(),
            branches,
        })
    }

    /// As the adjustment takes it.
    pub(crate) fn seen(&self) -> SeenTag {
        let corners = self.corners.corners;
        let covariance = &self.corners.corner_covariance;
        let stated = covariance.iter().all(|c| *c != Matrix2::zeros());
        stated
            .then(|| SeenTag::with_covariance(self.tag, corners, covariance, FLOOR_PX))
            .flatten()
            .unwrap_or_else(|| SeenTag::with_sigma(self.tag, corners, DEFAULT_SIGMA_PX))
    }
}
