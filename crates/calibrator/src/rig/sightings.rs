//! What the images show of the carried object.

use crate::image_store::ImageView;
use crate::resection::{ObjectView, TagPlacement};

/// Images, what each shows, and where the object may be in each.
pub(super) struct Sightings {
    pub views: Vec<ImageView>,
    pub object: Vec<Vec<ObjectView>>,
    pub placed: Vec<TagPlacement>,
    /// Number of the carried object's tags; further ones lie on the floor.
    pub n_carried: usize,
    /// Whether the object's tags were unknown and are sought too.
    pub seeking_tags: bool,
    /// Tags of an unknown object that could not be placed, in words.
    pub unplaced: Vec<String>,
}
