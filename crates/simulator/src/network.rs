//! A simulated network that loses, delays, reorders and duplicates messages, seeded, in virtual time.
//!
//! Input: payloads with their capture time and the time they were sent. Output: arrivals in order of arrival time. One
//! stream a camera keeps its order (a datagram waits for the one before it) unless the reordering fault says otherwise.

use crate::random::{Random, key_of_name};
use crate::scenario::{NetworkFaults, Scenario};
use std::collections::BTreeMap;
use std::ops::Range;

/// Most payloads in flight; further ones are lost, as in a full queue.
pub const MAX_UNDER_WAY: usize = 4096;

/// When a camera is cut off that sent its first message at `first_sent_ns`.
fn cut_off_ns(faults: &NetworkFaults, first_sent_ns: u64) -> Range<u64> {
    let [from, until] = faults.partition_s.map(|seconds| {
        let after_ns = (seconds.max(0.0) * 1e9).round() as u64;
        first_sent_ns.saturating_add(after_ns)
    });
    from..until
}

/// A payload that has arrived.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Arrival<T> {
    /// Index of the camera in the scenario.
    pub camera: usize,
    /// When it arrived, ns.
    pub arrival_ns: u64,
    /// The capture time it was sent with, ns.
    pub capture_ns: u64,
    /// What was sent.
    pub payload: T,
}

/// The network between the cameras and the receiver.
pub struct Network<T> {
    links: Vec<Link>,
    under_way: BTreeMap<(u64, u64), Arrival<T>>,
    sent: u64,
    lost: u64,
}

struct Link {
    faults: NetworkFaults,
    random: Random,
    first_sent_ns: Option<u64>,
    last_arrival_ns: u64,
}

impl<T: Clone> Network<T> {
    /// The network of a scenario, empty.
    pub fn new(scenario: &Scenario) -> Self {
        let link = |camera: &crate::scenario::SceneCamera| Link {
            faults: camera.network,
            random: Random::from_keys(&[
                scenario.seed,
                key_of_name("network"),
                key_of_name(&camera.id),
            ]),
            first_sent_ns: None,
            last_arrival_ns: 0,
        };
        Self {
            links: scenario.cameras.iter().map(link).collect(),
            under_way: BTreeMap::new(),
            sent: 0,
            lost: 0,
        }
    }

    /// Sends a payload of camera `camera` at `sent_ns`; an unknown camera's is lost.
    pub fn send(&mut self, camera: usize, sent_ns: u64, capture_ns: u64, payload: T) {
        let Some(link) = self.links.get_mut(camera) else {
            self.lost += 1;
            return;
        };
        let fate = link.fate(sent_ns);
        if fate.is_empty() {
            self.lost += 1;
        }
        for arrival_ns in fate.into_iter() {
            self.put(Arrival {
                camera,
                arrival_ns,
                capture_ns,
                payload: payload.clone(),
            });
        }
    }

    /// When the next payload arrives, if one is under way.
    pub fn next_arrival_ns(&self) -> Option<u64> {
        self.under_way
            .keys()
            .next()
            .map(|&(arrival_ns, _)| arrival_ns)
    }

    /// The next payload that has arrived by `now_ns`.
    pub fn receive(&mut self, now_ns: u64) -> Option<Arrival<T>> {
        let entry = self.under_way.first_entry()?;
        (entry.key().0 <= now_ns).then(|| entry.remove())
    }

    /// How many payloads were lost so far.
    pub fn lost(&self) -> u64 {
        self.lost
    }

    fn put(&mut self, arrival: Arrival<T>) {
        if self.under_way.len() >= MAX_UNDER_WAY {
            self.lost += 1;
            return;
        }
        self.sent += 1;
        self.under_way
            .insert((arrival.arrival_ns, self.sent), arrival);
    }
}

/// The arrival times of one message: none, one or two.
struct ArrivalTimes {
    first: Option<u64>,
    second: Option<u64>,
}

impl ArrivalTimes {
    fn is_empty(&self) -> bool {
        self.first.is_none() && self.second.is_none()
    }

    fn into_iter(self) -> impl Iterator<Item = u64> {
        self.first.into_iter().chain(self.second)
    }
}

impl Link {
    /// Draws the same count of random numbers whatever the faults are, so that one fault doesn't change another's
    /// pattern.
    fn fate(&mut self, sent_ns: u64) -> ArrivalTimes {
        let since_ns = *self.first_sent_ns.get_or_insert(sent_ns);
        let cut_off = cut_off_ns(&self.faults, since_ns);
        let lost = self.random.chance(self.faults.loss);
        let doubled = self.random.chance(self.faults.duplicate);
        let held = self.random.chance(self.faults.reorder);
        let arrival_ns = sent_ns.saturating_add(self.delay_ns());
        let copy_delay_ns = self.delay_ns();
        if lost || cut_off.contains(&sent_ns) {
            return ArrivalTimes {
                first: None,
                second: None,
            };
        }
        let first = if held {
            arrival_ns.saturating_add(ns_of_ms(self.faults.reorder_ms))
        } else {
            self.last_arrival_ns = self.last_arrival_ns.max(arrival_ns);
            self.last_arrival_ns
        };
        let second = doubled.then(|| first.saturating_add(copy_delay_ns));
        let arrives = |arrival_ns: &u64| !cut_off.contains(arrival_ns);
        ArrivalTimes {
            first: Some(first).filter(arrives),
            second: second.filter(arrives),
        }
    }

