//! The table of faults and promises of BENCHMARKS.md: a test a row. `cargo xtask faults` runs them in full length and writes the figures; a
//! plain run is shorter and holds no time against the machine (`system_tests::Figure`).

#![allow(clippy::expect_used, reason = "a test ends by panicking")]

mod camera_node;
mod clocks;
mod congestion;
mod intruders;
mod long_run;
mod random_kills;
mod resources;

use sextant_process::now_ns;
use sextant_proto::{FusionStatus, State};
use sextant_recordings::mcap::site_recording::SiteRecording;
use sextant_simulator::Random;
use std::collections::{BTreeMap, BTreeSet};
use std::process::Command;
use std::time::{Duration, Instant};
use system_tests::{
    CameraFeed, Cameras, FaultProxy, Faults, Figure, House, Scene, Sight, Witness, is_full,
};

const CAMERAS: usize = 4;
const ALL: [usize; CAMERAS] = [0, 1, 2, 3];

fn scene() -> Scene {
    Scene::new(CAMERAS, &["box", "cube"])
}

/// Longest time between two used poses of one object, with `since` as the first, ms.
fn longest_gap_ms(sights: &[Sight], since: Instant) -> f64 {
    let objects: BTreeSet<_> = sights.iter().map(|one| &one.pose.object).collect();
    assert!(objects.len() >= 2, "poses of all objects");
    longest_gap_of_any_ms(sights, since)
}

/// The same where there is one object.
fn longest_gap_of_any_ms(sights: &[Sight], since: Instant) -> f64 {
    let objects: BTreeSet<_> = sights.iter().map(|one| one.pose.object.clone()).collect();
    assert!(!objects.is_empty(), "poses");
    let gap = |object| {
        let own = sights.iter().filter(|one| one.pose.object == object);
        let times: Vec<Instant> = [since].into_iter().chain(own.map(|one| one.at)).collect();
        let gaps = times.windows(2).map(|pair| pair[1] - pair[0]);
        gaps.max().unwrap_or_default()
    };
    let longest = objects.into_iter().map(gap).max();
    longest.unwrap_or_default().as_secs_f64() * 1e3
}

/// What subscribers use of an object is never of an older epoch after a newer one.
fn assert_epochs_increase(sights: &[Sight]) {
    let mut newest = BTreeMap::new();
    for pose in sights
        .iter()
        .filter(|one| one.is_current)
        .map(|one| &one.pose)
    {
        let before = newest.insert(&pose.object, pose.epoch);
        assert!(
            before.is_none_or(|before| before <= pose.epoch),
            "{}: epoch {} after {before:?}",
            pose.object,
            pose.epoch
        );
    }
}

fn assert_true(house: &House, feed: &CameraFeed, sights: &[Sight]) {
    for sight in sights {
        let pose = &sight.pose;
        let error_m = feed.error_m(house, pose);
        assert!(!feed.is_wrong(house, pose), "{error_m} m: {pose:?}");
    }
}

fn feed(house: &House, cameras: &[usize], routers: &[&str], start_ns: u64) -> CameraFeed {
    let rate_hz = 30;
    CameraFeed::start(
        house,
        Cameras {
            cameras,
            routers,
            start_ns,
            rate_hz,
        },
    )
}

type Statuses = BTreeMap<String, FusionStatus>;

/// So many fusion nodes track all objects.
fn await_tracking(house: &House, routers: &[&str], nodes: usize) -> Statuses {
    house.await_statuses(routers, |statuses| {
        let tracks = |status: &FusionStatus| {
            let mut objects = status.objects.iter();
            objects.all(|object| object.state == State::Tracking)
        };
        statuses.len() == nodes && statuses.values().all(tracks)
    })
}

/// The status of the node `main` is as wanted.
fn await_main(house: &House, router: &str, wanted: impl Fn(&FusionStatus) -> bool) -> FusionStatus {
    let mut statuses = house.await_statuses(&[router], |statuses| {
        statuses.get("main").is_some_and(&wanted)
    });
    statuses.remove("main").expect("it is there")
}

