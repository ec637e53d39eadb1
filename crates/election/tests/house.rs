//! Elections in a simulated house: nodes that are killed, stopped and continued, a network that delays and is divided,
//! in virtual time.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

use proptest::prelude::*;
use sextant_election::{Company, Election, Input, Moment};
use sextant_proto::{Heartbeat, NodeId};
use sextant_simulator::Random;
use std::collections::BTreeSet;

const MS: u64 = 1_000_000;
/// A node is called this often, ns.
const STEP_NS: u64 = 5 * MS;
/// Longest delay of a message, ns.
const DELAY_NS: u64 = 20 * MS;
/// A link that is cut counts as dead after this time, ns.
const LEASE_NS: u64 = 2_000 * MS;
const WALL_NS: u64 = 1_800_000_000_000_000_000;

#[derive(Debug, Clone)]
enum Event {
    Beat(Heartbeat),
    Left(NodeId),
}

#[derive(Debug)]
struct Node {
    id: NodeId,
    election: Option<Election>,
    stopped: bool,
    half: u8,
    /// With the time of arrival.
    inbox: Vec<(u64, Event)>,
    /// By how much its clocks are ahead, ns.
    offset_ns: u64,
}

/// A pose that a node has published.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Published {
    at_ns: u64,
    node: usize,
    epoch: u64,
}

struct House {
    now_ns: u64,
    nodes: Vec<Node>,
    published: Vec<Published>,
    random: Random,
}

impl House {
    fn new(n: usize, seed: u64) -> Self {
        let node = |k: usize| Node {
            id: NodeId::new(&format!("f{k}")).unwrap(),
            election: None,
            stopped: false,
            half: 0,
            inbox: Vec::new(),
            offset_ns: k as u64 * 777 * MS,
        };
        let mut house = Self {
            now_ns: 10_000 * MS,
            nodes: (0..n).map(node).collect(),
            published: Vec::new(),
            random: Random::new(seed),
        };
        for k in 0..n {
            house.start(k);
            house.run(50 * MS);
        }
        house
    }

    fn delay(&mut self) -> u64 {
        self.random.below(DELAY_NS as usize) as u64
    }

    fn moment(&self, k: usize) -> Moment {
        let offset_ns = self.nodes[k].offset_ns;
        Moment {
            monotonic_ns: self.now_ns + offset_ns,
            wall_ns: WALL_NS + self.now_ns + offset_ns,
        }
    }

    fn start(&mut self, k: usize) {
        if self.nodes[k].election.is_some() {
            return;
        }
        let half = self.nodes[k].half;
        let mut others = self.nodes.iter();
        let company = match others.any(|node| node.election.is_some() && node.half == half) {
            true => Company::Others,
            false => Company::Alone,
        };
        let election = Election::new(self.nodes[k].id.clone(), self.moment(k), company);
        self.nodes[k].inbox.clear();
        self.nodes[k].election = Some(election);
        self.nodes[k].stopped = false;
    }

    fn kill(&mut self, k: usize) {
        self.nodes[k].election = None;
        let id = self.nodes[k].id.clone();
        self.send(k, &Event::Left(id), 0);
    }

    /// To everyone in the same half; to the others `late` later, if ever.
    fn send(&mut self, from: usize, event: &Event, late_ns: u64) {
        for to in 0..self.nodes.len() {
            let is_reached = self.nodes[to].half == self.nodes[from].half;
            if to == from || self.nodes[to].election.is_none() || !is_reached {
                continue;
            }
            let at_ns = self.now_ns + late_ns + self.delay();
            self.nodes[to].inbox.push((at_ns, event.clone()));
        }
    }

