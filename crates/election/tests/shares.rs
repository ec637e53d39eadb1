//! Nodes that share objects: who tracks and publishes what, in virtual time, as nodes come and go.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

use proptest::prelude::*;
use sextant_election::{Assignment, Company, Election, Input, Moment, Sharding, ranking};
use sextant_proto::{Heartbeat, NodeId};
use sextant_site_model::ObjectId;
use std::collections::{BTreeMap, BTreeSet};

const MS: u64 = 1_000_000;
const STEP_NS: u64 = 5 * MS;
const WALL_NS: u64 = 1_800_000_000_000_000_000;

fn node(k: usize) -> NodeId {
    NodeId::new(&format!("f{k}")).unwrap()
}

fn objects(n: usize) -> Vec<ObjectId> {
    let id = |k| ObjectId::new(&format!("o{k}")).unwrap();
    (0..n).map(id).collect()
}

/// The first of the ranking of each object.
fn firsts(nodes: &[NodeId], objects: &[ObjectId]) -> Vec<NodeId> {
    let first = |object| ranking(nodes, object)[0].clone();
    objects.iter().map(first).collect()
}

struct Member {
    election: Election,
    sharding: Sharding,
    /// With the time of arrival.
    inbox: Vec<(u64, Heartbeat)>,
}

/// Nodes that see all objects all the time, on a network that delays.
struct Site {
    now_ns: u64,
    objects: Vec<ObjectId>,
    members: BTreeMap<usize, Member>,
    /// Time, object, node and epoch of each pose.
    poses: Vec<(u64, usize, usize, u64)>,
}

impl Site {
    fn new(nodes: usize, n_objects: usize) -> Self {
        let mut site = Self {
            now_ns: 10_000 * MS,
            objects: objects(n_objects),
            members: BTreeMap::new(),
            poses: Vec::new(),
        };
        for k in 0..nodes {
            site.start(k, Assignment::ByMembers { standbys: 1 });
            site.run(20 * MS);
        }
        site
    }

    /// The clocks of the nodes differ.
    fn moment(&self, k: usize) -> Moment {
        let ahead_ns = k as u64 * 777 * MS;
        Moment {
            monotonic_ns: self.now_ns + ahead_ns,
            wall_ns: WALL_NS + self.now_ns - ahead_ns,
        }
    }

    fn start(&mut self, k: usize, assignment: Assignment) {
        let company = match self.members.is_empty() {
            true => Company::Alone,
            false => Company::Others,
        };
        let now = self.moment(k);
        let mut sharding = Sharding::new(node(k), assignment, now, company);
        sharding.set_objects(&self.objects);
        let member = Member {
            election: Election::new(node(k), now, company),
            sharding,
            inbox: Vec::new(),
        };
        self.members.insert(k, member);
    }

    fn kill(&mut self, k: usize) {
        self.members.remove(&k);
        for other in self.members.keys().copied().collect::<Vec<_>>() {
            let now = self.moment(other);
            let election = &mut self.members.get_mut(&other).unwrap().election;
            election.handle(now, Input::Left(&node(k)));
        }
    }

    fn run(&mut self, for_ns: u64) {
        let end_ns = self.now_ns + for_ns;
        while self.now_ns < end_ns {
            self.now_ns += STEP_NS;
            let order: Vec<usize> = self.members.keys().copied().collect();
            let beats: Vec<(usize, Heartbeat)> = order
                .into_iter()
                .filter_map(|k| Some((k, self.call(k)?)))
                .collect();
            for (from, beat) in beats {
                for (to, member) in &mut self.members {
                    let delay_ns = (3 + (7 * from + 5 * to) as u64 % 20) * MS;
                    member.inbox.push((self.now_ns + delay_ns, beat.clone()));
                }
            }
        }
    }

