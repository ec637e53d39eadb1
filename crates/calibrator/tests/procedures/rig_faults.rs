//! Broken inputs: refused, or solved with a word, each with its true cause.

use crate::rig::{calibrated, plainly};
use crate::scene::*;
use nalgebra::Vector6;
use nalgebra::{Isometry3, Vector3};
use sextant_calibrator::{Finding, Grade, Origin, RigError, RigPlan, RigSession};
use sextant_geometry::{Pose, se3};
use sextant_site_model::{Camera, ImageObservation, ObjectModel, ObjectTag, Prior, Rig};

fn refusal(rig: &Rig, images: &[ImageObservation]) -> RigError {
    match plainly(rig, images) {
        Err(error) => error,
        Ok(found) => panic!("solved: {}", found.report.verdict),
    }
}

/// A walk during which a camera moves half way through.
fn with_a_move(step: Isometry3<f64>, seed: u64) -> Vec<ImageObservation> {
    let truth = rig();
    let cameras = truth.cameras().iter().map(|camera| Camera {
        world_from_camera: camera.world_from_camera.map(|pose| {
            if camera.id == camera_id(1) {
                pose * step
            } else {
                pose
            }
        }),
        ..camera.clone()
    });
    let after = Rig::new(cameras.collect()).unwrap();
    let mut images = walk(&truth, &board(), 60, 0.12, SHARP, seed);
    let moved = walk(&after, &board(), 60, 0.12, SHARP, seed);
    let half = images.len() / 2;
    images.truncate(half);
    images.extend_from_slice(&moved[half..]);
    images
}

#[test]
fn a_camera_that_moved_a_little_is_named() {
    let step = Isometry3::new(Vector3::new(0.012, 0.0, 0.0), Vector3::new(0.0, 0.006, 0.0));
    let refused = refusal(&rig(), &with_a_move(step, 11));
    assert!(
        matches!(&refused, RigError::Moved { camera, .. } if *camera == camera_id(1)),
        "{refused}"
    );
}

#[test]
fn a_camera_that_moved_far_is_named() {
    let step = Isometry3::new(Vector3::new(0.2, 0.1, 0.0), Vector3::new(0.0, 0.1, 0.05));
    let refused = refusal(&rig(), &with_a_move(step, 12));
    assert!(
        matches!(&refused, RigError::Moved { camera, .. } if *camera == camera_id(1)),
        "{refused}"
    );
}

#[test]
fn islands_are_named() {
    let mut images = walk(&rig(), &board(), 60, 0.12, SHARP, 13);
    for (at, seen) in images.iter_mut().enumerate() {
        let (instant, camera) = (at / 4, at % 4);
        if (instant < 30) == (camera < 2) {
            seen.tags.clear();
        }
    }
    let found = plainly(&rig(), &images).unwrap();
    let unsolved = found.report.unsolved.join("; ");
    assert!(
        unsolved.contains("cameras c and d share no view with a and b"),
        "{unsolved}"
    );
    let is_placed = |at: usize| found.rig.cameras()[at].world_from_camera.is_some();
    assert_eq!([0, 1, 2, 3].map(is_placed), [true, true, false, false]);
    assert_eq!(found.rig.cameras()[2].pose_prior, Prior::Default);
}

#[test]
fn swapped_names_are_found() {
    let truth = rig();
    let wide = |camera: &Camera| {
        let mut parameters = camera.lens.parameters();
        if camera.id == camera_id(3) {
            parameters[..4].copy_from_slice(&[640.0, 641.0, 330.0, 250.0]);
        }
        Camera {
            lens: camera.lens.with_parameters(&parameters).unwrap(),
            ..camera.clone()
        }
    };
    let truth = Rig::new(truth.cameras().iter().map(wide).collect()).unwrap();
    let mut images = walk(&truth, &board(), 60, 0.12, SHARP, 14);
    for image in &mut images {
        if image.camera == camera_id(0) {
            image.camera = camera_id(3);
        } else if image.camera == camera_id(3) {
            image.camera = camera_id(0);
        }
    }
    let refused = refusal(&truth, &images);
    assert!(
        matches!(&refused, RigError::Swapped { first, second }
        if *first == camera_id(0) && *second == camera_id(3)),
        "{refused}"
    );
}

