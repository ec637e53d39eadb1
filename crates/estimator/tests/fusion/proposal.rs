//! A refined calibration is proposed where images that had no part in it are explained better by it.

use std::f64::consts::PI;

use nalgebra::{UnitQuaternion, Vector3};
use sextant_estimator::{Fusion, FusionOptions, Input, Proposal};
use sextant_geometry::{Pose, se3};
use sextant_site_model::{ImageObservation, ObjectModel, ObjectTag, Rig};
use sextant_site_report::State;

use crate::imperfect::{files, glued, measured, watched};
use crate::scene::{Random, START_NS, cube, feed, fusion, path_at, position_error, rig, run};

/// Half a minute of images.
const INSTANTS: u64 = 900;

/// Worst distance, in m and rad alike, of the first of some poses to the others against the truth: no common frame
/// matters for it.
fn worst_apart(poses: &[Pose], truth: &[Pose]) -> f64 {
    let apart = |poses: &[Pose], index: usize| poses[0].inverse() * poses[index];
    let off = |index| se3::difference(&apart(poses, index), &apart(truth, index)).amax();
    (1..poses.len()).map(off).fold(0.0, f64::max)
}

/// The same but for the common scale, of which images show nothing: the poses that were found, as far from one another
/// in the mean as the true ones.
fn worst_apart_unscaled(poses: &[Pose], truth: &[Pose]) -> f64 {
    let spread = |poses: &[Pose]| {
        let from_first =
            |pose: &Pose| (pose.translation.vector - poses[0].translation.vector).norm();
        poses.iter().map(from_first).sum::<f64>()
    };
    let scale = spread(truth) / spread(poses);
    let scaled = poses
        .iter()
        .map(|pose| Pose::from_parts((pose.translation.vector * scale).into(), pose.rotation));
    worst_apart(&scaled.collect::<Vec<_>>(), truth)
}

fn cameras(rig: &Rig) -> Vec<Pose> {
    let cameras = rig.cameras().iter();
    cameras.filter_map(|one| one.world_from_camera).collect()
}

fn tags(object: &ObjectModel) -> Vec<Pose> {
    let tags = object.tags().iter();
    tags.filter_map(|one| one.object_from_tag).collect()
}

/// The tags but the third, at the bottom of the cube.
fn seen(object: &ObjectModel) -> Vec<Pose> {
    let mut tags = tags(object);
    tags.remove(2);
    tags
}

fn proposed(fusion: &mut Fusion, rig: &Rig, object: &ObjectModel, seed: u64) -> Option<Proposal> {
    watched(fusion, rig, object, INSTANTS, &mut Random(seed));
    fusion.proposal()
}

#[test]
fn wrong_cameras_and_tags_are_proposed_nearer_to_the_truth() {
    let mut shares = Vec::new();
    for seed in 1..7 {
        let (truth, object) = (rig(4), cube());
        let random = &mut Random(seed);
        let configured = measured(&truth, 0.005, 0.005, random);
        let stuck = glued(&object, 0.001, 0.017, random);
        let mut machine = fusion(&configured, &stuck, FusionOptions::default());
        let proposal = proposed(&mut machine, &truth, &object, seed).unwrap();
        let held_back = proposal.held_back;
        assert!(held_back.n_images >= 8, "seed {seed}: {held_back:?}");
        assert!(
            held_back.after_px < 0.2 * held_back.before_px,
            "seed {seed}: {held_back:?}"
        );
        let rig = proposal.rig.as_ref().unwrap();
        let before = worst_apart_unscaled(&cameras(&configured), &cameras(&truth));
        let after = worst_apart_unscaled(&cameras(rig), &cameras(&truth));
        shares.push(after / before);
        let [model] = &proposal.objects[..] else {
            panic!("seed {seed}: {proposal:?}");
        };
        let [before, after] =
            [&stuck, model].map(|model| worst_apart(&seen(model), &seen(&object)));
        assert!(after < 0.3 * before, "seed {seed}: {after} of {before}");
        let sigmas = rig.cameras().iter().map(|camera| camera.pose_prior.given());
        assert!(sigmas.flatten().all(|sigma| sigma.position_m < 0.005));
        let (scale, frame) = (rig.scale_sigma().unwrap(), model.frame_sigma().unwrap());
        assert!((0.001..0.01).contains(&scale), "no image shows it: {scale}");
        assert!(
            (1e-4..1e-3).contains(&frame.position_m),
            "nor this: {frame:?}"
        );
        assert_eq!(machine.proposal(), Some(proposal), "asking changes nothing");
    }
    // Typically a twentieth is left; which instants are kept decides how well the worst camera is known.
    let mean = shares.iter().sum::<f64>() / shares.len() as f64;
    let is_nearer = shares.iter().all(|share| *share < 0.35);
    assert!(mean < 0.15 && is_nearer, "left of the errors: {shares:?}");
}

#[test]
fn cameras_that_nobody_triggers_are_compared_by_the_motion_between_their_images() {
    for seed in 1..4 {
        let (truth, object) = (rig(4), cube());
        let random = &mut Random(seed);
        let configured = measured(&truth, 0.003, 0.0035, random);
        let stuck = glued(&object, 0.0005, 0.009, random);
        let mut machine = fusion(&configured, &stuck, FusionOptions::default());
        for mut image in run(&truth, &object, 0.1, 8.0, random) {
            image.clock_error_ns = ImageObservation::CLOCK_ERROR_UNKNOWN;
            feed(&mut machine, image);
        }
        let rig = machine
            .proposal()
            .and_then(|proposal| proposal.rig)
            .unwrap();
        let before = worst_apart_unscaled(&cameras(&configured), &cameras(&truth));
        let after = worst_apart_unscaled(&cameras(&rig), &cameras(&truth));
        assert!(after < 0.5 * before, "seed {seed}: {after} of {before}");
        assert_eq!(machine.faults(), []);
    }
}

