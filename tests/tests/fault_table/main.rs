//! The table of faults and promises of BENCHMARKS.md: a test a row. `cargo xtask faults` runs them in full length and
//! writes the figures; a plain run is shorter and holds no time against the machine (`system_tests::Figure`).

#![allow(clippy::expect_used, reason = "a test ends by panicking")]

mod camera_node;
mod clocks;
mod congestion;
mod intruders;
mod killed_writes;
mod links;
mod long_run;
mod models;
mod random_kills;
mod resources;
mod routers;
mod sharing;
mod standby;

use sextant_process::now_ns;
use sextant_proto::{FusionStatus, State};
use sextant_simulator::Random;
use std::collections::{BTreeMap, BTreeSet};
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

/// Like [`longest_gap_ms`], where there may be one object only.
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

/// A site of two halves: two routers with a link that a proxy cuts, and half of the cameras and one fusion node behind
/// each.
struct DividedSite {
    house: House,
    routers: [String; 2],
    link: FaultProxy,
    feeds: [CameraFeed; 2],
}

impl DividedSite {
    /// Both nodes track, and one of them publishes: which of [`HALVES`] it is.
    fn start(mut house: House) -> (Self, Statuses, usize) {
        let left = house.router("left", &[]);
        let link = FaultProxy::start(&left);
        let right = house.router("right", &[&link.endpoint]);
        house.fusion(HALVES[0], &[&left]);
        house.fusion(HALVES[1], &[&right]);
        let start_ns = now_ns();
        let feeds = [
            feed(&house, &[0, 1], &[&left], start_ns),
            feed(&house, &[2, 3], &[&right], start_ns),
        ];
        await_tracking(&house, &[&left], 2);
        // Either may: the routers may have met after both had begun.
        let statuses = house.await_statuses(&[&left], one_publishes);
        let publisher = HALVES
            .iter()
            .position(|&node| statuses[node].epoch.is_some());
        let site = Self {
            house,
            routers: [left, right],
            link,
            feeds,
        };
        (site, statuses, publisher.expect("one publishes"))
    }
}

/// The fusion nodes of a divided site.
const HALVES: [&str; 2] = ["main", "spare"];

/// Connections are closed and refused.
fn cut() -> Faults {
    Faults {
        is_cut: true,
        ..Faults::default()
    }
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
