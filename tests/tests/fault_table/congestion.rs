//! More messages than a node, a link or a subscriber can take.

use super::*;
use crate::camera_node::CAMERA;
use sextant_proto::{Observations, limits};
use sextant_zenoh_bus::{Bus, BusOptions, DropRule};

const ROW: &str = "link of a camera too narrow for its previews";
/// Observations take a fifth of it, previews would take three times as much.
const BYTES_PER_S: u32 = 32_000;

/// What arrived behind the router.
#[derive(Default)]
struct Arrived {
    /// Sequence number and age of each observation, ms.
    observations: Vec<(u64, f64)>,
    previews: usize,
}

impl Arrived {
    fn oldest_ms(&self) -> f64 {
        self.observations
            .iter()
            .fold(0.0, |most, one| most.max(one.1))
    }

    fn lost_percent(&self) -> f64 {
        let numbers = self.observations.iter().map(|one| one.0);
        let (Some(first), Some(last)) = (numbers.clone().min(), numbers.max()) else {
            return 100.0;
        };
        let sent = (last - first + 1) as f64;
        100.0 * (1.0 - self.observations.len() as f64 / sent)
    }
}

/// A camera node whose link carries its observations, but not also all of its previews.
#[test]
fn observations_go_before_previews_on_a_narrow_link() {
    let mut house = camera_node::house();
    let router = house.router("router", &[]);
    let proxy = FaultProxy::start(&router);
    let far = Bus::open(&BusOptions::client_of(&router)).expect("a router");
    let camera = CAMERA.parse().expect("an id");
    let longest = limits::MAX_PAYLOAD_BYTES;
    let keys = [
        house.keys.observations(&camera),
        house.keys.preview(&camera),
    ];
    let [observations, previews] = keys.map(|key| {
        let subscribed = far.subscribe(&key, 4096, DropRule::Oldest, longest);
        subscribed.expect("a subscription")
    });
    let prefix = format!("n{}", std::process::id());
    let text = camera_node::write_files(&house, &proxy.endpoint, &prefix);
    let text = format!("{text}[preview]\nrate_hz = 10.0\nquality = 90\n");
    house.node(CAMERA, "camera", &text);
    assert!(previews.recv_timeout(system_tests::PATIENCE).is_some());
    proxy.set(Faults {
        bytes_per_s: BYTES_PER_S,
        ..Faults::default()
    });
    while observations.try_recv().is_some() || previews.try_recv().is_some() {}
    let mut arrived = Arrived::default();
    let (mut bytes, end) = ([0; 2], Instant::now() + lasting(60, 10));
    while Instant::now() < end {
        if let Some(item) = observations.recv_timeout(Duration::from_millis(5)) {
            let seen: Observations = item.decode().expect("observations");
            let age_ms = now_ns().saturating_sub(seen.capture_ns) as f64 * 1e-6;
            arrived.observations.push((seen.sequence, age_ms));
            bytes[0] += item.bytes().map_or(0, <[u8]>::len);
        }
        while let Some(item) = previews.try_recv() {
            arrived.previews += 1;
            bytes[1] += item.bytes().map_or(0, <[u8]>::len);
        }
    }
    println!(
        "{} observations, {} previews, {bytes:?} bytes",
        arrived.observations.len(),
        arrived.previews
    );
    for (what, value, unit, at_most) in [
        ("observations lost", arrived.lost_percent(), "%", 1.0),
        (
            "oldest observation on arrival",
            arrived.oldest_ms(),
            "ms",
            500.0,
        ),
    ] {
        Figure {
            row: ROW,
            what,
            value,
            unit,
            at_most,
        }
        .keep();
    }
    assert!(arrived.previews > 0, "previews pass where there is room");
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
