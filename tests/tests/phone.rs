//! A browser as a camera: its page detects tags in a video, the bridge publishes them, and fusion finds the object.

#![allow(clippy::expect_used, reason = "a test ends by panicking")]

use serde_json::Value;
use sextant_proto::{CameraStatus, ClockSource, ObjectPose, Observations, State, limits};
use sextant_simulator::{Renderer, Scenario};
use sextant_site_model::{Camera, CameraId, ObjectId, ObjectModel, ObjectTag, Rig, TagId};
use sextant_tag_families::Family;
use sextant_test_needs as needs;
use sextant_zenoh_bus::{DropRule, Profile, Subscription};
use std::fs;
use std::io::Write;
use std::net::TcpStream;
use std::path::Path;
use std::process::Child;
use std::time::{Duration, Instant};
use system_tests::{FusedSite, LockedSite, free_port, run_page_checks, send, sextant};

const NAME: &str = "pocket";
const PATIENCE: Duration = Duration::from_secs(60);

struct Bridge(Child);

impl Drop for Bridge {
    fn drop(&mut self) {
        send(self.0.id(), libc::SIGTERM);
        let _ = self.0.wait();
    }
}

/// The rig and the object of a scenario with one camera.
fn files(scenario: &Scenario) -> (Rig, ObjectModel) {
    let seen = &scenario.cameras[0];
    let id = CameraId::new(NAME).expect("an id");
    let pose = Some(seen.world_from_camera);
    let rig = Rig::new(vec![Camera::new(id, seen.resolution, seen.lens, pose)]);
    let object = &scenario.objects[0];
    let tags = object.tags.iter().map(|tag| {
        let id = TagId {
            family: tag.family,
            id: tag.id,
        };
        ObjectTag::new(id, tag.size, Some(tag.object_from_tag))
    });
    let id = ObjectId::new(&object.id).expect("an id");
    let object = ObjectModel::new(id, tags.collect()).expect("an object");
    (rig.expect("a rig"), object)
}

/// A still of the scenario as a video for the browser.
fn write_video(scenario: &Scenario, file: &Path) {
    let [width, height] = scenario.cameras[0].resolution;
    let mut grey = vec![0; (width * height) as usize];
    let mut renderer = Renderer::new(scenario, 0).expect("a scene");
    renderer.render(0, &mut grey).expect("an image");
    let mut video = fs::File::create(file).expect("the folder can be written");
    let colours = vec![128; grey.len() / 2];
    writeln!(video, "YUV4MPEG2 W{width} H{height} F30:1 Ip A1:1 C420jpeg").expect("room");
    for _ in 0..2 {
        let frame = [b"FRAME\n", &grey[..], &colours].concat();
        video.write_all(&frame).expect("room");
    }
}

/// The first message that is as wanted.
fn first<M: sextant_proto::Message>(messages: &Subscription, wanted: impl Fn(&M) -> bool) -> M {
    loop {
        let item = messages.recv_timeout(PATIENCE).expect("a message in time");
        let message: M = item.decode().expect("a message of the contract");
        if wanted(&message) {
            return message;
        }
    }
}