    /// A turn of a node, which sees all that it tracks.
    fn call(&mut self, k: usize) -> Option<Heartbeat> {
        let (now, now_ns) = (self.moment(k), self.now_ns);
        let member = self.members.get_mut(&k)?;
        let Member {
            election,
            sharding,
            inbox,
        } = member;
        for (_, beat) in inbox.extract_if(.., |(at_ns, _)| *at_ns <= now_ns) {
            election.handle(now, Input::Heartbeat(&beat));
            sharding.hear(&beat);
        }
        election.handle(now, Input::Tick);
        if sharding.evaluate(now, election) {
            election.hasten_heartbeat(now.monotonic_ns);
        }
        for (index, object) in self.objects.iter().enumerate() {
            sharding.see(object, now.monotonic_ns);
            if let Some(epoch) = sharding.epoch(object)
                && election.is_sure(now.monotonic_ns)
            {
                self.poses.push((now_ns, index, k, epoch));
            }
        }
        let mut beat = election.poll_heartbeat(now.monotonic_ns)?;
        beat.sharing = Some(sharding.announcement(now.monotonic_ns));
        sextant_proto::encode(&beat).unwrap();
        Some(beat)
    }

    /// The publishers of each object in the last 10 ms.
    fn publishers(&self) -> Vec<BTreeSet<usize>> {
        let mut publishers = vec![BTreeSet::new(); self.objects.len()];
        let recent = self.poses.iter().rev();
        for (_, object, node, _) in recent.take_while(|one| one.0 + 10 * MS > self.now_ns) {
            publishers[*object].insert(*node);
        }
        publishers
    }

    fn trackers(&self, object: &ObjectId) -> BTreeSet<usize> {
        let members = self.members.iter();
        let trackers = members.filter(|(_, member)| member.sharding.tracks(object));
        trackers.map(|(k, _)| *k).collect()
    }

    /// Each object is published by the first of its ranking, and tracked by the first two.
    fn assert_settled(&self) {
        let nodes: Vec<NodeId> = self.members.keys().map(|k| node(*k)).collect();
        let publishers = self.publishers();
        for (index, object) in self.objects.iter().enumerate() {
            let ranked = ranking(&nodes, object);
            let number = |id: &&NodeId| id.as_str()[1..].parse::<usize>().unwrap();
            let first_two: BTreeSet<usize> = ranked.iter().take(2).map(number).collect();
            assert_eq!(
                publishers[index],
                BTreeSet::from([number(&ranked[0])]),
                "{object}"
            );
            assert_eq!(self.trackers(object), first_two, "{object}");
        }
    }

    /// The longest time without a pose of an object that a subscriber uses, ns; epochs that subscribers use never fall.
    fn longest_gap_ns(&self, since_ns: u64) -> u64 {
        let gap = |index: usize| {
            let (mut newest, mut last_ns, mut longest_ns) = (0, since_ns, 0);
            let own = self.poses.iter().filter(|one| one.1 == index);
            for (at_ns, _, _, epoch) in own.filter(|one| one.0 >= since_ns) {
                if *epoch >= newest {
                    newest = *epoch;
                    longest_ns = longest_ns.max(at_ns - last_ns);
                    last_ns = *at_ns;
                }
            }
            longest_ns.max(self.now_ns - last_ns)
        };
        (0..self.objects.len()).map(gap).max().unwrap()
    }
}

#[test]
fn a_node_alone_has_all_objects_at_once() {
    let mut site = Site::new(1, 5);
    site.run(100 * MS);
    site.assert_settled();
}

#[test]
fn objects_move_without_a_gap_when_nodes_come_and_go() {
    let mut site = Site::new(3, 40);
    site.run(3_000 * MS);
    site.assert_settled();
    let mut since_ns = site.now_ns;
    for k in [3, 4] {
        site.start(k, Assignment::ByMembers { standbys: 1 });
        site.run(3_000 * MS);
        site.assert_settled();
    }
    assert_eq!(site.longest_gap_ns(since_ns), STEP_NS, "nobody was killed");
    for k in [1, 3] {
        since_ns = site.now_ns;
        site.kill(k);
        site.run(3_000 * MS);
        site.assert_settled();
        let gap_ns = site.longest_gap_ns(since_ns);
        assert!(gap_ns <= 200 * MS, "{gap_ns}");
    }
}

