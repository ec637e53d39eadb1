//! The last poses of one object, in the order of their time, within bounds.

use crate::interpolation::interpolate;
use crate::{Error, Pose};
use std::collections::VecDeque;
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

/// How long poses are kept, by their own time.
pub(crate) const KEPT: Duration = Duration::from_secs(10);
/// Most poses of one object.
const CAPACITY: usize = 2048;
/// Longest interval that is interpolated: the motion in a longer one is unknown.
const LONGEST_GAP: Duration = Duration::from_millis(500);
/// A newest pose that came longer ago than this is no longer where the object is.
const FRESH: Duration = Duration::from_secs(1);

/// The last poses of one object, filled by the network and read by anyone.
#[derive(Debug, Default)]
pub(crate) struct History {
    state: Mutex<HistoryState>,
    arrival: Condvar,
}

#[derive(Debug, Default)]
struct HistoryState {
    poses: VecDeque<Pose>,
    last_arrival: Option<Instant>,
}

impl HistoryState {
    fn insert(&mut self, pose: Pose) {
        let kept_ns = KEPT.as_nanos() as u64;
        let newest = self.poses.back().map_or(pose.t_ns, |last| last.t_ns);
        if pose.t_ns.saturating_add(kept_ns) < newest {
            // A clock was set back, or another recording plays: what is kept belongs to another time.
            self.poses.clear();
        }
        let place = self.poses.partition_point(|other| other.t_ns < pose.t_ns);
        match self.poses.get_mut(place) {
            Some(other) if other.t_ns == pose.t_ns => *other = pose,
            _ => self.poses.insert(place, pose),
        }
        let newest = self.poses.back().map_or(0, |last| last.t_ns);
        while self.poses.len() > CAPACITY
            || self
                .poses
                .front()
                .is_some_and(|first| newest - first.t_ns > kept_ns)
        {
            self.poses.pop_front();
        }
    }

    fn fresh(&self) -> Option<&Pose> {
        let is_fresh = self
            .last_arrival
            .is_some_and(|time| time.elapsed() <= FRESH);
        self.poses.back().filter(|_| is_fresh)
    }

    /// The poses around a time; none while it is not covered.
    fn around(&self, t_ns: u64) -> Option<(&Pose, &Pose)> {
        let place = self.poses.partition_point(|pose| pose.t_ns < t_ns);
        let after = self.poses.get(place)?;
        if after.t_ns == t_ns {
            return Some((after, after));
        }
        Some((self.poses.get(place.checked_sub(1)?)?, after))
    }
}

impl History {
    /// Takes in a pose that arrives now.
    pub(crate) fn insert(&self, pose: Pose) {
        let mut state = self.lock();
        state.insert(pose);
        state.last_arrival = Some(Instant::now());
        drop(state);
        self.arrival.notify_all();
    }

    /// The newest pose, unless it is older than a second; waits for one until `deadline`.
    pub(crate) fn newest(&self, deadline: Instant) -> Option<Pose> {
        self.wait_for(deadline, |state| state.fresh().cloned())
    }

    /// Time of the oldest pose in the history; 0 without one.
    pub(crate) fn oldest_ns(&self) -> u64 {
        self.lock().poses.front().map_or(0, |first| first.t_ns)
    }

    /// How long ago the last pose came.
    pub(crate) fn silent(&self) -> Option<Duration> {
        self.lock().last_arrival.map(|time| time.elapsed())
    }

    /// The pose at a time, interpolated; waits until `deadline` for poses after that time.
    pub(crate) fn at(&self, object: &str, t_ns: u64, deadline: Instant) -> Result<Pose, Error> {
        let covered = |state: &HistoryState| {
            let is_past = state.poses.back().is_some_and(|last| last.t_ns >= t_ns);
            is_past.then(|| interpolated(state, object, t_ns))
        };
        self.wait_for(deadline, covered)
            .unwrap_or_else(|| interpolated(&self.lock(), object, t_ns))
    }

