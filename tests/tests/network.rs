//! A network that delays, shuffles, doubles and loses, and cuts one camera off for a while: the poses stay true, what
//! did not come in or came too late is counted, and the camera that is gone is named until it is back.
//!
//! The faults are the simulator's, drawn from a seed; arrivals are in the simulator's order however slow this machine
//! is.

#![allow(clippy::expect_used, reason = "a test ends by panicking")]

use nalgebra::Matrix6;
use sextant_evaluation::{Consistency, PoseError};
use sextant_process::now_ns;
use sextant_proto::{FusionStatus, Notice, ObjectPose, Observations};
use sextant_simulator::{Arrival, Network, NetworkFaults, Scenario};
use sextant_site_report::State;
use sextant_zenoh_bus::Subscription;
use std::time::Duration;
use system_tests::{FusedSite, Scene, place};

const CAMERAS: usize = 3;
const SECONDS: f64 = 8.5;
const OBJECTS: [&str; 2] = ["box", "cube"];
/// From image to message.
const DETECTING_NS: u64 = 5_000_000;
/// The camera that is cut off, and when.
const CUT_OFF: usize = 2;
const CUT_OFF_S: [f64; 2] = [1.5, 6.0];
/// A message of the first camera that is held back comes after the estimator's window of 0.5 s.
const HELD_MS: f64 = 800.0;
const WINDOW_NS: u64 = 500_000_000;

/// What the network does to a camera.
fn faults(camera: usize) -> NetworkFaults {
    NetworkFaults {
        loss: 0.1,
        delay_ms: 30.0,
        jitter_ms: 10.0,
        reorder: 0.05,
        reorder_ms: if camera == 0 { HELD_MS } else { 80.0 },
        duplicate: 0.05,
        partition_s: if camera == CUT_OFF {
            CUT_OFF_S
        } else {
            [0.0; 2]
        },
    }
}

/// The images of all cameras as the network hands them over, and how many it lost.
fn arrivals(scene: &mut Scene, start_ns: u64) -> (Vec<Arrival<Observations>>, u64) {
    let mut scenario = Scenario::demo(CAMERAS, 1, 11);
    for (index, camera) in scenario.cameras.iter_mut().enumerate() {
        camera.network = faults(index);
    }
    let mut network = Network::new(&scenario);
    for image in 0..(SECONDS * 30.0) as u64 {
        for camera in 0..CAMERAS {
            let at_ns = image * 33_333_333 + camera as u64 * 9_123_457;
            let taken_ns = start_ns + at_ns;
            let seen = scene.observe(camera, at_ns as f64 * 1e-9, taken_ns);
            network.send(camera, taken_ns + DETECTING_NS, taken_ns, seen);
        }
    }
    let arrived = std::iter::from_fn(|| network.receive(u64::MAX)).collect();
    (arrived, network.lost())
}

/// Images of a camera that come when its window is past.
fn too_late(arrived: &[Arrival<Observations>], camera: usize) -> u64 {
    let mut newest_ns = 0;
    let own = arrived.iter().filter(|arrival| arrival.camera == camera);
    let late = own.filter(|arrival| {
        newest_ns = newest_ns.max(arrival.capture_ns);
        arrival.capture_ns + WINDOW_NS < newest_ns
    });
    late.count() as u64
}

fn heard<M: sextant_proto::Message>(subscription: &Subscription) -> Vec<M> {
    let items = std::iter::from_fn(|| subscription.try_recv());
    items.filter_map(|item| item.decode().ok()).collect()
}

/// The error of a pose, and its NEES.
fn error_of(pose: &ObjectPose, start_ns: u64) -> (PoseError, f64) {
    let name = pose.object.as_str();
    let index = OBJECTS.iter().position(|object| *object == name);
    let seconds = (pose.capture_ns - start_ns) as f64 * 1e-9;
    let truth = place(index.expect("one of ours"), seconds);
    let error = PoseError::between(&pose.world_from_object(), &truth);
    let covariance = Matrix6::from_row_slice(&pose.covariance);
    (error, error.nees(&covariance).expect("a covariance"))
}

