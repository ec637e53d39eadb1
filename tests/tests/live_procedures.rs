//! Calibration and learning against a running site: images come while the command looks, it says what to do next, ends
//! by itself or by Ctrl-C, and writes the file whole.

#![allow(clippy::expect_used, reason = "a test ends by panicking")]

use nalgebra::{UnitQuaternion, Vector3};
use serde_json::Value;
use sextant_geometry::{Pose, se3};
use sextant_site_files::{read_object, read_rig, write_object, write_rig};
use sextant_site_model::{ObjectModel, Rig};
use std::fs::{self, File};
use std::path::PathBuf;
use std::process::{Child, ExitStatus};
use std::time::{Duration, Instant};
use system_tests::{FusedSite, PATIENCE, Scene, send, sextant};

/// A site whose cameras see one box, and a command that follows it.
struct FollowedSite {
    site: FusedSite,
    scene: Scene,
    box_: ObjectModel,
    step: u32,
}

/// A command that runs, its words in files. Dropping it ends it.
struct Running {
    child: Child,
    said: PathBuf,
    complained: PathBuf,
}

impl FollowedSite {
    fn start() -> Self {
        let scene = Scene::new(3, &["box"]);
        let site = FusedSite::start(&scene.rig, &scene.objects, "");
        write_rig(&site.path("lenses.toml"), &without_places(&scene.rig)).expect("a file");
        write_object(&site.path("known.toml"), &scene.objects[0]).expect("a file");
        Self {
            box_: scene.objects[0].clone(),
            site,
            scene,
            step: 0,
        }
    }

    fn run(&self, line: &str) -> Running {
        let (said, complained) = (self.site.path("said"), self.site.path("complained"));
        let child = sextant()
            .current_dir(self.site.path(""))
            .args(line.split_whitespace())
            .args(["--live", "--site", "lab", "--connect", &self.site.connect])
            .stdout(File::create(&said).expect("a file"))
            .stderr(File::create(&complained).expect("a file"))
            .spawn()
            .expect("sextant starts");
        Running {
            child,
            said,
            complained,
        }
    }

    /// All cameras take one image; the object is where `way` has it.
    fn shoot(&mut self, way: impl Fn(f64) -> Pose) {
        let seconds = f64::from(self.step) * 0.05;
        let time_ns = 1_700_000_000_000_000_000 + u64::from(self.step) * 50_000_000;
        for camera in 0..self.scene.rig.cameras().len() {
            let pose = way(seconds);
            let image = self.scene.see(camera, &[(&self.box_, pose)], time_ns);
            self.site.publish(&image);
        }
        self.step += 1;
    }

    /// Lets the cameras see until the command has ended.
    fn until_end(&mut self, running: &mut Running, way: impl Fn(f64) -> Pose) -> ExitStatus {
        let deadline = Instant::now() + PATIENCE;
        let pace = self.site.listen(&self.site.keys.all_poses());
        loop {
            if let Some(status) = running.child.try_wait().expect("a child") {
                return status;
            }
            assert!(Instant::now() < deadline, "never ends: {}", running.words());
            self.shoot(&way);
            let _ = pace.recv_timeout(Duration::from_millis(5));
        }
    }
}

impl Running {
    fn words(&self) -> String {
        let read = |file| fs::read_to_string(file).unwrap_or_default();
        read(&self.said) + &read(&self.complained)
    }
}

impl Drop for Running {
    fn drop(&mut self) {
        if matches!(self.child.try_wait(), Ok(None)) {
            send(self.child.id(), libc::SIGKILL);
            let _ = self.child.wait();
        }
    }
}

fn without_places(rig: &Rig) -> Rig {
    let mut cameras = rig.cameras().to_vec();
    cameras.iter_mut().for_each(|c| c.world_from_camera = None);
    Rig::new(cameras).expect("a rig")
}

/// Carried about, turned to everyone.
fn carried(seconds: f64) -> Pose {
    let wave = |rate: f64, phase: f64| (rate * seconds + phase).sin();
    let at = Vector3::new(
        0.34 * wave(1.3, 0.0),
        0.34 * wave(1.7, 1.0),
        0.25 * wave(1.1, 2.0),
    );
    let turn = Vector3::new(0.7 * wave(1.9, 0.0), 0.7 * wave(1.5, 0.5), 1.1 * seconds);
    Pose::from_parts(at.into(), UnitQuaternion::from_scaled_axis(turn))
}

/// Turned in the hand, every side up in its turn.
fn turned(seconds: f64) -> Pose {
    let turn = UnitQuaternion::from_euler_angles(
        0.9 * seconds,
        0.5 * (0.7 * seconds).sin(),
        0.31 * seconds,
    );
    let at = Vector3::new(0.03 * (1.3 * seconds).sin(), 0.0, 0.0);
    Pose::from_parts(at.into(), turn)
}

