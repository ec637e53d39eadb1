//! Any process of a site is killed, at random: fusion nodes, the parts of a camera node, the viewer bridge and the
//! router.

use super::*;
use crate::camera_node::{CAMERA, DIE, error_m, in_shared_memory};
use std::net::TcpStream;
use system_tests::send;

const ROW: &str = "kill -9 of any process at random";
const VICTIMS: [&str; 6] = ["main", "spare", "capture", "detect", "viewer", "router"];

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
        let mut house = camera_node::house();
        let router = house.router("router", &[]);
        house.fusion("main", &[&router]);
        house.fusion("spare", &[&router]);
        let network = format!("[network]\nmode = \"client\"\nconnect = [\"{router}\"]\n");
        let page = format!("127.0.0.1:{}", system_tests::free_port());
        let text = format!("site = \"lab\"\nlisten = \"{page}\"\n{network}");
        house.node("viewer", "viewer", &text);
        let shared_memory = format!("f{}", std::process::id());
        let text = camera_node::write_files(&house, &router, &shared_memory);
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

    /// Both fusion nodes track all objects, and one of them publishes. Between two images of its only camera an object
    /// coasts.
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
            let is_wrong = pose.state == State::Tracking && error_m(pose) > 0.02;
            assert!(!is_wrong, "{} m: {pose:?}", error_m(pose));
        }
    }

    fn in_shared_memory(&self) -> Vec<String> {
        in_shared_memory(&self.house, &self.shared_memory)
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
        let due =
            begun + Duration::from_secs_f64(period_s * (kill as f64 + 0.5 * random.uniform()));
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
    // A file of the last dead ports may still be there; those of all kills would be dozens.
    assert!(now.len() <= usual + 4, "{usual} files before: {now:?}");
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