#[test]
fn another_resolution_is_named() {
    let mut images = walk(&rig(), &board(), 30, 0.12, SHARP, 15);
    for corner in images
        .iter_mut()
        .filter(|image| image.camera == camera_id(1))
        .flat_map(|image| image.tags.iter_mut())
        .flat_map(|tag| &mut tag.corners)
    {
        *corner *= 2.0;
    }
    let refused = refusal(&rig(), &images);
    assert!(
        matches!(&refused, RigError::Resolution { camera, .. } if *camera == camera_id(1)),
        "{refused}"
    );
}

#[test]
fn empty_images_are_named() {
    let mut images = walk(&rig(), &board(), 10, 0.12, SHARP, 16);
    images.iter_mut().for_each(|image| image.tags.clear());
    let refused = refusal(&rig(), &images).to_string();
    assert!(
        refused.contains("40 images, and none shows a tag of object board: no tag at all"),
        "{refused}"
    );
    assert!(matches!(refusal(&rig(), &[]), RigError::NothingSeen { .. }));
}

#[test]
fn a_tag_that_is_there_twice_is_named() {
    let truth = rig();
    // Tag 3's number stands in the place of tag 8 too, on the same side.
    let doubled = |images: &mut Vec<ImageObservation>| {
        for tag in images.iter_mut().flat_map(|image| image.tags.iter_mut()) {
            if tag.tag == tag_of(8) {
                tag.tag = tag_of(3);
            }
        }
    };
    let mut images = walk(&truth, &board(), 40, 0.12, SHARP, 17);
    doubled(&mut images);
    let refused = refusal(&truth, &images);
    assert!(
        matches!(refused, RigError::Doubled { tag, .. } if tag == tag_of(3)),
        "{refused}"
    );
    // And on the other side, where both are never seen at once.
    let mut images = walk(&truth, &board(), 40, 0.12, SHARP, 18);
    for tag in images.iter_mut().flat_map(|image| image.tags.iter_mut()) {
        if tag.tag == tag_of(20) {
            tag.tag = tag_of(3);
        }
    }
    let found = plainly(&truth, &images).unwrap();
    assert!(
        found
            .report
            .verdict
            .to_string()
            .contains("tag36h11:3 fits in only"),
        "{}",
        found.report.verdict
    );
}

fn tag_of(id: u32) -> sextant_site_model::TagId {
    tag(id)
}

#[test]
fn sizes_that_disagree_with_the_spacing_are_named() {
    let truth = rig();
    let images = walk(&truth, &board(), 40, 0.12, SHARP, 19);
    let wrong = changed(&board(), |tag| tag.size_m *= 1.02);
    let found = calibrated(&blind(&truth), wrong, Origin::FirstCamera, &images).unwrap();
    let verdict = found.report.verdict;
    assert_eq!(verdict.grade, Grade::Usable);
    assert!(
        verdict
            .to_string()
            .contains("% smaller than given, according to their spacing"),
        "{verdict}"
    );
}

#[test]
fn a_single_tag_far_away_is_not_called_good() {
    let truth = rig();
    let single = object("wand", [(0, 0.05, Isometry3::identity())].into_iter());
    let images = walk(&truth, &single, 40, 0.12, SHARP, 20);
    match calibrated(&blind(&truth), single, Origin::FirstCamera, &images) {
        Ok(found) => assert_ne!(found.report.verdict.grade, Grade::Good),
        Err(refused) => assert!(
            matches!(refused, RigError::NotConnected { .. }),
            "{refused}"
        ),
    }
}

#[test]
fn hints_lead_from_nothing_to_enough() {
    let truth = rig();
    let plan = RigPlan {
        object: board(),
        origin: Origin::FirstCamera,
    };
    let mut session = RigSession::new(blind(&truth), plan).unwrap();
    assert!(
        session
            .progress()
            .hint
            .starts_with("Carry the object through what camera a sees")
    );
    let images = walk(&truth, &board(), 200, 0.1, SHARP, 21);
    let mut complete = 0.0;
    for image in &images {
        session.handle(image);
        let progress = session.progress();
        assert!(progress.complete >= complete);
        complete = progress.complete;
    }
    assert!(complete > 0.9, "{complete}: {}", session.progress().hint);
}

#[test]
fn an_unknown_object_is_to_be_turned_until_every_tag_was_shown() {
    let truth = rig();
    let mute = tag(0);
    let plan = RigPlan {
        object: changed(&board(), |tag| tag.object_from_tag = None),
        origin: Origin::FirstCamera,
    };
    let mut session = RigSession::new(blind(&truth), plan).unwrap();
    for mut image in walk(&truth, &board(), 200, 0.1, SHARP, 21) {
        image.tags.retain(|seen| seen.tag != mute);
        session.handle(&image);
    }
    let progress = session.progress();
    let shown = 1.0 - 1.0 / board().tags().len() as f64;
    assert!(progress.complete <= shown, "{}", progress.complete);
    let hint = format!("Turn the object: hardly an image shows its tag {mute}");
    assert_eq!(progress.hint, hint);
}

