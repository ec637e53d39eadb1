//! The loop: messages in, poses and statuses out, until asked to stop.

use crate::adjuster::Adjuster;
use crate::announcer::Announcer;
use crate::clocks::DriftEstimator;
use crate::config::{FusionConfig, Refinement};
use crate::files::ModelFiles;
use crate::formers::Formers;
use crate::input_log::{self, InputLog};
use crate::intake::{Arrival, Intake};
use crate::models::{Change, Models, Payloads};
use crate::proposing;
use crate::publishers::Publishers;
use crate::refusals::detail;
use crate::replica::{Answered, Effect, Origin, Replica, Request};
use crate::requests;
use crate::standby::{Duty, Standby, moment};
use crate::status::{Losses, StatusReporter};
use crate::storer::Storer;
use anyhow::Context;
use sextant_election::Moment;
use sextant_estimator::{Fusion, FusionOptions, Input, Output, Proposal};
use sextant_process::host::host_name;
use sextant_process::{
    ClockQuality, Exit, Reading, Shutdown, SteadyClock, WithExit, fail_point, memory, now_ns,
    watchdog,
};
use sextant_proto::{InputSource, Keys, NodeId, NodeKind, Notice, Outcome, limits};
use sextant_site_files::read_toml;
use sextant_site_model::{CameraId, Rig};
use sextant_site_report::{ObjectEstimate, State};
use sextant_zenoh_bus::{
    Bus, BusError, ControlProbe, DropRule, HeldName, Item, Payload, Question, StreamBounds,
    Subscription,
};
use std::path::Path;
use std::time::{Duration, Instant};

/// Most observations that wait, and their bytes: one second of 64 cameras at 30 images a second with 20 tags each. They wait for at most
/// `max_age_s`.
const QUEUE: usize = 2048;
const QUEUE_BYTES: usize = 8 << 20;
/// Most changes of rig and objects that wait.
const CHANGE_QUEUE: usize = 256;
/// Between two statuses.
const STATUS_PERIOD_NS: u64 = 1_000_000_000;
/// How long another fusion node may take to hand over its models.
const MODELS_WAIT: Duration = Duration::from_secs(3);
/// After a refinement was refused, ns.
const REFUSED_REST_NS: u64 = 60_000_000_000;
/// Most notices of nodes whose models are old.
const OLD_MODELS_SHOWN: usize = 4;
/// Longest sleep: bounds the delay of a shutdown.
const LONGEST_WAIT: Duration = Duration::from_millis(100);

/// Runs a fusion node until `shutdown`.
///
/// # Errors
/// [`Exit::Input`] for a wrong file, [`Exit::Unavailable`] when the network can't be had.
pub fn run(config_file: &Path, shutdown: &Shutdown) -> anyhow::Result<()> {
    memory::keep_heap_small();
    let config: FusionConfig = read_toml(config_file).exit_with(Exit::Input)?;
    let folder = config_file.parent().unwrap_or(Path::new(""));
    let security = config.protection(folder).exit_with(Exit::Input)?;
    config
        .check()
        .map_err(anyhow::Error::msg)
        .with_context(|| config_file.display().to_string())
        .exit_with(Exit::Input)?;
    let (files, models) = ModelFiles::read(config_file, &config)?;
    models
        .check()
        .with_context(|| format!("{}: cannot be published", config_file.display()))
        .exit_with(Exit::Input)?;
    let machine_of = |models: &Models| {
        let (rig, objects) = (models.rig.clone(), models.objects.clone());
        Fusion::new(rig, objects, FusionOptions::default())
    };
    machine_of(&models)
        .with_context(|| format!("{}: objects", config_file.display()))
        .exit_with(Exit::Input)?;
    let stop = || {
        watchdog::feed();
        shutdown.is_requested()
    };
    if let Some(words) = security.warning(now_ns() / 1_000_000_000) {
        tracing::warn!("{words}");
    }
    let bus = match Bus::open_unless(&config.network, &security, &stop) {
        Err(BusError::Abandoned { .. }) => return Ok(()),
        opened => opened.exit_with(Exit::Unavailable)?,
    };
    let keys = Keys::of(config.site.clone());
    let holder = keys.holder(NodeKind::Fusion, &config.node);
    let held = bus.hold_name(&holder, &host_name(), &|| shutdown.is_requested());
    let Some(name) = held.exit_with(Exit::Unavailable)? else {
        return Ok(());
    };
    let machine = machine_of(&models)?;
    let keeps = config.keep_changes;
    let (formers, record) = match keeps {
        true => (files.formers(), files.record()),
        false => (Formers::default(), None),
    };
    let replica = Replica::new(config.node.clone(), models, formers, record, keeps);
    let storer = keeps.then(|| Storer::start(files)).transpose()?;
    let clock = SteadyClock::new(Reading::take);
    let mut node = FusionNode::open(&bus, &config, machine, replica, clock)?;
    node.storer = storer;
    node.name = Some(name);
    let alive = bus.alive(&node.keys.alive(NodeKind::Fusion, &config.node))?;
    tracing::info!(
        cameras = node.replica.models().rig.cameras().len(),
        objects = node.replica.models().objects.len(),
        "fusing"
    );
    node.work(shutdown)?;
    drop(alive);
    drop(node);
    bus.close();
    Ok(())
}