#[test]
fn tags_alone_are_corrected_without_moving_a_camera() {
    let (truth, object) = (rig(4), cube());
    let stuck = glued(&object, 0.001, 0.017, &mut Random(5));
    let (files, _) = files(&truth, &object);
    let mut machine = fusion(&files, &stuck, FusionOptions::default());
    let proposal = proposed(&mut machine, &truth, &object, 5).unwrap();
    assert_eq!(proposal.objects.len(), 1);
    let rig = proposal.rig.unwrap_or(files);
    let moved = worst_apart(&cameras(&rig), &cameras(&truth));
    assert!(moved < 0.0005, "{moved}");
}

#[test]
fn nothing_is_proposed_for_an_exact_site() {
    let (truth, object) = (rig(4), cube());
    let (rig, model) = files(&truth, &object);
    let mut machine = fusion(&rig, &model, FusionOptions::default());
    assert_eq!(proposed(&mut machine, &truth, &object, 3), None);
}

#[test]
fn what_was_taken_is_not_proposed_again() {
    let (truth, object) = (rig(4), cube());
    let random = &mut Random(2);
    let configured = measured(&truth, 0.005, 0.005, random);
    let stuck = glued(&object, 0.001, 0.017, random);
    let mut machine = fusion(&configured, &stuck, FusionOptions::default());
    let proposal = proposed(&mut machine, &truth, &object, 2).unwrap();
    let (rig, objects) = (proposal.rig.unwrap(), proposal.objects);
    machine.handle(0, Input::Rig(rig.clone()));
    assert_eq!(machine.proposal(), None, "nothing is seen yet");
    let mut refined = fusion(&rig, &objects[0], FusionOptions::default());
    assert_eq!(proposed(&mut refined, &truth, &object, 12), None);
}

/// The rig with the names of its first two cameras exchanged.
fn with_names_exchanged(rig: &Rig) -> Rig {
    let mut cameras = rig.cameras().to_vec();
    let first = cameras[0].id.clone();
    cameras[0].id = std::mem::replace(&mut cameras[1].id, first);
    Rig::new(cameras).unwrap()
}

/// The object with its first tag upside down.
fn with_a_tag_upside_down(object: &ObjectModel) -> ObjectModel {
    let first = object.tags()[0].clone();
    let upside_down = Pose::from_parts(
        Vector3::zeros().into(),
        UnitQuaternion::from_axis_angle(&Vector3::z_axis(), PI),
    );
    object.clone().with_tag(ObjectTag {
        object_from_tag: first.object_from_tag.map(|place| place * upside_down),
        ..first
    })
}

/// The object as its print is at another scale.
fn printed_at(object: &ObjectModel, ratio: f64) -> ObjectModel {
    object
        .tags()
        .iter()
        .cloned()
        .fold(object.clone(), |printed, mut tag| {
            tag.size_m *= ratio;
            if let Some(place) = &mut tag.object_from_tag {
                place.translation.vector *= ratio;
            }
            printed.with_tag(tag)
        })
}

#[test]
fn mistakes_of_files_are_proposed_mended() {
    let (truth, object) = (rig(4), cube());
    let files = [
        (with_names_exchanged(&truth), object.clone()),
        (truth.clone(), with_a_tag_upside_down(&object)),
        (truth.clone(), printed_at(&object, 1.05)),
    ];
    for (index, (rig_file, object_file)) in files.into_iter().enumerate() {
        let random = &mut Random(index as u64 + 50);
        let configured = measured(&rig_file, 0.003, 0.003, random);
        let glued = glued(&object_file, 0.0005, 0.009, random);
        let mut machine = fusion(&configured, &glued, FusionOptions::default());
        let start = run(&truth, &object, 0.1, 4.0, random);
        let (before, after) = start.split_at(start.len() / 2);
        before
            .iter()
            .for_each(|image| drop(feed(&mut machine, image.clone())));
        let proposal = machine
            .proposal()
            .unwrap_or_else(|| panic!("{index}: {:?}", machine.faults()));
        assert!(
            proposal.held_back.n_images >= 8,
            "{index}: {:?}",
            proposal.held_back
        );
        assert!(!machine.faults().is_empty(), "{index}: its file is wrong");
        if let Some(rig) = proposal.rig {
            machine.handle(START_NS, Input::Rig(rig));
        }
        if let [object] = &proposal.objects[..] {
            machine.handle(START_NS, Input::Objects(vec![object.clone()]));
        }
        for image in after {
            for estimate in feed(&mut machine, image.clone()) {
                let off = position_error(&estimate, &path_at(estimate.capture_ns));
                let sigma = estimate.covariance.fixed_view::<3, 3>(0, 0).trace().sqrt();
                let is_right = estimate.state != State::Tracking || off < 4.0 * sigma + 0.005;
                assert!(is_right, "{index}: {off} with {sigma}");
            }
        }
        assert_eq!(machine.faults(), [], "{index}");
    }
}
