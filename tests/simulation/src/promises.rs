//! What a site promises.

use crate::disk::Disk;
use crate::host::true_ns;
use crate::network::Network;
use crate::plan::{FaultKind, MS, Place, Plan, S};
use crate::scene::Scene;
use node_camera::SiteModels;
use node_fusion::{CoreState, FusionCore, ModelsInForce, Put};
use sextant_proto::{
    CameraSettings, ChangeOutcome, ConfigAnswer, FusionStatus, Heartbeat, KeyRef, Keys,
    ModelsState, ModelsVersion, NodeId, Notice, ObjectConfig, ObjectPose, RigConfig, decode,
    fingerprint,
};
use sextant_site_mirror::SiteMirror;
use sextant_site_model::{ObjectId, ObjectModel};
use sextant_site_report::{Fault, State};
use sextant_zenoh_bus::Item;
use std::collections::{BTreeMap, BTreeSet};
use std::fmt;

/// A pose may be off by so much, m, and by so many of its standard deviations. Where files are wrong the world is that
/// of the rig file, or of the cameras that see anything: a camera that is off by 3 mm and 0.3 degrees, a metre away,
/// moves it by as much again.
const OFF_M: f64 = 0.02;
const OFF_BY_FILES_M: f64 = 0.04;
const OFF_SIGMAS: f64 = 6.0;
/// Images of each camera by which a mistake must have been noticed.
const UNSEEN_IMAGES: f64 = 9.0;
/// And turned by so much.
const TURNED_RAD: f64 = 0.5;
/// Two nodes that have heard each other for so long do not both publish an object, ns.
const AGREED_NS: u64 = 1_500 * MS;
/// Runs of poses of one node after another's within a second that are no handing over.
const RUNS: usize = 5;
/// A node that has heard another for so long has its models, ns.
const FOLLOWED_NS: u64 = 4 * S;
/// After so long without anything wrong every object that is seen has poses, ns.
const SETTLED_NS: u64 = 8 * S;
/// Longest time without poses of an object that is seen, when nothing is wrong, ns.
const GAP_NS: u64 = 1_500 * MS;
/// A change is answered within, ns.
const ANSWERED_NS: u64 = 8 * S;
/// Between two checks of what is due.
const CHECK_NS: u64 = 250 * MS;
/// A started node is compared with others for so long, ns.
const STARTED_NS: u64 = 7 * S;

/// A promise that was broken.
#[derive(Debug, Clone, PartialEq)]
pub struct Violation {
    /// When.
    pub at_ns: u64,
    /// Which, in short: the same words for the same promise.
    pub promise: &'static str,
    /// How.
    pub how: String,
}

impl fmt::Display for Violation {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let at_s = self.at_ns as f64 * 1e-9;
        write!(formatter, "at {at_s:.3} s: {}: {}", self.promise, self.how)
    }
}

/// What is known of a fusion node.
#[derive(Debug, Clone, Default)]
struct NodeRecord {
    started_ns: Option<u64>,
    models: ModelsState,
    /// Since when it has these.
    models_since_ns: u64,
    /// The models of others, by their last heartbeats that it has read.
    reported: BTreeMap<NodeId, ModelsState>,
}

/// A message of a fusion node, and the site at that moment.
pub struct PublicationContext<'a> {
    /// Of the node.
    pub index: usize,
    /// The message.
    pub put: &'a Put,
    /// The node.
    pub core: &'a FusionCore,
    /// The disk of its host.
    pub disk: &'a Disk,
    /// The true site.
    pub scene: &'a Scene,
    /// The network.
    pub network: &'a Network,
    /// True time.
    pub at_ns: u64,
}

/// A change that has to be answered.
#[derive(Debug)]
struct Pending {
    key: String,
    fingerprint: u64,
    due_ns: u64,
}