struct FusionNode<'a> {
    bus: &'a Bus,
    keys: Keys,
    node: NodeId,
    observations: Subscription,
    changes: Subscription,
    machine: Fusion,
    adjuster: Adjuster,
    input_log: InputLog,
    replica: Replica,
    /// None where changes are not kept.
    storer: Option<Storer>,
    /// Asked another node for its models, and whom.
    question: Option<(NodeId, Question)>,
    intake: Intake,
    publishers: Publishers<'a>,
    /// While this node publishes the poses.
    announcer: Option<Announcer<'a>>,
    standby: Standby,
    probe: ControlProbe,
    status: StatusReporter,
    clocks: DriftEstimator,
    /// Timers use its monotonic time, the machine its steady time.
    clock: SteadyClock,
    /// Quality of this host's clock at the last status.
    clock_quality: ClockQuality,
    /// Monotonic.
    status_due_ns: u64,
    refinement: Refinement,
    /// How long a pose may be held up before it is published.
    max_age_s: f64,
    /// When the images and messages of this turn were read, monotonic.
    turned_ns: u64,
    /// A refinement that was refused is not applied again before, monotonic.
    applies_from_ns: u64,
    /// The proposal published last.
    proposed: Option<Proposal>,
    /// Held while the node runs.
    name: Option<HeldName>,
}

fn cameras_of(rig: &Rig) -> impl Iterator<Item = CameraId> {
    rig.cameras().iter().map(|camera| camera.id.clone())
}

impl<'a> FusionNode<'a> {
    fn open(
        bus: &'a Bus,
        config: &FusionConfig,
        mut machine: Fusion,
        mut replica: Replica,
        clock: SteadyClock,
    ) -> anyhow::Result<Self> {
        machine.adjust_apart();
        let (keys, node) = (Keys::of(config.site.clone()), &config.node);
        let bounds = StreamBounds {
            items: QUEUE,
            bytes: QUEUE_BYTES,
            wait: Duration::from_secs_f64(config.max_age_s),
        };
        let longest = limits::MAX_PAYLOAD_BYTES;
        let now = clock.monotonic_ns();
        let mut standby = Standby::open(bus, &keys, node, &config.sharding, &mut replica, &clock)?;
        let models = replica.models();
        standby.take_objects(&models.objects);
        let mut publishers = Publishers::open(bus, &keys, node, models)?;
        publishers.models(replica.payloads())?;
        publishers.formers(replica.formers())?;
        publishers.proposal(&proposing::message(None, node, 0)?)?;
        let intake = Intake::new(keys.clone(), cameras_of(&models.rig), config.max_age_s);
        let arrivals = intake.arrivals();
        let (all, hear) = (keys.all_observations(), move |key: &str| {
            arrivals.count(key)
        });
        Ok(Self {
            observations: bus.subscribe_stream_heard(&all, bounds, longest, hear)?,
            changes: bus.subscribe(&keys.all_config(), CHANGE_QUEUE, DropRule::Oldest, longest)?,
            intake,
            publishers,
            probe: ControlProbe::new(&keys.all_alive(), Instant::now()),
            standby,
            status: StatusReporter::new(node.clone(), &models.objects, now),
            clocks: DriftEstimator::default(),
            clock_quality: ClockQuality::read(),
            clock,
            status_due_ns: now,
            refinement: config.refinement,
            max_age_s: config.max_age_s,
            turned_ns: now,
            applies_from_ns: 0,
            proposed: None,
            name: None,
            input_log: InputLog::new(node.clone()),
            node: node.clone(),
            keys,
            machine,
            adjuster: Adjuster::start()?,
            replica,
            storer: None,
            question: None,
            announcer: None,
            bus,
        })
    }

    fn work(&mut self, shutdown: &Shutdown) -> anyhow::Result<()> {
        while !shutdown.is_requested() {
            self.turn()?;
        }
        Ok(())
    }

