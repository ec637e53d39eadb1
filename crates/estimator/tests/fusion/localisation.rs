//! Cameras that an object carries: the object is where they see the landmarks.

use nalgebra::{UnitQuaternion, Vector3};
use sextant_estimator::{Fusion, FusionOptions, Input};
use sextant_geometry::Pose;
use sextant_site_model::{
    Camera, ImageObservation, Mount, ObjectId, ObjectModel, ObjectTag, PoseSigma, Prior, Rig,
};
use sextant_site_report::{Fault, ObjectEstimate, State};

use crate::scene::{
    Eye, PERIOD_NS, Random, START_NS, camera_id, cube, cube_id, error, feed, looking_from, poses,
    position_error, rig, tag_id,
};

const SIGMA_PX: f64 = 0.1;

fn room_id() -> ObjectId {
    ObjectId::new("room").unwrap()
}

/// Sixteen tags of 15 cm on a wall all around, 2 m from the world's origin; the frame of the room is elsewhere.
fn room() -> ObjectModel {
    let tag = |index: u32| {
        let angle = std::f64::consts::TAU * f64::from(index) / 16.0;
        let height = 0.3 * f64::from(index % 3) - 0.3;
        let place = Vector3::new(2.0 * angle.cos(), 2.0 * angle.sin(), height);
        // looking_from gives x right, y down, z inwards; a tag has x right, y up and its face along z for whom it
        // faces.
        let about_x = UnitQuaternion::from_axis_angle(&Vector3::x_axis(), std::f64::consts::PI);
        let about_y = UnitQuaternion::from_axis_angle(&Vector3::y_axis(), std::f64::consts::PI);
        let turn = looking_from(place).rotation * about_x * about_y;
        let world_from_tag = Pose::from_parts(place.into(), turn);
        ObjectTag::new(
            tag_id(20 + index),
            0.15,
            Some(world_from_room().inverse() * world_from_tag),
        )
    };
    ObjectModel::new(room_id(), (0..16).map(tag).collect())
        .unwrap()
        .exact()
        .with_world_from_object(Some(world_from_room()))
        .unwrap()
}

fn world_from_room() -> Pose {
    Pose::new(Vector3::new(2.5, -1.0, 0.4), Vector3::new(0.1, -0.2, 0.7))
}

/// World from the cube, which flies about and turns, and tilts a little.
fn flight_at(time_ns: u64) -> Pose {
    let seconds = (time_ns - START_NS) as f64 * 1e-9;
    let place = Vector3::new(
        0.3 * (1.7 * seconds).sin(),
        0.3 * (1.3 * seconds).cos(),
        0.1 * (2.1 * seconds).sin(),
    );
    let tilt = UnitQuaternion::from_euler_angles(
        0.15 * (2.3 * seconds).sin(),
        0.15 * (1.9 * seconds).cos(),
        0.0,
    );
    let turn = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), 0.8 * seconds);
    Pose::from_parts(place.into(), turn * tilt)
}

/// Two cameras on the cube, looking forwards and backwards.
fn carried() -> Vec<Camera> {
    let lens = rig(1).cameras()[0].lens;
    let camera = |(index, turn): (usize, f64)| {
        let forwards = looking_from(Vector3::new(turn.cos(), turn.sin(), 0.0));
        let mount = Mount {
            carrier: cube_id(),
            carrier_from_camera: Pose::from_parts(
                Vector3::new(0.0, 0.0, 0.05).into(),
                forwards.rotation,
            ),
        };
        Camera {
            mount: Some(mount),
            ..Camera::new(camera_id(10 + index), [640, 480], lens, None)
        }
    };
    [0.2, 3.0].into_iter().enumerate().map(camera).collect()
}

/// What the carried cameras see is what cameras that stand still would see of a room that moves.
fn as_world(cameras: &[Camera]) -> Rig {
    let camera = |camera: &Camera| Camera {
        world_from_camera: camera.mount.as_ref().map(|mount| mount.carrier_from_camera),
        mount: None,
        ..camera.clone()
    };
    Rig::new(cameras.iter().map(camera).collect()).unwrap()
}

