//! The laws of the planar pose: exact corners give the pose back, and noisy ones two that both explain them.

use crate::generators::{lens, vector};
use nalgebra::{Point2, Point3, SVector, Vector2, Vector3};
use proptest::prelude::*;
use sextant_geometry::planar_pose::{PlanarPoseError, PlanarPoses, solve_square};
use sextant_geometry::{Intrinsics, Lens, Pose, se3, so3, tag_corners_in_tag};
use std::f64::consts::{PI, TAU};

const SIZE_M: f64 = 0.04;

/// A tag that turns its face to the camera: `tilt` from the line of sight, towards `heading`, rolled by `roll`.
fn facing(tilt: f64, heading: f64, roll: f64, sight: Vector3<f64>, distance_m: f64) -> Pose {
    let upright = so3::exp(&(Vector3::x() * PI));
    let tilted = so3::exp(&(Vector3::new(heading.cos(), heading.sin(), 0.0) * tilt));
    let rolled = so3::exp(&(Vector3::z() * roll));
    let towards = nalgebra::UnitQuaternion::rotation_between(&Vector3::z(), &sight).unwrap();
    Pose::from_parts(
        (sight.normalize() * distance_m).into(),
        towards * tilted * upright * rolled,
    )
}

fn tag_pose(max_tilt_degrees: f64) -> impl Strategy<Value = Pose> {
    let angles = (0.0..max_tilt_degrees.to_radians(), 0.0..TAU, 0.0..TAU);
    (angles, vector::<2>(0.3), 0.1..1.5).prop_map(|((tilt, heading, roll), sight, distance_m)| {
        facing(
            tilt,
            heading,
            roll,
            Vector3::new(sight.x, sight.y, 1.0),
            distance_m,
        )
    })
}

fn project(lens: &Lens, camera_from_tag: &Pose, size_m: f64) -> Option<[Point2<f64>; 4]> {
    let mut corners = [Point2::origin(); 4];
    for (pixel, corner) in corners.iter_mut().zip(tag_corners_in_tag(size_m)) {
        *pixel = lens.project(&(camera_from_tag * corner))?;
    }
    Some(corners)
}

fn pinhole() -> Lens {
    Lens::pinhole(Intrinsics {
        fx: 600.0,
        fy: 600.0,
        cx: 319.5,
        cy: 239.5,
    })
    .unwrap()
}

fn rms_px(lens: &Lens, camera_from_tag: &Pose, size_m: f64, seen: &[Point2<f64>; 4]) -> f64 {
    let reprojected = project(lens, camera_from_tag, size_m).unwrap();
    let sum: f64 = reprojected
        .iter()
        .zip(seen)
        .map(|(a, b)| (a - b).norm_squared())
        .sum();
    (sum / 4.0).sqrt()
}

/// What holds for whatever corners: finite, before the camera, errors as stated, best first, face to the camera.
fn check_poses(lens: &Lens, seen: &[Point2<f64>; 4], size_m: f64, poses: &PlanarPoses) {
    let mut last = 0.0;
    for pose in poses.iter() {
        let camera_from_tag = &pose.camera_from_tag;
        assert!(se3::log(camera_from_tag).iter().all(|x| x.is_finite()));
        assert!((camera_from_tag.rotation.norm() - 1.0).abs() < 1e-12);
        assert!(
            tag_corners_in_tag(size_m)
                .iter()
                .all(|corner| (camera_from_tag * corner).z > 0.0)
        );
        let rms = rms_px(lens, camera_from_tag, size_m, seen);
        assert!(
            (rms - pose.rms_px).abs() <= 1e-6 * (1.0 + rms),
            "{rms} is not {}",
            pose.rms_px
        );
        assert!(pose.rms_px >= last, "best first");
        last = pose.rms_px;
        let normal = camera_from_tag.rotation * Vector3::z();
        assert!(
            normal.dot(&camera_from_tag.translation.vector) < 0.0,
            "the face is seen"
        );
    }
}