/// State of the checks.
pub struct Promises {
    plan: Plan,
    objects: Vec<ObjectId>,
    nodes: Vec<NodeRecord>,
    broken: Option<Violation>,
    poses: u64,
    mirror: SiteMirror,
    /// Which nodes published an object in turns, and until when.
    publishers: BTreeMap<ObjectId, Vec<(usize, u64)>>,
    /// When each camera saw each object last.
    sightings: BTreeMap<(ObjectId, usize), u64>,
    /// Since when at least two cameras have seen an object without a pause, and until when.
    seen_by_two: BTreeMap<ObjectId, (u64, u64)>,
    /// When the client used a pose of an object last that is tracked.
    tracked: BTreeMap<ObjectId, u64>,
    /// The newest version that was answered to be kept.
    newest_kept: Option<ModelsVersion>,
    /// The epoch of the last pose that it used, and when.
    epochs: BTreeMap<ObjectId, (u64, u64)>,
    pending: Vec<Pending>,
    statuses: BTreeMap<String, FusionStatus>,
    checked_ns: u64,
    are_cameras_set: bool,
}

impl Promises {
    /// Of a plan.
    #[must_use]
    pub fn new(plan: &Plan, objects: Vec<ObjectId>) -> Self {
        let sets_camera =
            |kind: FaultKind| matches!(kind, FaultKind::ClockSet(Place::Camera(_), _));
        Self {
            are_cameras_set: plan.faults.iter().any(|fault| sets_camera(fault.kind)),
            nodes: vec![NodeRecord::default(); plan.nodes],
            plan: plan.clone(),
            objects,
            broken: None,
            poses: 0,
            mirror: SiteMirror::default(),
            publishers: BTreeMap::new(),
            sightings: BTreeMap::new(),
            seen_by_two: BTreeMap::new(),
            tracked: BTreeMap::new(),
            newest_kept: None,
            epochs: BTreeMap::new(),
            pending: Vec::new(),
            statuses: BTreeMap::new(),
            checked_ns: 0,
        }
    }

    /// The first promise that was broken.
    #[must_use]
    pub fn broken(&self) -> Option<&Violation> {
        self.broken.as_ref()
    }

    /// Poses that the client used.
    #[must_use]
    pub fn poses(&self) -> u64 {
        self.poses
    }

    fn record_violation(&mut self, at_ns: u64, promise: &'static str, how: String) {
        self.broken.get_or_insert(Violation {
            at_ns,
            promise,
            how,
        });
    }

    /// A fusion node's process starts.
    pub fn started(&mut self, index: usize, at_ns: u64) {
        self.nodes[index] = NodeRecord {
            started_ns: Some(at_ns),
            models_since_ns: at_ns,
            ..NodeRecord::default()
        };
    }

    /// A fusion node's process has ended.
    pub fn ended(&mut self, index: usize) {
        self.nodes[index] = NodeRecord::default();
    }

    /// A fusion node reads another one's heartbeat.
    pub fn record_heartbeat(&mut self, index: usize, heartbeat: &Item) {
        if let Ok(beat) = heartbeat.decode::<Heartbeat>() {
            self.nodes[index].reported.insert(beat.node, beat.models);
        }
    }

    /// A camera sees an object.
    pub fn sees(&mut self, camera: usize, object: &ObjectId, at_ns: u64) {
        self.sightings.insert((object.clone(), camera), at_ns);
        let lasts_ns = (2.5e9 / self.plan.rate_hz) as u64;
        let of_object = self.sightings.iter().filter(|((of, _), seen_ns)| {
            of == object && at_ns.saturating_sub(**seen_ns) < lasts_ns
        });
        if of_object.count() < 2 {
            return;
        }
        let known = self
            .seen_by_two
            .entry(object.clone())
            .or_insert((at_ns, at_ns));
        if at_ns.saturating_sub(known.1) > lasts_ns {
            known.0 = at_ns;
        }
        known.1 = at_ns;
    }

    fn is_settled(&self, index: usize, for_ns: u64, at_ns: u64) -> bool {
        let started_ns = self.nodes[index].started_ns;
        started_ns.is_some_and(|started_ns| at_ns.saturating_sub(started_ns) >= for_ns)
    }

