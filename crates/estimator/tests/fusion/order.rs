//! What comes out depends on when images were taken, not on when they came.

use proptest::prelude::*;
use sextant_estimator::{FusionOptions, ImageObservation, Input, ObjectEstimate};

use crate::scene::{Eye, Random, cube, cube_id, fusion, poses, rig, run_in_phase};

/// Images of half a second; the first two cameras share their instants, the third runs free.
fn images(seed: u64) -> Vec<ImageObservation> {
    let (rig, object) = (rig(3), cube());
    let eye = Eye {
        rig: &rig,
        object: &object,
        sigma_px: 0.1,
    };
    let phase_ns = |camera| if camera < 2 { 0 } else { 12_345_678 };
    run_in_phase(&eye, 0.45, phase_ns, &mut Random(seed))
}

/// The estimates at all capture times once everything has come.
fn estimates(images: &[ImageObservation], order: &[usize]) -> Vec<Option<ObjectEstimate>> {
    let mut fusion = fusion(&rig(3), &cube(), FusionOptions::default());
    let now = images.iter().map(|image| image.capture_ns).max().unwrap();
    for index in order {
        fusion.handle(now, Input::Image(images[*index].clone()));
        poses(&mut fusion);
    }
    images
        .iter()
        .map(|image| fusion.pose_at(&cube_id(), image.capture_ns))
        .collect()
}

fn gap(a: &ObjectEstimate, b: &ObjectEstimate) -> f64 {
    let pose = sextant_geometry::se3::difference(&a.world_from_object, &b.world_from_object).amax();
    pose.max((a.covariance - b.covariance).amax())
        .max((a.twist - b.twist).amax())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    #[test]
    fn late_reordered_and_duplicated_images_give_the_same_poses(
        seed in 0u64..1000,
        order in Just((0..39usize).collect::<Vec<_>>()).prop_shuffle(),
        again in prop::collection::vec(0usize..39, 0..20),
    ) {
        let images = images(seed);
        prop_assert_eq!(images.len(), 39);
        let sorted: Vec<usize> = (0..39).collect();
        let shuffled: Vec<usize> = order.into_iter().chain(again).collect();
        for (a, b) in estimates(&images, &sorted).iter().zip(&estimates(&images, &shuffled)) {
            match (a, b) {
                (Some(a), Some(b)) => prop_assert!(a.state == b.state && gap(a, b) < 1e-9),
                (a, b) => prop_assert_eq!(a, b),
            }
        }
    }
}

#[test]
fn the_same_images_give_the_same_bits() {
    let images = images(7);
    let order: Vec<usize> = (0..images.len()).rev().collect();
    assert_eq!(estimates(&images, &order), estimates(&images, &order));
}

#[test]
fn simultaneous_images_are_taken_jointly_whichever_comes_first() {
    let (rig, object) = (rig(4), cube());
    let eye = Eye {
        rig: &rig,
        object: &object,
        sigma_px: 0.1,
    };
    let images = run_in_phase(&eye, 0.2, |_| 0, &mut Random(3));
    let mut swapped = images.clone();
    swapped.reverse();
    let run = |images: &[ImageObservation]| {
        let mut fusion = fusion(&rig, &object, FusionOptions::default());
        let now = images.iter().map(|image| image.capture_ns).max().unwrap();
        images
            .iter()
            .for_each(|image| fusion.handle(now, Input::Image(image.clone())));
        fusion.pose_at(&cube_id(), now)
    };
    let pose = run(&images).unwrap();
    assert_eq!(Some(&pose), run(&swapped).as_ref());
    assert_eq!(pose.cameras, 4);
}