/// An image of a carried camera.
fn look(cameras: &[Camera], index: usize, time_ns: u64, random: &mut Random) -> ImageObservation {
    let (rig, room) = (as_world(cameras), room());
    let eye = Eye {
        rig: &rig,
        object: &room,
        sigma_px: SIGMA_PX,
    };
    let carrier_from_room = flight_at(time_ns).inverse() * world_from_room();
    eye.image(index, time_ns, &carrier_from_room, random)
}

struct Followed {
    rms_m: f64,
    nees: f64,
    tracking: usize,
    fusion: Fusion,
}

/// Follows the cube for some seconds; what is past the first half second counts.
fn followed(
    configured: Rig,
    objects: Vec<ObjectModel>,
    images: impl IntoIterator<Item = ImageObservation>,
) -> Followed {
    let mut fusion = Fusion::new(configured, objects, FusionOptions::default()).unwrap();
    let (mut square, mut nees, mut tracking) = (0.0, 0.0, 0);
    for image in images {
        let is_counted = image.capture_ns > START_NS + 500_000_000;
        let estimates = feed(&mut fusion, image);
        let own = |one: &&ObjectEstimate| one.object == cube_id() && one.state == State::Tracking;
        for estimate in estimates.iter().filter(own).filter(|_| is_counted) {
            let truth = flight_at(estimate.capture_ns);
            let off = error(estimate, &truth);
            square += position_error(estimate, &truth).powi(2);
            nees += off.dot(&estimate.covariance.cholesky().unwrap().solve(&off)) / 6.0;
            tracking += 1;
        }
    }
    let count = tracking.max(1) as f64;
    Followed {
        rms_m: f64::sqrt(square / count),
        nees: nees / count,
        tracking,
        fusion,
    }
}

fn exact(cameras: &[Camera]) -> Rig {
    Rig::new(cameras.to_vec()).unwrap().exact()
}

fn rounds(seconds: f64) -> impl Iterator<Item = u64> {
    (0..(seconds * 1e9 / PERIOD_NS as f64) as u64).map(|round| START_NS + round * PERIOD_NS)
}

#[test]
fn carried_cameras_tell_where_their_carrier_is() {
    let cameras = carried();
    let mut random = Random(1);
    let images: Vec<_> = rounds(4.0)
        .flat_map(|time_ns| [(0, time_ns), (1, time_ns + PERIOD_NS / 2)])
        .map(|(index, time_ns)| look(&cameras, index, time_ns, &mut random))
        .collect();
    let found = followed(exact(&cameras), vec![room()], images);
    assert!(found.tracking > 180, "{} poses", found.tracking);
    assert!(found.rms_m < 0.004, "{} m", found.rms_m);
    assert!((0.3..2.0).contains(&found.nees), "NEES {}", found.nees);
    assert_eq!(found.fusion.faults(), []);
    let counts = found.fusion.statistics().cameras[&camera_id(10)];
    assert!(counts.images > 100 && counts.used_tags > 100, "{counts:?}");
}

#[test]
fn landmarks_and_mounts_may_be_off() {
    let cameras = carried();
    let mut random = Random(2);
    let images: Vec<_> = rounds(6.0)
        .flat_map(|time_ns| [(0, time_ns), (1, time_ns)])
        .map(|(index, time_ns)| look(&cameras, index, time_ns, &mut random))
        .collect();
    let shift = |random: &mut Random, scale: f64| Vector3::from_fn(|_, _| random.gauss() * scale);
    let sigma = PoseSigma {
        position_m: 0.005,
        orientation_rad: 0.01,
    };
    let room = room();
    let off = room.tags().iter().cloned().fold(room.clone(), |room, tag| {
        let by = Pose::new(shift(&mut random, 0.005), shift(&mut random, 0.01));
        room.with_tag(ObjectTag {
            object_from_tag: tag.object_from_tag.map(|pose| pose * by),
            pose_prior: Prior::Sigma(sigma),
            ..tag
        })
    });
    let found = followed(exact(&cameras), vec![off], images);
    assert!(found.tracking > 250, "{} poses", found.tracking);
    assert!(found.rms_m < 0.015, "{} m", found.rms_m);
    assert!(found.nees < 4.0, "NEES {}", found.nees);
}