    fn are_sound(
        &self,
        network: &Network,
        one: usize,
        other: usize,
        for_ns: u64,
        at_ns: u64,
    ) -> bool {
        let places = [one, other].map(Place::Fusion);
        network.is_sound(places[0], places[1], for_ns, at_ns)
            && self.is_settled(one, for_ns.max(AGREED_NS), at_ns)
            && self.is_settled(other, for_ns.max(AGREED_NS), at_ns)
    }
}

/// Messages of fusion nodes.
impl Promises {
    /// Checks a message of a fusion node.
    pub fn handle_publication(&mut self, context: &PublicationContext<'_>) {
        let &PublicationContext {
            index, at_ns, core, ..
        } = context;
        let (state, models, payload) = (core.state(), core.models(), &context.put.payload);
        if let Ok(pose) = decode::<ObjectPose>(payload) {
            let world = context.scene.world_of(&models.rig);
            self.pose_is_right(index, &pose, world, context.scene, at_ns);
            self.one_publishes(index, &pose, context.network, at_ns);
            if pose.state != State::Lost {
                self.no_older_models(index, &state.models, context.network, at_ns);
            }
        } else if let Ok(answer) = decode::<ConfigAnswer>(payload)
            && answer.outcome == ChangeOutcome::Kept
        {
            let Disk {
                record,
                models: on_disk,
                ..
            } = context.disk;
            // The version may be a newer one of the same models by now, which another node has given them.
            let recorded = record.as_ref().map(|record| record.state.fingerprint);
            if recorded != Some(state.models.fingerprint) || on_disk != models {
                let how = format!("fusion {index} answers that {} is kept", answer.key);
                self.record_violation(at_ns, "what was answered to be kept is on the disk", how);
            }
            self.newest_kept = self.newest_kept.take().max(state.models.version);
        }
    }

    fn pose_is_right(
        &mut self,
        index: usize,
        pose: &ObjectPose,
        world: i32,
        scene: &Scene,
        at_ns: u64,
    ) {
        if pose.state != State::Tracking || self.is_mistake_fresh(at_ns) {
            return;
        }
        let stamp_ns = true_ns(pose.capture_ns);
        let near = (-3..=3).map(|step: i64| stamp_ns.saturating_add_signed(step * 10_000_000));
        // By a clock that was set the stamp says little.
        let late = (0..=60).map(|step| at_ns.saturating_sub(step * 15 * MS));
        let times: Vec<u64> = match self.are_cameras_set {
            true => near.chain(late).collect(),
            false => near.collect(),
        };
        let (error_m, sigmas) = scene.error(pose, world, &times);
        let turned_rad = scene.turned_rad(pose, &times);
        if turned_rad > TURNED_RAD {
            let how = format!(
                "fusion {index}: {} is turned by {turned_rad:.2} rad",
                pose.object
            );
            self.record_violation(at_ns, "no pose called tracking is turned", how);
        }
        let off_m = match self.plan.exact {
            true => OFF_M,
            false => OFF_BY_FILES_M,
        };
        if !(error_m <= off_m || sigmas <= OFF_SIGMAS) {
            let how = format!(
                "fusion {index}: {} is off by {:.1} mm, {sigmas:.1} sigma, by {} cameras and {} tags",
                pose.object,
                error_m * 1e3,
                pose.cameras,
                pose.tags
            );
            self.record_violation(at_ns, "no pose called tracking is wrong", how);
        }
    }

    /// Whether somebody has just made a mistake, so that nobody can know of it yet.
    fn is_mistake_fresh(&self, at_ns: u64) -> bool {
        let unseen_ns = (UNSEEN_IMAGES / self.plan.rate_hz * 1e9) as u64;
        let mistake = self.plan.mistake.as_ref();
        mistake
            .is_some_and(|mistake| (mistake.at_ns()..mistake.at_ns() + unseen_ns).contains(&at_ns))
    }

