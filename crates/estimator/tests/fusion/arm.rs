//! An arm of two joints: links and joints found, honest, within their limits, also where a link is hidden.

use proptest::prelude::*;
use sextant_estimator::{Fusion, FusionOptions, Input};
use sextant_geometry::{Pose, se3};
use sextant_site_model::{ImageObservation, ObjectId, Rig};
use sextant_site_report::{ArticulatedEstimate, ObjectEstimate, State};

use crate::arm_scene::{ALL, arm, at, image, links, run};
use crate::scene::{PERIOD_NS, Random, START_NS, exact_options, poses, rig};

fn fusion(rig: &Rig, options: FusionOptions) -> Fusion {
    Fusion::new(rig.clone(), vec![arm()], options).unwrap()
}

fn feed(fusion: &mut Fusion, image: ImageObservation) -> Option<ObjectEstimate> {
    fusion.handle(image.capture_ns + 10_000_000, Input::Image(image));
    poses(fusion).pop()
}

fn posture(estimate: &ObjectEstimate) -> &ArticulatedEstimate {
    estimate.articulated.as_ref().unwrap()
}

fn nees(estimate: &ObjectEstimate, link: usize) -> f64 {
    let (base, values) = at(estimate.capture_ns);
    let one = &posture(estimate).links[link];
    let off = se3::difference(&one.world_from_link, &links(&base, values)[link]);
    off.dot(&one.covariance.cholesky().unwrap().solve(&off)) / 6.0
}

#[test]
fn links_and_joints_are_found_and_followed() {
    let rig = rig(4);
    let mut fusion = fusion(&rig, exact_options());
    let (mut squares, mut count) = ([0.0; 5], 0);
    for image in run(&rig, 3.0, |_| ALL, 1) {
        let time_ns = image.capture_ns;
        let Some(estimate) = feed(&mut fusion, image) else {
            continue;
        };
        let (base, values) = at(time_ns);
        assert!(time_ns < START_NS + 100_000_000 || estimate.state == State::Tracking);
        let posture = posture(&estimate);
        assert_eq!(posture.links[0].world_from_link, estimate.world_from_object);
        assert!((posture.links[0].covariance - estimate.covariance).amax() < 1e-9);
        if time_ns > START_NS + 300_000_000 {
            count += 1;
            for (link, truth) in links(&base, values).iter().enumerate() {
                let off = se3::difference(&posture.links[link].world_from_link, truth);
                squares[link] += off.fixed_rows::<3>(0).norm_squared();
            }
            for joint in 0..2 {
                squares[3 + joint] += (posture.joints[joint].value - values[joint]).powi(2);
            }
        }
    }
    let rms = squares.map(|square| (square / f64::from(count)).sqrt());
    assert!(count > 300);
    assert!(rms[..3].iter().all(|rms| *rms < 0.5e-3), "{rms:?}");
    assert!(rms[3..].iter().all(|rms| *rms < 0.006), "{rms:?}");
}

#[test]
fn errors_of_links_and_joints_are_as_large_as_their_covariance_says() {
    let rig = rig(3);
    let (mut of_links, mut of_joints, mut runs) = ([0.0; 3], [0.0; 2], 0.0);
    for seed in 0..120 {
        let mut fusion = fusion(&rig, exact_options());
        let images = run(&rig, 0.3 + 0.01 * seed as f64, |_| ALL, seed);
        let last = images
            .into_iter()
            .filter_map(|image| feed(&mut fusion, image))
            .last();
        let last = last.unwrap();
        let (_, values) = at(last.capture_ns);
        runs += 1.0;
        for (link, sum) in of_links.iter_mut().enumerate() {
            *sum += nees(&last, link);
        }
        for (joint, sum) in of_joints.iter_mut().enumerate() {
            let one = &posture(&last).joints[joint];
            *sum += (one.value - values[joint]).powi(2) / one.variance;
        }
    }
    for mean in of_links.map(|sum| sum / runs) {
        assert!((0.75..1.25).contains(&mean), "{of_links:?} / {runs}");
    }
    // A mean of 120 squares of one Gaussian has a sigma of 0.13.
    for mean in of_joints.map(|sum| sum / runs) {
        assert!((0.6..1.5).contains(&mean), "{of_joints:?} / {runs}");
    }
}

#[test]
fn a_hidden_link_follows_with_a_larger_covariance_and_is_found_again() {
    let rig = rig(4);
    let mut fusion = fusion(&rig, exact_options());
    // The forearm is hidden from 1 s to 2 s.
    let seen = |seconds: f64| {
        if (1.0..2.0).contains(&seconds) {
            &ALL[..2]
        } else {
            ALL
        }
    };
    let mut widest: f64 = 0.0;
    let mut before: f64 = 0.0;
    for image in run(&rig, 2.5, seen, 4) {
        let seconds = (image.capture_ns - START_NS) as f64 * 1e-9;
        let Some(estimate) = feed(&mut fusion, image) else {
            continue;
        };
        let value = posture(&estimate).joints[1].value;
        assert!((-1.2..=1.2).contains(&value), "{value}");
        let sigma = posture(&estimate).links[2].covariance.trace().sqrt();
        let upper = posture(&estimate).links[1].covariance.trace().sqrt();
        if (0.5..1.0).contains(&seconds) {
            before = before.max(sigma);
        } else if (1.0..2.0).contains(&seconds) {
            widest = widest.max(sigma);
            assert_eq!(estimate.state, State::Tracking);
            assert!(
                upper < 0.1 && nees(&estimate, 2) < 6.0,
                "{seconds} s: {}",
                nees(&estimate, 2)
            );
        } else if seconds > 2.1 {
            assert!(
                sigma < 3.0 * before && nees(&estimate, 2) < 6.0,
                "{seconds} s"
            );
        }
    }
    assert!(widest > 10.0 * before, "{before} {widest}");
}

