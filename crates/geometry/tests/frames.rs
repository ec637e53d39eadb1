//! One test for each numbered sentence of FRAMES.md, named after it.

#![allow(clippy::unwrap_used, reason = "tests")]

use nalgebra::{
    Isometry3, Point2, Point3, SMatrix, Translation3, UnitQuaternion, Vector3, Vector6,
};
use sextant_geometry::least_squares::{self, Kernel, NormalEquations, Problem};
use sextant_geometry::{
    Intrinsics, Lens, Pose, PoseParts, planar_pose, se3, so3, tag_corners_in_tag,
};
use std::f64::consts::{FRAC_PI_2, PI};

const WIDTH: f64 = 640.0;
const HEIGHT: f64 = 480.0;

/// A camera whose optical axis meets the middle of its 640 x 480 image.
fn lens() -> Lens {
    Lens::pinhole(Intrinsics {
        fx: 600.0,
        fy: 600.0,
        cx: 319.5,
        cy: 239.5,
    })
    .unwrap()
}

fn pose(position: [f64; 3], rotation: [f64; 3]) -> Pose {
    Isometry3::from_parts(
        Translation3::from(Vector3::from(position)),
        so3::exp(&rotation.into()),
    )
}

/// A tag one metre before the camera, upright and face on.
fn camera_from_upright_tag() -> Pose {
    pose([0.0, 0.0, 1.0], [PI, 0.0, 0.0])
}

/// A camera at (2, 0, 1) in the world that looks at the world's z axis, horizontally and upright.
fn world_from_camera() -> Pose {
    let (right, down, forward) = (Vector3::y(), -Vector3::z(), -Vector3::x());
    let axes = nalgebra::Rotation3::from_basis_unchecked(&[right, down, forward]);
    Isometry3::from_parts(
        Translation3::new(2.0, 0.0, 1.0),
        UnitQuaternion::from_rotation_matrix(&axes),
    )
}

fn corners_in_image(camera_from_tag: &Pose, size_m: f64) -> [Point2<f64>; 4] {
    tag_corners_in_tag(size_m).map(|corner| lens().project(&(camera_from_tag * corner)).unwrap())
}

fn assert_near<const N: usize>(a: [f64; N], b: [f64; N]) {
    let near = a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-9);
    assert!(near, "{a:?} is not {b:?}");
}

#[test]
fn s01_lengths_are_metres_and_angles_radians() {
    // A 0.1 m tag a metre away, seen with f = 600 px, is 60 px wide.
    let [top_left, top_right, ..] = corners_in_image(&camera_from_upright_tag(), 0.1);
    assert_near([top_right.x - top_left.x], [60.0]);
    assert_near(
        [so3::exp(&Vector3::new(0.0, 0.0, FRAC_PI_2)).angle()],
        [FRAC_PI_2],
    );
    // Seconds: a velocity of 1 m/s for half a second.
    assert_near([se3::exp(&(Vector6::x() * 0.5)).translation.x], [0.5]);
}

#[test]
fn s02_a_time_is_nanoseconds_since_the_epoch_and_capture_the_middle_of_the_exposure() {
    // Geometry knows no time: what this sentence asks of it is that no lens, pose or step carries one.
    // The middle of the exposure is where linear motion blur leaves a point: half way between the two ends.
    let velocity = Vector6::new(0.2, -0.1, 0.0, 0.0, 0.0, 0.0);
    let (start_ns, end_ns) = (1_700_000_000_000_000_000_u64, 1_700_000_000_010_000_000_u64);
    let capture_ns = start_ns + (end_ns - start_ns) / 2;
    let at = |t_ns: u64| se3::exp(&(velocity * ((t_ns - start_ns) as f64 * 1e-9)));
    let middle = (at(start_ns).translation.vector + at(end_ns).translation.vector) * 0.5;
    assert_near(at(capture_ns).translation.vector.into(), middle.into());
}