/// The reprojection error has no slope at a minimum.
fn slope(lens: &Lens, camera_from_tag: &Pose, size_m: f64, seen: &[Point2<f64>; 4]) -> f64 {
    let cost = |step: &SVector<f64, 6>| {
        // Translations in tag sizes, so that both halves weigh alike.
        let scale = SVector::<f64, 6>::new(size_m, size_m, size_m, 1.0, 1.0, 1.0);
        let moved = se3::perturb(camera_from_tag, &step.component_mul(&scale));
        SVector::<f64, 1>::new(rms_px(lens, &moved, size_m, seen).powi(2))
    };
    crate::numeric::jacobian_at_zero(cost).amax()
}

proptest! {
    #[test]
    fn exact_corners_give_the_pose_back(lens in lens(), camera_from_tag in tag_pose(75.0)) {
        let Some(seen) = project(&lens, &camera_from_tag, SIZE_M) else { return Ok(()) };
        let poses = solve_square(&lens, &seen, SIZE_M).unwrap();
        check_poses(&lens, &seen, SIZE_M, &poses);
        prop_assert!(poses.best().rms_px < 1e-5, "{}", poses.best().rms_px);
        // The error is quartic in the tilt of a tag seen face on, so that an error of nothing still leaves an angle.
        let off = |pose: &Pose| se3::difference(pose, &camera_from_tag);
        let nearest = poses.iter().map(|pose| off(&pose.camera_from_tag).norm()).fold(f64::INFINITY, f64::min);
        prop_assert!(nearest < 1e-2, "{nearest}");
    }

    #[test]
    fn a_tilted_tag_is_found_to_a_millionth(lens in lens(), heading in 0.0..TAU, roll in 0.0..TAU) {
        let camera_from_tag = facing(0.7, heading, roll, Vector3::new(0.05, 0.1, 1.0), 0.4);
        let seen = project(&lens, &camera_from_tag, SIZE_M).unwrap();
        let poses = solve_square(&lens, &seen, SIZE_M).unwrap();
        let off = se3::difference(&poses.best().camera_from_tag, &camera_from_tag);
        prop_assert!(off.norm() < 1e-6, "{off}");
    }

    #[test]
    fn noisy_corners_give_a_minimum_as_best(
        lens in lens(), camera_from_tag in tag_pose(70.0), noise in vector::<8>(0.3)
    ) {
        let Some(exact) = project(&lens, &camera_from_tag, SIZE_M) else { return Ok(()) };
        let seen = std::array::from_fn(|i| exact[i] + Vector2::new(noise[2 * i], noise[2 * i + 1]));
        let Ok(poses) = solve_square(&lens, &seen, SIZE_M) else {
            // Noise may turn a tag of a few pixels inside out, or throw it out of the field.
            return Ok(());
        };
        check_poses(&lens, &seen, SIZE_M, &poses);
        let true_rms_px = rms_px(&lens, &camera_from_tag, SIZE_M, &seen);
        prop_assert!(poses.best().rms_px <= true_rms_px + 1e-9, "at least as good as the truth");
        // The other branch may still be on its way where it is about to merge into the best.
        let extent = (seen[0] - seen[2]).norm();
        prop_assert!(slope(&lens, &poses.best().camera_from_tag, SIZE_M, &seen) < 1e-3 * extent);
    }

    #[test]
    fn size_scales_the_translation_and_nothing_else(camera_from_tag in tag_pose(60.0), exponent in -4.0..4.0) {
        let seen = project(&pinhole(), &camera_from_tag, SIZE_M).unwrap();
        let scale = 10_f64.powf(exponent);
        let small = solve_square(&pinhole(), &seen, SIZE_M).unwrap();
        let large = solve_square(&pinhole(), &seen, SIZE_M * scale).unwrap();
        let (small, large) = (small.best().camera_from_tag, large.best().camera_from_tag);
        prop_assert!((small.rotation.coords - large.rotation.coords).amax() < 1e-12);
        prop_assert!((small.translation.vector * scale - large.translation.vector).norm() < 1e-12 * scale);
    }

    #[test]
    fn no_corners_give_nan(lens in lens(), corners in prop::array::uniform8(any::<f64>()), size_m in any::<f64>()) {
        let seen = std::array::from_fn(|i| Point2::new(corners[2 * i], corners[2 * i + 1]));
        if let Ok(poses) = solve_square(&lens, &seen, size_m) {
            check_poses(&lens, &seen, size_m, &poses);
        }
    }

    #[test]
    fn random_quadrilaterals_give_poses_before_the_camera(
        lens in lens(),
        corners in prop::array::uniform8(0.0..640.0),
    ) {
        let seen = std::array::from_fn(|i| Point2::new(corners[2 * i], corners[2 * i + 1]));
        if let Ok(poses) = solve_square(&lens, &seen, 1.0) {
            check_poses(&lens, &seen, 1.0, &poses);
        }
    }
}

