//! Rig and objects change while a site runs: each change is taken whole or refused whole, and what it does not name
//! goes on.

#![allow(clippy::expect_used, reason = "a test ends by panicking")]

use sextant_process::now_ns;
use sextant_proto::{Notice, ObjectConfig, ObjectPose, RigConfig, limits};
use sextant_site_files::{object_toml, rig_toml, write_object, write_rig};
use sextant_site_model::{Exposure, LensSigma, ObjectModel, PoseSigma, Prior, Rig, Stamp};
use sextant_site_report::State;
use sextant_zenoh_bus::Subscription;
use std::collections::BTreeMap;
use std::process::Output;
use std::time::{Duration, Instant};
use system_tests::{FusedSite, PATIENCE, Scene, changed};

struct WatchedSite {
    site: FusedSite,
    scene: Scene,
    poses: Subscription,
}

impl WatchedSite {
    /// A site of two cubes, both tracked.
    fn start(more: &str) -> Self {
        let scene = Scene::new(3, &["box", "cube", "ball"]);
        let site = FusedSite::start(&scene.rig, &scene.objects[..2], more);
        let poses = site.listen(&site.keys.all_poses());
        let mut watched = Self { site, scene, poses };
        watched.until("both are tracked", |states| {
            states.len() == 2 && states.values().all(|state| *state == State::Tracking)
        });
        watched
    }

    /// Lets the cameras see until the last states of all objects are as wanted; the states on the way of each object.
    fn until(
        &mut self,
        what: &str,
        wanted: impl Fn(&BTreeMap<String, State>) -> bool,
    ) -> BTreeMap<String, Vec<State>> {
        let (mut last, mut all) = (BTreeMap::new(), BTreeMap::<String, Vec<State>>::new());
        let deadline = Instant::now() + PATIENCE;
        while !wanted(&last) {
            assert!(Instant::now() < deadline, "never: {what}; {last:?}");
            for camera in 0..3 {
                let image = self.scene.observe(camera, 0.0, now_ns());
                self.site.publish(&image);
            }
            while let Some(item) = self.poses.recv_timeout(Duration::from_millis(5)) {
                let pose: ObjectPose = item.decode().expect("a pose");
                last.insert(pose.object.to_string(), pose.state);
                all.entry(pose.object.to_string())
                    .or_default()
                    .push(pose.state);
            }
        }
        all
    }

    /// `sextant config set object` with these tags of the scene's object, under this name.
    fn set(&self, name: &str, tags: &ObjectModel) -> Output {
        let file = self.site.path("change.toml");
        let object = changed(name, tags.tags().to_vec());
        write_object(&file, &object).expect("the folder can be written");
        let file = file.display().to_string();
        self.site.run_command(&["config", "set", "object", &file])
    }

    fn objects(&self) -> Vec<ObjectConfig> {
        let key = self.site.keys.all_config_objects();
        let found = self
            .site
            .bus
            .latest(&key, limits::MAX_PAYLOAD_BYTES, Duration::from_secs(1));
        let found = found.expect("the network answers");
        found
            .iter()
            .map(|item| item.decode().expect("an object"))
            .collect()
    }
}

fn said(output: &Output) -> String {
    String::from_utf8_lossy(&[&output.stdout[..], &output.stderr[..]].concat()).into_owned()
}

#[test]
fn objects_come_change_and_go_and_the_others_go_on() {
    let mut watched = WatchedSite::start("");
    let ball = watched.scene.objects[2].clone();
    let output = watched.set("ball", &ball);
    assert!(output.status.success(), "{}", said(&output));
    assert!(
        said(&output).contains("config/object/ball taken until the node ends"),
        "{}",
        said(&output)
    );
    let states = watched.until("the new one is tracked", |states| {
        states.get("ball") == Some(&State::Tracking)
    });
    // While the commands ran no camera saw anything: an object may have coasted, but none began anew.
    assert!(!states["box"].contains(&State::Initialising), "{states:?}");

    let removed = watched
        .site
        .run_command(&["config", "remove", "object", "ball", "--json"]);
    assert!(removed.status.success(), "{}", said(&removed));
    assert!(
        said(&removed).contains("\"outcome\":\"taken\""),
        "{}",
        said(&removed)
    );
    let status = watched
        .site
        .await_status(|status| status.objects.len() == 2);
    assert_eq!((status.faults, status.notices), (vec![], vec![]));
    assert_eq!(watched.objects().len(), 2);
    let again = watched
        .site
        .run_command(&["config", "remove", "object", "ball"]);
    assert_eq!(again.status.code(), Some(1));
    assert!(
        said(&again).contains("no object ball on site lab; it has: box, cube"),
        "{}",
        said(&again)
    );
}