    fn wait_for<T>(
        &self,
        deadline: Instant,
        wanted: impl Fn(&HistoryState) -> Option<T>,
    ) -> Option<T> {
        let mut state = self.lock();
        loop {
            if let Some(found) = wanted(&state) {
                return Some(found);
            }
            let left = deadline.saturating_duration_since(Instant::now());
            if left.is_zero() {
                return None;
            }
            let waited = self.arrival.wait_timeout(state, left);
            state = waited.unwrap_or_else(PoisonError::into_inner).0;
        }
    }

    fn lock(&self) -> MutexGuard<'_, HistoryState> {
        // No code of a caller runs under the lock, so a poisoned state is a whole one.
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

fn interpolated(state: &HistoryState, object: &str, t_ns: u64) -> Result<Pose, Error> {
    let Some((before, after)) = state.around(t_ns) else {
        let ends = state.poses.front().zip(state.poses.back());
        return Err(Error::NotCovered {
            object: object.to_owned(),
            t_ns,
            covered_ns: ends.map(|(first, last)| (first.t_ns, last.t_ns)),
        });
    };
    let gap = Duration::from_nanos(after.t_ns - before.t_ns);
    if gap > LONGEST_GAP {
        return Err(Error::Gap {
            object: object.to_owned(),
            t_ns,
            gap,
        });
    }
    Ok(interpolate(before, after, t_ns))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::interpolation::tests::pose;
    use nalgebra::Vector3;

    fn at(seconds: f64) -> Pose {
        pose(seconds, Vector3::new(seconds, 0.0, 0.0), Vector3::zeros())
    }

    fn history(times: impl IntoIterator<Item = f64>) -> History {
        let history = History::default();
        times.into_iter().for_each(|time| history.insert(at(time)));
        history
    }

    fn look(history: &History, seconds: f64) -> Result<Pose, Error> {
        history.at("cube", at(seconds).t_ns, Instant::now())
    }

    #[test]
    fn poses_in_any_order_are_found_by_time() {
        let history = history([0.0, 0.2, 0.1, 0.3]);
        for seconds in [0.0, 0.05, 0.1, 0.17, 0.3] {
            let found = look(&history, seconds).unwrap();
            assert!((found.position.x - seconds).abs() < 1e-6, "{found:?}");
        }
    }

    #[test]
    fn what_is_not_covered_is_refused_with_what_is() {
        assert!(matches!(
            look(&history([]), 0.0),
            Err(Error::NotCovered {
                covered_ns: None,
                ..
            })
        ));
        let history = history([1.0, 1.1]);
        let covered = Some((at(1.0).t_ns, at(1.1).t_ns));
        for seconds in [0.5, 1.2] {
            let Err(Error::NotCovered { covered_ns, .. }) = look(&history, seconds) else {
                panic!("covered")
            };
            assert_eq!(covered_ns, covered);
        }
    }

    #[test]
    fn a_gap_is_not_interpolated() {
        let history = history([0.0, 0.6]);
        assert!(matches!(look(&history, 0.3), Err(Error::Gap { .. })));
        assert!(look(&history, 0.6).is_ok());
    }

    #[test]
    fn a_flood_stays_within_both_bounds() {
        let slow = history((0..100).map(f64::from));
        assert_eq!(slow.lock().poses.len(), 11);
        let fast = history((0..10_000).map(|k| f64::from(k) * 1e-4));
        assert_eq!(fast.lock().poses.len(), CAPACITY);
    }

    #[test]
    fn a_clock_that_is_set_back_begins_a_new_history() {
        let history = history([100.0, 100.1, 50.0, 50.1]);
        assert!(look(&history, 50.05).is_ok());
        assert_eq!(history.lock().poses.len(), 2);
    }

    #[test]
    fn waiting_ends_when_the_time_is_covered() {
        let history = history([0.0]);
        let late = Instant::now() + Duration::from_secs(60);
        std::thread::scope(|scope| {
            let waiter = scope.spawn(|| history.at("cube", at(0.05).t_ns, late));
            history.insert(at(0.1));
            assert!(waiter.join().unwrap().is_ok());
        });
    }
}
