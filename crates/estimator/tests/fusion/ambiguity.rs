//! One tag looks almost the same tilted either way: when that is known, and when not.

use nalgebra::{UnitQuaternion, Vector3};
use sextant_estimator::FusionOptions;
use sextant_geometry::Pose;
use sextant_site_model::Rig;
use sextant_site_report::{ObjectEstimate, State};

use crate::scene::{
    Eye, PERIOD_NS, Random, START_NS, attitude_error, card, exact_options, feed, fusion,
    looking_from, rig,
};

/// A card at the world's origin that faces the first camera but for a tilt about a level axis.
pub fn tilted(tilt: f64) -> Pose {
    let camera = looking_from(Vector3::new(1.0, 0.0, 0.7));
    let facing =
        camera.rotation * UnitQuaternion::from_axis_angle(&Vector3::x_axis(), std::f64::consts::PI);
    let turned = facing * UnitQuaternion::from_axis_angle(&Vector3::y_axis(), tilt);
    Pose::from_parts(Vector3::zeros().into(), turned)
}

/// What is said about a resting card, image by image, by the first cameras of a ring.
fn watch(rig: &Rig, pose: &Pose, sigma_px: f64, rounds: u64, seed: u64) -> Vec<ObjectEstimate> {
    let (object, mut random) = (card(), Random(seed));
    let eye = Eye {
        rig,
        object: &object,
        sigma_px,
    };
    let mut fusion = fusion(rig, &object, exact_options());
    let mut said = Vec::new();
    for round in 0..rounds {
        for camera in 0..rig.cameras().len() {
            let time_ns = START_NS + round * PERIOD_NS + camera as u64 * 5_000_000;
            said.extend(feed(
                &mut fusion,
                eye.image(camera, time_ns, pose, &mut random),
            ));
        }
    }
    said
}

#[test]
fn a_tag_tilted_far_is_tracked_by_one_camera() {
    for seed in 0..20 {
        let pose = tilted(0.8);
        let said = watch(&rig(1), &pose, 0.03, 10, seed);
        let last = said.last().unwrap();
        assert_eq!(last.state, State::Tracking, "seed {seed}");
        assert!(attitude_error(last, &pose) < 0.03, "seed {seed}");
    }
}

#[test]
fn a_flipped_attitude_is_never_called_tracking() {
    for seed in 0..60 {
        let tilt = 0.02 * (seed % 20) as f64;
        let pose = tilted(tilt);
        for estimate in watch(&rig(1), &pose, 0.1, 12, seed) {
            let off = attitude_error(&estimate, &pose);
            assert!(
                estimate.state != State::Tracking || off < 0.3,
                "seed {seed}: tilt {tilt} off by {off}"
            );
        }
    }
}

#[test]
fn a_frontal_tag_says_how_little_it_knows() {
    let mut vaguest: f64 = 0.0;
    for seed in 0..20 {
        let pose = tilted(0.05);
        for estimate in watch(&rig(1), &pose, 0.1, 20, seed) {
            let sigma = estimate.covariance.fixed_view::<3, 3>(3, 3).trace().sqrt();
            let off = attitude_error(&estimate, &pose);
            // One in 6000 lies beyond this of three degrees of freedom; 400 are looked at.
            assert!(off < 4.5 * sigma, "seed {seed}: {off} with sigma {sigma}");
            vaguest = vaguest.max(sigma);
        }
    }
    assert!(vaguest > 0.1, "{vaguest}");
}

#[test]
fn a_second_view_tells_the_branches_apart_at_once() {
    for seed in 0..40 {
        let pose = tilted(0.03 * (seed % 10) as f64);
        let said = watch(&rig(2), &pose, 0.1, 3, seed);
        let last = said.last().unwrap();
        assert_eq!(last.state, State::Tracking, "seed {seed}");
        assert!(
            attitude_error(last, &pose) < 0.03,
            "seed {seed}: {}",
            attitude_error(last, &pose)
        );
    }
}

#[test]
fn a_tag_that_turns_through_the_frontal_view_does_not_flip() {
    let (rig, object) = (rig(1), card());
    let eye = Eye {
        rig: &rig,
        object: &object,
        sigma_px: 0.03,
    };
    for seed in 0..20 {
        let mut random = Random(seed);
        let mut fusion = fusion(&rig, &object, FusionOptions::default());
        for round in 0..40 {
            let pose = tilted(-0.9 + 1.8 * round as f64 / 39.0);
            let said = feed(
                &mut fusion,
                eye.image(0, START_NS + round * PERIOD_NS, &pose, &mut random),
            );
            for estimate in said
                .iter()
                .filter(|estimate| estimate.state == State::Tracking)
            {
                assert!(
                    attitude_error(estimate, &pose) < 0.25,
                    "seed {seed} round {round}"
                );
            }
        }
        let last = fusion
            .pose_at(&crate::scene::cube_id(), START_NS + 39 * PERIOD_NS)
            .unwrap();
        assert!(attitude_error(&last, &tilted(0.9)) < 0.05, "seed {seed}");
    }
}
