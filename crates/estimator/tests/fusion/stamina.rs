//! A long run under adverse conditions: wrong corners, hidden tags, cameras that leave and join.

use std::ops::Range;

use nalgebra::Vector2;
use sextant_estimator::{Fusion, FusionOptions};
use sextant_site_model::ImageObservation;
use sextant_site_report::State;

use crate::scene::{
    Eye, PERIOD_NS, Random, START_NS, cube, feed, fusion, path_at, position_error, rig,
};

/// Seconds for which a camera is there or away.
const SHIFT_S: u64 = 7;

fn is_there(camera: usize, time_ns: u64) -> bool {
    let shift = (time_ns - START_NS) / (SHIFT_S * 1_000_000_000);
    !(shift + camera as u64).is_multiple_of(3)
}

/// Each tag is hidden now and then, each corner in twenty is anywhere.
fn spoilt(mut image: ImageObservation, random: &mut Random) -> ImageObservation {
    image.tags.retain(|_| random.uniform() > 0.2);
    for corner in image.tags.iter_mut().flat_map(|tag| &mut tag.corners) {
        if random.uniform() < 0.05 {
            *corner += Vector2::new(random.gauss(), random.gauss()) * 15.0;
        }
    }
    image
}

/// Takes the images of these numbers in; the share of poses said to be tracked that are off by more than a centimetre,
/// and the poses.
pub fn endure(fusion: &mut Fusion, numbers: Range<u64>) -> (f64, u64) {
    let (rig, object, mut random) = (rig(4), cube(), Random(numbers.start));
    let eye = Eye {
        rig: &rig,
        object: &object,
        sigma_px: 0.05,
    };
    let (mut wrong, mut poses) = (0, 0);
    for number in numbers {
        let (camera, time_ns) = ((number % 4) as usize, START_NS + number * PERIOD_NS / 4);
        if !is_there(camera, time_ns) {
            continue;
        }
        let image = eye.image(camera, time_ns, &path_at(time_ns), &mut random);
        for estimate in feed(fusion, spoilt(image, &mut random)) {
            let off = position_error(&estimate, &path_at(estimate.capture_ns));
            assert!(off.is_finite() && estimate.covariance.iter().all(|x| x.is_finite()));
            poses += 1;
            wrong += u64::from(estimate.state == State::Tracking && off > 0.01);
        }
    }
    (wrong as f64 / poses as f64, poses)
}

#[test]
fn fifty_thousand_spoilt_images_lead_nowhere_else() {
    let mut fusion = fusion(&rig(4), &cube(), FusionOptions::default());
    let images = 50_000;
    let (wrong, poses) = endure(&mut fusion, 0..images);
    assert!(poses > images / 2, "{poses}");
    assert!(wrong < 1e-3, "{wrong}");
}
