//! No fault is reported where there is none: for bodies that are thrown, and cameras within their configured
//! deviations. A fault among such cameras is.

use nalgebra::{UnitQuaternion, Vector3};
use sextant_estimator::{Fusion, FusionOptions, Input};
use sextant_geometry::Pose;
use sextant_site_model::{Camera, PoseSigma, Prior, Rig};
use sextant_site_report::Fault;

use crate::scene::{
    Eye, PERIOD_NS, Random, START_NS, camera_id, cube, fusion, path, poses, rig, with_cameras,
};

/// When what is true of the cameras changes, seconds.
const CHANGE_S: f64 = 2.0;

fn vector(random: &mut Random, sigma: f64) -> Vector3<f64> {
    Vector3::from_fn(|_, _| random.gauss() * sigma)
}

/// Faults by any of the images of five seconds of a cube, each camera at a phase of its own, with the seconds from the
/// start. What is true of the cameras changes after two seconds.
fn named(
    fusion: &mut Fusion,
    [before, after]: [&Rig; 2],
    pose: &dyn Fn(f64) -> Pose,
    random: &mut Random,
) -> Vec<(f64, Fault)> {
    let (object, sigma_px) = (&cube(), 0.05);
    let cameras = before.cameras().len();
    let mut named = Vec::new();
    for image in 0..150 * cameras as u64 {
        let after_ns = image * PERIOD_NS / cameras as u64;
        let (seconds, time_ns) = (after_ns as f64 * 1e-9, START_NS + after_ns);
        let eye = Eye {
            rig: if seconds < CHANGE_S { before } else { after },
            object,
            sigma_px,
        };
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
        let faults = named(&mut fusion, [&rig; 2], &flight, &mut random);
        assert!(faults.is_empty(), "seed {seed}: {:?}", faults[0]);
    }
}

fn with_poses(rig: &Rig, change: impl FnMut(usize) -> Pose) -> Rig {
    let mut cameras: Vec<Camera> = rig.cameras().to_vec();
    for (camera, by) in cameras.iter_mut().zip((0..).map(change)) {
        camera.world_from_camera = camera.world_from_camera.map(|pose| pose * by);
    }
    Rig::new(cameras).unwrap().exact()
}

/// Cameras that stand as well as that, and how the rig states them, if it does.
fn imprecise(sigma: PoseSigma, is_stated: bool, random: &mut Random) -> (Rig, Rig) {
    let truth = with_poses(&rig(4), |_| {
        let turn = UnitQuaternion::from_scaled_axis(vector(random, sigma.orientation_rad));
        Pose::from_parts(vector(random, sigma.position_m).into(), turn)
    });
    let rig = with_cameras(&rig(4), |camera| {
        if is_stated {
            camera.pose_prior = Prior::Sigma(sigma);
        }
    });
    (truth, rig)
}

#[test]
fn a_camera_that_stands_as_well_as_is_stated_is_not_named() {
    for seed in 1..7 {
        let random = &mut Random(seed);
        let sigma = PoseSigma {
            position_m: 0.001,
            orientation_rad: 0.001,
        };
        let (truth, rig) = imprecise(sigma, true, random);
        let mut fusion = fusion(&rig, &cube(), FusionOptions::default());
        let faults = named(&mut fusion, [&truth; 2], &path, random);
        assert!(faults.is_empty(), "seed {seed}: {:?}", faults[0]);
    }
}

#[test]
fn a_camera_bumped_by_a_degree_is_named_among_cameras_that_are_not_quite_where_they_should_be() {
    let mut misnamed = 0;
    for (is_stated, sigma) in [(false, 0.0003), (true, 0.0005)] {
        let sigma = PoseSigma {
            position_m: sigma,
            orientation_rad: sigma,
        };
        for seed in 1..8 {
            let random = &mut Random(seed);
            let (truth, rig) = imprecise(sigma, is_stated, random);
            let mut fusion = fusion(&rig, &cube(), FusionOptions::default());
            let wrong = seed as usize % 4;
            let about = vector(random, 1.0).normalize() * 1.0_f64.to_radians();
            let bumped = with_poses(&truth, |camera| match camera == wrong {
                true => Pose::rotation(about),
                false => Pose::identity(),
            });
            let faults = named(&mut fusion, [&truth, &bumped], &path, random);
            let camera = camera_id(wrong);
            let moved = Fault::CameraMoved { camera };
            let soon =
                |(seconds, fault): &(f64, Fault)| *fault == moved && seconds - CHANGE_S < 2.0;
            let is_right =
                faults.first().is_some_and(soon) && faults.iter().all(|(_, one)| *one == moved);
            misnamed += usize::from(!is_right);
        }
    }
    // Two of 80 seeds: an offset of the clock explains the first images of the bumped camera as well.
    assert!(misnamed <= 1, "{misnamed} of 14 sites");
}