    /// Divides the network; each half notices after a link's lease that the other is gone.
    fn cut(&mut self, half: &BTreeSet<usize>) {
        for k in 0..self.nodes.len() {
            self.nodes[k].half = u8::from(half.contains(&k));
        }
        for from in 0..self.nodes.len() {
            for to in 0..self.nodes.len() {
                if self.nodes[from].half != self.nodes[to].half {
                    let gone = Event::Left(self.nodes[from].id.clone());
                    let at_ns = self.now_ns + LEASE_NS;
                    self.nodes[to].inbox.push((at_ns, gone));
                }
            }
        }
    }

    fn heal(&mut self) {
        self.cut(&BTreeSet::new());
    }

    fn run(&mut self, for_ns: u64) {
        let end_ns = self.now_ns + for_ns;
        while self.now_ns < end_ns {
            self.now_ns += STEP_NS;
            for k in 0..self.nodes.len() {
                self.call(k);
            }
        }
    }

    fn call(&mut self, k: usize) {
        let moment = self.moment(k);
        let now_ns = self.now_ns;
        let node = &mut self.nodes[k];
        let Some(election) = node.election.as_mut().filter(|_| !node.stopped) else {
            return;
        };
        let (arrived, rest): (Vec<_>, Vec<_>) = std::mem::take(&mut node.inbox)
            .into_iter()
            .partition(|(at_ns, _)| *at_ns <= now_ns);
        node.inbox = rest;
        for (_, event) in &arrived {
            let input = match event {
                Event::Beat(beat) => Input::Heartbeat(beat),
                Event::Left(id) => Input::Left(id),
            };
            election.handle(moment, input);
        }
        election.handle(moment, Input::Tick);
        if let Some(epoch) = election.epoch(moment.monotonic_ns) {
            self.published.push(Published {
                at_ns: now_ns,
                node: k,
                epoch,
            });
        }
        let beat = election.poll_heartbeat(moment.monotonic_ns);
        if let Some(beat) = beat {
            self.send(k, &Event::Beat(beat), 0);
        }
    }

    /// Those that published within the last 50 ms.
    fn publishers(&self) -> BTreeSet<usize> {
        let recent = |one: &&Published| one.at_ns + 50 * MS > self.now_ns;
        let recent = self.published.iter().rev().take_while(recent);
        recent.map(|one| one.node).collect()
    }

    fn publisher(&self) -> usize {
        let publishers = self.publishers();
        assert_eq!(publishers.len(), 1, "{publishers:?}");
        *publishers.first().unwrap()
    }

    /// The longest time without a pose since then, ns.
    fn longest_gap_ns(&self, since_ns: u64) -> u64 {
        let times = self.published.iter().map(|one| one.at_ns);
        let times: Vec<u64> = times.filter(|at_ns| *at_ns >= since_ns).collect();
        let gaps = times.windows(2).map(|pair| pair[1] - pair[0]);
        let first = times.first().map_or(u64::MAX, |at_ns| at_ns - since_ns);
        gaps.chain([first]).max().unwrap()
    }

    fn epochs(&self) -> BTreeSet<u64> {
        self.published.iter().map(|one| one.epoch).collect()
    }
}

/// A quiet house: the first has published from the start, the others never.
fn quiet(n: usize, seed: u64) -> House {
    let mut house = House::new(n, seed);
    house.run(3_000 * MS);
    assert_eq!(house.publisher(), 0);
    assert_eq!(house.epochs().len(), 1, "no other node has ever published");
    assert_eq!(house.longest_gap_ns(house.published[0].at_ns), STEP_NS);
    house
}

#[test]
fn one_node_alone_publishes_at_once_and_after_any_pause() {
    let mut house = quiet(1, 1);
    house.nodes[0].stopped = true;
    house.run(10_000 * MS);
    house.nodes[0].stopped = false;
    house.run(STEP_NS);
    assert_eq!(house.publisher(), 0);
    assert_eq!(house.epochs().len(), 1);
}

