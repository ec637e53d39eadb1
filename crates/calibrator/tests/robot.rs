//! Robots calibrated on simulated corners and poses that are off.
#![allow(clippy::unwrap_used, reason = "a test may panic")]

use nalgebra::{Matrix2, Point2, Vector2, Vector3, Vector6};
use sextant_adjustment::Mount;
use sextant_calibrator::{
    CalibratedRobot, Finding, Grade, PoseReading, RobotError, RobotPlan, RobotPoses, RobotSession,
};
use sextant_geometry::{Intrinsics, Lens, Pose, se3, so3, tag_corners_in_tag};
use sextant_simulator::Random;
use sextant_site_model::{
    Camera, CameraId, ImageObservation, ObjectId, ObjectModel, ObjectTag, PoseSigma, Prior, Rig,
    TagCorners, TagId,
};
use sextant_tag_families::Family;
use std::collections::BTreeMap;

/// Standard deviations of the robot's poses: 0.3 mm and 0.05 degrees.
const ROBOT: [f64; 2] = [0.3e-3, 0.87e-3];
const CORNER_PX: f64 = 0.1;
const START_NS: u64 = 1_700_000_000_000_000_000;

fn lens(focal_px: f64) -> Lens {
    let intrinsics = Intrinsics {
        fx: focal_px,
        fy: focal_px,
        cx: 640.0,
        cy: 480.0,
    };
    Lens::brown_conrady(intrinsics, [-0.1, 0.05, 0.0, 0.0, 0.0]).unwrap()
}

fn camera(focal_px: f64) -> Camera {
    let id = CameraId::new("north").unwrap();
    Camera::new(id, [1280, 960], lens(focal_px), None)
}

/// Twelve tags on a plate whose frame is so far from its middle, m.
fn plate(origin_m: f64) -> ObjectModel {
    let tags = (0..12).map(|at| {
        let tag = TagId {
            family: Family::Tag36h11,
            id: at,
        };
        let place = [f64::from(at % 4) - 1.5, f64::from(at / 4) - 1.0];
        let pose = Pose::translation(0.05 * place[0] + origin_m, 0.05 * place[1], 0.0);
        ObjectTag::new(tag, 0.04, Some(pose))
    });
    ObjectModel::new(ObjectId::new("plate").unwrap(), tags.collect()).unwrap()
}

/// A robot, its camera and its object: the truth.
struct Cell {
    mount: Mount,
    object: ObjectModel,
    base_from_site: Pose,
    hand_from_carried: Pose,
    random: Random,
}

impl Cell {
    fn new(mount: Mount, seed: u64) -> Self {
        Self {
            mount,
            object: plate(0.0),
            base_from_site: Pose::new(Vector3::new(0.9, -0.4, 0.3), Vector3::new(0.3, 2.0, -1.1)),
            hand_from_carried: Pose::new(
                Vector3::new(0.04, -0.07, 0.12),
                Vector3::new(-1.5, 0.4, 0.8),
            ),
            random: Random::new(seed),
        }
    }

    fn noise(&mut self, sigmas: [f64; 2]) -> Vector6<f64> {
        Vector6::from_fn(|k, _| self.random.normal() * sigmas[k / 3])
    }

    /// `base_from_hand` where the camera sees the object there.
    fn hand(&self, camera_from_object: &Pose) -> Pose {
        let site_from_carried = match self.mount {
            Mount::Object => *camera_from_object,
            Mount::Camera => camera_from_object.inverse(),
        };
        self.base_from_site * site_from_carried * self.hand_from_carried.inverse()
    }

    fn noisy_hand(&mut self, camera_from_object: &Pose) -> Pose {
        self.hand(camera_from_object) * se3::exp(&self.noise(ROBOT))
    }