/// Two nodes are there, and one of them publishes.
fn one_publishes(statuses: &Statuses) -> bool {
    let publishers = statuses.values().filter(|status| status.epoch.is_some());
    statuses.len() == 2 && publishers.count() == 1
}

/// No pose that subscribers use is older than the estimator's window when it arrives.
fn assert_fresh(sights: &[Sight]) {
    for sight in sights.iter().filter(|one| one.is_current) {
        let age_ms = sight.at_ns.saturating_sub(sight.pose.capture_ns) / 1_000_000;
        let limit_ms = if is_full() { 600 } else { 1_500 };
        assert!(age_ms < limit_ms, "{age_ms} ms: {:?}", sight.pose);
    }
}

/// As long as the table says, or shorter.
fn lasting(full_s: u64, short_s: u64) -> Duration {
    Duration::from_secs(if is_full() { full_s } else { short_s })
}

/// Two fusion nodes behind one router; `main` publishes, reached by a proxy.
fn two_nodes(house: &mut House) -> (String, FaultProxy, CameraFeed, Witness) {
    let router = house.router("router", &[]);
    let proxy = FaultProxy::start(&router);
    house.fusion("main", &[&proxy.endpoint]);
    house.fusion("spare", &[&router]);
    let feed = feed(house, &ALL, &[&router], now_ns());
    let witness = Witness::start(&house.keys, &[&router]);
    let statuses = await_tracking(house, &[&router], 2);
    assert!(statuses["main"].epoch.is_some() && statuses["spare"].epoch.is_none());
    (router, proxy, feed, witness)
}

/// Takes the publisher away; another goes on with its track. Then the first comes back and stands by.
fn replaced(
    what: &str,
    away: impl Fn(&mut House, &FaultProxy),
    back: impl Fn(&mut House, &FaultProxy),
) {
    let mut house = House::new(&scene());
    let (router, proxy, feed, witness) = two_nodes(&mut house);
    let first = witness.sights().last().expect("a pose").pose.epoch;
    let since = Instant::now();
    away(&mut house, &proxy);
    witness.await_pose(since, |pose| pose.epoch > first);
    let second = house.await_statuses(&[&router], |statuses| {
        statuses
            .get("spare")
            .is_some_and(|status| status.epoch.is_some())
    });
    let second = second["spare"].epoch.expect("it publishes");
    let used = witness.used_since(since);
    Figure {
        row: "publisher killed, stopped or cut off",
        what,
        value: longest_gap_ms(&used, since),
        unit: "ms without a pose",
        at_most: 300.0,
    }
    .keep();
    let successor = used.iter().filter(|one| one.pose.epoch == second);
    for sight in successor.clone().take(20) {
        assert_eq!(sight.pose.state, State::Tracking, "the track goes on");
    }
    assert!(successor.count() > 0);
    back(&mut house, &proxy);
    house.await_statuses(&[&router], one_publishes);
    let all = witness.sights();
    assert_true(&house, &feed, &all);
    assert_fresh(&all);
    assert_epochs_increase(&all);
    // On a busy machine a process may lie idle for longer than a standby waits.
    let epochs: BTreeSet<u64> = all.iter().map(|one| one.pose.epoch).collect();
    let flaps = epochs != BTreeSet::from([first, second]);
    assert!(!is_full() || !flaps, "{epochs:?}, not {first} and {second}");
}

#[test]
fn a_publisher_that_is_killed_is_replaced() {
    replaced(
        "kill -9",
        |house, _| house.kill("main"),
        |house, _| house.restart("main"),
    );
}

/// Stopped for 3 s and continued: what it publishes then is of an older epoch, if it publishes at all.
#[test]
fn a_publisher_that_is_stopped_is_replaced() {
    replaced(
        "SIGSTOP for 3 s",
        |house, _| house.signal("main", libc::SIGSTOP),
        |house, _| {
            std::thread::sleep(Duration::from_secs(3));
            house.signal("main", libc::SIGCONT);
        },
    );
}

