//! Observations of the carried object.

use crate::image_store::ImageView;
use crate::resection::{ObjectView, TagPlacement};

/// Images, their tags, and the possible poses of the object in each.
pub(crate) struct Sightings {
    pub views: Vec<ImageView>,
    pub object: Vec<Vec<ObjectView>>,
    pub placed: Vec<TagPlacement>,
    /// Number of the carried object's tags; further ones are on the floor.
    pub n_carried: usize,
    /// Whether the poses of the object's tags are unknown and free.
    pub seeking_tags: bool,
    /// Causes why tags of an unknown object could not be placed.
    pub unplaced: Vec<String>,
}

/// Least number of images with several tags to judge a camera.
const ENOUGH: usize = 8;
/// Share of them with tags arranged as on the object that a camera has at most which shows something else, and others
/// have at least.
const CONTRADICTS: f64 = 0.25;
const AGREES: f64 = 0.6;

impl Sightings {
    /// Cameras whose tags contradict the arrangement of the object, while those of most others have it: they show its
    /// mirrored back, or another one with the same numbers.
    pub fn strangers(&self, n_cameras: usize) -> Vec<usize> {
        let share = |camera: usize| {
            let (mut several, mut arranged) = (0, 0);
            for (view, object) in self.views.iter().zip(&self.object) {
                let tags = view.tags.iter();
                let n_placed = tags.filter(|seen| self.placed[seen.tag].is_some()).count();
                if view.camera == camera && n_placed > 1 {
                    several += 1;
                    let best = object.first().map_or(0, |best| best.agreeing.len());
                    arranged += usize::from(best > 1 && 2 * best >= n_placed);
                }
            }
            (several >= ENOUGH).then(|| arranged as f64 / several as f64)
        };
        let shares: Vec<Option<f64>> = (0..n_cameras).map(share).collect();
        let judged = shares.iter().flatten();
        let n_agree = judged.clone().filter(|share| **share >= AGREES).count();
        if 2 * n_agree <= judged.count() {
            return Vec::new();
        }
        let of_strangers =
            |camera: &usize| shares[*camera].is_some_and(|share| share < CONTRADICTS);
        (0..n_cameras).filter(of_strangers).collect()
    }
}