    fn image(&mut self, capture_ns: u64, camera_from_object: &Pose) -> ImageObservation {
        let lens = lens(1100.0);
        let random = &mut self.random;
        let tags = self.object.tags().iter().map(|tag| {
            let camera_from_tag = camera_from_object * tag.object_from_tag.unwrap();
            let corners = tag_corners_in_tag(tag.size_m).map(|corner| {
                let noise = Vector2::from_fn(|_, _| CORNER_PX * random.normal());
                lens.project(&(camera_from_tag * corner)).unwrap() + noise
            });
            TagCorners {
                tag: tag.tag,
                corners: corners.map(|c: Point2<f64>| c),
                corner_covariance: [Matrix2::from_diagonal_element(CORNER_PX * CORNER_PX); 4],
                corner_cross_covariance: [Matrix2::zeros(); 6],
            }
        });
        ImageObservation {
            camera: CameraId::new("north").unwrap(),
            capture_ns,
            clock_error_ns: 0,
            exposure_ns: 0,
            resolution: None,
            tags: tags.collect(),
        }
    }

    /// Moves each corner at random, by more than any noise and too little for another pose.
    fn scatter(&mut self, image: &mut ImageObservation) {
        let corners = image.tags.iter_mut().flat_map(|tag| &mut tag.corners);
        corners.for_each(|corner| *corner += Vector2::from_fn(|_, _| 3.0 * self.random.normal()));
    }

    /// A pose before the camera, tilted by up to so many radians about x, y and z.
    fn view(&mut self, tilts: [f64; 3]) -> Pose {
        let mut within = |most: f64| self.random.between(-most, most);
        let shift = Vector3::new(within(0.12), within(0.08), 0.55 + within(0.12));
        let turn = Vector3::new(within(tilts[0]), within(tilts[1]), within(tilts[2]));
        // Facing the camera: its z points out of the plate, and the camera's into the scene.
        Pose::from_parts(
            shift.into(),
            so3::exp(&Vector3::new(std::f64::consts::PI, 0.0, 0.0)) * so3::exp(&turn),
        )
    }

    /// Images of a robot that stands still for each.
    fn standing(
        &mut self,
        n: u64,
        tilts: [f64; 3],
    ) -> (Vec<ImageObservation>, BTreeMap<u64, Pose>) {
        let mut poses = BTreeMap::new();
        let images = (0..n).map(|at| {
            let view = self.view(tilts);
            poses.insert(at, self.noisy_hand(&view));
            self.image(START_NS + at * 3_000_000_000, &view)
        });
        (images.collect(), poses)
    }

    fn solve(
        &self,
        focal_px: f64,
        images: &[ImageObservation],
        poses: &RobotPoses,
    ) -> Result<CalibratedRobot, RobotError> {
        let rig = Rig::new(vec![camera(focal_px)]).unwrap();
        self.solve_with(&rig, &self.object, images, poses)
    }

    fn solve_with(
        &self,
        rig: &Rig,
        object: &ObjectModel,
        images: &[ImageObservation],
        poses: &RobotPoses,
    ) -> Result<CalibratedRobot, RobotError> {
        let plan = RobotPlan {
            object: object.clone(),
            mount: self.mount,
        };
        let mut session = RobotSession::new(rig, plan)?;
        images.iter().for_each(|image| session.handle(image));
        session.solve(poses)
    }

    /// Normalised squared errors of base and hand, six degrees of freedom each.
    fn nees(&self, found: &CalibratedRobot) -> [f64; 2] {
        let nees = |estimate: &Pose, truth: &Pose, covariance: &nalgebra::Matrix6<f64>| {
            let off = se3::difference(estimate, truth);
            off.dot(&(covariance.try_inverse().unwrap() * off))
        };
        [
            nees(
                &found.base_from_world,
                &self.base_from_site,
                &found.base_covariance,
            ),
            nees(
                &found.hand_from_carried,
                &self.hand_from_carried,
                &found.hand_covariance,
            ),
        ]
    }
}

const ALL_AXES: [f64; 3] = [0.6, 0.6, 1.5];

