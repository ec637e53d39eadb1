//! One tag from image to image: where it was, and where it should be next.
//!
//! Each corner goes on as far as it went between the last two images that showed it, per image.

use crate::area::Area;
use crate::quad::{Quad, distance, mean_edge, middle};
use crate::{Detection, Image};
use sextant_tag_families::Family;

/// Images without a tag after which it is forgotten.
pub(super) const MOST_MISSED: u32 = 3;

/// How far a tag may move between the first two images that show it, in pixels.
const FIRST_STEP_PX: f32 = 24.0;

/// How far a tag may be from where it should be, in pixels and as a share of its step between images.
const ASIDE_PX: f32 = 4.0;
const ASIDE_SHARE: f32 = 0.5;

/// What must be seen around a tag's border: its ring, as a share of its edge, and the tiles that tell black from white.
const RING_SHARE: f32 = 0.25;
const RING_PX: f32 = 8.0;

/// A tag that was decoded in one of the images before, though not in the last one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Awaited {
    /// The tag's family.
    pub family: Family,
    /// The tag's number within its family.
    pub id: u32,
    /// Where its corners would be, had it gone on as before: a guess, not a measurement.
    pub corners: [[f32; 2]; 4],
    /// Images since it was decoded: 1 to 3.
    pub images_ago: u32,
}

#[derive(Clone, Copy, Debug)]
pub(super) struct Track {
    /// As last decoded, and how many images ago.
    pub(super) tag: Awaited,
    /// Pixels an image, where the tag was decoded more than once.
    velocity: Option<Quad>,
}

impl Track {
    pub(super) fn begin(detection: &Detection) -> Self {
        Self {
            tag: Awaited {
                family: detection.family,
                id: detection.id,
                corners: detection.corners,
                images_ago: 0,
            },
            velocity: None,
        }
    }

    /// Takes up where the tag is now.
    pub(super) fn follow(&mut self, detection: &Detection) {
        let (last, images) = (self.tag.corners, self.tag.images_ago as f32);
        let step = |i: usize, axis: usize| (detection.corners[i][axis] - last[i][axis]) / images;
        *self = Self::begin(detection);
        self.velocity = Some(std::array::from_fn(|i| [step(i, 0), step(i, 1)]));
    }

    /// Where the corners should be so many images after the last that showed the tag.
    fn corners_after(&self, images: u32) -> Quad {
        let step = |i: usize, axis: usize| {
            let velocity = self.velocity.map_or(0.0, |velocity| velocity[i][axis]);
            self.tag.corners[i][axis] + velocity * images as f32
        };
        std::array::from_fn(|i| [step(i, 0), step(i, 1)])
    }

    /// How far the tag may be from where it should be so many images after the last that showed it.
    fn uncertainty_px(&self, images: u32) -> f32 {
        let step = self.velocity.map_or(FIRST_STEP_PX, |velocity| {
            let steps = velocity.iter().map(|[x, y]| x.hypot(*y));
            ASIDE_PX + ASIDE_SHARE * steps.fold(0.0, f32::max)
        });
        step * images as f32
    }

    /// Where to look for the tag in the next image; nothing when it should be outside.
    pub(super) fn region(&self, image: &Image<'_>) -> Option<Area> {
        let images = self.tag.images_ago + 1;
        let corners = self.corners_after(images);
        let around = RING_PX + RING_SHARE * mean_edge(&corners) + self.uncertainty_px(images);
        let bounds = |axis: usize| {
            let places = corners.iter().map(|corner| corner[axis]);
            let low = places.clone().fold(f32::INFINITY, f32::min);
            let high = places.fold(f32::NEG_INFINITY, f32::max);
            [low - around, high + around]
        };
        Area::between(bounds(0), bounds(1), image)
    }

    /// From where the tag should be to a detection that can be of it; nothing when that can't be, or when the tag has been
    /// found in this image already.
    pub(super) fn distance(&self, detection: &Detection) -> Option<f32> {
        let Awaited {
            family,
            id,
            corners,
            images_ago,
        } = self.tag;
        let known = (family, id) == (detection.family, detection.id);
        let distance = distance(middle(&self.corners_after(images_ago)), detection.centre());
        let near = distance <= self.uncertainty_px(images_ago) + mean_edge(&corners) / 2.0;
        (known && images_ago > 0 && near).then_some(distance)
    }

    pub(super) fn awaited(&self) -> Option<Awaited> {
        (self.tag.images_ago > 0).then(|| Awaited {
            corners: self.corners_after(self.tag.images_ago),
            ..self.tag
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Refinement;

    fn seen_at(x: f32, y: f32) -> Detection {
        Detection {
            family: Family::Tag36h11,
            id: 5,
            hamming: 0,
            margin: 50.0,
            corners: [[x, y], [x + 20.0, y], [x + 20.0, y + 20.0], [x, y + 20.0]],
            corner_covariance: [[1e-4, 0.0, 1e-4]; 4],
            refinement: Refinement::Photometric,
        }
    }

    #[test]
    fn a_tag_is_expected_where_it_goes() {
        let mut track = Track::begin(&seen_at(100.0, 50.0));
        track.tag.images_ago = 2;
        track.follow(&seen_at(110.0, 46.0));
        assert_eq!(track.corners_after(3)[0], [125.0, 40.0]);
        assert_eq!(track.awaited(), None);
        track.tag.images_ago = 3;
        assert_eq!(
            track.awaited().map(|tag| (tag.corners[2], tag.images_ago)),
            Some(([145.0, 60.0], 3))
        );
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
        track.tag.images_ago = 1;
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