#[test]
fn a_pause_too_short_for_a_takeover_costs_no_epoch() {
    let mut house = quiet(3, 2);
    for pause_ms in [20, 60, 95, 110, 120] {
        house.nodes[0].stopped = true;
        house.run(pause_ms * MS);
        house.nodes[0].stopped = false;
        house.run(500 * MS);
        assert_eq!(house.publisher(), 0, "{pause_ms}");
    }
    assert_eq!(house.epochs().len(), 1);
}

/// It received no heartbeat because it was stopped itself.
#[test]
fn a_standby_that_was_stopped_takes_nothing_over() {
    let mut house = quiet(2, 3);
    house.nodes[1].stopped = true;
    house.run(7_000 * MS);
    house.nodes[1].stopped = false;
    house.run(1_000 * MS);
    assert_eq!((house.publisher(), house.epochs().len()), (0, 1));
}

/// Otherwise a busy successor would wait for the answer of the node that it has replaced.
#[test]
fn an_interrupted_publisher_does_not_wait_for_a_node_that_was_silent_before() {
    let mut house = quiet(2, 6);
    house.nodes[1].stopped = true;
    house.run(300 * MS);
    house.nodes[0].stopped = true;
    house.run(150 * MS);
    house.nodes[0].stopped = false;
    house.run(STEP_NS);
    assert_eq!(house.published.last().unwrap().at_ns, house.now_ns);
}

#[test]
fn both_halves_of_a_divided_network_are_served_and_one_remains() {
    let mut house = quiet(4, 4);
    let cut_ns = house.now_ns;
    house.cut(&BTreeSet::from([2, 3]));
    house.run(10_000 * MS);
    assert_eq!(house.publishers(), BTreeSet::from([0, 2]));
    let other = house.published.iter().find(|one| one.node == 2).unwrap();
    assert!(other.at_ns - cut_ns <= 300 * MS);
    house.heal();
    house.run(200 * MS);
    assert_eq!(house.publisher(), 2, "the newer epoch stays");
    house.run(5_000 * MS);
    assert_eq!((house.publisher(), house.epochs().len()), (2, 2));
}

/// A standby knows of an epoch that a publisher in the other half has had.
#[test]
fn a_publisher_learns_of_a_newer_epoch_whose_node_is_gone() {
    let mut house = quiet(3, 5);
    house.cut(&BTreeSet::from([1, 2]));
    house.run(3_000 * MS);
    house.kill(1);
    house.nodes[2].stopped = true;
    house.heal();
    house.nodes[2].stopped = false;
    house.run(3_000 * MS);
    let newest = *house.epochs().last().unwrap();
    let publisher = house.publisher();
    assert_eq!(house.published.last().unwrap().epoch, newest);
    assert!(publisher != 1);
}

#[derive(Debug, Clone)]
enum Fault {
    Kill(usize),
    Stop(usize),
    Continue(usize),
    Start(usize),
    Cut(BTreeSet<usize>),
    Heal,
}

const NODES: usize = 4;

fn fault() -> impl Strategy<Value = Fault> {
    let node = 0..NODES;
    prop_oneof![
        node.clone().prop_map(Fault::Kill),
        node.clone().prop_map(Fault::Stop),
        node.clone().prop_map(Fault::Continue),
        node.clone().prop_map(Fault::Start),
        proptest::collection::btree_set(node, 1..NODES).prop_map(Fault::Cut),
        Just(Fault::Heal),
    ]
}