#[test]
fn base_and_hand_are_found_and_as_certain_as_stated() {
    // With deviations that the files do not have, the covariance is too large.
    let tags = plate(0.0).tags().to_vec();
    let tags = tags.into_iter().map(|tag| ObjectTag {
        pose_prior: Prior::Exact,
        size_prior: Prior::Exact,
        ..tag
    });
    let object = ObjectModel::new(ObjectId::new("plate").unwrap(), tags.collect()).unwrap();
    let rig = Rig::new(vec![Camera {
        lens_prior: Prior::Exact,
        ..camera(1100.0)
    }])
    .unwrap();
    for mount in [Mount::Object, Mount::Camera] {
        let mut nees = [0.0; 2];
        const SEEDS: u64 = 24;
        for seed in 0..SEEDS {
            let mut cell = Cell::new(mount, seed);
            let (images, poses) = cell.standing(24, ALL_AXES);
            let found = cell
                .solve_with(&rig, &object, &images, &RobotPoses::ByImage(poses))
                .unwrap();
            let report = &found.report;
            assert_eq!(report.poses, 24);
            assert!(report.outliers.is_empty(), "{report:?}");
            assert!((0.15..0.5).contains(&report.robot_sigma_mm), "{report:?}");
            assert!(
                (0.025..0.08).contains(&report.robot_sigma_deg),
                "{report:?}"
            );
            let held_out = report.held_out.unwrap();
            assert!(held_out.rms_mm < 1.5, "{held_out:?}");
            for (sum, nees) in nees.iter_mut().zip(cell.nees(&found)) {
                *sum += nees / SEEDS as f64;
            }
        }
        assert!(
            nees.iter().all(|nees| (3.5..9.0).contains(nees)),
            "{mount:?} {nees:?}"
        );
    }
}

#[test]
fn a_lens_that_is_off_and_a_wrong_pose_are_found() {
    let mut cell = Cell::new(Mount::Object, 3);
    let (images, mut poses) = cell.standing(24, ALL_AXES);
    let wrong = poses.get_mut(&5).unwrap();
    wrong.translation.vector.x += 0.03;
    let found = cell
        .solve(1106.0, &images, &RobotPoses::ByImage(poses))
        .unwrap();
    assert_eq!(found.report.outliers, [5]);
    let off = se3::difference(&found.hand_from_carried, &cell.hand_from_carried);
    assert!(off.fixed_rows::<3>(0).norm() < 1e-3, "{off}");
    let because = &found.report.verdict.because;
    let finds = |wanted: fn(&Finding) -> bool| because.iter().any(wanted);
    assert!(
        finds(|f| matches!(f, Finding::RobotOutliers(_))),
        "{because:?}"
    );
    assert!(
        finds(|f| matches!(f, Finding::LensDiffers { .. })),
        "{because:?}"
    );
}

#[test]
fn turns_about_one_axis_or_none_leave_a_named_part_open() {
    for (tilts, words) in [
        (
            [0.0, 0.0, 1.5],
            "only: the position of the object along that axis",
        ),
        ([0.0; 3], "the hand hardly turned"),
    ] {
        let mut cell = Cell::new(Mount::Object, 5);
        let (images, mut poses) = cell.standing(24, tilts);
        // One wrong pose is no second axis.
        *poses.get_mut(&7).unwrap() *= se3::exp(&Vector6::new(0.0, 0.0, 0.0, 0.7, 0.0, 0.0));
        let found = cell
            .solve(1100.0, &images, &RobotPoses::ByImage(poses))
            .unwrap();
        let report = &found.report;
        assert_eq!(report.outliers, [7]);
        assert!(report.undetermined[0].contains(words), "{report:?}");
        assert_eq!(report.verdict.grade, Grade::Poor);
        assert!(report.hand_sigma_mm > 20.0, "{report:?}");
        // Together they still tell where the object is.
        assert!(report.held_out.unwrap().median_mm < 1.5, "{report:?}");
        let pose = found.hand_from_carried.to_homogeneous();
        assert!(pose.iter().all(|x| x.is_finite()));
    }
}

