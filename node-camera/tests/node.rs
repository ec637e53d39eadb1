//! The camera node as processes: images of a simulated camera go through shared memory and the detector to the network;
//! a part that is killed comes back; a signal ends everything and leaves nothing.

#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    reason = "a test fails by panicking"
)]

use std::fs;
use std::path::Path;
use std::process::Command;
use std::sync::atomic::{AtomicU32, Ordering};
use std::time::{Duration, Instant};

use node_camera::{
    CameraNodeConfig, CommandConfig, CommandLine, Pace, SourceConfig, StreamFormat, VideoConfig,
};
use sextant_iceoryx_images::{IceoryxOptions, ImageSubscriber};
use sextant_process::children::ChildProcess;
use sextant_process::memory::pss_bytes;
use sextant_proto::{
    CameraStatus, ClockSource, Keys, ObjectConfig, Observations, Preview, RigConfig, SiteId, limits,
};
use sextant_recordings::{GreyImage, write_grey_png};
use sextant_simulator::{Renderer, Scenario};
use sextant_site_model::{Camera, CameraId, ObjectId, ObjectModel, ObjectTag, Rig, TagId};
use sextant_test_needs::VIDEO;
use sextant_zenoh_bus::{Bus, BusOptions, DropRule, Presence, Qos, Subscription};

const PATIENCE: Duration = Duration::from_secs(60);

/// A site with a router in this process, a scenario, and the configuration of its first camera.
struct Site {
    bus: Bus,
    keys: Keys,
    camera: CameraId,
    scenario: Scenario,
    shared_memory: IceoryxOptions,
    folder: tempfile::TempDir,
}

impl Site {
    fn new() -> Self {
        let folder = tempfile::Builder::new()
            .prefix("sxn")
            .tempdir_in("/tmp")
            .unwrap();
        let scenario = Scenario::demo(1, 2, 1);
        let site = Self {
            bus: Bus::open(&BusOptions::router_on("tcp/127.0.0.1:0")).unwrap(),
            keys: Keys::new("test").unwrap(),
            camera: CameraId::new(&scenario.cameras[0].id).unwrap(),
            scenario,
            shared_memory: IceoryxOptions {
                root: folder.path().join("i"),
                prefix: unique_prefix(),
            },
            folder,
        };
        sextant_site_files::write_toml(&site.folder.path().join("scenario.toml"), &site.scenario)
            .unwrap();
        let config = CameraNodeConfig::new(
            SiteId::new("test").unwrap(),
            site.camera.clone(),
            SourceConfig::simulator("scenario.toml"),
            BusOptions::client_of(&site.bus.endpoints()[0]),
            site.shared_memory.clone(),
        );
        sextant_site_files::write_toml(&site.config_file(), &config).unwrap();
        site
    }

    fn config_file(&self) -> std::path::PathBuf {
        self.folder.path().join("camera.toml")
    }

    fn command(&self, part: Option<&str>) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_node-camera"));
        command.arg("--config").arg(self.config_file());
        if let Some(part) = part {
            command.args(["--part", part]);
        }
        command
    }

    fn start(&self, part: Option<&str>) -> ChildProcess {
        ChildProcess::spawn(part.unwrap_or("both"), &mut self.command(part)).unwrap()
    }

    fn subscribe(&self, key: &str) -> Subscription {
        self.bus
            .subscribe(key, 64, DropRule::Oldest, limits::MAX_PAYLOAD_BYTES)
            .unwrap()
    }

    fn next_observations(
        &self,
        subscription: &Subscription,
        wanted: impl Fn(&Observations) -> bool,
    ) -> Observations {
        let deadline = Instant::now() + PATIENCE;
        while Instant::now() < deadline {
            if let Some(item) = subscription.recv_timeout(Duration::from_millis(100)) {
                let observations: Observations = item.decode().unwrap();
                if wanted(&observations) {
                    return observations;
                }
            }
        }
        panic!("no such observations within a minute");
    }

    fn publish_models(
        &self,
    ) -> (
        sextant_zenoh_bus::Latest<RigConfig>,
        Vec<sextant_zenoh_bus::Latest<ObjectConfig>>,
    ) {
        let cameras = self.scenario.cameras.iter().map(|camera| {
            Camera::new(
                CameraId::new(&camera.id).unwrap(),
                camera.resolution,
                camera.lens,
                Some(camera.world_from_camera),
            )
        });
        let rig = self
            .bus
            .latest_publisher(&self.keys.config_rig(), Qos::Config)
            .unwrap();
        rig.put(&RigConfig::from(&Rig::new(cameras.collect()).unwrap()))
            .unwrap();
        let objects = self.scenario.objects.iter().map(|object| {
            let id = ObjectId::new(&object.id).unwrap();
            let tags = object.tags.iter().map(|tag| {
                ObjectTag::new(
                    TagId {
                        family: tag.family,
                        id: tag.id,
                    },
                    tag.size,
                    Some(tag.object_from_tag),
                )
            });
            let model = ObjectModel::new(id.clone(), tags.collect()).unwrap();
            let publisher = self
                .bus
                .latest_publisher(&self.keys.config_object(&id), Qos::Config)
                .unwrap();
            publisher.put(&ObjectConfig::from(&model)).unwrap();
            publisher
        });
        (rig, objects.collect())
    }

    fn assert_nothing_remains(&self) {
        assert!(!self.shared_memory.root.exists());
        let start = format!("{}_", self.shared_memory.prefix);
        let left = fs::read_dir("/dev/shm")
            .unwrap()
            .map(|entry| entry.unwrap().file_name());
        let ours: Vec<_> = left
            .filter(|name| name.to_string_lossy().starts_with(&start))
            .collect();
        assert!(ours.is_empty(), "{ours:?}");
    }
}

