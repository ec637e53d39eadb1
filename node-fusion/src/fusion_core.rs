//! The fusion node without its network, files, threads and clock: messages in, poses and everything else that is to be
//! published out.
//!
//! [`FusionCore::turn`] takes its inputs and has its actions carried out. Time is an input; the same inputs at the same
//! times give the same outputs.

use crate::clocks::DriftEstimator;
use crate::config::{FusionConfig, Refinement};
use crate::formers::Formers;
use crate::input_log::{self, InputLog};
use crate::intake::{Arrival, Arrivals, Intake};
use crate::models::{Change, ModelsInForce, Payloads};
use crate::outbox::{Outbox, Publication};
use crate::proposing::{self, Proposals};
use crate::refusals::detail;
use crate::replica::{Answered, Effect, KeepJob, ModelsRecord, Origin, Replica, Request};
use crate::requests;
use crate::standby::{Duty, Standby};
use crate::status::{Losses, StatusReporter};
use sextant_election::{Company, Link, Moment};
use sextant_estimator::{Fusion, FusionOptions, Input, ModelError, Output, Proposal, SolverTask};
use sextant_process::ClockQuality;
use sextant_proto::{
    ChangeOutcome, Heartbeat, InputSource, KeyRef, Keys, ModelsState, NodeId, Notice,
};
use sextant_site_model::{CameraId, Rig, posed_objects};
use sextant_site_report::{ObjectEstimate, State};
use sextant_zenoh_bus::{Item, Payload, Presence};
use std::collections::VecDeque;

/// Between two statuses.
const STATUS_PERIOD_NS: u64 = 1_000_000_000;
/// A node whose turns are so far apart stood still, ns: it waits for a tenth of a second at most.
const STALL_NS: u64 = 300_000_000;
/// What waits after a stall is read within, ns.
const STALL_LASTS_NS: u64 = 2_000_000_000;
/// After a refinement was refused, ns.
const REFUSED_REST_NS: u64 = 60_000_000_000;
/// Most notices of nodes whose models are old.
const OLD_MODELS_SHOWN: usize = 4;

/// What the node's process has to do.
#[derive(Debug, PartialEq)]
pub enum Action {
    /// Publish it.
    Publish(Publication),
    /// Write changes to the files; the outcome is given by [`Environment::kept`](crate::Environment::kept).
    Keep(KeepJob),
    /// Ask a fusion node for its models; they are given by [`Environment::answers`](crate::Environment::answers).
    Ask(NodeId),
}

/// What the process knows of its host, for the status.
#[derive(Debug, Clone, Default)]
pub struct HostState {
    /// Quality of the host's clock.
    pub clock: ClockQuality,
    /// Hosts of other fusion nodes of this name.
    pub namesakes: Vec<String>,
    /// Observations dropped unread since the process started.
    pub unread: u64,
}

/// What a fusion node starts from.
#[derive(Debug)]
pub struct InitialState {
    /// Of the files.
    pub models: ModelsInForce,
    /// Their former versions.
    pub formers: Formers,
    /// Which version of the models was written last.
    pub record: Option<ModelsRecord>,
    /// What of the models is not in the files.
    pub unwritten: Vec<Change>,
    /// The fusion nodes that are alive.
    pub others: Vec<NodeId>,
    /// Quality of the host's clock.
    pub clock: ClockQuality,
}

/// What a fusion node does at a moment.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct CoreState {
    /// Whether it cares for what concerns the whole site.
    pub leads: bool,
    /// Whether it knows of no newer models than its own.
    pub is_current: bool,
    /// Whether a change is under way.
    pub is_deciding: bool,
    /// What it works from.
    pub models: ModelsState,
}

