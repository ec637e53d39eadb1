//! Groups of tags that move as one body.

use super::rigidity::{Joint, joint};
use super::tracks::Tracks;
use crate::discovered_tags::DiscoveredTags;
use crate::graph::islands;
use sextant_site_model::TagId;

/// Tags by what they move with.
#[derive(Clone, Debug, Default)]
pub(super) struct Groups {
    /// Of two tags and more, that move as one; the largest first.
    moving: Vec<Vec<TagId>>,
    loose: Vec<TagId>,
    still: Vec<TagId>,
    joints: Vec<([TagId; 2], Joint)>,
}

/// Tags in fewer images count as errors of reading.
const LEAST_IMAGES: usize = 3;

impl Groups {
    pub(super) fn from_tracks(tracks: &Tracks) -> Self {
        let pairs = tracks.pairs();
        let joints: Vec<([TagId; 2], Joint)> = pairs
            .filter_map(|(pair, views)| Some((pair, joint(views)?)))
            .collect();
        let seen = tracks.tags().filter(|(_, images)| *images >= LEAST_IMAGES);
        let seen: Vec<TagId> = seen.map(|(tag, _)| tag).collect();
        let (moving, still): (Vec<TagId>, Vec<TagId>) =
            seen.into_iter().partition(|tag| tracks.moves(*tag));
        let at = |tag: TagId| moving.iter().position(|known| *known == tag);
        let edges = joints
            .iter()
            .filter_map(|([a, b], _)| Some([at(*a)?, at(*b)?]));
        let of = islands(moving.len(), edges);
        let members = |island: usize| -> Vec<TagId> {
            let own = moving.iter().zip(&of).filter(|(_, i)| **i == island);
            own.map(|(tag, _)| *tag).collect()
        };
        let mut groups: Vec<Vec<TagId>> = (0..moving.len()).map(members).collect();
        groups.sort_by_key(|group| std::cmp::Reverse(group.len()));
        let loose = groups.iter().filter(|group| group.len() == 1).flatten();
        Self {
            loose: loose.copied().collect(),
            moving: groups.into_iter().filter(|group| group.len() > 1).collect(),
            still,
            joints,
        }
    }

    pub(super) fn joints(&self) -> &[([TagId; 2], Joint)] {
        &self.joints
    }

    /// Each thing that moves, the largest first.
    pub(super) fn moving(&self) -> &[Vec<TagId>] {
        &self.moving
    }

    /// Tags that move and are joined with nothing.
    pub(super) fn loose(&self) -> &[TagId] {
        &self.loose
    }

    /// Tags that stand still.
    pub(super) fn still(&self) -> &[TagId] {
        &self.still
    }

    /// The object's tags: those of the one thing that moves, or of the thing around the named tag.
    pub(super) fn object(&self, around: Option<TagId>) -> Option<&[TagId]> {
        match (around, self.moving.as_slice()) {
            (Some(tag), groups) => groups.iter().find(|group| group.contains(&tag)),
            (None, [only]) => Some(only),
            (None, _) => None,
        }
        .map(Vec::as_slice)
    }

    pub(super) fn found(&self, around: Option<TagId>) -> DiscoveredTags {
        let names = |tags: &[TagId]| tags.iter().map(ToString::to_string).collect();
        let object = self.object(around);
        let others = self.moving.iter().filter(|g| Some(g.as_slice()) != object);
        DiscoveredTags {
            object: object.map(names).unwrap_or_default(),
            others: others.map(|group| names(group)).collect(),
            loose: names(&self.loose),
            still: names(&self.still),
        }
    }
}