#[test]
fn a_refused_change_leaves_everything_as_it_was_and_is_named() {
    let mut watched = WatchedSite::start("");
    let before = watched.objects();
    let configs = watched.site.listen(&watched.site.keys.all_config_objects());
    // The tags of the cube, claimed by another object.
    let cube = watched.scene.objects[1].clone();
    let refused = watched.set("twin", &cube);
    assert_eq!(refused.status.code(), Some(1), "{}", said(&refused));
    let cause = "tag tag36h11:6 is on object cube and on object twin";
    assert!(said(&refused).contains(cause), "{}", said(&refused));
    let status = watched
        .site
        .await_status(|status| !status.notices.is_empty());
    let [Notice::ChangeRefused { key, refusal, .. }] = &status.notices[..] else {
        panic!("{:?}", status.notices);
    };
    assert_eq!(key, "config/object/twin");
    assert!(refusal.to_string().contains(cause), "{refusal}");
    assert_eq!(watched.objects(), before);
    // Clients that saw the twin hear that there is none.
    let heard: Vec<ObjectConfig> =
        std::iter::from_fn(|| configs.try_recv()?.decode().ok()).collect();
    assert_eq!(
        heard
            .last()
            .map(|config| (config.id.as_str(), config.tags.len())),
        Some(("twin", 0))
    );
    let states = watched.until("both go on", |states| states.len() == 2);
    assert!(
        !states
            .values()
            .flatten()
            .any(|state| *state == State::Initialising),
        "{states:?}"
    );

    let file = watched.site.path("wrong.toml");
    std::fs::write(&file, "id = \"cube\"\n").expect("the folder can be written");
    let wrong = watched
        .site
        .run_command(&["config", "set", "object", &file.display().to_string()]);
    assert_eq!(wrong.status.code(), Some(3), "{}", said(&wrong));
}

#[test]
fn kept_changes_survive_a_restart() {
    let mut watched = WatchedSite::start("keep_changes = true");
    let ball = watched.scene.objects[2].clone();
    let output = watched.set("ball", &ball);
    assert!(
        said(&output).contains("taken and kept in its files"),
        "{}",
        said(&output)
    );
    let rig_file = watched.site.path("new-rig.toml");
    let cameras = watched.scene.rig.cameras()[..2].to_vec();
    let rig = Rig::new(cameras).expect("a rig");
    write_rig(&rig_file, &rig).expect("the folder can be written");
    let rig_file = rig_file.display().to_string();
    let output = watched
        .site
        .run_command(&["config", "set", "rig", &rig_file]);
    assert!(output.status.success(), "{}", said(&output));
    let states = watched.until("all are seen by two cameras", |states| states.len() == 3);
    assert!(!states["cube"].contains(&State::Initialising), "{states:?}");

    let former = std::fs::read_to_string(watched.site.path("rig.toml.former")).expect("it is kept");
    assert!(former.contains("cam2"));
    let WatchedSite { site, poses, .. } = watched;
    drop(poses);
    let site = site.restarted();
    let status = site.await_status(|_| true);
    assert_eq!(
        (status.cameras.len(), status.objects.len()),
        (2, 3),
        "{status:?}"
    );
    let printed = site.run_command(&["config", "get", "rig"]);
    assert_eq!(said(&printed).trim(), rig_toml(&rig).trim());
    let found = site
        .bus
        .latest(&site.keys.config_rig(), limits::MAX_PAYLOAD_BYTES, PATIENCE);
    let found: RigConfig = found.expect("an answer")[0].decode().expect("a rig");
    assert_eq!(found, RigConfig::from(&rig));
}

