//! The loop: messages in, poses and statuses out, until asked to stop.

use crate::adjuster::Adjuster;
use crate::change_handler::{ChangeHandler, Decision, Verdict};
use crate::clocks::DriftEstimator;
use crate::config::{FusionConfig, Refinement};
use crate::files::ModelFiles;
use crate::following;
use crate::input_log::{self, InputLog};
use crate::intake::{Arrival, Intake};
use crate::models::{Change, Models};
use crate::proposing;
use crate::publishers::Publishers;
use crate::standby::{Duty, Standby};
use crate::status::{Losses, StatusReporter};
use anyhow::Context;
use sextant_estimator::{Fusion, FusionOptions, Input, Output, Proposal};
use sextant_process::host::host_name;
use sextant_process::{
    ClockQuality, Exit, Reading, Shutdown, SteadyClock, WithExit, fail_point, memory, now_ns,
    watchdog,
};
use sextant_proto::{
    CameraSettings, ConfigAnswer, InputSource, KeyRef, Keys, NodeId, NodeKind, Outcome, limits,
};
use sextant_site_files::read_toml;
use sextant_site_model::{CameraId, Rig};
use sextant_site_report::{ObjectEstimate, State};
use sextant_zenoh_bus::{
    Bus, BusError, ControlProbe, DropRule, HeldName, Item, Payload, StreamBounds, Subscription,
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
    let files = config.keep_changes.then_some(files);
    let mut handler = ChangeHandler::new(keys, models, files);
    for change in following::changes(&bus, &handler)? {
        following::make(&mut handler, change, now_ns());
    }
    let machine = machine_of(handler.models())?;
    let clock = SteadyClock::new(Reading::take);
    let mut node = FusionNode::open(&bus, &config, machine, handler, clock)?;
    node.name = Some(name);
    let alive = bus.alive(&node.keys.alive(NodeKind::Fusion, &config.node))?;
    tracing::info!(
        cameras = node.handler.models().rig.cameras().len(),
        objects = node.handler.models().objects.len(),
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
    handler: ChangeHandler,
    intake: Intake,
    publishers: Publishers<'a>,
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
        handler: ChangeHandler,
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
        let models = handler.models();
        let mut standby = Standby::open(bus, &keys, node, &config.sharding, &clock)?;
        standby.take_objects(&models.objects);
        let mut publishers = Publishers::open(bus, &keys, node, models)?;
        publishers.formers(handler.formers())?;
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
            proposed: None,
            name: None,
            input_log: InputLog::new(node.clone()),
            node: node.clone(),
            keys,
            machine,
            adjuster: Adjuster::start()?,
            handler,
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
        self.follow_clock();
        self.take_turns()?;
        if let Some(item) = item {
            self.take(&item);
        }
        self.take_change()?;
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

    /// Publishes or stands by, as the other fusion nodes of the site leave it to this one. A node that is replaced works from the models
    /// of its successor, which may have been changed while the two did not hear each other.
    fn take_turns(&mut self) -> anyhow::Result<()> {
        let objects = &self.handler.models().objects;
        match self.standby.turn(self.bus, objects, &self.clock)? {
            Some(Duty::Publish { epoch }) if !self.standby.is_shared() => {
                tracing::info!(epoch, "this node publishes the poses");
            }
            Some(Duty::StandBy) => {
                if !self.standby.is_shared() {
                    tracing::info!("another fusion node publishes the poses: standing by");
                }
                self.propose(None)?;
                for change in following::changes(self.bus, &self.handler)? {
                    if let Some(change) =
                        following::make(&mut self.handler, change, self.clock.now_ns())
                    {
                        self.put_in_force(&change)?;
                    }
                }
            }
            Some(Duty::Publish { .. }) | None => {}
        }
        Ok(())
    }

    /// Epoch of the poses that this node publishes now; none while it stands by. Where objects are shared, of the node that cares for the site.
    fn epoch(&self) -> Option<u64> {
        self.standby.epoch(&self.clock)
    }

    /// At most one change a turn, and none for a while after it: images go first.
    fn take_change(&mut self) -> anyhow::Result<()> {
        let begun = Instant::now();
        let Some(item) = self.handler.next(begun, || self.changes.try_recv()) else {
            return Ok(());
        };
        if let Some(verdict) = self.handler.decide(&item, self.clock.now_ns()) {
            self.carry_out(&verdict, item.sender.as_deref())?;
        }
        self.handler.rest(begun, Instant::now());
        Ok(())
    }

    /// `now` is monotonic.
    fn report(&mut self, now: u64) -> anyhow::Result<()> {
        if let Some(name) = &mut self.name {
            self.status.namesakes = name.others().into_iter().map(str::to_owned).collect();
        }
        self.clock_quality = ClockQuality::read();
        self.status.epoch = self.standby.newest_epoch(&self.clock);
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

    /// Carries out a decision and publishes the answer.
    fn carry_out(&mut self, verdict: &Verdict, sender: Option<&str>) -> anyhow::Result<()> {
        let key = limits::clipped(&verdict.key, limits::MAX_DETAIL_BYTES);
        match &verdict.decision {
            Decision::Take(change, _) => self.put_in_force(change)?,
            Decision::Same => {}
            Decision::Refuse(refusal) => {
                let now = self.clock.monotonic_ns();
                self.status.refusals.add(&key, sender, refusal, now);
                self.announce_again(&verdict.about)?;
            }
        }
        let outcome = verdict.outcome();
        if !matches!(outcome, Outcome::Refused(_)) {
            self.status.refusals.remove(&key);
        }
        tracing::info!(key, ?outcome, sender, "a change of the site");
        self.publishers.answer(&ConfigAnswer {
            node: self.node.clone(),
            key,
            fingerprint: verdict.fingerprint,
            outcome,
        })?;
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
            (_, proposal) => self.propose(proposal),
        }
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

    fn apply(&mut self, proposal: Proposal) -> anyhow::Result<()> {
        let held_back = proposal.held_back;
        for change in proposing::changes(proposal) {
            match self.handler.make(change, self.clock.now_ns()) {
                Ok(Decision::Take(change, _)) => {
                    self.put_in_force(&change)?;
                    self.request(&change)?;
                }
                Ok(_) => {}
                Err(cause) => tracing::warn!("a refinement was refused: {cause}"),
            }
        }
        tracing::info!(
            ?held_back,
            "a refined calibration is applied; `sextant config revert` takes it back"
        );
        Ok(())
    }

    /// Publishes a change that this node made by itself.
    fn request(&self, change: &Change) -> anyhow::Result<()> {
        match change {
            Change::Rig(rig) => self.publishers.request_rig(rig)?,
            Change::Object(object) => self.publishers.request_object(object)?,
            Change::Removal(_) | Change::Camera(_) => {}
        }
        Ok(())
    }

    fn put_in_force(&mut self, change: &Change) -> anyhow::Result<()> {
        match change {
            Change::Rig(rig) => {
                self.intake.take_rig(cameras_of(rig));
                self.publishers.announce_rig(rig)?;
                self.take_models(input_log::source_of_rig(rig), Input::Rig(rig.clone()));
            }
            Change::Object(object) => {
                self.publishers.put_object(object)?;
                self.publishers.announce_object(object.id())?;
                self.take_objects();
            }
            Change::Removal(id) => {
                self.publishers.remove_object(id);
                self.take_objects();
            }
            // The estimator does not depend on them.
            Change::Camera(settings) => {
                self.publishers.announce_settings(settings)?;
                return Ok(());
            }
        }
        self.publishers.formers(self.handler.formers())?;
        // What was proposed was about the former models.
        self.propose(None)
    }

    fn take_objects(&mut self) {
        let objects = self.handler.models().objects.clone();
        let source = input_log::source_of_objects(&objects);
        self.take_models(source, Input::Objects(objects));
    }

    fn take_models(&mut self, source: InputSource, input: Input) {
        let now = self.clock.now_ns();
        self.input_log.add(now, source);
        let objects = &self.handler.models().objects;
        self.status.take_objects(objects);
        self.standby.take_objects(objects);
        self.machine.handle(now, input);
    }

    /// Announces what is in force after a refusal, for those who received the refused change.
    fn announce_again(&mut self, about: &KeyRef) -> anyhow::Result<()> {
        match about {
            KeyRef::ConfigObject(id) => self.publishers.announce_object(id)?,
            KeyRef::ConfigCamera(id) => {
                let settings = self.handler.models().settings.get(id).cloned();
                let settings = settings.unwrap_or_else(|| CameraSettings::none(id.clone()));
                self.publishers.announce_settings(&settings)?;
            }
            _ => self.publishers.announce_rig(&self.handler.models().rig)?,
        }
        Ok(())
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
                    let (now, models) = (self.clock.now_ns(), self.handler.models());
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
        let Some(epoch) = self.standby.epoch_of(&estimate.object, &self.clock) else {
            self.status.note_state(estimate);
            return Ok(());
        };
        let now = self.clock.now_ns();
        if self.publishers.pose(estimate, epoch, now)? {
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

#[cfg(test)]
mod tests;
