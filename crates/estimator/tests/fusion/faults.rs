//! Wrong inputs are counted and change nothing else.

use nalgebra::{Matrix2, Point2};
use proptest::prelude::*;
use sextant_estimator::{FusionOptions, Input};
use sextant_site_model::{CameraId, ImageObservation, TagCorners};
use sextant_site_report::{Fault, State};

use crate::scene::{
    Random, START_NS, cube, feed, fusion, path_at, poses, position_error, rig, run, tag_id,
};

#[test]
fn what_cannot_be_used_is_counted() {
    let (rig, object) = (rig(2), cube());
    let mut fusion = fusion(&rig, &object, FusionOptions::default());
    let images = run(&rig, &object, 0.1, 1.5, &mut Random(1));
    let mut strange = images[4].clone();
    strange.tags[0].corners[2].x = f64::NAN;
    strange.tags.push(TagCorners {
        tag: tag_id(99),
        ..strange.tags[0].clone()
    });
    let unknown = ImageObservation {
        camera: CameraId::new("nobody").unwrap(),
        ..images[0].clone()
    };
    let ahead = ImageObservation {
        capture_ns: START_NS + 60_000_000_000,
        ..images[0].clone()
    };
    for image in [&images[0], &images[0], &strange, &unknown] {
        feed(&mut fusion, image.clone());
    }
    fusion.handle(START_NS, Input::Image(ahead));
    images[60..]
        .iter()
        .for_each(|image| drop(feed(&mut fusion, image.clone())));
    feed(&mut fusion, images[2].clone());
    let statistics = fusion.statistics();
    let counts = statistics.cameras[&images[0].camera];
    assert_eq!(statistics.unknown_cameras, 1);
    assert_eq!((counts.duplicates, counts.ahead, counts.late), (1, 1, 1));
    assert_eq!((counts.unknown_tags, counts.damaged_tags), (1, 1));
}

#[test]
fn images_of_another_size_than_the_rig_says_are_left_out_and_named() {
    let (rig, object) = (rig(2), cube());
    let mut fusion = fusion(&rig, &object, FusionOptions::default());
    let of_rig = rig.cameras()[0].resolution;
    let size = of_rig.map(|pixels| pixels / 2);
    let mut images = run(&rig, &object, 0.1, 1.5, &mut Random(1));
    for image in &mut images {
        let is_smaller = image.camera == rig.cameras()[0].id;
        image.resolution = Some(if is_smaller { size } else { of_rig });
    }
    for image in &images {
        for pose in feed(&mut fusion, image.clone()) {
            assert_eq!(pose.cameras, 1);
        }
    }
    let camera = rig.cameras()[0].id.clone();
    assert!(fusion.statistics().cameras[&camera].other_size > 10);
    let named = Fault::ImageSize {
        camera: camera.clone(),
        size,
        of_rig,
    };
    assert!(fusion.faults().contains(&named));
    let silent_ns = fusion.poll_timeout().unwrap();
    fusion.handle(silent_ns, Input::Tick);
    fusion.handle(silent_ns + 2_000_000_000, Input::Tick);
    assert!(!fusion.faults().contains(&named));
    let last = images.iter().rfind(|image| image.camera == camera);
    feed(&mut fusion, last.unwrap().clone());
    assert!(fusion.faults().contains(&named));
    let as_in_the_rig = ImageObservation {
        resolution: Some(of_rig),
        ..images
            .into_iter()
            .rfind(|image| image.camera == camera)
            .unwrap()
    };
    feed(&mut fusion, as_in_the_rig);
    assert!(!fusion.faults().contains(&named));
}

#[test]
fn wrong_corners_are_left_out() {
    let (rig, object) = (rig(4), cube());
    let mut fusion = fusion(&rig, &object, FusionOptions::default());
    let mut random = Random(21);
    let mut square = 0.0;
    let mut poses = 0;
    for mut image in run(&rig, &object, 0.1, 5.0, &mut Random(20)) {
        for corner in image.tags.iter_mut().flat_map(|tag| &mut tag.corners) {
            if random.uniform() < 0.05 {
                *corner += nalgebra::Vector2::new(random.gauss(), random.gauss()) * 20.0;
            }
        }
        let time_ns = image.capture_ns;
        for estimate in feed(&mut fusion, image)
            .iter()
            .filter(|_| time_ns > START_NS + 300_000_000)
        {
            assert_ne!(estimate.state, State::Lost);
            square += position_error(estimate, &path_at(time_ns)).powi(2);
            poses += 1;
        }
    }
    let rms = (square / f64::from(poses)).sqrt();
    assert!(rms < 1e-3, "{rms}");
}

fn number() -> impl Strategy<Value = f64> {
    prop_oneof![
        6 => 0.0..640.0,
        1 => -1e4..1e4,
        1 => prop::num::f64::ANY,
    ]
}

fn tag() -> impl Strategy<Value = TagCorners> {
    let corners = prop::array::uniform4((number(), number()));
    let covariances = prop::array::uniform4((number(), number(), number()));
    (0u32..8, corners, covariances).prop_map(|(id, corners, covariances)| TagCorners {
        tag: tag_id(id),
        corners: corners.map(|(x, y)| Point2::new(x, y)),
        corner_covariance: covariances.map(|(xx, xy, yy)| Matrix2::new(xx, xy, xy, yy)),
        corner_cross_covariance: [Matrix2::zeros(); 6],
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn garbage_gives_finite_poses_or_none(
        images in prop::collection::vec((0usize..3, 0u64..1_200_000_000, prop::collection::vec(tag(), 0..6)), 1..25),
    ) {
        let mut fusion = fusion(&rig(3), &cube(), FusionOptions::default());
        for (camera, after_ns, tags) in images {
            let capture_ns = START_NS + after_ns;
            let image = ImageObservation {
                camera: CameraId::new(&format!("cam{camera}")).unwrap(),
                capture_ns,
                clock_error_ns: if after_ns % 2 == 0 { 0 } else { ImageObservation::CLOCK_ERROR_UNKNOWN },
                exposure_ns: 0,
                resolution: None,
                tags,
            };
            fusion.handle(START_NS + 1_000_000_000, Input::Image(image));
            for estimate in poses(&mut fusion) {
                let pose = estimate.world_from_object.to_homogeneous();
                let numbers = pose.iter().chain(estimate.covariance.iter()).chain(estimate.twist.iter());
                prop_assert!(numbers.into_iter().all(|x| x.is_finite()));
                prop_assert!((0..6).all(|axis| estimate.covariance[(axis, axis)] >= 0.0));
            }
        }
    }
}