/// A newcomer is first of some objects, and the former standby is needed until it is ready.
#[test]
fn a_standby_stays_until_others_are_ready() {
    let mut site = Site::new(2, 40);
    site.run(3_000 * MS);
    site.start(2, Assignment::ByMembers { standbys: 1 });
    site.run(900 * MS);
    for object in &site.objects {
        assert!(site.trackers(object).is_superset(&BTreeSet::from([0, 1])));
    }
    let since_ns = site.now_ns;
    for k in [0, 1] {
        site.kill(k);
        site.run(2_000 * MS);
    }
    assert!(site.longest_gap_ns(since_ns) <= 200 * MS);
    site.assert_settled();
}

#[test]
fn a_node_whose_objects_are_fixed_has_these_and_no_others() {
    let mut site = Site::new(0, 4);
    let part = |names: &[usize]| {
        let all = objects(4);
        Assignment::Fixed(names.iter().map(|k| all[*k].clone()).collect())
    };
    site.start(0, part(&[0, 1]));
    site.start(1, part(&[2]));
    site.start(2, part(&[2]));
    site.run(3_000 * MS);
    let first = firsts(&[node(1), node(2)], &site.objects)[2] == node(1);
    let first = if first { 1 } else { 2 };
    let expected = [0, 0, first].map(|k| BTreeSet::from([k]));
    let publishers = site.publishers();
    assert_eq!(publishers[..3], expected);
    assert!(publishers[3].is_empty(), "nobody's");
    site.kill(first);
    site.run(500 * MS);
    assert_eq!(site.publishers()[2], BTreeSet::from([3 - first]));
}

#[test]
fn a_node_of_another_mode_is_named_once() {
    let now = Moment {
        monotonic_ns: 0,
        wall_ns: WALL_NS,
    };
    let by_members = Assignment::ByMembers { standbys: 1 };
    let mut sharding = Sharding::new(node(0), by_members, now, Company::Alone);
    let mut election = Election::new(node(1), now, Company::Alone);
    let mut beat = election.poll_heartbeat(0).unwrap();
    assert!(sharding.hear(&beat));
    assert!(!sharding.hear(&beat));
    for (standbys, is_named) in [(1, false), (0, true), (0, false)] {
        let other = Assignment::ByMembers { standbys };
        let other = Sharding::new(node(1), other, now, Company::Alone);
        beat.sharing = Some(other.announcement(0));
        assert_eq!(sharding.hear(&beat), is_named, "{standbys}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 30, failure_persistence: None, ..ProptestConfig::default() })]

    /// Rendezvous hashing: only the objects of a node that goes move, and a node that comes takes its part.
    #[test]
    fn the_objects_of_a_node_that_goes_move_and_no_others(n in 2..8_usize, gone in 0..8_usize) {
        let nodes: Vec<NodeId> = (0..n).map(node).collect();
        let rest: Vec<NodeId> = nodes.iter().filter(|one| **one != node(gone % n)).cloned().collect();
        let objects = objects(1000);
        let (with, without) = (firsts(&nodes, &objects), firsts(&rest, &objects));
        let moved = with.iter().zip(&without).filter(|(before, after)| before != after);
        let moved: Vec<_> = moved.map(|(before, _)| before.clone()).collect();
        prop_assert!(moved.iter().all(|before| *before == node(gone % n)));
        let share = moved.len() as f64 * n as f64 / 1000.0;
        prop_assert!((0.75..1.25).contains(&share), "{share}");
    }

    /// Whoever comes and goes: soon after it is over each object has one publisher, the first of its ranking.
    #[test]
    fn after_any_changes_each_object_has_one_publisher(
        changes in proptest::collection::vec((0..800_u64, 0..5_usize), 1..10),
    ) {
        let mut site = Site::new(2, 12);
        for (pause_ms, k) in changes {
            if site.members.contains_key(&k) {
                site.kill(k);
            } else {
                site.start(k, Assignment::ByMembers { standbys: 1 });
            }
            site.run(pause_ms * MS);
        }
        site.start(7, Assignment::ByMembers { standbys: 1 });
        site.run(3_000 * MS);
        site.assert_settled();
        let calm_ns = site.now_ns;
        site.run(1_000 * MS);
        prop_assert_eq!(site.longest_gap_ns(calm_ns), STEP_NS);
    }
}