#[test]
fn s03_a_from_b_maps_points_of_b_into_a() {
    let world_from_object = pose([1.0, 2.0, 3.0], [0.0, 0.0, FRAC_PI_2]);
    let origin_in_world = world_from_object * Point3::origin();
    let x_in_world = world_from_object * Point3::new(1.0, 0.0, 0.0);
    assert_near(origin_in_world.into(), [1.0, 2.0, 3.0]);
    assert_near(x_in_world.into(), [1.0, 3.0, 3.0]);
}

#[test]
fn s04_products_cancel_inwards() {
    let world_from_tag = world_from_camera() * camera_from_upright_tag();
    let corner = Point3::new(0.1, 0.2, 0.0);
    let step_by_step = world_from_camera() * (camera_from_upright_tag() * corner);
    assert_near((world_from_tag * corner).into(), step_by_step.into());
    assert_near((world_from_tag * Point3::origin()).into(), [1.0, 0.0, 1.0]);
}

#[test]
fn s05_a_quaternion_is_written_x_y_z_w() {
    let half = FRAC_PI_2 / 2.0;
    let quarter_turn_about_z = pose([0.0; 3], [0.0, 0.0, FRAC_PI_2]);
    let written = PoseParts::from(&quarter_turn_about_z).orientation;
    assert_near(written, [0.0, 0.0, half.sin(), half.cos()]);
    let read: PoseParts =
        toml::from_str("position = [0, 0, 0]\norientation = [1, 0, 0, 0]").unwrap();
    assert_near(
        (read.to_pose().unwrap() * Point3::new(1.0, 1.0, 0.0)).into(),
        [1.0, -1.0, 0.0],
    );
}

#[test]
fn s06_the_world_is_right_handed_with_z_up() {
    // A point above the one looked at lies higher up in the image of an upright camera.
    let camera_from_world = world_from_camera().inverse();
    let at = |z: f64| {
        lens()
            .project(&(camera_from_world * Point3::new(0.0, 0.0, z)))
            .unwrap()
    };
    assert!(at(1.2).y < at(1.0).y);
    let image_of = |v: Vector3<f64>| world_from_camera().rotation * v;
    assert_near(
        image_of(Vector3::x()).cross(&image_of(Vector3::y())).into(),
        image_of(Vector3::z()).into(),
    );
}

#[test]
fn s07_the_camera_looks_along_z_with_x_right_and_y_down() {
    let centre = lens().project(&Point3::new(0.0, 0.0, 1.0)).unwrap();
    let right = lens().project(&Point3::new(0.1, 0.0, 1.0)).unwrap();
    let down = lens().project(&Point3::new(0.0, 0.1, 1.0)).unwrap();
    assert!(right.x > centre.x && right.y == centre.y);
    assert!(down.y > centre.y && down.x == centre.x);
    assert_eq!(lens().project(&Point3::new(0.0, 0.0, -1.0)), None);
}

#[test]
fn s08_pixel_zero_is_the_centre_of_the_top_left_pixel() {
    // Its principal point in the middle of the image, a lens sees equally far to both edges of the outermost pixels.
    let left = lens().undistort(&Point2::new(-0.5, -0.5)).unwrap();
    let right = lens()
        .undistort(&Point2::new(WIDTH - 0.5, HEIGHT - 0.5))
        .unwrap();
    assert_near([left.x, left.y], [-right.x, -right.y]);
}

#[test]
fn s09_numbers_of_the_apriltag_library_are_half_a_pixel_larger() {
    // It counts from the outer corner of the top left pixel: the image's middle is (w/2, h/2) there.
    let middle = lens().project(&Point3::new(0.0, 0.0, 1.0)).unwrap();
    assert_near(
        [middle.x + 0.5, middle.y + 0.5],
        [WIDTH / 2.0, HEIGHT / 2.0],
    );
}

