//! Rigs that can be calibrated.

use crate::scene::*;
use nalgebra::{Isometry3, Vector3};
use sextant_calibrator::{CalibratedRig, Grade, Origin, RigError, RigPlan, RigSession, Up};
use sextant_geometry::{Pose, se3};
use sextant_site_model::{FOCAL_SIGMA, ImageObservation, ObjectModel, Prior, Rig};

pub fn calibrated(
    rig: &Rig,
    object: ObjectModel,
    origin: Origin,
    images: &[ImageObservation],
) -> Result<CalibratedRig, RigError> {
    let mut session = RigSession::new(rig.clone(), RigPlan { object, origin })?;
    images.iter().for_each(|image| session.handle(image));
    session.solve()
}

pub fn plainly(rig: &Rig, images: &[ImageObservation]) -> Result<CalibratedRig, RigError> {
    calibrated(&blind(rig), board(), Origin::FirstCamera, images)
}

/// Largest error of position (mm) and attitude (degrees) relative to the first camera.
pub fn errors(found: &Rig, truth: &Rig) -> (f64, f64) {
    let relative = |rig: &Rig, at: usize| {
        let pose = |at: usize| rig.cameras()[at].world_from_camera.unwrap();
        pose(0).inverse() * pose(at)
    };
    let error = |at| se3::difference(&relative(found, at), &relative(truth, at));
    let errors: Vec<_> = (1..truth.cameras().len()).map(error).collect();
    let worst = |first: usize| {
        errors
            .iter()
            .map(|e| e.fixed_rows::<3>(first).norm())
            .fold(0.0, f64::max)
    };
    (worst(0) * 1e3, worst(3).to_degrees())
}

#[test]
fn synchronised_cameras_are_found() {
    let truth = rig();
    let images = walk(&truth, &board(), 60, 0.12, SHARP, 1);
    let found = plainly(&truth, &images).unwrap();
    let (mm, deg) = errors(&found.rig, &truth);
    assert!(mm < 0.5 && deg < 0.02, "{mm} {deg}");
    assert_eq!(
        found.report.verdict.grade,
        Grade::Good,
        "{}",
        found.report.verdict
    );
    assert_eq!(
        found.rig.cameras()[0].world_from_camera,
        Some(Pose::identity())
    );
}

#[test]
fn the_rig_carries_the_deviations_that_the_report_states() {
    let truth = rig();
    let images = walk(&truth, &board(), 24, 0.3, SHARP, 10);
    let found = plainly(&truth, &images).unwrap();
    assert_eq!(found.rig.cameras()[0].pose_prior, Prior::Exact);
    for at in 1..4 {
        let sigma = found.rig.cameras()[at].pose_prior.given().unwrap();
        let stated = &found.report.cameras[at];
        assert!((1e-6..2e-3).contains(&sigma.position_m), "{sigma:?}");
        assert!((sigma.position_m * 1e3 - stated.sigma_mm).abs() < 1e-12);
        assert!((sigma.orientation_rad.to_degrees() - stated.sigma_deg).abs() < 1e-12);
    }
}

#[test]
fn the_first_camera_keeps_its_pose() {
    let truth = rig();
    let images = walk(&truth, &board(), 60, 0.12, SHARP, 2);
    let found = calibrated(&truth, board(), Origin::FirstCamera, &images).unwrap();
    let pose = |rig: &Rig| rig.cameras()[0].world_from_camera;
    assert_eq!(pose(&found.rig), pose(&truth));
}

#[test]
fn an_unknown_constellation_is_found_on_the_way() {
    let truth = rig();
    let seen = wand()
        .tags()
        .to_vec()
        .into_iter()
        .filter(|tag| tag.tag.id != 5); // it faces the floor
    let wand = ObjectModel::new("wand".parse().unwrap(), seen.collect()).unwrap();
    let images = walk(&truth, &wand, 60, 0.12, SHARP, 3);
    let unknown = changed(&wand, |tag| tag.object_from_tag = None);
    let found = calibrated(&blind(&truth), unknown, Origin::FirstCamera, &images).unwrap();
    let (mm, deg) = errors(&found.rig, &truth);
    assert!(mm < 3.0 && deg < 0.08, "{mm} {deg}");
}

