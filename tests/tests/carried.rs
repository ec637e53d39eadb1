//! Cameras that a robot carries: from posts with tags that stand in the room, the fusion node finds where the robot is.
//! The files of posts and mounts are off.
//!
//! The test stands in the place of the cameras, in the pace of the clock.

#![allow(clippy::expect_used, reason = "a test ends by panicking")]

use nalgebra::{Matrix3, Rotation3, UnitQuaternion, Vector3};
use sextant_geometry::{Intrinsics, Lens, Pose};
use sextant_process::now_ns;
use sextant_proto::{ObjectPose, State};
use sextant_simulator::Random;
use sextant_site_model::{Camera, CameraId, Mount, ObjectId, ObjectModel, Rig};
use std::f64::consts::{FRAC_PI_2, TAU};
use std::time::Duration;
use system_tests::{FusedSite, Scene};

const POSTS: [&str; 6] = ["p0", "p1", "p2", "p3", "p4", "p5"];
const SECONDS: f64 = 8.0;
/// What is learned of the files is learned by then.
const SETTLED_S: f64 = 3.0;
const PERIOD_NS: u64 = 33_333_333;

/// The robot drives in a circle and looks about.
fn world_from_robot(seconds: f64) -> Pose {
    let along = 0.8 * seconds;
    let at = Vector3::new(0.35 * along.cos(), 0.35 * along.sin(), 0.2);
    let turn = UnitQuaternion::from_euler_angles(
        0.05 * (2.0 * seconds).sin(),
        0.05 * (1.7 * seconds).cos(),
        along + 0.4 * seconds.sin(),
    );
    Pose::from_parts(at.into(), turn)
}

/// Cameras that look ahead and to the left; their z is the way they look, their y is down.
fn robot_from_camera(k: usize) -> Pose {
    let ahead = Matrix3::new(0.0, 0.0, 1.0, -1.0, 0.0, 0.0, 0.0, -1.0, 0.0);
    let ahead = UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(ahead));
    let left = UnitQuaternion::from_euler_angles(0.0, 0.0, FRAC_PI_2 * k as f64);
    Pose::from_parts((left * Vector3::new(0.1, 0.0, 0.05)).into(), left * ahead)
}

fn world_from_post(k: usize) -> Pose {
    let angle = TAU * k as f64 / POSTS.len() as f64;
    let at = Vector3::new(1.2 * angle.cos(), 1.2 * angle.sin(), 0.15 * (k % 3) as f64);
    let turn = UnitQuaternion::from_euler_angles(0.2, 0.1, angle + 0.6);
    Pose::from_parts(at.into(), turn)
}

fn camera(k: usize) -> Camera {
    let intrinsics = Intrinsics {
        fx: 420.0,
        fy: 420.0,
        cx: 319.5,
        cy: 239.5,
    };
    let lens = Lens::pinhole(intrinsics).expect("a lens");
    Camera::new(
        CameraId::new(&format!("eye{k}")).expect("an id"),
        [640, 480],
        lens,
        None,
    )
}

/// The pose as a tape measure and a protractor give it.
fn by_hand(random: &mut Random, pose: Pose) -> Pose {
    let mut errors = |sigma: f64| Vector3::from_fn(|_, _| sigma * random.normal());
    let turn = UnitQuaternion::from_scaled_axis(errors(0.004));
    pose * Pose::from_parts(errors(0.002).into(), turn)
}

/// Rig and objects as the files have them.
fn files(posts: &[ObjectModel]) -> (Rig, Vec<ObjectModel>) {
    let mut random = Random::new(5);
    let carrier = ObjectId::new("robot").expect("an id");
    let cameras = (0..2).map(|k| Camera {
        mount: Some(Mount {
            carrier: carrier.clone(),
            carrier_from_camera: by_hand(&mut random, robot_from_camera(k)),
        }),
        ..camera(k)
    });
    let rig = Rig::new(cameras.collect()).expect("a rig");
    let stands = |(k, post): (usize, &ObjectModel)| {
        let pose = by_hand(&mut random, world_from_post(k));
        post.clone()
            .with_world_from_object(Some(pose))
            .expect("a pose")
    };
    (rig, posts.iter().enumerate().map(stands).collect())
}

