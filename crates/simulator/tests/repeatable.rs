//! The same seed gives the same bytes, whatever was drawn before, and on every platform.

#![allow(clippy::unwrap_used, reason = "a test may end in a panic")]

use proptest::prelude::*;
use sextant_geometry::{Intrinsics, Lens};
use sextant_simulator::{Random, Renderer, Scenario, SceneCamera, Wave};

fn small(seed: u64) -> Scenario {
    let mut scenario = Scenario::demo(2, 2, seed);
    let intrinsics = Intrinsics {
        fx: 200.0,
        fy: 200.0,
        cx: 80.0,
        cy: 60.0,
    };
    for camera in &mut scenario.cameras {
        camera.resolution = [160, 120];
        camera.lens = Lens::brown_conrady(intrinsics, [-0.1, 0.05, 1e-4, -1e-4, 0.0]).unwrap();
    }
    scenario
}

fn image(renderer: &mut Renderer, true_ns: u64) -> Vec<u8> {
    let [width, height] = renderer.camera().resolution;
    let mut image = vec![0; (width * height) as usize];
    renderer.render(true_ns, &mut image).unwrap();
    image
}

fn fresh(scenario: &Scenario, camera: usize, true_ns: u64) -> Vec<u8> {
    image(&mut Renderer::new(scenario, camera).unwrap(), true_ns)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(6))]

    #[test]
    fn same_seed_gives_the_same_bytes_and_another_seed_others(
        seed in 0u64..1 << 62,
        t_ns in 0u64..1 << 60,
        camera in 0usize..2,
    ) {
        let there = fresh(&small(seed), camera, t_ns);
        prop_assert_eq!(&fresh(&small(seed), camera, t_ns), &there);
        prop_assert_ne!(&fresh(&small(seed + 1), camera, t_ns), &there);
    }

    #[test]
    fn an_image_does_not_depend_on_those_before_it(
        t_ns in 0u64..1 << 60,
        others in prop::collection::vec(0u64..1 << 60, 1..6),
    ) {
        let scenario = small(1);
        let mut used = Renderer::new(&scenario, 1).unwrap();
        for other in others {
            image(&mut used, other);
        }
        prop_assert_eq!(image(&mut used, t_ns), fresh(&scenario, 1, t_ns));
    }
}

/// Objects that fly past the cameras, through them and out of the image, before several kinds of lenses.
fn wild(seed: u64) -> Scenario {
    let mut scenario = small(seed);
    let mut random = Random::new(seed);
    let intrinsics = Intrinsics {
        fx: random.between(60.0, 300.0),
        fy: random.between(60.0, 300.0),
        cx: 75.0,
        cy: 70.0,
    };
    scenario.cameras[0].lens = Lens::kannala_brandt(intrinsics, [0.05, -0.02, 0.0, 0.0]).unwrap();
    scenario.cameras[1].lens =
        Lens::brown_conrady(intrinsics, [-0.3, 0.05, 0.0, 0.0, 0.0]).unwrap();
    scenario
        .cameras
        .iter_mut()
        .for_each(|camera| camera.exposure_ns = 20_000_000);
    let eye = scenario.cameras[0].world_from_camera.translation.vector;
    for object in &mut scenario.objects {
        for (axis, wave) in object.path.position.iter_mut().enumerate() {
            *wave = Wave::still(eye[axis]).and(1 + axis as u32, 0.4, random.between(0.0, 6.0));
        }
    }
    scenario
}

#[test]
fn objects_that_pass_the_camera_leave_nothing_behind() {
    for seed in 0..4 {
        let scenario = wild(seed);
        for camera in 0..2 {
            let mut used = Renderer::new(&scenario, camera).unwrap();
            (0..150).for_each(|n| drop(image(&mut used, n * 50_000_000)));
            let true_ns = 3_210_000_000;
            assert_eq!(image(&mut used, true_ns), fresh(&scenario, camera, true_ns));
        }
    }
}

#[test]
fn noise_differs_between_cameras_and_times() {
    let mut scenario = small(1);
    scenario.cameras[1] = SceneCamera {
        id: "twin".into(),
        ..scenario.cameras[0].clone()
    };
    assert_ne!(fresh(&scenario, 0, 5), fresh(&scenario, 1, 5));
    assert_ne!(fresh(&scenario, 0, 5), fresh(&scenario, 0, 6));
}

#[test]
fn an_image_of_the_wrong_size_is_refused() {
    let mut renderer = Renderer::new(&small(1), 0).unwrap();
    let error = renderer.render(0, &mut [0; 100]).unwrap_err();
    assert_eq!(
        error.to_string(),
        "the image needs 19200 bytes, but 100 were given"
    );
    assert!(Renderer::new(&small(1), 2).is_err());
}

/// Changes whenever the demonstration's looks do, or a lens's arithmetic; then it must change alike on every platform.
#[test]
fn bytes_are_the_same_on_every_platform() {
    let mut renderer = Renderer::new(&Scenario::demo(4, 4, 7), 2).unwrap();
    let bytes = image(&mut renderer, 1_780_000_000_123_456_789);
    let hash = bytes.iter().fold(0xcbf2_9ce4_8422_2325_u64, |hash, &byte| {
        (hash ^ u64::from(byte)).wrapping_mul(0x100_0000_01b3)
    });
    assert_eq!(hash, 887_591_835_049_874_117);
}
