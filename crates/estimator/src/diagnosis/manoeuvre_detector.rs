//! Objects that have become far more restless than they were. Somebody may have taken one in hand; but so looks a camera's small error,
//! too, that is none at rest, such as a clock's: a track takes it for motion.

use std::collections::BTreeMap;

/// Factor of a density of acceleration from which on it is far more.
const FAR: f64 = 10.0;
/// Nanoseconds after which it is how the object moves.
const PATIENCE_NS: u64 = 3_000_000_000;

/// By object, since when it has been restless, ns.
#[derive(Debug, Default)]
pub(crate) struct ManoeuvreDetector(BTreeMap<usize, u64>);

impl ManoeuvreDetector {
    /// Notes how restless an object is, and was.
    pub fn note(&mut self, object: usize, now_ns: u64, now: Option<f64>, then: Option<f64>) {
        if now.zip(then).is_some_and(|(now, then)| now > FAR * then) {
            self.0.entry(object).or_insert(now_ns);
        } else {
            self.0.remove(&object);
        }
    }

    /// Whether it has become so of late.
    pub fn is(&self, object: usize, now_ns: u64) -> bool {
        let lately = |since_ns: &u64| now_ns < since_ns.saturating_add(PATIENCE_NS);
        self.0.get(&object).is_some_and(lately)
    }

    /// Those that have.
    pub fn objects(&self, now_ns: u64) -> impl Iterator<Item = usize> {
        let objects = self.0.keys().copied();
        objects.filter(move |object| self.is(*object, now_ns))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SECOND_NS: u64 = 1_000_000_000;

    #[test]
    fn who_stays_restless_is_no_longer_news() {
        let mut manoeuvring = ManoeuvreDetector::default();
        let mut note = |at: u64, now: f64| {
            let now_ns = at * SECOND_NS;
            manoeuvring.note(3, now_ns, Some(now), Some(0.1));
            manoeuvring.objects(now_ns).next()
        };
        assert_eq!(note(10, 0.5), None);
        assert_eq!(note(11, 2.0), Some(3));
        assert_eq!(note(13, 5.0), Some(3));
        assert_eq!(note(14, 5.0), None);
        assert_eq!(note(15, 0.5), None);
        assert_eq!(note(16, 2.0), Some(3));
    }
}
