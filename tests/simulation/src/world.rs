//! The site in simulated time: one queue of events, every process, the network between them.

use crate::coverage::Coverage;
use crate::disk::Disk;
use crate::followers::{ANSWER_NS, Follower, UPDATE_NS};
use crate::fusion::{Conditions, Effect, Process, Step, item_of};
use crate::host::wall_ns;
use crate::network::{LEASE_NS, Network};
use crate::plan::{FaultKind, MS, Place, Plan};
use crate::promises::{Promises, PublicationContext, Violation};
use crate::recorder::Recorder;
use crate::scene::Scene;
use crate::trace::described;
use node_fusion::{FusionConfig, Put, Refinement, ShardingConfig};
use sextant_proto::{
    ClockQuality, ClockSource, KeyRef, Keys, NodeId, NodeKind, Observations, SiteId, Timing, encode,
};
use sextant_simulator::{Random, Schedule};
use sextant_zenoh_bus::{BusOptions, Item, Payload, Presence, Qos, SecurityOptions};
use std::cmp::Reverse;
use std::collections::{BTreeMap, BTreeSet, BinaryHeap};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::rc::Rc;

/// From the middle of an exposure to the observation.
const DETECTION_NS: u64 = 6 * MS;
/// Between two attempts to start where the network is missing, or the name is taken.
const RETRY_NS: u64 = 200 * MS;

#[derive(Debug)]
enum Event {
    /// A fusion node's process starts.
    Start(usize),
    /// A fusion node has a turn, unless it was given another meanwhile.
    Turn(usize),
    /// A camera takes its next image.
    Image(usize),
    /// A message arrives.
    Message(Place, Rc<Item>),
    /// A token appears or is gone for a fusion node.
    Presence(usize, Presence),
    /// A node is asked for its models, by another, in whose life.
    Question(usize, usize, u64),
    /// Its answers arrive.
    Answers(usize, usize, u64, Vec<Item>),
    /// A follower looks for changes.
    Update(Place),
    /// A fusion node is asked for what it keeps, by a follower, with the number of the question.
    KeptQuestion(usize, Place, u64),
    /// Its answers arrive.
    KeptAnswers(Place, usize, u64, Vec<Item>),
    /// A question is not waited for any longer.
    KeptTimeout(Place, u64),
    /// Something begins or ends.
    TurningPoint,
    /// The client asks for a change.
    ChangeRequest(usize),
}

/// Sorted by time, then by the order of their making.
struct ScheduledEvent {
    at_ns: u64,
    number: u64,
    event: Event,
}

impl PartialEq for ScheduledEvent {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other).is_eq()
    }
}

impl Eq for ScheduledEvent {}

impl PartialOrd for ScheduledEvent {
    fn partial_cmp(&self, other: &Self) -> Option<std::cmp::Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for ScheduledEvent {
    fn cmp(&self, other: &Self) -> std::cmp::Ordering {
        (self.at_ns, self.number).cmp(&(other.at_ns, other.number))
    }
}

/// A fusion node's host.
struct Host {
    config: FusionConfig,
    disk: Disk,
    process: Option<Process>,
    /// Counts its processes.
    life: u64,
    next_turn_ns: u64,
    /// The fusion nodes that it sees.
    seen: BTreeSet<usize>,
}

/// What a run showed.
#[derive(Debug, Clone)]
pub struct Outcome {
    /// The first promise that was broken.
    pub broken: Option<Violation>,
    /// Poses that the client used.
    pub poses: u64,
    /// Tells all messages of the run from those of another.
    pub fingerprint: u64,
    /// Which faults met which states.
    pub coverage: Coverage,
}

/// Runs a site to its end, or to the first promise that is broken. With `traces`, what happens is printed.
#[must_use]
pub fn run(plan: &Plan, traces: bool) -> Outcome {
    let whole = || World::new(plan, traces).run();
    catch_unwind(AssertUnwindSafe(whole)).unwrap_or_else(|_| Outcome {
        broken: Some(Violation {
            at_ns: 0,
            promise: "nothing panics",
            how: "its message stands above".to_owned(),
        }),
        poses: 0,
        fingerprint: 0,
        coverage: Coverage::default(),
    })
}

/// The site.
struct World<'a> {
    plan: &'a Plan,
    keys: Keys,
    scene: Scene,
    network: Network,
    hosts: Vec<Host>,
    followers: BTreeMap<Place, Follower>,
    schedules: Vec<Schedule>,
    sequences: Vec<u64>,
    /// By how much the clocks of cameras are off.
    clocks_off_ns: Vec<i64>,
    due: BinaryHeap<Reverse<ScheduledEvent>>,
    number: u64,
    promises: Promises,
    /// Where there is one.
    recorder: Option<Recorder>,
    fingerprint: u64,
    coverage: Coverage,
    traces: bool,
}

