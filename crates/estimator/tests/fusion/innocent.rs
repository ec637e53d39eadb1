//! What is no fault is named by nobody: bodies that are thrown, cameras that stand as well as is stated.

use nalgebra::{UnitQuaternion, Vector3};
use sextant_estimator::{Camera, Fault, Fusion, FusionOptions, Input, PoseSigma, Rig};
use sextant_geometry::Pose;

use crate::scene::{Eye, PERIOD_NS, Random, START_NS, camera_id, cube, fusion, path, poses, rig};

fn vector(random: &mut Random, sigma: f64) -> Vector3<f64> {
    Vector3::from_fn(|_, _| random.gauss() * sigma)
}

/// Faults by any of the images of five seconds of a cube, each camera at a phase of its own, with the seconds from the start.
fn named(
    fusion: &mut Fusion,
    truth: &Rig,
    pose: &dyn Fn(f64) -> Pose,
    random: &mut Random,
) -> Vec<(f64, Fault)> {
    let (rig, object, sigma_px) = (truth, &cube(), 0.05);
    let eye = Eye {
        rig,
        object,
        sigma_px,
    };
    let cameras = rig.cameras().len();
    let mut named = Vec::new();
    for image in 0..150 * cameras as u64 {
        let after_ns = image * PERIOD_NS / cameras as u64;
        let (seconds, time_ns) = (after_ns as f64 * 1e-9, START_NS + after_ns);
        let image = eye.image(image as usize % cameras, time_ns, &pose(seconds), random);
        fusion.handle(time_ns + 10_000_000, Input::Image(image));
        drop(poses(fusion));
        named.extend(fusion.faults().into_iter().map(|fault| (seconds, fault)));
    }
    named
}

/// Flights of half a second: up from the middle and down again, turning as it pleases.
fn thrown(random: &mut Random) -> impl Fn(f64) -> Pose + use<> {
    const FLIGHT_S: f64 = 0.5;
    let flights: Vec<_> = (0..12)
        .map(|_| (vector(random, 0.1), vector(random, 3.0)))
        .collect();
    move |seconds| {
        let (flight, after_s) = ((seconds / FLIGHT_S) as usize, seconds % FLIGHT_S);
        let (across, spin) = flights[flight];
        let height = 0.5 * 9.81 * after_s * (FLIGHT_S - after_s) - 0.15;
        let place = across * (after_s * (FLIGHT_S - after_s)) * 4.0 + Vector3::z() * height;
        let before: UnitQuaternion<f64> = flights[..flight]
            .iter()
            .map(|(_, spin)| UnitQuaternion::from_scaled_axis(spin * FLIGHT_S))
            .fold(UnitQuaternion::identity(), |sum, turn| turn * sum);
        let turn = UnitQuaternion::from_scaled_axis(spin * after_s) * before;
        Pose::from_parts(place.into(), turn)
    }
}

#[test]
fn tags_of_a_body_that_is_thrown_are_on_it() {
    for seed in 1..7 {
        let (rig, mut random) = (rig(6), Random(seed));
        let mut fusion = fusion(&rig, &cube(), FusionOptions::default());
        let flight = thrown(&mut random);
        let faults = named(&mut fusion, &rig, &flight, &mut random);
        assert!(faults.is_empty(), "seed {seed}: {:?}", faults[0]);
    }
}

fn with_poses(rig: &Rig, change: impl FnMut(usize) -> Pose) -> Rig {
    let mut cameras: Vec<Camera> = rig.cameras().to_vec();
    for (camera, by) in cameras.iter_mut().zip((0..).map(change)) {
        camera.world_from_camera = camera.world_from_camera.map(|pose| pose * by);
    }
    Rig::new(cameras).unwrap()
}

#[test]
fn a_camera_that_stands_as_well_as_is_stated_is_not_named() {
    for seed in 1..7 {
        let random = &mut Random(seed);
        let said = PoseSigma {
            position_m: 0.001,
            orientation_rad: 0.001,
        };
        let stated = rig(4).with_pose_sigmas((0..4).map(|camera| (camera_id(camera), said)));
        let mut fusion = fusion(&stated.unwrap(), &cube(), FusionOptions::default());
        let truth = with_poses(&rig(4), |_| {
            let turn = UnitQuaternion::from_scaled_axis(vector(random, said.orientation_rad));
            Pose::from_parts(vector(random, said.position_m).into(), turn)
        });
        let faults = named(&mut fusion, &truth, &path, random);
        assert!(faults.is_empty(), "seed {seed}: {:?}", faults[0]);
    }
}
