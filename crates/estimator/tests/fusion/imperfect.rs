//! Sites whose files are wrong by what nobody gives a sigma for, as files of real sites are.

use nalgebra::{UnitQuaternion, Vector3};
use sextant_estimator::{Fusion, FusionOptions, Input};
use sextant_geometry::{Pose, se3};
use sextant_site_model::{Camera, ObjectModel, ObjectTag, Rig};
use sextant_site_report::{Imperfection, ObjectEstimate, State};

use crate::scene::{
    self, Eye, PERIOD_NS, Random, START_NS, cube, error, feed, fusion, path, path_at, rig, run,
};

fn vector(random: &mut Random, sigma: f64) -> Vector3<f64> {
    Vector3::from_fn(|_, _| random.gauss() * sigma)
}

fn off(pose: &Pose, position_m: f64, orientation_rad: f64, random: &mut Random) -> Pose {
    let turn = UnitQuaternion::from_scaled_axis(vector(random, orientation_rad));
    let place = pose.translation.vector + vector(random, position_m);
    Pose::from_parts(place.into(), turn * pose.rotation)
}

/// The rig as somebody measured it by hand.
pub fn measured(rig: &Rig, position_m: f64, orientation_rad: f64, random: &mut Random) -> Rig {
    let camera = |camera: &Camera| Camera {
        world_from_camera: camera
            .world_from_camera
            .map(|pose| off(&pose, position_m, orientation_rad, random)),
        ..scene::unstated(camera)
    };
    Rig::new(rig.cameras().iter().map(camera).collect()).unwrap()
}

/// The object with tags glued on by hand.
pub fn glued(
    object: &ObjectModel,
    position_m: f64,
    orientation_rad: f64,
    random: &mut Random,
) -> ObjectModel {
    let tag = |tag: &ObjectTag| {
        let pose = tag.object_from_tag;
        let glued = pose.map(|pose| off(&pose, position_m, orientation_rad, random));
        ObjectTag::new(tag.tag, tag.size_m, glued)
    };
    ObjectModel::new(object.id().clone(), object.tags().iter().map(tag).collect()).unwrap()
}

/// The models as files have them that give no priors.
pub fn files(rig: &Rig, object: &ObjectModel) -> (Rig, ObjectModel) {
    let tag = |tag: &ObjectTag| ObjectTag::new(tag.tag, tag.size_m, tag.object_from_tag);
    let tags = object.tags().iter().map(tag).collect();
    let rig = Rig::new(rig.cameras().iter().map(scene::unstated).collect());
    let object = ObjectModel::new(object.id().clone(), tags);
    (rig.unwrap(), object.unwrap())
}

/// What is published of images that all cameras take at once.
pub fn watched(
    fusion: &mut Fusion,
    rig: &Rig,
    object: &ObjectModel,
    n_instants: u64,
    random: &mut Random,
) -> Vec<ObjectEstimate> {
    let eye = Eye {
        rig,
        object,
        sigma_px: 0.05,
    };
    let mut last = Vec::new();
    for instant in 0..n_instants {
        let time_ns = START_NS + instant * PERIOD_NS;
        let mut poses = Vec::new();
        for camera in 0..rig.cameras().len() {
            let image = eye.image(camera, time_ns, &path_at(time_ns), random);
            poses.extend(feed(fusion, image));
        }
        last.extend(poses.pop());
    }
    last
}

/// Worst error of the way between a pose and the eighth after it, m: no frame of world or object matters for it.
fn worst_way_error(poses: &[ObjectEstimate]) -> f64 {
    let way = |from: &Pose, to: &Pose| from.translation.vector - to.translation.vector;
    let pairs = poses.iter().zip(poses.iter().skip(8));
    let errors = pairs.map(|(a, b)| {
        let seen = way(&a.world_from_object, &b.world_from_object).norm();
        let true_way = way(&path_at(a.capture_ns), &path_at(b.capture_ns)).norm();
        (seen - true_way).abs()
    });
    errors.fold(0.0, f64::max)
}

#[test]
fn cameras_placed_by_hand_are_corrected_within_a_second() {
    for seed in 1..5 {
        let random = &mut Random(seed);
        let (truth, object) = (rig(4), cube());
        let configured = measured(&truth, 0.005, 0.005, random);
        let mut with = fusion(&configured, &object, FusionOptions::default());
        let mut without = fusion(
            &configured.clone().exact(),
            &object,
            FusionOptions::default(),
        );
        let learned = watched(&mut with, &truth, &object, 90, &mut Random(seed));
        let as_given = watched(&mut without, &truth, &object, 90, &mut Random(seed));
        let (learned, as_given) = [&learned, &as_given]
            .map(|all| worst_way_error(&all[30..]))
            .into();
        assert!(learned < 0.001, "seed {seed}: {learned} m");
        assert!(
            as_given > learned,
            "seed {seed}: {as_given} against {learned} m"
        );
        let named = with.imperfections().into_iter();
        let mut named = named.filter(|one| matches!(one, Imperfection::CamerasDisagree { .. }));
        assert!(
            named.next().is_some(),
            "seed {seed}: {:?}",
            with.imperfections()
        );
        assert_eq!(with.faults(), [], "seed {seed}");
    }
}