    /// Waits for an observation, then does all that is due.
    fn turn(&mut self) -> anyhow::Result<()> {
        fail_point!("fusion");
        let answered = self.probe.check(self.bus, Instant::now());
        answered.exit_with(Exit::Unavailable)?;
        watchdog::feed();
        let item = self.observations.recv_timeout(self.wait_at_most());
        self.turned_ns = self.clock.monotonic_ns();
        self.follow_clock();
        self.take_turns()?;
        if let Some(item) = item {
            self.take(&item);
        }
        // Those of the models that are in force still.
        self.publish_poses()?;
        self.care_for_models()?;
        self.adjust();
        let now = self.clock.now_ns();
        if self.machine.poll_timeout().is_some_and(|due| due <= now) {
            self.input_log.add(now, InputSource::Tick);
            self.machine.handle(now, Input::Tick);
        }
        self.publish_poses()?;
        while let Some(inputs) = self.input_log.poll(now) {
            // Those of a share of the objects would not replay to the poses of all.
            if self.epoch().is_some() && !self.standby.is_shared() {
                self.publishers.inputs(&inputs)?;
            }
        }
        let now = self.clock.monotonic_ns();
        if now >= self.status_due_ns {
            self.status_due_ns = now + STATUS_PERIOD_NS;
            self.refine()?;
            self.report(now)?;
        }
        Ok(())
    }

    /// Has the adjustment of the files that is due solved, and applies it once it is.
    fn adjust(&mut self) {
        match self.machine.adjustment() {
            Some(task) if task.is_solved() => {
                let now = self.clock.now_ns();
                self.input_log.add(now, InputSource::Adjusted);
                self.machine.handle(now, Input::Adjusted);
            }
            Some(task) => self.adjuster.solve(task),
            None => {}
        }
    }

    /// After this host's clock was set, everything that compares stamps with it begins anew.
    fn follow_clock(&mut self) {
        if let Some(by_ns) = self.clock.take_step() {
            self.intake.clock_stepped();
            self.standby.interrupted(&self.clock);
            let now = self.clock.now_ns();
            self.input_log.add(now, InputSource::ClockStep);
            self.machine.handle(now, Input::ClockStep { by_ns });
        }
    }

    /// Publishes or stands by, as the other fusion nodes of the site leave it to this one.
    fn take_turns(&mut self) -> anyhow::Result<()> {
        let duty = self
            .standby
            .turn(self.bus, &mut self.replica, &self.clock)?;
        let is_shared = self.standby.is_shared();
        match duty {
            Some(Duty::Publish { epoch }) if !is_shared => {
                tracing::info!(epoch, "this node publishes the poses");
            }
            Some(Duty::StandBy) => {
                if !is_shared {
                    tracing::info!("another fusion node publishes the poses: standing by");
                }
                self.propose(None)?;
            }
            Some(Duty::Publish { .. }) | None => {}
        }
        Ok(())
    }

    /// Takes models over from other nodes, decides about changes where this node publishes the poses, and announces what is in force there.
    fn care_for_models(&mut self) -> anyhow::Result<()> {
        let (leads, now) = (self.standby.leads(), moment(&self.clock));
        if let Some(outcome) = self.storer.as_ref().and_then(Storer::poll) {
            self.replica.kept(outcome, now);
        }
        let answered = |(_, question): &(NodeId, Question)| question.poll();
        if let Some(items) = self.question.as_ref().and_then(answered)
            && let Some((node, _)) = self.question.take()
        {
            let theirs = Payloads::answered(&self.keys.models_of(&node), &items);
            self.replica.follow(&node, theirs, now);
        }
        self.take_request(leads)?;
        self.replica
            .tick(self.epoch().is_some(), moment(&self.clock));
        // Before what is to be announced.
        match (leads && self.replica.is_current(), &self.announcer) {
            (true, None) => {
                let models = self.replica.models();
                let announcer = Announcer::open(self.bus, &self.keys, &self.node, models)?;
                self.announcer = Some(announcer);
            }
            (false, Some(_)) => self.announcer = None,
            _ => {}
        }
        while let Some(effect) = self.replica.poll() {
            self.carry_out(effect)?;
        }
        Ok(())
    }