#[test]
fn s10_a_normalised_point_is_the_image_of_an_ideal_lens_of_focal_length_one() {
    let point_in_camera = Point3::new(0.3, -0.2, 2.0);
    let pixel = lens().project(&point_in_camera).unwrap();
    let normalised = lens().undistort(&pixel).unwrap();
    assert_near([normalised.x, normalised.y], [0.15, -0.1]);
}

#[test]
fn s11_a_tags_origin_is_its_centre_and_its_face_the_plane_z_0() {
    let corners = tag_corners_in_tag(0.04);
    let sum = corners
        .iter()
        .fold(Vector3::zeros(), |sum, corner| sum + corner.coords);
    assert_near(sum.into(), [0.0; 3]);
    assert!(corners.iter().all(|corner| corner.z == 0.0));
}

#[test]
fn s12_for_the_viewer_of_the_upright_tag_x_is_right_y_up_and_z_towards_him() {
    let in_camera = |x, y, z| camera_from_upright_tag() * Point3::new(x, y, z);
    let pixel = |x, y, z| lens().project(&in_camera(x, y, z)).unwrap();
    assert!(pixel(0.1, 0.0, 0.0).x > pixel(0.0, 0.0, 0.0).x);
    assert!(
        pixel(0.0, 0.1, 0.0).y < pixel(0.0, 0.0, 0.0).y,
        "up is towards row 0"
    );
    assert!(
        in_camera(0.0, 0.0, 0.1).z < in_camera(0.0, 0.0, 0.0).z,
        "nearer to the camera"
    );
}

#[test]
fn s13_a_tags_size_is_the_edge_of_its_black_square() {
    let [top_left, top_right, bottom_right, _] = tag_corners_in_tag(0.08);
    assert_near(
        [
            (top_right - top_left).norm(),
            (bottom_right - top_right).norm(),
        ],
        [0.08, 0.08],
    );
    // The printed tag, white ring included, is 10/8 of it; the corners are not the ring's.
    assert!(top_right.x < 0.5 * 0.08 * 10.0 / 8.0);
}

#[test]
fn s14_corners_come_clockwise_from_the_top_left() {
    let [top_left, top_right, bottom_right, bottom_left] =
        corners_in_image(&camera_from_upright_tag(), 0.1);
    assert!(top_left.x < top_right.x && bottom_left.x < bottom_right.x);
    assert!(top_left.y < bottom_left.y && top_right.y < bottom_right.y);
}

#[test]
fn s15_a_tag_that_faces_the_camera_upright_is_turned_by_pi_about_x() {
    // 60 px wide about the image's middle: 0.1 m at 1 m.
    let corners = [
        [289.5, 209.5],
        [349.5, 209.5],
        [349.5, 269.5],
        [289.5, 269.5],
    ]
    .map(Point2::from);
    let poses = planar_pose::solve_square(&lens(), &corners, 0.1).unwrap();
    let off = se3::difference(&poses.best().camera_from_tag, &camera_from_upright_tag());
    assert!(
        off.fixed_rows::<3>(0).amax() < 1e-6 && off.fixed_rows::<3>(3).amax() < 1e-3,
        "{off}"
    );
}

#[test]
fn s16_a_step_moves_along_the_outer_axes_and_turns_about_the_objects_own_origin() {
    let truth = pose([1.0, 2.0, 3.0], [0.3, -0.2, 0.9]);
    let step = Vector6::new(0.01, -0.02, 0.03, 0.1, 0.2, -0.1);
    let estimate = se3::perturb(&truth, &step);
    assert_near(estimate.translation.vector.into(), [1.01, 1.98, 3.03]);
    let turned = so3::exp(&Vector3::new(0.1, 0.2, -0.1)) * truth.rotation;
    assert!(estimate.rotation.angle_to(&turned) < 1e-9);
    assert_near(se3::difference(&estimate, &truth).into(), step.into());
}

/// Points of an object, each seen in the world with the same error in every direction.
struct ObservedPoints {
    points_in_object: Vec<Point3<f64>>,
    truth: Pose,
    sigma_m: f64,
}

