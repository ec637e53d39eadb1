//! Track of one tag: last position, velocity, and predicted position.
//!
//! Each corner moves with the constant velocity between the last two images in which the tag was detected.

use crate::area::Area;
use crate::quad::{Quad, distance, mean_edge, middle};
use crate::{Detection, Image};

/// Images without the tag after which its track ends.
pub(super) const MOST_MISSED: u32 = 3;

/// Largest motion of a tag between the first two images with it, in pixels.
const FIRST_STEP_PX: f32 = 24.0;

/// Largest distance of a tag from its prediction, in pixels and as a share of its motion between images.
const ASIDE_PX: f32 = 4.0;
const ASIDE_SHARE: f32 = 0.5;

/// Margin that must be visible around a tag's border: its ring, as a share of its edge, and the tiles that separate
/// black from white.
const RING_SHARE: f32 = 0.25;
const RING_PX: f32 = 8.0;

#[derive(Clone, Copy, Debug)]
pub(super) struct Track {
    /// Last detection, and its age in images.
    tag: Detection,
    pub(super) images_ago: u32,
    /// Velocity of each corner, in pixels per image.
    velocity: Quad,
    /// Growth of the prediction's uncertainty, in pixels per image.
    aside_px: f32,
}

impl Track {
    pub(super) fn begin(tag: &Detection) -> Self {
        Self {
            tag: *tag,
            images_ago: 0,
            velocity: [[0.0; 2]; 4],
            aside_px: FIRST_STEP_PX,
        }
    }

    /// Updates the track with a detection.
    pub(super) fn follow(&mut self, tag: &Detection) {
        let (last, images) = (&self.tag.corners, self.images_ago as f32);
        let step = |i: usize, axis: usize| (tag.corners[i][axis] - last[i][axis]) / images;
        let velocity: Quad = std::array::from_fn(|i| [step(i, 0), step(i, 1)]);
        let steps = velocity.iter().map(|[x, y]| x.hypot(*y));
        *self = Self {
            velocity,
            aside_px: ASIDE_PX + ASIDE_SHARE * steps.fold(0.0, f32::max),
            ..Self::begin(tag)
        };
    }

    /// Predicted corners this many images after the last detection.
    fn corners_after(&self, images: u32) -> Quad {
        let (last, velocity) = (&self.tag.corners, &self.velocity);
        let place = |i: usize, axis: usize| last[i][axis] + velocity[i][axis] * images as f32;
        std::array::from_fn(|i| [place(i, 0), place(i, 1)])
    }

    /// Search area in the next image; `None` if the tag is predicted outside.
    pub(super) fn region(&self, image: &Image<'_>) -> Option<Area> {
        let images = self.images_ago + 1;
        let corners = self.corners_after(images);
        let around = RING_PX + RING_SHARE * mean_edge(&corners) + self.aside_px * images as f32;
        let bounds = |axis: usize| {
            let places = corners.iter().map(|corner| corner[axis]);
            let low = places.clone().fold(f32::INFINITY, f32::min);
            let high = places.fold(f32::NEG_INFINITY, f32::max);
            [low - around, high + around]
        };
        Area::enclosing(bounds(0), bounds(1), image)
    }

    /// Distance from the prediction to a detection that may be the tag; `None` if it cannot be, or if the tag was
    /// already found in this image.
    pub(super) fn distance(&self, detection: &Detection) -> Option<f32> {
        let known = (self.tag.family, self.tag.id) == (detection.family, detection.id);
        let expected = middle(&self.corners_after(self.images_ago));
        let distance = distance(expected, detection.centre());
        let aside_px = self.aside_px * self.images_ago as f32;
        let near = distance <= aside_px + mean_edge(&self.tag.corners) / 2.0;
        (known && self.images_ago > 0 && near).then_some(distance)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Refinement;
    use sextant_tag_families::Family;

    fn seen_at(x: f32, y: f32) -> Detection {
        Detection {
            family: Family::Tag36h11,
            id: 5,
            hamming: 0,
            margin: 50.0,
            corners: [[x, y], [x + 20.0, y], [x + 20.0, y + 20.0], [x, y + 20.0]],
            corner_covariance: [[1e-4, 0.0, 1e-4]; 4],
            corner_cross_covariance: [[0.0; 4]; 6],
            refinement: Refinement::Photometric,
        }
    }

    #[test]
    fn a_tag_is_expected_where_it_goes() {
        let mut track = Track::begin(&seen_at(100.0, 50.0));
        track.images_ago = 2;
        track.follow(&seen_at(110.0, 46.0));
        assert_eq!(track.corners_after(3)[0], [125.0, 40.0]);
        assert_eq!(track.corners_after(3)[2], [145.0, 60.0]);
    }

    #[test]
    fn a_region_lies_in_the_image_on_whole_tiles() {
        let pixels = [0; 64 * 48];
        let image = Image::new(&pixels, 64, 48, 64).unwrap();
        for (x, y) in [(0.0, 0.0), (50.0, 40.0), (-19.0, 30.0), (20.0, 20.0)] {
            let region = Track::begin(&seen_at(x, y)).region(&image).unwrap();
            assert_eq!((region.left % 4, region.top % 4), (0, 0));
            assert!(region.left + region.width <= 64 && region.top + region.height <= 48);
            assert!(region.width >= 16 && region.height >= 16, "{region:?}");
        }
        assert_eq!(Track::begin(&seen_at(200.0, 0.0)).region(&image), None);
        assert_eq!(
            Track::begin(&seen_at(f32::MAX, f32::MIN)).region(&image),
            None
        );
    }

    #[test]
    fn another_tag_or_one_far_off_is_not_it() {
        let mut track = Track::begin(&seen_at(100.0, 50.0));
        assert_eq!(track.distance(&seen_at(100.0, 50.0)), None);
        track.images_ago = 1;
        assert_eq!(track.distance(&seen_at(124.0, 50.0)), Some(24.0));
        assert_eq!(track.distance(&seen_at(160.0, 50.0)), None);
        assert_eq!(
            track.distance(&Detection {
                id: 6,
                ..seen_at(100.0, 50.0)
            }),
            None
        );
    }
}