    /// At most one change a turn, and none for a while after it: images go first. The node that publishes the poses decides.
    fn take_request(&mut self, leads: bool) -> anyhow::Result<()> {
        let begun = moment(&self.clock);
        if leads && !self.replica.is_ready(begun) {
            return Ok(());
        }
        let request = requests::next(&self.keys, || self.changes.try_recv());
        if let Some(request) = request.filter(|_| leads) {
            self.replica.request(request, begun);
            let ended_ns = self.clock.monotonic_ns();
            self.replica.rest(begun.monotonic_ns, ended_ns);
        }
        Ok(())
    }

    fn carry_out(&mut self, effect: Effect) -> anyhow::Result<()> {
        match effect {
            Effect::PutInForce(changes) => self.put_in_force(&changes)?,
            Effect::Answer(answered) => self.answer(answered)?,
            Effect::Keep(job) => {
                if let Some(storer) = &self.storer {
                    storer.keep(job);
                }
            }
            // The one before is waited for.
            Effect::Ask(_) if self.question.is_some() => {}
            Effect::Ask(node) => {
                let key = format!("{}/**", self.keys.models_of(&node));
                let question =
                    (self.bus).ask_others(&key, limits::MAX_PAYLOAD_BYTES, MODELS_WAIT)?;
                self.question = Some((node, question));
            }
        }
        Ok(())
    }

    /// Epoch of the poses that this node publishes now; none while it stands by. Where objects are shared, of the node that cares for the site.
    fn epoch(&self) -> Option<u64> {
        let epoch = self.standby.epoch(&self.clock);
        epoch.filter(|_| self.replica.is_current())
    }

    /// `now` is monotonic.
    fn report(&mut self, now: u64) -> anyhow::Result<()> {
        if let Some(name) = &mut self.name {
            self.status.namesakes = name.others().into_iter().map(str::to_owned).collect();
        }
        self.clock_quality = ClockQuality::read();
        self.status.epoch = self.standby.newest_epoch(&self.clock);
        self.status.models = model_notices(&self.replica, moment(&self.clock));
        let losses = Losses {
            unread: self.observations.counts().dropped,
            unpublished: self.publishers.unpublished().clone(),
        };
        let mut status = self
            .status
            .status(&mut self.intake, &self.machine, losses, now);
        status
            .objects
            .retain(|health| self.standby.tracks(&health.object));
        self.publishers.status(&status)?;
        let offsets = self.machine.clock_offsets();
        let clocks = self.clocks.report(&self.node, offsets, now);
        Ok(self.publishers.clocks(&clocks)?)
    }

