//! Cameras whose pictures stand still.
//!
//! No two pictures of a camera are equal: noise moves every corner by some hundredths of a pixel. Corners that are
//! equal to the last digit, image by image, are those of one picture that a driver or a program delivers again and
//! again.

use std::collections::BTreeMap;

use sextant_site_model::{ImageObservation, TagCorners};

/// After so long without an image a camera is not there any more, ns.
const GONE_NS: u64 = 2_000_000_000;
/// Seconds and images for which a picture must stand still.
const STILL_S: f64 = 0.3;
const STILL_IMAGES: u32 = 5;

/// What the last images of each camera showed.
#[derive(Debug, Default)]
pub(crate) struct FrozenCameras {
    /// By camera index.
    cameras: BTreeMap<usize, LastPicture>,
}

#[derive(Debug, Default)]
struct LastPicture {
    tags: Vec<TagCorners>,
    since_ns: u64,
    last_ns: u64,
    images: u32,
}

impl LastPicture {
    fn still_s(&self) -> f64 {
        self.last_ns.saturating_sub(self.since_ns) as f64 * 1e-9
    }

    fn is_frozen(&self) -> bool {
        !self.tags.is_empty() && self.images >= STILL_IMAGES && self.still_s() >= STILL_S
    }
}

impl FrozenCameras {
    /// Takes an image in that arrived at `now_ns`.
    pub fn record(&mut self, camera_index: usize, now_ns: u64, image: &ImageObservation) {
        let last = self.cameras.entry(camera_index).or_default();
        last.last_ns = now_ns;
        if last.tags == image.tags {
            last.images = last.images.saturating_add(1);
        } else {
            last.tags.clone_from(&image.tags);
            (last.since_ns, last.images) = (now_ns, 1);
        }
    }

    /// Whether the pictures of a camera stand still while another's do not: then they show what is no more. Where all
    /// stand still, somebody shows a picture.
    pub fn is_left_behind(&self, camera_index: usize, now_ns: u64) -> bool {
        let is_frozen = |index: usize| self.cameras.get(&index).is_some_and(LastPicture::is_frozen);
        let is_there = |last: &LastPicture| last.last_ns.saturating_add(GONE_NS) >= now_ns;
        let lives = |last: &LastPicture| !last.tags.is_empty() && !last.is_frozen();
        let mut others = self.cameras.values();
        is_frozen(camera_index) && others.any(|last| is_there(last) && lives(last))
    }

    /// The cameras whose pictures stand still, by index, and for how long, s.
    pub fn frozen(&self) -> impl Iterator<Item = (usize, f64)> {
        let frozen = self.cameras.iter().filter(|(_, last)| last.is_frozen());
        frozen.map(|(camera, last)| (*camera, last.still_s()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{Matrix2, Point2};
    use sextant_site_model::{CameraId, TagId};
    use sextant_tag_families::Family;

    fn image(x: f64) -> ImageObservation {
        let corners = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)];
        let tag = TagId {
            family: Family::Tag36h11,
            id: 0,
        };
        ImageObservation {
            camera: CameraId::new("north").unwrap(),
            capture_ns: 0,
            clock_error_ns: 0,
            exposure_ns: 0,
            resolution: None,
            tags: vec![TagCorners {
                tag,
                corners: corners.map(|(a, b)| Point2::new(x + 20.0 * a, 20.0 * b)),
                corner_covariance: [Matrix2::zeros(); 4],
                corner_cross_covariance: [Matrix2::zeros(); 6],
            }],
        }
    }

    #[test]
    fn a_picture_that_stands_still_while_others_move_is_left_behind() {
        let mut cameras = FrozenCameras::default();
        for n in 0..40_u64 {
            let now_ns = n * 33_000_000;
            cameras.record(0, now_ns, &image(100.0));
            assert!(n > 9 || cameras.frozen().next().is_none());
            assert!(!cameras.is_left_behind(0, now_ns));
        }
        let now_ns = 40 * 33_000_000;
        cameras.record(1, now_ns, &image(50.0));
        assert!(cameras.is_left_behind(0, now_ns) && !cameras.is_left_behind(1, now_ns));
        let later_ns = now_ns + 3_000_000_000;
        cameras.record(0, later_ns, &image(100.0));
        assert!(!cameras.is_left_behind(0, later_ns));
        cameras.record(0, later_ns, &image(100.01));
        assert!(cameras.frozen().next().is_none());
    }
}
