//! Members of a protected site who send what they may not, and one whose keys were revoked.

use super::*;
use sextant_proto::{Keys, ObjectPose, Observations, encode, limits};
use sextant_zenoh_bus::{Bus, DropRule, Profile, Qos, RawPublisher, Subscription};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::JoinHandle;
use system_tests::LockedSite;

const ROW: &str = "intruders on a protected site";

/// The cameras of a protected site, each with its own keys, in a thread.
struct OwnCameras {
    stop: Arc<AtomicBool>,
    thread: Option<JoinHandle<Vec<Observations>>>,
    start_ns: u64,
}

impl OwnCameras {
    fn start(site: &LockedSite) -> Self {
        let mut scene = site.scene.clone();
        let n = scene.rig.cameras().len();
        let names = scene.rig.cameras().iter().map(|one| one.id.to_string());
        let places: Vec<(Bus, RawPublisher)> = names
            .map(|name| {
                let bus = site.open(&name);
                let key = site.keys.observations(&name.parse().expect("an id"));
                let publisher = bus.raw_publisher(&key, Qos::Observation);
                (bus, publisher.expect("a publisher"))
            })
            .collect();
        let (stop, start_ns) = (Arc::new(AtomicBool::new(false)), now_ns());
        let stopped = Arc::clone(&stop);
        let thread = std::thread::spawn(move || {
            let mut sent = Vec::new();
            for turn in 0.. {
                let at_ns = start_ns + turn * 1_000_000_000 / 30 / n as u64;
                std::thread::sleep(Duration::from_nanos(at_ns.saturating_sub(now_ns())));
                if stopped.load(Ordering::Relaxed) {
                    break;
                }
                let camera = turn as usize % n;
                let seconds = (at_ns - start_ns) as f64 * 1e-9;
                let mut seen = scene.observe(camera, seconds, at_ns);
                seen.sequence = turn / n as u64;
                let _ = places[camera].1.put(&encode(&seen).expect("a message"));
                sent.push(seen);
            }
            sent
        });
        Self {
            stop,
            thread: Some(thread),
            start_ns,
        }
    }

    /// What they have sent.
    fn end(&mut self) -> Vec<Observations> {
        self.stop.store(true, Ordering::Relaxed);
        let thread = self.thread.take();
        thread.map_or_else(Vec::new, |thread| thread.join().expect("it ends"))
    }
}

impl Drop for OwnCameras {
    fn drop(&mut self) {
        self.end();
    }
}

/// Puts a message on a key as often as asked.
fn flood(bus: &Bus, key: &str, payload: &[u8], times: usize) {
    let publisher = bus.raw_publisher(key, Qos::Config).expect("a publisher");
    for _ in 0..times {
        // A refused session may be closed.
        let _ = publisher.put(payload);
    }
}

/// Observations of nothing that is so, under the name of a camera.
fn forged(site: &LockedSite, camera: usize) -> Observations {
    let mut scene = site.scene.clone();
    let mut seen = scene.observe(camera, 0.0, now_ns());
    let mut random = Random::from_keys(&[30]);
    for corner in seen.tags.iter_mut().flat_map(|tag| &mut tag.corners) {
        *corner = corner.map(|pixels| pixels + random.between(-40.0, 40.0) as f32);
    }
    seen
}

/// A member who may read sends again what cameras have sent since the last time; how many messages.
fn replay(member: &Bus, heard: &Subscription) -> usize {
    let items = std::iter::from_fn(|| heard.try_recv());
    let replayed = items.take(200).map(|item| {
        flood(member, &item.key, item.bytes().expect("a message"), 1);
    });
    replayed.count()
}

/// How many denied messages a router names or counts in its log: a line each, or the number of lines left out.
fn denied(log: &str) -> usize {
    let lines = log
        .lines()
        .filter(|line| line.contains("may not publish on"));
    let left_out = |line: &str| {
        let (_, rest) = line.split_once("] (")?;
        rest.split_once(" like this left out)")?
            .0
            .parse::<usize>()
            .ok()
    };
    lines.map(|line| 1 + left_out(line).unwrap_or(0)).sum()
}