#[test]
fn a_publisher_that_is_cut_off_is_replaced() {
    let cut = Faults {
        is_cut: true,
        ..Faults::default()
    };
    replaced(
        "network cut",
        |_, proxy| proxy.set(cut),
        |_, proxy| proxy.set(Faults::default()),
    );
}

/// Its connection stays open and nothing passes.
#[test]
fn a_publisher_behind_a_dead_switch_is_replaced() {
    let frozen = Faults {
        is_frozen: true,
        ..Faults::default()
    };
    replaced(
        "connection half-open",
        |_, proxy| proxy.set(frozen),
        |_, proxy| proxy.set(Faults::default()),
    );
}

/// Half of the cameras and one fusion node behind each of two routers, whose link is cut for a minute and mended.
#[test]
fn both_halves_of_a_divided_site_are_served_and_one_publisher_remains() {
    const ROW: &str = "half of the site cut off, then back";
    let mut house = House::new(&scene());
    let left = house.router("left", &[]);
    let proxy = FaultProxy::start(&left);
    let right = house.router("right", &[&proxy.endpoint]);
    house.fusion("main", &[&left]);
    house.fusion("spare", &[&right]);
    let start_ns = now_ns();
    let feeds = [
        feed(&house, &[0, 1], &[&left], start_ns),
        feed(&house, &[2, 3], &[&right], start_ns),
    ];
    let witnesses = [&left, &right].map(|router| Witness::start(&house.keys, &[router]));
    await_tracking(&house, &[&left], 2);
    // Whichever does: the routers may have met after both had begun.
    let statuses = house.await_statuses(&[&left], one_publishes);
    let nodes = ["main", "spare"];
    let publisher = nodes
        .iter()
        .position(|&node| statuses[node].epoch.is_some());
    let publisher = publisher.expect("one publishes");
    let first = statuses[nodes[publisher]].epoch.expect("it publishes");
    let since = Instant::now();
    proxy.set(Faults {
        is_cut: true,
        ..Faults::default()
    });
    witnesses[1 - publisher].await_pose(since, |pose| pose.epoch > first);
    std::thread::sleep(lasting(60, 3));
    for (witness, what) in witnesses.iter().zip(["first half", "other half"]) {
        Figure {
            row: ROW,
            what,
            value: longest_gap_ms(&witness.used_since(since), since),
            unit: "ms without a pose",
            at_most: 300.0,
        }
        .keep();
    }
    let healed = Instant::now();
    proxy.set(Faults::default());
    let statuses = house.await_statuses(&[&left], one_publishes);
    let second = statuses[nodes[1 - publisher]].epoch;
    let second = second.expect("the newer epoch stays");
    let one = Instant::now();
    for (witness, what) in witnesses
        .iter()
        .zip(["first half, healing", "other half, healing"])
    {
        witness.await_pose(one, |pose| pose.epoch == second);
        let mut late = witness.used_since(one).into_iter();
        assert!(late.all(|sight| sight.pose.epoch == second));
        let all = witness.sights();
        assert_epochs_increase(&all);
        assert_true(&house, &feeds[0], &all);
        assert_fresh(&all);
        Figure {
            row: ROW,
            what,
            value: longest_gap_ms(&witness.used_since(healed), healed),
            unit: "ms without a pose",
            at_most: 1000.0,
        }
        .keep();
    }
}

