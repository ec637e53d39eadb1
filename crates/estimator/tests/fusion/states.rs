//! When an object is tracked, coasting and lost.

use sextant_estimator::{FusionOptions, Input};
use sextant_geometry::Pose;
use sextant_site_model::ImageObservation;
use sextant_site_report::State;

use crate::scene::{
    Eye, PERIOD_NS, Random, START_NS, cube, feed, fusion, path, path_at, poses, position_error,
    rig, run,
};

fn empty(mut image: ImageObservation) -> ImageObservation {
    image.tags.clear();
    image
}

#[test]
fn an_unseen_object_coasts_with_growing_covariance_and_is_lost_once() {
    let (rig, object) = (rig(2), cube());
    let mut fusion = fusion(&rig, &object, FusionOptions::default());
    let mut coasted = Vec::new();
    for (index, image) in run(&rig, &object, 0.1, 2.0, &mut Random(4))
        .into_iter()
        .enumerate()
    {
        let unseen = index >= 40;
        let said = feed(&mut fusion, if unseen { empty(image) } else { image });
        coasted.extend(said.into_iter().filter(|_| unseen));
    }
    let (lost, coasting): (Vec<_>, Vec<_>) = coasted
        .into_iter()
        .partition(|estimate| estimate.state == State::Lost);
    assert!(
        !coasting.is_empty()
            && coasting
                .iter()
                .all(|estimate| estimate.state == State::Coasting)
    );
    assert!(
        coasting
            .windows(2)
            .all(|pair| pair[0].covariance.trace() < pair[1].covariance.trace())
    );
    assert_eq!(lost.len(), 1);
}

#[test]
fn a_loss_is_announced_by_the_timeout_and_said_on_a_tick() {
    let (rig, object) = (rig(2), cube());
    let mut fusion = fusion(&rig, &object, FusionOptions::default());
    assert_eq!(fusion.poll_timeout(), None);
    for image in run(&rig, &object, 0.1, 0.3, &mut Random(4)) {
        feed(&mut fusion, image);
    }
    let timeout_ns = fusion.poll_timeout().unwrap();
    fusion.handle(timeout_ns - 1, Input::Tick);
    assert!(poses(&mut fusion).is_empty());
    fusion.handle(timeout_ns, Input::Tick);
    assert_eq!(poses(&mut fusion)[0].state, State::Lost);
    // Then the cameras are gone.
    while let Some(timeout_ns) = fusion.poll_timeout() {
        assert!(timeout_ns < START_NS + 3_000_000_000);
        fusion.handle(timeout_ns, Input::Tick);
    }
    assert!(poses(&mut fusion).is_empty());
}

#[test]
fn an_object_put_elsewhere_is_found_again() {
    let (rig, object) = (rig(4), cube());
    let eye = Eye {
        rig: &rig,
        object: &object,
        sigma_px: 0.1,
    };
    let (mut fusion, mut random) = (fusion(&rig, &object, FusionOptions::default()), Random(9));
    let place = |round: u64| {
        if round < 20 {
            path_at(START_NS)
        } else {
            path_at(START_NS + 1_500_000_000)
        }
    };
    for round in 0..40 {
        let time_ns = START_NS + round * PERIOD_NS;
        let mut last = Vec::new();
        for camera in 0..4 {
            last.extend(feed(
                &mut fusion,
                eye.image(camera, time_ns, &place(round), &mut random),
            ));
        }
        let tracked = last
            .last()
            .filter(|estimate| estimate.state == State::Tracking);
        let near = tracked.is_some_and(|estimate| position_error(estimate, &place(round)) < 1e-3);
        assert!(near || (20..26).contains(&round), "round {round}: {last:?}");
    }
}

#[test]
fn an_object_that_is_elsewhere_in_every_round_is_found_in_every_round() {
    let (rig, object) = (rig(4), cube());
    let eye = Eye {
        rig: &rig,
        object: &object,
        sigma_px: 0.1,
    };
    let (mut fusion, mut random) = (fusion(&rig, &object, FusionOptions::default()), Random(9));
    for round in 0..40 {
        let time_ns = START_NS + round * 3 * PERIOD_NS;
        let pose = path(1.7 * round as f64);
        let mut last = Vec::new();
        for camera in 0..4 {
            last.extend(feed(
                &mut fusion,
                eye.image(camera, time_ns, &pose, &mut random),
            ));
        }
        let last = last.last().unwrap();
        assert!(
            position_error(last, &pose) < 1e-3,
            "round {round}: {:?}",
            last.state
        );
    }
}

#[test]
fn an_object_that_is_hit_is_followed() {
    let (rig, object) = (rig(3), cube());
    let eye = Eye {
        rig: &rig,
        object: &object,
        sigma_px: 0.1,
    };
    let (mut fusion, mut random) = (fusion(&rig, &object, FusionOptions::default()), Random(9));
    // At rest, then at once at 0.8 m/s.
    let place = |time_ns: u64| {
        let since_s = time_ns.saturating_sub(START_NS + 500_000_000) as f64 * 1e-9;
        Pose::translation(0.8 * since_s, 0.0, 0.0) * path_at(START_NS)
    };
    for round in 0..24 {
        for camera in 0..3 {
            let time_ns = START_NS + round * PERIOD_NS + camera as u64 * 11_000_000;
            for estimate in feed(
                &mut fusion,
                eye.image(camera, time_ns, &place(time_ns), &mut random),
            ) {
                let off = position_error(&estimate, &place(time_ns));
                assert!(
                    off < 0.012,
                    "round {round} camera {camera}: {off} {:?}",
                    estimate.state
                );
            }
        }
    }
}
