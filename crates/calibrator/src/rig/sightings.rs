//! Observations of the carried object.

use crate::image_store::ImageView;
use crate::resection::{ObjectView, TagPlacement};

/// Images, their tags, and the possible poses of the object in each.
pub(super) struct Sightings {
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