#[test]
fn a_small_tilted_tag_has_two_poses_that_mirror_each_other() {
    let tilt = 0.4;
    let camera_from_tag = facing(tilt, 0.0, 0.0, Vector3::z(), 1.2);
    let seen = project(&pinhole(), &camera_from_tag, SIZE_M).unwrap();
    let poses = solve_square(&pinhole(), &seen, SIZE_M).unwrap();
    let other = poses.other().expect("a 20 px tag is ambiguous");
    assert!(
        poses.best().rms_px < 1e-6 && other.rms_px < 0.2,
        "{}",
        other.rms_px
    );
    let apart = poses
        .best()
        .camera_from_tag
        .rotation
        .angle_to(&other.camera_from_tag.rotation);
    assert!((apart - 2.0 * tilt).abs() < 0.05, "{apart}");
}

#[test]
fn half_a_tenth_of_a_pixel_decides_for_the_wrong_branch_and_the_right_one_is_still_there() {
    let camera_from_tag = facing(0.35, 0.3, 0.2, Vector3::z(), 1.2);
    let exact = project(&pinhole(), &camera_from_tag, SIZE_M).unwrap();
    let wrong = *solve_square(&pinhole(), &exact, SIZE_M)
        .unwrap()
        .other()
        .unwrap();
    let towards = project(&pinhole(), &wrong.camera_from_tag, SIZE_M).unwrap();
    let seen: [Point2<f64>; 4] = std::array::from_fn(|i| exact[i] + (towards[i] - exact[i]) * 0.7);
    let poses = solve_square(&pinhole(), &seen, SIZE_M).unwrap();
    let angle = |pose: &Pose| pose.rotation.angle_to(&camera_from_tag.rotation);
    assert!(
        angle(&poses.best().camera_from_tag) > 0.5,
        "the wrong one is best"
    );
    assert!(
        angle(&poses.other().unwrap().camera_from_tag) < 0.1,
        "the right one is given as well"
    );
}

#[test]
fn a_large_tag_face_on_has_its_pose() {
    let camera_from_tag = facing(0.0, 0.0, 0.5, Vector3::z(), 0.3);
    let seen = project(&pinhole(), &camera_from_tag, 0.1).unwrap();
    let poses = solve_square(&pinhole(), &seen, 0.1).unwrap();
    let off = se3::difference(&poses.best().camera_from_tag, &camera_from_tag);
    assert!(
        off.fixed_rows::<3>(0).norm() < 1e-6 && off.norm() < 1e-2,
        "{off}"
    );
}

