//! Exposure, gain and rate of a camera from the site: given before the camera starts and while it runs, refused, kept,
//! removed.

#![allow(clippy::expect_used, reason = "a test ends by panicking")]

use sextant_proto::{CameraSettings, CameraStatus, SettingsOutcome, limits};
use sextant_simulator::Scenario;
use sextant_zenoh_bus::Qos;
use std::process::{Child, Output};
use std::time::{Duration, Instant};
use system_tests::{FusedSite, PATIENCE, Scene, sextant};

const CAMERA: &str = "cam0";

/// A camera node on the simulator; dropping it ends it.
struct CameraNode(Child);

impl CameraNode {
    /// Starts it; its own file says nothing of exposure, gain and rate.
    fn start(site: &FusedSite) -> Self {
        let mut scenario = Scenario::demo(1, 1, 1);
        scenario.cameras[0].id = CAMERA.to_owned();
        sextant_site_files::write_toml(&site.path("scenario.toml"), &scenario).expect("a file");
        let text = format!(
            "site = \"lab\"\ncamera = \"{CAMERA}\"\n[source]\nkind = \"simulator\"\n\
             scenario = \"scenario.toml\"\n[network]\nconnect = [\"{}\"]\n[shared_memory]\nroot = \"i\"\n",
            site.connect
        );
        let file = site.path("camera.toml");
        std::fs::write(&file, text).expect("a file");
        let mut command = sextant();
        command.args(["camera", "--config"]).arg(file);
        Self(command.spawn().expect("sextant starts"))
    }
}

impl Drop for CameraNode {
    fn drop(&mut self) {
        system_tests::send(self.0.id(), libc::SIGTERM);
        let _ = self.0.wait();
    }
}

/// The first status that is as wanted.
fn await_status(site: &FusedSite, wanted: impl Fn(&CameraStatus) -> bool) -> CameraStatus {
    let statuses = site.listen(&site.keys.all_camera_statuses());
    let deadline = Instant::now() + PATIENCE;
    let mut last = None;
    while Instant::now() < deadline {
        let item = statuses.recv_timeout(Duration::from_millis(200));
        let status = item.and_then(|item| item.decode::<CameraStatus>().ok());
        match status {
            Some(status) if wanted(&status) => return status,
            Some(status) => last = Some(status),
            None => {}
        }
    }
    panic!("no such status; the last one: {last:?}");
}

fn is_applied(status: &CameraStatus, wanted: [Option<f64>; 3]) -> bool {
    let controls = &status.controls;
    controls.wanted() == wanted && controls.outcome == SettingsOutcome::Applied
}

fn set(site: &FusedSite, arguments: &[&str]) -> Output {
    site.run_command(&[&["config", "set", "camera", CAMERA], arguments].concat())
}

fn said(output: &Output) -> String {
    String::from_utf8_lossy(&[&output.stdout[..], &output.stderr[..]].concat()).into_owned()
}

/// Puts settings on the network before there is a camera, and waits until the site has them.
fn give_early(site: &FusedSite, settings: &CameraSettings) {
    let key = site.keys.config_camera(&settings.camera);
    let publisher = site.bus.publisher(&key, Qos::Config).expect("a publisher");
    publisher.put(settings).expect("the network takes it");
    let deadline = Instant::now() + PATIENCE;
    let ask = || {
        let wait = Duration::from_secs(1);
        site.bus.latest(&key, limits::MAX_PAYLOAD_BYTES, wait)
    };
    while ask().expect("a question").is_empty() {
        assert!(Instant::now() < deadline, "the site has no settings");
    }
}

#[test]
fn settings_reach_a_camera_before_and_while_it_runs_and_outlive_the_fusion_node() {
    let scene = Scene::new(1, &["cube"]);
    let site = FusedSite::start(&scene.rig, &scene.objects, "keep_changes = true");
    let early = CameraSettings {
        exposure_us: Some(2000.0),
        ..CameraSettings::none(CAMERA.parse().expect("an id"))
    };
    give_early(&site, &early);
    let camera = CameraNode::start(&site);
    let dark = await_status(&site, |status| {
        is_applied(status, early.values()) && status.brightness > 0.0
    });
    assert_eq!(dark.controls.exposure_us.value, Some(2000.0));

    let output = set(&site, &["--gain", "3", "--rate", "20", "--json"]);
    assert!(output.status.success(), "{}", said(&output));
    let words = said(&output);
    assert!(words.contains("\"outcome\":\"kept\""), "{words}");
    assert!(words.contains("\"outcome\":\"applied\""), "{words}");
    let wanted = [Some(2000.0), Some(3.0), Some(20.0)];
    await_status(&site, |status| {
        is_applied(status, wanted) && status.brightness > 1.5 * dark.brightness
    });

    let refused = set(&site, &["--exposure", "200ms"]);
    assert_eq!(refused.status.code(), Some(1));
    let words = said(&refused);
    assert!(words.contains("keeps what it had"), "{words}");
    assert!(words.contains("choose at most 50 ms"), "{words}");
    let status = await_status(&site, |_| true);
    assert_eq!(status.controls.exposure_us.value, Some(2000.0));
    let misspelt = set(&site, &["--exposure", "4"]);
    assert_eq!(misspelt.status.code(), Some(2));
    assert!(said(&misspelt).contains("such as 4ms"));
    let mended = set(&site, &["--exposure", "2ms"]);
    assert!(mended.status.success(), "{}", said(&mended));

    let site = site.restarted();
    await_status(&site, |status| is_applied(status, wanted));
    drop(camera);
    let _camera = CameraNode::start(&site);
    await_status(&site, |status| is_applied(status, wanted));
    let shown = site.run_command(&["config", "get", "camera", CAMERA]);
    assert!(said(&shown).contains("set by the site"), "{}", said(&shown));

    let removed = set(
        &site,
        &["--exposure", "file", "--gain", "file", "--rate", "file"],
    );
    assert!(removed.status.success(), "{}", said(&removed));
    let own = await_status(&site, |status| {
        status.controls.outcome == SettingsOutcome::None
    });
    assert_ne!(own.controls.exposure_us.value, Some(2000.0));
    let file = std::fs::read_to_string(site.path("cameras.toml")).expect("a file");
    assert!(!file.contains(CAMERA), "{file}");
}