#[test]
fn a_camera_that_sees_tags_in_another_arrangement_places_nothing() {
    let truth = rig();
    let mut images = walk(&truth, &board(), 60, 0.12, SHARP, 33);
    for image in images.iter_mut().filter(|i| i.camera == camera_id(2)) {
        for seen in &mut image.tags {
            // As read from the back: columns in the other order.
            seen.tag.id ^= 3;
        }
    }
    let found = plainly(&truth, &images).unwrap();
    let [named] = &found.report.unsolved[..] else {
        panic!("{:?}", found.report.unsolved)
    };
    assert!(named.contains("camera c did not see board"), "{named}");
    assert_eq!(found.report.cameras.len(), 3);
    let placed = found.rig.cameras().iter();
    assert_eq!(
        placed.filter(|one| one.world_from_camera.is_some()).count(),
        3
    );
}

/// The rig as measured by tape: a few millimetres and tenths of a degree off.
fn by_tape(truth: &Rig) -> Rig {
    let cameras = truth.cameras().iter().enumerate().map(|(at, camera)| {
        let wave = |k: usize| (2.3 * (6 * at + k) as f64 + 1.0).sin() * 1.4;
        let off = Vector6::from_fn(|k, _| wave(k) * if k < 3 { 0.003 } else { 0.0035 });
        Camera {
            world_from_camera: camera
                .world_from_camera
                .map(|pose| se3::perturb(&pose, &off)),
            ..camera.clone()
        }
    });
    Rig::new(cameras.collect()).unwrap()
}

#[test]
fn an_object_printed_at_another_scale_is_named_and_the_rig_keeps_its_size() {
    let file = board();
    let printed = file.tags().iter().map(|tag| {
        let place = tag.object_from_tag.map(|mut pose: Pose| {
            pose.translation.vector *= 0.97;
            pose
        });
        ObjectTag::new(tag.tag, 0.97 * tag.size_m, place)
    });
    let printed = ObjectModel::new(file.id().clone(), printed.collect()).unwrap();
    let images = walk(&rig(), &printed, 60, 0.12, SHARP, 31);
    let found = calibrated(&by_tape(&rig()), board(), Origin::FirstCamera, &images).unwrap();
    let verdict = &found.report.verdict;
    assert!(verdict.grade > Grade::Good, "{verdict}");
    let ratio = verdict.because.iter().find_map(|finding| match finding {
        Finding::PrintedAtScale { ratio, .. } => Some(*ratio),
        _ => None,
    });
    assert!((ratio.unwrap() - 0.97).abs() < 0.004, "{ratio:?}");
    let place = |rig: &Rig, at: usize| {
        rig.cameras()[at]
            .world_from_camera
            .unwrap()
            .translation
            .vector
    };
    for at in 1..4 {
        let [is, was] = [&found.rig, &rig()].map(|rig| (place(rig, at) - place(rig, 0)).norm());
        assert!((is / was - 1.0).abs() < 0.005, "{is} {was}");
    }
}

#[test]
fn exchanged_names_of_cameras_with_one_lens_are_found_by_their_former_places() {
    let truth = rig();
    let mut images = walk(&truth, &board(), 60, 0.12, SHARP, 32);
    for image in &mut images {
        image.camera = match [0, 1, 2, 3].map(|at| image.camera == camera_id(at)) {
            [true, ..] => camera_id(2),
            [_, _, true, _] => camera_id(0),
            _ => image.camera.clone(),
        };
    }
    let found = calibrated(&by_tape(&truth), board(), Origin::FirstCamera, &images).unwrap();
    let verdict = &found.report.verdict;
    let exchanged = Finding::ExchangedNames(vec![camera_id(0), camera_id(2)]);
    assert_eq!(verdict.grade, Grade::Poor);
    assert!(verdict.because.contains(&exchanged), "{verdict}");
    for (is, was) in [(0, 2), (1, 1), (2, 0), (3, 3)] {
        let is = found.rig.cameras()[is].world_from_camera.unwrap();
        let was = truth.cameras()[was].world_from_camera.unwrap();
        assert!(se3::difference(&is, &was).norm() < 0.03);
    }
}
