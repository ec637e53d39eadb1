//! Groups of tags that move as one body.

use super::rigidity::{Joint, LEAST_VIEWS, PairView, joint};
use super::tracks::Tracks;
use crate::discovered_tags::DiscoveredTags;
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

/// Two tags that images show together often enough to tell whether they are on one body.
struct Compared {
    tags: [TagId; 2],
    n_views: usize,
    joint: Option<Joint>,
}

impl Compared {
    fn new(tags: [TagId; 2], views: &[PairView]) -> Option<Self> {
        (views.len() >= LEAST_VIEWS).then(|| Self {
            tags,
            n_views: views.len(),
            joint: joint(views),
        })
    }
}

/// The body of each tag, as a number. Two groups are one body where most views of their tags together are rigid, at all
/// times: that of two tags alone may be so by chance, while both things hardly moved.
fn bodies(tags: &[TagId], compared: &[Compared]) -> Vec<usize> {
    let mut of: Vec<usize> = (0..tags.len()).collect();
    let at = |tag: TagId| tags.iter().position(|known| *known == tag);
    let pairs = compared.iter().filter_map(|pair| {
        let [a, b] = pair.tags.map(at);
        Some(([a?, b?], pair))
    });
    let mut pairs: Vec<([usize; 2], &Compared)> = pairs.collect();
    pairs.sort_by_key(|(_, pair)| std::cmp::Reverse(pair.joint.map_or(0, |joint| joint.views)));
    let joined = |of: &[usize], groups: [usize; 2]| {
        let between = pairs.iter().filter(|([a, b], _)| {
            let own = [of[*a], of[*b]];
            own == groups || own == [groups[1], groups[0]]
        });
        let (rigid, loose): (Vec<_>, Vec<_>) = between.partition(|(_, pair)| pair.joint.is_some());
        let views = |of: Vec<&([usize; 2], &Compared)>| {
            of.iter().map(|(_, pair)| pair.n_views).sum::<usize>()
        };
        views(rigid) > views(loose)
    };
    loop {
        let next = pairs.iter().find_map(|([a, b], pair)| {
            let groups = [of[*a], of[*b]];
            let is_new = pair.joint.is_some() && groups[0] != groups[1];
            (is_new && joined(&of, groups)).then_some(groups)
        });
        let Some([into, from]) = next else {
            return of;
        };
        of.iter_mut()
            .filter(|group| **group == from)
            .for_each(|group| *group = into);
    }
}

impl Groups {
    pub(super) fn from_tracks(tracks: &Tracks) -> Self {
        let compared: Vec<Compared> = tracks
            .pairs()
            .filter_map(|(tags, views)| Compared::new(tags, views))
            .collect();
        let joints = compared
            .iter()
            .filter_map(|pair| Some((pair.tags, pair.joint?)));
        let seen = tracks.tags().filter(|(_, images)| *images >= LEAST_IMAGES);
        let seen: Vec<TagId> = seen.map(|(tag, _)| tag).collect();
        let (moving, still): (Vec<TagId>, Vec<TagId>) =
            seen.into_iter().partition(|tag| tracks.moves(*tag));
        let of = bodies(&moving, &compared);
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
            joints: joints.collect(),
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

#[cfg(test)]
mod tests {
    use super::*;
    use sextant_tag_families::Family;

    fn tag(id: u32) -> TagId {
        TagId {
            family: Family::Tag36h11,
            id,
        }
    }

    fn compared(a: u32, b: u32, n_views: usize, is_rigid: bool) -> Compared {
        let views = n_views * 3 / 4;
        Compared {
            tags: [tag(a), tag(b)],
            n_views,
            joint: is_rigid.then_some(Joint { ratio: 1.0, views }),
        }
    }

    #[test]
    fn tags_that_agree_by_chance_do_not_join_two_things() {
        let tags: Vec<TagId> = (0..6).map(tag).collect();
        let pairs = [
            // Two things, whose opposite faces are never seen together.
            compared(0, 1, 30, true),
            compared(1, 2, 16, true),
            compared(3, 4, 24, true),
            compared(4, 5, 32, true),
            // Of one pair the views are poor.
            compared(3, 5, 6, false),
            // Between them one pair agrees, and others do not.
            compared(2, 3, 12, true),
            compared(1, 3, 20, false),
            compared(0, 5, 16, false),
        ];
        let of = bodies(&tags, &pairs);
        assert!(of[0] == of[1] && of[1] == of[2], "{of:?}");
        assert!(of[3] == of[4] && of[4] == of[5], "{of:?}");
        assert_ne!(of[0], of[3]);
        let joined = bodies(&tags, &pairs[..6]);
        assert!(joined.iter().all(|body| *body == joined[0]), "{joined:?}");
    }
}
