//! A site of several processes that a test may kill, stop and cut off: routers, fusion nodes, and cameras whose images
//! the test makes up.

use crate::fault_proxy::until;
use crate::program::sextant;
use crate::witness::client_of;
use crate::{Scene, free_port, place, send};
use sextant_process::now_ns;
use sextant_proto::{FusionStatus, Keys, ObjectPose, State, encode, limits};
use sextant_site_files::{write_object, write_rig};
use sextant_zenoh_bus::{Bus, DropRule, Qos, RawPublisher};
use std::collections::BTreeMap;
use std::fs;
use std::path::PathBuf;
use std::process::{Child, Command, Stdio};
use std::sync::atomic::{AtomicBool, AtomicI64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

/// Tests of houses are about time: they run one after the other.
static ONE_AT_A_TIME: Mutex<()> = Mutex::new(());

/// Processes of a site. Dropping it ends them.
pub struct House {
    folder: tempfile::TempDir,
    /// What its files say.
    files: Scene,
    /// What its camera feeds see.
    scene: Scene,
    running: BTreeMap<String, Running>,
    /// The site's keys.
    pub keys: Keys,
    _turn: MutexGuard<'static, ()>,
}

struct Running {
    child: Child,
    /// A program that runs `sextant`, with its own arguments; none: it runs by itself.
    wrapper: Vec<String>,
    arguments: Vec<String>,
}

impl House {
    /// A house whose files say what is true of this scene.
    ///
    /// # Panics
    /// When files cannot be written.
    #[must_use]
    pub fn new(scene: &Scene) -> Self {
        Self::with_files(scene, scene)
    }

    /// A house whose files say otherwise than its camera feeds see: more, for cameras and objects of real camera nodes,
    /// or with errors.
    ///
    /// # Panics
    /// When files cannot be written.
    #[must_use]
    pub fn with_files(files: &Scene, scene: &Scene) -> Self {
        let turn = ONE_AT_A_TIME.lock().unwrap_or_else(PoisonError::into_inner);
        Self {
            folder: tempfile::tempdir().expect("a temporary folder"),
            files: files.clone(),
            scene: scene.clone(),
            running: BTreeMap::new(),
            keys: Keys::new("lab").expect("an id"),
            _turn: turn,
        }
    }

    /// Nodes that are started from now on have the files of this scene.
    pub fn set_files(&mut self, files: &Scene) {
        self.files = files.clone();
    }

    /// Starts a router that connects to these others; its endpoint.
    ///
    /// # Panics
    /// When it does not start.
    pub fn router(&mut self, name: &str, others: &[&str]) -> String {
        let endpoint = format!("tcp/127.0.0.1:{}", free_port());
        self.router_on(name, &endpoint, others, &[]);
        endpoint
    }

    /// Starts a router on this endpoint, run by a program with these arguments.
    ///
    /// # Panics
    /// When it does not start.
    pub fn router_in(&mut self, name: &str, endpoint: &str, wrapper: &[&str]) {
        self.router_on(name, endpoint, &[], wrapper);
    }

    fn router_on(&mut self, name: &str, endpoint: &str, others: &[&str], wrapper: &[&str]) {
        let mut arguments = vec!["router", "--listen", endpoint];
        for other in others {
            arguments.extend(["--connect", other]);
        }
        self.start_in(name, owned(wrapper), owned(&arguments));
        let address = endpoint.trim_start_matches("tcp/").to_owned();
        until("the router listens", || {
            std::net::TcpStream::connect(&address).is_ok()
        });
    }

    /// Starts a fusion node behind these routers, and waits for its first status.
    ///
    /// # Panics
    /// When it does not come up.
    pub fn fusion(&mut self, name: &str, routers: &[&str]) {
        self.fusion_with(name, routers, "");
    }

    /// The same with further sections in its file.
    ///
    /// # Panics
    /// When it does not come up.
    pub fn fusion_with(&mut self, name: &str, routers: &[&str], sections: &str) {
        self.fusion_in(name, routers, sections, &[]);
    }

    /// The same run by a program with these arguments.
    ///
    /// # Panics
    /// When it does not come up.
    pub fn fusion_in(&mut self, name: &str, routers: &[&str], sections: &str, wrapper: &[&str]) {
        let folder = self.folder.path().join(name);
        fs::create_dir(&folder).expect("a folder");
        write_rig(&folder.join("rig.toml"), &self.files.rig).expect("a file");
        let names: Vec<String> = (self.files.objects.iter())
            .map(|object| format!("{}.toml", object.id()))
            .collect();
        for (object, name) in self.files.objects.iter().zip(&names) {
            write_object(&folder.join(name), object).expect("a file");
        }
        let text = format!(
            "site = \"lab\"\nnode = \"{name}\"\nrig = \"rig.toml\"\nobjects = {names:?}\n\
             keep_changes = true\n[network]\nmode = \"client\"\nconnect = {routers:?}\n{sections}"
        );
        let file = folder.join("fusion.toml");
        fs::write(&file, text).expect("a file");
        let file = file.display().to_string();
        let arguments = owned(&["fusion", "--config", &file]);
        self.start_in(name, owned(wrapper), arguments);
        self.await_statuses(routers, |statuses| statuses.contains_key(name));
    }

    /// Starts `sextant <command>` with a file of this text in the folder `name`, which is made where it is missing.
    ///
    /// # Panics
    /// When the file cannot be written.
    pub fn node(&mut self, name: &str, command: &str, text: &str) {
        self.node_in(name, command, text, &[]);
    }

    /// The same run by a program with these arguments.
    ///
    /// # Panics
    /// When the file cannot be written.
    pub fn node_in(&mut self, name: &str, command: &str, text: &str, wrapper: &[&str]) {
        let file = self.path(name, "node.toml");
        fs::create_dir_all(file.parent().expect("a folder")).expect("a folder");
        fs::write(&file, text).expect("a file");
        let file = file.display().to_string();
        let arguments = owned(&[command, "--config", &file]);
        self.start_in(name, owned(wrapper), arguments);
    }

    /// Process id of a part of a camera node; none while it does not run.
    ///
    /// # Panics
    /// When the node was never started.
    #[must_use]
    pub fn part_of(&self, name: &str, part: &str) -> Option<u32> {
        let id = self.running[name].child.id();
        let children = fs::read_to_string(format!("/proc/{id}/task/{id}/children")).ok()?;
        let mut ids = children.split_whitespace().filter_map(|id| id.parse().ok());
        ids.find(|id| {
            let words = fs::read_to_string(format!("/proc/{id}/cmdline")).unwrap_or_default();
            words.split('\0').any(|word| word == part)
        })
    }

    /// Asks all processes to end, and waits for them.
    pub fn end(&mut self) {
        for running in self.running.values_mut() {
            if matches!(running.child.try_wait(), Ok(None)) {
                send(running.child.id(), libc::SIGCONT);
                send(running.child.id(), libc::SIGTERM);
            }
        }
        for running in self.running.values_mut() {
            let _ = running.child.wait();
        }
    }

    /// Starts a command against this site, whose output nobody reads.
    pub fn tool(&mut self, name: &str, router: &str, arguments: &[&str]) {
        let site = ["--site", "lab", "--connect", router];
        let arguments = arguments.iter().chain(&site);
        self.start(name, arguments.map(|&one| one.to_owned()).collect());
    }

    fn start(&mut self, name: &str, arguments: Vec<String>) {
        self.start_in(name, Vec::new(), arguments);
    }

    fn start_in(&mut self, name: &str, wrapper: Vec<String>, arguments: Vec<String>) {
        let running = Running {
            child: spawn(&wrapper, &arguments),
            wrapper,
            arguments,
        };
        self.running.insert(name.to_owned(), running);
    }

    /// Starts a process again that has ended, with the same files.
    ///
    /// # Panics
    /// When it was never started.
    pub fn restart(&mut self, name: &str) {
        let running = self.running.get_mut(name).expect("it was started");
        running.child = spawn(&running.wrapper, &running.arguments);
    }

    /// Kills a process as a power cut would, and waits for its end.
    ///
    /// # Panics
    /// When it does not run.
    pub fn kill(&mut self, name: &str) {
        let running = self.running.get_mut(name).expect("it was started");
        running.child.kill().expect("it runs");
        running.child.wait().expect("it ends");
    }

    /// Sends a signal to a process.
    ///
    /// # Panics
    /// When it was never started.
    pub fn signal(&self, name: &str, signal: i32) {
        send(self.running[name].child.id(), signal);
    }

    /// A file of a node.
    #[must_use]
    pub fn path(&self, node: &str, file: &str) -> PathBuf {
        self.folder.path().join(node).join(file)
    }

    fn publisher(&self, bus: &Bus, camera: usize) -> RawPublisher {
        let key = self.keys.observations(&self.scene.rig.cameras()[camera].id);
        bus.raw_publisher(&key, Qos::Observation)
            .expect("a publisher")
    }

    /// Resident memory of a process, MiB.
    ///
    /// # Panics
    /// When it does not run.
    #[must_use]
    pub fn memory_mib(&self, name: &str) -> f64 {
        let file = format!("/proc/{}/status", self.running[name].child.id());
        let text = fs::read_to_string(file).expect("it runs");
        let line = text.lines().find_map(|line| line.strip_prefix("VmRSS:"));
        let kib = line.and_then(|line| line.split_whitespace().next()?.parse::<f64>().ok());
        kib.expect("a figure in kB") / 1024.0
    }

    /// How many files a process has open.
    ///
    /// # Panics
    /// When it was never started.
    #[must_use]
    pub fn open_files(&self, name: &str) -> usize {
        let folder = format!("/proc/{}/fd", self.running[name].child.id());
        fs::read_dir(folder).map_or(0, Iterator::count)
    }

    /// A command against this site.
    #[must_use]
    pub fn command(&self, router: &str, arguments: &[&str]) -> Command {
        let mut command = sextant();
        command.args(arguments);
        command.args(["--site", "lab", "--connect", router]);
        command
    }

    /// Waits until the newest statuses of the fusion nodes, by name, are as wanted; returns them.
    ///
    /// # Panics
    /// When they never are.
    pub fn await_statuses(
        &self,
        routers: &[&str],
        wanted: impl Fn(&BTreeMap<String, FusionStatus>) -> bool,
    ) -> BTreeMap<String, FusionStatus> {
        let bus = client_of(routers);
        let key = self.keys.all_fusion_statuses();
        let longest = limits::MAX_PAYLOAD_BYTES;
        let statuses = bus.subscribe(&key, 1024, DropRule::Oldest, longest);
        let statuses = statuses.expect("a subscription");
        let (mut newest, mut received) = (BTreeMap::new(), BTreeMap::new());
        until("such statuses", || {
            while let Some(item) = statuses.try_recv() {
                let status: FusionStatus = item.decode().expect("a status");
                received.insert(status.node.to_string(), Instant::now());
                newest.insert(status.node.to_string(), status);
            }
            // What a node that is gone said last no longer counts.
            newest.retain(|node, _| received[node].elapsed() < Duration::from_millis(2500));
            wanted(&newest)
        });
        newest
    }
}

fn owned(words: &[&str]) -> Vec<String> {
    words.iter().map(|&word| word.to_owned()).collect()
}

fn spawn(wrapper: &[String], arguments: &[String]) -> Child {
    let mut command = sextant();
    if let [program, rest @ ..] = wrapper {
        let mut wrapped = Command::new(program);
        wrapped.args(rest).arg(command.get_program());
        command = wrapped;
    }
    command.args(arguments).stdout(Stdio::null());
    command.spawn().expect("sextant starts")
}

impl Drop for House {
    fn drop(&mut self) {
        self.end();
    }
}

/// Cameras of a house.
#[derive(Debug, Clone, Copy)]
pub struct Cameras<'a> {
    /// Which of the scene.
    pub cameras: &'a [usize],
    /// Behind one of these routers.
    pub routers: &'a [&'a str],
    /// When the objects began to move, ns since the Unix epoch; the same for all cameras of a house.
    pub start_ns: u64,
    /// Images a second of each.
    pub rate_hz: u64,
}