    fn one_publishes(&mut self, index: usize, pose: &ObjectPose, network: &Network, at_ns: u64) {
        let last = self.publishers.entry(pose.object.clone()).or_default();
        match last.last_mut() {
            Some((node, last_ns)) if *node == index => *last_ns = at_ns,
            _ => last.push((index, at_ns)),
        }
        if last.len() > RUNS {
            last.remove(0);
        }
        let (_, first_ns) = last[0];
        let is_soon = last.len() == RUNS && at_ns - first_ns < S;
        let nodes: BTreeSet<usize> = last.iter().map(|(node, _)| *node).collect();
        // A node that the others do not hear well takes over from them, and they from it.
        let mut pairs = nodes
            .iter()
            .flat_map(|one| nodes.range(one + 1..).map(move |other| (*one, *other)));
        let are_sound =
            pairs.all(|(one, other)| self.are_sound(network, one, other, AGREED_NS, at_ns));
        if is_soon && are_sound {
            let how = format!("{} by fusion nodes {nodes:?}", pose.object);
            self.record_violation(at_ns, "one node publishes an object", how);
        }
    }

    fn no_older_models(&mut self, index: usize, own: &ModelsState, network: &Network, at_ns: u64) {
        let is_newer = |theirs: &ModelsState| {
            theirs.version > own.version && theirs.fingerprint != own.fingerprint
        };
        let mut reported = self.nodes[index].reported.iter();
        if let Some((node, _)) = reported.find(|(_, theirs)| is_newer(theirs)) {
            let how = format!("fusion {index} publishes, and knows that {node} has newer ones");
            self.record_violation(at_ns, "no node publishes with old models", how);
        }
        for other in (0..self.nodes.len()).filter(|other| *other != index) {
            let newer = &self.nodes[other];
            let is_newer = newer.started_ns.is_some()
                && is_newer(&newer.models)
                && at_ns - newer.models_since_ns > FOLLOWED_NS;
            if is_newer && self.are_sound(network, index, other, FOLLOWED_NS, at_ns) {
                let how = format!("fusion {index} publishes, fusion {other} has newer ones");
                self.record_violation(at_ns, "no node publishes with old models", how);
            }
        }
    }
}

/// What the client gets.
impl Promises {
    /// The client asks for a change.
    pub fn asked(&mut self, key: &str, payload: &[u8], network: &Network, at_ns: u64) {
        let due_ns = at_ns + ANSWERED_NS;
        let slow_disk = |fault: &crate::plan::Fault| matches!(fault.kind, FaultKind::SlowDisk(..));
        let has_slow_disk = self.plan.faults.iter().any(slow_disk);
        let is_sound = |index: &usize| {
            let span_ns = ANSWERED_NS + SETTLED_NS;
            network.is_sound(Place::Client, Place::Fusion(*index), span_ns, due_ns)
                && self.is_settled(*index, STARTED_NS, at_ns)
                && !has_slow_disk
        };
        if !(0..self.nodes.len()).all(|index| is_sound(&index)) {
            return;
        }
        self.pending.push(Pending {
            key: Keys::below_site(key).to_owned(),
            fingerprint: fingerprint(payload),
            due_ns,
        });
    }

    /// The client receives a message.
    pub fn received(&mut self, item: &Item, keys: &Keys, at_ns: u64) {
        let Some(key) = keys.parse(&item.key) else {
            return;
        };
        let taken = (self.mirror).handle(at_ns, &key, item.sender.as_deref(), item.try_bytes());
        if taken.is_err() {
            return;
        }
        match key {
            KeyRef::Pose(object) => {
                self.poses += 1;
                if let Ok(pose) = item.decode::<ObjectPose>() {
                    self.used(object, &pose, at_ns);
                }
            }
            KeyRef::ConfigAnswer(_) => {
                if let Ok(answer) = item.decode::<ConfigAnswer>() {
                    let is_it = |one: &Pending| {
                        one.key == answer.key && one.fingerprint == answer.fingerprint
                    };
                    self.pending.retain(|one| !is_it(one));
                }
            }
            KeyRef::FusionStatus(node) => {
                if let Ok(status) = item.decode::<FusionStatus>() {
                    self.statuses.insert(node.as_str().to_owned(), status);
                }
            }
            _ => {}
        }
    }
}