/// The fusion node without network, files and clock.
#[derive(Debug)]
pub struct FusionCore {
    keys: Keys,
    node: NodeId,
    machine: Fusion,
    input_log: InputLog,
    replica: Replica,
    intake: Intake,
    standby: Standby,
    status: StatusReporter,
    clocks: DriftEstimator,
    outbox: Outbox,
    /// Estimates whose poses are not published yet.
    estimates: VecDeque<ObjectEstimate>,
    actions: VecDeque<Action>,
    clock: ClockQuality,
    refinement: Refinement,
    /// How long a pose may be held up before it is published.
    max_age_s: f64,
    /// When the last input came, monotonic.
    handled_ns: u64,
    /// When the last turn ended, monotonic.
    turned_ns: u64,
    /// Until then the node is late itself, after it stood still; monotonic.
    stalled_until_ns: u64,
    /// Whether it was logged that this node has to publish and may not.
    is_stuck: bool,
    /// When a request came whose turn is not over, monotonic.
    requested_ns: Option<u64>,
    /// Monotonic.
    status_due_ns: u64,
    /// A refinement that was refused is not applied again before, monotonic.
    applies_from_ns: u64,
    /// The refined calibrations on offer.
    proposals: Proposals,
}

fn cameras_of(rig: &Rig) -> impl Iterator<Item = CameraId> {
    rig.cameras().iter().map(|camera| camera.id.clone())
}

impl FusionCore {
    /// A node that starts now.
    ///
    /// # Errors
    /// Models that the estimator refuses.
    pub fn new(
        config: &FusionConfig,
        initial: InitialState,
        now: Moment,
    ) -> Result<Self, ModelError> {
        let InitialState {
            models,
            formers,
            record,
            unwritten,
            others,
            clock,
        } = initial;
        let (keys, node) = (Keys::for_site(config.site.clone()), config.node.clone());
        let options = FusionOptions::default();
        let mut machine = Fusion::new(models.rig.clone(), models.objects.clone(), options)?;
        machine.adjust_apart();
        let company = match others.is_empty() {
            true => Company::Alone,
            false => Company::Others,
        };
        let posed = posed_objects(&models.rig, &models.objects);
        let unwritten = config.keep_changes.then_some(unwritten);
        let mut core = Self {
            machine,
            input_log: InputLog::new(node.clone()),
            intake: Intake::new(keys.clone(), cameras_of(&models.rig), config.max_age_s),
            standby: Standby::new(&node, &config.sharding, &models, company, now),
            status: StatusReporter::new(node.clone(), posed.clone(), now.monotonic_ns),
            clocks: DriftEstimator::default(),
            outbox: Outbox::new(keys.clone(), node.clone(), posed),
            replica: Replica::new(node.clone(), models, formers, record, unwritten),
            estimates: VecDeque::new(),
            actions: VecDeque::new(),
            clock,
            refinement: config.refinement,
            max_age_s: config.max_age_s,
            handled_ns: now.monotonic_ns,
            turned_ns: now.monotonic_ns,
            stalled_until_ns: 0,
            is_stuck: false,
            requested_ns: None,
            status_due_ns: now.monotonic_ns,
            applies_from_ns: 0,
            proposals: Proposals::new(node.clone()),
            keys,
            node,
        };
        for node in others {
            core.replica.joined(node, now);
        }
        core.outbox.models(core.replica.payloads());
        core.outbox.formers(core.replica.formers());
        core.publish_proposal(now);
        Ok(core)
    }

    /// The next thing to be done.
    pub(crate) fn poll(&mut self, now: Moment) -> Option<Action> {
        if let Some(since_ns) = self.requested_ns.take() {
            self.replica.rest(since_ns, now.monotonic_ns);
        }
        while let Some(estimate) = self.estimates.pop_front() {
            self.publish_pose(&estimate, now);
        }
        let publication = self.outbox.poll().map(Action::Publish);
        publication.or_else(|| self.actions.pop_front())
    }

    /// When the next [`Self::turn`] is due at the latest but for changes of the models, which are looked after every
    /// tenth of a second; ns by the monotonic clock.
    #[must_use]
    pub fn poll_timeout(&self, now: Moment) -> u64 {
        let of_machine = self.machine.poll_timeout().unwrap_or(u64::MAX);
        let of_machine = (now.monotonic_ns).saturating_add(of_machine.saturating_sub(now.wall_ns));
        of_machine
            .min(self.status_due_ns)
            .min(self.standby.due_ns())
    }

    /// What is in force.
    #[must_use]
    pub fn models(&self) -> &ModelsInForce {
        self.replica.models()
    }