/// Standard deviations, line delays and exposures are set, printed and kept.
#[test]
fn everything_in_the_files_travels_and_stays() {
    let watched = WatchedSite::start("keep_changes = true");
    let (rig, object) = stated(&watched.scene);
    let files = ["new-rig.toml", "new-cube.toml"].map(|name| watched.site.path(name));
    write_rig(&files[0], &rig).expect("the folder can be written");
    write_object(&files[1], &object).expect("the folder can be written");
    let [rig_file, object_file] = files.map(|file| file.display().to_string());
    let command = |words: &[&str]| {
        let output = watched.site.run_command(words);
        assert!(output.status.success(), "{}", said(&output));
        said(&output).trim().to_owned()
    };
    assert!(command(&["config", "set", "rig", &rig_file]).contains("config/rig taken"));
    command(&["config", "set", "object", &object_file]);
    let texts = [rig_toml(&rig), object_toml(&object)].map(|text| text.trim().to_owned());
    let got = |site: &FusedSite| {
        ["rig", "object cube"].map(|what| {
            let words = ["config", "get"].into_iter().chain(what.split(' '));
            let output = site.run_command(&words.collect::<Vec<_>>());
            said(&output).trim().to_owned()
        })
    };
    assert_eq!(got(&watched.site), texts);
    let WatchedSite { site, poses, .. } = watched;
    drop(poses);
    let site = site.restarted();
    assert_eq!(got(&site), texts);
}

/// The scene's cameras and its cube with everything that files can say of them.
fn stated(scene: &Scene) -> (Rig, ObjectModel) {
    let pose_prior = Prior::Sigma(PoseSigma {
        position_m: 0.0005,
        orientation_rad: 0.00025,
    });
    let mut cameras = scene.rig.cameras().to_vec();
    for camera in &mut cameras {
        camera.pose_prior = pose_prior;
        camera.lens_prior = Prior::Sigma(LensSigma {
            focal_px: 0.25,
            distortion_px: 0.125,
        });
        camera.line_delay_s = Some(2e-5);
        camera.exposure = Some(Exposure {
            length_s: 0.004,
            stamp: Stamp::End,
        });
    }
    let cube = &scene.objects[1];
    let mut tags = cube.tags().to_vec();
    tags[0].pose_prior = pose_prior;
    tags[0].size_prior = Prior::Sigma(0.0002);
    let rig = Rig::new(cameras).expect("a rig");
    (rig, changed(cube.id().as_str(), tags))
}

/// An arm of two links.
const ARM: &str = r#"id = "arm"
[[link]]
id = "upper"
[[link]]
id = "lower"
[[joint]]
id = "elbow"
kind = "revolute"
parent = "upper"
child = "lower"
axis = [0.0, 0.0, 1.0]
[[tag]]
family = "tag36h11"
id = 200
size = 0.04
link = "upper"
link_from_tag = { position = [0, 0, 0], orientation = [0, 0, 0, 1] }
[[tag]]
family = "tag36h11"
id = 201
size = 0.04
link = "lower"
link_from_tag = { position = [0, 0, 0], orientation = [0, 0, 0, 1] }
"#;

#[test]
fn an_object_of_links_comes_is_said_and_goes() {
    let watched = WatchedSite::start("");
    let file = watched.site.path("arm.toml");
    std::fs::write(&file, ARM).expect("the folder can be written");
    let file = file.display().to_string();
    let command = |words: &[&str]| watched.site.run_command(words);
    let set = command(&["config", "set", "object", &file]);
    assert!(set.status.success(), "{}", said(&set));
    let taken = "config/object/arm taken until the node ends";
    assert!(said(&set).contains(taken), "{}", said(&set));
    let again = command(&["config", "set", "object", &file, "--json"]);
    assert!(
        said(&again).contains("\"outcome\":\"same\""),
        "{}",
        said(&again)
    );
    let got = command(&["config", "get", "object", "arm"]);
    assert!(said(&got).contains("[[joint]]"), "{}", said(&got));
    let removed = command(&["config", "remove", "object", "arm"]);
    assert!(removed.status.success(), "{}", said(&removed));
    let nobody = command(&["config", "get", "object", "arm"]);
    assert_eq!(nobody.status.code(), Some(1), "{}", said(&nobody));
    watched.site.await_status(|status| {
        status
            .objects
            .iter()
            .all(|one| one.object.as_str() != "arm")
    });
}