#[test]
fn two_sides_that_no_image_joins_are_joined_by_the_cameras() {
    let truth = rig();
    let unknown = changed(&board(), |tag| tag.object_from_tag = None);
    let images = walk(&truth, &board(), 90, 0.12, SHARP, 50);
    let found = calibrated(&blind(&truth), unknown, Origin::FirstCamera, &images).unwrap();
    let (mm, deg) = errors(&found.rig, &truth);
    assert!(mm < 3.0 && deg < 0.1, "{mm} {deg} {}", found.report.verdict);
}

#[test]
fn two_sides_that_nothing_joins_are_named() {
    let truth = rig();
    let unknown = changed(&board(), |tag| tag.object_from_tag = None);
    let mut images = walk(&truth, &board(), 90, 0.12, SHARP, 51);
    for (at, pair) in images.chunks_mut(4).enumerate() {
        // First one side before all, then the other.
        for seen in pair {
            seen.tags.retain(|tag| (tag.tag.id < 12) == (at < 45));
        }
    }
    let found = calibrated(&blind(&truth), unknown, Origin::FirstCamera, &images).unwrap();
    let verdict = found.report.verdict.to_string();
    assert!(
        verdict.contains("groups that no image shows together")
            && verdict.contains("two cameras see a side each"),
        "{verdict}"
    );
}

#[test]
fn a_tag_on_the_floor_finds_out_a_board_that_was_enlarged_as_a_whole() {
    let truth = rig();
    let floor = object("floor", [(100, 0.2, Pose::identity())].into_iter());
    let mut images = walk(&truth, &board(), 60, 0.12, SHARP, 52);
    let enlarged = changed(&board(), |tag| {
        tag.size_m *= 1.02;
        tag.object_from_tag = tag.object_from_tag.map(|mut pose| {
            pose.translation.vector *= 1.02;
            pose
        });
    });
    let alone = calibrated(
        &blind(&truth),
        enlarged.clone(),
        Origin::FirstCamera,
        &images,
    )
    .unwrap();
    assert!(
        alone.report.scale.contains("cannot be detected"),
        "{}",
        alone.report.scale
    );
    let mut noise = Random::new(53);
    for (at, seen) in images.iter_mut().enumerate() {
        let camera = &truth.cameras()[at % 4];
        let more = image(camera, &floor, &Pose::identity(), 0.0, SHARP, &mut noise);
        seen.tags.extend(more.tags);
    }
    let origin = Origin::Tag(tag(100), 0.2);
    let found = calibrated(&blind(&truth), enlarged, origin, &images).unwrap();
    let verdict = found.report.verdict;
    assert_eq!(verdict.grade, Grade::Usable);
    assert!(
        verdict
            .to_string()
            .contains("tag36h11:100 is 2.0 % larger than given, according to the carried object"),
        "{verdict}"
    );
}

#[test]
fn thirty_per_cent_of_wrong_detections_do_no_harm() {
    let truth = rig();
    let wrong = Lack {
        wrong: 0.3,
        ..SHARP
    };
    let images = walk(&truth, &board(), 60, 0.12, wrong, 4);
    let found = plainly(&truth, &images).unwrap();
    let (mm, deg) = errors(&found.rig, &truth);
    assert!(mm < 0.8 && deg < 0.03, "{mm} {deg}");
}

#[test]
fn cameras_that_run_free_with_clocks_that_are_off_are_found() {
    let truth = rig();
    let mut noise = Random::new(5);
    let mut images = Vec::new();
    for at in 0..240 {
        for (index, camera) in truth.cameras().iter().enumerate() {
            let seconds = f64::from(at) / 30.0 + 0.0071 * index as f64;
            let late = [0.0, 0.05, -0.02, 0.0][index];
            let seen = (&board(), &carried(seconds));
            images.push(image(
                camera,
                seen.0,
                seen.1,
                seconds + late + 1.0,
                SHARP,
                &mut noise,
            ));
        }
    }
    let found = plainly(&truth, &images).unwrap();
    assert!(!found.report.synchronised);
    let (mm, deg) = errors(&found.rig, &truth);
    assert!(mm < 1.5 && deg < 0.06, "{mm} {deg}");
    for (camera, late) in found.report.cameras[1..].iter().zip([50.0, -20.0, 0.0]) {
        let off = camera.clock_offset_ms.unwrap() - late;
        assert!(off.abs() < 0.5, "{camera:?}");
    }
}

