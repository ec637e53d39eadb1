//! A refined calibration is proposed where images that had no part in it are explained better by it.

use sextant_estimator::{Fusion, FusionOptions, Input, Proposal};
use sextant_geometry::{Pose, se3};
use sextant_site_model::{ImageObservation, ObjectModel, Rig};

use crate::imperfect::{files, glued, measured, watched};
use crate::scene::{Random, cube, feed, fusion, rig, run};

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