impl<'a> World<'a> {
    fn new(plan: &'a Plan, traces: bool) -> Self {
        let site: SiteId = "lab".parse().expect("a site");
        let keys = Keys::for_site(site.clone());
        let scene = Scene::new(plan);
        let mut random = Random::from_keys(&[plan.seed, 0x776f_726c]);
        let hosts = (0..plan.nodes).map(|index| {
            let node = node(index);
            Host {
                config: config(plan, &site, &node),
                disk: Disk {
                    models: scene.models(),
                    record: None,
                    journal: None,
                },
                process: None,
                life: 0,
                next_turn_ns: u64::MAX,
                seen: BTreeSet::new(),
            }
        });
        let cameras = (0..plan.cameras).map(|index| {
            let follower = Follower::camera(&keys, scene.camera(index));
            (Place::Camera(index), follower)
        });
        let client = (Place::Client, Follower::client(&keys));
        let off_ns = plan.clocks_off_ns as f64;
        let mut world = Self {
            hosts: hosts.collect(),
            followers: cameras.chain([client]).collect(),
            schedules: (0..plan.cameras)
                .map(|_| Schedule::new(plan.rate_hz, random.uniform()))
                .collect(),
            sequences: vec![0; plan.cameras],
            clocks_off_ns: (0..plan.cameras)
                .map(|_| (random.between(-1.0, 1.0) * off_ns) as i64)
                .collect(),
            network: Network::new(plan),
            promises: Promises::new(plan, scene.objects().collect()),
            recorder: plan.records.then(Recorder::default),
            due: BinaryHeap::new(),
            number: 0,
            fingerprint: 0xcbf2_9ce4_8422_2325,
            coverage: Coverage::default(),
            traces,
            plan,
            keys,
            scene,
        };
        if traces {
            println!("clocks of cameras off by {:?} ns", world.clocks_off_ns);
        }
        for (index, at_ns) in plan.starts_ns.iter().enumerate() {
            world.at(*at_ns, Event::Start(index));
        }
        for camera in 0..plan.cameras {
            let first_ns = world.schedules[camera].next_at_or_after(0);
            world.at(first_ns, Event::Image(camera));
        }
        let places: Vec<Place> = world.followers.keys().copied().collect();
        for place in places {
            world.at(random.below(200) as u64 * MS, Event::Update(place));
        }
        for at_ns in world.network.turning_points() {
            world.at(at_ns, Event::TurningPoint);
        }
        for (index, (at_ns, _)) in plan.requests.iter().enumerate() {
            world.at(*at_ns, Event::ChangeRequest(index));
        }
        world
    }

    fn at(&mut self, at_ns: u64, event: Event) {
        self.number += 1;
        let number = self.number;
        self.due.push(Reverse(ScheduledEvent {
            at_ns,
            number,
            event,
        }));
    }

