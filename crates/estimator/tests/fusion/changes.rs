//! Rig and objects change while the machine runs: whole or not at all.

use sextant_estimator::{Fusion, FusionOptions, Input, ModelError, Output};
use sextant_geometry::{Intrinsics, Lens, Pose};
use sextant_site_model::{Camera, ObjectId, ObjectModel, ObjectTag, PoseSigma, Prior, Rig};
use sextant_site_report::State;

use crate::scene::{
    Random, START_NS, cube, cube_id, feed, fusion, path_at, position_error, rig, run,
};

#[test]
fn objects_that_share_a_tag_are_refused_and_the_old_ones_stay() {
    let (rig, object) = (rig(2), cube());
    let mut fusion = fusion(&rig, &object, FusionOptions::default());
    let images = run(&rig, &object, 0.1, 0.4, &mut Random(1));
    let (before, after) = images.split_at(10);
    before
        .iter()
        .for_each(|image| drop(feed(&mut fusion, image.clone())));
    let twin = ObjectModel::new(ObjectId::new("twin").unwrap(), object.tags().to_vec())
        .unwrap()
        .exact();
    fusion.handle(START_NS, Input::Objects(vec![object.clone(), twin]));
    assert!(matches!(
        fusion.poll_output(),
        Some(Output::Refused(ModelError::SharedTag { .. }))
    ));
    for image in after {
        let said = feed(&mut fusion, image.clone());
        assert!(said.iter().all(|estimate| estimate.object == cube_id()) && !said.is_empty());
    }
}

#[test]
fn objects_come_and_go_and_the_unchanged_keep_their_track() {
    let (rig, object) = (rig(2), cube());
    let mut fusion = fusion(&rig, &object, FusionOptions::default());
    run(&rig, &object, 0.1, 0.3, &mut Random(1))
        .into_iter()
        .for_each(|image| drop(feed(&mut fusion, image)));
    let known = fusion.pose_at(&cube_id(), START_NS + 290_000_000);
    assert!(known.is_some());
    fusion.handle(START_NS, Input::Objects(vec![object.clone()]));
    assert_eq!(fusion.pose_at(&cube_id(), START_NS + 290_000_000), known);
    fusion.handle(START_NS, Input::Objects(vec![]));
    assert_eq!(fusion.pose_at(&cube_id(), START_NS + 290_000_000), None);
}

#[test]
fn an_object_that_keeps_a_tag_in_its_place_keeps_its_track() {
    let (rig, object) = (rig(2), cube());
    let mut fusion = fusion(&rig, &object, FusionOptions::default());
    run(&rig, &object, 0.1, 0.3, &mut Random(1))
        .into_iter()
        .for_each(|image| drop(feed(&mut fusion, image)));
    let at_ns = START_NS + 290_000_000;
    let known = fusion.pose_at(&cube_id(), at_ns);
    assert!(known.is_some());
    let change = |change: &dyn Fn(&mut ObjectTag)| {
        let mut tags = object.tags().to_vec();
        tags.iter_mut().for_each(change);
        Input::Objects(vec![ObjectModel::new(cube_id(), tags).unwrap().exact()])
    };
    let first = object.tags()[0].tag;
    let one_larger = |tag: &mut ObjectTag| tag.size_m *= if tag.tag == first { 1.1 } else { 1.0 };
    fusion.handle(START_NS, change(&one_larger));
    assert_eq!(fusion.pose_at(&cube_id(), at_ns), known);
    let inexact = |tag: &mut ObjectTag| tag.pose_prior = Prior::Sigma(PoseSigma::OF_TAG);
    fusion.handle(START_NS, change(&inexact));
    assert_eq!(fusion.pose_at(&cube_id(), at_ns), known);
    fusion.handle(START_NS, change(&|tag| tag.size_m *= 2.0));
    assert_eq!(fusion.pose_at(&cube_id(), at_ns), None);
}

