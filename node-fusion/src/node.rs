//! The process around [`FusionCore`]: the network, the files, the threads and the clock.

use crate::adjuster::Adjuster;
use crate::config::FusionConfig;
use crate::files::ModelFiles;
use crate::formers::Formers;
use crate::fusion_core::{Action, FusionCore, HostState, InitialState};
use crate::models::ModelsInForce;
use crate::ports::Ports;
use crate::storer::Storer;
use crate::turn::{Environment, MOST_REQUESTS};
use anyhow::Context;
use sextant_election::{Link, Moment};
use sextant_estimator::SolverTask;
use sextant_process::host::host_name;
use sextant_process::{
    ClockQuality, Exit, Reading, Shutdown, SteadyClock, WithExit, fail_point, memory, now_ns,
    watchdog,
};
use sextant_proto::limits::{MAX_PAYLOAD_BYTES, MAX_PEERS};
use sextant_proto::{KeyRef, Keys, MessageKind, NodeId, NodeKind};
use sextant_site_files::read_toml;
use sextant_zenoh_bus::{
    AliveWatch, Bus, BusError, ControlProbe, DropRule, HeldName, Item, Presence, Question,
    StreamBounds, Subscription,
};
use std::path::Path;
use std::time::{Duration, Instant};

/// Most observations that wait, and their bytes: one second of 64 cameras at 30 images a second with 20 tags each. They
/// wait for at most `max_age_s`.
const QUEUE: usize = 2048;
const QUEUE_BYTES: usize = 8 << 20;
/// Most heartbeats that wait: three seconds of those of as many nodes as a site may have.
const HEARTBEATS: StreamBounds = StreamBounds {
    items: 60 * MAX_PEERS,
    bytes: 8 << 20,
    wait: Duration::MAX,
};
/// How long another fusion node may take to hand over its models.
const MODELS_WAIT: Duration = Duration::from_secs(3);
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
        .check_use()
        .with_context(|| config_file.display().to_string())
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
    let keys = Keys::for_site(config.site.clone());
    let holder = keys.holder(NodeKind::Fusion, &config.node);
    let held = bus.hold_name(&holder, &host_name(), &|| shutdown.is_requested());
    let Some(name) = held.exit_with(Exit::Unavailable)? else {
        return Ok(());
    };
    let (mut process, mut core) = Process::open(&bus, &config, files, models, name)?;
    let alive = bus.alive(&keys.alive(NodeKind::Fusion, &config.node))?;
    let in_force = core.models();
    tracing::info!(
        cameras = in_force.rig.cameras().len(),
        objects = in_force.objects.len(),
        "fusing"
    );
    while !shutdown.is_requested() {
        process.turn(&mut core)?;
    }
    drop(alive);
    drop(process);
    bus.close();
    Ok(())
}

/// What a fusion node's process has of the network, the files and the host.
struct Process<'a> {
    bus: &'a Bus,
    keys: Keys,
    ports: Ports<'a>,
    observations: Subscription,
    /// The observation of this turn.
    observation: Option<Item>,
    changes: Subscription,
    heartbeats: Subscription,
    presence: AliveWatch,
    /// None where changes are not kept.
    storer: Option<Storer>,
    adjuster: Adjuster,
    /// Asked another node for its models, and whom.
    question: Option<(NodeId, Question)>,
    probe: ControlProbe,
    clock: SteadyClock,
    name: HeldName,
}