    fn run(mut self) -> Outcome {
        while let Some(Reverse(due)) = self.due.pop() {
            if due.at_ns >= self.plan.end_ns || self.promises.broken().is_some() {
                break;
            }
            self.happen(due.at_ns, due.event);
        }
        let state = |host: &Host| host.process.as_ref().map(|process| process.core.state());
        let states: Vec<_> = self.hosts.iter().map(state).collect();
        let processes = self.hosts.iter().filter_map(|host| host.process.as_ref());
        let mut leading = processes.filter(|process| process.core.state().leads);
        let models = leading.next().map(|process| process.core.models());
        let is_up = |place: &Place| !self.is_down(*place, self.plan.end_ns);
        let followers = self.followers.iter().filter(|(place, _)| is_up(place));
        let cameras = followers.filter_map(|(place, follower)| Some((*place, follower.models()?)));
        let cameras: Vec<_> = cameras.collect();
        let replayed = self.recorder.take().and_then(Recorder::contradiction);
        self.promises.end(&states, models, &cameras, replayed);
        Outcome {
            broken: self.promises.broken().cloned(),
            poses: self.promises.poses(),
            fingerprint: self.fingerprint,
            coverage: self.coverage,
        }
    }

    fn trace(&self, at_ns: u64, words: impl FnOnce() -> String) {
        if self.traces {
            println!("{:10.4} {}", at_ns as f64 * 1e-9, words());
        }
    }

    fn has(&self, at_ns: u64, wrong: impl Fn(&FaultKind) -> bool) -> bool {
        let mut lasting = self.plan.faults.iter().filter(|fault| fault.lasts(at_ns));
        lasting.any(|fault| wrong(&fault.kind))
    }

    fn is_down(&self, place: Place, at_ns: u64) -> bool {
        self.has(
            at_ns,
            |wrong| matches!(wrong, FaultKind::Killed(of) | FaultKind::PowerOff(of) if *of == place),
        )
    }

    fn is_paused(&self, place: Place, at_ns: u64) -> bool {
        self.has(
            at_ns,
            |wrong| matches!(wrong, FaultKind::Paused(of) if *of == place),
        )
    }

    fn happen(&mut self, at_ns: u64, event: Event) {
        match event {
            Event::Start(index) => self.start(index, at_ns),
            Event::Turn(index) => self.turn(index, at_ns),
            Event::Image(camera) => self.image(camera, at_ns),
            Event::Message(to, item) => self.receive(to, &item, at_ns),
            Event::Presence(index, change) => {
                if let Some(process) = &mut self.hosts[index].process {
                    process.presence(change);
                }
            }
            Event::Question(asked, asking, life) => self.answer(asked, asking, life, at_ns),
            Event::Answers(asking, asked, life, items) => {
                let node = node(asked);
                let host = &mut self.hosts[asking];
                if let Some(process) = host.process.as_mut().filter(|_| host.life == life) {
                    process.answered(&node, items);
                }
            }
            Event::Update(place) => self.update(place, at_ns),
            Event::KeptQuestion(asked, asking, number) => {
                self.answer_kept(asked, asking, number, at_ns);
            }
            Event::KeptAnswers(asking, asked, number, items) => {
                let follower = self.followers.get_mut(&asking);
                if follower.is_some_and(|follower| follower.answer(number, asked, items)) {
                    self.end_question(asking, number, at_ns);
                }
            }
            Event::KeptTimeout(asking, number) => self.end_question(asking, number, at_ns),
            Event::TurningPoint => self.turn_point(at_ns),
            Event::ChangeRequest(index) => self.request(index, at_ns),
        }
    }
}

