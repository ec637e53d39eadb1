//! Which of the recorded live poses a replay gives again, bit for bit.

use serde::Serialize;
use sextant_proto::ObjectPose;
use sextant_site_model::ObjectId;
use sextant_site_report::ObjectEstimate;
use std::collections::BTreeMap;
use std::ops::RangeInclusive;

/// The live poses of a recording that are not given yet.
#[derive(Debug)]
pub struct LivePoses {
    waiting: BTreeMap<(ObjectId, u64), Vec<ObjectPose>>,
    comparison: LiveComparison,
}

/// Counts of live poses.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize)]
pub struct LiveComparison {
    /// Given again by the replay, equal in every bit.
    pub identical: usize,
    /// Not given by the replay, or not with these bits.
    pub different: usize,
    /// Published while no inputs are recorded, which the replay cannot know: before the first ones, and after the last
    /// ones of a process of the node, which has them for a tenth of a second before it publishes them.
    pub without_inputs: usize,
}

impl LiveComparison {
    /// Poses that the replay could give.
    pub fn n_compared(&self) -> usize {
        self.identical + self.different
    }
}

impl LivePoses {
    /// The poses of a recording.
    pub fn new(poses: &[ObjectPose]) -> Self {
        let mut waiting: BTreeMap<_, Vec<ObjectPose>> = BTreeMap::new();
        for pose in poses {
            let key = (pose.object.clone(), pose.capture_ns);
            waiting.entry(key).or_default().push(pose.clone());
        }
        Self {
            waiting,
            comparison: LiveComparison::default(),
        }
    }

    /// Notes a pose of the replay.
    pub fn take(&mut self, estimate: &ObjectEstimate) {
        let key = (estimate.object.clone(), estimate.capture_ns);
        let Some(waiting) = self.waiting.get_mut(&key) else {
            return;
        };
        let is_same = |live: &ObjectPose| {
            let (epoch, sequence) = (live.epoch, live.sequence);
            let replayed = ObjectPose::from_estimate(estimate, epoch, sequence, live.published_ns);
            bits(live) == bits(&replayed)
        };
        if let Some(index) = waiting.iter().position(is_same) {
            waiting.remove(index);
            self.comparison.identical += 1;
        }
    }

    /// The counts; inputs are recorded in these spans of time, ns.
    pub fn comparison(self, spans_ns: &[RangeInclusive<u64>]) -> LiveComparison {
        let mut comparison = self.comparison;
        for live in self.waiting.values().flatten() {
            let has_inputs = |span: &RangeInclusive<u64>| span.contains(&live.published_ns);
            match spans_ns.iter().any(has_inputs) {
                true => comparison.different += 1,
                false => comparison.without_inputs += 1,
            }
        }
        comparison
    }
}

/// The encoded message, in which zeros of either sign differ.
fn bits(pose: &ObjectPose) -> Option<Vec<u8>> {
    sextant_proto::encode(pose).ok()
}
