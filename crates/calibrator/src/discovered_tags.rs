//! Which tags discovery found to belong to what, in a report's words.

use crate::verdict::listed;
use serde::Serialize;
use sextant_site_model::TagId;

/// Which tags were found to be what; as text, family and number.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct DiscoveredTags {
    /// The object's own, that move as one.
    pub object: Vec<String>,
    /// Other things that move, each as one.
    pub others: Vec<Vec<String>>,
    /// Tags that move and are joined with nothing.
    pub loose: Vec<String>,
    /// Tags that stand still before their cameras.
    pub still: Vec<String>,
}

impl DiscoveredTags {
    /// What moves, if no single thing does.
    pub(crate) fn several(&self) -> String {
        let things = self.others.iter().map(listed);
        let things: Vec<String> = things.collect();
        format!(
            "Several things move, each as one: {}; name a tag of yours, or keep the others still",
            things.join(" | ")
        )
    }

    /// Why there is no object.
    pub(crate) fn why_none(&self, images: usize, around: Option<TagId>) -> String {
        if let (Some(tag), false) = (around, self.others.is_empty()) {
            return format!(
                "{tag} is on none of the things that move: {}",
                self.several()
            );
        }
        if !self.others.is_empty() {
            return self.several();
        }
        if !self.loose.is_empty() {
            return format!(
                "{} moved, but no two of them as one: turn the object so that two of its tags \
                 are seen together, or name its tags",
                listed(&self.loose)
            );
        }
        if !self.still.is_empty() {
            return format!(
                "{} were seen, but none of them moved: turn the object before the camera, or name its tags",
                listed(&self.still)
            );
        }
        format!("{images} images, and none shows a tag: check light, focus, distance and family")
    }
}
