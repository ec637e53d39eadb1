//! `sextant-client` as a program of somebody else uses it: its examples against a demo, its answers against the truth,
//! and what it says when names, routers and keys are wrong or the site goes away.

#![allow(clippy::expect_used, reason = "a test ends by panicking")]

use nalgebra::Matrix6;
use sextant_client::{Error, Messages, Pose, Site};
use sextant_evaluation::PoseError;
use sextant_process::now_ns;
use sextant_proto::State;
use sextant_zenoh_bus::Profile;
use std::path::Path;
use std::time::Duration;
use system_tests::{
    Demo, FusedSite, LockedSite, PATIENCE, Scene, client_example, free_port, place, workspace_root,
};

const OBJECTS: [&str; 2] = ["box", "cube"];
const CAMERAS: usize = 3;
/// Between the images of a camera, ns.
const PERIOD_NS: u64 = 33_333_333;
/// A moment for what cannot come.
const MOMENT: Duration = Duration::from_millis(300);
/// Chi-square of six degrees of freedom that one sample in ten thousand exceeds.
const NEES_LIMIT: f64 = 27.9;

#[test]
fn every_example_runs_against_a_demo() {
    let demo = Demo::start(&["--cameras", "2"]);
    for (example, arguments, lines) in [
        ("list", &[][..], 6),
        ("poses", &["cuboid"], 10),
        ("stream", &["cuboid"], 10),
        ("relative", &["cuboid", "prism"], 2),
    ] {
        let mut command = client_example(example);
        command.args(arguments).arg(&demo.connect);
        let output = command.output().expect("the example runs");
        assert!(output.status.success(), "{example}: {output:?}");
        let text = String::from_utf8_lossy(&output.stdout);
        assert!(text.lines().count() >= lines, "{example}: {text}");
    }
}

/// The guide's blocks are compiled (Rust) and run (Python); the README shows the first of each.
#[test]
fn the_readme_shows_what_the_guide_shows() {
    let read = |name| std::fs::read_to_string(workspace_root().join(name)).expect("a page");
    let (readme, guide) = (read("README.md"), read("docs/subscribe.md"));
    let blocks: Vec<&str> = readme.split("```").skip(1).step_by(2).collect();
    assert_eq!(blocks.len(), 2, "{blocks:?}");
    for block in blocks {
        assert!(guide.contains(block), "not in the guide:{block}");
    }
}

fn connect(site: &FusedSite) -> Site {
    Site::connect(&site.connect, "lab").expect("a router")
}

/// A site with two objects, and its images from a start on.
struct Moving {
    site: FusedSite,
    scene: Scene,
    /// What the site says to the images, which keeps the next ones waiting.
    poses: Messages<Pose>,
    start_ns: u64,
    next: u64,
}

impl Moving {
    fn start() -> Self {
        let scene = Scene::new(CAMERAS, &OBJECTS);
        Self::new(FusedSite::start(&scene.rig, &scene.objects, ""), scene)
    }

    fn new(site: FusedSite, scene: Scene) -> Self {
        Self {
            poses: connect(&site).all_poses().expect("a subscription"),
            site,
            scene,
            start_ns: now_ns(),
            next: 0,
        }
    }

    fn image(&mut self) {
        let at_ns = self.next * PERIOD_NS;
        for camera in 0..CAMERAS {
            let seen = self
                .scene
                .observe(camera, at_ns as f64 * 1e-9, self.start_ns + at_ns);
            self.site.publish(&seen);
        }
        self.next += 1;
        let is_answer = |pose: &Pose| pose.t_ns >= self.start_ns + at_ns;
        let mut answers = std::iter::from_fn(|| self.poses.next_within(MOMENT));
        answers.find(is_answer);
    }

    /// Publishes images until there is an answer.
    fn until<T>(&mut self, mut answer: impl FnMut() -> Option<T>) -> T {
        for _ in 0..3000 {
            if let Some(answer) = answer() {
                return answer;
            }
            self.image();
        }
        panic!("no answer to so many images");
    }

    fn truth(&self, index: usize, t_ns: u64) -> sextant_geometry::Pose {
        place(index, (t_ns - self.start_ns) as f64 * 1e-9)
    }
}

fn nees(
    estimate: &sextant_geometry::Pose,
    truth: &sextant_geometry::Pose,
    covariance: &Matrix6<f64>,
) -> f64 {
    let error = PoseError::between(estimate, truth);
    error.nees(covariance).expect("a covariance")
}