/// Everything is behind the first of two routers, and goes on behind the second.
#[test]
fn a_site_goes_on_when_a_router_dies() {
    let mut house = House::new(&scene());
    let first = house.router("first", &[]);
    let second = house.router("second", &[&first]);
    house.fusion("main", &[&first, &second]);
    house.fusion("spare", &[&second, &first]);
    let feed = feed(&house, &ALL, &[&first, &second], now_ns());
    let witness = Witness::start(&house.keys, &[&second]);
    await_tracking(&house, &[&second], 2);
    let since = Instant::now();
    house.kill("first");
    witness.await_pose(since + Duration::from_secs(3), |pose| {
        pose.state == State::Tracking
    });
    let statuses = house.await_statuses(&[&second], one_publishes);
    assert!(
        statuses.contains_key("main"),
        "it is behind the other router"
    );
    let used = witness.used_since(since);
    Figure {
        row: "kill -9 of a router, the second goes on",
        what: "kill -9",
        value: longest_gap_ms(&used, since),
        unit: "ms without a pose",
        at_most: 1000.0,
    }
    .keep();
    assert_epochs_increase(&witness.sights());
    assert_true(&house, &feed, &witness.sights());
}

/// Fusion nodes are killed at random and started again.
#[test]
fn poses_go_on_through_random_kills() {
    let mut house = House::new(&scene());
    let (router, _proxy, feed, witness) = two_nodes(&mut house);
    let mut random = Random::from_keys(&[28]);
    let kills = if is_full() { 50 } else { 4 };
    let begun = Instant::now();
    let mut longest_ms: f64 = 0.0;
    for _ in 0..kills {
        let victim = ["main", "spare"][random.below(2)];
        let since = Instant::now();
        house.kill(victim);
        witness.await_pose(since + Duration::from_millis(400), |_| true);
        longest_ms = longest_ms.max(longest_gap_ms(&witness.used_since(since), since));
        house.restart(victim);
        // One that has just begun has no track to go on with: until both have, nobody is spare.
        await_tracking(&house, &[&router], 2);
        if is_full() {
            std::thread::sleep(Duration::from_secs_f64(random.between(0.5, 2.5)));
        }
    }
    Figure {
        row: "kill -9 of fusion nodes at random, one standby",
        what: &format!("{kills} kills in {} s", begun.elapsed().as_secs()),
        value: longest_ms,
        unit: "ms without a pose",
        at_most: 300.0,
    }
    .keep();
    let all = witness.sights();
    assert_epochs_increase(&all);
    assert_true(&house, &feed, &all);
    assert_fresh(&all);
}

/// One camera behind a link that stalls with its connection open, so that images pile up in it.
#[test]
fn a_camera_that_was_cut_off_brings_no_stale_images() {
    const ROW: &str = "camera cut off, then back";
    let mut house = House::new(&scene());
    let router = house.router("router", &[]);
    house.fusion("main", &[&router]);
    let proxy = FaultProxy::start(&router);
    let start_ns = now_ns();
    let others = feed(&house, &[0, 1, 2], &[&router], start_ns);
    let _cut = feed(&house, &[3], &[&proxy.endpoint], start_ns);
    let witness = Witness::start(&house.keys, &[&router]);
    await_tracking(&house, &[&router], 1);
    let rate = |status: &FusionStatus, camera: usize| f64::from(status.cameras[camera].rate_hz);
    let is_back = |status: &FusionStatus| rate(status, 3) > 25.0;
    await_main(&house, &router, is_back);
    proxy.set(Faults {
        is_frozen: true,
        ..Faults::default()
    });
    std::thread::sleep(lasting(10, 4));
    let during = await_main(&house, &router, |status| rate(status, 3) == 0.0);
    let slowest = (0..3)
        .map(|camera| rate(&during, camera))
        .fold(f64::MAX, f64::min);
    Figure {
        row: ROW,
        what: "rate of the others",
        value: 100.0 * (1.0 - slowest / 30.0).max(0.0),
        unit: "% less",
        at_most: 2.0,
    }
    .keep();
    let before = during.cameras[3].last_capture_ns;
    let back = Instant::now();
    proxy.set(Faults::default());
    await_main(&house, &router, |status| {
        let last_ns = status.cameras[3].last_capture_ns;
        last_ns > before && now_ns().saturating_sub(last_ns) < 1_500_000_000
    });
    Figure {
        row: ROW,
        what: "back in the status after",
        value: back.elapsed().as_secs_f64() * 1e3,
        unit: "ms",
        at_most: 2000.0,
    }
    .keep();
    await_main(&house, &router, is_back);
    let all = witness.sights();
    assert_true(&house, &others, &all);
    assert_fresh(&all);
}

