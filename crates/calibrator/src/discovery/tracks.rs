//! Tracks of single tags before they are assigned to objects: whether each moves, and its poses relative to others.

use super::rigidity::{PairView, UnitPoses};
use nalgebra::Point2;
use sextant_site_model::{Camera, CameraId, ImageObservation, TagCorners, TagId};
use sextant_tag_families::Family;
use std::collections::BTreeMap;

/// Most tracked tags; a room has fewer.
const MOST_TAGS: usize = 96;
/// Most stored views of a pair; beyond it, every second is dropped.
const MOST_VIEWS: usize = 32;
/// A tag has moved if a corner has moved by this share of its edge and by this number of pixels.
const MOVED: (f64, f64) = (0.35, 4.0);
/// Images in which a tag must have moved, and their share of its images, so that wrong detections have no effect.
const MOVED_IMAGES: usize = 3;
const MOVED_SHARE: f64 = 0.01;

/// All tags.
#[derive(Clone, Debug, Default)]
pub(super) struct Tracks {
    tags: BTreeMap<TagId, Track>,
    pairs: BTreeMap<[TagId; 2], Pair>,
}

#[derive(Clone, Debug, Default)]
struct Track {
    images: usize,
    /// Where each camera saw it first.
    first: BTreeMap<CameraId, Corners>,
    /// Images that show it elsewhere.
    elsewhere: usize,
}

/// Where a camera saw two tags.
#[derive(Clone, Debug)]
struct StoredView {
    camera: CameraId,
    corners: [Corners; 2],
}

/// Two tags in the same images.
#[derive(Clone, Debug)]
pub(super) struct Pair {
    views: Vec<PairView>,
    /// The last stored view.
    last: StoredView,
    every: usize,
    came: usize,
}

type Corners = [Point2<f64>; 4];

impl Tracks {
    /// Adds the tags of an image.
    pub(super) fn add(&mut self, camera: &Camera, image: &ImageObservation, families: &[Family]) {
        let once =
            |seen: &&TagCorners| image.tags.iter().filter(|t| t.tag == seen.tag).count() == 1;
        let counting = image
            .tags
            .iter()
            .filter(|t| families.contains(&t.tag.family));
        let mut seen: Vec<&TagCorners> = counting.filter(once).collect();
        seen.sort_by_key(|tag| tag.tag);
        seen.retain(|tag| self.tags.len() < MOST_TAGS || self.tags.contains_key(&tag.tag));
        for tag in &seen {
            self.tags
                .entry(tag.tag)
                .or_default()
                .add(&camera.id, &tag.corners);
        }
        let moving: Vec<&TagCorners> = seen.into_iter().filter(|t| self.moves(t.tag)).collect();
        let mut poses: BTreeMap<TagId, UnitPoses> = BTreeMap::new();
        for (at, a) in moving.iter().enumerate() {
            for b in &moving[at + 1..] {
                self.add_pair(camera, [*a, *b], &mut poses);
            }
        }
    }

    fn add_pair(
        &mut self,
        camera: &Camera,
        [a, b]: [&TagCorners; 2],
        poses: &mut BTreeMap<TagId, UnitPoses>,
    ) {
        let key = [a.tag, b.tag];
        let corners = [a.corners, b.corners];
        if let Some(pair) = self.pairs.get(&key)
            && pair.last.camera == camera.id
            && !(0..2).any(|at| has_moved(&pair.last.corners[at], &corners[at]))
        {
            return;
        }
        for tag in [a, b] {
            let unit = || UnitPoses::from_corners(&camera.lens, &tag.corners);
            poses.entry(tag.tag).or_insert_with(unit);
        }
        let view = PairView::between(&poses[&a.tag], &poses[&b.tag]);
        let last = StoredView {
            camera: camera.id.clone(),
            corners,
        };
        match self.pairs.get_mut(&key) {
            Some(pair) => pair.add(view, last),
            None => {
                self.pairs.insert(key, Pair::begun_with(view, last));
            }
        }
    }

    pub(super) fn is_empty(&self) -> bool {
        self.tags.is_empty()
    }

    /// Whether it has moved in the image of its camera.
    pub(super) fn moves(&self, tag: TagId) -> bool {
        self.tags.get(&tag).is_some_and(|track| {
            let least = (MOVED_SHARE * track.images as f64) as usize;
            track.elsewhere >= least.max(MOVED_IMAGES)
        })
    }

    /// Every tag with the number of images that show it.
    pub(super) fn tags(&self) -> impl Iterator<Item = (TagId, usize)> {
        self.tags.iter().map(|(tag, track)| (*tag, track.images))
    }

    /// Pairs that were seen together while they moved.
    pub(super) fn pairs(&self) -> impl Iterator<Item = ([TagId; 2], &[PairView])> {
        self.pairs.iter().map(|(key, pair)| (*key, &pair.views[..]))
    }
}

impl Track {
    fn add(&mut self, camera: &CameraId, corners: &Corners) {
        self.images += 1;
        let first = self.first.entry(camera.clone()).or_insert(*corners);
        self.elsewhere += usize::from(has_moved(first, corners));
    }
}

impl Pair {
    fn begun_with(view: PairView, last: StoredView) -> Self {
        Self {
            views: vec![view],
            last,
            every: 1,
            came: 1,
        }
    }

    fn add(&mut self, view: PairView, last: StoredView) {
        self.last = last;
        if self.came.is_multiple_of(self.every) {
            self.views.push(view);
        }
        self.came += 1;
        if self.views.len() > MOST_VIEWS {
            let mut at = 0;
            self.views.retain(|_| {
                at += 1;
                at % 2 == 1
            });
            self.every *= 2;
        }
    }
}

fn has_moved(before: &Corners, now: &Corners) -> bool {
    let edge = (0..4)
        .map(|k| (now[k] - now[(k + 1) % 4]).norm())
        .sum::<f64>()
        / 4.0;
    let bound = (MOVED.0 * edge).max(MOVED.1);
    before.iter().zip(now).any(|(a, b)| (a - b).norm() > bound)
}
