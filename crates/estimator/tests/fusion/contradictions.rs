//! What contradicts a site as a whole, so that no single camera or tag is the cause: named, and not called tracking.

use sextant_estimator::{Fusion, FusionOptions, Input};
use sextant_geometry::{Intrinsics, Lens, Pose};
use sextant_site_model::{Camera, ImageObservation, ObjectModel, ObjectTag, Rig};
use sextant_site_report::{Fault, ObjectEstimate, State};

use crate::imperfect::{glued, measured};
use crate::scene::{
    Eye, PERIOD_NS, Random, START_NS, camera_id, card, cube, cube_id, feed, fusion, path_at, poses,
    position_error, rig, run, run_in_phase, tag_id,
};

const HOUR_NS: u64 = 3_600_000_000_000;

/// The rig and the object as people have them, without a sigma.
fn files(cameras: usize, object: &ObjectModel, random: &mut Random) -> (Rig, ObjectModel) {
    (
        measured(&rig(cameras), 0.003, 0.003, random),
        glued(object, 0.0005, 0.009, random),
    )
}

/// The cube with other tags.
fn with_tags(change: impl Fn(usize, &ObjectTag) -> ObjectTag) -> ObjectModel {
    let tags = cube();
    let changed = tags.tags().iter().enumerate();
    let changed = changed.map(|(index, tag)| change(index, tag)).collect();
    ObjectModel::new(cube_id(), changed).unwrap()
}

/// All poses of the images, with what is wrong by then.
fn watch(fusion: &mut Fusion, images: Vec<ImageObservation>) -> Vec<(ObjectEstimate, Vec<Fault>)> {
    let mut all = Vec::new();
    for image in images {
        for estimate in feed(fusion, image) {
            all.push((estimate, fusion.faults()));
        }
    }
    all
}

#[test]
fn tags_that_are_all_printed_larger_are_named_and_allowed_for() {
    for (cameras, ratio) in [(1, 1.5), (1, 0.8), (4, 1.5), (4, 1.25)] {
        let random = &mut Random(cameras as u64);
        let printed = with_tags(|_, tag| ObjectTag {
            size_m: tag.size_m * ratio,
            ..tag.clone()
        });
        let (rig_file, file) = files(cameras, &cube(), random);
        let mut fusion = fusion(&rig_file, &file, FusionOptions::default());
        let said = watch(&mut fusion, run(&rig(cameras), &printed, 0.1, 4.0, random));
        let named = |faults: &[Fault]| {
            let mut faults = faults.iter();
            faults.find_map(|fault| match fault {
                Fault::ObjectScaled { ratio, .. } => Some(*ratio),
                _ => None,
            })
        };
        let (last, faults) = said.last().unwrap();
        let found = named(faults).unwrap_or_else(|| panic!("{cameras} {ratio}: {faults:?}"));
        assert!(
            (found / ratio - 1.0).abs() < 0.05,
            "{cameras} cameras: {found}"
        );
        let settled = said.iter().skip(said.len() / 2);
        for (estimate, _) in settled {
            let off = position_error(estimate, &path_at(estimate.capture_ns));
            let sigma = estimate.covariance.fixed_view::<3, 3>(0, 0).trace().sqrt();
            assert!(
                off < 4.0 * sigma + 0.005,
                "{cameras} cameras: {off} with {sigma}"
            );
        }
        assert_eq!(last.state, State::Tracking);
    }
}

#[test]
fn one_of_two_tags_in_a_plane_that_is_off_its_place_is_no_print_scale() {
    let random = &mut Random(19);
    let at =
        |id: u32, x: f64| ObjectTag::new(tag_id(id), 0.04, Some(Pose::translation(x, 0.0, 0.0)));
    let object = |x: f64| ObjectModel::new(cube_id(), vec![at(0, 0.0), at(1, x)]).unwrap();
    let (rig_file, file) = files(2, &object(0.06), random);
    let mut fusion = fusion(&rig_file, &file, FusionOptions::default());
    let said = watch(&mut fusion, run(&rig(2), &object(0.08), 0.1, 3.0, random));
    let is_scaled = |fault: &Fault| matches!(fault, Fault::ObjectScaled { .. });
    assert!(said.iter().all(|(_, faults)| !faults.iter().any(is_scaled)));
}