#[test]
fn a_lossy_camera_costs_no_coverage_where_others_see() {
    let mut house = House::new(&scene());
    let router = house.router("router", &[]);
    house.fusion("main", &[&router]);
    let proxy = FaultProxy::start(&router);
    let start_ns = now_ns();
    let others = feed(&house, &[0, 1, 2], &[&router], start_ns);
    let _lossy = feed(&house, &[3], &[&proxy.endpoint], start_ns);
    let witness = Witness::start(&house.keys, &[&router]);
    await_tracking(&house, &[&router], 1);
    proxy.set(Faults {
        loss: 0.2,
        jitter: Duration::from_millis(200),
        ..Faults::default()
    });
    let since = Instant::now();
    std::thread::sleep(lasting(30, 4));
    let used = witness.used_since(since);
    let tracked = used.iter().filter(|one| one.pose.state == State::Tracking);
    Figure {
        row: "20 % loss, 200 ms jitter on one camera",
        what: "poses that are not tracking",
        value: 100.0 * (1.0 - tracked.count() as f64 / used.len() as f64),
        unit: "%",
        at_most: 0.5,
    }
    .keep();
    Figure {
        row: "20 % loss, 200 ms jitter on one camera",
        what: "longest gap",
        value: longest_gap_ms(&used, since),
        unit: "ms",
        at_most: 150.0,
    }
    .keep();
    assert_true(&house, &others, &used);
    assert_fresh(&used);
}

/// Ten times as many images as the cameras of the house make.
#[test]
fn an_overload_leaves_poses_fresh_and_memory_bounded() {
    const ROW: &str = "10x overload of observations";
    let mut house = House::new(&scene());
    let router = house.router("router", &[]);
    house.fusion("main", &[&router]);
    let start_ns = now_ns();
    let usual = feed(&house, &ALL, &[&router], start_ns);
    let witness = Witness::start(&house.keys, &[&router]);
    await_tracking(&house, &[&router], 1);
    drop(usual);
    let since = Instant::now();
    let flood = CameraFeed::start(
        &house,
        Cameras {
            cameras: &ALL,
            routers: &[&router],
            start_ns,
            rate_hz: 300,
        },
    );
    std::thread::sleep(lasting(30, 4));
    let memory_mib = house.memory_mib("main");
    drop(flood);
    let ended = Instant::now();
    let used = witness.used_since(since);
    let mut ages_ms: Vec<f64> = used
        .iter()
        .map(|one| one.at_ns.saturating_sub(one.pose.capture_ns) as f64 * 1e-6)
        .collect();
    ages_ms.sort_by(f64::total_cmp);
    Figure {
        row: ROW,
        what: "p99 of the age of served poses",
        value: ages_ms[ages_ms.len() * 99 / 100],
        unit: "ms",
        at_most: 100.0,
    }
    .keep();
    Figure {
        row: ROW,
        what: "memory of the fusion node",
        value: memory_mib,
        unit: "MiB",
        at_most: 256.0,
    }
    .keep();
    let usual = feed(&house, &ALL, &[&router], start_ns);
    let recovered = witness.await_pose(ended, |pose| {
        pose.state == State::Tracking && now_ns().saturating_sub(pose.capture_ns) < 100_000_000
    });
    Figure {
        row: ROW,
        what: "recovery",
        value: (recovered - ended).as_secs_f64() * 1e3,
        unit: "ms",
        at_most: 1000.0,
    }
    .keep();
    assert_true(&house, &usual, &witness.sights());
    assert_fresh(&witness.sights());
}