    /// What it does now.
    #[must_use]
    pub fn state(&self) -> CoreState {
        CoreState {
            leads: self.standby.leads(),
            is_current: self.replica.is_current(),
            is_deciding: self.replica.is_deciding(),
            models: self.replica.state().clone(),
        }
    }

    /// Where to count every observation that arrives, also those that are dropped unread.
    #[must_use]
    pub fn arrivals(&self) -> Arrivals {
        self.intake.arrivals()
    }

    /// An adjustment of the files that is to be solved, which may take long.
    #[must_use]
    pub(crate) fn task(&self) -> Option<SolverTask> {
        self.machine.task().filter(|task| !task.is_solved())
    }

    /// Whether the next message under a key of the configuration may be handed over. At most one change is made at a
    /// time, and none for a while after it: images go first.
    #[must_use]
    pub(crate) fn takes_requests(&self, now: Moment) -> bool {
        !self.standby.leads() || (self.requested_ns.is_none() && self.replica.is_ready(now))
    }

    /// Whether [`Self::report`] is due.
    #[must_use]
    pub(crate) fn is_report_due(&self, now: Moment) -> bool {
        now.monotonic_ns >= self.status_due_ns
    }
}

/// The other fusion nodes.
impl FusionCore {
    /// The state of the link to the network, whether or not it has changed.
    pub(crate) fn link(&mut self, link: Link, now: Moment) {
        self.standby.link(link, now);
        self.replica.link(link, now);
    }

    /// A fusion node has come or gone.
    pub(crate) fn presence(&mut self, change: &Presence, now: Moment) {
        let (Presence::Joined(key) | Presence::Left(key)) = change;
        let Some(KeyRef::Alive(_, node)) = self.keys.parse(key) else {
            return;
        };
        match change {
            Presence::Joined(_) => self.replica.joined(node, now),
            Presence::Left(_) => {
                self.standby.left(&node, now);
                self.replica.left(&node, now);
            }
        }
    }

    /// A heartbeat of a fusion node.
    pub(crate) fn heartbeat(&mut self, item: &Item, now: Moment) {
        if let Ok(beat) = item.decode::<Heartbeat>()
            && self.keys.heartbeat(&beat.node) == item.key
        {
            self.standby.handle_heartbeat(&beat, now);
            self.replica.hear(&beat.node, &beat.models, now);
        }
    }

    /// The answers of a fusion node that was asked for its models.
    pub(crate) fn follow(&mut self, node: &NodeId, answers: &[Item], now: Moment) {
        let theirs = Payloads::answered(&self.keys.models_of(node), answers);
        self.replica.follow(node, theirs, now);
    }

    /// Publishes or stands by, as the other fusion nodes of the site leave it to this one. To be called before images
    /// are handed over.
    pub(crate) fn update_duty(&mut self, now: Moment) {
        self.note_turn(now);
        let duty = self.standby.tick(self.replica.models(), now);
        let is_shared = self.standby.is_shared();
        match duty {
            Some(Duty::Publish { epoch }) if !is_shared && self.replica.is_current() => {
                tracing::info!(epoch, "this node publishes the poses");
            }
            Some(Duty::StandBy) => {
                if !is_shared {
                    tracing::info!("another fusion node publishes the poses: standing by");
                }
                self.propose(None, now);
            }
            Some(Duty::Publish { .. }) | None => {}
        }
        if let Some(beat) = self.standby.poll_heartbeat(self.replica.state(), now) {
            self.outbox.heartbeat(&beat);
        }
    }

    /// A turn begins, or ends.
    fn note_turn(&mut self, now: Moment) {
        if now.monotonic_ns.saturating_sub(self.turned_ns) > STALL_NS {
            self.stalled_until_ns = now.monotonic_ns + STALL_LASTS_NS;
        }
        self.turned_ns = now.monotonic_ns;
    }

    /// Epoch of the poses that this node publishes now; none while it stands by. Where objects are shared, of the node
    /// that cares for the site.
    fn epoch(&self, now: Moment) -> Option<u64> {
        let epoch = self.standby.epoch(now);
        epoch.filter(|_| self.replica.is_current())
    }
}