/// What a reading of the poses makes of a robot with poses of images.
fn reading_of(
    mount: Mount,
    seed: u64,
    write: impl Fn(&BTreeMap<u64, Pose>) -> BTreeMap<u64, Pose>,
) -> PoseReading {
    let mut cell = Cell::new(mount, seed);
    let (images, poses) = cell.standing(24, ALL_AXES);
    match cell.solve(1104.0, &images, &RobotPoses::ByImage(write(&poses))) {
        Err(RobotError::OtherReading { reading, .. }) => reading,
        other => panic!("{mount:?} {seed}: {other:?}"),
    }
}

#[test]
fn poses_that_are_written_in_another_way_are_refused_with_the_way() {
    let each = |of: fn(&Pose) -> Pose| {
        move |poses: &BTreeMap<u64, Pose>| {
            poses.iter().map(|(key, pose)| (*key, of(pose))).collect()
        }
    };
    let scalar_first = |pose: &Pose| {
        let [x, y, z, w]: [f64; 4] = pose.rotation.coords.into();
        let misread = nalgebra::Quaternion::new(z, w, x, y);
        Pose::from_parts(
            pose.translation,
            nalgebra::UnitQuaternion::from_quaternion(misread),
        )
    };
    let in_millimetres = |pose: &Pose| {
        let mut pose = *pose;
        pose.translation.vector *= 1e3;
        pose
    };
    for (at, mount) in [Mount::Object, Mount::Camera].into_iter().enumerate() {
        let seed = 40 + at as u64;
        let inverse = reading_of(mount, seed, each(Pose::inverse));
        assert!(inverse.is_inverse && inverse.metres == 1.0, "{inverse:?}");
        let scalar = reading_of(mount, seed, each(scalar_first));
        assert!(scalar.is_scalar_first && !scalar.is_inverse, "{scalar:?}");
        let long = reading_of(mount, seed, each(in_millimetres));
        assert!(long.metres == 1e-3 && !long.is_inverse, "{long:?}");
        for late in [-2_i64, 1] {
            let shifted = reading_of(mount, seed, |poses| {
                let shifted = poses
                    .iter()
                    .filter_map(|(key, pose)| Some((key.checked_add_signed(late)?, *pose)));
                shifted.collect()
            });
            assert_eq!(shifted.late, late);
        }
    }
}

#[test]
fn a_robot_that_is_merely_poor_is_not_read_otherwise() {
    let mut cell = Cell::new(Mount::Camera, 50);
    let (images, mut poses) = cell.standing(24, ALL_AXES);
    for pose in poses.values_mut() {
        *pose *= se3::exp(&cell.noise([8e-3, 20e-3]));
    }
    let found = cell
        .solve(1100.0, &images, &RobotPoses::ByImage(poses))
        .unwrap();
    assert!(found.report.robot_sigma_mm > 4.0);
}

#[test]
fn an_image_without_a_usable_tag_counts_for_nothing() {
    let mut cell = Cell::new(Mount::Object, 4);
    let (mut images, poses) = cell.standing(24, ALL_AXES);
    cell.scatter(&mut images[5]);
    let found = cell
        .solve(1100.0, &images, &RobotPoses::ByImage(poses))
        .unwrap();
    assert_eq!(found.report.poses, 23);
    assert_eq!(found.report.held_out.unwrap().poses, 23);
}

#[test]
fn the_base_is_as_certain_wherever_the_frame_of_the_object_is() {
    let sigma_mm = |origin_m: f64| {
        let mut cell = Cell::new(Mount::Camera, 2);
        cell.object = plate(origin_m);
        let middle = Pose::translation(-origin_m, 0.0, 0.0);
        let mut poses = BTreeMap::new();
        let images = (0..24).map(|at| {
            let view = cell.view(ALL_AXES) * middle;
            poses.insert(at, cell.noisy_hand(&view));
            cell.image(START_NS + at, &view)
        });
        let images: Vec<ImageObservation> = images.collect();
        let poses = RobotPoses::ByImage(poses);
        let found = cell.solve(1100.0, &images, &poses).unwrap();
        found.report.base_sigma_mm
    };
    let (near, far) = (sigma_mm(0.0), sigma_mm(5.0));
    assert!((far / near - 1.0).abs() < 0.3, "{near} {far}");
}

