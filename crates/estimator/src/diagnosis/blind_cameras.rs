//! Cameras that see no tag at all while others track an object that stands in their picture.
//!
//! A camera that was turned away, is covered or out of focus contradicts nothing. That it should see a tag follows from
//! the poses that the others determine, and how small a tag may be from what they see.

use std::collections::BTreeMap;

use nalgebra::{Point2, Vector3};
use sextant_geometry::{Pose, tag_corners_in_tag};
use sextant_site_model::TagCorners;

use crate::measurement::corner_noise::area_px2;
use crate::measurement::corners::CalibratedCamera;

/// Seconds and looks for which a camera must see nothing.
const BLIND_S: f64 = 5.0;
const LOOKS: u32 = 12;
/// Least time between two looks, ns.
const PAUSE_NS: u64 = 200_000_000;
/// After so long without a tag in its picture, a camera's blindness begins anew, ns.
const FORGOTTEN_NS: u64 = 3_000_000_000;
/// A tag that every camera sees is as large as the smallest that others see now and no smaller than this, px, as
/// frontal, by the cosine, and as far from the border, by the picture.
const LEAST_PX: f64 = 12.0;
const LEAST_COSINE: f64 = 0.5;
const BORDER: f64 = 0.05;
/// After so long a sight says nothing of what can be seen now, ns.
const NOW_NS: u64 = 1_000_000_000;

/// What a camera that sees no tag should see.
#[derive(Debug, Clone, Copy)]
struct Blindness {
    looked_ns: u64,
    object: usize,
    since_ns: u64,
    last_ns: u64,
    looks: u32,
}

/// For how long each camera has seen nothing of what is in its picture.
#[derive(Debug, Default)]
pub(crate) struct BlindCameras {
    /// By camera index; none of those whose last image shows a tag.
    cameras: BTreeMap<usize, Blindness>,
    /// Edge of the smallest tag in the last image that shows one, px, and when it arrived, ns; by camera index.
    smallest: BTreeMap<usize, (f64, u64)>,
}

impl BlindCameras {
    /// Takes an image in that shows a tag.
    pub fn note_sight(&mut self, camera: usize, tags: &[TagCorners], now_ns: u64) {
        self.cameras.remove(&camera);
        let edges = tags.iter().map(|seen| area_px2(&seen.corners).sqrt());
        let smallest = edges.fold(f64::INFINITY, f64::min);
        self.smallest.insert(camera, (smallest, now_ns));
    }

    /// Smallest edge of a tag that is visible now, px; infinite while no camera sees a tag.
    pub fn visible_px(&self, now_ns: u64) -> f64 {
        let is_now = |seen_ns: u64| now_ns.saturating_sub(seen_ns) <= NOW_NS;
        let now = self.smallest.values().filter(|(_, ns)| is_now(*ns));
        let smallest = now.map(|(edge_px, _)| *edge_px);
        smallest.fold(f64::INFINITY, f64::min).max(LEAST_PX)
    }

    /// Whether to look again what an image without a tag should show.
    pub fn is_due(&self, camera: usize, now_ns: u64) -> bool {
        let last = self.cameras.get(&camera);
        last.is_none_or(|last| now_ns.saturating_sub(last.looked_ns) >= PAUSE_NS)
    }

    /// Takes an image in that shows no tag, and the object that it should show, if there is one.
    pub fn note_nothing(&mut self, camera: usize, object: Option<usize>, now_ns: u64) {
        let new = Blindness {
            looked_ns: now_ns,
            object: 0,
            since_ns: now_ns,
            last_ns: now_ns,
            looks: 0,
        };
        let last = self.cameras.entry(camera).or_insert(new);
        if now_ns.saturating_sub(last.last_ns) > FORGOTTEN_NS {
            *last = new;
        }
        last.looked_ns = now_ns;
        if let Some(object) = object {
            (last.object, last.last_ns) = (object, now_ns);
            last.looks = last.looks.saturating_add(1);
        }
    }

    /// The cameras that see nothing, the object that they should see, both by index, and for how long, s.
    pub fn blind(&self, now_ns: u64) -> impl Iterator<Item = (usize, usize, f64)> {
        self.cameras.iter().filter_map(move |(camera, one)| {
            let blind_s = one.last_ns.saturating_sub(one.since_ns) as f64 * 1e-9;
            let is_now = now_ns.saturating_sub(one.last_ns) <= FORGOTTEN_NS;
            let is_blind = one.looks >= LOOKS && blind_s >= BLIND_S && is_now;
            is_blind.then_some((*camera, one.object, blind_s))
        })
    }
}

/// Whether a tag is large, frontal and far enough from the border of a camera's picture to be seen unless it is
/// covered; `visible_px` is the smallest visible edge.
pub(crate) fn is_well_in_view(
    camera: &CalibratedCamera,
    [width, height]: [u32; 2],
    world_from_tag: &Pose,
    size_m: f64,
    visible_px: f64,
) -> bool {
    let camera_from_tag = camera.camera_from_world * world_from_tag;
    let centre = camera_from_tag.translation.vector;
    let outwards = camera_from_tag.rotation * Vector3::z();
    if -outwards.dot(&centre) < LEAST_COSINE * centre.norm() {
        return false;
    }
    let size = [width, height].map(f64::from);
    let is_inside = |corner: &Point2<f64>| {
        let mut axes = corner.iter().zip(size);
        axes.all(|(at, size)| (BORDER * size..(1.0 - BORDER) * size).contains(at))
    };
    let corners = tag_corners_in_tag(size_m).map(|corner| {
        let corner = camera.lens.project(&(camera_from_tag * corner));
        corner.filter(is_inside)
    });
    let [Some(a), Some(b), Some(c), Some(d)] = corners else {
        return false;
    };
    area_px2(&[a, b, c, d]).sqrt() >= visible_px
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_camera_is_blind_after_seconds_without_a_tag_in_its_picture() {
        let mut cameras = BlindCameras::default();
        let look_ns = |n: u64| n * PAUSE_NS;
        for n in 0..30 {
            assert!(cameras.is_due(0, look_ns(n)));
            cameras.note_nothing(0, Some(1), look_ns(n));
            assert!(!cameras.is_due(0, look_ns(n) + 1));
            let is_blind = cameras.blind(look_ns(n)).next().is_some();
            assert_eq!(is_blind, n >= 25, "{n}");
        }
        let later_ns = look_ns(29) + FORGOTTEN_NS + 1;
        assert!(cameras.blind(later_ns).next().is_none());
        cameras.note_nothing(0, Some(1), later_ns);
        assert!(cameras.blind(later_ns).next().is_none());
        cameras.note_sight(0, &[], later_ns);
        assert!(cameras.cameras.is_empty());
    }
}