/// A member forges what it may not send: another's observations, poses, the rig.
fn forge(site: &LockedSite, member: &Bus, keys: &Keys) {
    for camera in 0..2 {
        let seen = forged(site, camera);
        let key = keys.observations(&seen.camera);
        flood(member, &key, &encode(&seen).expect("a message"), 100);
    }
    let pose = keys.pose(site.scene.objects[0].id());
    flood(member, &pose, b"no pose", 100);
    flood(member, &keys.config_rig(), b"no rig", 10);
}

#[test]
fn forged_and_repeated_messages_change_nothing() {
    let mut site = LockedSite::start(Profile::Site);
    // A third member, whose keys are taken back.
    site.change_members(&["add", "former", "--role", "operator"]);
    let former = site.path("former");
    std::fs::rename(site.keys_of("former"), &former).expect("keys");
    site.change_members(&["revoke", "former"]);
    site.restart();

    let screen = site.open("screen");
    let witness = Witness::new(site.open("screen"), &site.keys);
    let mut cameras = OwnCameras::start(&site);
    site.await_status(&screen, |status| {
        status
            .objects
            .iter()
            .all(|one| one.state == State::Tracking)
            && !status.objects.is_empty()
    });
    let since = Instant::now();
    let start_ns = cameras.start_ns;
    let is_wrong = |pose: &ObjectPose| {
        let seconds = (pose.capture_ns as f64 - start_ns as f64) * 1e-9;
        let truth = system_tests::place(0, seconds).translation.vector;
        let error_m = (truth - nalgebra::Vector3::from(pose.position)).norm();
        pose.state == State::Tracking && error_m > 0.02
    };
    let begun = Instant::now();
    let intruders = [site.open("screen"), site.open_with(&former)];
    let heard = screen.subscribe(
        &site.keys.all_observations(),
        256,
        DropRule::Oldest,
        limits::MAX_PAYLOAD_BYTES,
    );
    let heard = heard.expect("a subscription");
    let mut replayed = 0;
    while begun.elapsed() < lasting(20, 3) {
        replayed += replay(&intruders[0], &heard);
        for intruder in &intruders {
            forge(&site, intruder, &site.keys);
        }
        std::thread::sleep(Duration::from_millis(100));
    }
    let sights = witness.used_since(since);
    let sent = cameras.end();
    let gap_ms = longest_gap_of_any_ms(&sights, since);
    let wrong = sights.iter().filter(|one| is_wrong(&one.pose)).count();

    // Whatever was put on a link before is decided on before this.
    let last = &sent[sent.len() - 1];
    let status = site.await_status(&screen, |status| {
        status
            .cameras
            .iter()
            .any(|one| one.last_capture_ns >= last.capture_ns)
    });
    let own = |camera: &sextant_site_model::CameraId| {
        sent.iter().filter(|one| one.camera == *camera).count() as u64
    };
    let accepted: u64 = (status.cameras.iter())
        .map(|one| one.received.saturating_sub(own(&one.camera)))
        .sum();
    assert!(replayed > 0, "cameras were heard");
    let named = denied(&site.log());
    println!("{replayed} replayed; {named} denied messages named or counted so far");
    assert!(named > 0, "denied messages are named: {}", site.log());
    let changes = site.log().matches("a change of the site").count();
    for (what, value, unit, at_most) in [
        (
            "forged or replayed observations accepted",
            accepted as f64,
            "",
            0.0,
        ),
        ("forged changes answered", changes as f64, "", 0.0),
        ("poses tracked and wrong", wrong as f64, "", 0.0),
        ("longest gap", gap_ms, "ms without a pose", 150.0),
    ] {
        Figure {
            row: ROW,
            what,
            value,
            unit,
            at_most,
        }
        .keep();
        assert!(!unit.is_empty() || value <= at_most, "{what}: {value}");
    }
}