/// Images, and time.
impl FusionCore {
    /// A message of a camera.
    pub(crate) fn observation(&mut self, item: &Item, now: Moment) {
        self.handled_ns = now.monotonic_ns;
        let Payload::Bytes(bytes) = &item.payload else {
            return self.intake.count_too_long(&item.key);
        };
        let arrival = Arrival {
            now_ns: now.wall_ns,
            monotonic_ns: now.monotonic_ns,
            clock: self.clock,
            is_stalled: now.monotonic_ns < self.stalled_until_ns,
        };
        let Some(admitted) = self.intake.take(&item.key, bytes, arrival) else {
            return;
        };
        let models = self.replica.models();
        (self.input_log).add_image(now.wall_ns, admitted.source, models);
        let mut image = models.rig.timed(admitted.observation);
        image
            .tags
            .retain(|seen| !self.standby.is_foreign(&seen.tag));
        self.machine.handle(now.wall_ns, Input::Image(image));
        self.collect_estimates(now);
    }

    /// The wall clock of this host was set by so many ns: everything that compares stamps with it begins anew.
    pub(crate) fn clock_stepped(&mut self, by_ns: i64, now: Moment) {
        self.handled_ns = now.monotonic_ns;
        self.intake.clock_stepped();
        self.standby.interrupted(now);
        self.feed(InputSource::ClockStep, Input::ClockStep { by_ns }, now);
    }

    /// Does what is due.
    pub(crate) fn tick(&mut self, now: Moment) {
        self.note_turn(now);
        self.handled_ns = now.monotonic_ns;
        self.update_models(now);
        let task = self.machine.task();
        if task.is_some_and(|task| task.is_solved()) {
            self.feed(InputSource::Adjusted, Input::Adjusted, now);
        }
        let due_ns = self.machine.poll_timeout();
        if due_ns.is_some_and(|due_ns| due_ns <= now.wall_ns) {
            self.feed(InputSource::Tick, Input::Tick, now);
        }
        while let Some(inputs) = self.input_log.poll(now.wall_ns) {
            // Those of a share of the objects would not replay to the poses of all.
            if self.epoch(now).is_some() && !self.standby.is_shared() {
                self.outbox.inputs(&inputs);
            }
        }
    }

    fn feed(&mut self, source: InputSource, input: Input, now: Moment) {
        self.input_log.add(now.wall_ns, source);
        self.machine.handle(now.wall_ns, input);
        self.collect_estimates(now);
    }

    fn collect_estimates(&mut self, now: Moment) {
        while let Some(output) = self.machine.poll_output() {
            match output {
                Output::Pose(estimate) => self.estimates.push_back(estimate),
                Output::ClockStep { by_ns } => self.status.clock_stepped(by_ns, now.monotonic_ns),
                other => tracing::warn!(?other, "unexpected output of the estimator"),
            }
        }
    }

    fn publish_pose(&mut self, estimate: &ObjectEstimate, now: Moment) {
        if estimate.state == State::Tracking {
            self.standby.see(&estimate.object, now);
        }
        // Models that are old for a moment are being taken over; poses by models that stay old are no poses.
        let lost;
        let (estimate, is_due) = match self.replica.is_stuck(now) {
            true => {
                lost = as_lost(estimate);
                (&lost, true)
            }
            false => (estimate, self.replica.is_current()),
        };
        let epoch = self.standby.epoch_of(&estimate.object, now);
        let Some(epoch) = epoch.filter(|_| is_due) else {
            self.status.note_state(estimate);
            return;
        };
        let held_s = now.monotonic_ns.saturating_sub(self.handled_ns) as f64 * 1e-9;
        if held_s > self.max_age_s {
            self.outbox.count_held_up();
        } else if self.outbox.pose(estimate, epoch, now.wall_ns) {
            self.status.count(estimate);
        }
    }
}

