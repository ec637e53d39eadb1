//! Who agrees while one contradicts.
//!
//! A body that is hit contradicts everyone at once; what is faulty is contradicted by those that go on to agree.

use std::collections::BTreeMap;

/// Nanoseconds within which one has lately agreed.
const LATELY_NS: u64 = 1_000_000_000;

/// One camera's or tag's agreement with an object's track.
#[derive(Debug, Clone, Copy, Default)]
struct Agreement {
    agreed_ns: u64,
    /// Since when it contradicts.
    since_ns: Option<u64>,
}

/// By object, of its cameras or its tags.
#[derive(Debug)]
pub(crate) struct ConsistencyTally<K>(BTreeMap<(usize, K), Agreement>);

impl<K> Default for ConsistencyTally<K> {
    fn default() -> Self {
        Self(BTreeMap::new())
    }
}

impl<K: Ord + Copy> ConsistencyTally<K> {
    /// Notes whether one agrees at an instant; whether it begins to contradict.
    pub fn note(&mut self, object: usize, one: K, time_ns: u64, agreed: bool) -> bool {
        let agreement = self.0.entry((object, one)).or_default();
        if agreed {
            agreement.agreed_ns = agreement.agreed_ns.max(time_ns);
            agreement.since_ns = None;
            return false;
        }
        let begins = agreement.since_ns.is_none();
        agreement.since_ns.get_or_insert(time_ns);
        begins
    }

    /// Whether one contradicts the object's track.
    pub fn contradicts(&self, object: usize, one: K) -> bool {
        let agreement = self.0.get(&(object, one));
        agreement.is_some_and(|own| own.since_ns.is_some())
    }

    /// The others that agree with the object's track, since this one contradicts or lately.
    pub fn of(&self, object: usize, one: K, time_ns: u64) -> impl Iterator<Item = K> {
        let since_ns = self.0.get(&(object, one)).and_then(|own| own.since_ns);
        let lately_ns = time_ns.saturating_sub(LATELY_NS);
        let after_ns = since_ns.unwrap_or(0).max(lately_ns);
        let of_object = self.0.iter().filter(move |((of, _), _)| *of == object);
        of_object
            .filter(move |((_, other), agreement)| *other != one && agreement.agreed_ns > after_ns)
            .map(|((_, other), _)| *other)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const S: u64 = 1_000_000_000;

    #[test]
    fn those_that_go_on_to_agree_support_the_charge() {
        let mut support = ConsistencyTally::default();
        for camera in 0..3 {
            support.note(0, camera, S, true);
        }
        assert!(support.note(0, 1, S + 10, false));
        assert!(!support.note(0, 1, S + 30, false));
        assert_eq!(support.of(0, 1, S + 30).count(), 0);
        support.note(0, 2, S + 20, true);
        assert_eq!(support.of(0, 1, S + 30).collect::<Vec<_>>(), [2]);
        assert_eq!(support.of(1, 1, S + 30).count(), 0);
        assert!(support.contradicts(0, 1) && !support.contradicts(0, 2));
    }

    #[test]
    fn a_body_that_is_hit_contradicts_all_and_is_held_against_nobody() {
        let mut support = ConsistencyTally::default();
        for camera in 0..3 {
            support.note(0, camera, S, true);
            support.note(0, camera, S + 1 + camera as u64, false);
        }
        assert!((0..3).all(|camera| support.of(0, camera, S + 9).count() == 0));
    }
}