/// Processes of fusion nodes.
impl World<'_> {
    fn conditions(&self, index: usize, at_ns: u64) -> Conditions {
        let place = Place::Fusion(index);
        let (mut disk_ns, mut overload_ns) = (Some(2 * MS), 0);
        for fault in self.plan.faults.iter().filter(|fault| fault.lasts(at_ns)) {
            match fault.kind {
                FaultKind::SlowDisk(of, each_ns) if of == index => {
                    disk_ns = disk_ns.map(|_| each_ns)
                }
                FaultKind::FullDisk(of) if of == index => disk_ns = None,
                FaultKind::Overloaded(of, by_ns) if of == index => overload_ns = by_ns,
                _ => {}
            }
        }
        Conditions {
            at_ns,
            wall_ns: wall_ns(&self.plan.faults, place, 0, at_ns),
            is_linked: self.network.is_linked(place, at_ns),
            disk_ns,
            overload_ns,
        }
    }

    /// Whether a host has lost its power so recently that its link does not count as dead yet.
    fn has_lost_power(&self, place: Place, at_ns: u64) -> bool {
        self.plan.faults.iter().any(|fault| {
            let lasts = (fault.from_ns..fault.from_ns + LEASE_NS).contains(&at_ns);
            lasts && fault.kind == FaultKind::PowerOff(place)
        })
    }

    /// The fusion nodes whose tokens someone sees. That of a host without power is there until its link counts as dead.
    fn nodes_seen(&self, own: Place, at_ns: u64) -> BTreeSet<usize> {
        let seen = (0..self.hosts.len()).filter(|other| {
            let place = Place::Fusion(*other);
            if place == own {
                return false;
            }
            let is_there =
                self.hosts[*other].process.is_some() && self.network.sees(own, place, at_ns);
            is_there || self.network.is_linked(own, at_ns) && self.has_lost_power(place, at_ns)
        });
        seen.collect()
    }

    fn start(&mut self, index: usize, at_ns: u64) {
        let place = Place::Fusion(index);
        if self.is_down(place, at_ns) || self.hosts[index].process.is_some() {
            return;
        }
        let waits = !self.network.is_linked(place, at_ns) || self.has_lost_power(place, at_ns);
        if waits || self.is_paused(place, at_ns) {
            return self.at(at_ns + RETRY_NS, Event::Start(index));
        }
        self.forget_token(index, at_ns);
        let seen = self.nodes_seen(place, at_ns);
        let others = seen.iter().map(|other| node(*other)).collect();
        let at = self.conditions(index, at_ns);
        let host = &mut self.hosts[index];
        host.life += 1;
        host.seen = seen;
        host.process = Some(Process::start(&host.config, &mut host.disk, others, at));
        host.next_turn_ns = at_ns;
        self.promises.started(index, at_ns);
        self.trace(at_ns, || format!("{place} starts"));
        self.at(at_ns, Event::Turn(index));
        self.update_presence(at_ns);
    }

    fn turn(&mut self, index: usize, at_ns: u64) {
        let place = Place::Fusion(index);
        if self.hosts[index].next_turn_ns != at_ns {
            return;
        }
        if self.is_paused(place, at_ns) {
            let faults = self.plan.faults.iter();
            let ends =
                faults.filter(|fault| fault.lasts(at_ns) && fault.kind == FaultKind::Paused(place));
            let until_ns = ends.map(|fault| fault.until_ns).max().unwrap_or(at_ns + MS);
            return self.schedule_turn(index, until_ns);
        }
        let at = self.conditions(index, at_ns);
        let host = &mut self.hosts[index];
        let Some(process) = &mut host.process else {
            return;
        };
        let (promises, scene, network) = (&mut self.promises, &self.scene, &self.network);
        let mut observer = |step: Step<'_>| match step {
            Step::Reads(heartbeat) => promises.record_heartbeat(index, heartbeat),
            Step::Publishes(put, core, disk) => promises.handle_publication(&PublicationContext {
                index,
                put,
                core,
                disk,
                scene,
                network,
                at_ns,
            }),
        };
        let (effects, next_ns) = process.turn(at, &mut host.disk, &mut observer);
        self.schedule_turn(index, next_ns);
        for (effect_ns, effect) in effects {
            match effect {
                Effect::Publish(put) => self.publish(index, &put, effect_ns),
                Effect::Ask(node) => self.ask(index, &node, effect_ns),
            }
        }
        self.watch(index, at_ns);
    }

    fn schedule_turn(&mut self, index: usize, at_ns: u64) {
        self.hosts[index].next_turn_ns = at_ns;
        self.at(at_ns, Event::Turn(index));
    }

    /// Sends a message of a node to its subscribers.
    fn publish(&mut self, index: usize, put: &Put, at_ns: u64) {
        let place = Place::Fusion(index);
        self.note(&put.key, &put.payload);
        if let Some(recorder) = &mut self.recorder {
            recorder.message(index, &self.keys, put, at_ns);
        }
        let item = Rc::new(item_of(put));
        let about = self.keys.parse(&put.key);
        self.trace_message(index, put, at_ns);
        match about {
            Some(KeyRef::Heartbeat(_)) => self.send_to_fusion_nodes(place, &item, true, at_ns),
            Some(key) if key.is_config() => {
                self.send_to_fusion_nodes(place, &item, false, at_ns);
                self.send_to_followers(place, &item, at_ns);
            }
            Some(KeyRef::Pose(_) | KeyRef::FusionStatus(_) | KeyRef::ConfigAnswer(_)) => {
                let may_drop = put.qos != Qos::Config;
                self.send(place, Place::Client, &item, may_drop, at_ns);
            }
            _ => {}
        }
    }

    fn trace_message(&self, index: usize, put: &Put, at_ns: u64) {
        if !self.traces {
            return;
        }
        let process = self.hosts[index].process.as_ref();
        let world = process.map_or(0, |process| self.scene.world_of(&process.core.models().rig));
        if let Some(words) = described(put, &self.scene, world) {
            self.trace(at_ns, || format!("{}: {words}", Place::Fusion(index)));
        }
    }

    fn send_to_fusion_nodes(&mut self, from: Place, item: &Rc<Item>, may_drop: bool, at_ns: u64) {
        for index in 0..self.hosts.len() {
            self.send(from, Place::Fusion(index), item, may_drop, at_ns);
        }
    }

    fn send_to_followers(&mut self, from: Place, item: &Rc<Item>, at_ns: u64) {
        let subscribed = |(place, follower): (&Place, &Follower)| {
            follower.subscribes(&item.key).then_some(*place)
        };
        let places: Vec<Place> = self.followers.iter().filter_map(subscribed).collect();
        for place in places.into_iter().filter(|place| *place != from) {
            self.send(from, place, item, false, at_ns);
        }
    }

    fn send(&mut self, from: Place, to: Place, item: &Rc<Item>, may_drop: bool, at_ns: u64) {
        let arrival_ns = match from == to {
            true => Some(at_ns),
            false => self.network.arrival_ns(from, to, at_ns, may_drop),
        };
        if let Some(arrival_ns) = arrival_ns {
            self.at(arrival_ns, Event::Message(to, Rc::clone(item)));
        }
    }

    fn ask(&mut self, asking: usize, node_asked: &NodeId, at_ns: u64) {
        let Some(asked) = (0..self.hosts.len()).find(|index| node(*index) == *node_asked) else {
            return;
        };
        let life = self.hosts[asking].life;
        let (from, to) = (Place::Fusion(asking), Place::Fusion(asked));
        if let Some(arrival_ns) = self.network.arrival_ns(from, to, at_ns, false) {
            self.at(arrival_ns, Event::Question(asked, asking, life));
        }
    }

    fn answer(&mut self, asked: usize, asking: usize, life: u64, at_ns: u64) {
        let place = Place::Fusion(asked);
        if self.is_paused(place, at_ns) {
            return self.at(at_ns + 20 * MS, Event::Question(asked, asking, life));
        }
        let process = self.hosts[asked].process.as_ref();
        let Some((root, payloads)) = process.and_then(Process::shelf) else {
            return;
        };
        let items = payloads.iter().map(|(below, payload)| Item {
            key: format!("{root}/{below}"),
            payload: Payload::Bytes(payload.to_vec()),
            sender: None,
        });
        let items = items.collect();
        let to = Place::Fusion(asking);
        if let Some(arrival_ns) = self.network.arrival_ns(place, to, at_ns, false) {
            self.at(arrival_ns, Event::Answers(asking, asked, life, items));
        }
    }

    fn receive(&mut self, to: Place, item: &Rc<Item>, at_ns: u64) {
        match to {
            Place::Fusion(index) => {
                let about = self.keys.parse(&item.key);
                let is_paused = self.is_paused(to, at_ns);
                let Some(process) = &mut self.hosts[index].process else {
                    return;
                };
                let item = Item::clone(item);
                match about {
                    Some(KeyRef::Observations(_)) => {
                        let wakes_ns = process.observation(item, at_ns);
                        if !is_paused && wakes_ns < self.hosts[index].next_turn_ns {
                            self.schedule_turn(index, wakes_ns);
                        }
                    }
                    Some(KeyRef::Heartbeat(_)) => process.heartbeat(item),
                    Some(_) => process.change(item),
                    None => {}
                }
            }
            Place::Client | Place::Camera(_) => {
                if self.is_paused(to, at_ns) || self.is_down(to, at_ns) {
                    return;
                }
                let follower = self.followers.get_mut(&to);
                let used = follower.and_then(|follower| follower.handle(Item::clone(item), at_ns));
                if let Some(item) = used {
                    self.promises.received(&item, &self.keys, at_ns);
                }
            }
        }
    }

    fn note(&mut self, key: &str, payload: &[u8]) {
        for byte in key.bytes().chain(payload.iter().copied()) {
            self.fingerprint = (self.fingerprint ^ u64::from(byte)).wrapping_mul(0x100_0000_01b3);
        }
    }

    /// Records the coverage and checks the promises after a turn.
    fn watch(&mut self, index: usize, at_ns: u64) {
        let Some(process) = &self.hosts[index].process else {
            return;
        };
        let state = process.core.state();
        let lasting = self.plan.faults.iter().filter(|fault| fault.lasts(at_ns));
        let kinds = lasting.map(|fault| fault.kind.name());
        self.coverage.note(kinds, &state);
        let models = process.core.models();
        (self.promises).check(index, &state, models, &self.network, at_ns);
    }
}