#[test]
fn corners_that_are_no_tag_are_refused() {
    let square = [
        [100.0, 100.0],
        [200.0, 100.0],
        [200.0, 200.0],
        [100.0, 200.0],
    ];
    let solve = |corners: [[f64; 2]; 4]| {
        solve_square(&pinhole(), &corners.map(Point2::from), SIZE_M).unwrap_err()
    };
    let [a, b, c, d] = square;
    assert_eq!(
        solve([d, c, b, a]),
        PlanarPoseError::NotATag,
        "seen from behind"
    );
    assert_eq!(solve([a, c, b, d]), PlanarPoseError::NotATag, "crossed");
    assert_eq!(solve([a, a, a, a]), PlanarPoseError::NotATag, "a point");
    assert_eq!(
        solve([a, b, c, [180.0, 120.0]]),
        PlanarPoseError::NotATag,
        "a dart"
    );
    assert!(matches!(
        solve([a, b, [f64::NAN, 0.0], d]),
        PlanarPoseError::Corner { corner: 2, .. }
    ));
}

#[test]
fn sizes_that_are_none_are_refused() {
    let square = [
        [100.0, 100.0],
        [200.0, 100.0],
        [200.0, 200.0],
        [100.0, 200.0],
    ]
    .map(Point2::from);
    for size_m in [0.0, -0.04, 1e-7, 1e7, f64::NAN, f64::INFINITY] {
        assert!(
            matches!(
                solve_square(&pinhole(), &square, size_m),
                Err(PlanarPoseError::Size(_))
            ),
            "{size_m}"
        );
    }
}

#[test]
fn a_corner_outside_the_lens_field_is_named() {
    let lens = Lens::kannala_brandt(pinhole().intrinsics(), [-0.3, 0.0, 0.0, 0.0]).unwrap();
    let corners = [
        [300.0, 200.0],
        [3000.0, 200.0],
        [3000.0, 300.0],
        [300.0, 300.0],
    ]
    .map(Point2::from);
    let error = solve_square(&lens, &corners, SIZE_M).unwrap_err();
    assert!(
        error
            .to_string()
            .starts_with("corner 1: pixel (3000.0, 200.0) is outside the valid field"),
        "{error}"
    );
}

#[test]
fn the_whole_tag_lies_before_the_camera_even_when_it_nearly_touches_it() {
    let camera_from_tag = facing(1.2, 0.3, 0.0, Vector3::z(), 0.05);
    let near = tag_corners_in_tag(SIZE_M).map(|corner: Point3<f64>| (camera_from_tag * corner).z);
    assert!(near.iter().all(|&z| z > 0.0));
    let seen = project(&pinhole(), &camera_from_tag, SIZE_M).unwrap();
    let poses = solve_square(&pinhole(), &seen, SIZE_M).unwrap();
    check_poses(&pinhole(), &seen, SIZE_M, &poses);
    assert!(se3::difference(&poses.best().camera_from_tag, &camera_from_tag).norm() < 1e-6);
}

#[test]
fn both_branches_agree_with_opencv() {
    // solvePnPGeneric with SOLVEPNP_IPPE_SQUARE, each branch then refined by solvePnPRefineLM, OpenCV 5.0.
    let lens = Lens::pinhole(Intrinsics {
        fx: 600.0,
        fy: 590.0,
        cx: 320.0,
        cy: 240.0,
    })
    .unwrap();
    let seen = [
        [300.0, 210.0],
        [345.0, 214.0],
        [341.0, 262.0],
        [297.0, 255.0],
    ]
    .map(Point2::from);
    let poses = solve_square(&lens, &seen, SIZE_M).unwrap();
    let expected = [
        (
            [3.52680168e-4, -3.94874302e-3, 0.500496714],
            [-2.95596797, -0.14818396, 0.5617083],
        ),
        (
            [8.8024e-4, -4.12795e-3, 0.50429131],
            [2.98515041, 0.14555076, 0.50796491],
        ),
    ];
    assert_eq!(poses.iter().count(), 2);
    for (pose, (position, rotation)) in poses.iter().zip(expected) {
        let theirs = Pose::from_parts(Vector3::from(position).into(), so3::exp(&rotation.into()));
        let off = se3::difference(&pose.camera_from_tag, &theirs);
        assert!(off.norm() < 1e-4, "{off}");
    }
}