    fn delay_ns(&mut self) -> u64 {
        ns_of_ms(self.faults.delay_ms + self.faults.jitter_ms * self.random.normal())
    }
}

fn ns_of_ms(ms: f64) -> u64 {
    (ms.max(0.0) * 1e6).round() as u64
}

#[cfg(test)]
mod tests {
    use super::*;

    fn network(faults: NetworkFaults, seed: u64) -> Network<u32> {
        let mut scenario = Scenario::demo(2, 1, seed);
        for camera in &mut scenario.cameras {
            camera.network = faults;
        }
        Network::new(&scenario)
    }

    fn run(faults: NetworkFaults, seed: u64) -> Vec<Arrival<u32>> {
        let mut network = network(faults, seed);
        for n in 0..1000u32 {
            let sent_ns = 1_000_000_000 + u64::from(n) * 10_000_000;
            network.send(n as usize % 2, sent_ns, sent_ns - 5_000_000, n);
        }
        std::iter::from_fn(|| network.receive(u64::MAX)).collect()
    }

    const BAD: NetworkFaults = NetworkFaults {
        loss: 0.1,
        delay_ms: 8.0,
        jitter_ms: 4.0,
        reorder: 0.05,
        reorder_ms: 60.0,
        duplicate: 0.1,
        partition_s: [0.0; 2],
    };

    #[test]
    fn arrivals_come_in_order_of_their_time_and_not_before_they_were_sent() {
        let arrivals = run(BAD, 3);
        assert!(arrivals.is_sorted_by_key(|a| a.arrival_ns));
        assert!(
            arrivals
                .iter()
                .all(|a| a.arrival_ns >= a.capture_ns + 5_000_000)
        );
    }

    #[test]
    fn same_seed_gives_the_same_faults_and_another_seed_others() {
        assert_eq!(run(BAD, 3), run(BAD, 3));
        assert_ne!(run(BAD, 3), run(BAD, 4));
    }

    #[test]
    fn faults_happen_as_often_as_stated() {
        let count = |faults| run(faults, 5).len() as f64 / 1000.0;
        let none = NetworkFaults::default();
        assert_eq!(count(none), 1.0);
        assert!((count(NetworkFaults { loss: 0.2, ..none }) - 0.8).abs() < 0.05);
        assert!(
            (count(NetworkFaults {
                duplicate: 0.2,
                ..none
            }) - 1.2)
                .abs()
                < 0.05
        );
    }

    #[test]
    fn a_stream_keeps_its_order_unless_reordering_is_asked_for() {
        let in_order = |faults| {
            let arrivals = run(faults, 6);
            let mut of_one = arrivals.iter().filter(|a| a.camera == 0).map(|a| a.payload);
            of_one.by_ref().is_sorted()
        };
        let jittery = NetworkFaults {
            jitter_ms: 30.0,
            ..NetworkFaults::default()
        };
        assert!(in_order(jittery));
        assert!(!in_order(NetworkFaults {
            reorder: 0.1,
            reorder_ms: 50.0,
            ..jittery
        }));
    }

    #[test]
    fn a_camera_that_is_cut_off_loses_what_falls_into_that_time_and_nothing_else() {
        let cut = NetworkFaults {
            partition_s: [2.0, 4.5],
            ..BAD
        };
        let first_ns = |camera: usize| 1_000_000_000 + 10_000_000 * camera as u64;
        let falls_into = |time_ns: u64, camera: usize| {
            let from_ns = first_ns(camera) + 2_000_000_000;
            (from_ns..from_ns + 2_500_000_000).contains(&time_ns)
        };
        let passes = |arrival: &Arrival<u32>| {
            let sent_ns = arrival.capture_ns + 5_000_000;
            ![sent_ns, arrival.arrival_ns]
                .into_iter()
                .any(|time_ns| falls_into(time_ns, arrival.camera))
        };
        // The first message of either camera passes, so that both count from it.
        let mut without = run(BAD, 9);
        without.retain(passes);
        assert_eq!(run(cut, 9), without);
        assert!((600..850).contains(&without.len()), "{}", without.len());
    }

    #[test]
    fn nothing_arrives_before_its_time() {
        let mut network = network(
            NetworkFaults {
                delay_ms: 5.0,
                ..NetworkFaults::default()
            },
            1,
        );
        network.send(0, 1_000_000_000, 0, 7);
        assert_eq!(network.next_arrival_ns(), Some(1_005_000_000));
        assert!(network.receive(1_004_999_999).is_none());
        assert_eq!(network.receive(1_005_000_000).map(|a| a.payload), Some(7));
    }

    #[test]
    fn queue_is_bounded() {
        let mut network = network(
            NetworkFaults {
                delay_ms: 5.0,
                ..NetworkFaults::default()
            },
            1,
        );
        for n in 0..5000 {
            network.send(0, 1, 1, n);
        }
        assert_eq!(network.lost(), 5000 - MAX_UNDER_WAY as u64);
    }
}