impl Promises {
    fn used(&mut self, object: ObjectId, pose: &ObjectPose, at_ns: u64) {
        let (newest, newest_ns) = self.epochs.get(&object).copied().unwrap_or_default();
        if pose.epoch < newest && at_ns - newest_ns < S {
            let how = format!("{object}: {} after {newest}", pose.epoch);
            self.record_violation(at_ns, "no pose of an older epoch is used", how);
        }
        self.epochs.insert(object.clone(), (pose.epoch, at_ns));
        if pose.state == State::Tracking {
            self.tracked.insert(object, at_ns);
        }
    }
}

/// Checks of what is due.
impl Promises {
    /// Checks what is due after a turn of a fusion node.
    pub fn check(
        &mut self,
        index: usize,
        state: &CoreState,
        models: &ModelsInForce,
        network: &Network,
        at_ns: u64,
    ) {
        let node = &mut self.nodes[index];
        if node.models != state.models {
            node.models = state.models.clone();
            node.models_since_ns = at_ns;
        }
        if at_ns.saturating_sub(self.checked_ns) < CHECK_NS {
            return;
        }
        self.checked_ns = at_ns;
        if let Some(late) = self.pending.iter().find(|one| at_ns > one.due_ns) {
            let how = format!("{} is not answered", late.key);
            self.record_violation(at_ns, "a change is answered", how);
        }
        let is_settled = (0..self.nodes.len()).all(|index| {
            network.is_sound(Place::Client, Place::Fusion(index), SETTLED_NS, at_ns)
                && self.is_settled(index, SETTLED_NS, at_ns)
        });
        // After a change tracks may begin anew.
        // With a mistake nobody may be able to tell where an object is.
        if self.plan.mistake.is_some() {
            return;
        }
        let is_quiet = (self.nodes.iter()).all(|node| at_ns - node.models_since_ns > SETTLED_NS);
        if !is_settled || !is_quiet {
            return;
        }
        for object in self.objects.clone() {
            let is_there = models.objects.iter().any(|model| *model.id() == object);
            let (since_ns, until_ns) = self.seen_by_two.get(&object).copied().unwrap_or_default();
            let is_seen = at_ns - since_ns > SETTLED_NS && at_ns - until_ns < S / 2;
            let last_ns = self.tracked.get(&object).copied().unwrap_or(0);
            if is_there && is_seen && since_ns > 0 && at_ns - last_ns > GAP_NS {
                let gap_s = (at_ns - last_ns) as f64 * 1e-9;
                let how = format!("{object} has no pose called tracking for {gap_s:.2} s");
                self.record_violation(at_ns, "an object that is seen has poses", how);
            }
        }
    }

    fn client_has(&mut self, models: &ModelsInForce) {
        let known = self.objects.iter().filter_map(|id| {
            let object = self.mirror.object(id)?;
            object.config.clone()
        });
        let mut known: Vec<ObjectConfig> = known.collect();
        let mut in_force: Vec<ObjectConfig> = models.objects.iter().map(Into::into).collect();
        known.sort_by(|one, other| one.id.cmp(&other.id));
        in_force.sort_by(|one, other| one.id.cmp(&other.id));
        let has_rig = self.mirror.rig() == Some(&RigConfig::from(&models.rig));
        if !has_rig || known != in_force {
            let ids = |objects: &[ObjectConfig]| -> Vec<String> {
                objects.iter().map(|object| object.id.to_string()).collect()
            };
            let how = format!(
                "the client has the rig: {has_rig}, the objects {:?} in place of {:?}",
                ids(&known),
                ids(&in_force)
            );
            self.record_violation(self.plan.end_ns, "models in force are known", how);
        }
    }

