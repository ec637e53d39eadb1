//! Tags that are seen where their objects can't have them: stuck on something else, or printed twice.
//!
//! A camera that was moved sees all its tags in the wrong place; of a sound camera's views only those of a misplaced
//! tag are rejected.

use std::collections::BTreeMap;

use crate::fading_counter::FadingCounter;
use crate::tracker::report::FinalisedView;
use sextant_site_model::TagId;

/// Where a tag is that is far from where its object has it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum SeenOn {
    /// Where the object of this index is.
    On(usize),
    /// Where no object is.
    Nowhere,
}

/// Views far from the tag's place, fading, from which on a tag is named as misplaced, and below which it is not any
/// more.
const RAISED: f64 = 5.0;
const CLEARED: f64 = 1.0;
/// Agreeing views that a sound camera has, fading, and share of its views of other tags that may be rejected.
const SOUND_VIEWS: f64 = 3.0;
const SOUND_SHARE: f64 = 0.1;

/// An object and one of its tags.
type ObjectTag = (usize, TagId);

/// One tag's rejected views by one camera, those near the tag's place apart.
#[derive(Debug, Clone, Copy, Default)]
struct Rejected {
    /// Rejected views, and those of them that are near the tag's place.
    views: FadingCounter,
    /// The object that the last far view was on.
    on: Option<usize>,
}

impl Rejected {
    fn far(&self) -> f64 {
        self.views.total - self.views.rejected
    }
}

/// The misplaced tags of a site.
#[derive(Debug, Default)]
pub(crate) struct MisplacedTags {
    /// By camera.
    rejected: BTreeMap<(usize, ObjectTag), Rejected>,
    found: BTreeMap<ObjectTag, Option<usize>>,
}

impl MisplacedTags {
    /// Counts a rejected view; `far` tells what is there if that is far from the tag's place.
    pub fn reject(
        &mut self,
        object: usize,
        time_ns: u64,
        view: &FinalisedView,
        far: Option<SeenOn>,
    ) {
        let key = (view.camera_index, (object, view.tag));
        let count = self.rejected.entry(key).or_default();
        count.views.add(time_ns, far.is_none());
        count.on = match far {
            Some(SeenOn::On(other)) => Some(other),
            Some(SeenOn::Nowhere) => None,
            None => count.on,
        };
    }

    /// Whether a tag is misplaced.
    pub fn contains(&self, tag: &TagId) -> bool {
        self.found.keys().any(|(_, own)| own == tag)
    }

    /// The misplaced tags, and the object that each is seen on.
    pub fn found(&self) -> impl Iterator<Item = (ObjectTag, Option<usize>)> {
        self.found.iter().map(|(tag, on)| (*tag, *on))
    }

    /// Decides anew, in one pass; `of_camera` gives the counts of a camera's views.
    pub fn judge(&mut self, now_ns: u64, of_camera: impl Fn(usize) -> Option<FadingCounter>) {
        self.rejected.retain(|_, count| {
            count.views = count.views.faded(now_ns);
            count.views.total > 0.01
        });
        let mut by_tag: BTreeMap<ObjectTag, (f64, Option<usize>)> = BTreeMap::new();
        for ((camera, tag), count) in &self.rejected {
            let (far, on) = by_tag.entry(*tag).or_default();
            if of_camera(*camera).is_some_and(|all| is_sound(&all, count)) {
                *far += count.far();
                *on = on.or(count.on);
            }
        }
        let found = by_tag.into_iter().filter(|(tag, (far, _))| {
            *far >= RAISED || (*far >= CLEARED && self.found.contains_key(tag))
        });
        self.found = found.map(|(tag, (_, on))| (tag, on)).collect();
    }
}

/// Whether a camera agrees with its tracks but for the rejected views of one tag.
fn is_sound(all: &FadingCounter, of_tag: &Rejected) -> bool {
    let of_others = all.rejected - of_tag.views.total;
    all.total - all.rejected >= SOUND_VIEWS && of_others <= SOUND_SHARE * all.total
}