/// The frame that the mounts of the files have on average, in that of the robot: nothing tells of an error that all of
/// them share.
fn robot_from_mounts(rig: &Rig) -> Pose {
    let cameras = rig.cameras().iter().enumerate();
    let frames = cameras.filter_map(|(k, camera)| {
        let mount = camera.mount.as_ref()?;
        Some(robot_from_camera(k) * mount.carrier_from_camera.inverse())
    });
    let (mut shift, mut turn) = (Vector3::zeros(), Vector3::zeros());
    for frame in frames {
        shift += frame.translation.vector / rig.cameras().len() as f64;
        turn += frame.rotation.scaled_axis() / rig.cameras().len() as f64;
    }
    Pose::from_parts(shift.into(), UnitQuaternion::from_scaled_axis(turn))
}

/// Drives the robot about; what is published of it, each with how long after the start it was seen.
fn drive(site: &mut FusedSite, posts: &[ObjectModel]) -> Vec<(f64, ObjectPose)> {
    let poses = site.listen(&site.keys.all_poses());
    let start_ns = now_ns();
    let mut truth = Scene::from_models(
        Rig::new(vec![camera(0), camera(1)]).expect("a rig"),
        Vec::new(),
    );
    let placed: Vec<_> = posts
        .iter()
        .enumerate()
        .map(|(k, post)| (post, world_from_post(k)))
        .collect();
    for image in 0..(SECONDS * 1e9) as u64 / PERIOD_NS {
        for k in 0..2 {
            // Nothing triggers the cameras together.
            let at_ns = image * PERIOD_NS + k as u64 * 11_200_000;
            let world_from_camera = world_from_robot(at_ns as f64 * 1e-9) * robot_from_camera(k);
            let seeing = |other: usize| Camera {
                world_from_camera: Some(world_from_camera),
                ..camera(other)
            };
            truth.rig = Rig::new(vec![seeing(0), seeing(1)]).expect("a rig");
            let seen = truth.see(k, &placed, start_ns + at_ns);
            std::thread::sleep(Duration::from_nanos(
                (start_ns + at_ns).saturating_sub(now_ns()),
            ));
            site.publish(&seen);
        }
    }
    let mut found = Vec::new();
    while let Some(item) = poses.recv_timeout(Duration::from_millis(500)) {
        let pose: ObjectPose = item.decode().expect("a pose");
        let seconds = pose.capture_ns.saturating_sub(start_ns) as f64 * 1e-9;
        if pose.object.as_str() == "robot" {
            found.push((seconds, pose));
        }
    }
    found
}

#[test]
fn a_robot_is_found_by_the_cameras_that_it_carries() {
    let posts = Scene::new(1, &POSTS).objects;
    let (rig, objects) = files(&posts);
    let mut site = FusedSite::start(&rig, &objects, "");
    let found = drive(&mut site, &posts);
    let frame = robot_from_mounts(&rig);
    let mut errors_m = Vec::new();
    let mut within = 0;
    for (seconds, pose) in &found {
        if *seconds < SETTLED_S || pose.state != State::Tracking {
            continue;
        }
        let truth = (world_from_robot(*seconds) * frame).translation.vector;
        let error = Vector3::from(pose.position) - truth;
        let covariance = Matrix3::from_fn(|row, column| pose.covariance[6 * row + column]);
        let inverse = covariance.try_inverse().expect("a covariance");
        // chi-squared with 3 degrees of freedom.
        within += usize::from((error.transpose() * inverse * error).x < 7.81);
        errors_m.push(error.norm());
    }
    errors_m.sort_by(f64::total_cmp);
    let n = errors_m.len();
    let share = within as f64 / n as f64;
    println!(
        "{n} poses, median {:.2} mm, worst {:.2} mm, {share:.2} within",
        1e3 * errors_m[n / 2],
        1e3 * errors_m[n - 1]
    );
    // Both cameras see some post nearly always.
    assert!(n as f64 > 0.8 * (SECONDS - SETTLED_S) * 60.0, "{n} poses");
    assert!(errors_m[n / 2] < 0.01 && errors_m[n - 1] < 0.025);
    assert!(share > 0.8);

    let listed = site.run_command(&["list", "--json"]);
    let listed = String::from_utf8_lossy(&listed.stdout).into_owned();
    assert!(listed.contains("\"robot\""), "{listed}");
}
