//! Which poses a subscriber takes where several fusion nodes may publish: those of the newest epoch of their object.

use crate::limits::MAX_OBJECTS;
use sextant_site_model::ObjectId;
use std::collections::BTreeMap;

/// An epoch without a pose for so long, ns, no longer keeps older ones out: its node may be in the other half of a
/// divided network, or its clock may have been set back before it was restarted.
const MEMORY_NS: u64 = 2_000_000_000;
/// Most objects: those of four fusion nodes. Poses of further ones are dropped.
const MOST: usize = 4 * MAX_OBJECTS;

/// Drops poses and links of epochs older than the newest one received of the same object.
#[derive(Debug, Clone, Default)]
pub struct EpochFilter {
    newest: BTreeMap<ObjectId, Newest>,
}

#[derive(Debug, Clone, Copy)]
struct Newest {
    epoch: u64,
    received_ns: u64,
}

impl EpochFilter {
    /// Whether a pose of this epoch, received at `now_ns` by any clock, is to be used.
    pub fn admits(&mut self, object: &ObjectId, epoch: u64, now_ns: u64) -> bool {
        let is_remembered = |newest: &Newest| now_ns.abs_diff(newest.received_ns) < MEMORY_NS;
        let known = self.newest.get(object);
        if known.is_some_and(|newest| epoch < newest.epoch && is_remembered(newest)) {
            return false;
        }
        if known.is_none() && self.newest.len() >= MOST {
            self.newest.retain(|_, newest| is_remembered(newest));
            if self.newest.len() >= MOST {
                return false;
            }
        }
        let received_ns = now_ns;
        self.newest
            .insert(object.clone(), Newest { epoch, received_ns });
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn id(name: &str) -> ObjectId {
        ObjectId::new(name).unwrap()
    }

    #[test]
    fn an_older_epoch_of_the_same_object_is_dropped() {
        let (mut filter, now) = (EpochFilter::default(), 5);
        let (cube, ball) = (id("cube"), id("ball"));
        let taken = [(&cube, 5), (&cube, 7), (&cube, 6), (&ball, 6), (&cube, 7)]
            .map(|(object, epoch)| filter.admits(object, epoch, now));
        assert_eq!(taken, [true, true, false, true, true]);
    }

    /// Otherwise a site whose clock was set back would have no poses after its restart.
    #[test]
    fn an_epoch_that_is_silent_is_forgotten() {
        let (mut filter, start) = (EpochFilter::default(), 5);
        let cube = id("cube");
        assert!(filter.admits(&cube, 9, start));
        let almost = MEMORY_NS - 1;
        assert!(!filter.admits(&cube, 3, start + almost));
        assert!(filter.admits(&cube, 3, start + MEMORY_NS));
        assert!(!filter.admits(&cube, 2, start + MEMORY_NS));
        assert!(filter.admits(&cube, 9, start + MEMORY_NS));
    }

    #[test]
    fn a_flood_of_objects_ends_at_the_bound() {
        let (mut filter, now) = (EpochFilter::default(), 5);
        let admitted = (0..2 * MOST).filter(|n| filter.admits(&id(&format!("o{n}")), 1, now));
        assert_eq!(admitted.count(), MOST);
        assert!(filter.admits(&id("late"), 1, now + MEMORY_NS));
        assert_eq!(filter.newest.len(), 1);
    }
}