    fn camera_has(&mut self, place: Place, camera: &SiteModels, models: &ModelsInForce) {
        let id = camera.camera();
        let wanted = models.settings.get(id).cloned();
        let wanted = wanted.unwrap_or_else(|| CameraSettings::none(id.clone()));
        let mut in_rig = models.rig.cameras().iter();
        let lens = in_rig.find(|one| one.id == *id).map(|one| &one.lens);
        let has_size = |model: &ObjectModel| {
            let mut tags = model.tags().iter();
            tags.all(|tag| camera.size_m(&tag.tag) == Some(tag.size_m))
        };
        let what = match () {
            () if *camera.settings() != wanted => format!("settings: {:?}", camera.settings()),
            () if camera.lens(640, 480) != lens => "another lens".to_owned(),
            () if !models.objects.iter().all(has_size) => "other tags".to_owned(),
            () => return,
        };
        let how = format!("{place} has {what}");
        self.record_violation(self.plan.end_ns, "models in force are known", how);
    }

    /// Everything was mended for a while.
    pub fn end(
        &mut self,
        states: &[Option<CoreState>],
        models: Option<&ModelsInForce>,
        cameras: &[(Place, &SiteModels)],
        replayed: Option<String>,
    ) {
        let at_ns = self.plan.end_ns;
        if let Some(how) = replayed {
            self.record_violation(at_ns, "a recording gives the very poses", how);
        }
        if let Some(models) = models {
            self.client_has(models);
            for (place, camera) in cameras {
                self.camera_has(*place, camera, models);
            }
        }
        if self.statuses.len() != states.len() {
            let how = format!("{} of {} nodes", self.statuses.len(), states.len());
            self.record_violation(at_ns, "every node publishes its status", how);
        }
        if states.iter().any(Option::is_none) {
            self.record_violation(
                at_ns,
                "a mended node works",
                "a fusion node is down".to_owned(),
            );
        }
        let states: Vec<&CoreState> = states.iter().flatten().collect();
        if states.iter().any(|state| state.models != states[0].models) {
            let how = format!(
                "{:?}",
                states.iter().map(|state| &state.models).collect::<Vec<_>>()
            );
            self.record_violation(at_ns, "all nodes have the same models in the end", how);
        }
        if states
            .iter()
            .any(|state| state.models.version < self.newest_kept)
        {
            let how = format!("{:?}", self.newest_kept);
            self.record_violation(at_ns, "what was kept is in force in the end", how);
        }
        let leaders = states.iter().filter(|state| state.leads).count();
        if leaders != 1 {
            let how = format!("{leaders} nodes lead");
            self.record_violation(at_ns, "one node leads in the end", how);
        }
        let mut wrong = Vec::new();
        for status in self.statuses.values() {
            // Of a change that was refused people read for a minute, of one that was set aside until they decide.
            let is_usual = |notice: &&Notice| {
                matches!(
                    notice,
                    Notice::ChangeRefused { .. }
                        | Notice::RefinementProposed { .. }
                        | Notice::SetAside { .. }
                )
            };
            let notices = status.notices.iter().filter(|notice| !is_usual(notice));
            wrong.extend(notices.map(ToString::to_string));
            let is_whole = self.plan.faults.is_empty() && self.plan.requests.is_empty();
            if is_whole && self.plan.mistake.is_none() {
                // Where clocks are off, it is right to say so.
                let is_so = |fault: &&Fault| {
                    self.plan.clocks_off_ns > 0 && matches!(fault, Fault::ClockOff { .. })
                };
                let faults = status.faults.iter().filter(|fault| !is_so(fault));
                wrong.extend(faults.map(|fault| format!("{fault:?}")));
            }
        }
        if let Some(first) = wrong.first() {
            self.record_violation(at_ns, "a mended site names nothing wrong", first.clone());
        }
    }
}
