//! Any process of a site is killed, at random: fusion nodes, the parts of a camera node, the viewer bridge and the router.

use super::*;
use nalgebra::{Isometry3, Rotation3, UnitQuaternion, Vector3};
use sextant_estimator::{Camera, CameraId, Rig};
use sextant_geometry::{Intrinsics, Lens, Pose};
use sextant_simulator::{Background, Path, Scenario, SceneCamera, SceneObject, SceneTag, Solid};
use std::net::TcpStream;
use system_tests::send;

const ROW: &str = "kill -9 of any process at random";
/// Seen by the camera node alone.
const DIE: &str = "die";
const CAMERA: &str = "eye";
const VICTIMS: [&str; 6] = ["main", "spare", "capture", "detect", "viewer", "router"];

fn die_at() -> Isometry3<f64> {
    let turn = UnitQuaternion::from_euler_angles(0.1, 0.2, 0.3);
    Isometry3::from_parts(Vector3::new(0.6, 0.6, 0.0).into(), turn)
}

fn eye() -> Camera {
    let place = Vector3::new(0.6, 0.25, 0.25);
    let forward = (die_at().translation.vector - place).normalize();
    let right = forward.cross(&Vector3::z()).normalize();
    let rotation = Rotation3::from_basis_unchecked(&[right, forward.cross(&right), forward]);
    let intrinsics = Intrinsics {
        fx: 300.0,
        fy: 300.0,
        cx: 159.5,
        cy: 119.5,
    };
    Camera {
        id: CameraId::new(CAMERA).expect("an id"),
        resolution: [320, 240],
        lens: Lens::pinhole(intrinsics).expect("a lens"),
        world_from_camera: Some(Pose::from_parts(
            place.into(),
            UnitQuaternion::from_rotation_matrix(&rotation),
        )),
    }
}

/// What the camera node renders.
fn scenario(camera: &Camera, die: &ObjectModel) -> Scenario {
    let tag = |tag: &sextant_estimator::ObjectTag| {
        let at = tag.object_from_tag.expect("a place");
        SceneTag::new(tag.tag.family, tag.tag.id, tag.size_m, at)
    };
    let pose = camera.world_from_camera.expect("a place");
    Scenario {
        background: Background::Plain { level: 110.0 },
        cameras: vec![SceneCamera {
            rate_hz: 10.0,
            ..SceneCamera::new(CAMERA, camera.resolution, camera.lens, pose)
        }],
        objects: vec![SceneObject {
            id: DIE.to_owned(),
            solids: vec![Solid::Box {
                size: [0.06; 3],
                object_from_box: Pose::identity(),
                albedo: 0.4,
            }],
            tags: die.tags().iter().map(tag).collect(),
            path: Path::at_rest(&die_at()),
        }],
        ..Scenario::demo(1, 1, 1)
    }
}

/// A site of which each process may be killed.
struct Site {
    house: House,
    router: String,
    page: String,
    feed: CameraFeed,
    witness: Witness,
    shared_memory: String,
}

impl Site {
    fn start() -> Self {
        let seen = scene();
        let mut objects = Scene::new(CAMERAS, &["box", "cube", DIE]).objects;
        let die = objects[2].clone();
        let mut cameras = seen.rig.cameras().to_vec();
        cameras.push(eye());
        objects.truncate(2);
        objects.push(die.clone());
        let files = Scene::of(Rig::new(cameras).expect("a rig"), objects);
        let mut house = House::of(&files, &seen);
        let router = house.router("router", &[]);
        house.fusion("main", &[&router]);
        house.fusion("spare", &[&router]);
        let network = format!("[network]\nmode = \"client\"\nconnect = [\"{router}\"]\n");
        let page = format!("127.0.0.1:{}", system_tests::free_port());
        let text = format!("site = \"lab\"\nlisten = \"{page}\"\n{network}");
        house.node("viewer", "viewer", &text);
        let shared_memory = format!("f{}", std::process::id());
        let text = format!(
            "site = \"lab\"\ncamera = \"{CAMERA}\"\n[source]\nkind = \"simulator\"\nscenario = \"scenario.toml\"\n[shared_memory]\nroot = \"i\"\nprefix = \"{shared_memory}\"\n{network}"
        );
        std::fs::create_dir(house.path("", CAMERA)).expect("a folder");
        let file = house.path(CAMERA, "scenario.toml");
        sextant_site_files::write_toml(&file, &scenario(&eye(), &die)).expect("a file");
        house.node(CAMERA, "camera", &text);
        let feed = feed(&house, &ALL, &[&router], now_ns());
        let witness = Witness::start(&house.keys, &[&router]);
        let site = Self {
            house,
            router,
            page,
            feed,
            witness,
            shared_memory,
        };
        site.await_calm();
        site
    }