#[test]
fn the_base_follows_from_a_link_when_it_is_never_seen_with_others() {
    let rig = rig(4);
    let mut fusion = fusion(&rig, exact_options());
    let mut last = None;
    for image in run(&rig, 0.7, |_| &ALL[2..], 5) {
        last = feed(&mut fusion, image).or(last);
    }
    let last = last.unwrap();
    assert_eq!(
        last.state,
        State::Initialising,
        "the base may be anywhere about the joints"
    );
    let sigmas = [0, 1, 2].map(|link| posture(&last).links[link].covariance.trace().sqrt());
    assert!(
        sigmas[2] < 0.1 && sigmas[2] < 0.2 * sigmas[1] && sigmas[1] < sigmas[0],
        "{sigmas:?}"
    );
    for (joint, limit) in [(0, 2.0), (1, 1.2)] {
        let one = &posture(&last).joints[joint];
        assert!(
            one.value.abs() <= limit && one.variance.sqrt() > 0.2 * limit,
            "{one:?}"
        );
    }
    // Then all links show, somewhere else on the arc: known within the time of a contradiction.
    for image in run(
        &rig,
        1.2,
        |seconds| if seconds < 0.75 { &[] } else { ALL },
        6,
    ) {
        if image.capture_ns > START_NS + 750_000_000 {
            let seconds = (image.capture_ns - START_NS) as f64 * 1e-9;
            let estimate = feed(&mut fusion, image);
            if seconds > 1.0 {
                let estimate = estimate.unwrap();
                assert_eq!(estimate.state, State::Tracking);
                assert!((0..3).all(|link| nees(&estimate, link) < 6.0));
            }
        }
    }
}

#[test]
fn one_camera_is_enough_when_it_sees_all_links() {
    let rig = rig(1);
    let mut fusion = fusion(&rig, exact_options());
    let mut tracked = 0;
    for image in run(&rig, 2.0, |_| ALL, 8) {
        let time_ns = image.capture_ns;
        let Some(estimate) = feed(&mut fusion, image) else {
            continue;
        };
        let (base, values) = at(time_ns);
        let truth = links(&base, values);
        if estimate.state == State::Tracking {
            tracked += 1;
            for (found, truth) in posture(&estimate).links.iter().zip(&truth) {
                let turn = found.world_from_link.rotation.angle_to(&truth.rotation);
                assert!(turn < 0.3, "{} flipped at {time_ns}: {turn}", found.link);
            }
        }
    }
    assert!(tracked > 45, "{tracked}");
}

#[test]
fn a_joint_at_its_limit_is_not_published_beyond() {
    let rig = rig(2);
    let mut fusion = fusion(&rig, exact_options());
    let mut random = Random(3);
    let (mut beyond, mut close) = (0, 0);
    for index in 0..60u64 {
        let time_ns = START_NS + index * PERIOD_NS / 2;
        let (camera, base) = ((index % 2) as usize, Pose::translation(-0.08, 0.0, 0.0));
        let values = [0.3, 1.2];
        let image = image(&rig, camera, time_ns, ALL, &base, values, &mut random);
        let Some(estimate) = feed(&mut fusion, image) else {
            continue;
        };
        let elbow = &posture(&estimate).joints[1];
        beyond += u32::from(elbow.value > 1.2);
        close += u32::from(elbow.value > 1.2 - 4.0 * elbow.variance.sqrt());
        assert!(elbow.variance > 0.0);
    }
    assert_eq!(beyond, 0);
    assert!(close > 45, "{close}");
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(8))]

    #[test]
    fn an_arm_is_the_same_in_whatever_order_its_images_come(
        order in Just((0..30usize).collect::<Vec<_>>()).prop_shuffle(),
    ) {
        let rig = rig(2);
        let images = run(&rig, 0.5, |_| ALL, 9);
        prop_assert_eq!(images.len(), 30);
        let now = images.iter().map(|image| image.capture_ns).max().unwrap();
        let estimates = |order: &[usize]| {
            let mut fusion = fusion(&rig, FusionOptions::default());
            for index in order {
                fusion.handle(now, Input::Image(images[*index].clone()));
            }
            images
                .iter()
                .map(|image| fusion.pose_at(&ObjectId::new("arm").unwrap(), image.capture_ns))
                .collect::<Vec<_>>()
        };
        let sorted: Vec<usize> = (0..30).collect();
        for (a, b) in estimates(&sorted).iter().zip(&estimates(&order)) {
            let (Some(a), Some(b)) = (a, b) else {
                prop_assert_eq!(a, b);
                continue;
            };
            for (a, b) in posture(a).joints.iter().zip(&posture(b).joints) {
                prop_assert!((a.value - b.value).abs() < 1e-9);
                prop_assert!((a.variance - b.variance).abs() < 1e-9);
            }
        }
    }
}