#[test]
fn tags_glued_on_by_hand_leave_honest_poses() {
    let mut all = Vec::new();
    for seed in 1..13 {
        let random = &mut Random(seed);
        let (truth, object) = (rig(4), cube());
        let configured = glued(&object, 0.001, 0.017, random);
        let mut fusion = fusion(&truth, &configured, FusionOptions::default());
        let poses = watched(&mut fusion, &truth, &object, 45, random);
        assert!(poses.iter().all(|pose| pose.state == State::Tracking));
        let last = poses.last().unwrap();
        let error = error(last, &path_at(last.capture_ns));
        let inverse = last.covariance.try_inverse().unwrap();
        all.push(error.dot(&(inverse * error)) / 6.0);
    }
    let nees = all.iter().sum::<f64>() / all.len() as f64;
    assert!((0.3..3.0).contains(&nees), "NEES {nees} of {all:?}");
}

#[test]
fn exact_files_are_recognised_with_the_first_images() {
    let (rig, object) = (rig(3), cube());
    let (files, tags) = files(&rig, &object);
    let mut known = fusion(&rig, &object, FusionOptions::default());
    let mut learned = fusion(&files, &tags, FusionOptions::default());
    let known = watched(&mut known, &rig, &object, 60, &mut Random(3));
    let found = watched(&mut learned, &rig, &object, 60, &mut Random(3));
    assert_eq!(learned.imperfections(), []);
    for (known, found) in known.iter().zip(&found).skip(15) {
        let apart = se3::difference(&known.world_from_object, &found.world_from_object);
        assert!(
            apart.norm() < 2e-5,
            "{} at {}",
            apart.norm(),
            known.capture_ns
        );
        assert!(found.covariance.trace() < 1.2 * known.covariance.trace());
    }
}

/// The body is struck by so much that nothing predicted holds, before the only camera.
#[test]
fn a_hit_body_has_a_pose_in_the_very_next_image() {
    let (rig, object) = (rig(1), cube());
    let mut fusion = fusion(&rig, &object, FusionOptions::default());
    let eye = Eye {
        rig: &rig,
        object: &object,
        sigma_px: 0.05,
    };
    let struck = Pose::new(
        Vector3::new(0.06, -0.05, 0.03),
        Vector3::new(0.5, -0.4, 0.9),
    );
    let random = &mut Random(7);
    for instant in 0..60 {
        let time_ns = START_NS + instant * PERIOD_NS;
        let still = path(0.2);
        let truth = if instant < 40 { still } else { struck * still };
        let poses = feed(&mut fusion, eye.image(0, time_ns, &truth, random));
        if instant >= 40 {
            let pose = poses
                .last()
                .map(|pose| (pose.state, error(pose, &truth).norm()));
            let is_there =
                pose.is_some_and(|(state, error)| state == State::Tracking && error < 0.05);
            assert!(is_there, "instant {instant}: {pose:?}");
        }
    }
}

/// Cameras whose shutters run free see a moving body at different times: no reason to move the cameras.
#[test]
fn exact_files_are_recognised_where_shutters_run_free() {
    let (rig, object) = (rig(4), cube());
    let (files, tags) = files(&rig, &object);
    let mut learned = fusion(&files, &tags, FusionOptions::default());
    let mut worst: f64 = 0.0;
    for mut image in run(&rig, &object, 0.05, 4.0, &mut Random(5)) {
        image.clock_error_ns = 0;
        let late = image.capture_ns > START_NS + 1_000_000_000;
        for pose in feed(&mut learned, image).into_iter().filter(|_| late) {
            worst = worst.max(
                error(&pose, &path_at(pose.capture_ns))
                    .fixed_rows::<3>(0)
                    .norm(),
            );
        }
    }
    assert_eq!(learned.imperfections(), []);
    assert!(worst < 0.001, "{worst} m");
}

#[test]
fn corrections_outlive_a_clock_that_is_found_to_be_off() {
    for seed in 1..4 {
        let random = &mut Random(seed);
        let (truth, object) = (rig(4), cube());
        let configured = measured(&truth, 0.01, 0.01, random);
        let mut fusion = fusion(&configured, &object, FusionOptions::default());
        let mut tracked = Vec::new();
        for mut image in run(&truth, &object, 0.05, 8.0, random) {
            let arrival_ns = image.capture_ns + 10_000_000;
            if image.camera == scene::camera_id(1) && image.capture_ns > START_NS + 4_000_000_000 {
                image.capture_ns -= 200_000_000;
            }
            fusion.handle(arrival_ns, Input::Image(image));
            let poses = scene::poses(&mut fusion).into_iter();
            tracked.extend(poses.filter(|pose| pose.state == State::Tracking));
        }
        assert!(!fusion.clock_offsets().is_empty(), "seed {seed}");
        let since_ns = START_NS + 5_000_000_000;
        tracked.retain(|pose| pose.capture_ns >= since_ns);
        assert!(tracked.len() > 350, "seed {seed}: {} poses", tracked.len());
        let worst = worst_way_error(&tracked);
        assert!(worst < 0.001, "seed {seed}: {worst} m");
    }
}
