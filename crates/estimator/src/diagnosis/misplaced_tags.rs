//! Tags that are seen where their objects can't have them: stuck on something else, or printed twice.
//!
//! A camera that was moved sees all its tags in the wrong place, a stray is alone with that among what its cameras see.

use std::collections::{BTreeMap, BTreeSet};

use crate::TagId;
use crate::diagnosis::fading_counter::kept;
use crate::tracker::finalised_views::{FinalisedView, SeenOn};

/// Views, fading, from which on a stray is named, and below which it is not any more.
const RAISED: f64 = 5.0;
const CLEARED: f64 = 1.0;
/// Agreeing views that a camera must have to be believed, and share of its views of other tags that may contradict.
const SOUND_VIEWS: f64 = 3.0;
const SOUND_SHARE: f64 = 0.1;

/// An object and one of its tags.
type Stray = (usize, TagId);

/// Counts that fade, of one tag's views that one camera's image contradicts.
#[derive(Debug, Clone, Copy, Default)]
struct Refused {
    at_ns: u64,
    views: f64,
    elsewhere: f64,
    /// Those on an object, and on which the last one was.
    on_object: f64,
    on: Option<usize>,
}

impl Refused {
    fn faded(&self, now_ns: u64) -> Self {
        let keep = kept(self.at_ns, now_ns);
        Self {
            at_ns: now_ns.max(self.at_ns),
            views: self.views * keep,
            elsewhere: self.elsewhere * keep,
            on_object: self.on_object * keep,
            on: self.on,
        }
    }
}

/// What is known of strays.
#[derive(Debug, Default)]
pub(crate) struct MisplacedTags {
    /// By camera.
    refused: BTreeMap<(usize, Stray), Refused>,
    found: BTreeMap<Stray, Option<usize>>,
}

impl MisplacedTags {
    /// A view that contradicts its track.
    pub fn refuse(&mut self, object: usize, time_ns: u64, view: &FinalisedView) {
        let key = (view.camera_index, (object, view.tag));
        let count = self.refused.entry(key).or_default();
        *count = count.faded(time_ns);
        count.views += 1.0;
        if let Some(place) = view.elsewhere {
            count.elsewhere += 1.0;
            if let SeenOn::On(other) = place {
                count.on_object += 1.0;
                count.on = Some(other);
            }
        }
    }

    /// Whether a tag is a stray.
    pub fn contains(&self, stray: &Stray) -> bool {
        self.found.contains_key(stray)
    }

    /// The strays, and the object that each is seen on.
    pub fn found(&self) -> impl Iterator<Item = (Stray, Option<usize>)> {
        self.found.iter().map(|(stray, on)| (*stray, *on))
    }

    /// Decides anew; `of_camera` gives a camera's views and how many of them contradict.
    pub fn judge(&mut self, now_ns: u64, of_camera: impl Fn(usize) -> Option<(f64, f64)>) {
        if self.refused.is_empty() {
            return;
        }
        for count in self.refused.values_mut() {
            *count = count.faded(now_ns);
        }
        self.refused.retain(|_, count| count.views > 0.01);
        let misplaced_tags: BTreeSet<Stray> =
            self.refused.keys().map(|(_, stray)| *stray).collect();
        self.found.retain(|stray, _| misplaced_tags.contains(stray));
        for stray in misplaced_tags {
            let sum = self.accepted(stray, &of_camera);
            let on = sum.on.filter(|_| sum.on_object > 0.5 * sum.elsewhere);
            if sum.elsewhere >= RAISED
                || (self.found.contains_key(&stray) && sum.elsewhere >= CLEARED)
            {
                self.found.insert(stray, on);
            } else {
                self.found.remove(&stray);
            }
        }
    }

    /// The views of a stray by cameras that are otherwise sound.
    fn accepted(&self, stray: Stray, of_camera: &impl Fn(usize) -> Option<(f64, f64)>) -> Refused {
        let mut sum = Refused::default();
        let counts = self.refused.iter().filter(|((_, one), _)| *one == stray);
        for ((camera, _), count) in counts {
            let Some((views, refused)) = of_camera(*camera) else {
                continue;
            };
            let of_others = refused - count.views;
            let sound = views - refused >= SOUND_VIEWS && of_others <= SOUND_SHARE * views;
            if sound {
                sum.elsewhere += count.elsewhere;
                sum.on_object += count.on_object;
                sum.on = sum.on.or(count.on);
            }
        }
        sum
    }
}