/// Cameras that see a scene, live: a thread that publishes what each sees. Dropping it ends them.
pub struct CameraFeed {
    shared: Arc<Shared>,
    thread: Option<JoinHandle<()>>,
    start_ns: u64,
}

#[derive(Debug, Default)]
struct Shared {
    stop: AtomicBool,
    /// By how much the cameras' clock is ahead, ns.
    clock_ns: AtomicI64,
}

impl CameraFeed {
    /// Starts these cameras.
    ///
    /// # Panics
    /// When no router answers.
    #[must_use]
    pub fn start(house: &House, what: Cameras<'_>) -> Self {
        let bus = client_of(what.routers);
        let shared = Arc::new(Shared::default());
        let feeding = Feeding {
            publishers: what
                .cameras
                .iter()
                .map(|&k| house.publisher(&bus, k))
                .collect(),
            scene: house.scene.clone(),
            cameras: what.cameras.to_vec(),
            start_ns: what.start_ns,
            // Cameras take turns, as free-running ones do.
            turn_ns: 1_000_000_000 / what.rate_hz / what.cameras.len() as u64,
            shared: Arc::clone(&shared),
            _bus: bus,
        };
        Self {
            shared,
            thread: Some(std::thread::spawn(|| feeding.run())),
            start_ns: what.start_ns,
        }
    }