/// The clock of one camera's board is set by five seconds, and set right again.
#[test]
fn a_board_whose_clock_is_set_is_named_and_taken_again() {
    for by_s in [5, -5] {
        let mut house = House::new(&scene());
        let router = house.router("router", &[]);
        house.fusion("main", &[&router]);
        let start_ns = now_ns();
        let others = feed(&house, &[0, 1, 2], &[&router], start_ns);
        let board = feed(&house, &[3], &[&router], start_ns);
        let witness = Witness::start(&house.keys, &[&router]);
        await_tracking(&house, &[&router], 1);
        let since = Instant::now();
        board.set_clock(by_s * 1_000_000_000);
        let is_named = |status: &FusionStatus| {
            let findings = status.faults.iter().map(ToString::to_string);
            let notices = status.notices.iter().map(ToString::to_string);
            let mut words = findings.chain(notices);
            words.any(|words| words.contains("cam3"))
        };
        await_main(&house, &router, is_named);
        Figure {
            row: "clock of a board set by 5 s",
            what: &format!("{by_s:+} s named after"),
            value: since.elapsed().as_secs_f64() * 1e3,
            unit: "ms",
            at_most: 2000.0,
        }
        .keep();
        board.set_clock(0);
        await_main(&house, &router, |status| {
            !is_named(status) && status.cameras[3].rate_hz > 25.0
        });
        let used = witness.used_since(since);
        Figure {
            row: "clock of a board set by 5 s",
            what: "longest gap of poses",
            value: longest_gap_ms(&used, since),
            unit: "ms",
            at_most: 300.0,
        }
        .keep();
        assert_true(&house, &others, &used);
    }
}

/// A subscriber that stops reading, with its connection open.
#[test]
fn a_subscriber_that_does_not_read_hurts_itself_only() {
    let mut house = House::new(&scene());
    let router = house.router("router", &[]);
    house.fusion("main", &[&router]);
    let others = feed(&house, &ALL, &[&router], now_ns());
    let witness = Witness::start(&house.keys, &[&router]);
    await_tracking(&house, &[&router], 1);
    house.tool("reader", &router, &["echo"]);
    house.signal("reader", libc::SIGSTOP);
    let since = Instant::now();
    std::thread::sleep(lasting(30, 4));
    let used = witness.used_since(since);
    Figure {
        row: "a subscriber stops reading",
        what: "longest gap of others",
        value: longest_gap_ms(&used, since),
        unit: "ms",
        at_most: 150.0,
    }
    .keep();
    assert_true(&house, &others, &used);
    assert_fresh(&used);
}

/// A recorder that writes into a file system of two mebibytes. Needs root, for a mount of its own.
#[test]
fn a_recorder_whose_disk_is_full_says_so_and_keeps_what_it_has() {
    let mut house = House::new(&scene());
    let router = house.router("router", &[]);
    house.fusion("main", &[&router]);
    let _feed = feed(&house, &ALL, &[&router], now_ns());
    let witness = Witness::start(&house.keys, &[&router]);
    await_tracking(&house, &[&router], 1);
    let (folder, kept) = (house.path("", "disk"), house.path("", "kept.mcap"));
    std::fs::create_dir(&folder).expect("a folder");
    let record = house.command(&router, &["record"]);
    let mut shell = Command::new("unshare");
    shell.args(["--mount", "sh", "-c"]);
    shell.arg("mount -t tmpfs -o size=2m tmpfs \"$1\" || exit 77; disk=$1 kept=$2; shift 2; \"$@\" \"$disk/site.mcap\"; code=$?; cp \"$disk/site.mcap\" \"$kept\"; exit $code");
    shell.arg("sh").args([&folder, &kept]);
    shell.arg(record.get_program()).args(record.get_args());
    let since = Instant::now();
    let ended = shell
        .output()
        .expect("unshare runs: it comes with util-linux");
    if ended.status.code() == Some(77) || !kept.exists() && ended.status.code() == Some(1) {
        eprintln!("SKIPPED: a full disk needs root, for a mount of its own");
        return;
    }
    let words = String::from_utf8_lossy(&ended.stderr);
    assert!(ended.status.code().is_some_and(|code| code != 0), "{words}");
    assert!(
        words.contains("disk is full") || words.contains("No space"),
        "{words}"
    );
    let ended_ns = now_ns();
    let recording = SiteRecording::read(&kept).expect("it opens");
    let last_ns = recording.poses.iter().map(|pose| pose.published_ns).max();
    Figure {
        row: "recorder's disk full",
        what: "lost at the end",
        value: ended_ns.saturating_sub(last_ns.expect("poses")) as f64 * 1e-6,
        unit: "ms, the end of the program included",
        at_most: 1000.0,
    }
    .keep();
    Figure {
        row: "recorder's disk full",
        what: "longest gap of live poses",
        value: longest_gap_ms(&witness.used_since(since), since),
        unit: "ms",
        at_most: 150.0,
    }
    .keep();
}

