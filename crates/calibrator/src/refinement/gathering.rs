//! From a stream of images to tenths of a second of one object each.

use super::site::Site;
use sextant_estimator::{ImageObservation, TagCorners};

/// Length of a moment, ns.
const LENGTH_NS: u64 = 100_000_000;
/// Images that come this much later are still waited for, ns.
const PATIENCE_NS: u64 = 150_000_000;
/// From one moment of an object to the next, ns.
const PAUSE_NS: u64 = 1_000_000_000;
/// A stamp this much ahead of a later image's was wrong, ns.
const JUMP_NS: u64 = 10_000_000_000;
/// Images of a moment at most: 64 cameras at 60 images a second.
const MOST_IMAGES: usize = 384;

/// Images of one object within a tenth of a second.
#[derive(Clone, Debug)]
pub(super) struct Gathered {
    pub object: usize,
    pub start_ns: u64,
    /// Images reduced to the object's tags.
    pub images: Vec<ImageObservation>,
}

/// What is being gathered.
#[derive(Clone, Debug, Default)]
pub(super) struct Gathering {
    open: Vec<Gathered>,
    /// By object, when its next moment may begin.
    pauses: Vec<u64>,
    latest_ns: u64,
}

impl Gathering {
    pub(super) fn take(&mut self, site: &Site, image: &ImageObservation) {
        if site.camera(&image.camera).is_none() {
            return;
        }
        self.advance(image.capture_ns);
        self.pauses.resize(site.objects.len(), 0);
        for (object, of) in site.objects.iter().enumerate() {
            let own = &site.tags[of.tags.clone()];
            let is_own = |seen: &&TagCorners| own.iter().any(|tag| tag.tag == seen.tag);
            let tags: Vec<TagCorners> = image.tags.iter().filter(is_own).cloned().collect();
            if !tags.is_empty() {
                let image = ImageObservation {
                    tags,
                    camera: image.camera.clone(),
                    ..*image
                };
                self.put(object, image);
            }
        }
    }

    /// Time goes on; what lies far ahead of it came of a wrong stamp.
    fn advance(&mut self, at: u64) {
        let jumped = self.latest_ns.saturating_sub(at) > JUMP_NS;
        self.latest_ns = if jumped { at } else { self.latest_ns.max(at) };
        let end = self.latest_ns.saturating_add(JUMP_NS);
        self.open.retain(|open| open.start_ns <= end);
        for pause in &mut self.pauses {
            *pause = (*pause).min(end);
        }
    }

    fn put(&mut self, object: usize, image: ImageObservation) {
        let at = image.capture_ns;
        match self.open.iter_mut().find(|open| open.object == object) {
            Some(open) => {
                let within = open.start_ns..open.start_ns.saturating_add(LENGTH_NS);
                if within.contains(&at) && open.images.len() < MOST_IMAGES {
                    open.images.push(image);
                }
            }
            None if at >= self.pauses[object] => {
                self.pauses[object] = at.saturating_add(PAUSE_NS);
                self.open.push(Gathered {
                    object,
                    start_ns: at,
                    images: vec![image],
                });
            }
            None => {}
        }
    }

    /// A moment to which nothing comes any more.
    pub(super) fn next_whole(&mut self) -> Option<Gathered> {
        let whole = |open: &Gathered| {
            let end = open.start_ns.saturating_add(LENGTH_NS + PATIENCE_NS);
            self.latest_ns >= end
        };
        let at = self.open.iter().position(whole)?;
        Some(self.open.remove(at))
    }
}