    /// Sets the cameras' clock to be ahead by so many ns.
    pub fn set_clock(&self, by_ns: i64) {
        self.shared.clock_ns.store(by_ns, Ordering::Relaxed);
    }

    /// Distance between a pose and the truth, m.
    ///
    /// # Panics
    /// For an object that the scene lacks.
    #[must_use]
    pub fn error_m(&self, house: &House, pose: &ObjectPose) -> f64 {
        let objects = &house.scene.objects;
        let k = objects
            .iter()
            .position(|object| *object.id() == pose.object);
        let seconds = (pose.capture_ns as f64 - self.start_ns as f64) * 1e-9;
        let truth = place(k.expect("an object of the scene"), seconds);
        (truth.translation.vector - nalgebra::Vector3::from(pose.position)).norm()
    }

    /// Whether a pose claims to be good and is not.
    #[must_use]
    pub fn is_wrong(&self, house: &House, pose: &ObjectPose) -> bool {
        pose.state == State::Tracking && self.error_m(house, pose) > 0.02
    }
}

struct Feeding {
    publishers: Vec<RawPublisher>,
    scene: Scene,
    cameras: Vec<usize>,
    start_ns: u64,
    turn_ns: u64,
    shared: Arc<Shared>,
    _bus: Bus,
}

impl Feeding {
    fn run(mut self) {
        let n = self.cameras.len() as u64;
        let first = now_ns().saturating_sub(self.start_ns) / self.turn_ns + 1;
        for turn in first.. {
            let at_ns = self.start_ns + turn * self.turn_ns;
            std::thread::sleep(Duration::from_nanos(at_ns.saturating_sub(now_ns())));
            if self.shared.stop.load(Ordering::Relaxed) {
                return;
            }
            let which = (turn % n) as usize;
            let seconds = (at_ns - self.start_ns) as f64 * 1e-9;
            let stamp_ns =
                at_ns.saturating_add_signed(self.shared.clock_ns.load(Ordering::Relaxed));
            let mut seen = self.scene.observe(self.cameras[which], seconds, stamp_ns);
            seen.sequence = turn / n;
            // What the network does not take is lost, as a camera's would be.
            let _ = self.publishers[which].put(&encode(&seen).expect("a message"));
        }
    }
}

impl Drop for CameraFeed {
    fn drop(&mut self) {
        self.shared.stop.store(true, Ordering::Relaxed);
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}
