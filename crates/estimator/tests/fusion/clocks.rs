//! Clocks that are off are found out by the motion itself.

use sextant_estimator::{Fusion, FusionOptions};
use sextant_site_model::{ImageObservation, Rig};

use crate::scene::{
    Eye, PERIOD_NS, Random, START_NS, camera_id, cube, feed, fusion, path_at, position_error, rig,
};

/// Runs free cameras whose stamps lie `offsets_ns` after the truth; the largest error of position after the first
/// second.
fn watch(
    rig: &Rig,
    offsets_ns: &[i64],
    clock_error_ns: u64,
    seconds: u64,
    seed: u64,
) -> (Fusion, f64) {
    let object = cube();
    let eye = Eye {
        rig,
        object: &object,
        sigma_px: 0.05,
    };
    watch_with(&eye, offsets_ns, clock_error_ns, seconds, seed)
}

fn watch_with(
    eye: &Eye<'_>,
    offsets_ns: &[i64],
    clock_error_ns: u64,
    seconds: u64,
    seed: u64,
) -> (Fusion, f64) {
    let (rig, object, mut random) = (eye.rig, eye.object, Random(seed));
    let mut fusion = fusion(rig, object, FusionOptions::default());
    let mut images: Vec<ImageObservation> = Vec::new();
    for round in 0..seconds * 30 {
        for (camera, offset_ns) in offsets_ns.iter().enumerate() {
            let true_ns = START_NS + 100_000_000 + round * PERIOD_NS + camera as u64 * 7_123_457;
            let stamp_ns = true_ns.strict_add_signed(*offset_ns);
            let mut image = eye.image(camera, stamp_ns, &path_at(true_ns), &mut random);
            image.clock_error_ns = if camera == 0 { 0 } else { clock_error_ns };
            images.push(image);
        }
    }
    let mut worst: f64 = 0.0;
    for image in images {
        for estimate in feed(&mut fusion, image) {
            if estimate.capture_ns > START_NS + 1_200_000_000 {
                worst = worst.max(position_error(&estimate, &path_at(estimate.capture_ns)));
            }
        }
    }
    (fusion, worst)
}

#[test]
fn offsets_that_nobody_knows_are_estimated() {
    let (fusion, worst) = watch(
        &rig(4),
        &[0, -9_000_000, 16_000_000, 4_500_000],
        ImageObservation::CLOCK_ERROR_UNKNOWN,
        3,
        1,
    );
    let offsets = fusion.clock_offsets();
    for (camera, truth_s) in [(1, -0.009), (2, 0.016), (3, 0.0045)] {
        let found = offsets[&camera_id(camera)];
        assert!(
            (found.offset_s - truth_s).abs() < 0.0005,
            "{camera}: {found:?}"
        );
        assert!(
            (found.offset_s - truth_s).abs() < 5.0 * found.sigma_s,
            "{camera}: {found:?}"
        );
    }
    assert!(worst < 2e-3, "{worst}");
}

/// A wrong clock contradicts sharp corners at once: what is found out about it must not depend on views being refused.
#[test]
fn offsets_are_found_in_the_sharpest_images() {
    let (rig, object) = (rig(4), cube());
    let eye = Eye {
        rig: &rig,
        object: &object,
        sigma_px: 0.012,
    };
    for seed in 0..5 {
        let mut random = Random(seed + 100);
        let mut offset_ns = || (random.gauss() * 12e6) as i64;
        let offsets_ns = [0, offset_ns(), offset_ns(), offset_ns()];
        let unknown = ImageObservation::CLOCK_ERROR_UNKNOWN;
        let (fusion, worst) = watch_with(&eye, &offsets_ns, unknown, 2, seed);
        let found = fusion.clock_offsets();
        for camera in 1..4 {
            let off_s = found[&camera_id(camera)].offset_s - offsets_ns[camera] as f64 * 1e-9;
            assert!(off_s.abs() < 0.0005, "seed {seed} camera {camera}: {off_s}");
        }
        assert!(worst < 2e-3, "seed {seed}: {worst}");
    }
}

#[test]
fn offsets_within_what_the_clocks_state_are_estimated() {
    let (fusion, worst) = watch(&rig(3), &[0, 2_000_000, -1_000_000], 2_000_000, 3, 2);
    let offsets = fusion.clock_offsets();
    assert!((offsets[&camera_id(1)].offset_s - 0.002).abs() < 0.0003);
    assert!((offsets[&camera_id(2)].offset_s + 0.001).abs() < 0.0003);
    assert!(worst < 1e-3, "{worst}");
}

#[test]
fn clocks_that_agree_are_found_to_agree() {
    let (fusion, worst) = watch(
        &rig(4),
        &[0; 4],
        ImageObservation::CLOCK_ERROR_UNKNOWN,
        3,
        3,
    );
    for (camera, found) in fusion.clock_offsets() {
        assert!(found.sigma_s < 0.0005, "{camera}: {found:?}");
        assert!(
            found.offset_s.abs() < 4.0 * found.sigma_s,
            "{camera}: {found:?}"
        );
    }
    assert!(worst < 1e-3, "{worst}");
}

/// Nothing else tells its time, so that its images may be of a little earlier or later for all that is known.
#[test]
fn a_camera_alone_with_an_object_tells_nothing_of_its_own_clock() {
    let (rig, object) = (rig(2), cube());
    let eye = Eye {
        rig: &rig,
        object: &object,
        sigma_px: 0.05,
    };
    for seed in 1..5 {
        let (mut fusion, mut random) = (
            fusion(&rig, &object, FusionOptions::default()),
            Random(seed),
        );
        for round in 0..30 {
            let time_ns = START_NS + seed * 700_000_000 + round * PERIOD_NS;
            let mut image = eye.image(1, time_ns, &path_at(time_ns), &mut random);
            image.clock_error_ns = 20_000_000;
            feed(&mut fusion, image);
        }
        let found = fusion.clock_offsets()[&camera_id(1)];
        assert!(found.sigma_s > 0.0199, "seed {seed}: {found:?}");
        assert!(found.offset_s.abs() < 0.001, "seed {seed}: {found:?}");
    }
}

#[test]
fn poses_have_the_time_at_which_their_images_were_taken() {
    let (rig, object, ahead_ns) = (rig(3), cube(), 12_000_000);
    let eye = Eye {
        rig: &rig,
        object: &object,
        sigma_px: 0.05,
    };
    let (mut fusion, mut random) = (fusion(&rig, &object, FusionOptions::default()), Random(3));
    for number in 0..180 {
        let (camera, true_ns) = (number % 3, START_NS + number as u64 * PERIOD_NS / 3);
        let stamp_ns = true_ns + if camera == 1 { ahead_ns } else { 0 };
        let mut image = eye.image(camera, stamp_ns, &path_at(true_ns), &mut random);
        image.clock_error_ns = ImageObservation::CLOCK_ERROR_UNKNOWN;
        let seconds = (true_ns - START_NS) as f64 * 1e-9;
        for estimate in feed(&mut fusion, image) {
            let off_ns = estimate.capture_ns.abs_diff(true_ns);
            assert!(
                seconds < 0.4 || off_ns < 1_000_000,
                "{seconds} s: {off_ns} ns"
            );
            let error = position_error(&estimate, &path_at(estimate.capture_ns));
            assert!(seconds < 0.4 || error < 0.001, "{seconds} s: {error} m");
        }
    }
}