#[test]
fn a_browser_is_a_camera_of_the_site() {
    if needs::PHONE.is_skipped() {
        return;
    }
    let mut scenario = Scenario::demo(1, 1, 1);
    // Browsers learn from the bridge which families to look for.
    for tag in &mut scenario.objects[0].tags {
        tag.family = Family::Tag25h9;
    }
    let (rig, object) = files(&scenario);
    let site = FusedSite::start(&rig, &[object], "");
    let video = site.path("video.y4m");
    write_video(&scenario, &video);
    let config = site.path("viewer.toml");
    let address = format!("127.0.0.1:{}", free_port());
    let text = format!(
        "site = \"lab\"\nlisten = \"{address}\"\n[network]\nconnect = [\"{}\"]\n",
        site.connect
    );
    fs::write(&config, text).expect("the folder can be written");
    let camera = CameraId::new(NAME).expect("an id");
    let observations = site.listen(&site.keys.observations(&camera));
    let statuses = site.listen(&site.keys.camera_status(&camera));
    let previews = site.listen(&site.keys.preview(&camera));
    let poses = site.listen(&site.keys.all_poses());
    let mut bridge = sextant();
    let bridge = bridge.args(["viewer", "--config"]).arg(&config).spawn();
    let bridge = Bridge(bridge.expect("sextant starts"));
    let page = format!("http://{address}/");
    let film = video.to_string_lossy();
    run_page_checks(
        "camera.mjs",
        &[
            &page,
            &film,
            "--name",
            NAME,
            "--timeout",
            "60",
            "--seconds",
            "3",
        ],
    );

    let seen: Observations = first(&observations, |seen: &Observations| !seen.tags.is_empty());
    assert_eq!(seen.resolution, [640, 480]);
    assert!(
        matches!(
            seen.clock.source,
            ClockSource::Ntp | ClockSource::FreeRunning
        ),
        "{:?}",
        seen.clock
    );
    assert!(seen.tags.iter().all(|tag| !tag.poses.is_empty()));
    let status: CameraStatus = first(&statuses, |status: &CameraStatus| status.detected > 10);
    assert!(status.notices.is_empty(), "{:?}", status.notices);
    assert!(
        status.rate_hz > 1.0 && status.brightness > 10.0,
        "{status:?}"
    );
    let pose: ObjectPose = first(&poses, |pose: &ObjectPose| pose.state == State::Tracking);
    let truth = scenario.objects[0].world_from_object(0).translation.vector;
    let off = (0..3).map(|axis| (pose.position[axis] - truth[axis]).powi(2));
    let off_m = off.sum::<f64>().sqrt();
    assert!(off_m < 0.03, "{off_m} m");
    // No page of the site was open, so no picture left the browser, though its user allowed it.
    assert!(previews.try_recv().is_none());
    drop(bridge);
}

#[test]
fn a_link_of_a_protected_site_is_for_one_device() {
    if needs::PHONE.is_skipped() {
        return;
    }
    let mut site = LockedSite::start(Profile::Lab);
    site.change_members(&["add", NAME, "--role", "phone"]);
    site.restart();
    let video = site.path("video.y4m");
    write_video(&Scenario::demo(1, 1, 1), &video);
    let config = site.path("viewer.toml");
    let address = format!("127.0.0.1:{}", free_port());
    let text = format!(
        "site = \"lab\"\nnode = \"desk\"\nlisten = \"{address}\"\nfolder = \"kept\"\n[network]\n\
         connect = [\"{}\"]\n[security]\nprofile = \"lab\"\nkeys = \"authority/desk\"\n",
        site.connect
    );
    fs::write(&config, text).expect("the folder can be written");
    let shown = || {
        let mut program = sextant();
        program.args(["phone", "--json", "--config"]).arg(&config);
        let output = program.output().expect("sextant runs");
        let line: Value = serde_json::from_slice(&output.stdout).expect("a line of JSON");
        line
    };
    let link = shown();
    assert_eq!(link["used"], false);
    let url = link["url"].as_str().expect("a link");
    let tokens = site.keys_of("desk").join("page-tokens.toml");
    let tokens = fs::read_to_string(tokens).expect("tokens");
    let mut lines = tokens.lines();
    let operator = lines.find_map(|line| line.strip_prefix("operate = \""));
    let operator = operator.expect("a token").trim_end_matches('"');
    let mut bridge = sextant();
    let bridge = bridge.args(["viewer", "--config"]).arg(&config).spawn();
    let _bridge = Bridge(bridge.expect("sextant starts"));
    let deadline = Instant::now() + PATIENCE;
    while TcpStream::connect(&address).is_err() {
        assert!(Instant::now() < deadline, "the bridge does not come up");
        std::thread::sleep(Duration::from_millis(20));
    }
    let screen = site.open("screen");
    let camera = CameraId::new(NAME).expect("an id");
    let observations = screen
        .subscribe(
            &site.keys.observations(&camera),
            64,
            DropRule::Oldest,
            limits::MAX_PAYLOAD_BYTES,
        )
        .expect("a subscription");
    let film = video.to_string_lossy();
    run_page_checks("phone-link.mjs", &[url, &film, operator, "--timeout", "60"]);
    let _: Observations = first(&observations, |_| true);
    assert_eq!(shown()["used"], true);
}