/// The models of the site.
impl FusionCore {
    /// A message under a key of the configuration; what is no request, or is not for this node to decide on, is passed
    /// over.
    pub(crate) fn config(&mut self, item: &Item, now: Moment) {
        if !self.standby.leads() {
            return;
        }
        if let Some(request) = requests::parse(&self.keys, item, &self.proposals) {
            self.handled_ns = now.monotonic_ns;
            self.requested_ns = Some(now.monotonic_ns);
            self.replica.request(request, now);
            self.update_models(now);
        }
    }

    /// What became of the last [`Action::Keep`].
    pub(crate) fn kept(&mut self, outcome: Result<(), String>, now: Moment) {
        self.replica.kept(outcome, now);
    }

    /// Decides about changes where this node publishes the poses, and announces what is in force there.
    fn update_models(&mut self, now: Moment) {
        self.replica.tick(self.epoch(now).is_some(), now);
        self.note_stuck(now);
        // Before what is to be announced.
        let announces = self.standby.leads() && self.replica.is_current();
        self.outbox
            .announce(announces.then_some(self.replica.models()));
        while let Some(effect) = self.replica.poll() {
            match effect {
                Effect::PutInForce(changes) => self.apply_changes(&changes, now),
                Effect::Answer(answered) => self.answer(answered, now),
                Effect::Keep(job) => self.actions.push_back(Action::Keep(job)),
                Effect::Ask(node) => self.actions.push_back(Action::Ask(node)),
            }
        }
    }

    /// Logs once that this node has to publish, and has no models that it may publish by.
    fn note_stuck(&mut self, now: Moment) {
        let is_stuck = self.replica.is_stuck(now) && self.standby.leads();
        if is_stuck && !self.is_stuck {
            let newer = self.replica.outdated(now).next();
            let newer = newer.map(|(_, newer)| newer.to_string());
            tracing::error!(
                newer,
                "this node should publish the poses and does not have the newest rig and objects: \
                 it publishes all objects as lost until it has them"
            );
        }
        self.is_stuck = is_stuck;
    }

    /// Works from the models of the replica, which these changes have made.
    fn apply_changes(&mut self, changes: &[Change], now: Moment) {
        let models = self.replica.models();
        let posed = posed_objects(&models.rig, &models.objects);
        self.status.take_objects(posed.clone());
        self.standby.take_models(models);
        self.outbox.take_objects(posed);
        self.outbox.announce_changes(changes, self.replica.models());
        for change in changes {
            if let Change::Rig(rig) = change {
                self.intake.take_rig(cameras_of(rig));
                let source = input_log::source_of_rig(rig);
                self.feed(source, Input::Rig(rig.clone()), now);
            }
        }
        let is_about_objects =
            |change: &Change| matches!(change, Change::Object(_) | Change::Removal(_));
        if changes.iter().any(is_about_objects) {
            let objects = self.replica.models().objects.clone();
            let source = input_log::source_of_objects(&objects);
            self.feed(source, Input::Objects(objects), now);
        }
        self.outbox.models(self.replica.payloads());
        // The estimator does not depend on the settings of cameras.
        let is_about_models = |change: &Change| !matches!(change, Change::Camera(_));
        if changes.iter().any(is_about_models) {
            self.outbox.formers(self.replica.formers());
            // What was proposed was about the former models.
            self.propose(None, now);
        }
    }

    /// Says what became of a change.
    fn answer(&mut self, Answered { answer, origin }: Answered, now: Moment) {
        let (key, outcome) = (&answer.key, &answer.outcome);
        let (about, sender) = match origin {
            Origin::Request { about, sender } => (about, sender),
            Origin::Own => {
                match outcome {
                    ChangeOutcome::Refused(cause) => {
                        tracing::warn!("a refinement was refused: {cause}");
                        self.applies_from_ns = now.monotonic_ns + REFUSED_REST_NS;
                    }
                    _ => tracing::info!(
                        "a refined calibration is applied; `sextant config revert` takes it back"
                    ),
                }
                return;
            }
        };
        match outcome {
            ChangeOutcome::Refused(refusal) => {
                let sender = sender.as_deref();
                (self.status.refusals).add(key, sender, refusal, now.monotonic_ns);
                self.outbox.announce_again(&about, self.replica.models());
            }
            ChangeOutcome::Taken | ChangeOutcome::Kept | ChangeOutcome::Same => {
                self.status.refusals.remove(key)
            }
        }
        let (followers, behind) = (answer.followers.len(), answer.behind.len());
        tracing::info!(
            key,
            ?outcome,
            sender,
            followers,
            behind,
            "a change of the site"
        );
        self.outbox.answer(&answer);
    }
}

