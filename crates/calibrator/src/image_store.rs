//! Stored images of a session, and the usable tags of an image: known tags, each once, inside the image, with both
//! poses.

use nalgebra::{Matrix2, Point2, Vector2};
use sextant_geometry::Pose;
use sextant_geometry::planar_pose::tag_poses;
use sextant_site_model::{Camera, ImageObservation, TagCorners, TagId};
use std::collections::BTreeMap;

use crate::verdict::Finding;
use sextant_adjustment::TagObservation;

/// Standard deviation of a corner without a reported one, pixels. The adjustment estimates the noise; this only sets
/// the unit.
pub(crate) const DEFAULT_SIGMA_PX: f64 = 0.1;
/// Added to the reported standard deviation for errors of lens and paper, pixels.
pub(crate) const FLOOR_PX: f64 = 0.02;
/// A corner may lie this far outside the image, since a detector extrapolates edges, pixels.
const BORDER_PX: f64 = 2.0;

/// A tag that a procedure uses.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct TagSpec {
    pub tag: TagId,
    pub size_m: f64,
}

/// A tag in an image, with the poses that its four corners allow.
#[derive(Clone, Debug)]
pub(crate) struct TagView {
    /// Index into the tags of the procedure.
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

/// The ignored tags of one image.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct IgnoredTags {
    /// Tags that the procedure does not use.
    pub foreign: Vec<TagId>,
    /// Tags that appear more than once.
    pub doubled: Vec<TagId>,
    /// Tags with their centre outside the resolution in the rig, which is therefore wrong.
    pub outside: Vec<TagId>,
}

/// A bounded store of images. When it is full, it drops every second stretch of time and halves its rate, so that the
/// stored images cover the whole session and simultaneous images stay together.
#[derive(Clone, Debug)]
pub(crate) struct ImageStore {
    images: Vec<ImageObservation>,
    most: usize,
    n_received: usize,
    /// One in this many stretches is stored.
    every: u64,
}

/// Length of a stretch of time, ns: long enough for successive images, short enough to miss no motion.
const STRETCH_NS: u64 = 500_000_000;

impl ImageStore {
    pub(crate) fn at_most(most: usize) -> Self {
        Self {
            images: Vec::new(),
            most,
            n_received: 0,
            every: 1,
        }
    }

    pub(crate) fn push(&mut self, image: &ImageObservation) {
        self.n_received += 1;
        if !is_kept(image, self.every) {
            return;
        }
        self.images.push(image.clone());
        if self.images.len() > self.most {
            self.thin();
        }
    }

    fn thin(&mut self) {
        let every = self.every.saturating_mul(2);
        if self.images.iter().any(|image| !is_kept(image, every)) {
            self.every = every;
            self.images.retain(|image| is_kept(image, every));
        }
        // Images of a single stretch cannot be thinned; the newest are dropped.
        self.images.truncate(self.most);
    }

    /// Number of images received, stored or not.
    pub(crate) fn n_received(&self) -> usize {
        self.n_received
    }

    /// A finding where more images came than are stored.
    pub(crate) fn thinned(&self) -> Option<Finding> {
        let (stored, received) = (self.images.len(), self.n_received);
        (stored < received).then_some(Finding::Thinned { stored, received })
    }

    pub(crate) fn iter(&self) -> impl Iterator<Item = &ImageObservation> {
        self.images.iter()
    }
}

fn is_kept(image: &ImageObservation, every: u64) -> bool {
    (image.capture_ns / STRETCH_NS).is_multiple_of(every)
}