/// Cameras that stand still see the cube, which carries others.
fn both(random: &mut Random, seconds: f64) -> (Rig, Vec<ImageObservation>) {
    let (still, cameras, cube) = (rig(2), carried(), cube());
    let eye = Eye {
        rig: &still,
        object: &cube,
        sigma_px: SIGMA_PX,
    };
    let mut images = Vec::new();
    for time_ns in rounds(seconds) {
        for index in 0..2 {
            images.push(eye.image(index, time_ns, &flight_at(time_ns), random));
            images.push(look(&cameras, index, time_ns, random));
        }
    }
    let all = still.cameras().iter().cloned().chain(cameras);
    (Rig::new(all.collect()).unwrap().exact(), images)
}

#[test]
fn what_stands_still_and_what_is_carried_are_combined() {
    let (rig, images) = both(&mut Random(3), 4.0);
    let is_carried = |image: &ImageObservation| image.camera >= camera_id(10);
    let of = |carried: bool| {
        let own = images
            .iter()
            .filter(move |image| is_carried(image) == carried);
        followed(rig.clone(), vec![cube(), room()], own.cloned())
    };
    let (still, carried) = (of(false), of(true));
    let all = followed(rig.clone(), vec![cube(), room()], images.iter().cloned());
    let best = still.rms_m.min(carried.rms_m);
    assert!(all.rms_m <= 1.02 * best, "{} of {best}", all.rms_m);
    assert!((0.3..2.0).contains(&all.nees), "NEES {}", all.nees);
    assert_eq!(all.fusion.faults(), []);
}

#[test]
fn an_object_that_its_own_cameras_follow_is_not_lost() {
    let (rig, images) = both(&mut Random(4), 4.0);
    let gone_ns = START_NS + 1_500_000_000;
    let mut fusion = Fusion::new(rig, vec![cube(), room()], FusionOptions::default()).unwrap();
    let is_seen =
        |image: &&ImageObservation| image.camera >= camera_id(10) || image.capture_ns < gone_ns;
    let mut states = Vec::new();
    for image in images.iter().filter(is_seen) {
        let own = feed(&mut fusion, image.clone()).into_iter();
        states.extend(
            own.filter(|one| one.object == cube_id())
                .map(|one| one.state),
        );
    }
    assert!(!states.contains(&State::Lost));
    // Then its own cameras stop too.
    fusion.handle(START_NS + 60_000_000_000, Input::Tick);
    let own = poses(&mut fusion).into_iter();
    let lost = own.filter(|one| one.object == cube_id() && one.state == State::Lost);
    assert_eq!(lost.count(), 1);
}

#[test]
fn landmarks_that_lie_elsewhere_are_named() {
    let (rig, images) = both(&mut Random(5), 3.0);
    let elsewhere = Pose::translation(0.1, 0.0, 0.0) * world_from_room();
    let room = room().with_world_from_object(Some(elsewhere)).unwrap();
    let mut found = followed(rig, vec![cube(), room], images);
    assert!(found.nees < 4.0, "NEES {}", found.nees);
    let contradicted = |fault: &Fault| match fault {
        Fault::ObjectContradicted { object, .. } => *object == cube_id(),
        _ => false,
    };
    let faults = found.fusion.faults();
    assert!(faults.iter().any(contradicted), "{faults:?}");
    // It is not named for longer than it is seen.
    found.fusion.handle(START_NS + 20_000_000_000, Input::Tick);
    let faults = found.fusion.faults();
    assert!(!faults.iter().any(contradicted), "{faults:?}");
}