impl Problem<6> for ObservedPoints {
    type State = Pose;

    fn linearise(&self, pose: &Pose, equations: &mut NormalEquations<6>) -> Option<()> {
        for point in &self.points_in_object {
            let seen = self.truth * point;
            let mut jacobian = SMatrix::<f64, 3, 6>::zeros();
            for i in 0..6 {
                // By differences of `perturb`, so that the covariance is over its step and no other.
                let step = Vector6::ith(i, 1e-6);
                let moved = se3::perturb(pose, &step) * point - se3::perturb(pose, &-step) * point;
                jacobian.set_column(i, &(moved / 2e-6));
            }
            let information = SMatrix::identity() / self.sigma_m.powi(2);
            equations.add(
                &(pose * point - seen),
                &jacobian,
                &information,
                Kernel::Quadratic,
            );
        }
        Some(())
    }

    fn step(&self, pose: &Pose, step: &Vector6<f64>) -> Pose {
        se3::perturb(pose, step)
    }
}

#[test]
fn s17_a_covariance_is_over_the_step_in_world_axes_about_the_objects_origin() {
    // A rod along the object's x, which is turned up to the world's z, far from the world's origin.
    let rod = [
        [1.0, 0.0, 0.0],
        [-1.0, 0.0, 0.0],
        [0.0, 0.1, 0.0],
        [0.0, -0.1, 0.0],
    ];
    let truth = pose([10.0, 0.0, 0.0], [0.0, -FRAC_PI_2, 0.0]);
    let points_in_object = rod.map(Point3::from).to_vec();
    let problem = ObservedPoints {
        points_in_object,
        truth,
        sigma_m: 0.01,
    };
    let solution = least_squares::minimise(&problem, truth, &Default::default()).unwrap();
    let covariance = solution.covariance().unwrap();
    let variances: [f64; 6] = covariance.diagonal().into();
    // Position: the mean of four points. Attitude: loose about the rod, in world axes rz, stiff across.
    let (mean, across_x, across_y, about) = (1e-4 / 4.0, 1e-4 / 2.02, 1e-4 / 2.0, 1e-4 / 0.02);
    assert_near(variances, [mean, mean, mean, across_x, across_y, about]);
    // About the object's own origin: no lever arm of ten metres couples attitude into position.
    assert!(covariance.fixed_view::<3, 3>(0, 3).amax() < 1e-9);
}

#[test]
fn s18_a_twist_is_a_step_per_second() {
    let before = pose([1.0, 0.0, 0.0], [0.0, 0.0, 0.4]);
    let twist = Vector6::new(0.5, 0.0, -0.5, 0.0, 0.0, 2.0);
    let duration_s = 0.25;
    let after = se3::perturb(&before, &(twist * duration_s));
    assert_near(
        (se3::difference(&after, &before) / duration_s).into(),
        twist.into(),
    );
    // Spinning in place moves the origin nowhere.
    let spun = se3::perturb(&before, &Vector6::new(0.0, 0.0, 0.0, 0.0, 0.0, 1.0));
    assert_near(
        spun.translation.vector.into(),
        before.translation.vector.into(),
    );
}

#[test]
fn every_numbered_sentence_has_its_test() {
    let (page, tests) = (include_str!("../FRAMES.md"), include_str!("frames.rs"));
    let is_number = |text: &str| !text.is_empty() && text.bytes().all(|b| b.is_ascii_digit());
    let starts = page
        .lines()
        .filter_map(|line| Some(line.split_once(". ")?.0));
    let numbers: Vec<usize> = starts
        .filter(|start| is_number(start))
        .map(|n| n.parse().unwrap())
        .collect();
    assert!(numbers.iter().copied().eq(1..=numbers.len()), "{numbers:?}");
    assert_eq!(tests.matches("\nfn s").count(), numbers.len());
    for number in numbers {
        assert!(
            tests.contains(&format!("\nfn s{number:02}_")),
            "sentence {number} has no test"
        );
    }
}