#[test]
fn stamps_that_jitter_invent_no_clock_offsets() {
    let truth = rig();
    let mut noise = Random::new(8);
    let mut images = Vec::new();
    for at in 0..200 {
        for (index, camera) in truth.cameras().iter().enumerate() {
            let seconds = f64::from(at) / 15.0 + 0.0071 * index as f64;
            let late = 0.012 * noise.normal();
            let seen = (&board(), &carried(seconds));
            images.push(image(
                camera,
                seen.0,
                seen.1,
                seconds + late + 1.0,
                SHARP,
                &mut noise,
            ));
        }
    }
    let found = plainly(&truth, &images).unwrap();
    assert!(!found.report.synchronised);
    for camera in &found.report.cameras {
        let off_ms = camera.clock_offset_ms.unwrap_or(0.0);
        assert!(off_ms.abs() < 8.0, "{camera:?}");
    }
    let (mm, deg) = errors(&found.rig, &truth);
    assert!(mm < 6.0 && deg < 0.4, "{mm} {deg}");
}

#[test]
fn a_clock_that_is_off_by_50_ms_is_found_and_allowed_for() {
    let truth = rig();
    let mut images = walk(&truth, &board(), 100, 0.1, SHARP, 6);
    for image in images.iter_mut().filter(|i| i.camera == camera_id(2)) {
        let true_s = (image.capture_ns - 1_000_000_000) as f64 * 1e-9;
        let late = carried(true_s - 0.05);
        let camera = &truth.cameras()[2];
        let seen = (&board(), &late);
        *image = crate::scene::image(
            camera,
            seen.0,
            seen.1,
            true_s,
            SHARP,
            &mut Random::new(image.capture_ns),
        );
    }
    let found = plainly(&truth, &images).unwrap();
    let ms = found.report.cameras[2].clock_offset_ms.unwrap();
    assert!((ms - 50.0).abs() < 3.0, "{ms}");
    let (mm, deg) = errors(&found.rig, &truth);
    assert!(mm < 3.0 && deg < 0.1, "{mm} {deg}");
    assert!(
        found
            .report
            .verdict
            .to_string()
            .contains(" ahead of those of the others")
    );
}

#[test]
fn cameras_are_joined_through_others() {
    let truth = rig();
    let mut images = walk(&truth, &board(), 120, 0.06, SHARP, 7);
    // a and c never see the board at the same time.
    for pair in images.chunks_mut(4) {
        if pair[0].tags.len() > pair[2].tags.len() {
            pair[2].tags.clear();
        } else {
            pair[0].tags.clear();
        }
    }
    let found = plainly(&truth, &images).unwrap();
    let (mm, deg) = errors(&found.rig, &truth);
    assert!(mm < 1.0 && deg < 0.03, "{mm} {deg}");
}

#[test]
fn a_tag_on_the_floor_is_the_world() {
    let truth = rig();
    let world_from_floor =
        Isometry3::new(Vector3::new(0.2, -0.1, 0.0), Vector3::new(0.0, 0.0, 0.8));
    let floor = object("floor", [(100, 0.2, Pose::identity())].into_iter());
    let mut images = walk(&truth, &board(), 60, 0.12, SHARP, 8);
    let mut noise = Random::new(9);
    for (at, seen) in images.iter_mut().enumerate() {
        let camera = &truth.cameras()[at % 4];
        let more = image(camera, &floor, &world_from_floor, 0.0, SHARP, &mut noise);
        seen.tags.extend(more.tags);
    }
    let origin = Origin::Tag(tag(100), 0.2);
    let found = calibrated(&blind(&truth), board(), origin, &images).unwrap();
    for (found, truth) in found.rig.cameras().iter().zip(truth.cameras()) {
        let right = world_from_floor.inverse() * truth.world_from_camera.unwrap();
        let error = se3::difference(&found.world_from_camera.unwrap(), &right);
        assert!(
            error.fixed_rows::<3>(0).norm() < 2e-3 && error.fixed_rows::<3>(3).norm() < 1e-3,
            "{error}"
        );
    }
}