#[test]
fn an_object_with_its_tags_in_other_places_is_named_and_not_wrong() {
    for cameras in [1, 4] {
        let random = &mut Random(7);
        let places = cube();
        let swapped = with_tags(|index, tag| ObjectTag {
            object_from_tag: places.tags()[[2, 3, 4, 5, 1, 0][index]].object_from_tag,
            ..tag.clone()
        });
        let (rig_file, file) = files(cameras, &cube(), random);
        let mut fusion = fusion(&rig_file, &file, FusionOptions::default());
        let images = run(&rig(cameras), &swapped, 0.1, 6.0, random);
        let several = |image: &ImageObservation| image.tags.len() > 1;
        let shown = images.into_iter().filter(several).collect();
        let said = watch(&mut fusion, shown);
        let is_contradicted = |faults: &[Fault]| {
            let mut faults = faults.iter();
            faults.any(|fault| {
                matches!(
                    fault,
                    Fault::ObjectContradicted { .. }
                        | Fault::TagsExchanged { .. }
                        | Fault::TagTurned { .. }
                )
            })
        };
        let is_wrong = |one: &ObjectEstimate| {
            let off = position_error(one, &path_at(one.capture_ns));
            let sigma = one.covariance.fixed_view::<3, 3>(0, 0).trace().sqrt();
            one.state == State::Tracking && off > 4.0 * sigma + 0.005
        };
        let late = said.iter().skip(said.len() / 2);
        // Later its tags are learned anew.
        let early = said.iter().take(said.len() / 2);
        let named = early.filter(|(_, faults)| is_contradicted(faults));
        let wrong = late.clone().filter(|(one, _)| is_wrong(one));
        let (named, wrong, all) = (named.count(), wrong.count(), late.count());
        assert!(2 * named > all, "{cameras} cameras: {named} of {all}");
        assert!(20 * wrong < all, "{cameras} cameras: {wrong} of {all}");
    }
}

#[test]
fn a_picture_that_stands_still_is_named_and_left_out() {
    let random = &mut Random(3);
    let (rig_file, file) = files(4, &cube(), random);
    let mut fusion = fusion(&rig_file, &file, FusionOptions::default());
    let mut frozen: Option<Vec<_>> = None;
    let mut images = run(&rig(4), &cube(), 0.1, 5.0, random);
    for image in &mut images {
        if image.camera == camera_id(1) && image.capture_ns > START_NS + 2_000_000_000 {
            let still = frozen.get_or_insert_with(|| image.tags.clone());
            image.tags.clone_from(still);
        }
    }
    let said = watch(&mut fusion, images);
    let expected = |fault: &Fault| match fault {
        Fault::CameraFrozen { camera, still_s } => *camera == camera_id(1) && *still_s > 2.0,
        _ => false,
    };
    let (_, faults) = said.last().unwrap();
    assert!(
        faults.iter().all(expected) && faults.len() == 1,
        "{faults:?}"
    );
    let after = START_NS + 3_000_000_000;
    for (estimate, _) in said.iter().filter(|(one, _)| one.capture_ns > after) {
        let off = position_error(estimate, &path_at(estimate.capture_ns));
        assert!(off < 0.02, "{off}");
        assert_eq!(estimate.state, State::Tracking);
    }
}

/// It is turned away after two seconds and back after nine. While no camera sees the object, none is reported.
#[test]
fn a_camera_that_sees_nothing_of_what_others_track_is_named() {
    let random = &mut Random(5);
    let (rig_file, file) = files(4, &cube(), random);
    for n_blind in [1, 4] {
        let mut fusion = fusion(&rig_file, &file, FusionOptions::default());
        let mut images = run(&rig(4), &cube(), 0.1, 12.0, random);
        for image in &mut images {
            let seconds = (image.capture_ns - START_NS) as f64 * 1e-9;
            let is_away = (1..=n_blind).any(|camera| image.camera == camera_id(camera % 4));
            if is_away && (2.0..9.0).contains(&seconds) {
                image.tags.clear();
            }
        }
        let said = watch(&mut fusion, images);
        for (estimate, faults) in said {
            let seconds = (estimate.capture_ns - START_NS) as f64 * 1e-9;
            let blind = faults.iter().find_map(|fault| match fault {
                Fault::CameraBlind {
                    camera, blind_s, ..
                } => Some((camera, *blind_s)),
                _ => None,
            });
            // It turns, so that there are times when no camera there would see a tag of it.
            let expected = n_blind == 1 && (8.6..9.0).contains(&seconds);
            if expected || !(6.9..9.1).contains(&seconds) {
                assert_eq!(blind.is_some(), expected, "{seconds}: {faults:?}");
            }
            if let Some((camera, blind_s)) = blind {
                assert_eq!(*camera, camera_id(1));
                assert!((5.0..seconds - 2.0).contains(&blind_s), "{blind_s}");
            }
        }
    }
}

#[test]
fn a_pinhole_where_the_picture_bends_is_named() {
    let intrinsics = Intrinsics {
        fx: 600.0,
        fy: 600.0,
        cx: 319.5,
        cy: 239.5,
    };
    let bending = Lens::brown_conrady(intrinsics, [-0.3, 0.1, 0.0, 0.0, 0.0]).unwrap();
    let truth = Rig::new(vec![Camera {
        lens: bending,
        ..rig(1).cameras()[0].clone()
    }]);
    let truth = truth.unwrap();
    let board = (0..35).map(|index| {
        let place = Pose::translation(
            0.1 * f64::from(index % 7) - 0.3,
            0.1 * f64::from(index / 7) - 0.2,
            0.0,
        );
        ObjectTag::new(tag_id(index), 0.07, Some(place))
    });
    let board = ObjectModel::new(cube_id(), board.collect()).unwrap();
    let mut fusion = fusion(
        &Rig::new(vec![Camera::new(
            camera_id(0),
            [640, 480],
            Lens::pinhole(intrinsics).unwrap(),
            truth.cameras()[0].world_from_camera,
        )])
        .unwrap(),
        &board,
        FusionOptions::default(),
    );
    let eye = Eye {
        rig: &truth,
        object: &board,
        sigma_px: 0.1,
    };
    let said = watch(&mut fusion, run_in_phase(&eye, 8.0, |_| 0, &mut Random(5)));
    let named = said.iter().any(|(_, faults)| {
        let mut faults = faults.iter();
        faults.any(|fault| matches!(fault, Fault::LensOff { camera } if *camera == camera_id(0)))
    });
    assert!(named);
}