/// Ten bytes at most: what file names show of a prefix.
fn unique_prefix() -> String {
    static NUMBER: AtomicU32 = AtomicU32::new(0);
    format!(
        "{:x}n{}",
        std::process::id(),
        NUMBER.fetch_add(1, Ordering::SeqCst)
    )
}

/// The process id of a part that `parent` started.
fn part_of(parent: &ChildProcess, part: &str) -> Option<u32> {
    let id = parent.id();
    let children = fs::read_to_string(format!("/proc/{id}/task/{id}/children")).unwrap();
    children
        .split_whitespace()
        .map(|pid| pid.parse().unwrap())
        .find(|pid: &u32| {
            let arguments = fs::read_to_string(format!("/proc/{pid}/cmdline")).unwrap_or_default();
            arguments.split('\0').any(|argument| argument == part)
        })
}

fn stop(mut node: ChildProcess) -> Duration {
    node.ask_to_stop();
    let asked = Instant::now();
    let status = node
        .wait_until(asked + PATIENCE)
        .unwrap()
        .expect("it ends by itself");
    assert!(status.success(), "{status}");
    asked.elapsed()
}

#[test]
fn images_become_observations_with_poses_and_an_exact_account() {
    let site = Site::new();
    let _models = site.publish_models();
    let (watch, statuses) = (
        site.bus.watch_alive(&site.keys.all_alive()).unwrap(),
        site.subscribe(&site.keys.camera_status(&site.camera)),
    );
    let subscription = site.subscribe(&site.keys.observations(&site.camera));
    let previews = site.subscribe(&site.keys.preview(&site.camera));
    let (detect, capture) = (site.start(Some("detect")), site.start(Some("capture")));
    assert!(matches!(
        watch.recv_timeout(PATIENCE),
        Some(Presence::Joined(_))
    ));

    let seen = site.next_observations(&subscription, |observations| {
        observations.tags.iter().any(|tag| tag.poses.len() == 2)
    });
    let timing = seen.timing;
    assert!(
        seen.capture_ns < timing.received_ns
            && timing.received_ns <= timing.detected_ns
            && timing.detected_ns <= timing.published_ns
    );
    let preview: Preview = previews.recv_timeout(PATIENCE).unwrap().decode().unwrap();
    assert_eq!(preview.jpeg[..2], [0xff, 0xd8]);
    for _ in 0..100 {
        site.next_observations(&subscription, |_| true);
    }
    let mut reader = ImageSubscriber::open(&site.shared_memory, site.camera.as_str()).unwrap();
    assert!(
        reader.wait(PATIENCE).unwrap().is_some(),
        "a third process takes the same images"
    );
    drop(reader);
    println!(
        "capture {} kB, detect {} kB (proportional set size)",
        pss_bytes(capture.id()).unwrap() / 1024,
        pss_bytes(detect.id()).unwrap() / 1024
    );

    let (detect_end, capture_end) = (stop(detect), stop(capture));
    println!("detect ended after {detect_end:?}, capture after {capture_end:?}");
    assert!(matches!(
        watch.recv_timeout(PATIENCE),
        Some(Presence::Left(_))
    ));
    let mut last: Option<CameraStatus> = None;
    while let Some(item) = statuses.try_recv() {
        last = Some(item.decode().unwrap());
    }
    let last = last.unwrap();
    println!("{last:?}");
    assert_eq!(last.captured, last.detected + last.dropped);
    assert!(last.detected > 100 && last.published == last.detected);
    site.assert_nothing_remains();
}