#[test]
fn an_object_turned_before_the_cameras_is_discovered_and_learned() {
    let mut followed = FollowedSite::start();
    fs::write(followed.site.path("found.toml"), "former").expect("a file");
    let mut running =
        followed.run("learn --rig rig.toml --size 0.04 --id box --origin tag:0 --out found.toml");
    let status = followed.until_end(&mut running, turned);
    let words = running.words();
    assert!(status.success(), "{words}");
    assert!(
        words.contains("found to move as one: tag36h11:0, tag36h11:1"),
        "{words}"
    );
    assert!(
        words.contains("sextant config set object found.toml --site lab"),
        "{words}"
    );
    let found = read_object(&followed.site.path("found.toml")).expect("an object");
    let place = |model: &ObjectModel, at: usize| {
        let tags = model.tags();
        let pose = |at: usize| tags[at].object_from_tag.expect("a place");
        pose(0).inverse() * pose(at)
    };
    for at in 1..6 {
        let error = se3::difference(&place(&found, at), &place(&followed.box_, at));
        assert!(error.fixed_rows::<3>(0).norm() < 1e-3, "{at}: {error}");
    }
    let former = fs::read_to_string(followed.site.path("found.toml.former")).expect("kept");
    assert_eq!(former, "former");
}

#[test]
fn cameras_are_placed_while_an_object_is_carried() {
    let mut followed = FollowedSite::start();
    let mut running = followed.run("calibrate rig --rig lenses.toml --object known.toml --json");
    let status = followed.until_end(&mut running, carried);
    let words = running.words();
    assert!(status.success(), "{words}");
    let lines: Vec<Value> = fs::read_to_string(&running.said)
        .expect("lines")
        .lines()
        .map(|line| serde_json::from_str(line).expect("JSON"))
        .collect();
    assert_eq!(lines[0]["kind"], "rig", "{words}");
    assert!(
        lines[0]["hint"]
            .as_str()
            .is_some_and(|hint| !hint.is_empty())
    );
    assert!(
        lines[lines.len() - 1]["verdict"]["grade"].is_string(),
        "{words}"
    );
    let found = read_rig(&followed.site.path("lenses.toml")).expect("a rig");
    let place = |rig: &Rig, at: usize| {
        let pose = |at: usize| rig.cameras()[at].world_from_camera.expect("a place");
        pose(0).inverse() * pose(at)
    };
    for at in 1..3 {
        let error = se3::difference(&place(&found, at), &place(&followed.scene.rig, at));
        assert!(error.fixed_rows::<3>(0).norm() < 4e-3, "{at}: {error}");
    }
}

#[test]
fn ctrl_c_before_there_is_enough_says_what_is_missing_and_writes_nothing() {
    let mut followed = FollowedSite::start();
    let mut running = followed
        .run("learn --rig rig.toml --tags 0,1,99 --size 0.04 --id box --out found.toml --strict");
    let deadline = Instant::now() + PATIENCE;
    while !running.words().contains("tag36h11:99 comes into view") {
        assert!(Instant::now() < deadline, "no hint: {}", running.words());
        followed.shoot(turned);
        assert!(
            running.child.try_wait().expect("a child").is_none(),
            "{}",
            running.words()
        );
    }
    send(running.child.id(), libc::SIGINT);
    let status = followed.until_end(&mut running, turned);
    assert_eq!(status.code(), Some(3), "{}", running.words());
    assert!(
        running.words().contains("no image shows tag36h11:99"),
        "{}",
        running.words()
    );
    assert!(!followed.site.path("found.toml").exists());
}

#[test]
fn ctrl_c_before_any_image_of_use_is_an_interruption() {
    let mut followed = FollowedSite::start();
    let mut cameras = followed.scene.rig.cameras()[..1].to_vec();
    cameras[0].id = "other".parse().expect("an id");
    write_rig(
        &followed.site.path("other.toml"),
        &Rig::new(cameras).expect("a rig"),
    )
    .expect("a file");
    let mut running = followed.run("calibrate rig --rig other.toml --object known.toml");
    let deadline = Instant::now() + PATIENCE;
    while !running
        .words()
        .contains("camera cam0 is not in the rig file")
    {
        assert!(Instant::now() < deadline, "no remark: {}", running.words());
        followed.shoot(carried);
        assert!(
            running.child.try_wait().expect("a child").is_none(),
            "{}",
            running.words()
        );
    }
    send(running.child.id(), libc::SIGINT);
    let status = followed.until_end(&mut running, carried);
    assert_eq!(status.code(), Some(130), "{}", running.words());
}