/// The plate's tags and a second camera are elsewhere than the files say, by their sigmas; the cameras have no common
/// clock.
#[test]
fn what_files_are_off_by_is_in_the_covariance() {
    const SEEDS: u64 = 12;
    const POSES: u64 = 24;
    const OFF: PoseSigma = PoseSigma {
        position_m: 0.5e-3,
        orientation_rad: 2e-3,
    };
    let mut nees = [0.0; 2];
    for seed in 0..SEEDS {
        let mut cell = Cell::new(Mount::Object, seed);
        let off = [OFF.position_m, OFF.orientation_rad];
        let of_file = plate(0.0).tags().to_vec();
        let of_file = of_file.into_iter().map(|tag| ObjectTag {
            pose_prior: Prior::Sigma(OFF),
            ..tag
        });
        let of_file: Vec<ObjectTag> = of_file.collect();
        let truth = of_file.iter().map(|tag| ObjectTag {
            object_from_tag: tag
                .object_from_tag
                .map(|pose| se3::perturb(&pose, &cell.noise(off))),
            ..tag.clone()
        });
        cell.object = ObjectModel::new(ObjectId::new("plate").unwrap(), truth.collect()).unwrap();
        let of_file = ObjectModel::new(ObjectId::new("plate").unwrap(), of_file).unwrap();
        let north_from_south = Pose::new(Vector3::new(0.2, 0.0, 0.0), Vector3::new(0.0, -0.3, 0.0));
        let mut images = Vec::new();
        let mut poses = BTreeMap::new();
        for at in 0..POSES {
            let view = cell.view(ALL_AXES);
            poses.insert(at, cell.noisy_hand(&view));
            let at_ns = START_NS + at * 3_000_000_000;
            images.push(cell.image(at_ns, &view));
            images.push(ImageObservation {
                camera: CameraId::new("south").unwrap(),
                ..cell.image(at_ns + 100_000_000, &(north_from_south.inverse() * view))
            });
        }
        let south = Camera {
            id: CameraId::new("south").unwrap(),
            world_from_camera: Some(se3::perturb(&north_from_south, &cell.noise(off))),
            pose_prior: Prior::Sigma(OFF),
            ..camera(1100.0)
        };
        let north = Camera {
            world_from_camera: Some(Pose::identity()),
            ..camera(1100.0)
        };
        let rig = Rig::new(vec![north, south]).unwrap();
        // The numbers of images are by their capture times, not by their arrival.
        images.reverse();
        let found = cell
            .solve_with(&rig, &of_file, &images, &RobotPoses::ByImage(poses))
            .unwrap();
        assert_eq!(found.report.poses, POSES as usize);
        for (sum, nees) in nees.iter_mut().zip(cell.nees(&found)) {
            *sum += nees / SEEDS as f64;
        }
    }
    assert!(
        nees.iter().all(|nees| (3.5..9.0).contains(nees)),
        "{nees:?}"
    );
}

const OFFSET_S: f64 = 0.137;

impl Cell {
    /// Ten seconds at 30 Hz of a path before the camera, at a time for each time of it.
    fn images_along(&mut self, time: fn(f64) -> f64) -> Vec<ImageObservation> {
        let images = (0..300).map(|at| {
            let s = f64::from(at) / 30.0;
            self.image(START_NS + (s * 1e9) as u64, &along(time(s)))
        });
        images.collect()
    }

    /// The robot's poses at 125 Hz by its own clock.
    fn hands_along(&mut self, time: fn(f64) -> f64, sigmas: [f64; 2]) -> RobotPoses {
        let poses = (0..1300).map(|at| {
            let s = f64::from(at) / 125.0;
            let by_its_clock = START_NS + ((s + OFFSET_S) * 1e9) as u64;
            let hand = self.hand(&along(time(s))) * se3::exp(&self.noise(sigmas));
            (by_its_clock, hand)
        });
        RobotPoses::ByTime(poses.collect())
    }
}

