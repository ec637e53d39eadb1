//! What is remembered of an object's last second, so that a fault that is noticed late can be looked at from before it came.

use std::collections::{BTreeMap, VecDeque};
use std::sync::Arc;

use crate::site::ObjectImage;
use crate::track::Track;

/// Nanoseconds between two marks.
const SPACING_NS: u64 = 500_000_000;
/// Instants between two marks, and in all, at most: the second is some four seconds of ten cameras.
const BETWEEN: usize = 300;
const MOST: usize = 1500;

/// Images that are taken at once.
#[derive(Debug, Clone)]
pub(super) struct Instant {
    pub time_ns: u64,
    pub images: BTreeMap<usize, Arc<ObjectImage>>,
}

/// One object's.
#[derive(Debug, Default)]
pub(super) struct Recall {
    /// The tracks at the last two marks, the older first.
    marks: [Option<Track>; 2],
    /// Since the older mark.
    instants: VecDeque<Instant>,
}

impl Recall {
    pub fn add(&mut self, instant: Instant) {
        self.instants.push_back(instant);
    }

    /// The track to begin with.
    pub fn start(&self) -> Track {
        let known = self.marks.iter().flatten().next();
        known.cloned().unwrap_or_default()
    }

    /// One of the instants since then.
    pub fn instant(&self, index: usize) -> Option<&Instant> {
        self.instants.get(index)
    }

    /// How many there are.
    pub fn len(&self) -> usize {
        self.instants.len()
    }

    /// Whether it can hold no more.
    pub fn is_full(&self) -> bool {
        self.instants.len() >= MOST
    }

    /// Notes how the track is while nothing is wrong.
    pub fn mark(&mut self, track: &Track) {
        let newest_ns = self.marks[1].as_ref().map_or(0, |mark| mark.time_ns);
        let is_due = track.time_ns >= newest_ns.saturating_add(SPACING_NS);
        if is_due || self.instants.len() > BETWEEN {
            let [_, newer] = std::mem::take(&mut self.marks);
            let since_ns = newer.as_ref().map_or(track.time_ns, |mark| mark.time_ns);
            self.marks = [newer, Some(track.clone())];
            self.instants.retain(|one| one.time_ns > since_ns);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn track(time_ns: u64) -> Track {
        let mut track = Track::default();
        track.time_ns = time_ns;
        track
    }

    #[test]
    fn it_reaches_back_to_the_mark_before_the_last() {
        let mut recall = Recall::default();
        for step in 1..=24 {
            let time_ns = step * 100_000_000;
            let images = BTreeMap::new();
            recall.add(Instant { time_ns, images });
            recall.mark(&track(time_ns));
        }
        let first = recall.instant(0).map(|instant| instant.time_ns);
        assert_eq!(recall.start().time_ns, 1_500_000_000);
        assert_eq!(first, Some(1_600_000_000));
        assert_eq!(recall.len(), 9);
    }
}
