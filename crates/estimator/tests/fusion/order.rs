//! What comes out depends on when images were taken, not on when they came.

use nalgebra::Matrix2;
use proptest::prelude::*;
use sextant_estimator::{FusionOptions, Input};
use sextant_geometry::Lens;
use sextant_site_model::{ImageObservation, ObjectModel, Rig};
use sextant_site_report::ObjectEstimate;

use crate::arm_scene::{self, ALL, arm};
use crate::scene::{
    Eye, PERIOD_NS, Random, START_NS, cube, fusion, poses, rig, run_in_phase, with_cameras,
};

/// What is there and what it looks like.
struct Show {
    rig: Rig,
    object: ObjectModel,
    images: Vec<ImageObservation>,
}

/// Images of half a second; the first two cameras share their instants, the third runs free.
fn plain(seed: u64) -> Show {
    let (rig, object) = (rig(3), cube());
    let eye = Eye {
        rig: &rig,
        object: &object,
        sigma_px: 0.1,
    };
    let phase_ns = |camera| if camera < 2 { 0 } else { 12_345_678 };
    let images = run_in_phase(&eye, 0.45, phase_ns, &mut Random(seed));
    Show {
        rig,
        object,
        images,
    }
}

/// An arm whose joints move; the first two cameras share their instants, the third runs free.
fn plain_arm(seed: u64) -> Show {
    let (rig, object, mut random) = (rig(3).exact(), arm(), Random(seed));
    let image = |number: u64| {
        let (camera, round) = ((number % 3) as usize, number / 3);
        let phase_ns = if camera < 2 { 0 } else { 12_345_678 };
        let time_ns = START_NS + round * PERIOD_NS + phase_ns;
        let (base, values) = arm_scene::at(time_ns);
        arm_scene::image(&rig, camera, time_ns, ALL, &base, values, &mut random)
    };
    let images = (0..39).map(image).collect();
    Show {
        rig,
        object,
        images,
    }
}

/// An arm whose joints move, before rolling shutters and lenses that bend, by clocks with unknown
/// errors, one of which is off, and with unknown noise. The files are exact: errors of files are learned in order of
/// arrival.
fn with_everything(seed: u64) -> Show {
    let rig = with_cameras(&rig(3), |camera| {
        let intrinsics = camera.lens.intrinsics();
        camera.lens = Lens::brown_conrady(intrinsics, [-0.3, 0.1, 0.0, 0.0, 0.0]).unwrap();
        camera.line_delay_s = Some(2e-5);
    });
    let (rig, object) = (rig.exact(), arm());
    let mut random = Random(seed);
    let mut images = Vec::new();
    for number in 0..39u64 {
        let (camera, true_ns) = ((number % 3) as usize, START_NS + number * PERIOD_NS / 3);
        let off_ns = if camera == 1 { 15_000_000 } else { 0 };
        let ((base, values), time_ns) = (arm_scene::at(true_ns), true_ns + off_ns);
        let mut image = arm_scene::image(&rig, camera, time_ns, ALL, &base, values, &mut random);
        image.clock_error_ns = ImageObservation::CLOCK_ERROR_UNKNOWN;
        for tag in &mut image.tags {
            tag.corner_covariance = [Matrix2::zeros(); 4];
        }
        images.push(image);
    }
    Show {
        rig,
        object,
        images,
    }
}

/// The estimates at all capture times once everything has come.
fn estimates(show: &Show, order: &[usize]) -> Vec<Option<ObjectEstimate>> {
    let mut fusion = fusion(&show.rig, &show.object, FusionOptions::default());
    let times = || show.images.iter().map(|image| image.capture_ns);
    let now = times().max().unwrap();
    for index in order {
        fusion.handle(now, Input::Image(show.images[*index].clone()));
        poses(&mut fusion);
    }
    times()
        .map(|time_ns| fusion.pose_at(show.object.id(), time_ns))
        .collect()
}

fn gap(a: &ObjectEstimate, b: &ObjectEstimate) -> f64 {
    let pose = sextant_geometry::se3::difference(&a.world_from_object, &b.world_from_object).amax();
    let both = a.articulated.iter().zip(&b.articulated);
    let of_links = both.flat_map(|(a, b)| a.links.iter().zip(&b.links));
    let of_links = of_links.map(|(a, b)| (a.covariance - b.covariance).amax());
    pose.max((a.covariance - b.covariance).amax())
        .max((a.twist - b.twist).amax())
        .max(of_links.fold(0.0, f64::max))
}

fn assert_order_does_not_matter(show: &Show, shuffled: &[usize]) -> Result<(), TestCaseError> {
    let sorted: Vec<usize> = (0..show.images.len()).collect();
    let in_order = estimates(show, &sorted);
    prop_assert!(in_order.iter().flatten().count() > 20);
    for pair in in_order.into_iter().zip(estimates(show, shuffled)) {
        match pair {
            (Some(a), Some(b)) => prop_assert!(a.state == b.state && gap(&a, &b) < 1e-9),
            (a, b) => prop_assert_eq!(a, b),
        }
    }
    Ok(())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    #[test]
    fn late_reordered_and_duplicated_images_give_the_same_poses(
        seed in 0u64..1000,
        order in Just((0..39usize).collect::<Vec<_>>()).prop_shuffle(),
        again in prop::collection::vec(0usize..39, 0..20),
    ) {
        let shuffled: Vec<usize> = order.into_iter().chain(again).collect();
        assert_order_does_not_matter(&plain(seed), &shuffled)?;
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(3))]

    #[test]
    fn so_it_is_with_joints_and_with_everything_that_can_be_estimated(
        seed in 0u64..1000,
        order in Just((0..39usize).collect::<Vec<_>>()).prop_shuffle(),
        again in prop::collection::vec(0usize..39, 0..20),
    ) {
        let shuffled: Vec<usize> = order.into_iter().chain(again).collect();
        assert_order_does_not_matter(&plain_arm(seed), &shuffled)?;
        assert_order_does_not_matter(&with_everything(seed), &shuffled)?;
    }
}

#[test]
fn the_same_images_give_the_same_bits() {
    for show in [plain(7), with_everything(7)] {
        let order: Vec<usize> = (0..show.images.len()).rev().collect();
        assert_eq!(estimates(&show, &order), estimates(&show, &order));
    }
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
        fusion.pose_at(object.id(), now)
    };
    let pose = run(&images).unwrap();
    assert_eq!(Some(&pose), run(&swapped).as_ref());
    assert_eq!(pose.cameras, 4);
}
