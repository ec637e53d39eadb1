//! Floods of images whose stamps or tags are made up: a window holds so many, and those of the other cameras go on.

use sextant_estimator::{FusionOptions, Input};
use sextant_site_model::ImageObservation;

use crate::scene::{
    Eye, PERIOD_NS, Random, START_NS, camera_id, cube, cube_id, feed, fusion, path_at,
    position_error, rig,
};

/// Images of one camera that a window of half a second holds.
const WINDOW: u64 = 250;

#[test]
fn stamps_that_lie_a_nanosecond_apart_don_t_fill_the_window() {
    let (rig, object) = (rig(2), cube());
    let mut fusion = fusion(&rig, &object, FusionOptions::default());
    let eye = Eye {
        rig: &rig,
        object: &object,
        sigma_px: 0.05,
    };
    let mut random = Random(1);
    for number in 0..10 {
        let time_ns = START_NS + number * PERIOD_NS;
        for camera in 0..2 {
            let image = eye.image(camera, time_ns, &path_at(time_ns), &mut random);
            feed(&mut fusion, image);
        }
    }
    let begun_ns = START_NS + 10 * PERIOD_NS;
    let flooding = eye.image(1, begun_ns, &path_at(begun_ns), &mut random);
    for step in 0..10 * WINDOW {
        let capture_ns = begun_ns + step;
        let image = ImageObservation {
            capture_ns,
            ..flooding.clone()
        };
        fusion.handle(begun_ns, Input::Image(image));
        while fusion.poll_output().is_some() {}
    }
    let counts = fusion.statistics().cameras[&camera_id(1)];
    assert_eq!((counts.images, counts.duplicates), (11, 10 * WINDOW - 1));
    let time_ns = begun_ns + PERIOD_NS;
    let truth = path_at(time_ns);
    let said = feed(&mut fusion, eye.image(0, time_ns, &truth, &mut random));
    let pose = said.iter().find(|pose| pose.object == cube_id());
    let error_m = position_error(pose.unwrap(), &truth);
    assert!(error_m < 0.005, "{error_m}");
}