    /// Both fusion nodes track all objects, and one of them publishes. Between two images of its only camera an object coasts.
    fn await_calm(&self) {
        self.house.await_statuses(&[&self.router], |statuses| {
            let tracks = |status: &FusionStatus| {
                let mut objects = status.objects.iter();
                status.objects.len() == 3
                    && objects.all(|one| matches!(one.state, State::Tracking | State::Coasting))
            };
            one_publishes(statuses) && statuses.values().all(tracks)
        });
        self.await_all_poses(Instant::now());
        let deadline = Instant::now() + system_tests::PATIENCE;
        while TcpStream::connect(&self.page).is_err() {
            assert!(Instant::now() < deadline, "the page never answers");
            std::thread::sleep(Duration::from_millis(20));
        }
    }

    fn await_all_poses(&self, since: Instant) {
        for object in ["box", "cube", DIE] {
            self.witness.await_pose(since, |pose| {
                pose.object.as_str() == object && pose.state == State::Tracking
            });
        }
    }

    /// Longest time without a tracking pose of an object from the kill on, ms.
    fn kill(&mut self, victim: &str) -> f64 {
        let since = Instant::now();
        match victim {
            "capture" | "detect" => {
                let part = self.house.part_of(CAMERA, victim).expect("it runs");
                send(part, libc::SIGKILL);
            }
            node => {
                self.house.kill(node);
                if node == "router" {
                    self.house.restart(node);
                }
            }
        }
        self.await_all_poses(since + Duration::from_millis(400));
        let mut used = self.witness.used_since(since);
        used.retain(|one| one.pose.state == State::Tracking);
        let gap_ms = longest_gap_ms(&used, since);
        if ["main", "spare", "viewer"].contains(&victim) {
            self.house.restart(victim);
        }
        gap_ms
    }

    /// No pose claims to be good and is not.
    fn assert_true(&self, sights: &[Sight]) {
        let (dice, others): (Vec<_>, Vec<_>) =
            (sights.iter().cloned()).partition(|one| one.pose.object.as_str() == DIE);
        assert_true(&self.house, &self.feed, &others);
        for pose in dice.iter().map(|one| &one.pose) {
            let error = Vector3::from(pose.position) - die_at().translation.vector;
            let is_wrong = pose.state == State::Tracking && error.norm() > 0.02;
            assert!(!is_wrong, "{} m: {pose:?}", error.norm());
        }
    }

    /// Files of this site in shared memory, and in the folder of its bookkeeping.
    fn in_shared_memory(&self) -> Vec<String> {
        let entries = |folder: &std::path::Path, prefix: &str| {
            let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
            let names = entries.map(|one| one.file_name().to_string_lossy().into_owned());
            let own = names.filter(|name| name.starts_with(prefix));
            own.collect::<Vec<_>>()
        };
        let mut files = entries("/dev/shm".as_ref(), &self.shared_memory);
        files.extend(entries(&self.house.path(CAMERA, "i"), ""));
        files
    }
}

/// How long poses may stay away after the end of this process, ms.
fn promise_ms(victim: &str) -> f64 {
    match victim {
        "main" | "spare" | "viewer" => 300.0,
        _ => 1000.0,
    }
}

#[test]
fn any_process_may_be_killed_at_random() {
    let mut site = Site::start();
    let usual = site.in_shared_memory().len();
    assert!(usual > 0, "images pass through shared memory");
    let mut random = Random::from_keys(&[29]);
    let kills = if is_full() { 50 } else { VICTIMS.len() };
    let begun = Instant::now();
    let mut longest_ms: BTreeMap<&str, f64> = BTreeMap::new();
    for kill in 0..kills {
        let period_s = 300.0 / 50.0;
        let due = begun + Duration::from_secs_f64(period_s * (kill as f64 + random.uniform()));
        if is_full() {
            std::thread::sleep(due.saturating_duration_since(Instant::now()));
        }
        // Each of them once, then any.
        let victim = VICTIMS.get(kill).copied();
        let victim = victim.unwrap_or_else(|| VICTIMS[random.below(VICTIMS.len())]);
        let gap_ms = site.kill(victim);
        println!("{victim}: {gap_ms:.0} ms");
        let longest = longest_ms.entry(victim).or_default();
        *longest = longest.max(gap_ms);
        site.await_calm();
    }
    println!("{kills} kills in {} s", begun.elapsed().as_secs());
    for (victim, gap_ms) in longest_ms {
        Figure {
            row: ROW,
            what: victim,
            value: gap_ms,
            unit: "ms without a tracked pose",
            at_most: promise_ms(victim),
        }
        .keep();
    }
    let all = site.witness.sights();
    assert_epochs_increase(&all);
    site.assert_true(&all);
    assert_fresh(&all);
    let now = site.in_shared_memory();
    assert!(now.len() <= usual, "{usual} files before: {now:?}");
    site.house.end();
    let left = site.in_shared_memory();
    assert!(left.is_empty(), "{left:?}");
    Figure {
        row: ROW,
        what: "files left in shared memory at the end",
        value: left.len() as f64,
        unit: "",
        at_most: 0.0,
    }
    .keep();
}