#[test]
fn poses_stay_true_through_a_bad_network_and_a_camera_that_goes_and_comes_back() {
    let mut scene = Scene::new(CAMERAS, &OBJECTS);
    let mut site = FusedSite::start(&scene.rig, &scene.objects, "");
    let poses = site.listen(&site.keys.all_poses());
    let statuses = site.listen(&site.keys.all_fusion_statuses());
    let start_ns = now_ns();
    let (arrived, lost) = arrivals(&mut scene, start_ns);
    for arrival in &arrived {
        std::thread::sleep(Duration::from_nanos(
            arrival.arrival_ns.saturating_sub(now_ns()),
        ));
        site.publish(&arrival.payload);
    }
    let count = |camera: usize| arrived.iter().filter(|one| one.camera == camera).count() as u64;
    let last = site.await_status(|status| {
        let received = status.cameras.iter().map(|camera| camera.received);
        received.eq((0..CAMERAS).map(count))
    });
    assert_counted(&last, &arrived, lost);
    assert_true(&heard(&poses), start_ns);
    assert_named(&heard(&statuses));
}

/// All that came is received, what came too late is said to have, and the rest was lost on its way.
fn assert_counted(last: &FusionStatus, arrived: &[Arrival<Observations>], lost: u64) {
    let sent = (SECONDS * 30.0) as u64 * CAMERAS as u64;
    let doubled = arrived.len() as u64 + lost - sent;
    assert!(lost > 100 && doubled > 10, "{lost} {doubled}");
    for (index, camera) in last.cameras.iter().enumerate() {
        assert_eq!(camera.rejected.total(), 0, "{camera:?}");
        let late = too_late(arrived, index);
        assert_eq!(late > 0, index == 0);
        assert!(camera.late >= late, "{late}: {camera:?}");
    }
}

/// Never lost, never off, and as sure as they should be.
fn assert_true(poses: &[ObjectPose], start_ns: u64) {
    let settled_ns = start_ns + 1_000_000_000;
    let settled = poses.iter().filter(|pose| pose.capture_ns > settled_ns);
    let settled: Vec<&ObjectPose> = settled.collect();
    assert!(settled.len() > 500, "{}", settled.len());
    let (mut consistency, mut worst_mm) = (Consistency::default(), 0.0_f64);
    for pose in &settled {
        assert_eq!(pose.state, State::Tracking, "{pose:?}");
        let (error, nees) = error_of(pose, start_ns);
        consistency.add(nees);
        worst_mm = worst_mm.max(error.position_m() * 1e3);
    }
    let share = consistency.within_95();
    println!(
        "{} poses, {share:.3} inside, at most {worst_mm:.2} mm",
        settled.len()
    );
    assert!(worst_mm < 5.0, "{worst_mm} mm");
    assert!(share > 0.88, "{share}");
}

/// The camera that was cut off is named while it was, and nothing else is said to be wrong.
fn assert_named(statuses: &[FusionStatus]) {
    let cut_off = format!("cam{CUT_OFF}");
    let is_silent = |notice: &Notice| match notice {
        Notice::CameraSilent { camera, .. } => camera.as_str() == cut_off,
        _ => false,
    };
    let is_named = |status: &FusionStatus| status.notices.iter().any(is_silent);
    let named = statuses.iter().position(is_named);
    let named = named.expect("the camera is named while it is gone");
    assert_eq!(statuses[named].cameras[CUT_OFF].rate_hz, 0.0);
    let back = |status: &FusionStatus| !is_named(status) && status.cameras[CUT_OFF].rate_hz > 0.0;
    assert!(statuses[named..].iter().any(back), "{:?}", statuses.last());
    // This network is bad enough for images that are too late, which is said, too.
    let is_late = |notice: &Notice| matches!(notice, Notice::LateObservations { .. });
    for status in statuses {
        let mut others = status.notices.iter();
        assert_eq!(others.find(|one| !is_silent(one) && !is_late(one)), None);
        assert!(status.faults.is_empty(), "{:?}", status.faults);
        assert!(
            status.imperfections.is_empty(),
            "{:?}",
            status.imperfections
        );
    }
}