/// A walk in a room with a tag that lies on something level, one that hangs upright and two on a plumb line.
fn walk_by_gravity(truth: &Rig) -> Vec<ImageObservation> {
    let hanging = |x: f64, z: f64| {
        let turn = Vector3::new(std::f64::consts::FRAC_PI_2, 0.0, 0.0);
        Isometry3::new(Vector3::new(x, 0.1, z), turn)
    };
    let lying = Isometry3::new(Vector3::new(0.2, -0.1, 0.4), Vector3::new(0.0, 0.0, 0.8));
    let tags = [
        (100, 0.2, lying),
        (101, 0.2, hanging(-0.3, 0.8)),
        (102, 0.2, hanging(0.0, 0.3)),
        (103, 0.2, hanging(0.0, 1.0)),
    ];
    let still = object("still", tags.into_iter());
    let mut images = walk(truth, &board(), 40, 0.12, SHARP, 40);
    let mut noise = Random::new(41);
    for (at, seen) in images.iter_mut().enumerate() {
        let camera = &truth.cameras()[at % 4];
        let more = image(camera, &still, &Pose::identity(), 0.0, SHARP, &mut noise);
        seen.tags.extend(more.tags);
    }
    images
}

#[test]
fn what_lies_hangs_or_stands_on_a_plumb_line_says_what_is_up() {
    let truth = rig();
    let images = walk_by_gravity(&truth);
    let ups = [
        Up::Flat(tag(100), 0.2),
        Up::Upright(tag(101), 0.2),
        Up::Plumb([tag(102), tag(103)], 0.2),
    ];
    for up in ups {
        let origin = Origin::Levelled(Box::new(Origin::FirstCamera), up.clone());
        let found = calibrated(&blind(&truth), board(), origin, &images).unwrap();
        let (mm, deg) = errors(&found.rig, &truth);
        assert!(mm < 0.8 && deg < 0.03, "{mm} {deg}");
        let first = found.rig.cameras()[0].world_from_camera.unwrap();
        assert!(first.translation.vector.norm() < 1e-9);
        let up_in_camera = |pose: &Pose| pose.rotation.inverse() * Vector3::z();
        let right = up_in_camera(&truth.cameras()[0].world_from_camera.unwrap());
        let off = up_in_camera(&first).angle(&right).to_degrees();
        assert!(off < 0.15, "{up:?}: {off}");
    }
}

#[test]
fn two_cameras_that_see_the_board_from_the_front_only_are_found() {
    let side_by_side = [-0.15, 0.15].map(|x| above(x, 1.2));
    let cameras = rig().cameras().to_vec();
    let cameras = cameras.into_iter().zip(side_by_side);
    let cameras = cameras.map(|(camera, pose)| sextant_site_model::Camera {
        world_from_camera: Some(pose),
        ..camera
    });
    let truth = Rig::new(cameras.collect()).unwrap();
    let mut noise = Random::new(42);
    let mut images = Vec::new();
    for at in 0..60 {
        let way = 0.3 * f64::from(at);
        let place = Vector3::new(
            0.2 * way.sin(),
            0.15 * (1.3 * way).cos(),
            0.1 * (0.4 * way).sin(),
        );
        for camera in truth.cameras() {
            let seen = (&board(), &Isometry3::new(place, Vector3::zeros()));
            images.push(image(
                camera,
                seen.0,
                seen.1,
                0.1 * f64::from(at),
                SHARP,
                &mut noise,
            ));
        }
    }
    let found = plainly(&truth, &images).unwrap();
    let (mm, deg) = errors(&found.rig, &truth);
    let stated = &found.report.cameras[1];
    assert!(
        mm < 3.0 * 1.8 * stated.sigma_mm && deg < 3.0 * 1.8 * stated.sigma_deg,
        "{mm} {deg} {stated:?}"
    );
    assert!(mm < 2.0 && deg < 0.1, "{mm} {deg} {}", found.report.verdict);
}

/// The largest error in reported deviations, over all cameras but the first.
fn worst_in_sigmas(found: &CalibratedRig, truth: &Rig) -> f64 {
    let relative = |rig: &Rig, at: usize| {
        let pose = |at: usize| rig.cameras()[at].world_from_camera.unwrap();
        pose(0).inverse() * pose(at)
    };
    let of = |at: usize| {
        let error = se3::difference(&relative(&found.rig, at), &relative(truth, at));
        let stated = &found.report.cameras[at];
        let mm = error.fixed_rows::<3>(0).norm() * 1e3 / (stated.sigma_mm * 3_f64.sqrt());
        let deg = error.fixed_rows::<3>(3).norm().to_degrees();
        mm.max(deg / (stated.sigma_deg * 3_f64.sqrt()))
    };
    (1..truth.cameras().len()).map(of).fold(0.0, f64::max)
}