    /// Publishes what became of a change.
    fn answer(&mut self, Answered { answer, origin }: Answered) -> anyhow::Result<()> {
        let (key, outcome) = (&answer.key, &answer.outcome);
        let (about, sender) = match origin {
            Origin::Request { about, sender } => (about, sender),
            Origin::Own => {
                match outcome {
                    Outcome::Refused(cause) => {
                        tracing::warn!("a refinement was refused: {cause}");
                        self.applies_from_ns = self.clock.monotonic_ns() + REFUSED_REST_NS;
                    }
                    _ => tracing::info!(
                        "a refined calibration is applied; `sextant config revert` takes it back"
                    ),
                }
                return Ok(());
            }
        };
        match outcome {
            Outcome::Refused(refusal) => {
                let now = self.clock.monotonic_ns();
                (self.status.refusals).add(key, sender.as_deref(), refusal, now);
                if let Some(announcer) = &mut self.announcer {
                    announcer.again(&about, self.replica.models())?;
                }
            }
            Outcome::Taken | Outcome::Kept | Outcome::Same => self.status.refusals.remove(key),
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
        self.publishers.answer(&answer)?;
        Ok(())
    }

    /// Publishes the refined calibration that ordinary use has shown, or puts it in force, as configured.
    fn refine(&mut self) -> anyhow::Result<()> {
        let proposal = match (self.refinement, self.epoch()) {
            (Refinement::Off, _) | (_, None) => None,
            (Refinement::Propose | Refinement::Apply, Some(_)) => self.machine.proposal(),
        };
        match (self.refinement, proposal) {
            (Refinement::Apply, Some(proposal)) => self.apply(proposal),
            (_, proposal) => self.propose(proposal)?,
        }
        Ok(())
    }

    fn propose(&mut self, proposal: Option<Proposal>) -> anyhow::Result<()> {
        if proposal == self.proposed {
            return Ok(());
        }
        if let (Some(proposal), None) = (&proposal, &self.proposed) {
            tracing::info!("{}", proposing::notice(&proposal.held_back));
        }
        let message = proposing::message(proposal.as_ref(), &self.node, self.clock.now_ns());
        self.status.proposed = proposal.as_ref().map(|proposal| proposal.held_back);
        self.proposed = proposal;
        match message {
            Ok(message) => self.publishers.proposal(&message)?,
            Err(cause) => tracing::warn!("a refined calibration cannot be published: {cause}"),
        }
        Ok(())
    }

    fn apply(&mut self, proposal: Proposal) {
        let now = moment(&self.clock);
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

    /// Works from the models of the replica, which these changes have made.
    fn put_in_force(&mut self, changes: &[Change]) -> anyhow::Result<()> {
        let mut are_objects_new = false;
        for change in changes {
            match change {
                Change::Rig(rig) => {
                    self.intake.take_rig(cameras_of(rig));
                    self.take_models(input_log::source_of_rig(rig), Input::Rig(rig.clone()));
                }
                Change::Object(object) => self.publishers.put_object(object)?,
                Change::Removal(id) => self.publishers.remove_object(id),
                // The estimator does not depend on them.
                Change::Camera(_) => {}
            }
            are_objects_new |= matches!(change, Change::Object(_) | Change::Removal(_));
            if let Some(announcer) = &mut self.announcer {
                announcer.change(change)?;
            }
        }
        if are_objects_new {
            let objects = self.replica.models().objects.clone();
            let source = input_log::source_of_objects(&objects);
            self.take_models(source, Input::Objects(objects));
        }
        self.publishers.models(self.replica.payloads())?;
        if changes
            .iter()
            .any(|change| !matches!(change, Change::Camera(_)))
        {
            self.publishers.formers(self.replica.formers())?;
            // What was proposed was about the former models.
            self.propose(None)?;
        }
        Ok(())
    }

    fn take_models(&mut self, source: InputSource, input: Input) {
        let now = self.clock.now_ns();
        self.input_log.add(now, source);
        let objects = &self.replica.models().objects;
        self.status.take_objects(objects);
        self.standby.take_objects(objects);
        self.machine.handle(now, input);
    }

    fn take(&mut self, item: &Item) {
        match &item.payload {
            Payload::Bytes(bytes) => {
                let arrival = Arrival {
                    now_ns: self.clock.now_ns(),
                    monotonic_ns: self.clock.monotonic_ns(),
                    clock: self.clock_quality,
                };
                if let Some(image) = self.intake.take(&item.key, bytes, arrival) {
                    let (now, models) = (self.clock.now_ns(), self.replica.models());
                    self.input_log.add_image(now, image.source, models);
                    let mut image = models.rig.timed(image.observation);
                    image
                        .tags
                        .retain(|seen| !self.standby.is_foreign(&seen.tag));
                    self.machine.handle(now, Input::Image(image));
                }
            }
            Payload::TooLong(_) => self.intake.count_too_long(&item.key),
        }
    }

    fn publish_poses(&mut self) -> anyhow::Result<()> {
        while let Some(output) = self.machine.poll_output() {
            match output {
                Output::Pose(estimate) => self.publish_pose(&estimate)?,
                Output::ClockStep { by_ns } => {
                    let now = self.clock.monotonic_ns();
                    self.status.clock_stepped(by_ns, now);
                }
                other => tracing::warn!(?other, "unexpected output of the estimator"),
            }
        }
        Ok(())
    }

    fn publish_pose(&mut self, estimate: &ObjectEstimate) -> anyhow::Result<()> {
        if estimate.state == State::Tracking {
            self.standby.see(&estimate.object, &self.clock);
        }
        let epoch = self.standby.epoch_of(&estimate.object, &self.clock);
        let Some(epoch) = epoch.filter(|_| self.replica.is_current()) else {
            self.status.note_state(estimate);
            return Ok(());
        };
        let now = moment(&self.clock);
        let held_s = now.monotonic_ns.saturating_sub(self.turned_ns) as f64 * 1e-9;
        if held_s > self.max_age_s {
            self.publishers.count_held_up(&estimate.object, held_s);
        } else if self.publishers.pose(estimate, epoch, now.wall_ns)? {
            self.status.count(estimate);
        }
        Ok(())
    }

    fn wait_at_most(&self) -> Duration {
        let due = self.machine.poll_timeout().unwrap_or(u64::MAX);
        let wait = due.saturating_sub(self.clock.now_ns());
        let due = self.status_due_ns.min(self.standby.due_ns());
        let others = due.saturating_sub(self.clock.monotonic_ns());
        Duration::from_nanos(wait.min(others)).min(LONGEST_WAIT)
    }
}

/// What a person should know of the models.
fn model_notices(replica: &Replica, now: Moment) -> Vec<Notice> {
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
    outdated.chain(not_kept).collect()
}

#[cfg(test)]
mod tests;