/// Once a second.
impl FusionCore {
    /// The status, the clocks, and the refined calibration that ordinary use has shown.
    pub(crate) fn report(&mut self, host: HostState, now: Moment) {
        self.status_due_ns = now.monotonic_ns + STATUS_PERIOD_NS;
        self.refine(now);
        self.clock = host.clock;
        self.status.namesakes = host.namesakes;
        self.status.epoch = self.standby.newest_epoch(now);
        self.status.models = model_notices(&self.replica, &self.node, now);
        let losses = Losses {
            unread: host.unread,
            held_up: self.outbox.held_up(),
            unpublished: self.outbox.unpublished().clone(),
        };
        let now_ns = now.monotonic_ns;
        let mut status = (self.status).status(&mut self.intake, &self.machine, losses, now_ns);
        status
            .objects
            .retain(|health| self.standby.tracks(&health.object));
        self.outbox.status(&status);
        let offsets = self.machine.clock_offsets();
        let clocks = self.clocks.report(&self.node, offsets, now_ns);
        self.outbox.clocks(&clocks);
    }

    /// Publishes the refined calibration, or puts it in force, as configured.
    fn refine(&mut self, now: Moment) {
        let proposal = match (self.refinement, self.epoch(now)) {
            (Refinement::Off, _) | (_, None) => None,
            (Refinement::Propose | Refinement::Apply, Some(_)) => self.machine.proposal(),
        };
        match (self.refinement, proposal) {
            (Refinement::Apply, Some(proposal)) => self.apply(proposal, now),
            (_, proposal) => self.propose(proposal, now),
        }
    }

    fn propose(&mut self, proposal: Option<Proposal>, now: Moment) {
        let is_first = self.proposals.newest().is_none();
        if !self.proposals.offer(proposal, now.wall_ns) {
            return;
        }
        let held_back = self.proposals.newest().map(|proposal| proposal.held_back);
        if let (Some(held_back), true) = (&held_back, is_first) {
            tracing::info!("{}", proposing::notice(held_back));
        }
        self.status.proposed = held_back;
        self.publish_proposal(now);
    }

    fn publish_proposal(&mut self, now: Moment) {
        match self.proposals.message(now.wall_ns) {
            Ok(message) => self.outbox.proposal(&message),
            Err(cause) => tracing::warn!("a refined calibration cannot be published: {cause}"),
        }
    }

    fn apply(&mut self, proposal: Proposal, now: Moment) {
        if self.replica.is_ready(now) && now.monotonic_ns >= self.applies_from_ns {
            let request = Request {
                key: Keys::below_site(&self.keys.config_models()).to_owned(),
                fingerprint: 0,
                origin: Origin::Own,
                changes: Ok(proposing::changes(proposal).collect()),
            };
            self.replica.request(request, now);
        }
    }
}

/// An estimate by models that are known to be old: the object is anywhere.
fn as_lost(estimate: &ObjectEstimate) -> ObjectEstimate {
    ObjectEstimate {
        state: State::Lost,
        ..estimate.clone()
    }
}

/// What a person should know of the models.
fn model_notices(replica: &Replica, node: &NodeId, now: Moment) -> Vec<Notice> {
    let outdated = replica
        .outdated(now)
        .map(|(node, newer)| Notice::OldModels {
            node: node.clone(),
            newer: newer.clone(),
        });
    let outdated = outdated.take(OLD_MODELS_SHOWN);
    let not_kept = replica.not_kept().map(|cause| Notice::NotKept {
        detail: detail(&cause),
    });
    let set_aside = replica.set_aside().map(|one| Notice::SetAside {
        node: node.clone(),
        by: one.by.clone(),
        t_ns: one.t_ns,
        detail: one.detail.clone(),
    });
    outdated.chain(not_kept).chain(set_aside).collect()
}

#[cfg(test)]
mod tests;