/// Those who follow the models.
impl World<'_> {
    fn update(&mut self, place: Place, at_ns: u64) {
        self.at(at_ns + UPDATE_NS, Event::Update(place));
        if self.is_down(place, at_ns) || self.is_paused(place, at_ns) {
            return;
        }
        let is_linked = self.network.is_linked(place, at_ns);
        let follower = self.followers.get_mut(&place);
        let Some(number) = follower.and_then(|follower| follower.update(is_linked, at_ns)) else {
            return;
        };
        let mut awaited = BTreeSet::new();
        for index in 0..self.hosts.len() {
            let fusion = Place::Fusion(index);
            if self.hosts[index].process.is_some()
                && let Some(arrival_ns) = self.network.arrival_ns(place, fusion, at_ns, false)
            {
                awaited.insert(index);
                self.at(arrival_ns, Event::KeptQuestion(index, place, number));
            }
        }
        if let Some(follower) = self.followers.get_mut(&place) {
            follower.wait_for(number, awaited);
        }
        self.at(at_ns + ANSWER_NS, Event::KeptTimeout(place, number));
    }

    fn answer_kept(&mut self, asked: usize, asking: Place, number: u64, at_ns: u64) {
        let fusion = Place::Fusion(asked);
        if self.is_paused(fusion, at_ns) {
            return self.at(at_ns + 20 * MS, Event::KeptQuestion(asked, asking, number));
        }
        let Some(process) = &self.hosts[asked].process else {
            return;
        };
        let follower = &self.followers[&asking];
        let items = process.kept().filter(|item| follower.subscribes(&item.key));
        let items: Vec<Item> = items.cloned().collect();
        if let Some(arrival_ns) = self.network.arrival_ns(fusion, asking, at_ns, false) {
            let answers = Event::KeptAnswers(asking, asked, number, items);
            self.at(arrival_ns, answers);
        }
    }

    fn end_question(&mut self, place: Place, number: u64, at_ns: u64) {
        if self.is_paused(place, at_ns) {
            return self.at(at_ns + 20 * MS, Event::KeptTimeout(place, number));
        }
        let follower = self.followers.get_mut(&place);
        let used = follower.map(|follower| follower.end_question(number, at_ns));
        for item in used.unwrap_or_default() {
            self.promises.received(&item, &self.keys, at_ns);
        }
    }
}