fn suffer(house: &mut House, fault: &Fault) {
    match fault {
        Fault::Kill(k) => house.kill(*k),
        Fault::Stop(k) => house.nodes[*k].stopped = true,
        Fault::Continue(k) => house.nodes[*k].stopped = false,
        Fault::Start(k) => house.start(*k),
        Fault::Cut(half) => house.cut(half),
        Fault::Heal => house.heal(),
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 300, failure_persistence: None, ..ProptestConfig::default() })]

    /// Another publishes within 300 ms, and when the first is back it changes nothing.
    #[test]
    fn a_publisher_that_is_killed_stopped_or_cut_off_is_replaced(
        seed: u64,
        n in 2..=NODES,
        how in 0..3,
        phase_ns in 0..1_000_u64,
        away_ms in 300..20_000_u64,
    ) {
        let mut house = quiet(n, seed);
        house.run(phase_ns * MS);
        let since_ns = house.now_ns;
        match how {
            0 => house.kill(0),
            1 => house.nodes[0].stopped = true,
            _ => house.cut(&BTreeSet::from([0])),
        }
        house.run(away_ms * MS);
        let others: Vec<_> = house.published.iter().filter(|one| one.node != 0).copied().collect();
        prop_assert!(others[0].at_ns - since_ns <= 300 * MS, "{}", others[0].at_ns - since_ns);
        let successor = others[0].node;
        match how {
            0 => house.start(0),
            1 => house.nodes[0].stopped = false,
            _ => house.heal(),
        }
        house.run(5_000 * MS);
        prop_assert_eq!(house.publisher(), successor);
        prop_assert_eq!(house.epochs().len(), 2);
        if how < 2 {
            // Nobody was cut off: what is published is never of an older epoch.
            let epochs: Vec<u64> = house.published.iter().map(|one| one.epoch).collect();
            prop_assert!(epochs.is_sorted());
        }
    }

    /// Whatever has happened: soon after it is over exactly one publishes, and goes on.
    #[test]
    fn after_any_faults_exactly_one_publishes(
        seed: u64,
        faults in proptest::collection::vec((0..3_000_u64, fault()), 0..12),
    ) {
        let mut house = House::new(NODES, seed);
        for (pause_ms, fault) in &faults {
            suffer(&mut house, fault);
            house.run(pause_ms * MS);
        }
        house.heal();
        for k in 0..NODES {
            house.nodes[k].stopped = false;
            house.start(k);
        }
        // Links that were cut shortly before have their lease yet to run out.
        house.run(2 * LEASE_NS);
        house.run(1_000 * MS);
        let calm_ns = house.now_ns;
        house.run(3_000 * MS);
        let calm = house.published.iter().filter(|one| one.at_ns > calm_ns);
        let publishers: BTreeSet<_> = calm.map(|one| (one.node, one.epoch)).collect();
        prop_assert_eq!(publishers.len(), 1);
        prop_assert_eq!(house.longest_gap_ns(calm_ns), STEP_NS);
        // One epoch, one node.
        for epoch in house.epochs() {
            let of_epoch = house.published.iter().filter(|one| one.epoch == epoch);
            let nodes: BTreeSet<usize> = of_epoch.map(|one| one.node).collect();
            prop_assert_eq!(nodes.len(), 1);
        }
    }

    /// No sequence of heartbeats, true or forged, makes a node panic or its heartbeat invalid.
    #[test]
    fn any_inputs_are_taken(
        inputs in proptest::collection::vec(
            (0..400_u64, 0..20_usize, any::<Option<u64>>(), any::<u64>(), any::<u64>()),
            0..200,
        ),
    ) {
        let id = |k: usize| NodeId::new(&format!("f{k}")).unwrap();
        let mut now = Moment { monotonic_ns: 0, wall_ns: WALL_NS };
        let mut election = Election::new(id(7), now, Company::Others);
        for (pause_ms, k, epoch, newest, sent_ns) in inputs {
            now.monotonic_ns += pause_ms * MS;
            let beat = Heartbeat {
                node: id(k),
                sent_ns,
                epoch,
                newest,
                heard: Vec::new(),
                sharing: None,
                models: Default::default(),
            };
            election.handle(now, Input::Heartbeat(&beat));
            election.handle(now, Input::Tick);
            if let Some(beat) = election.poll_heartbeat(now.monotonic_ns) {
                sextant_proto::encode(&beat).unwrap();
            }
            prop_assert!(election.poll_timeout() <= now.monotonic_ns + 50 * MS);
        }
    }
}