#[test]
fn a_killed_capture_comes_back_to_the_same_detection() {
    let site = Site::new();
    let subscription = site.subscribe(&site.keys.observations(&site.camera));
    let detect = site.start(Some("detect"));
    let mut capture = site.start(Some("capture"));
    let before = site.next_observations(&subscription, |observations| observations.sequence > 3);
    capture.child_mut().kill().unwrap();
    capture.child_mut().wait().unwrap();
    let again = site.start(Some("capture"));
    site.next_observations(&subscription, |observations| {
        observations.sequence < before.sequence
    });
    stop(again);
    stop(detect);
    site.assert_nothing_remains();
}

#[test]
fn a_second_camera_of_one_name_is_refused_with_the_others_host() {
    let site = Site::new();
    let subscription = site.subscribe(&site.keys.observations(&site.camera));
    let both = site.start(None);
    site.next_observations(&subscription, |_| true);
    let second = site.command(Some("detect")).output().unwrap();
    assert_eq!(second.status.code(), Some(4));
    let (words, host) = (
        String::from_utf8(second.stderr).unwrap(),
        sextant_process::host::host_name(),
    );
    let expected = format!("camera {} runs on host {host} already", site.camera);
    assert!(words.contains(&expected), "{words}");
    stop(both);
    site.assert_nothing_remains();
}

#[test]
fn a_lock_that_another_process_holds_delays_no_end() {
    let site = Site::new();
    let root = &site.shared_memory.root;
    fs::create_dir(root).unwrap();
    let lock = fs::File::open(root).unwrap();
    for part in ["capture", "detect"] {
        lock.lock().unwrap();
        let waiting = site.start(Some(part));
        let descriptors = format!("/proc/{}/fd", waiting.id());
        until("it is at the lock", || {
            let open = fs::read_dir(&descriptors).into_iter().flatten().flatten();
            open.map(|entry| fs::read_link(entry.path()).unwrap_or_default())
                .any(|path| path == *root)
        });
        stop(waiting);
        lock.unlock().unwrap();
    }
    let subscription = site.subscribe(&site.keys.observations(&site.camera));
    let both = site.start(None);
    site.next_observations(&subscription, |_| true);
    lock.lock().unwrap();
    stop(both);
    lock.unlock().unwrap();
    sextant_iceoryx_images::remove_dead(&site.shared_memory).unwrap();
    site.assert_nothing_remains();
}

fn until(what: &str, mut condition: impl FnMut() -> bool) {
    let deadline = Instant::now() + PATIENCE;
    while !condition() {
        assert!(Instant::now() < deadline, "never happened: {what}");
        std::thread::sleep(Duration::from_millis(5));
    }
}

#[test]
fn both_parts_run_under_one_parent_and_end_with_it() {
    let site = Site::new();
    let subscription = site.subscribe(&site.keys.observations(&site.camera));
    let both = site.start(None);
    site.next_observations(&subscription, |observations| !observations.tags.is_empty());
    println!("both ended after {:?}", stop(both));
    site.assert_nothing_remains();
}

#[test]
fn the_parent_starts_a_killed_part_again() {
    let site = Site::new();
    let subscription = site.subscribe(&site.keys.observations(&site.camera));
    let both = site.start(None);
    for part in ["capture", "detect"] {
        let before =
            site.next_observations(&subscription, |observations| observations.sequence > 3);
        let victim = part_of(&both, part).unwrap();
        assert!(
            Command::new("kill")
                .args(["-9", &victim.to_string()])
                .status()
                .unwrap()
                .success()
        );
        until_gone(victim);
        while subscription.try_recv().is_some() {}
        let after = site.next_observations(&subscription, |_| true);
        assert!(after.capture_ns > before.capture_ns);
        assert_ne!(part_of(&both, part), Some(victim));
    }
    stop(both);
    site.assert_nothing_remains();
}

fn until_gone(pid: u32) {
    let deadline = Instant::now() + PATIENCE;
    while Path::new(&format!("/proc/{pid}")).exists() {
        assert!(Instant::now() < deadline);
        std::thread::sleep(Duration::from_millis(5));
    }
}