/// Feeds images whose camera's stamps are `behind_ns` early and that arrive by a clock that is `host_ns` early.
fn with_clocks(
    fusion: &mut Fusion,
    images: Vec<ImageObservation>,
    behind_ns: impl Fn(&ImageObservation) -> u64,
    host_ns: u64,
) -> Vec<ObjectEstimate> {
    let mut all = Vec::new();
    for mut image in images {
        let arrival_ns = image.capture_ns + 10_000_000 - host_ns;
        image.capture_ns -= behind_ns(&image);
        fusion.handle(arrival_ns, Input::Image(image));
        all.extend(poses(fusion));
    }
    all
}

#[test]
fn a_camera_an_hour_behind_from_the_start_gives_no_poses_of_an_hour_ago() {
    for late in [0, 1] {
        let random = &mut Random(11);
        let (rig_file, file) = files(2, &cube(), random);
        let mut fusion = fusion(&rig_file, &file, FusionOptions::default());
        let images = run(&rig(2), &cube(), 0.1, 4.0, random);
        let is_late = |image: &ImageObservation| image.camera == camera_id(late);
        let behind_ns = |image: &ImageObservation| HOUR_NS * u64::from(is_late(image));
        let said = with_clocks(&mut fusion, images, behind_ns, 0);
        assert!(
            said.iter().all(|one| one.capture_ns >= START_NS),
            "camera {late}"
        );
        // Once, when the offset is found and all begins anew.
        let lost = said.iter().filter(|one| one.state == State::Lost).count();
        assert!(lost <= 1, "camera {late}: {lost}");
        assert!(said.len() > 60, "camera {late}: {} poses", said.len());
        let named = fusion.faults().into_iter().any(|fault| match fault {
            Fault::ClockOff { camera, offset_s } => {
                camera == camera_id(late) && (offset_s + 3600.0).abs() < 0.1
            }
            _ => false,
        });
        assert!(named, "camera {late}: {:?}", fusion.faults());
    }
}

#[test]
fn a_host_whose_clock_is_off_follows_the_cameras() {
    for host_ns in [5_000_000_000, 1000 * HOUR_NS] {
        let random = &mut Random(13);
        let (rig_file, file) = files(3, &cube(), random);
        let mut fusion = fusion(&rig_file, &file, FusionOptions::default());
        let images = run(&rig(3), &cube(), 0.1, 2.0, random);
        let n_images = images.len();
        let said = with_clocks(&mut fusion, images, |_| 0, host_ns);
        let tracked = said.iter().filter(|one| one.state == State::Tracking);
        assert!(10 * tracked.count() > 9 * n_images, "{host_ns}");
        let expected = |fault: &Fault| match fault {
            Fault::HostClockOff { offset_s } => (offset_s + host_ns as f64 * 1e-9).abs() < 0.1,
            _ => false,
        };
        assert!(
            fusion.faults().iter().any(expected),
            "{:?}",
            fusion.faults()
        );
    }
}

#[test]
fn one_tag_before_one_camera_needs_no_places_and_several_tags_do() {
    let random = &mut Random(17);
    let unplaced = |object: &ObjectModel| {
        let tags = object.tags().iter();
        let tags = tags.map(|tag| ObjectTag::new(tag.tag, tag.size_m, None));
        ObjectModel::new(cube_id(), tags.collect()).unwrap()
    };
    let camera = rig(1).cameras()[0].clone();
    let unplaced_rig = Rig::new(vec![Camera::new(
        camera.id,
        camera.resolution,
        camera.lens,
        None,
    )]);
    let unplaced_rig = unplaced_rig.unwrap();
    let mut one = fusion(&unplaced_rig, &unplaced(&card()), FusionOptions::default());
    let eye = Eye {
        rig: &rig(1),
        object: &card(),
        sigma_px: 0.1,
    };
    let mut said = Vec::new();
    for n in 0..60 {
        let time_ns = START_NS + n * PERIOD_NS;
        let pose = crate::ambiguity::tilted(0.5);
        said.extend(feed(&mut one, eye.image(0, time_ns, &pose, random)));
    }
    assert!(
        said.len() > 40 && one.faults().is_empty(),
        "{:?}",
        one.faults()
    );
    let several = fusion(&unplaced_rig, &unplaced(&cube()), FusionOptions::default());
    assert!(matches!(
        several.faults()[..],
        [Fault::ObjectUnplaced { .. }]
    ));
}
