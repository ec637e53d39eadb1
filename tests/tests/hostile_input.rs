//! What a broken or hostile sender puts on an observation key is counted and reported, and changes nothing else.

#![allow(clippy::expect_used, reason = "a test ends by panicking")]

use sextant_proto::{FusionStatus, Keys, NodeId, Observations, Rejections, decode, encode, limits};
use sextant_site_model::CameraId;
use sextant_zenoh_bus::{Bus, BusOptions, DropRule, Item, Qos};
use std::time::{Duration, Instant};
use system_tests::Demo;

const PATIENCE: Duration = Duration::from_secs(30);

struct Site {
    keys: Keys,
    bus: Bus,
}

impl Site {
    fn connect(demo: &Demo) -> Self {
        let keys = Keys::new("demo").expect("an id");
        let bus =
            Bus::open(&BusOptions::client_of(&demo.connect)).expect("the demo's router answers");
        Self { keys, bus }
    }

    /// The first message on a key that has the wanted property.
    fn await_message(&self, key: &str, mut wanted: impl FnMut(&Item) -> bool) {
        let messages = self
            .bus
            .subscribe(key, 64, DropRule::Oldest, limits::MAX_PAYLOAD_BYTES)
            .expect("a subscription");
        let deadline = Instant::now() + PATIENCE;
        while Instant::now() < deadline {
            if messages
                .recv_timeout(Duration::from_millis(200))
                .is_some_and(|item| wanted(&item))
            {
                return;
            }
        }
        panic!("no such message on {key} within {PATIENCE:?}");
    }

    fn observation_of(&self, camera: &CameraId) -> (String, Vec<u8>) {
        let key = self.keys.observations(camera);
        let mut taken = Vec::new();
        self.await_message(&key, |item| {
            taken = item.bytes().unwrap_or_default().to_vec();
            decode::<Observations>(&taken).is_ok_and(|message| !message.tags.is_empty())
        });
        (key, taken)
    }
}

/// The bytes of an observation with a corner that is not a number, as only a broken sender makes them.
fn with_nan_corner(good: &[u8]) -> Vec<u8> {
    let message: Observations = decode(good).expect("a good observation");
    let corner = message.tags[0].corners[0][0].to_le_bytes();
    let at = good
        .windows(4)
        .position(|bytes| bytes == corner)
        .expect("the corner is in the bytes");
    let mut bad = good.to_vec();
    bad[at..at + 4].copy_from_slice(&f32::NAN.to_le_bytes());
    bad
}

fn intake_of(item: &Item, camera: &CameraId) -> Option<(u64, Rejections)> {
    let status: FusionStatus = decode(item.bytes()?).ok()?;
    let intake = status
        .cameras
        .into_iter()
        .find(|intake| &intake.camera == camera)?;
    Some((intake.received, intake.rejected))
}

#[test]
fn what_does_not_decode_is_counted_and_nothing_else_changes() {
    let demo = Demo::start(&["--cameras", "2", "--objects", "1"]);
    let site = Site::connect(&demo);
    let camera = demo
        .processes
        .iter()
        .find_map(|(name, _)| name.strip_prefix("capture-"))
        .expect("a camera");
    let camera = CameraId::new(camera).expect("an id");
    let (key, good) = site.observation_of(&camera);

    let mut foreign = good.clone();
    foreign[1] = foreign[1].wrapping_add(1);
    let mut impostor: Observations = decode(&good).expect("a good observation");
    impostor.camera = CameraId::new("impostor").expect("an id");
    let hostile = site
        .bus
        .raw_publisher(&key, Qos::Config)
        .expect("a publisher");
    let garbage: Vec<u8> = (0..200_u8)
        .map(|k| k.wrapping_mul(151).wrapping_add(43))
        .collect();
    let cut = &good[..good.len() / 2];
    let long = vec![0x53; 1_000_000];
    for payload in [
        &garbage[..],
        cut,
        &foreign,
        &with_nan_corner(&good),
        &long,
        &encode(&impostor).expect("a message"),
    ] {
        hostile.put(payload).expect("the network takes it");
    }

    let mut received_before = None;
    let status_key = site
        .keys
        .fusion_status(&NodeId::new("fusion").expect("an id"));
    site.await_message(&status_key, |item| {
        let Some((received, rejected)) = intake_of(item, &camera) else {
            return false;
        };
        let expected = Rejections {
            bad_magic: 1,
            foreign_version: 1,
            wrong_kind: 0,
            damaged: 1,
            too_long: 1,
            out_of_range: 1,
            wrong_camera: 1,
        };
        let counted = rejected == expected;
        // All is counted, and the camera's own images still arrive.
        counted
            && received_before
                .replace(received)
                .is_some_and(|before| received > before)
    });
    demo.signal(libc::SIGINT);
    let ended = demo.wait();
    assert!(ended.status.success());
    let object = &ended.summary["objects"][0];
    assert!(
        object["position_rms_mm"]
            .as_f64()
            .is_some_and(|mm| mm < 3.0),
        "{}",
        ended.summary
    );
}