impl<'a> Process<'a> {
    /// The process, and its node.
    fn open(
        bus: &'a Bus,
        config: &FusionConfig,
        files: ModelFiles,
        models: ModelsInForce,
        name: HeldName,
    ) -> anyhow::Result<(Self, FusionCore)> {
        let keys = Keys::for_site(config.site.clone());
        let clock = SteadyClock::new(Reading::take);
        let bounds = StreamBounds {
            items: QUEUE,
            bytes: QUEUE_BYTES,
            wait: Duration::from_secs_f64(config.max_age_s),
        };
        let (beats, longest) = (keys.all_heartbeats(), MessageKind::Heartbeat.max_bytes());
        let heartbeats = bus.subscribe_stream(&beats, HEARTBEATS, longest)?;
        let alive = bus.alive_keys(&keys.all_fusion_alive())?;
        let others = alive.iter().filter_map(|key| match keys.parse(key)? {
            KeyRef::Alive(_, node) => Some(node),
            _ => None,
        });
        let (formers, record) = match config.keep_changes {
            true => (files.formers(), files.record()),
            false => (Formers::default(), None),
        };
        let initial = InitialState {
            models,
            formers,
            record,
            unwritten: files.unwritten(),
            others: others.collect(),
            clock: ClockQuality::read(),
        };
        let mut core = FusionCore::new(config, initial, moment(&clock))?;
        let arrivals = core.arrivals();
        let count = move |key: &str| arrivals.count(key);
        let (images, changes) = (keys.all_observations(), keys.all_config());
        let longest = MAX_PAYLOAD_BYTES;
        let mut process = Self {
            observations: bus.subscribe_stream_heard(&images, bounds, longest, count)?,
            observation: None,
            changes: bus.subscribe(&changes, MOST_REQUESTS, DropRule::Oldest, longest)?,
            heartbeats,
            presence: bus.watch_alive(&keys.all_fusion_alive())?,
            ports: Ports::new(bus),
            storer: (config.keep_changes)
                .then(|| Storer::start(files))
                .transpose()?,
            adjuster: Adjuster::start()?,
            question: None,
            probe: ControlProbe::new(&keys.all_alive(), Instant::now()),
            clock,
            name,
            keys,
            bus,
        };
        // Programs that see this node's token find the values that it keeps for late joiners.
        core.act(&mut process)?;
        Ok((process, core))
    }

    /// Waits for an observation, then takes a turn.
    fn turn(&mut self, core: &mut FusionCore) -> anyhow::Result<()> {
        fail_point!("fusion");
        let answered = self.probe.check(self.bus, Instant::now());
        answered.exit_with(Exit::Unavailable)?;
        watchdog::feed();
        let now = self.now();
        let wait = core.poll_timeout(now).saturating_sub(now.monotonic_ns);
        let wait = Duration::from_nanos(wait).min(LONGEST_WAIT);
        self.observation = self.observations.recv_timeout(wait);
        Ok(core.turn(self)?)
    }
}

impl Environment for Process<'_> {
    type Error = BusError;

    fn now(&self) -> Moment {
        moment(&self.clock)
    }

    fn take_clock_step(&mut self) -> Option<i64> {
        self.clock.take_step()
    }

    fn link(&self) -> Link {
        match self.bus.is_connected() {
            true => Link::Up,
            false => Link::Down,
        }
    }

    fn next_presence(&mut self) -> Option<Presence> {
        self.presence.try_recv()
    }

    fn next_heartbeat(&mut self) -> Option<Item> {
        self.heartbeats.try_recv()
    }

    fn next_observation(&mut self) -> Option<Item> {
        self.observation.take()
    }

    fn next_request(&mut self) -> Option<Item> {
        self.changes.try_recv()
    }

    fn kept(&mut self) -> Option<Result<(), String>> {
        self.storer.as_ref()?.poll()
    }

    fn answers(&mut self) -> Option<(NodeId, Vec<Item>)> {
        let (_, question) = self.question.as_ref()?;
        let items = question.poll()?;
        let (node, _) = self.question.take()?;
        Some((node, items))
    }

    fn host(&mut self) -> HostState {
        HostState {
            clock: ClockQuality::read(),
            namesakes: self.name.others().into_iter().map(str::to_owned).collect(),
            unread: self.observations.counts().dropped,
        }
    }

    fn act(&mut self, action: Action, _: &FusionCore) -> Result<(), BusError> {
        match action {
            Action::Publish(publication) => self.ports.publish(publication)?,
            Action::Keep(job) => {
                if let Some(storer) = &self.storer {
                    storer.keep(job);
                }
            }
            // The one before is waited for.
            Action::Ask(_) if self.question.is_some() => {}
            Action::Ask(node) => {
                let key = format!("{}/**", self.keys.models_of(&node));
                let question = self.bus.ask_others(&key, MAX_PAYLOAD_BYTES, MODELS_WAIT)?;
                self.question = Some((node, question));
            }
        }
        Ok(())
    }

    fn solve(&mut self, task: &SolverTask) {
        self.adjuster.solve(task);
    }
}

/// Now, by both clocks of the host.
fn moment(clock: &SteadyClock) -> Moment {
    Moment {
        monotonic_ns: clock.monotonic_ns(),
        wall_ns: clock.now_ns(),
    }
}