/// The usable part of an image.
pub(crate) fn take_in(
    index: usize,
    camera: &Camera,
    wanted: &[TagSpec],
    image: &ImageObservation,
) -> (ImageView, IgnoredTags) {
    let mut over = IgnoredTags::default();
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
        } else if !is_inside(&centre(seen), camera.resolution) {
            over.outside.push(seen.tag);
        } else if !seen.corners.iter().all(|c| is_inside(c, camera.resolution)) {
            // Cut off by the edge of the image: corners outside are extrapolated.
        } else if let Some(view) = TagView::from_corners(camera, tag, &wanted[tag], seen) {
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

fn centre(seen: &TagCorners) -> Point2<f64> {
    let sum = seen
        .corners
        .iter()
        .fold(Vector2::zeros(), |sum, c| sum + c.coords);
    Point2::from(sum / 4.0)
}

fn is_inside(corner: &Point2<f64>, [width, height]: [u32; 2]) -> bool {
    let inside =
        |at: f64, size: u32| (-0.5 - BORDER_PX..=f64::from(size) - 0.5 + BORDER_PX).contains(&at);
    inside(corner.x, width) && inside(corner.y, height)
}

impl TagView {
    fn from_corners(
        camera: &Camera,
        tag: usize,
        wanted: &TagSpec,
        seen: &TagCorners,
    ) -> Option<Self> {
        let poses = tag_poses(&camera.lens, &seen.corners, wanted.size_m);
        let branches: Vec<Pose> = poses.iter().map(|p| p.camera_from_tag).collect();
        (!branches.is_empty()).then(|| Self {
            tag,
            corners: seen.clone(),
            branches,
        })
    }

    /// As the input of an adjustment.
    pub(crate) fn seen(&self) -> TagObservation {
        let corners = self.corners.corners;
        let covariance = &self.corners.corner_covariance;
        let stated = covariance.iter().all(|c| *c != Matrix2::zeros());
        stated
            .then(|| TagObservation::with_covariance(self.tag, corners, covariance, FLOOR_PX))
            .flatten()
            .unwrap_or_else(|| TagObservation::with_sigma(self.tag, corners, DEFAULT_SIGMA_PX))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use sextant_site_model::CameraId;

    fn at(camera: &str, ms: u64) -> ImageObservation {
        ImageObservation {
            camera: CameraId::new(camera).unwrap(),
            capture_ns: ms * 1_000_000,
            clock_error_ns: 0,
            exposure_ns: 0,
            resolution: None,
            tags: Vec::new(),
        }
    }

    #[test]
    fn what_is_kept_lies_all_over_and_together() {
        let mut kept = ImageStore::at_most(100);
        for ms in (0..60_000).step_by(100) {
            kept.push(&at("a", ms));
            kept.push(&at("b", ms));
        }
        assert_eq!(kept.n_received(), 1200);
        let said = kept.thinned().unwrap().to_string();
        let stored = kept.iter().count();
        assert!(
            said.starts_with(&format!("{stored} of 1200 images were used")),
            "{said}"
        );
        let of = |name: &str| -> Vec<u64> {
            let own = kept.iter().filter(|i| i.camera.as_str() == name);
            own.map(|i| i.capture_ns / 1_000_000).collect()
        };
        assert_eq!(of("a"), of("b"));
        let times = of("a");
        assert!((25..=50).contains(&times.len()), "{}", times.len());
        assert!(
            times[0] == 0 && times[times.len() - 1] > 50_000,
            "{times:?}"
        );
    }

    #[test]
    fn a_burst_does_not_shut_out_what_comes_later() {
        let mut kept = ImageStore::at_most(10);
        (0..100).for_each(|_| kept.push(&at("a", 1_000_005)));
        for ms in (2_000_000..2_060_000).step_by(500) {
            kept.push(&at("a", ms));
        }
        let late = kept.iter().filter(|i| i.capture_ns > 2_000_000_000_000);
        assert!(late.count() > 1);
    }

    #[test]
    fn images_of_one_moment_do_not_pile_up() {
        let mut kept = ImageStore::at_most(10);
        (0..1000).for_each(|_| kept.push(&at("a", 5)));
        assert_eq!(kept.iter().count(), 10);
    }
}