/// A path of the object before the camera.
fn along(s: f64) -> Pose {
    let shift = Vector3::new(
        0.1 * (0.9 * s).sin(),
        0.07 * (0.7 * s).cos(),
        0.55 + 0.1 * (0.5 * s).sin(),
    );
    let turn = Vector3::new(
        0.5 * (0.8 * s).sin(),
        0.5 * (1.1 * s).cos(),
        0.9 * (0.6 * s).sin(),
    );
    Pose::from_parts(
        shift.into(),
        so3::exp(&Vector3::new(std::f64::consts::PI, 0.0, 0.0)) * so3::exp(&turn),
    )
}

#[test]
fn the_offset_of_a_robots_clock_is_found_while_it_moves() {
    for mount in [Mount::Object, Mount::Camera] {
        let mut cell = Cell::new(mount, 9);
        let mut images = cell.images_along(|s| s);
        // What an image lacks must not displace the poses of the others.
        cell.scatter(&mut images[100]);
        let poses = cell.hands_along(|s| s, ROBOT);
        let found = cell.solve(1100.0, &images, &poses).unwrap();
        let offset_ms = found.report.clock_offset_ms.unwrap();
        assert!(
            (offset_ms - 1e3 * OFFSET_S).abs() < 1.0,
            "{:?}",
            found.report
        );
        let off = se3::difference(&found.hand_from_carried, &cell.hand_from_carried);
        assert!(off.fixed_rows::<3>(0).norm() < 0.5e-3, "{off}");
        assert_eq!(found.report.outliers, []);
    }
}

#[test]
fn the_offset_of_a_robots_clock_is_found_between_stops() {
    // Each second, the hand moves for the first 0.3 s.
    let stops = |s: f64| {
        let share = (s.fract() / 0.3).min(1.0);
        s.floor() + share * share * (3.0 - 2.0 * share)
    };
    let mut cell = Cell::new(Mount::Object, 9);
    let images = cell.images_along(stops);
    let poses = cell.hands_along(stops, [0.0; 2]);
    let found = cell.solve(1100.0, &images, &poses).unwrap();
    let offset_ms = found.report.clock_offset_ms.unwrap();
    assert!(
        (offset_ms - 1e3 * OFFSET_S).abs() < 1.0,
        "{:?}",
        found.report
    );
}

#[test]
fn what_cannot_be_solved_is_refused_with_a_remedy() {
    let mut cell = Cell::new(Mount::Object, 1);
    let (images, poses) = cell.standing(6, ALL_AXES);
    let refused = |images: &[ImageObservation], poses: RobotPoses, words: &str| {
        let error = cell.solve(1100.0, images, &poses).unwrap_err().to_string();
        assert!(error.contains(words), "{error}");
    };
    refused(
        &[],
        RobotPoses::ByImage(poses.clone()),
        "0 images, and none shows a tag",
    );
    // Two images of one pose are one.
    let again: Vec<ImageObservation> = [0, 1, 1].map(|at| images[at].clone()).to_vec();
    refused(
        &again,
        RobotPoses::ByImage(poses.clone()),
        "2 poses of the robot were matched, and 3 are the least; 3 of 3 images",
    );
    refused(
        &images[..2],
        RobotPoses::ByImage(poses.clone()),
        "2 of 2 images",
    );
    refused(&images, RobotPoses::ByTime(poses), "column `image`");
    refused(&images, RobotPoses::ByTime(BTreeMap::new()), "has no pose");
    let one = Pose::translation(f64::NAN, 0.0, 0.0);
    let broken = (0..6).map(|at| (at, one)).collect();
    let error = cell.solve(1100.0, &images, &RobotPoses::ByImage(broken));
    assert!(error.is_err());
}