/// What begins and ends.
impl World<'_> {
    fn turn_point(&mut self, at_ns: u64) {
        for fault in self
            .plan
            .faults
            .iter()
            .filter(|fault| fault.from_ns == at_ns)
        {
            self.trace(at_ns, || format!("begins: {fault}"));
        }
        for index in 0..self.hosts.len() {
            let place = Place::Fusion(index);
            if self.is_down(place, at_ns) {
                let host = &mut self.hosts[index];
                if let Some(process) = host.process.take() {
                    process.kill(at_ns, &mut host.disk);
                    host.next_turn_ns = u64::MAX;
                    self.promises.ended(index);
                    self.trace(at_ns, || format!("{place} is killed"));
                }
            } else if self.hosts[index].process.is_none() && at_ns >= self.plan.starts_ns[index] {
                self.start(index, at_ns);
            }
        }
        let faults = self.plan.faults.to_vec();
        for fault in faults.iter().filter(|fault| fault.until_ns == at_ns) {
            let (place, has_kept_memory) = match fault.kind {
                FaultKind::Killed(place) => (place, true),
                FaultKind::PowerOff(place) => (place, false),
                _ => continue,
            };
            if let Some(follower) = self.followers.get_mut(&place) {
                follower.restart(has_kept_memory);
            }
        }
        self.update_presence(at_ns);
    }

    /// Tells everybody which fusion nodes have come and gone.
    fn update_presence(&mut self, at_ns: u64) {
        for index in 0..self.hosts.len() {
            if self.hosts[index].process.is_some() {
                let seen = self.nodes_seen(Place::Fusion(index), at_ns);
                self.note_seen(index, seen, at_ns);
            }
        }
        let places: Vec<Place> = self.followers.keys().copied().collect();
        for place in places {
            if !self.is_down(place, at_ns) {
                let seen = self.nodes_seen(place, at_ns);
                self.note_seen_by_follower(place, seen);
            }
        }
    }

    /// The token of a fusion node's last process is gone for everybody, if that of the next follows at once.
    fn forget_token(&mut self, of: usize, at_ns: u64) {
        for index in 0..self.hosts.len() {
            let mut seen = self.hosts[index].seen.clone();
            seen.remove(&of);
            self.note_seen(index, seen, at_ns);
        }
        let places: Vec<Place> = self.followers.keys().copied().collect();
        for place in places {
            let mut seen = self.followers[&place].seen.clone();
            seen.remove(&of);
            self.note_seen_by_follower(place, seen);
        }
    }

    fn note_seen(&mut self, index: usize, seen: BTreeSet<usize>, at_ns: u64) {
        let before = std::mem::replace(&mut self.hosts[index].seen, seen.clone());
        for other in seen.symmetric_difference(&before) {
            let key = self.keys.alive(NodeKind::Fusion, &node(*other));
            let change = match seen.contains(other) {
                true => Presence::Joined(key),
                false => Presence::Left(key),
            };
            self.at(at_ns + 300_000, Event::Presence(index, change));
        }
    }

    fn note_seen_by_follower(&mut self, place: Place, seen: BTreeSet<usize>) {
        if let Some(follower) = self.followers.get_mut(&place) {
            let before = std::mem::replace(&mut follower.seen, seen.clone());
            for index in seen.symmetric_difference(&before) {
                follower.presence(&node(*index), seen.contains(index));
            }
        }
    }

    fn image(&mut self, camera: usize, at_ns: u64) {
        let place = Place::Camera(camera);
        let next_ns = self.schedules[camera].next_at_or_after(at_ns + 1);
        self.at(next_ns, Event::Image(camera));
        if self.is_down(place, at_ns) || self.is_paused(place, at_ns) {
            return;
        }
        self.sequences[camera] += 1;
        let off_ns = self.clocks_off_ns[camera];
        let capture_ns = wall_ns(&self.plan.faults, place, off_ns, at_ns);
        let message = Observations {
            camera: self.scene.camera(camera),
            sequence: self.sequences[camera],
            capture_ns,
            exposure_ns: 2_000_000,
            clock: ClockQuality {
                source: match self.plan.clocks_off_ns {
                    0 => ClockSource::Ntp,
                    _ => ClockSource::FreeRunning,
                },
                error_ns: MS,
            },
            resolution: [640, 480],
            timing: Timing::default(),
            tags: self.scene.observe(camera, at_ns),
        };
        if !self.network.is_linked(place, at_ns) {
            return;
        }
        let nodes = 0..self.hosts.len();
        let mut sound = nodes.filter(|index| {
            self.network
                .is_sound(place, Place::Fusion(*index), 0, at_ns)
        });
        if sound.next().is_some() {
            for object in self.scene.objects_of(&message.tags) {
                self.promises.sees(camera, &object, at_ns);
            }
        }
        if let Some(recorder) = &mut self.recorder {
            recorder.image(&message, at_ns);
        }
        let item = Rc::new(Item {
            key: self.keys.observations(&message.camera),
            payload: Payload::Bytes(encode(&message).unwrap_or_default()),
            sender: None,
        });
        self.send_to_fusion_nodes(place, &item, true, at_ns + DETECTION_NS);
    }

    fn request(&mut self, index: usize, at_ns: u64) {
        let (_, request) = self.plan.requests[index];
        let client = Place::Client;
        if self.is_down(client, at_ns) || self.is_paused(client, at_ns) {
            return;
        }
        let (key, payload) = self.scene.request(request, &self.keys);
        self.trace(at_ns, || format!("client asks for {request:?}"));
        (self.promises).asked(&key, &payload, &self.network, at_ns);
        let item = Rc::new(Item {
            key,
            payload: Payload::Bytes(payload),
            sender: Some("ann@desk".to_owned()),
        });
        self.send_to_fusion_nodes(client, &item, false, at_ns);
        self.send_to_followers(client, &item, at_ns);
    }
}

/// A fusion node's name.
///
/// # Panics
/// Never.
#[must_use]
pub fn node(index: usize) -> NodeId {
    NodeId::new(&format!("fusion-{index}")).expect("an id")
}

fn config(plan: &Plan, site: &SiteId, node: &NodeId) -> FusionConfig {
    FusionConfig {
        site: site.clone(),
        node: node.clone(),
        rig: "rig.toml".into(),
        objects: Vec::new(),
        cameras: "cameras.toml".into(),
        keep_changes: plan.keeps,
        max_age_s: 0.5,
        refinement: Refinement::Propose,
        sharding: match plan.shares {
            true => ShardingConfig::ByMembers { standbys: 1 },
            false => ShardingConfig::Off,
        },
        network: BusOptions::client_of("tcp/127.0.0.1:7447"),
        security: SecurityOptions::default(),
    }
}
