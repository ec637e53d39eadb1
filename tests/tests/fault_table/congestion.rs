//! A camera node whose link carries its observations, but not also all of its previews.

use super::*;
use crate::camera_node::CAMERA;
use sextant_proto::{Observations, limits};
use sextant_zenoh_bus::{Bus, BusOptions, DropRule};

const ROW: &str = "link of a camera too narrow for its previews";
/// Observations take a fifth of it, previews would take three times as much.
const BYTES_PER_S: u32 = 32_000;

/// What arrived, by the router's clock.
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
