//! What is wrong with a site is named where people look: in the fusion node's status, on the page, in `sextant top`.
//!
//! The test stands in the place of the cameras: what they see is true, what the fusion node's files say is not.

#![allow(clippy::expect_used, reason = "a test ends by panicking")]

use nalgebra::{UnitQuaternion, Vector3};
use serde_json::Value;
use sextant_geometry::Pose;
use sextant_process::now_ns;
use sextant_proto::Observations;
use sextant_site_files::write_object;
use sextant_site_model::{ObjectModel, ObjectTag, Rig};
use sextant_test_needs as needs;
use std::net::TcpListener;
use std::process::Child;
use std::time::Duration;
use system_tests::{FusedSite, Scene, changed, run_page_checks, send, sextant};

const CAMERAS: usize = 4;

/// A site whose files are exact, as the fusion node knows: what contradicts them is a fault, no imperfection.
fn site() -> (FusedSite, Scene) {
    let scene = Scene::new(CAMERAS, &["box", "cube"]);
    let objects: Vec<ObjectModel> = scene
        .objects
        .iter()
        .cloned()
        .map(ObjectModel::exact)
        .collect();
    let site = FusedSite::start(&scene.rig.clone().exact(), &objects, "");
    (site, scene)
}

/// Lets the cameras see what is true, for so many seconds, each image when it is taken, since a fusion node asks itself
/// about clocks by its own time; `last` may change what they say at the end.
fn watch(site: &mut FusedSite, truth: &mut Scene, seconds: f64, last: impl Fn(&mut Observations)) {
    let images = (seconds * 30.0) as u64;
    let start_ns = now_ns();
    for image in 0..images {
        for camera in 0..CAMERAS {
            let at_ns = image * 33_333_333 + camera as u64 * 7_123_457;
            let mut seen = truth.observe(camera, at_ns as f64 * 1e-9, start_ns + at_ns);
            if image + 10 > images {
                last(&mut seen);
            }
            std::thread::sleep(Duration::from_nanos(
                (start_ns + at_ns).saturating_sub(now_ns()),
            ));
            site.publish(&seen);
        }
    }
}

fn as_seen(_: &mut Observations) {}

/// The object with its first tag changed.
fn with_first_tag(object: &ObjectModel, change: impl Fn(&mut ObjectTag)) -> ObjectModel {
    let mut tags = object.tags().to_vec();
    change(&mut tags[0]);
    changed(object.id().as_str(), tags)
}

/// Waits until faults and notices of the status say all of this.
fn await_findings(site: &FusedSite, words: &[&str]) {
    site.await_status(|status| {
        let faults = status.faults.iter().map(ToString::to_string);
        let notices = status.notices.iter().map(ToString::to_string);
        let findings: Vec<String> = faults.chain(notices).collect();
        let is_reported = |words: &&str| findings.iter().any(|one| one.contains(*words));
        words.iter().all(is_reported)
    });
}

/// The faults as `sextant top` tells them.
fn top(site: &FusedSite) -> Vec<String> {
    let output = site.run_command(&["top", "--once", "--json"]);
    assert!(
        output.status.success(),
        "{}",
        String::from_utf8_lossy(&output.stderr)
    );
    let line: Value = serde_json::from_slice(&output.stdout).expect("a line of JSON");
    let faults = line["faults"].as_array().expect("faults").iter();
    faults
        .map(|fault| fault["words"].as_str().expect("words").to_owned())
        .collect()
}

fn assert_all_shown(faults: &[String], words: &[&str]) {
    for words in words {
        assert!(
            faults.iter().any(|fault| fault.contains(words)),
            "{words}: {faults:?}"
        );
    }
}

/// A viewer bridge of the site. Dropping it ends it.
struct Viewer(Child, String);

