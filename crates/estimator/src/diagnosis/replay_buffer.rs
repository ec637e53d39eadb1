//! What is remembered of an object's last second, so that a fault that is noticed late can be looked at from before it came.

use std::collections::{BTreeMap, BTreeSet, VecDeque};
use std::sync::Arc;

use crate::site::{ClockPrior, ObjectImage};
use crate::tracker::track::Track;

/// Nanoseconds between two marks.
const SPACING_NS: u64 = 500_000_000;
/// Instants between two marks, and in all, at most: the second is some four seconds of ten cameras.
const BETWEEN: usize = 300;
const MOST: usize = 1500;
/// Stale instants that are dropped with each that comes: one image need not wait for all.
const DROPPED: usize = 4;

/// Images that are taken at once.
#[derive(Debug, Clone)]
pub(crate) struct Instant {
    pub time_ns: u64,
    pub images: BTreeMap<usize, Arc<ObjectImage>>,
}

/// One object's.
#[derive(Debug, Default)]
pub(crate) struct ReplayBuffer {
    /// The tracks at the last two marks, the older first.
    checkpoints: [Option<Track>; 2],
    /// Since the older mark, behind those that are to be dropped.
    instants: VecDeque<Instant>,
    stale: usize,
}

impl ReplayBuffer {
    pub fn add(&mut self, instant: Instant) {
        self.instants.push_back(instant);
        let dropped = self.stale.min(DROPPED);
        drop(self.instants.drain(..dropped));
        self.stale -= dropped;
    }

    /// The track to begin with.
    pub fn start(&self) -> Track {
        self.oldest_checkpoint().cloned().unwrap_or_default()
    }

    /// How restless the object was.
    pub fn process_noise_psd(&self) -> Option<f64> {
        self.oldest_checkpoint()?.process_noise_psd()
    }

    fn images(&self) -> impl Iterator<Item = &ObjectImage> {
        let instants = self.instants.range(self.stale..);
        let images = instants.flat_map(|instant| instant.images.values());
        images.map(Arc::as_ref)
    }

    /// The cameras that have seen the object since then, by index.
    pub fn cameras(&self) -> BTreeSet<usize> {
        self.images().map(|image| image.camera_index).collect()
    }

    /// Whether the clock of another camera than this is right.
    pub fn has_right_clock_beside(&self, camera: usize) -> bool {
        let is_right = |image: &ObjectImage| image.clock == ClockPrior::Right;
        self.images()
            .any(|image| is_right(image) && image.camera_index != camera)
    }

    fn oldest_checkpoint(&self) -> Option<&Track> {
        self.checkpoints.iter().flatten().next()
    }

    /// One of the instants since then.
    pub fn instant(&self, index: usize) -> Option<&Instant> {
        self.instants.get(self.stale + index)
    }

    /// How many there are.
    pub fn len(&self) -> usize {
        self.instants.len() - self.stale
    }

    /// Whether it can hold no more.
    pub fn is_full(&self) -> bool {
        self.len() >= MOST
    }

    /// Notes how the track is while nothing is wrong.
    pub fn checkpoint(&mut self, track: &Track) {
        // What is wrong from the first image on is not known at once: the first mark waits as well.
        let first_ns = self.instant(0).map_or(0, |one| one.time_ns);
        let newest = self.checkpoints[1].as_ref();
        let newest_ns = newest.map_or(first_ns.saturating_add(SPACING_NS), |checkpoint| {
            checkpoint.time_ns
        });
        let is_due = track.time_ns >= newest_ns.saturating_add(SPACING_NS);
        if is_due || self.len() > BETWEEN {
            let [_, newer] = std::mem::take(&mut self.checkpoints);
            let since_ns = newer
                .as_ref()
                .map_or(track.time_ns, |checkpoint| checkpoint.time_ns);
            self.checkpoints = [newer, Some(track.clone())];
            self.stale = self.instants.partition_point(|one| one.time_ns <= since_ns);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn track(time_ns: u64) -> Track {
        Track {
            time_ns,
            ..Track::default()
        }
    }

    /// So many instants and marks, each a tenth of a second after the last.
    fn remembered(steps: u64) -> ReplayBuffer {
        let mut replay_buffer = ReplayBuffer::default();
        for time_ns in (1..=steps).map(|step| step * 100_000_000) {
            let images = BTreeMap::new();
            replay_buffer.add(Instant { time_ns, images });
            replay_buffer.checkpoint(&track(time_ns));
        }
        replay_buffer
    }

    #[test]
    fn for_a_second_it_reaches_back_to_the_beginning() {
        let replay_buffer = remembered(10);
        assert_eq!(replay_buffer.start(), Track::default());
        assert_eq!(replay_buffer.len(), 10);
    }

    #[test]
    fn it_reaches_back_to_the_mark_before_the_last() {
        let replay_buffer = remembered(24);
        let first = replay_buffer.instant(0).map(|instant| instant.time_ns);
        assert_eq!(replay_buffer.start().time_ns, 1_600_000_000);
        assert_eq!(first, Some(1_700_000_000));
        assert_eq!(replay_buffer.len(), 8);
    }
}