/// So many images of the first camera, 33 ms apart.
fn rendered(site: &Site, count: u64) -> Vec<(u64, GreyImage)> {
    let mut renderer = Renderer::new(&site.scenario, 0).unwrap();
    let [width, height] = site.scenario.cameras[0]
        .resolution
        .map(|pixels| pixels as usize);
    let render = |number: u64| {
        let mut pixels = vec![0; width * height];
        let capture_ns = number * 33_000_000;
        renderer.render(capture_ns, &mut pixels).unwrap();
        let image = GreyImage {
            width,
            height,
            pixels,
        };
        (capture_ns, image)
    };
    (1..=count).map(render).collect()
}

/// The images one after the other, as a program would write them.
fn write_raw(site: &Site, file: &Path, count: u64) {
    let images = rendered(site, count);
    let raw: Vec<u8> = images
        .into_iter()
        .flat_map(|(_, image)| image.pixels)
        .collect();
    fs::write(file, raw).unwrap();
}

/// The images as a recording, in the folder `recording`.
fn write_recording(site: &Site, images: &[(u64, GreyImage)]) {
    let recording = site.folder.path().join("recording");
    let camera = recording.join(site.camera.as_str());
    fs::create_dir_all(camera.join("data")).unwrap();
    let mut csv = String::new();
    for (number, (capture_ns, image)) in images.iter().enumerate() {
        let name = format!("{number}.png");
        write_grey_png(&camera.join("data").join(&name), image).unwrap();
        csv += &format!("{capture_ns},{name}\n");
    }
    fs::write(camera.join("data.csv"), csv).unwrap();
}

/// The middle of an image, a quarter as wide and high.
fn middle(image: &GreyImage) -> GreyImage {
    let (width, height) = (image.width / 4, image.height / 4);
    let [left, top] = [image.width - width, image.height - height].map(|rest| rest / 2);
    let rows = image.pixels.chunks(image.width).skip(top).take(height);
    GreyImage {
        width,
        height,
        pixels: rows
            .flat_map(|row| &row[left..left + width])
            .copied()
            .collect(),
    }
}

fn use_source(site: &Site, source: SourceConfig) {
    let config = CameraNodeConfig {
        source,
        ..CameraNodeConfig::read(&site.config_file()).unwrap()
    };
    sextant_site_files::write_toml(&site.config_file(), &config).unwrap();
}

#[test]
fn a_program_is_a_camera_and_is_started_again_when_it_ends() {
    let site = Site::new();
    let file = site.folder.path().join("frames");
    write_raw(&site, &file, 10);
    let cat = format!("cat {}", file.display());
    let source = CommandConfig {
        run: CommandLine::Text(cat),
        format: StreamFormat::Grey,
        resolution: Some(site.scenario.cameras[0].resolution),
        row_length: None,
        latency_ms: None,
    };
    use_source(&site, SourceConfig::Command(source));
    let subscription = site.subscribe(&site.keys.observations(&site.camera));
    let both = site.start(None);
    let seen = site.next_observations(&subscription, |seen| !seen.tags.is_empty());
    assert_eq!(seen.clock.source, ClockSource::Arrival);
    // Beyond what one run of the program has.
    site.next_observations(&subscription, |seen| seen.sequence > 20);
    stop(both);
    site.assert_nothing_remains();
}

#[test]
fn a_video_is_played_at_its_own_times_to_its_end() {
    if VIDEO.is_skipped() {
        return;
    }
    let site = Site::new();
    let raw = site.folder.path().join("frames");
    write_raw(&site, &raw, 40);
    let [width, height] = site.scenario.cameras[0].resolution;
    let encoded = Command::new("ffmpeg")
        .args(["-loglevel", "error", "-f", "rawvideo", "-pix_fmt", "gray"])
        .args([
            "-video_size",
            &format!("{width}x{height}"),
            "-framerate",
            "20",
        ])
        .args(["-i".as_ref(), raw.as_os_str()])
        .args(["-c:v", "ffv1"])
        .arg(site.folder.path().join("tags.mkv"))
        .status()
        .expect("ffmpeg runs (Debian: apt install ffmpeg)");
    assert!(encoded.success());
    let video = VideoConfig {
        file: "tags.mkv".into(),
        repeat: false,
        start_ns: None,
    };
    use_source(&site, SourceConfig::Video(video));
    let subscription = site.subscribe(&site.keys.observations(&site.camera));
    let mut both = site.start(None);
    let first = site.next_observations(&subscription, |seen| !seen.tags.is_empty());
    assert_eq!(first.clock.source, ClockSource::Recorded);
    let later = site.next_observations(&subscription, |seen| seen.sequence > first.sequence);
    let images = later.sequence - first.sequence;
    assert_eq!(later.capture_ns - first.capture_ns, images * 50_000_000);
    let status = both
        .wait_until(Instant::now() + PATIENCE)
        .unwrap()
        .expect("it ends by itself");
    assert!(status.success());
    site.assert_nothing_remains();
}

