//! Which instants are tested: each object's now and then, and of all objects together as many as the window holds,
//! spread over its time.

use std::collections::BTreeMap;

/// Time for which instants that were not tested are made up for, ns: an image of usual cameras shows many objects at
/// once.
const BURST_NS: u64 = 50_000_000;

/// When instants were last tested.
#[derive(Debug, Default)]
pub(crate) struct Pacing {
    /// Of each object that was tested lately, by index, ns.
    tested_ns: BTreeMap<usize, u64>,
    /// The newest instant, ns.
    newest_ns: u64,
    /// Of all objects, the next is tested once instants are as new as this, ns.
    due_ns: u64,
}

impl Pacing {
    /// Whether an instant of an object is tested: `interval_ns` after its last one, or later where so many objects take
    /// turns that `spacing_ns` between any two instants would not be kept.
    pub fn take(&mut self, object: usize, time_ns: u64, interval_ns: u64, spacing_ns: u64) -> bool {
        self.newest_ns = self.newest_ns.max(time_ns);
        let share_ns = self.tested_ns.len() as u64 * spacing_ns;
        let interval_ns = interval_ns.max(share_ns);
        let last_ns = self.tested_ns.get(&object).copied().unwrap_or(0);
        if time_ns < last_ns.saturating_add(interval_ns) || self.newest_ns < self.due_ns {
            return false;
        }
        let oldest_ns = time_ns.saturating_sub(2 * interval_ns + BURST_NS);
        self.tested_ns.retain(|_, at_ns| *at_ns >= oldest_ns);
        self.tested_ns.insert(object, time_ns);
        let due_ns = self.due_ns.max(self.newest_ns.saturating_sub(BURST_NS));
        self.due_ns = due_ns.saturating_add(spacing_ns);
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const MS: u64 = 1_000_000;

    /// How often each object is tested in ten seconds, and the longest time without any test, ns. All objects are in
    /// each image.
    fn tested(n_objects: usize, interval_ns: u64, spacing_ns: u64) -> (Vec<usize>, u64) {
        let mut pacing = Pacing::default();
        let mut counts = vec![0; n_objects];
        let (mut last_ns, mut longest_ns) = (1_000 * MS, 0);
        for image in 0..300 {
            let time_ns = 1_000 * MS + image * 33 * MS;
            for (object, count) in counts.iter_mut().enumerate() {
                if pacing.take(object, time_ns, interval_ns, spacing_ns) {
                    *count += 1;
                    longest_ns = longest_ns.max(time_ns - last_ns);
                    last_ns = time_ns;
                }
            }
        }
        (counts, longest_ns)
    }

    #[test]
    fn few_objects_are_tested_at_their_interval() {
        let (counts, _) = tested(3, 100 * MS, 9 * MS);
        assert!(
            counts.iter().all(|count| (70..=100).contains(count)),
            "{counts:?}"
        );
    }

    #[test]
    fn many_objects_take_turns_without_pauses() {
        for n_objects in [12, 30, 120, 1000] {
            let (counts, longest_ns) = tested(n_objects, 30 * MS, 9 * MS);
            let sum: usize = counts.iter().sum();
            let most = 9_900 / 9 + 6;
            assert!((most * 7 / 10..=most).contains(&sum), "{n_objects}: {sum}");
            assert!(longest_ns <= 66 * MS, "{n_objects}: {longest_ns}");
            let (least, most) = (counts.iter().min(), counts.iter().max());
            assert!(
                least.unwrap() + 2 >= most.unwrap() / 2,
                "{n_objects}: {counts:?}"
            );
        }
    }
}