#[test]
fn tags_glued_on_by_hand_cost_next_to_nothing() {
    let truth = rig();
    let mut noise = Random::new(60);
    let tags = board().tags().to_vec().into_iter().map(|mut tag| {
        let mut normal = |sigma: f64| Vector3::from_fn(|_, _| noise.normal() * sigma);
        let glued = Isometry3::new(normal(0.001), normal(0.017));
        tag.object_from_tag = tag.object_from_tag.map(|pose| pose * glued);
        tag
    });
    let glued = ObjectModel::new("board".parse().unwrap(), tags.collect()).unwrap();
    let images = walk(&truth, &glued, 60, 0.12, SHARP, 61);
    let exact = calibrated(&blind(&truth), glued, Origin::FirstCamera, &images).unwrap();
    let found = plainly(&truth, &images).unwrap();
    let (mm, deg) = errors(&found.rig, &truth);
    let (least_mm, least_deg) = errors(&exact.rig, &truth);
    assert!(mm < 2.0 * least_mm + 0.2, "{mm} {least_mm}");
    assert!(deg < 2.0 * least_deg + 0.01, "{deg} {least_deg}");
    assert!(worst_in_sigmas(&found, &truth) < 3.0);
    let left_out = found.report.cameras.iter().map(|camera| camera.left_out);
    assert_eq!(left_out.sum::<usize>(), 0);
}

#[test]
fn focal_lengths_of_another_day_are_put_right() {
    let truth = rig();
    let images = walk(&truth, &board(), 60, 0.12, SHARP, 62);
    let mut off = [1.01, 0.995, 1.004, 0.988].into_iter();
    let former = with_focal_lengths_off(&truth, || off.next().unwrap());
    let found = plainly(&former, &images).unwrap();
    let (mm, deg) = errors(&found.rig, &truth);
    assert!(mm < 3.0 && deg < 0.1, "{mm} {deg} {}", found.report.verdict);
    assert!(worst_in_sigmas(&found, &truth) < 3.0);
    for (found, truth) in found.rig.cameras().iter().zip(truth.cameras()) {
        let focal = |camera: &sextant_site_model::Camera| camera.lens.intrinsics().fx;
        let off = focal(found) / focal(truth) - 1.0;
        assert!(off.abs() < 1e-3, "{}: {off}", found.id);
    }
}

#[test]
fn a_camera_alone_among_others_keeps_its_pose_and_is_named() {
    let truth = rig();
    let mut images = walk(&truth, &board(), 60, 0.12, SHARP, 63);
    for seen in images.iter_mut().filter(|i| i.camera == camera_id(0)) {
        seen.tags.clear();
    }
    let found = calibrated(&truth, board(), Origin::FirstCamera, &images).unwrap();
    let unsolved = found.report.unsolved.join("; ");
    assert!(
        unsolved.contains("camera a never saw the object"),
        "{unsolved}"
    );
    assert_eq!(found.rig.cameras()[0], truth.cameras()[0]);
    assert_eq!(found.report.reference, "b");
    assert_eq!(found.report.cameras.len(), 3);
}

/// Part of the true values within two reported deviations.
fn part_within(seeds: std::ops::Range<u64>) -> f64 {
    let truth = rig();
    let (mut inside, mut all) = (0, 0);
    for seed in seeds {
        let images = walk(
            &truth,
            &board(),
            24,
            0.3,
            Lack {
                sigma_px: 0.2,
                wrong: 0.0,
            },
            seed,
        );
        // Lenses are off by as much as such lenses are.
        let mut noise = Random::new(seed + 1000);
        let former = with_focal_lengths_off(&truth, || 1.0 + FOCAL_SIGMA * noise.normal());
        let found = plainly(&former, &images).unwrap();
        let relative = |rig: &Rig, at: usize| {
            let pose = |at: usize| rig.cameras()[at].world_from_camera.unwrap();
            pose(0).inverse() * pose(at)
        };
        for at in 1..4 {
            let error = se3::difference(&relative(&found.rig, at), &relative(&truth, at));
            let stated = &found.report.cameras[at];
            for axis in 0..3 {
                inside += usize::from(error[axis].abs() * 1e3 <= 2.0 * stated.sigma_axes_mm[axis]);
                inside += usize::from(
                    error[3 + axis].abs().to_degrees() <= 2.0 * stated.sigma_axes_deg[axis],
                );
                all += 2;
            }
        }
    }
    inside as f64 / f64::from(all)
}

#[test]
fn stated_deviations_are_honest() {
    let part = part_within(20..32);
    assert!((0.9..=0.99).contains(&part), "{part}");
}