#[test]
fn a_recording_is_played_to_its_end() {
    let site = Site::new();
    write_recording(&site, &rendered(&site, 60));
    use_source(&site, SourceConfig::images("recording"));
    let subscription = site.subscribe(&site.keys.observations(&site.camera));
    let mut both = site.start(None);
    let seen = site.next_observations(&subscription, |observations| !observations.tags.is_empty());
    assert_eq!(seen.clock.source, ClockSource::Recorded);
    assert_eq!(seen.capture_ns, (seen.sequence + 1) * 33_000_000);
    let status = both
        .wait_until(Instant::now() + PATIENCE)
        .unwrap()
        .expect("it ends by itself");
    assert!(status.success());
    site.assert_nothing_remains();
}

#[test]
fn a_wrong_file_ends_with_the_code_of_wrong_input() {
    let site = Site::new();
    fs::write(site.config_file(), "site = \"test\"\n").unwrap();
    for part in [None, Some("capture"), Some("detect")] {
        let mut node = site.start(part);
        let status = node.wait_until(Instant::now() + PATIENCE).unwrap().unwrap();
        assert_eq!(status.code(), Some(3));
    }
    site.assert_nothing_remains();
}

#[test]
fn a_scenario_without_the_camera_ends_both_parts() {
    let site = Site::new();
    let text = fs::read_to_string(site.config_file()).unwrap();
    fs::write(
        site.config_file(),
        text.replace(
            &format!("camera = \"{}\"", site.camera),
            "camera = \"nobody\"",
        ),
    )
    .unwrap();
    let mut node = site.start(None);
    let status = node.wait_until(Instant::now() + PATIENCE).unwrap().unwrap();
    assert_eq!(status.code(), Some(3));
    site.assert_nothing_remains();
}

#[test]
fn detection_without_a_router_waits_and_ends_when_asked() {
    let site = Site::new();
    let endpoint = site.bus.endpoints()[0].clone();
    let Site { bus, .. } = &site;
    assert!(!endpoint.is_empty() && bus.is_connected());
    let text = fs::read_to_string(site.config_file()).unwrap();
    let free = std::net::TcpListener::bind("127.0.0.1:0")
        .unwrap()
        .local_addr()
        .unwrap();
    fs::write(
        site.config_file(),
        text.replace(&endpoint, &format!("tcp/{free}")),
    )
    .unwrap();
    let node = site.start(Some("detect"));
    std::thread::sleep(Duration::from_millis(300));
    stop(node);
    site.assert_nothing_remains();
}

/// As fast as it goes: `cargo test --release --workspace --test node -- --ignored --nocapture`.
#[test]
#[ignore = "takes minutes"]
fn memory_stays_flat_over_a_million_images() {
    const IMAGES: u64 = 1_000_000;
    let site = Site::new();
    let images = rendered(&site, 50);
    let small = images.iter().map(|(time, image)| (*time, middle(image)));
    write_recording(&site, &small.collect::<Vec<_>>());
    let source = SourceConfig::Images {
        folder: "recording".into(),
        pace: Pace::AsFastAsPossible,
        repeat: true,
        start_ns: None,
    };
    use_source(&site, source);
    let subscription = site.subscribe(&site.keys.observations(&site.camera));
    let statuses = site.subscribe(&site.keys.camera_status(&site.camera));
    let parts = ["capture", "detect"].map(|part| site.start(Some(part)));
    let kilobytes = || {
        parts
            .each_ref()
            .map(|part| pss_bytes(part.id()).unwrap() / 1024)
    };
    site.next_observations(&subscription, |seen| !seen.tags.is_empty());
    let (started, mut before) = (Instant::now(), None);
    let detected = loop {
        let status = statuses.recv_timeout(PATIENCE).expect("a status");
        let detected = status.decode::<CameraStatus>().unwrap().detected;
        if detected >= IMAGES / 10 {
            before.get_or_insert_with(kilobytes);
        }
        if detected >= IMAGES {
            break detected;
        }
    };
    let (before, after) = (before.unwrap(), kilobytes());
    println!(
        "{detected} images in {:.0?}; capture and detect have {before:?} kB after a tenth, {after:?} kB at the end",
        started.elapsed()
    );
    for (before, after) in before.iter().zip(after) {
        assert!(after <= before + 256, "{before} kB became {after} kB");
    }
    for part in parts {
        stop(part);
    }
    site.assert_nothing_remains();
}