#[test]
fn poses_at_any_time_and_between_objects_are_true_within_their_covariance() {
    let mut moving = Moving::start();
    let client = connect(&moving.site);
    let settled = |pose: &Pose| pose.state == State::Tracking;
    let newest = moving.until(|| client.pose("box", Duration::ZERO).ok().filter(settled));
    let other = moving.until(|| client.pose("cube", Duration::ZERO).ok().filter(settled));
    let begin_ns = newest.t_ns.max(other.t_ns);
    moving.until(|| {
        client
            .pose_at("cube", begin_ns + 60 * PERIOD_NS, Duration::ZERO)
            .ok()
    });
    // Not a multiple of the cameras' period, so that each time has another place between two poses.
    for t_ns in (begin_ns..begin_ns + 58 * PERIOD_NS).step_by(41_000_001) {
        let pose = client.pose_at("box", t_ns, PATIENCE).expect("a pose");
        let truth = moving.truth(0, t_ns);
        let off = nees(&pose.world_from_object(), &truth, &pose.covariance);
        assert!(off < NEES_LIMIT, "{off} at {t_ns}");
        let relative = client
            .transform_at("box", "cube", t_ns, PATIENCE)
            .expect("a transform");
        let truth = truth.inv_mul(&moving.truth(1, t_ns));
        let off = nees(&relative.a_from_b(), &truth, &relative.covariance);
        assert!(off < NEES_LIMIT, "{off} at {t_ns}");
    }
    let early = client.pose_at("box", moving.start_ns - 1, Duration::ZERO);
    assert!(
        matches!(
            early,
            Err(Error::NotCovered {
                covered_ns: Some(_),
                ..
            })
        ),
        "{early:?}"
    );
}

#[test]
fn what_does_not_exist_is_named_with_what_does() {
    let scene = Scene::new(2, &OBJECTS);
    let site = FusedSite::start(&scene.rig, &scene.objects, "");
    let client = connect(&site);
    let words = client
        .poses("sphere")
        .expect_err("no such object")
        .to_string();
    assert_eq!(
        words,
        r#"site "lab" has no object "sphere"; it has box, cube"#
    );
    let words = client
        .observations("cam7")
        .expect_err("no such camera")
        .to_string();
    assert_eq!(
        words,
        r#"site "lab" has no camera "cam7"; it has cam0, cam1"#
    );
    let words = client.pose("No Id", MOMENT).expect_err("no id").to_string();
    assert!(words.contains("No Id") && words.contains("a-z"), "{words}");
    let unseen = client
        .pose("box", MOMENT)
        .expect_err("nobody sees it")
        .to_string();
    assert!(unseen.contains("sextant top"), "{unseen}");

    let impatient = Site::options("hall")
        .endpoint(&site.connect)
        .timeout(MOMENT);
    let other = impatient.connect().expect("a router serves every site");
    let words = other.poses("box").expect_err("another site").to_string();
    assert!(words.contains("this router serves lab"), "{words}");

    let nobody = format!("tcp/127.0.0.1:{}", free_port());
    let lonely = Site::options("lab")
        .endpoint(&nobody)
        .timeout(MOMENT)
        .connect();
    let words = lonely.expect_err("no router").to_string();
    assert!(
        words.contains(&nobody) && words.contains("refused"),
        "{words}"
    );
}

#[test]
fn subscriptions_go_on_when_the_site_comes_back() {
    let mut moving = Moving::start();
    let client = connect(&moving.site);
    let mut poses = client.poses("box").expect("an object");
    moving.until(|| poses.try_next());
    let Moving { site, scene, .. } = moving;
    let mut again = Moving::new(site.restarted(), scene);
    let start_ns = again.start_ns;
    let is_new = |pose: &Pose| pose.t_ns >= start_ns;
    again.until(|| poses.try_next().filter(is_new));
    again.until(|| client.pose("cube", Duration::ZERO).ok());
    assert_eq!(poses.counts().refused, 0);
}

/// The user name is the common name in the member's `node.toml`.
fn user_of(keys: &Path) -> (String, String) {
    let read = |name| std::fs::read_to_string(keys.join(name)).expect("keys");
    let node = read("node.toml");
    let line = node
        .lines()
        .find_map(|line| line.strip_prefix("common_name = "));
    let name = line.expect("a name").trim_matches('"').to_owned();
    (name, read("password").trim().to_owned())
}

#[test]
fn keys_and_passwords_open_a_protected_site() {
    for profile in [Profile::Lab, Profile::Site] {
        let site = LockedSite::start(profile);
        let keys = site.keys_of("screen");
        let options = || Site::options("lab").endpoint(&site.connect);
        let client = options().keys(&keys).connect().expect("a member");
        let objects = client.objects().expect("objects");
        assert_eq!(objects.len(), 1, "{objects:?}");
        if profile == Profile::Lab {
            let (name, password) = user_of(&keys);
            let client = options()
                .user(&name, &password)
                .connect()
                .expect("a member");
            assert_eq!(client.objects().expect("objects").len(), 1);
            let wrong = options().user(&name, "wrong").timeout(MOMENT).connect();
            assert!(matches!(wrong, Err(Error::NoRouter { .. })), "{wrong:?}");
        }
        let stranger = options().timeout(MOMENT).connect();
        assert!(stranger.is_err(), "{stranger:?}");
    }
}