/// How many objects each node publishes, once each of these is published by one node and each node has some.
fn await_shares(house: &House, router: &str, nodes: &[&str], n: usize) -> BTreeMap<String, usize> {
    let shares = |statuses: &Statuses| {
        let published = |status: &FusionStatus| {
            let objects = status.objects.iter();
            objects.filter(|object| object.rate_hz > 1.0).count()
        };
        let shares = statuses
            .iter()
            .map(|(name, one)| (name.clone(), published(one)));
        shares.collect::<BTreeMap<_, _>>()
    };
    let statuses = house.await_statuses(&[router], |statuses| {
        let shares = shares(statuses);
        let has_some = |name: &&str| shares.get(*name).is_some_and(|share| *share > 0);
        shares.len() == nodes.len()
            && nodes.iter().all(has_some)
            && shares.values().sum::<usize>() == n
    });
    shares(&statuses)
}

/// Three nodes share twelve objects. One is killed, and started again.
#[test]
fn objects_are_shared_and_move_when_nodes_come_and_go() {
    const ROW: &str = "one of three fusion nodes that share 12 objects";
    const NODES: [&str; 3] = ["main", "spare", "third"];
    let names: Vec<String> = (0..12).map(|k| format!("cube{k}")).collect();
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    let mut house = House::new(&Scene::new(CAMERAS, &names));
    let router = house.router("router", &[]);
    for node in NODES {
        house.fusion_with(node, &[&router], "[sharding]\nmode = \"by-members\"\n");
    }
    let cameras = Cameras {
        cameras: &ALL,
        routers: &[&router],
        start_ns: now_ns(),
        // Three nodes run on this machine.
        rate_hz: 10,
    };
    let feed = CameraFeed::start(&house, cameras);
    let witness = Witness::start(&house.keys, &[&router]);
    let before = await_shares(&house, &router, &NODES, names.len());
    // Two of three nodes track an object.
    let statuses = house.await_statuses(&[&router], |statuses| {
        let tracked = statuses.values().map(|status| status.objects.len());
        tracked.sum::<usize>() == 2 * names.len()
    });
    let unknown = statuses.values().flat_map(|status| &status.cameras);
    assert_eq!(unknown.map(|camera| camera.unknown_tags).max(), Some(0));

    let killed = Instant::now();
    house.kill("main");
    await_shares(&house, &router, &NODES[1..], names.len());
    let restarted = Instant::now();
    house.restart("main");
    assert_eq!(await_shares(&house, &router, &NODES, names.len()), before);
    let used = witness.used_since(killed);
    let (away, back): (Vec<_>, Vec<_>) = used.into_iter().partition(|one| one.at < restarted);
    for (what, sights, since) in [("kill -9", away, killed), ("back", back, restarted)] {
        assert_true(&house, &feed, &sights);
        Figure {
            row: ROW,
            what,
            value: longest_gap_ms(&sights, since),
            unit: "ms without a pose",
            at_most: 300.0,
        }
        .keep();
    }
    assert_epochs_increase(&witness.sights());
}