#[test]
fn what_was_learned_about_a_camera_stays_with_it_when_the_rigs_order_changes() {
    let (whole, object) = (rig(3), cube());
    let noisy = |fusion: &mut Fusion, from: f64, to: f64| {
        let images = run(&whole, &object, from, to, &mut Random(6));
        images
            .into_iter()
            .flat_map(|image| feed(fusion, image))
            .collect::<Vec<_>>()
    };
    let reordered = || {
        let mut cameras = whole.cameras().to_vec();
        cameras.rotate_left(1);
        Rig::new(cameras).unwrap().exact()
    };
    let mut changed = fusion(&whole, &object, FusionOptions::default());
    let mut left_alone = fusion(&whole, &object, FusionOptions::default());
    noisy(&mut changed, 0.1, 0.4);
    noisy(&mut left_alone, 0.1, 0.4);
    // Settled alike: the same rig once more.
    left_alone.handle(START_NS, Input::Rig(whole.clone()));
    changed.handle(START_NS, Input::Rig(reordered()));
    assert_eq!(
        noisy(&mut changed, 0.5, 0.8),
        noisy(&mut left_alone, 0.5, 0.8)
    );
}

#[test]
fn a_new_rig_is_used_from_the_next_image_on() {
    let (whole, object) = (rig(3), cube());
    let first = Rig::new(whole.cameras()[..2].to_vec()).unwrap().exact();
    let mut fusion = fusion(&first, &object, FusionOptions::default());
    for (index, image) in run(&whole, &object, 0.1, 1.0, &mut Random(6))
        .into_iter()
        .enumerate()
    {
        if index == 45 {
            fusion.handle(image.capture_ns, Input::Rig(whole.clone()));
        }
        let third = image.camera.as_str() == "cam2";
        let time_ns = image.capture_ns;
        let said = feed(&mut fusion, image);
        assert!(
            said.iter()
                .all(|estimate| position_error(estimate, &path_at(time_ns)) < 2e-3 || index < 6)
        );
        assert_eq!(
            said.iter().any(|estimate| estimate.tags > 0),
            !third || index >= 45,
            "{index}"
        );
    }
    assert_eq!(fusion.statistics().unknown_cameras, 15);
}

/// The rig is measured anew and its world begins elsewhere, or its lenses are others: not one pose is where the object
/// was by the former rig.
#[test]
fn a_rig_that_sees_the_object_elsewhere_begins_its_track_anew() {
    let (truth, object) = (rig(3), cube());
    let shift = Pose::translation(0.158, 0.0, 0.0);
    let moved = |camera: &Camera| {
        let pose = camera.world_from_camera.map(|pose| shift * pose);
        Camera::new(camera.id.clone(), camera.resolution, camera.lens, pose)
    };
    let longer = |camera: &Camera| {
        let pinhole = camera.lens.intrinsics();
        let (fx, fy) = (1.1 * pinhole.fx, 1.1 * pinhole.fy);
        let lens = Lens::pinhole(Intrinsics { fx, fy, ..pinhole }).unwrap();
        Camera::new(
            camera.id.clone(),
            camera.resolution,
            lens,
            camera.world_from_camera,
        )
    };
    let moved: Vec<Camera> = truth.cameras().iter().map(moved).collect();
    let longer: Vec<Camera> = truth.cameras().iter().map(longer).collect();
    for former in [moved, longer] {
        let former = Rig::new(former).unwrap();
        let mut fusion = fusion(&former, &object, FusionOptions::default());
        let mut tracked = 0;
        for (index, image) in run(&truth, &object, 0.1, 1.0, &mut Random(6))
            .into_iter()
            .enumerate()
        {
            if index == 45 {
                fusion.handle(image.capture_ns, Input::Rig(truth.clone()));
            }
            let time_ns = image.capture_ns;
            for estimate in feed(&mut fusion, image) {
                if index >= 45 && estimate.state == State::Tracking {
                    tracked += 1;
                    let error_m = position_error(&estimate, &path_at(time_ns));
                    assert!(error_m < 5e-3, "image {index}: {error_m} m");
                }
            }
        }
        assert!(tracked > 30, "{tracked}");
    }
}

#[test]
fn models_that_contradict_each_other_make_no_machine() {
    let twice = Fusion::new(rig(1), vec![cube(), cube()], FusionOptions::default());
    assert!(matches!(twice, Err(ModelError::DuplicateObject(_))));
    let options = FusionOptions {
        window_s: -1.0,
        ..FusionOptions::default()
    };
    assert!(matches!(
        Fusion::new(rig(1), vec![cube()], options),
        Err(ModelError::Options(_))
    ));
}