impl Viewer {
    fn start(site: &FusedSite) -> Self {
        let listener = TcpListener::bind("127.0.0.1:0").expect("a free port");
        let listen = listener.local_addr().expect("an address");
        drop(listener);
        let config = site.path("viewer.toml");
        let text = format!(
            "site = \"lab\"\nlisten = \"{listen}\"\n[network]\nmode = \"client\"\nconnect = [\"{}\"]\n",
            site.connect
        );
        std::fs::write(&config, text).expect("the folder can be written");
        let mut command = sextant();
        let bridge = command.args(["viewer", "--config"]).arg(&config).spawn();
        Self(bridge.expect("sextant starts"), format!("http://{listen}"))
    }

    /// Fails unless the page tells all of these, and shows no object of this name.
    fn assert_shown(&self, words: &[&str], gone: &str) {
        let arguments = [&[self.1.as_str(), "--gone", gone], words].concat();
        run_page_checks("faults.mjs", &arguments);
    }
}

impl Drop for Viewer {
    fn drop(&mut self) {
        send(self.0.id(), libc::SIGTERM);
        let _ = self.0.wait();
    }
}

#[test]
fn wrong_tags_are_named_in_the_status_on_the_page_and_in_top() {
    if needs::FAULTS.is_skipped() {
        return;
    }
    let (mut site, mut truth) = site();
    let viewer = Viewer::start(&site);
    let slipped = |tag: &mut ObjectTag| {
        tag.object_from_tag = tag
            .object_from_tag
            .map(|pose| pose * Pose::translation(0.005, 0.0, 0.0));
    };
    truth.objects[0] = with_first_tag(&truth.objects[0], slipped);
    truth.objects[1] = with_first_tag(&truth.objects[1], |tag| tag.size_m *= 1.02);
    // The same tag once more, somewhere else in the image.
    watch(&mut site, &mut truth, 5.0, |image| {
        let twin = image.tags.last().cloned().map(|mut tag| {
            tag.corners.iter_mut().for_each(|corner| corner[1] += 60.0);
            tag
        });
        image.tags.extend(twin);
    });
    // An object that claims the tags of another.
    let file = site.path("twin.toml");
    write_object(&file, &changed("twin", truth.objects[1].tags().to_vec()))
        .expect("it can be written");
    let refused = site.run_command(&["config", "set", "object", &file.display().to_string()]);
    assert_eq!(refused.status.code(), Some(1));
    let words = [
        "tag tag36h11:0 of object box is loose or not where the model says",
        "tag tag36h11:6 of object cube is ",
        "twice",
        "tag tag36h11:6 is on object cube and on object twin",
    ];
    await_findings(&site, &words);
    assert_all_shown(&top(&site), &words);
    viewer.assert_shown(&words, "twin");
}

#[test]
fn a_bumped_camera_is_named() {
    let (mut site, mut truth) = site();
    let mut cameras = truth.rig.cameras().to_vec();
    let degree = UnitQuaternion::from_scaled_axis(Vector3::y() * 1_f64.to_radians());
    let bumped = &mut cameras[2].world_from_camera;
    *bumped = bumped.map(|pose| pose * Pose::from_parts(Vector3::zeros().into(), degree));
    truth.rig = Rig::new(cameras).expect("a rig");
    watch(&mut site, &mut truth, 4.0, as_seen);
    let words = ["camera cam2 is not where the rig says"];
    await_findings(&site, &words);
    assert_all_shown(&top(&site), &words);
}

#[test]
fn a_clock_that_is_off_is_named_with_its_offset() {
    let (mut site, mut truth) = site();
    truth.clock_offsets_s[3] = 0.02;
    watch(&mut site, &mut truth, 6.0, as_seen);
    let words = ["the clock of camera cam3 is off by +"];
    await_findings(&site, &words);
    assert_all_shown(&top(&site), &words);
    let output = site.run_command(&["top", "--once", "--json"]);
    let line: Value = serde_json::from_slice(&output.stdout).expect("a line of JSON");
    let offset_ms = line["cameras"][3]["clock"]["offset_ms"]
        .as_f64()
        .expect("an offset");
    assert!((offset_ms - 20.0).abs() < 1.0, "{line}");
}
